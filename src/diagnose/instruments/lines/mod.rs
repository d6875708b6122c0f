//! Torque at a fixed frequency in time: the same line in all sessions, at any speed.
//!
//! The disturbance torque `d` on a rotor is computed from unsmoothed position and current ([`balance`]), where the joint keeps
//! moving ([`piece`]). A line of amplitude `a` gives `a W/2`, `W = Σ w`, in its transform `E = Σ w d e^{−iωt}`; [`estimate`] measures it posture by posture. The noise has the level of the
//! neighbouring frequencies ([`spectrum`]); its `|E|²` is exponential, so sums over sessions follow a gamma distribution.
//! A line is named if the training sessions together show it beyond chance, in slow and in fast motion, and if it gains on held-out
//! data. A torque that depends on an angle changes its frequency with speed; a limit cycle of the loop changes its amplitude, and is no narrow line.
//! The line is then subtracted from the recorded torque, so that all later stages see a machine without it.
//! At uneven times all sums are taken at the true times; nothing is interpolated, because that would make lines of its own.
//! Left out: joints that hardly move; lines above [`HIGHEST`], where the control loop causes lines of its own; lines below [`LOWEST`], which are
//! reported as a pattern without a cause (`evidence/oscillation`).
//! Reference: P. D. Welch (1967), The use of fast Fourier transform for the estimation of power spectra; S. M. Kay (1993), Fundamentals
//! of Statistical Signal Processing I, sec. 3.11 (bounds of amplitude, phase and frequency).

mod balance;
mod estimate;
mod piece;
mod scan;
mod spectrum;

use std::f64::consts::TAU;
use std::ops::Range;

use crate::diagnose::evidence::probability::calibrated;
use crate::diagnose::instruments::claims::{Sighting, claimed};
use crate::diagnose::instruments::{Instrument, Measurement, Recordings};
use crate::diagnose::result::EffectGain;
use crate::diagnose::rows::division::Division;
use crate::diagnose::rows::sampling::Sampling;
use crate::diagnose::rows::signals;
use crate::drive::Sensing;
use crate::effects::Phenomenon;
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::side_by_side;
use crate::timeseries::{Channel, Estimate, TimeSeries};
use estimate::Line;
use piece::Piece;
use scan::Scan;

/// [Hz] Lowest and highest frequency that is tried; below the lowest, the motion itself has its power.
const LOWEST: f64 = 10.0;
const HIGHEST: f64 = 160.0;
/// Probability that noise shows a line in the training sessions of a machine.
const CHANCE: f64 = 1e-4;
/// [nats] `|E|²` over its level that a piece exceeds at a frequency by chance once in a thousand.
const PRESENT: f64 = 7.0;
/// [1] Standard errors that an amplitude has to exceed: its 95 % interval then excludes zero. The existence of a line may be more certain than its strength, and
/// a cause without a known strength is not named.
const SURE: f64 = 1.96;
/// [1] Least amplitude relative to the RMS torque: real drives have weaker lines than this, whatever the motion.
const LEAST: f64 = 0.01;
/// [1] Largest motor torque at the frequency, relative to the disturbance: a control loop responds little well above its bandwidth.
const ANSWERED: f64 = 0.5;
/// Largest number of lines of a joint.
const MOST: usize = 2;
/// Least amplitude on another joint relative to the strongest at the same frequency: joints shake each other.
const OTHER_JOINT: f64 = 0.3;

/// Lines at frequencies that are fixed in time.
pub struct Lines;

impl Instrument<Recordings<'_>> for Lines {
    fn measure(&self, scene: &Recordings) -> Result<Measurement> {
        let Recordings { model, sessions, options, .. } = *scene;
        let all = found(scene);
        let (lines, without_gain): (Vec<_>, Vec<_>) = all.into_iter().partition(|(_, line)| line.gain.shown);
        let sightings = lines.iter().chain(&without_gain).map(|(joint, line)| sighting(model, *joint, line));
        let findings = claimed(model, &options.catalogue, sightings.collect());
        let corrected: Vec<TimeSeries> = match lines.is_empty() {
            true => Vec::new(),
            false => sessions.iter().map(|session| without(model, &lines, session)).collect(),
        };
        Ok(Measurement { findings, shaken: !corrected.is_empty(), corrected, ..Measurement::default() })
    }
}

