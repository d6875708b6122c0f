//! Measured current against the logged command: the dead band of a drive, sample by sample.
//!
//! The current read at `t` follows the command of `t − d`, held over a sample:
//! `i(t) = D(i_cmd(t − d)) + i0 + noise`, `D(u) = 0` for `|u| < u0`, `u` beyond it. First `d` is found, where commands are large; `i0` is the
//! median of the remaining difference there. For each sample, `g = log p(i | 0) − log p(i | u)` compares its likelihood with zero current and with
//! the commanded current. The log-likelihood of a dead band `u0` is the sum of `g` over all `|u| < u0`; its maximum is exact and needs no
//! start value. Noise is Student's t, so that samples at a voltage limit have a small weight.
//! The gain is the fall of the error within the band on held-out samples, with the `u0` of the training samples.
//! Left out: a drive whose current follows more slowly than one sample: its samples do not show a band that blocks the current and a normal
//! response beyond it.
//! Reference: J.-W. Choi, S.-K. Sul (1996), Inverter output voltage synthesis using novel dead time compensation.

use std::ops::Range;

use rayon::prelude::*;

use super::claims::{Sighting, claimed};
use super::{FittedRows, Instrument, Measurement};
use crate::diagnose::result::EffectGain;
use crate::diagnose::select::certainty::probability;
use crate::drive::Sensing;
use crate::effects::Phenomenon;
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::{Channel, Estimate, TimeSeries};

use crate::diagnose::fit::regression::{NU, log_density};
use crate::diagnose::residuals::gains;
use crate::diagnose::rows::division::Division;
use crate::replay::Gain;

/// [s] Longest delay of the current that is tried.
const LONGEST: f64 = 0.03;
/// Approximate number of samples that determine a delay.
const JUDGED: usize = 4000;
/// Share of the samples that count as independent: the loop's transients last a few samples.
const INDEPENDENT: f64 = 0.25;
/// Ranges of commands, relative to the dead band, in which the current has to be blocked, and in which it has to follow.
const INSIDE: [f64; 2] = [0.3, 0.9];
const OUTSIDE: [f64; 2] = [1.1, 2.5];
/// Largest part of the command that flows inside the band, and least part outside.
const STAYS_AWAY: f64 = 0.25;
const FOLLOWS: f64 = 0.75;
/// [1] Smallest standard error, relative to the band: in a real bridge the edge moves with the ripple of the current.
const LEAST_ERROR: f64 = 0.002;

/// A dead band that commands and currents show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeadBand {
    /// `u0` [A].
    pub width: Estimate,
    /// [nats] Evidence for it on the training samples.
    pub nats: f64,
    /// Gain on held-out samples within the band, in the difference between current and command.
    pub gain: Gain,
}

/// The instrument for the dead band; its gain is that of the current inside the band.
pub struct Command;

impl Instrument<FittedRows<'_>> for Command {
    fn measure(&self, scene: &FittedRows) -> Result<Measurement> {
        let FittedRows { problem, sessions, division, options, .. } = *scene;
        let model = problem.motion.model;
        let of_joint = |joint: usize| {
            let band = dead_band(model, joint, sessions, division).filter(|band| band.nats > options.rules.nats)?;
            Some(Sighting {
                phenomenon: Phenomenon::DeadBand { width: band.width },
                joints: vec![joint],
                probability: probability(band.nats, 1, &options.rules, std::iter::empty()),
                evidence_nats: band.nats,
                gain: Some(EffectGain::of(band.gain, "current within the band")),
                words: format!(
                    "commands below {:.3} ± {:.3} A make no current",
                    band.width.value, band.width.std_error
                ),
            })
        };
        let sightings = (0..model.joints.len()).into_par_iter().filter_map(of_joint).collect();
        Ok(Measurement { findings: claimed(model, &problem.catalogue, sightings), ..Measurement::default() })
    }
}

/// Samples of a joint in one session: the current, and the two commands on either side of its delay.
struct Samples {
    /// [s]
    time: Vec<f64>,
    current: Vec<f64>,
    /// The earlier command of each sample, then the later command of the last one: the later command of a sample is the earlier one of the next.
    command: Vec<f64>,
    /// Weight of the earlier command.
    part: f64,
    /// [A] Scale of the noise.
    scale: f64,
}

