//! Whether the current is recorded late relative to the motion, measured from transients.
//!
//! Above some 3 Hz a joint is a mass, whichever flank is in contact: acceleration follows torque at once. The sum
//! `Σ a(t) τ(t + L)`, both filtered by a kernel of 12 ms minus one of 60 ms, therefore peaks at the lag
//! `L` = 0, and at `T` if the current is late by `T`.
//! A late position does not show: the controller responds to the position that it reads, and its response is in step with it.
//! Where samples lie at uneven times, both kernels are those of a [local polynomial](crate::diagnose::rows::local) in true time, taken at even
//! times: its weights have no first moment, so that it delays nothing. Left out: windows across pauses.
//! Reference: C. H. Knapp, G. C. Carter (1976), The generalized correlation method for estimation of time delay.

use std::ops::Range;

use super::as_recorded::{AsRecorded, nominal};
use super::claims::{Sighting, claimed};
use super::{Instrument, Measurement, Recordings};
use crate::diagnose::evidence::probability::{calibrated, odds_against};
use crate::diagnose::fit::pose::{nothing_moves, pose};
use crate::diagnose::options::Options;
use crate::diagnose::residuals::gains;
use crate::diagnose::result::{EffectGain, Findings};
use crate::diagnose::rows::division::Division;
use crate::diagnose::rows::kernel::{Averages, Kernel};
use crate::diagnose::rows::observe::motor_torque;
use crate::diagnose::rows::sampling::Sampling;
use crate::effects::Phenomenon;
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::side_by_side;
use crate::timeseries::{Channel, Estimate, TimeSeries};

/// [s] Half widths of the two kernels whose difference is the band-pass filter.
const BAND: [f64; 2] = [0.012, 0.06];
/// [s] Largest distance of samples: four of them in the narrow kernel, on either side.
pub const COARSEST: f64 = BAND[0] / 4.0;
/// [s] Largest lag that is tried.
const LONGEST: f64 = 0.03;
/// Least correlation of a peak.
const LEAST_CORRELATION: f64 = 0.2;
/// [s] Lags of recordings without a delay: 0.3 ± 0.4 ms per joint and session (24 simulated machines, 9 foreign recordings: −0.3 to 1.2 ms);
/// the median of several is within ±0.6 ms. A larger lag than this constant is a delay.
const NOTICEABLE: f64 = 1.5e-3;
/// [s] Possible shift of the median by friction and the gap.
const SYSTEMATIC: f64 = 3e-4;

/// Standard errors by which a delay has to exceed [`NOTICEABLE`]: if joints and sessions disagree about the lag, there is no delay.
const SURELY: f64 = 4.0;

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
    let of_session = |session: usize| {
        let places = (0..model.joints.len()).map(move |joint| (session, joint));
        places.flat_map(move |place| runs(sessions, division, session).into_iter().map(move |run| (place, run)))
    };
    let places: Vec<((usize, usize), Range<usize>)> = (0..sessions.len()).flat_map(of_session).collect();
    let of_place =
        |((session, joint), run): &((usize, usize), Range<usize>)| lag(model, *joint, sessions[*session], run.clone());
    // Memory for the torque, and for both signals after the filter.
    let longest = sessions.iter().map(|session| session.len()).max().unwrap_or(0);
    let mut lags: Vec<f64> = side_by_side(&places, 24 * longest, of_place).into_iter().flatten().collect();
    if lags.len() < 2 {
        return None;
    }
    lags.sort_by(f64::total_cmp);
    let value = lags[lags.len() / 2];
    let mut deviations: Vec<f64> = lags.iter().map(|lag| (lag - value).abs()).collect();
    deviations.sort_by(f64::total_cmp);
    // For a normal variable the median deviation is 0.6745 standard deviations, and the median scatters 1.25 times as much as the mean.
    let scatter = 1.25 * deviations[deviations.len() / 2] / 0.6745 / (lags.len() as f64).sqrt();
    let std_error = scatter.hypot(SYSTEMATIC);
    let beyond = (value - NOTICEABLE) / std_error;
    let probability = calibrated(odds_against(value, NOTICEABLE, std_error));
    (beyond > SURELY).then_some(Late { lag: Estimate { value, std_error }, probability })
}

/// Runs of training samples in a session: those at even times, and where there are none, those between pauses.
fn runs(sessions: &[&TimeSeries], division: Division, number: usize) -> Vec<Range<usize>> {
    let session = sessions[number];
    let dt = session.sample_interval();
    // Both ends lose half of the wide kernel, and what remains has to be at least as long as both losses together.
    let long = |run: &Range<usize>| run.len() as f64 * dt > 4.0 * BAND[1];
    let sampling = Sampling::new(&session.time, dt);
    let training = division.training(number, session);
    let even: Vec<_> = training.iter().flat_map(|part| sampling.even_runs(part.clone())).filter(long).collect();
    if !even.is_empty() {
        return even;
    }
    training.iter().flat_map(|part| sampling.within(part)).filter(long).collect()
}

