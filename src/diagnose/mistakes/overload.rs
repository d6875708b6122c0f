//! Torque against what the drive can give: the effort limit of the URDF and the current limit of the model file.
//!
//! A drive gives its limit at most, and a little more where the file quotes a continuous one; milliamperes read as amperes make it a thousand times as
//! much, a joint torque read as a current `ratio · K_t` times.

use super::rows::Rows;
use crate::robot::Model;

/// Times the limit at which the scale of a torque is in doubt: peak torque of a drive is up to three times the continuous one.
const DOUBTFUL: f64 = 3.0;
/// Times the limit that nothing but a wrong scale makes.
pub const IMPOSSIBLE: f64 = 10.0;
/// Part of the samples that may lie above: spikes are no torque.
const SPIKES: f64 = 0.01;

/// A joint whose torque is above what its drive can give.
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
    /// How many times the limit.
    pub fn times(&self) -> f64 {
        self.torque / self.limit
    }

    /// Whether a factor brings the torque to what the drive can give.
    pub fn explained_by(&self, factor: f64) -> bool {
        factor.abs() * self.times() < DOUBTFUL
    }
}

/// All such joints.
pub fn found(model: &Model, rows: &[Rows]) -> Vec<Overload> {
    let of_joint = |joint: usize| {
        let own = &model.joints[joint];
        let drive = own.torque_per_ampere() * own.amplifier.current_limit;
        let effort = model.robot.bodies[joint].joint.limits.effort;
        // The larger of those that are given: the smaller may be a continuous one.
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