/// The lines of each joint in the training data.
fn found(scene: &Recordings) -> Vec<(usize, Line)> {
    let Recordings { model, sessions, division, .. } = *scene;
    let joints: Vec<usize> = (0..model.joints.len()).collect();
    let samples = sessions.iter().map(|session| session.len()).sum::<usize>();
    // Memory: torque, four signals of the pieces and their spectra, and the transform of one piece at a time.
    let bytes = 56 * samples + scan::transform_bytes(scan::length_of(samples));
    let scans =
        side_by_side(&joints, bytes, |joint| Scan::new(model, *joint, pieces(model, *joint, sessions, division)));
    let scans: Vec<&Scan> = scans.iter().flatten().collect();
    // With those that are too weak, too uncertain or the motor's own: they shake other joints as well.
    let of_scan = |scan: &&Scan| scan.lines(model).map(|line| (scan.joint, line)).collect::<Vec<_>>();
    let all: Vec<(usize, Line)> = scans.iter().flat_map(of_scan).collect();
    let named = |scan: &&Scan| {
        let motor = MotorTorque::new(model, scan.joint, sessions, division);
        let own = all.iter().filter(|(joint, _)| *joint == scan.joint);
        let disturbing = own.filter(|(_, line)| motor.is_disturbed_by(line)).take(MOST);
        disturbing.filter(|line| !comes_from_another_joint(line, &all, &scans)).cloned().collect::<Vec<_>>()
    };
    scans.iter().flat_map(named).collect()
}

/// Whether another joint shakes this one at a line's frequency: its own line is much stronger, or where it has none, its spectrum shows more there.
fn comes_from_another_joint((joint, line): &(usize, Line), all: &[(usize, Line)], scans: &[&Scan]) -> bool {
    let is_near = |f: f64| (f - line.frequency.value).abs() < line.resolution;
    let stronger = |scan: &&Scan| {
        let mut own = all.iter().filter(|(joint, one)| *joint == scan.joint && is_near(one.frequency.value)).peekable();
        match own.peek() {
            Some(_) => own.any(|(_, own)| line.amplitude.value < OTHER_JOINT * own.amplitude.value),
            None => scan.peaks.iter().any(|peak| is_near(peak.frequency) && peak.evidence > line.evidence),
        }
    };
    scans.iter().filter(|scan| scan.joint != *joint).any(stronger)
}

/// Pieces of the sessions, or of both parts of each session if no session is held out: runs of samples at even times, or where there are
/// none, all samples between two pauses. Training pieces come first.
fn pieces(model: &Model, joint: usize, sessions: &[&TimeSeries], division: Division) -> Vec<Piece> {
    let all = sessions.iter().enumerate().flat_map(|(number, session)| {
        let sampling = Sampling::new(&session.time, session.sample_interval());
        let of_part = |(samples, held): (Range<usize>, bool)| {
            let long = |run: &Range<usize>| run.len() as f64 * sampling.median > piece::SHORTEST_RUN;
            let mut even = sampling.even_runs(samples.clone()).into_iter().filter(long).peekable();
            if even.peek().is_some() {
                return even.filter_map(|run| Piece::new(model, joint, session, run, held)).collect::<Vec<_>>();
            }
            let parts = sampling.within(&samples).filter(long);
            parts.filter_map(|part| Piece::uneven(model, joint, (session, &sampling), part, held)).collect()
        };
        division.parts(number, session).into_iter().flat_map(of_part).collect::<Vec<_>>()
    });
    let mut all: Vec<Piece> = all.collect();
    all.sort_by_key(|piece| piece.held_out);
    all
}

/// Torque of the motor of a joint in each training part of the sessions.
struct MotorTorque<'s>(Vec<(&'s [f64], Vec<f64>)>);

