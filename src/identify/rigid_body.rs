//! Rigid-body terms of a window: gravity `G_i(q)` and inertia `H_ii(q)` of equation 11 at the posture of the links.
//!
//! ```text
//!   q = θ − G/k − s b/2,  s = sgn G           motor θ, gear of stiffness k and gap b, where the model gives them
//! ```
//! Gravity winds up the gear and holds the link on one flank, so the link hangs behind its motor. Left out: a gap that the model does not
//! give. A staircase about a level arm does not show it: as a free coefficient it takes its prior value and widens all intervals.

use std::ops::Range;

use nalgebra::DMatrix;

use super::windows::Window;
use crate::dynamics::Dynamics;
use crate::robot::{JointModel, Model};
use crate::timeseries::{Channel, Clock, TimeSeries};

/// Number of postures at which a window is sampled.
const SAMPLES: usize = 8;

/// [s] Between two evaluations along a motion.
const STRIDE: f64 = 0.02;
/// [s] To either side, over which velocities and accelerations are taken from positions.
const DIFFERENCE: f64 = 0.06;

/// Range of a motor [rad], as a part of that of the motor that turns farthest, below which its joint is held: it only gives way to the others
/// within its gap, and its link does not move as its motor. Motors are compared, because joints turn or slide. The same part of the range as
/// the shortest stroke that counts as a reversal.
const HELD: f64 = 0.05;

/// The model along one session, seen from one joint.
pub struct RigidBody<'a> {
    dynamics: Dynamics,
    joint: usize,
    /// Reflected rotor inertia of the joint [kg·m² or kg].
    rotor: f64,
    /// Positions of all joints; a joint that was not recorded stands at zero.
    positions: Vec<Option<&'a [f64]>>,
    /// Which of the other joints are held.
    held: Vec<bool>,
    /// Samples between two evaluations along a motion.
    stride: usize,
    /// The joints of the model.
    joints: &'a [JointModel],
    /// Sample times.
    clock: Clock<'a>,
}

impl<'a> RigidBody<'a> {
    /// The model along a session.
    pub fn new(model: &'a Model, joint: usize, series: &'a TimeSeries) -> Self {
        let positions: Vec<Option<&[f64]>> = model
            .joints
            .iter()
            .map(|joint| series.joint(&joint.name).and_then(|recorded| recorded.get(Channel::Position)))
            .collect();
        let turned = |(position, joint): (&Option<&[f64]>, &JointModel)| position.map_or(0.0, range) * joint.gear_ratio;
        let ranges: Vec<f64> = positions.iter().zip(&model.joints).map(turned).collect();
        let farthest = ranges.iter().copied().fold(0.0, f64::max);
        let clock = Clock::new(&series.time);
        Self {
            dynamics: Dynamics::new(&model.robot),
            held: (0..ranges.len()).map(|k| k != joint && ranges[k] < HELD * farthest).collect(),
            joint,
            rotor: model.joints[joint].reflected_inertia(),
            positions,
            stride: (STRIDE / clock.interval).max(1.0) as usize,
            joints: &model.joints,
            clock,
        }
    }

    /// The joint that is seen from.
    pub const fn joint_model(&self) -> &JointModel {
        &self.joints[self.joint]
    }

    /// Motor positions on the joint side at a sample [rad or m].
    pub fn posture(&self, sample: usize) -> Vec<f64> {
        self.positions.iter().map(|position| position.map_or(0.0, |x| x[sample])).collect()
    }

    /// `⟨G_i⟩` [N·m or N] over a window.
    pub fn gravity(&self, window: Window) -> f64 {
        let mut gravity = self.gravity_of();
        self.average(window, |q| gravity(q))
    }

    /// `⟨H_ii⟩` [kg·m² or kg] over a window, the reflected rotor inertia included.
    pub fn inertia(&self, window: Window) -> f64 {
        let mut inertia = self.link_inertia_of();
        self.average(window, |q| inertia(q)) + self.rotor
    }

    /// `G_i` [N·m or N] at every sample.
    pub fn gravity_along(&self, samples: Range<usize>) -> Vec<f64> {
        let (mut gravity, mut links) = (self.gravity_of(), self.links());
        self.interpolated(samples, |sample| gravity(&links(sample)))
    }

