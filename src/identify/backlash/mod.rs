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
mod search;
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
    identify_from(model, joint, data, friction, Known { gap: Some(near), share: Some(share), ..Known::default() })
}

/// As [`identify`], for a joint that is level in the nominal model, on a machine whose model `loaded` has a load that the nominal one lacks, such as
/// a tilt. `None` where the gap is not sure.
///
/// Reversals count also where the load may hold the link, which it does not if the link's share of friction is large enough. So that share has to be
/// found well, and the reversals in which the load is clearly smaller have to say the same. Under gravity of its own a joint gives no such gap: the
/// masses of a model are not as well known as a load that was found.
pub fn identify_loaded(
    loaded: &Model,
    nominal: &Model,
    joint: usize,
    data: &[&TimeSeries],
    friction: &Friction,
) -> Option<BacklashIdentification> {
    /// [1] Part of the link's friction up to which a load is clearly smaller: where gaps were wrong, fewer than three reversals lay below it, or these
    /// disagreed (tuning seeds 3021 to 3050).
    const CLEARLY: f64 = 0.8;
    let parts = uninterrupted(data);
    if !search::is_level(&sessions(nominal, joint, &parts), &nominal.joints[joint], friction) {
        return None;
    }
    let counting_on =
        |least_share: f64| identify_from(loaded, joint, data, friction, Known { least_share, ..Known::default() }).ok();
    let all = counting_on(1.0).filter(|all| all.is_seen() && all.share_is_known())?;
    let clear = counting_on(CLEARLY * all.link_share.as_ref()?.value)?;
    (clear.is_seen() && clear.agrees_with(&all)).then_some(all)
}

fn uninterrupted<'a>(data: &[&'a TimeSeries]) -> Vec<Cow<'a, TimeSeries>> {
    data.iter().flat_map(|series| series.uninterrupted()).collect()
}

fn sessions<'a>(model: &'a Model, joint: usize, parts: &'a [Cow<TimeSeries>]) -> Vec<Session<'a>> {
    let mut sessions: Vec<Session> = parts.iter().filter_map(|series| Session::of(model, joint, series)).collect();
    reversal::keep_moved(&mut sessions);
    sessions
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
    let parts = uninterrupted(data);
    let sessions = sessions(model, joint, &parts);
    let name = &model.joints[joint].name;
    reversal::enough(&sessions, name)?;
    let fit =
        search::fit(&sessions, &model.joints[joint], friction, known).ok_or_else(|| reversal::uninformative(name))?;
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