/// The dead band of a joint in the training data.
pub fn dead_band(model: &Model, joint: usize, sessions: &[&TimeSeries], division: Division) -> Option<DeadBand> {
    let read = |held_out: bool| -> Vec<Samples> {
        let of_session = |(number, session): (usize, &&TimeSeries)| {
            let parts = division.parts(number, session).into_iter().filter(|(_, held)| *held == held_out);
            parts.filter_map(|(part, _)| Samples::new(model, joint, session, part)).collect::<Vec<_>>()
        };
        sessions.iter().enumerate().flat_map(of_session).collect()
    };
    let train = read(false);
    let (width, nats) = widest_gain(&train)?;
    shuts(&train, width.value).then(|| DeadBand { width, nats, gain: gain(&read(true), width.value) })
}

impl Samples {
    /// The samples of a part of a session; `None` where it has no signed current or no command.
    fn new(model: &Model, joint: usize, session: &TimeSeries, samples: Range<usize>) -> Option<Self> {
        let joint = &model.joints[joint];
        if joint.current_sensor.is_some_and(|sensor| sensor.sensing == Sensing::Absolute) {
            return None;
        }
        let series = session.joint(&joint.name)?;
        let (current, command) = (series.get(Channel::Current)?, series.get(Channel::CommandCurrent)?);
        let limit = joint.amplifier.current_limit;
        let (current, command) = (&current[samples.clone()], &command[samples.clone()]);
        let mut command: Vec<f64> = command.iter().map(|u| u.clamp(-limit, limit)).collect();
        let dt = session.sample_interval();
        let longest = (LONGEST / dt) as usize;
        if dt.is_nan() || dt <= 0.0 || current.len() < 8 * longest.max(1) {
            return None;
        }
        let (delay, part) = delay(current, &command, longest);
        command.truncate(command.len() - delay);
        let time = session.time[samples][delay + 1..].to_vec();
        let mut samples = Self { time, current: current[delay + 1..].to_vec(), command, part, scale: 1.0 };
        samples.settle();
        Some(samples)
    }

    /// Subtracts the sensor's offset and estimates the noise, both from the larger half of the commands.
    fn settle(&mut self) {
        let large = typical(self.command[1..].iter().map(|u| u.abs()).collect());
        let errors: Vec<f64> = (0..self.current.len())
            .filter(|k| self.commands(*k).iter().all(|u| u.abs() >= large))
            .map(|k| self.current[k] - self.commanded(k))
            .collect();
        let offset = typical(errors.clone());
        self.current.iter_mut().for_each(|i| *i -= offset);
        // For a normal variable the median deviation is 0.6745 standard deviations.
        self.scale = (typical(errors.iter().map(|e| (e - offset).abs()).collect()) / 0.6745).max(1e-9);
    }

    /// The later and the earlier command of a sample.
    fn commands(&self, k: usize) -> [f64; 2] {
        [self.command[k + 1], self.command[k]]
    }

    fn commanded(&self, k: usize) -> f64 {
        let [later, earlier] = self.commands(k);
        (1.0 - self.part) * later + self.part * earlier
    }

    /// Log-density of a sample for given states of its later and earlier command: passed or blocked.
    fn density(&self, k: usize, passes: [bool; 2]) -> f64 {
        let through = |which: usize| if passes[which] { self.commands(k)[which] } else { 0.0 };
        let expected = (1.0 - self.part) * through(0) + self.part * through(1);
        log_density(self.current[k] - expected, self.scale, NU)
    }

    /// The contributions of a sample as the band grows beyond its commands: `(|u|, change of log-likelihood)`.
    fn events(&self, k: usize) -> [(f64, f64); 2] {
        let sizes = self.commands(k).map(f64::abs);
        let first = usize::from(sizes[1] < sizes[0]);
        let mut passes = [true, true];
        let mut last = self.density(k, passes);
        [first, 1 - first].map(|which| {
            passes[which] = false;
            let next = self.density(k, passes);
            let event = (sizes[which], next - last);
            last = next;
            event
        })
    }
}

