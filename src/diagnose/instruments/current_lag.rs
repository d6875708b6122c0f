//! Whether the current is recorded late relative to the motion, measured from transients.
//!
//! Above some 3 Hz a joint is a mass, whichever flank is in contact: acceleration follows torque at once. The sum
//! `Σ a(t) τ(t + L)`, both filtered by a kernel of 12 ms minus one of 60 ms, therefore peaks at the lag
//! `L` = 0, and at `T` if the current is late by `T`.
//! A late position does not show: the controller responds to the position that it reads, and its response is in step with it.
//! A late velocity does: where teeth strike and the loop shakes, `a` is the cause and `τ` the controller's answer, as late as what it reads. The lags
//! of a joint whose velocity channel may be their cause are left out.
//! Where samples lie at uneven times, both kernels are those of a [local polynomial](crate::diagnose::rows::local) in true time, taken at even
//! times: its weights have no first moment, so that it delays nothing. Left out: windows across pauses.
//! A delay is named if undoing it lowers the torque error of held-out data, or else the error of their transients.
//! Reference: C. H. Knapp, G. C. Carter (1976), The generalized correlation method for estimation of time delay.

mod transients;

use super::as_recorded::{AsRecorded, nominal};
use super::claims::{Sighting, claimed};
use super::velocity_lag::late_velocity;
use super::{Instrument, Measurement, Recordings};
use crate::diagnose::evidence::probability::{calibrated, odds_against};
use crate::diagnose::fit::pose::{nothing_moves, pose};
use crate::diagnose::options::Options;
use crate::diagnose::residuals::gains;
use crate::diagnose::result::{EffectGain, Findings};
use crate::diagnose::rows::division::Division;
use crate::effects::Phenomenon;
use crate::error::Result;
use crate::identify::statistics::{median, typical};
use crate::robot::Model;
use crate::timeseries::{Channel, Estimate, TimeSeries, delayed, side_by_side};
pub use transients::COARSEST;
use transients::{Transients, compared};

/// [s] Lags of recordings without a delay: 0.3 ± 0.4 ms per joint and session (24 simulated machines, 9 foreign recordings: −0.3 to 1.2 ms);
/// the median of several is within ±0.6 ms. A larger lag than this constant is a delay.
const NOTICEABLE: f64 = 1.5e-3;
/// [s] Possible shift of the median by friction and the gap.
const SYSTEMATIC: f64 = 3e-4;

/// Standard errors by which a delay has to exceed [`NOTICEABLE`]: if joints and sessions disagree about the lag, there is no delay.
const SURELY: f64 = 4.0;

/// [1] Lag of a controller's answer in lags of the velocity that it reads. It was 0.4 of a low-pass and 0.9 to 1.0 of a delay (drawn seeds 99000
/// to 99104); the rest is for a controller that itself takes as long. Not calibrated.
const ANSWER: f64 = 2.0;

/// Delay of the current.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Late {
    /// [s]
    pub lag: Estimate,
    /// Probability that it is larger than in recordings without a delay.
    pub probability: f64,
}

/// Delay of the current relative to the motion in the training data, where it is noticeable.
pub fn late_current(model: &Model, sessions: &[&TimeSeries], division: Division) -> Option<Late> {
    let joints = 0..model.joints.len();
    let places: Vec<(usize, usize)> =
        joints.flat_map(|joint| (0..sessions.len()).map(move |session| (joint, session))).collect();
    let of_place = |(joint, session): &(usize, usize)| -> Vec<f64> {
        let parts = division.training(*session, sessions[*session]);
        let runs = Transients::of(model, *joint, sessions[*session], &parts);
        runs.iter().filter_map(Transients::lag).collect()
    };
    // Memory for the torque, and for time and both signals after the filter.
    let longest = sessions.iter().map(|session| session.len()).max().unwrap_or(0);
    let of_places = side_by_side(&places, 32 * longest, of_place);
    let of_joints = of_places.chunks(sessions.len().max(1)).map(|lags| lags.concat());
    let may_be_answers = |(joint, lags): &(usize, Vec<f64>)| {
        let lag = median(lags.clone());
        let late = || late_velocity(model, *joint, sessions, division);
        lag > NOTICEABLE && late().is_some_and(|late| lag < ANSWER * late)
    };
    let lags: Vec<f64> =
        of_joints.enumerate().filter(|of_joint| !may_be_answers(of_joint)).flat_map(|(_, lags)| lags).collect();
    if lags.len() < 2 {
        return None;
    }
    let value = median(lags.clone());
    // The median of normal values scatters 1.25 times as much as their mean.
    let scatter = 1.25 * typical(lags.iter().map(|lag| lag - value)) / (lags.len() as f64).sqrt();
    let std_error = scatter.hypot(SYSTEMATIC);
    let beyond = (value - NOTICEABLE) / std_error;
    let probability = calibrated(odds_against(value, NOTICEABLE, std_error));
    (beyond > SURELY).then_some(Late { lag: Estimate { value, std_error }, probability })
}

