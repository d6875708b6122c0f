//! The gap of a gear from motor-side position, velocity and current at the reversals of a motion.
//!
//! At a reversal the flanks part, the rotor crosses the gap alone, and contact on the other flank ends the traverse:
//!
//! ```text
//!   rotor θ  ──╮                       current |i|  ╮        ╭── rotor and link
//!   link q ────╫──── at rest                        ╰────────╯
//!              ╰──╲ b ╲────                            rotor alone
//!                 t1   t2                           t1       t2
//! ```
//!
//! Two estimators stand side by side, each with every single value:
//! - `paper`: equation 15 of L. Márton, B. Lantos (2009), literally and with the filter that noisy current needs;
//! - `best`: the likelihood of the counts seen, given the current that flowed, pooled over all reversals.
//!
//! The gap is the total one at the joint, `b` (the paper's equation 3 has ±β, half of it, at the motor).

mod paper;
mod result;
mod reversal;

pub use result::{BacklashIdentification, EstimatorResult, LeftOut, Reason, ReversalGap};
pub use reversal::{Reversal, find_reversals};

use reversal::Session;

use crate::error::Result;
use crate::gearhead::Friction;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// The gap of one joint, by the paper's procedure and by the estimator that the program stands behind.
///
/// `friction` is the law just identified on the same data; its `link_share` need not be known, the fit frees it.
///
/// # Errors
/// The data lack position, velocity or current of the joint, or hold fewer than three reversals of it.
pub fn identify(
    model: &Model,
    joint: usize,
    data: &[&TimeSeries],
    _friction: &Friction,
) -> Result<BacklashIdentification> {
    let sessions = data.iter().map(|series| Session::of(model, joint, series)).collect::<Result<Vec<_>>>()?;
    let name = &model.joints[joint].name;
    reversal::enough(&sessions, name)?;
    let paper = paper::filtered(&sessions);
    Ok(BacklashIdentification {
        joint: name.clone(),
        best: paper.clone(),
        paper,
        paper_literal: paper::literal(&sessions),
        link_share: None,
    })
}
