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
//! Two estimators are reported, each with every single value:
//! - `paper`: equation 15 of L. Márton, B. Lantos (2009), literally and with the filter that noisy current needs;
//! - `best`: the likelihood of the recorded counts, given the measured current, pooled over all reversals.
//!
//! The gap is the total one at the joint, `b` (the paper's equation 3 has ±β, half of it, at the motor).

mod ensemble;
mod fit;
mod paper;
mod result;
mod reversal;
mod transmission;
mod truncated;
mod window;

use std::borrow::Cow;

pub use result::{BacklashIdentification, EstimatorResult, LeftOut, Reason, ReversalGap, ShownReversal};
pub use reversal::{Reversal, find_reversals};

use fit::Known;
use paper::Strokes;
pub(super) use reversal::{Session, braking};
pub(super) use window::torque_between;

use super::signals::Signals;
use crate::error::Result;
use crate::gearhead::Friction;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// The gap of one joint, by the paper's procedure and by the estimator whose result the program uses.
///
/// `friction` is the law just identified on the same data; its `link_share` need not be known, because the fit estimates it.
///
/// # Errors
/// The data lack position or current of the joint (a current without sign needs its command as well), hold fewer than three reversals
/// of it, or none that determines the gap.
pub fn identify(
    model: &Model,
    joint: usize,
    data: &[&TimeSeries],
    friction: &Friction,
) -> Result<BacklashIdentification> {
    identify_from(model, joint, data, friction, Known::default())
}

/// As [`identify`], for a gap that is known to be within some counts of `near` [rad or m], with the link share held. Errors of gap and
/// share can compensate each other, so two recordings of one machine are best compared at one share.
///
/// # Errors
/// As [`identify`].
pub fn identify_at_share(
    model: &Model,
    joint: usize,
    data: &[&TimeSeries],
    friction: &Friction,
    near: f64,
    share: f64,
) -> Result<BacklashIdentification> {
    identify_from(model, joint, data, friction, Known { gap: Some(near), share: Some(share) })
}

/// Equation 15 as published, on the last ten steps: on the raw current, and with the filter that noisy current needs. `None` where no
/// session has reversals. A current without sign is used as it is: the equation asks for its magnitude only.
pub(super) fn published(unit: &'static str, sessions: Vec<Signals>) -> Option<[EstimatorResult; 2]> {
    let strokes: Vec<Strokes> = sessions.into_iter().map(|signals| Strokes::last_steps(unit, signals)).collect();
    strokes.iter().any(Strokes::any).then(|| [paper::literal(&strokes), paper::filtered(&strokes)])
}

fn identify_from(
    model: &Model,
    joint: usize,
    data: &[&TimeSeries],
    friction: &Friction,
    known: Known,
) -> Result<BacklashIdentification> {
    let parts: Vec<Cow<TimeSeries>> = data.iter().flat_map(|series| series.uninterrupted()).collect();
    let mut sessions: Vec<Session> = parts.iter().filter_map(|series| Session::of(model, joint, series)).collect();
    reversal::keep_moved(&mut sessions);
    let name = &model.joints[joint].name;
    reversal::enough(&sessions, name)?;
    let fit =
        fit::fit(&sessions, &model.joints[joint], friction, known).ok_or_else(|| reversal::uninformative(name))?;
    let strokes: Vec<Strokes> = sessions.iter().map(Strokes::gentlest).collect();
    Ok(BacklashIdentification {
        joint: name.clone(),
        best: fit.gap,
        paper: paper::filtered(&strokes),
        paper_literal: paper::literal(&strokes),
        link_share: Some(fit.share),
        shown: paper::typical(&strokes),
    })
}
