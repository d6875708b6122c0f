//! The simulated machine let go: from a state on the track of the recording, driven by the recorded torque alone.

use rayon::prelude::*;

use super::observer::Observed;
use super::{BANDWIDTHS, Followed};
use crate::effects::JointState;
use crate::error::Result;
use crate::plant::Plant;

/// The state of the machine at a sample.
#[derive(Debug, Clone)]
pub(super) struct Released {
    /// The sample.
    pub(super) sample: usize,
    /// [s] since the start of the recording.
    pub(super) time: f64,
    /// One per joint.
    pub(super) states: Vec<JointState>,
}

/// Predicted positions [rad or m] at these samples, each from a release on, as the encoders see them: `[joint][release]`.
///
/// # Errors
/// The model's effects do not fit, or the simulation diverges.
pub(super) fn positions(
    followed: &Followed,
    observed: &Observed,
    released: &[Released],
    ends: &[usize],
) -> Result<Vec<Vec<f64>>> {
    /// Releases that one machine carries out after another: building one takes as long as simulating some of them.
    const TOGETHER: usize = 25;
    let n = followed.inputs.len();
    let chunks: Vec<_> = released.chunks(TOGETHER).zip(ends.chunks(TOGETHER)).collect();
    let run = |(released, ends): (&[Released], &[usize])| -> Result<Vec<Vec<f64>>> {
        let mut plant = followed.plant()?;
        released.iter().zip(ends).map(|(one, end)| let_go(followed, observed, &mut plant, one, *end)).collect()
    };
    let positions: Vec<Vec<f64>> =
        chunks.into_par_iter().map(run).collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    Ok((0..n).map(|joint| positions.iter().map(|position| position[joint]).collect()).collect())
}

/// Predicted position of each joint at a sample.
fn let_go(
    followed: &Followed,
    observed: &Observed,
    plant: &mut Plant,
    released: &Released,
    to: usize,
) -> Result<Vec<f64>> {
    let n = followed.inputs.len();
    let joints = &followed.model.joints;
    let mut held: Vec<_> = (0..n)
        .filter(|joint| !followed.inputs[*joint].recorded)
        .map(|joint| (joint, followed.correction(joint, BANDWIDTHS[BANDWIDTHS.len() - 1])))
        .collect();
    plant.launch_at(released.time, &released.states);
    let mut commands = vec![0.0; n];
    for k in released.sample..to {
        for ((command, torque), joint) in commands.iter_mut().zip(&observed.torque[k * n..]).zip(joints) {
            *command = torque / joint.torque_per_ampere();
        }
        let interval = followed.time[k + 1] - followed.time[k];
        plant.advance(&commands, interval)?;
        for (joint, correction) in &mut held {
            correction.apply(plant, *joint, followed.inputs[*joint].position[k + 1], interval);
        }
    }
    let misread = &observed.misread[to * n..];
    Ok((0..n).map(|joint| plant.states()[joint].motor_position + misread[joint]).collect())
}
