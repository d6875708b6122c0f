//! The machine that is simulated, out of the reach of whoever has to find out what it is.
//!
//! A procedure takes a [`Model`]; what holds the truth is none, and gives none away. It can be simulated ([`simulate`](super::simulate)),
//! changed ([`Truth::alter`]), and compared with what was found.

use std::fmt;

use crate::gearhead::FrictionLaw;
use crate::identify::Identification;
use crate::robot::Model;

/// The simulated machine, everything about it known: friction, gaps, effects.
#[derive(Clone)]
pub struct Truth {
    machine: Model,
}

impl Truth {
    /// A machine to be simulated.
    pub const fn of(machine: Model) -> Self {
        Self { machine }
    }

    /// The machine as its model file describes it before anything was measured: without effects, friction and gaps.
    pub fn nominal(&self) -> Model {
        let mut model = Model { effects: Vec::new(), ..self.machine.clone() };
        for joint in &mut model.joints {
            joint.friction = None;
            joint.backlash = None;
        }
        model
    }

    /// Puts something else into the machine: another friction, a gap, an effect, a load.
    pub fn alter(&mut self, change: impl FnOnce(&mut Model)) {
        change(&mut self.machine);
    }

    /// Writes the true values beside what was identified.
    pub fn compare(&self, found: &mut Identification) {
        found.compare(&self.machine);
    }

    /// The friction law of a joint, to be drawn beside the identified one.
    pub fn friction(&self, joint: &str) -> Option<FrictionLaw> {
        let joint = self.machine.joints.iter().find(|known| known.name == joint)?;
        joint.friction.map(|friction| friction.law)
    }

    /// [rad or m] Total gap of a joint, to be compared with the measured one.
    pub fn backlash(&self, joint: &str) -> Option<f64> {
        self.machine.joints.iter().find(|known| known.name == joint)?.backlash
    }

    /// The machine itself, for the simulation alone.
    pub(super) const fn machine(&self) -> &Model {
        &self.machine
    }
}

impl fmt::Debug for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Truth of {}", self.machine.name)
    }
}
