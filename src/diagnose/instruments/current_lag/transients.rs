//! Transients of a joint: its acceleration and its motor torque in the band in which it is a mass, and how well one follows the other.
//!
//! ```text
//!   a(t) = c τ(t + L) + n(t)         c by least squares over the training data of a joint, for each lag L
//! ```
//! The noise is nearly all in `a`, from the encoder's counts, so `a` is regressed on `τ` and not the reverse.

use std::ops::Range;

use crate::diagnose::rows::kernel::{Averages, Kernel};
use crate::diagnose::rows::sampling::Sampling;
use crate::diagnose::rows::signals::motor_torque;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries, delayed, root_mean_square};

/// [s] Half widths of the two kernels whose difference is the band-pass filter.
const BAND: [f64; 2] = [0.012, 0.06];
/// [s] Largest distance of samples: four of them in the narrow kernel, on either side.
pub const COARSEST: f64 = BAND[0] / 4.0;
/// [s] Largest lag that is tried.
const LONGEST: f64 = 0.03;
/// Least correlation of a peak.
const LEAST_CORRELATION: f64 = 0.2;

/// Transients in an uninterrupted run of samples, at even times.
pub struct Transients {
    /// [s]
    time: Vec<f64>,
    /// `a` [rad/s² or m/s²]
    acceleration: Vec<f64>,
    /// `τ` [N·m or N]
    torque: Vec<f64>,
    /// [s] Time from one to the next.
    step: f64,
}

impl Transients {
    /// Of a joint in each uninterrupted run of these parts of a session: those at even times, and where there are none, those between pauses.
    /// None where the current is not known by its sign or the samples are too far apart.
    pub fn of(model: &Model, joint: usize, session: &TimeSeries, parts: &[Range<usize>]) -> Vec<Self> {
        let all = || {
            let series = session.joint(&model.joints[joint].name)?;
            let position = series.get(Channel::Position)?;
            let (torque, has_current) = motor_torque(model, joint, series, series.get(Channel::Velocity))?;
            let dt = session.sample_interval();
            if !has_current || dt.is_nan() || dt <= 0.0 || dt > COARSEST {
                return None;
            }
            let sampling = Sampling::new(&session.time, dt);
            let runs = runs(&sampling, parts).into_iter();
            Some(runs.filter_map(|run| Self::of_run(&sampling, position, &torque, run)).collect())
        };
        all().unwrap_or_default()
    }

    fn of_run(sampling: &Sampling, position: &[f64], torque: &[f64], run: Range<usize>) -> Option<Self> {
        match sampling.even_runs(run.clone()).len() {
            1 => Self::at_even_times(sampling, position, torque, run),
            _ => Self::at_uneven_times(sampling, position, torque, run),
        }
    }

    fn at_even_times(sampling: &Sampling, position: &[f64], torque: &[f64], run: Range<usize>) -> Option<Self> {
        let dt = sampling.median;
        let [narrow, wide] = BAND.map(|width| Kernel::new((width / dt) as usize, dt));
        let edge = wide.reach + 1;
        if run.len() < 4 * edge {
            return None;
        }
        let inner = run.start + edge..run.end - edge;
        let band = |signal: &[f64], pick: fn(Averages) -> f64| -> Vec<f64> {
            let of = |centre| pick(narrow.averages(signal, centre)) - pick(wide.averages(signal, centre));
            inner.clone().map(of).collect()
        };
        Some(Self {
            time: sampling.time()[inner.clone()].to_vec(),
            acceleration: band(position, |averages| averages.curvature),
            torque: band(torque, |averages| averages.value),
            step: dt,
        })
    }

    /// At multiples of the median step.
    fn at_uneven_times(sampling: &Sampling, position: &[f64], torque: &[f64], run: Range<usize>) -> Option<Self> {
        let dt = sampling.median;
        let [begin, end] = [sampling.time()[run.start] + BAND[1] + dt, sampling.time()[run.end - 1] - BAND[1] - dt];
        if end - begin < 2.0 * BAND[1] {
            return None;
        }
        let at = |k: usize| {
            let t = begin + k as f64 * dt;
            let [narrow, wide] = [sampling.around_time(t, BAND[0])?, sampling.around_time(t, BAND[1])?];
            let a = narrow.averages(position).curvature - wide.averages(position).curvature;
            Some([t, a, narrow.averages(torque).value - wide.averages(torque).value])
        };
        let all: Option<Vec<[f64; 3]>> = (0..((end - begin) / dt) as usize).map(at).collect();
        let all = all?;
        let [time, acceleration, torque] = [0, 1, 2].map(|part| all.iter().map(|one| one[part]).collect());
        Some(Self { time, acceleration, torque, step: dt })
    }

    /// [s] How late the torque follows the acceleration: where they agree best, interpolated by a parabola. `None` where they agree nowhere.
    pub fn lag(&self) -> Option<f64> {
        let (a, b, longest) = (&self.acceleration, &self.torque, (LONGEST / self.step) as usize);
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
        let samples = best as f64 - longest as f64 + 0.5 * (left - right) / (left - 2.0 * middle + right);
        Some(samples * self.step)
    }

    /// `τ(t + L)` [N·m or N]
    fn torque_after(&self, lag: f64) -> Vec<f64> {
        delayed(&self.time, &self.torque, -lag)
    }

    /// `n` [rad/s² or m/s²] for this lag [s] and this `c`.
    fn errors(&self, lag: f64, c: f64) -> Vec<f64> {
        self.acceleration.iter().zip(self.torque_after(lag)).map(|(a, tau)| a - c * tau).collect()
    }
}

/// Uninterrupted runs of samples, each longer than what its ends lose to the wide kernel.
fn runs(sampling: &Sampling, parts: &[Range<usize>]) -> Vec<Range<usize>> {
    let long = |run: &Range<usize>| run.len() as f64 * sampling.median > 4.0 * BAND[1];
    let even: Vec<_> = parts.iter().flat_map(|part| sampling.even_runs(part.clone())).filter(long).collect();
    if !even.is_empty() {
        return even;
    }
    parts.iter().flat_map(|part| sampling.within(part)).filter(long).collect()
}

/// Errors of one joint's held-out transients without and with a lag [s] of the torque, relative to the acceleration: time and both errors of each run.
pub fn compared(training: &[Transients], held_out: &[Transients], lag: f64) -> Vec<[Vec<f64>; 3]> {
    let ratio = |lag: f64| {
        let (mut products, mut squares) = (0.0, 0.0);
        for one in training {
            for (a, tau) in one.acceleration.iter().zip(one.torque_after(lag)) {
                products += a * tau;
                squares += tau * tau;
            }
        }
        products / f64::max(squares, 1e-300)
    };
    let ratios = [ratio(0.0), ratio(lag)];
    let of_run = |one: &Transients| {
        let rms = root_mean_square(&one.acceleration).max(1e-300);
        let relative = |errors: Vec<f64>| errors.into_iter().map(|e| e / rms).collect();
        [one.time.clone(), relative(one.errors(0.0, ratios[0])), relative(one.errors(lag, ratios[1]))]
    };
    held_out.iter().map(of_run).collect()
}

#[cfg(test)]
mod tests;
