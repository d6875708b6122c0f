//! The last check for a mistake: more than half of the torque remains after every effect has been tried.
//!
//! A single effect, such as a tilted base, can be most of what a nominal model lacks; so this check runs at the end. Two conditions are needed. The
//! error of the finished diagnosis on held-out data is above half of the torque and well above the sensor's floor. And the torque balance, with
//! free masses, tilt, payload and spring, leaves more than a quarter of the squares.

use super::balance;
use super::balance::UNSOUND;
use super::rows;
use crate::diagnose::result::Mistake;
use crate::diagnose::result::{FitError, Split};
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// [%] of the RMS torque.
const HALF: f64 = 50.0;
/// Errors below this multiple of the floor are due to the sensors.
const FLOORS: f64 = 3.0;

/// The joints with more than half of the torque unexplained; empty where there are none.
pub fn found(model: &Model, sessions: &[&TimeSeries], errors: &[FitError]) -> Vec<Mistake> {
    let large = |name: &str| {
        errors.iter().find(|fit| {
            let torque =
                fit.joint == name && ["torque", "force"].contains(&fit.quantity) && fit.split == Split::HeldOut;
            torque && fit.after_percent > HALF && fit.after > FLOORS * fit.floor
        })
    };
    if model.joints.iter().all(|joint| large(&joint.name).is_none()) {
        return Vec::new();
    }
    let rows = rows::rows(model, sessions);
    let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
    let balances = balance::balances(model, &rows, &moves);
    let of_joint = |(joint, left): (&crate::robot::JointModel, &Option<balance::Balance>)| {
        let fit = large(&joint.name)?;
        let left = (*left)?.left;
        (left > UNSOUND).then(|| Mistake {
            mistake: "baseline_error",
            joints: vec![joint.name.clone()],
            factor: None,
            evidence: format!(
                "{}: {:.0} % of the torque on data held out is unexplained after every effect was tried, and {:.0} % of the torque if masses, tilt, payload and a spring are free.",
                joint.name,
                fit.after_percent,
                100.0 * left.sqrt()
            ),
            remedy: "compare the manifest's columns, units and signs with the recording, and gear ratio, torque constant, masses and axes of the model with the machine".to_owned(),
            alternatives: Vec::new(),
        })
    };
    model.joints.iter().zip(&balances).filter_map(of_joint).collect()
}
