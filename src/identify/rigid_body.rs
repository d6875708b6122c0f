//! What the rigid-body model says about a window: gravity `G_i(q)` and inertia `H_ii(q)` of equation 11 at the measured posture.

use std::ops::Range;

use nalgebra::Isometry3;

use super::windows::Window;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};
use crate::units::JointKind;

/// Postures that a window is sampled at.
const SAMPLES: usize = 40;

/// Samples between two evaluations of gravity along a motion.
const STRIDE: usize = 5;

/// The model along one session, seen from one joint.
pub struct RigidBody<'a> {
    model: &'a Model,
    joint: usize,
    /// Positions of all joints; a joint that was not recorded stands at zero.
    positions: Vec<Option<&'a [f64]>>,
}

impl<'a> RigidBody<'a> {
    /// The model along a session.
    pub fn new(model: &'a Model, joint: usize, series: &'a TimeSeries) -> Self {
        let positions = model
            .joints
            .iter()
            .map(|joint| series.joint(&joint.name).and_then(|recorded| recorded.get(Channel::Position)))
            .collect();
        Self { model, joint, positions }
    }

    /// Joint positions at a sample [rad or m].
    pub fn posture(&self, sample: usize) -> Vec<f64> {
        self.positions.iter().map(|position| position.map_or(0.0, |x| x[sample])).collect()
    }

    /// `⟨G_i⟩` [N·m or N] over a window.
    pub fn gravity(&self, window: Window) -> f64 {
        self.average(window, |q| self.gravity_at(q))
    }

    /// `⟨H_ii⟩` [kg·m² or kg] over a window, the reflected rotor inertia included.
    pub fn inertia(&self, window: Window) -> f64 {
        self.link_inertia(window) + self.model.joints[self.joint].reflected_inertia()
    }

    /// `⟨H_ii⟩` [kg·m² or kg] of the links alone.
    pub fn link_inertia(&self, window: Window) -> f64 {
        self.average(window, |q| self.link_inertia_at(q))
    }

    /// `G_i` [N·m or N] at every sample, computed at every [`STRIDE`]th and straight between: held, it would lag behind the motion.
    pub fn gravity_along(&self, samples: Range<usize>) -> Vec<f64> {
        let Range { start, end } = samples;
        let knots: Vec<f64> = (start..end + STRIDE)
            .step_by(STRIDE)
            .map(|k| self.gravity_at(&self.posture(k.min(end.saturating_sub(1)))))
            .collect();
        (0..end - start)
            .map(|k| {
                let (knot, part) = (k / STRIDE, (k % STRIDE) as f64 / STRIDE as f64);
                knots[knot] + part * (knots[(knot + 1).min(knots.len() - 1)] - knots[knot])
            })
            .collect()
    }

    /// Mean of a function of the posture over a window.
    fn average(&self, window: Window, value: impl Fn(&[f64]) -> f64) -> f64 {
        let samples = SAMPLES.min(window.end - window.start).max(1);
        let at = |k: usize| window.start + (2 * k + 1) * (window.end - window.start) / (2 * samples);
        (0..samples).map(|k| value(&self.posture(at(k)))).sum::<f64>() / samples as f64
    }

    /// `G_i(q)` [N·m or N].
    pub fn gravity_at(&self, q: &[f64]) -> f64 {
        let robot = &self.model.robot;
        self.subtree(q).map(|(mass, arm, _)| -mass * robot.gravity.dot(&arm)).sum()
    }

    /// `H_ii(q)` of the links [kg·m² or kg].
    pub fn link_inertia_at(&self, q: &[f64]) -> f64 {
        self.subtree(q).map(|(mass, arm, spin)| mass * arm.norm_squared() + spin).sum()
    }

    /// For every body that the joint moves: mass, velocity of its centre of mass per joint velocity, spin inertia about the axis.
    fn subtree(&self, q: &[f64]) -> impl Iterator<Item = (f64, nalgebra::Vector3<f64>, f64)> {
        let robot = &self.model.robot;
        let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(robot.dof());
        let mut moved = vec![false; robot.dof()];
        for (k, body) in robot.bodies.iter().enumerate() {
            let parent = body.parent.map_or_else(Isometry3::identity, |p| poses[p]);
            let axis = body.joint.axis.into_inner();
            let motion = match body.joint.kind {
                JointKind::Revolute => Isometry3::rotation(axis * q[k]),
                JointKind::Prismatic => Isometry3::translation(axis.x * q[k], axis.y * q[k], axis.z * q[k]),
            };
            poses.push(parent * body.joint.origin * motion);
            moved[k] = k == self.joint || body.parent.is_some_and(|p| moved[p]);
        }
        let own = &robot.bodies[self.joint].joint;
        let axis = poses[self.joint] * own.axis.into_inner();
        let origin = poses[self.joint].translation.vector;
        let mut found = Vec::new();
        for (k, body) in robot.bodies.iter().enumerate().filter(|(k, _)| moved[*k]) {
            let com = (poses[k] * nalgebra::Point3::from(body.inertia.com)).coords;
            found.push(match own.kind {
                JointKind::Revolute => {
                    let local = poses[k].rotation.inverse() * axis;
                    (body.inertia.mass, axis.cross(&(com - origin)), local.dot(&(body.inertia.tensor * local)))
                }
                JointKind::Prismatic => (body.inertia.mass, axis, 0.0),
            });
        }
        found.into_iter()
    }
}
