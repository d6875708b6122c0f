//! The simulated machine, hidden from the procedures that have to identify it.
//!
//! A procedure takes a [`Model`]; a truth is not one, and cannot be converted to one. It can be simulated
//! ([`simulate`](super::simulate)), changed ([`Truth::alter`]), and compared with the result of a procedure.

use std::fmt;

use crate::gearhead::FrictionLaw;
use crate::identify::Identification;
use crate::robot::Model;

/// The simulated machine with all its properties: friction, gaps, effects.
#[derive(Clone)]
pub struct Truth {
    machine: Model,
}

impl Truth {
    /// A machine to be simulated.
    pub const fn of(machine: Model) -> Self {
        Self { machine }
    }

    /// The machine as its model file describes it before any measurement: without effects, friction and gaps.
    pub fn nominal(&self) -> Model {
        let mut model = Model { effects: Vec::new(), ..self.machine.clone() };
        for joint in &mut model.joints {
            joint.friction = None;
            joint.backlash = None;
        }
        model
    }

    /// Changes the machine: friction, a gap, an effect, a load.
    pub fn alter(&mut self, change: impl FnOnce(&mut Model)) {
        change(&mut self.machine);
    }

    /// Writes the true values beside the identified ones.
    pub fn compare(&self, found: &mut Identification) {
        found.compare(&self.machine);
    }

    /// The friction law of a joint, for a plot beside the identified one.
    pub fn friction(&self, joint: &str) -> Option<FrictionLaw> {
        let joint = self.machine.joints.iter().find(|known| known.name == joint)?;
        joint.friction.map(|friction| friction.law)
    }

    /// [rad or m] Total gap of a joint, for comparison with the measured one.
    pub fn backlash(&self, joint: &str) -> Option<f64> {
        self.machine.joints.iter().find(|known| known.name == joint)?.backlash
    }

    /// The machine itself, for the simulation only.
    pub(super) const fn machine(&self) -> &Model {
        &self.machine
    }
}

impl fmt::Debug for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Truth of {}", self.machine.name)
    }
}