/// Delay of the current in whole samples, and the remaining part of a sample: the minimum of `Σ |i − u|` over large commands.
fn delay(current: &[f64], command: &[f64], longest: usize) -> (usize, f64) {
    let large = typical(command.iter().map(|u| u.abs()).collect());
    let stride = (current.len() / JUDGED).max(1);
    let judged: Vec<usize> = (longest + 1..current.len())
        .step_by(stride)
        .filter(|k| command[k - longest..=*k].iter().all(|u| u.abs() >= large))
        .collect();
    let misfit = |delay: usize, part: f64| -> f64 {
        let error = |k: &usize| current[*k] - (1.0 - part) * command[k - delay] - part * command[k - delay - 1];
        let offset = typical(judged.iter().map(error).collect());
        judged.iter().map(|k| (error(k) - offset).abs()).sum()
    };
    const PARTS: usize = 8;
    let at = |step: usize| misfit(step / PARTS, (step % PARTS) as f64 / PARTS as f64);
    let least = |steps: &mut dyn Iterator<Item = usize>| {
        steps.map(|step| (at(step), step)).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, step)| step)
    };
    let whole = least(&mut (0..longest).map(|delay| delay * PARTS));
    let best = least(&mut (whole.saturating_sub(PARTS)..(whole + PARTS).min((longest - 1) * PARTS)));
    (best / PARTS, (best % PARTS) as f64 / PARTS as f64)
}

/// The width of maximum likelihood with its standard error, and its log-likelihood [nats] relative to no band.
fn widest_gain(sessions: &[Samples]) -> Option<(Estimate, f64)> {
    let mut events: Vec<(f64, f64)> =
        sessions.iter().flat_map(|samples| (0..samples.current.len()).flat_map(|k| samples.events(k))).collect();
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Cumulative sum: the likelihood of a band up to each command.
    let mut sum = 0.0;
    for (_, gain) in &mut events {
        sum += INDEPENDENT * *gain;
        *gain = sum;
    }
    let most = events.iter().map(|event| event.1).fold(f64::NEG_INFINITY, f64::max);
    if !(most > 0.0 && most.is_finite()) {
        return None;
    }
    // Between two commands the likelihood is constant, so its posterior under a flat prior is a sum of steps.
    let mut moments = [0.0; 3];
    for pair in events.windows(2) {
        let (size, total) = pair[0];
        let (middle, length) = (0.5 * (size + pair[1].0), pair[1].0 - size);
        let weight = (total - most).exp() * length;
        for (moment, value) in moments.iter_mut().zip([1.0, middle, middle * middle + length * length / 12.0]) {
            *moment += weight * value;
        }
    }
    let value = moments[1] / moments[0];
    let variance = (moments[2] / moments[0] - value * value).max(0.0);
    let std_error = variance.sqrt().hypot(LEAST_ERROR * value);
    (moments[0] > 0.0).then_some((Estimate { value, std_error }, most))
}

/// Whether the current is blocked inside the band and follows outside.
fn shuts(sessions: &[Samples], u0: f64) -> bool {
    let slope = |[from, to]: [f64; 2]| {
        let (mut iu, mut uu) = (0.0, 0.0);
        for samples in sessions {
            for k in 0..samples.current.len() {
                let within = |u: f64| u.abs() >= from * u0 && u.abs() < to * u0;
                if samples.commands(k).into_iter().all(within) {
                    let u = samples.commanded(k);
                    iu += samples.current[k] * u;
                    uu += u * u;
                }
            }
        }
        (uu > 0.0).then(|| iu / uu)
    };
    slope(INSIDE).is_some_and(|slope| slope.abs() < STAYS_AWAY) && slope(OUTSIDE).is_some_and(|slope| slope > FOLLOWS)
}

/// Gain in the current's error within the band, from a model without the band to one with it.
fn gain(sessions: &[Samples], u0: f64) -> Gain {
    let errors = |samples: &Samples| -> [Vec<f64>; 3] {
        let within = |k: &usize| samples.commands(*k).iter().all(|u| u.abs() < u0);
        let picked: Vec<usize> = (0..samples.current.len()).filter(within).collect();
        let each = |value: &dyn Fn(usize) -> f64| picked.iter().map(|k| value(*k)).collect::<Vec<f64>>();
        [
            each(&|k| samples.time[k]),
            each(&|k| samples.current[k] - samples.commanded(k)),
            each(&|k| samples.current[k]),
        ]
    };
    let errors: Vec<[Vec<f64>; 3]> = sessions.iter().map(errors).collect();
    gains::gain(&errors)
}

/// Median; 0 for an empty list.
fn typical(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