impl<'s> MotorTorque<'s> {
    fn new(model: &Model, joint: usize, sessions: &[&'s TimeSeries], division: Division) -> Self {
        let of_session = |(number, session): (usize, &&'s TimeSeries)| {
            let series = session.joint(&model.joints[joint].name)?;
            let torque = signals::motor_torque(model, joint, series, None)?.0;
            let of_part = |part: Range<usize>| (&session.time[part.clone()], torque[part].to_vec());
            Some(division.training(number, session).into_iter().map(of_part).collect::<Vec<_>>())
        };
        Self(sessions.iter().enumerate().filter_map(of_session).flatten().collect())
    }

    /// [N·m or N] RMS over all sessions.
    fn root_mean_square(&self) -> f64 {
        crate::timeseries::root_mean_square(
            &self.0.iter().flat_map(|(_, torque)| torque).copied().collect::<Vec<f64>>(),
        )
    }

    /// [N·m or N] Largest amplitude of a part at a frequency [Hz]: `2/T |Σ Δt τ e^{−iωt}|`, `Δt` the time that a sample stands for.
    fn amplitude(&self, frequency: f64) -> f64 {
        let of_session = |(time, torque): &(&[f64], Vec<f64>)| {
            let stands_for = |k: usize| {
                let (before, after) = (k.saturating_sub(1), (k + 1).min(time.len() - 1));
                (time[after] - time[before]) / (after - before).max(1) as f64
            };
            let sum = torque.iter().enumerate().fold([0.0; 3], |[re, im, total], (k, torque)| {
                let (sin, cos) = (TAU * frequency * time[k]).sin_cos();
                let step = stands_for(k);
                [re + step * torque * cos, im + step * torque * sin, total + step]
            });
            2.0 * sum[0].hypot(sum[1]) / sum[2].max(1e-300)
        };
        self.0.iter().map(of_session).fold(0.0, f64::max)
    }

    /// Whether a line is strong enough, certain enough, and not caused by the motor. A control loop responds little above its bandwidth; a
    /// line that the motor causes excites rotor and gear. Below the bandwidth the two cases look alike, and none is named.
    fn is_disturbed_by(&self, line: &Line) -> bool {
        let Estimate { value, std_error, .. } = line.amplitude;
        value > SURE * std_error
            && value > LEAST * self.root_mean_square()
            && self.amplitude(line.frequency.value) < ANSWERED * value
    }
}

/// Value that a sum of `count` exponential variables of mean 1 exceeds with this probability.
pub fn beyond_chance(count: usize, probability: f64) -> f64 {
    let exceeds = |x: f64| {
        let mut term = 1.0;
        let sum: f64 = (0..count)
            .map(|k| {
                if k > 0 {
                    term *= x / k as f64;
                }
                term
            })
            .sum();
        sum * (-x).exp()
    };
    let (mut low, mut high) = (0.0, 200.0 + 10.0 * count as f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if exceeds(middle) > probability { low = middle } else { high = middle }
    }
    high
}

fn sighting(model: &Model, joint: usize, line: &Line) -> Sighting {
    let Line { frequency, amplitude, phase, .. } = *line;
    let unit = model.joints[joint].kind.effort_unit();
    let of = if line.is_gain_in_training { ", each training session predicted from the others" } else { "" };
    Sighting {
        phenomenon: Phenomenon::Line { frequency, amplitude, phase },
        joints: vec![joint],
        probability: calibrated(CHANCE),
        evidence_nats: line.evidence,
        gain: Some(EffectGain::of(line.gain, &format!("amplitude at {:.1} Hz{of}", frequency.value))),
        words: format!(
            "a line at {:.2} ± {:.2} Hz, {:.3} ± {:.3} {unit}",
            frequency.value, frequency.std_error, amplitude.value, amplitude.std_error
        ),
    }
}

/// A session whose motor torque includes the lines: `τ_m + d`.
fn without(model: &Model, lines: &[(usize, Line)], session: &TimeSeries) -> TimeSeries {
    let mut corrected = session.clone();
    let start = session.time.first().copied().unwrap_or(0.0);
    for (joint, line) in lines {
        let joint = &model.joints[*joint];
        let absolute = joint.current_sensor.is_some_and(|s| s.sensing == Sensing::Absolute);
        let Some(series) = corrected.joints.iter_mut().find(|series| series.name == joint.name) else { continue };
        let side: Option<Vec<f64>> = series.get(Channel::Velocity).map(|v| v.iter().map(|v| v.signum()).collect());
        for (channel, scale) in [(Channel::Torque, 1.0), (Channel::Current, joint.torque_per_ampere())] {
            for (k, sample) in series.channels.get_mut(&channel).into_iter().flatten().enumerate() {
                let sign = if absolute { side.as_ref().map_or(1.0, |side| side[k]) } else { 1.0 };
                *sample += sign * line.torque(session.time[k] - start) / scale;
            }
        }
    }
    corrected
}

#[cfg(test)]
mod tests {
    use super::beyond_chance;

    /// One exponential variable exceeds x with probability e^−x, a sum of two with (1 + x) e^−x.
    #[test]
    fn closed_form_tails_of_gamma_distributions() {
        assert!((beyond_chance(1, 1e-6) - 1e6_f64.ln()).abs() < 1e-9);
        let x = beyond_chance(2, 1e-6);
        assert!(((1.0 + x) * (-x).exp() / 1e-6 - 1.0).abs() < 1e-9);
    }
}