    /// `K_i` [N·m or N] at every sample: what the velocities of all joints, and the accelerations of the others, ask of the joint's motor.
    pub fn coupling_along(&self, samples: Range<usize>) -> Vec<f64> {
        let (clock, last) = (&self.clock, self.clock.time().len() - 1);
        let (mut dynamics, mut moving) = (self.dynamics.clone(), vec![0.0; self.joints.len()]);
        let mut still = moving.clone();
        self.interpolated(samples, |sample| {
            let (before, after) = (clock.before(sample, DIFFERENCE), clock.after(sample, DIFFERENCE).min(last));
            if before == sample || after == sample {
                return 0.0;
            }
            let [t, u] = [clock.elapsed(before, sample), clock.elapsed(sample, after)];
            let slopes = |position: &Option<&[f64]>| {
                position.map_or([0.0; 2], |x| [(x[sample] - x[before]) / t, (x[after] - x[sample]) / u])
            };
            let moved = |(position, held): (_, &bool)| if *held { [0.0; 2] } else { slopes(position) };
            let slopes: Vec<[f64; 2]> = self.positions.iter().zip(&self.held).map(moved).collect();
            let v: Vec<f64> = slopes.iter().map(|[a, b]| (a * t + b * u) / (t + u)).collect();
            let mut a: Vec<f64> = slopes.iter().map(|[a, b]| 2.0 * (b - a) / (t + u)).collect();
            a[self.joint] = 0.0;
            let q = self.posture(sample);
            dynamics.inverse(&q, &v, &a, &mut moving);
            dynamics.gravity(&q, &mut still);
            moving[self.joint] - still[self.joint]
        })
    }

    /// A function of the sample, computed at some samples and interpolated linearly: a held value would lag behind the motion.
    fn interpolated(&self, samples: Range<usize>, mut value: impl FnMut(usize) -> f64) -> Vec<f64> {
        let Range { start, end } = samples;
        let stride = self.stride;
        let knots: Vec<f64> =
            (start..end + stride).step_by(stride).map(|k| value(k.min(end.saturating_sub(1)))).collect();
        (0..end - start)
            .map(|k| {
                let (knot, part) = (k / stride, (k % stride) as f64 / stride as f64);
                knots[knot] + part * (knots[(knot + 1).min(knots.len() - 1)] - knots[knot])
            })
            .collect()
    }

    /// Mean of a function of the posture over a window.
    fn average(&self, window: Window, mut value: impl FnMut(&[f64]) -> f64) -> f64 {
        let samples = SAMPLES.min(window.end - window.start).max(1);
        let at = |k: usize| window.start + (2 * k + 1) * (window.end - window.start) / (2 * samples);
        let mut links = self.links();
        (0..samples).map(|k| value(&links(at(k)))).sum::<f64>() / samples as f64
    }

    /// Positions of the links at a sample [rad or m].
    fn links(&self) -> impl FnMut(usize) -> Vec<f64> + '_ {
        let known = self.joints.iter().any(|joint| joint.gear_stiffness.is_some() || joint.backlash.is_some());
        let (mut dynamics, mut torque) = (self.dynamics.clone(), vec![0.0; self.joints.len()]);
        move |sample| {
            let mut q = self.posture(sample);
            if known {
                dynamics.gravity(&q, &mut torque);
                for ((q, torque), joint) in q.iter_mut().zip(&torque).zip(self.joints) {
                    let pressed = if *torque == 0.0 { 0.0 } else { torque.signum() };
                    let wind_up = joint.gear_stiffness.map_or(0.0, |k| torque / k);
                    *q -= wind_up + 0.5 * joint.backlash.unwrap_or(0.0) * pressed;
                }
            }
            q
        }
    }

    /// `G_i(q)` [N·m or N].
    pub fn gravity_of(&self) -> impl FnMut(&[f64]) -> f64 {
        let (mut dynamics, joint) = (self.dynamics.clone(), self.joint);
        let mut tau = vec![0.0; dynamics.dof()];
        move |q| {
            dynamics.gravity(q, &mut tau);
            tau[joint]
        }
    }

    /// `H_ii(q)` of the links [kg·m² or kg].
    pub fn link_inertia_of(&self) -> impl FnMut(&[f64]) -> f64 {
        let (mut dynamics, joint) = (self.dynamics.clone(), self.joint);
        let mut h = DMatrix::zeros(dynamics.dof(), dynamics.dof());
        move |q| {
            dynamics.mass_matrix(q, &mut h);
            h[(joint, joint)]
        }
    }
}

