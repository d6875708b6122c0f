//! Friction and gaps of a machine as its controller knows them, and what follows from them along a reference.

use crate::control::{Compensation, Feedforward, KnownGear, Target};
use crate::dynamics::Dynamics;
use crate::robot::{JointModel, Model};

/// The compensations of a machine's joints.
pub(super) struct KnownGears {
    /// One per joint; `None`: nothing is known of it.
    joints: Vec<Option<Compensation>>,
    /// What they add to the present command.
    now: Vec<Feedforward>,
    /// What they added to the last one.
    before: Vec<Feedforward>,
    /// Reference of all joints: positions, velocities, accelerations.
    reference: [Vec<f64>; 3],
    /// [N·m or N] Torques of the links along it.
    rigid: Vec<f64>,
}

impl KnownGears {
    /// Nothing is known of any of `n` joints.
    pub fn none(n: usize) -> Self {
        let zero = || vec![0.0; n];
        let nothing = vec![Feedforward::default(); n];
        Self {
            joints: Vec::new(),
            now: nothing.clone(),
            before: nothing,
            reference: [zero(), zero(), zero()],
            rigid: zero(),
        }
    }

    /// Friction and gaps of this model; gaps are crossed in a time [s] > 0. Joints without friction in the model are left alone.
    pub fn of(model: &Model, crossing_time: f64) -> Self {
        let gear = |joint: &JointModel| {
            let friction = joint.friction?;
            Some(Compensation::new(KnownGear {
                friction: Box::new(move |velocity| friction.law.kinetic(velocity)),
                link_share: friction.link_share,
                backlash: joint.backlash.unwrap_or(0.0),
                rotor_inertia: joint.reflected_inertia(),
                crossing_time,
            }))
        };
        Self { joints: model.joints.iter().map(gear).collect(), ..Self::none(model.joints.len()) }
    }

    /// Goes on to the next targets, `period` [s] after the last.
    pub fn advance(&mut self, targets: &[Target], dynamics: &mut Dynamics, period: f64) {
        if self.joints.is_empty() {
            return;
        }
        let [q, v, a] = &mut self.reference;
        for (i, target) in targets.iter().enumerate() {
            (q[i], v[i], a[i]) = (target.position, target.velocity, target.acceleration);
        }
        dynamics.inverse(q, v, a, &mut self.rigid);
        self.before.copy_from_slice(&self.now);
        for (i, joint) in self.joints.iter_mut().enumerate() {
            if let Some(joint) = joint {
                self.now[i] = joint.advance(&targets[i], self.rigid[i], period);
            }
        }
    }

    /// What a joint's compensation adds now.
    pub fn now(&self, joint: usize) -> Feedforward {
        self.now[joint]
    }

    /// What it added to the last command.
    pub fn before(&self, joint: usize) -> Feedforward {
        self.before[joint]
    }
}