/// Lag of the correlation's peak for one joint in samples of a session.
fn lag(model: &Model, joint: usize, session: &TimeSeries, run: Range<usize>) -> Option<f64> {
    let series = session.joint(&model.joints[joint].name)?;
    let position = series.get(Channel::Position)?;
    let (torque, has_current) = motor_torque(model, joint, series, series.get(Channel::Velocity))?;
    let dt = session.sample_interval();
    if !has_current || dt.is_nan() || dt <= 0.0 || dt > COARSEST {
        return None;
    }
    let sampling = Sampling::new(&session.time, dt);
    let [a, tau] = match sampling.even_runs(run.clone()).len() {
        1 => at_even_times(&position[run.clone()], &torque[run], dt)?,
        _ => at_uneven_times(&sampling, position, &torque, run)?,
    };
    peak(&a, &tau, (LONGEST / dt) as usize).map(|lag| lag * dt)
}

/// Acceleration and torque after the band-pass, sample by sample.
fn at_even_times(position: &[f64], torque: &[f64], dt: f64) -> Option<[Vec<f64>; 2]> {
    let [narrow, wide] = BAND.map(|width| Kernel::new((width / dt) as usize, dt));
    let edge = wide.reach + 1;
    if position.len() < 4 * edge {
        return None;
    }
    let band = |signal: &[f64], pick: fn(Averages) -> f64| -> Vec<f64> {
        (edge..signal.len() - edge)
            .map(|centre| pick(narrow.averages(signal, centre)) - pick(wide.averages(signal, centre)))
            .collect()
    };
    Some([band(position, |averages| averages.curvature), band(torque, |averages| averages.value)])
}

/// As [`at_even_times`], at multiples of the median step within an uninterrupted run.
fn at_uneven_times(sampling: &Sampling, position: &[f64], torque: &[f64], run: Range<usize>) -> Option<[Vec<f64>; 2]> {
    let dt = sampling.median;
    let [begin, end] = [sampling.time()[run.start] + BAND[1] + dt, sampling.time()[run.end - 1] - BAND[1] - dt];
    if end - begin < 2.0 * BAND[1] {
        return None;
    }
    let at = |k: usize| {
        let t = begin + k as f64 * dt;
        let [narrow, wide] = [sampling.around_time(t, BAND[0])?, sampling.around_time(t, BAND[1])?];
        let a = narrow.averages(position).curvature - wide.averages(position).curvature;
        Some((a, narrow.averages(torque).value - wide.averages(torque).value))
    };
    let both: Option<(Vec<f64>, Vec<f64>)> = (0..((end - begin) / dt) as usize).map(at).collect();
    both.map(|(a, tau)| [a, tau])
}

/// Lag in samples at which `b` follows `a` best, interpolated by a parabola.
fn peak(a: &[f64], b: &[f64], longest: usize) -> Option<f64> {
    if a.len() < 4 * longest {
        return None;
    }
    let inner = longest..a.len() - longest;
    let correlation: Vec<f64> =
        (0..=2 * longest).map(|shift| inner.clone().map(|k| a[k] * b[k + shift - longest]).sum::<f64>()).collect();
    let power = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    let best = (0..correlation.len()).max_by(|i, j| correlation[*i].total_cmp(&correlation[*j]))?;
    let strong = correlation[best] > LEAST_CORRELATION * (power(a) * power(b)).sqrt();
    if !strong || best == 0 || best == 2 * longest {
        return None;
    }
    let [left, middle, right] = [correlation[best - 1], correlation[best], correlation[best + 1]];
    Some(best as f64 - longest as f64 + 0.5 * (left - right) / (left - 2.0 * middle + right))
}

/// The instrument for a late current.
pub struct CurrentLag;

impl Instrument<Recordings<'_>> for CurrentLag {
    fn measure(&self, scene: &Recordings) -> Result<Measurement> {
        let Recordings { model, sessions, division, options } = *scene;
        let Some(aligned) = align(model, sessions, division, options)? else { return Ok(Measurement::default()) };
        let as_recorded = (!aligned.sessions.is_empty()).then_some(aligned.as_recorded);
        Ok(Measurement { findings: aligned.told, corrected: aligned.sessions, as_recorded, ..Measurement::default() })
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
    let gain = gains::Judge::new(&problem, &before).effect(&problem.joints(), [&before, &after], [&before, &after]);
    let sessions = if gain.shown() { aligned } else { Vec::new() };
    let told = claimed(model, &options.catalogue, vec![sighting(model, &late, gain)]);
    Ok(Some(Aligned { late, told, sessions, as_recorded }))
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

/// A session with its currents shifted `lag` [s] earlier.
fn shifted(session: &TimeSeries, lag: f64) -> TimeSeries {
    let mut aligned = session.clone();
    for series in &mut aligned.joints {
        if let Some(current) = series.channels.get_mut(&Channel::Current) {
            *current = session.time.iter().map(|t| at(&session.time, current, t + lag)).collect();
        }
    }
    aligned
}

/// Linear interpolation, constant beyond the ends.
fn at(time: &[f64], values: &[f64], t: f64) -> f64 {
    let next = time.partition_point(|sample| *sample <= t).clamp(1, time.len() - 1);
    let part = ((t - time[next - 1]) / (time[next] - time[next - 1])).clamp(0.0, 1.0);
    values[next - 1] + part * (values[next] - values[next - 1])
}