/// The instrument for a late current.
pub struct CurrentLag;

impl Instrument<Recordings<'_>> for CurrentLag {
    fn measure(&self, scene: &Recordings) -> Result<Measurement> {
        let Recordings { model, sessions, division, options } = *scene;
        let Some(aligned) = align(model, sessions, division, options)? else { return Ok(Measurement::default()) };
        let (findings, corrected) = (aligned.told, aligned.sessions);
        if corrected.is_empty() {
            return Ok(Measurement { findings, ..Measurement::default() });
        }
        let (delay, as_recorded) = (aligned.late.lag.value, Some(aligned.as_recorded));
        Ok(Measurement { findings, corrected, delay, as_recorded, ..Measurement::default() })
    }
}

/// Recordings with the late current shifted into step with the motion.
pub struct Aligned {
    /// The delay.
    pub late: Late,
    /// Its effect, or the reason why none is named.
    pub told: Findings,
    /// The corrected sessions; empty where the correction gains nothing.
    pub sessions: Vec<TimeSeries>,
    /// The nominal model on the original recordings.
    as_recorded: AsRecorded,
}

/// Shifts a late current into step with the motion, where that gains. A delay that no effect of the catalogue claims is reported as unexplained.
///
/// # Errors
/// A session lacks a channel of a joint, or there is too little motion.
pub fn align(
    model: &Model,
    sessions: &[&TimeSeries],
    division: Division,
    options: &Options,
) -> Result<Option<Aligned>> {
    let Some(late) = late_current(model, sessions, division) else { return Ok(None) };
    let aligned: Vec<TimeSeries> = sessions.iter().map(|session| shifted(session, late.lag.value)).collect();
    let as_recorded = AsRecorded::new(model, sessions, division, options)?;
    let mut problem = pose(model, &aligned.iter().collect::<Vec<_>>(), division, options)?;
    let after = nominal(&mut problem).ok_or_else(|| nothing_moves(model))?.residuals;
    let before = as_recorded.at_rows_of(&problem);
    let of_torque =
        gains::Judge::new(&problem, &before).effect(&problem.joints(), [&before, &after], [&before, &after]);
    let gain = if of_torque.shown() {
        of_torque
    } else {
        of_transients(model, sessions, division, late.lag.value, &of_torque)
    };
    let sessions = if gain.shown() { aligned } else { Vec::new() };
    let told = claimed(model, &options.catalogue, vec![sighting(model, &late, gain)]);
    Ok(Some(Aligned { late, told, sessions, as_recorded }))
}

/// The gain of a lag [s] in the transients of held-out data. Few rows may have a gear that is surely pressed; transients are everywhere.
fn of_transients(
    model: &Model,
    sessions: &[&TimeSeries],
    division: Division,
    lag: f64,
    steps: &EffectGain,
) -> EffectGain {
    let of_joint = |joint: usize| {
        let [training, held_out] = [Division::training, Division::held_out].map(|parts| -> Vec<Transients> {
            let of_session = |(number, session): (usize, &&TimeSeries)| {
                Transients::of(model, joint, session, &parts(&division, number, session))
            };
            sessions.iter().enumerate().flat_map(of_session).collect()
        });
        compared(&training, &held_out, lag)
    };
    let runs: Vec<_> = (0..model.joints.len()).flat_map(of_joint).collect();
    EffectGain {
        gain_by_joint: steps.gain_by_joint.clone(),
        ..EffectGain::of(gains::gain(&runs), "transients of the torque")
    }
}

fn sighting(model: &Model, late: &Late, gain: EffectGain) -> Sighting {
    let Estimate { value: lag, std_error } = late.lag;
    Sighting {
        phenomenon: Phenomenon::CurrentLag { lag: late.lag },
        joints: (0..model.joints.len()).collect(),
        probability: late.probability,
        evidence_nats: 0.5 * (lag / std_error).powi(2),
        gain: Some(gain),
        words: format!("the current is recorded {:.2} ± {:.2} ms behind the motion", 1e3 * lag, 1e3 * std_error),
    }
}

/// A session with its currents, or torques from them, shifted `lag` [s] earlier.
pub fn shifted(session: &TimeSeries, lag: f64) -> TimeSeries {
    let mut aligned = session.clone();
    for series in &mut aligned.joints {
        for channel in [Channel::Current, Channel::Torque] {
            if let Some(samples) = series.channels.get_mut(&channel) {
                *samples = delayed(&session.time, samples, -lag).into();
            }
        }
    }
    aligned
}
