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
mod share;
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

use super::quantity::Quantity;
use super::signals::Signals;
use crate::error::{Error, Result};
use crate::gearhead::Friction;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// The gap of one joint, by the paper's procedure and by the estimator whose result the program uses.
///
/// `friction` is the law just identified on the same data; its `link_share` need not be known, because the fit estimates it.
///
/// # Errors
/// The data lack position or current of the joint (a current without sign needs its command as well), hold fewer than three reversals
/// of it, or do not determine the gap.
pub fn identify(
    model: &Model,
    joint: usize,
    data: &[&TimeSeries],
    friction: &Friction,
) -> Result<BacklashIdentification> {
    found(model, joint, data, friction, Known::default())?.beside_wind_up()
}

/// As [`identify`], for a comparison of recordings of one machine: what its stiffness is off by is the same in all, and no part of the errors. `known` are
/// the gap, within some counts [rad or m], and the link share, which is held: errors of gap and share can compensate each other.
///
/// # Errors
/// As [`identify`].
pub fn identify_to_compare(
    model: &Model,
    joint: usize,
    data: &[&TimeSeries],
    friction: &Friction,
    known: Option<(f64, f64)>,
) -> Result<BacklashIdentification> {
    let (gap, share) = known.unzip();
    Ok(found(model, joint, data, friction, Known { gap, share, ..Known::default() })?.result)
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
        |least_share: f64| found(loaded, joint, data, friction, Known { least_share, ..Known::default() }).ok();
    let all = counting_on(1.0).filter(|all| all.result.is_seen() && all.result.share_is_known())?;
    let clear = counting_on(CLEARLY * all.result.link_share.as_ref()?.value)?.result;
    if clear.is_seen() && clear.agrees_with(&all.result) { all.beside_wind_up().ok() } else { None }
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

/// Why reversals do not tell a gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Untold {
    /// None determines it, or they disagree.
    ByReversals,
    /// Counts or noise hide it.
    ByResolution,
}

impl Untold {
    const fn reason(self) -> &'static str {
        match self {
            Self::ByReversals => {
                "too few reversals agree on one: reverse where gravity on the joint is nearly zero, and brake more gently than the link's own friction \
                 would"
            }
            Self::ByResolution => {
                "none is seen, and a small one may hide in the noise of the torque or in what the model leaves out: measure the current with less noise, or \
                 brake more gently, so that the motor takes longer to cross it"
            }
        }
    }
}

/// The error of a gap that is not told.
fn undetermined(joint: &str, reason: impl Into<String>) -> Error {
    Error::Undetermined { quantity: "backlash", joint: joint.to_owned(), reason: reason.into() }
}

/// The gap of one joint if its gear is as stiff as the model says.
struct Found {
    result: BacklashIdentification,
    /// [rad or m] standard error for the case that it is not.
    wind_up_error: f64,
}

impl Found {
    /// With the error of the wind-up; fails where a gap that was seen may be that alone.
    fn beside_wind_up(self) -> Result<BacklashIdentification> {
        let Self { mut result, wind_up_error } = self;
        let seen = result.is_seen();
        result.best = result.best.with_shared(wind_up_error);
        if !seen || result.is_seen() {
            return Ok(result);
        }
        let Quantity { value, unit, .. } = &result.best.mean;
        let reason = format!(
            "at a reversal the motor crosses {value:.2e} {unit}, of which {wind_up_error:.0e} {unit} or more may be wind-up of the gear: state its \
             gear_stiffness, and in [accuracy] how well it is known"
        );
        Err(undetermined(&result.joint, reason))
    }
}

fn found(model: &Model, joint: usize, data: &[&TimeSeries], friction: &Friction, known: Known) -> Result<Found> {
    let parts = uninterrupted(data);
    let sessions = sessions(model, joint, &parts);
    let name = &model.joints[joint].name;
    reversal::enough(&sessions, name)?;
    let (fit, wind_up_error) =
        search::fit(&sessions, model, friction, known).map_err(|untold| undetermined(name, untold.reason()))?;
    let strokes: Vec<Strokes> = sessions.iter().map(Strokes::gentlest).collect();
    let result = BacklashIdentification {
        joint: name.clone(),
        best: fit.gap,
        paper: paper::filtered(&strokes),
        paper_literal: paper::literal(&strokes),
        link_share: Some(fit.share),
        shown: paper::typical(&strokes),
    };
    Ok(Found { result, wind_up_error })
}
