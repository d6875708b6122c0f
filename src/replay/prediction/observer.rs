//! The simulated machine on the track of a recording: driven by the recorded torque, and corrected by each recorded position.
//!
//! ```text
//!   e = r − clamp(r, −δ/2, δ/2)      r = q_rec − q_sim, δ: the encoder's step
//!   q += g e + ½ â T²     v += h e/T + â T     â += 2 k e/T²          on rotor and link of the joint alike
//!   z = e^{−ω T},  g = 1 − z³,  h = 3/2 (1 − z²)(1 − z),  k = 1/2 (1 − z)³
//! ```
//! These are the gains of a filter with fading memory, whose three poles lie at `−ω`: it leaves no error under a constant acceleration `â` that
//! the model lacks. Rotor and link are moved together, so that the flank that touches and the torque through the gear remain the model's.
//! A position within the count that was read needs no correction. Where the machine rests there as well, friction holds it, whatever torque
//! the model lacks: after a rest as long as the filter's memory `1/ω`, `â = 0`. Otherwise it would be pushed and stopped at every sample.
//! Reference: N. Morrison (1969), Introduction to sequential smoothing and prediction, chapter 13; E. Brookner (1998), Tracking and Kalman
//! filtering made easy, chapter 7.

use super::releases::Released;
use super::{Followed, Input};
use crate::effects::JointState;
use crate::error::Result;
use crate::plant::Plant;

/// What the machine on the track of a recording has shown.
pub(super) struct Observed {
    /// [N·m or N] Torques that drove the motors, `[sample · joints + joint]`.
    pub(super) torque: Vec<f64>,
    /// [rad or m] What effects on the readings added to the positions, in the same order.
    pub(super) misread: Vec<f64>,
    /// The machine at the samples from which each horizon is predicted.
    pub(super) released: Vec<Vec<Released>>,
}

impl Followed<'_> {
    /// Follows the first `samples` of the recording with an observer of these bandwidths [rad/s], one per joint.
    ///
    /// # Errors
    /// The model's effects do not fit, or the simulation diverges.
    pub(super) fn observe(&self, bandwidths: &[f64], samples: usize, horizons: &[f64]) -> Result<Observed> {
        let n = self.inputs.len();
        let torque_per_ampere: Vec<f64> = self.model.joints.iter().map(|joint| joint.torque_per_ampere()).collect();
        let at: Vec<Vec<usize>> = horizons.iter().map(|horizon| self.releases(*horizon, samples)).collect();
        let signal = || Vec::with_capacity(samples * n);
        let mut observed = Observed { torque: signal(), misread: signal(), released: vec![Vec::new(); at.len()] };
        let mut plant = self.plant()?;
        plant.launch(&self.start());
        let mut corrections: Vec<Correction> = (0..n).map(|i| self.correction(i, bandwidths[i])).collect();
        let mut commands = vec![0.0; n];
        for k in 0..samples {
            for (released, at) in observed.released.iter_mut().zip(&at) {
                if at.get(released.len()) == Some(&k) {
                    released.push(Released { sample: k, time: plant.time(), states: plant.states().to_vec() });
                }
            }
            let readings = plant.read().to_vec();
            for i in 0..n {
                let taken = self.inputs[i].taken(k, torque_per_ampere[i], &plant.states()[i], &readings[i]);
                commands[i] = taken.torque / torque_per_ampere[i];
                observed.torque.push(taken.torque);
                observed.misread.push(taken.misread);
            }
            if k + 1 < samples {
                let interval = self.time[k + 1] - self.time[k];
                plant.advance(&commands, interval)?;
                let misread = &observed.misread[k * n..];
                for (i, correction) in corrections.iter_mut().enumerate() {
                    correction.apply(&mut plant, i, self.inputs[i].position[k + 1] - misread[i], interval);
                }
            }
        }
        Ok(observed)
    }

    /// The motion at the first sample, with the links in the middle of their gaps.
    fn start(&self) -> Vec<JointState> {
        let moving = |input: &Input| {
            let position = input.position[0];
            JointState { motor_position: position, link_position: position, ..JointState::default() }
        };
        self.inputs.iter().map(moving).collect()
    }

    /// The correction of a joint; one that was not recorded is held where it is.
    pub(super) fn correction(&self, joint: usize, bandwidth: f64) -> Correction {
        let half_step = if self.inputs[joint].recorded { 0.5 * self.steps[joint] } else { 0.0 };
        Correction { bandwidth, half_step, acceleration: 0.0, rested: 0.0 }
    }
}

/// The correction of one joint.
pub(super) struct Correction {
    /// `ω` [rad/s].
    bandwidth: f64,
    /// `δ/2` [rad or m].
    half_step: f64,
    /// `â` [rad/s² or m/s²].
    acceleration: f64,
    /// [s] Time for which the machine has rested within its count.
    rested: f64,
}

impl Correction {
    /// Corrects a joint of the machine by a recorded position, an interval `T` [s] after the one before.
    pub(super) fn apply(&mut self, plant: &mut Plant, joint: usize, recorded: f64, interval: f64) {
        let JointState { motor_position, motor_velocity, link_velocity, .. } = plant.states()[joint];
        let r = recorded - motor_position;
        let e = r - r.clamp(-self.half_step, self.half_step);
        let rests = e == 0.0 && motor_velocity == 0.0 && link_velocity == 0.0;
        self.rested = if rests { self.rested + interval } else { 0.0 };
        if self.bandwidth * self.rested > 1.0 {
            self.acceleration = 0.0;
            return;
        }
        let z = (-self.bandwidth * interval).exp();
        self.acceleration += (1.0 - z).powi(3) * e / interval.powi(2);
        let a = self.acceleration;
        let way = (1.0 - z.powi(3)) * e + 0.5 * a * interval.powi(2);
        let velocity = 1.5 * (1.0 - z * z) * (1.0 - z) * e / interval + a * interval;
        if way != 0.0 || velocity != 0.0 {
            plant.shift(joint, way, velocity);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::plant::Options;
    use crate::robot::Model;

    /// What is corrected moves rotor and link together; a machine that rests within its count stays there, and forgets what it lacked in motion.
    #[test]
    fn property_a_machine_at_rest_within_its_count_is_left_alone() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/scara/model.toml");
        let model = Model::load(&file).expect("a robot of the catalogue");
        let mut plant = Plant::new(&model, &Options::default()).expect("a plant");
        plant.launch(&vec![JointState::default(); model.joints.len()]);
        let mut correction = Correction { bandwidth: 32.0, half_step: 1e-3, acceleration: 2.0, rested: 0.0 };
        correction.apply(&mut plant, 0, 0.9e-3, 1.0 / 16.0);
        let JointState { motor_position, motor_velocity, .. } = plant.states()[0];
        assert_eq!([motor_position, motor_velocity, correction.acceleration], [0.0; 3]);
        correction.apply(&mut plant, 0, 1.5e-3, 1e-3);
        let JointState { motor_position, link_position, motor_velocity, .. } = plant.states()[0];
        assert!(motor_position > 0.0 && motor_position == link_position && motor_velocity > 0.0);
        // Moving within the count: `â` acts on.
        let before = motor_velocity;
        correction.apply(&mut plant, 0, motor_position, 1e-3);
        assert!(correction.acceleration > 0.0 && plant.states()[0].motor_velocity > before);
    }
}
