//! Torque against the limits of the drive: the effort limit of the URDF and the current limit of the model file.
//!
//! A drive gives its limit at most, or somewhat more if the file quotes a continuous one. Milliamperes read as amperes give a thousand times
//! as much, and a joint torque read as a current gives `ratio · K_t` times as much.

use super::rows::Rows;
use crate::robot::Model;

/// Multiple of the limit above which the scale of a torque is in doubt: the peak torque of a drive is up to three times the continuous one.
const DOUBTFUL: f64 = 3.0;
/// Multiple of the limit that only a wrong scale reaches.
pub const IMPOSSIBLE: f64 = 10.0;
/// Part of the samples that may lie above: spikes do not count as torque.
const SPIKES: f64 = 0.01;

/// A joint whose torque is above the limit of its drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overload {
    /// The joint's index in the model.
    pub joint: usize,
    /// [N·m or N] torque that 1 % of the rows exceed.
    pub torque: f64,
    /// [N·m or N] limit.
    pub limit: f64,
}

impl Overload {
    /// Torque relative to the limit.
    pub fn times(&self) -> f64 {
        self.torque / self.limit
    }

    /// Whether a factor brings the torque back within the limits of the drive.
    pub fn explained_by(&self, factor: f64) -> bool {
        factor.abs() * self.times() < DOUBTFUL
    }
}

/// All such joints.
pub fn found(model: &Model, rows: &[Rows]) -> Vec<Overload> {
    let of_joint = |joint: usize| {
        let own = &model.joints[joint];
        let drive = own.motor.map_or(f64::INFINITY, |_| own.torque_per_ampere() * own.amplifier.current_limit);
        let effort = model.robot.bodies[joint].joint.limits.effort;
        // The larger of the given limits: the smaller one may be a continuous limit.
        let given = [drive, effort].into_iter().filter(|limit| limit.is_finite() && *limit > 0.0);
        let limit = given.fold(0.0, f64::max);
        let mut torques: Vec<f64> =
            rows.iter().flat_map(|session| session.joints[joint].tau.iter().map(|tau| tau.abs())).collect();
        torques.sort_by(f64::total_cmp);
        let torque = *torques.get(((1.0 - SPIKES) * torques.len() as f64) as usize)?;
        (limit > 0.0 && torque > DOUBTFUL * limit).then_some(Overload { joint, torque, limit })
    };
    (0..model.joints.len()).filter_map(of_joint).collect()
}