/// [rad or m] From the lowest to the highest position.
pub(super) fn range(position: &[f64]) -> f64 {
    let (low, high) = position.iter().fold((f64::MAX, f64::MIN), |(low, high), &x| (low.min(x), high.max(x)));
    high - low
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::timeseries::JointSeries;

    /// Two bars with vertical axes: `l` = 0.5 m between the joints, then `m` = 2 kg at `c` = 0.3 m, with `I` = 0.01 kg·m² about its centre.
    const ROBOT: &str = "<robot name=\"two\"><link name=\"base\"/><link name=\"upper\"><inertial><mass value=\"1\"/>\
        <inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><link name=\"lower\"><inertial>\
        <origin xyz=\"0.3 0 0\"/><mass value=\"2\"/><inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\
        <joint name=\"j1\" type=\"continuous\"><parent link=\"base\"/><child link=\"upper\"/><axis xyz=\"0 0 1\"/></joint>\
        <joint name=\"j2\" type=\"continuous\"><parent link=\"upper\"/><child link=\"lower\"/><origin xyz=\"0.5 0 0\"/><axis xyz=\"0 0 1\"/></joint>\
        </robot>";
    const MODEL: &str = "schema = \"lostmotion/model/1\"\nname = \"two\"\nurdf = \"two.urdf\"\n[joints.j1]\ngear_ratio = 5.0\n\
        rotor_inertia = 0.0008\n[joints.j2]\ngear_ratio = 5.0\nrotor_inertia = 0.0008\n";

    /// While joint 1 is at rest and joint 2 swings, `K₁ = (I + m c² + m l c cos q₂) q̈₂ − m l c sin q₂ q̇₂²`.
    #[test]
    fn closed_form_coupling_of_two_bars() {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
        let (amplitude, omega) = (0.8, 3.0);
        let time: Vec<f64> = (0..2000).map(|k| f64::from(k) * 1e-3).collect();
        let swing: Vec<f64> = time.iter().map(|t| amplitude * (omega * t).sin()).collect();
        let series = TimeSeries {
            name: "swing".to_owned(),
            time: time.clone(),
            joints: [("j1", vec![0.2; time.len()]), ("j2", swing)]
                .map(|(name, position)| JointSeries {
                    name: name.to_owned(),
                    channels: [(Channel::Position, position.into())].into(),
                })
                .into(),
        };
        let found = RigidBody::new(&model, 0, &series).coupling_along(200..1800);
        for (coupling, t) in found.iter().zip(&time[200..]) {
            let q = amplitude * (omega * t).sin();
            let (v, a) = (amplitude * omega * (omega * t).cos(), -omega * omega * q);
            let exact = (0.01 + 2.0 * 0.09 + 0.3 * q.cos()) * a - 0.3 * q.sin() * v * v;
            // Differences over h = 60 ms are off by (ω h)²/12 = 0.3 % of the acceleration and (ω h)²/6 = 0.5 % of the velocity, of 3.5 N·m at most;
            // straight lines over 20 ms by (2 ω)² (20 ms)²/8 = 0.2 %.
            assert!((coupling - exact).abs() < 0.035, "{coupling} for {exact} at {t}");
        }
    }

    /// A joint that gives way by a fiftieth of what another moves is held: it asks nothing of that one, whatever its motor does.
    #[test]
    fn property_a_joint_that_is_held_adds_no_coupling() {
        let time: Vec<f64> = (0..2000).map(|k| f64::from(k) * 1e-3).collect();
        let swing =
            |amplitude: f64, omega: f64| time.iter().map(|t| amplitude * (omega * t).sin()).collect::<Vec<f64>>();
        let series = TimeSeries {
            name: "held".to_owned(),
            time: time.clone(),
            joints: [("j1", swing(0.5, 3.0)), ("j2", swing(0.01, 30.0))]
                .map(|(name, position)| JointSeries {
                    name: name.to_owned(),
                    channels: [(Channel::Position, position.into())].into(),
                })
                .into(),
        };
        let coupling = |model: &str, joint: usize| {
            let model = Model::from_texts(model, ROBOT, Path::new("model.toml")).expect("a good model");
            RigidBody::new(&model, joint, &series).coupling_along(200..1800)
        };
        assert!(coupling(MODEL, 0).iter().all(|coupling| coupling.abs() < 1e-12), "none on the joint that moves");
        // The moving joint's 4.5 rad/s² times `I + m c² + m l c` = 0.49 kg·m² are 2.2 N·m.
        assert!(coupling(MODEL, 1).iter().any(|coupling| coupling.abs() > 1.5), "but some on the held one");
        // With a gear of 200 the small motion is 4 rad of the motor, as much as the large one: 9 rad/s² times 0.49 kg·m².
        let geared = MODEL.replace("[joints.j2]\ngear_ratio = 5.0", "[joints.j2]\ngear_ratio = 200.0");
        assert!(coupling(&geared, 0).iter().any(|coupling| coupling.abs() > 2.0), "a motor that turns far is not held");
    }
}
