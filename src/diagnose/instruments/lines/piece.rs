//! Samples of a joint that show fast torque: those of a session where the joint keeps moving.
//!
//! At rest an encoder stays within a count and friction holds the joint; near a reversal the link crosses its gap. Elsewhere the counts pass so
//! quickly that the ripple of quantisation is above the frequencies of the lines. Each interval is weighted by a cosine at both ends, so
//! that the slow motion does not spread over the spectrum. Second differences over `h` remove most of the slow motion first;
//! they multiply a line by `H = −4 sin²(π f h)`, in position and torque. Where samples lie at uneven times, the difference from a mean in true time
//! does the same: `x − (⟨x⟩ − w²/14 ⟨ẍ⟩)` over a kernel of half width `w`, whose second moment is `w²/7`, with `H = 1 − (1 + (2π f w)²/14) K̂(2π f w)`.
//! Of a slow motion it leaves only the part that is due to the fourth derivative within `w`; sums over uneven times would spread a larger
//! rest over all frequencies. Each sample is weighted with the time that it stands for.

use nalgebra::{Complex, DMatrix};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

use crate::diagnose::rows::sampling::Sampling;
use crate::diagnose::rows::signals::motor_torque;
use crate::dynamics::Dynamics;
use crate::effects::kernel_gain;
use crate::robot::{Model, TorqueAt};
use crate::timeseries::{Channel, TimeSeries};

/// [s] Time on either side over which the speed is computed.
const SPEED_WIDTH: f64 = 0.03;
/// [1/s] Least rate of counts: below it the ripple of quantisation is among the lines.
const COUNTS: f64 = 150.0;
/// Share of a session's fastest motion below which the joint counts as slow.
const SLOW: f64 = 0.02;
/// [s] Time left out before and after slow motion, which includes reversals.
const AROUND: f64 = 0.1;
/// [s] Length of the cosine at the ends of an interval, and shortest interval.
const RISE: f64 = 0.1;
const SHORTEST: f64 = 0.3;
/// [s] Shortest run of samples in which an interval can remain.
pub const SHORTEST_RUN: f64 = 2.0 * AROUND + SHORTEST;
/// [s] `h`.
const DIFFERENCE: f64 = 2e-3;
/// [s] `w`: at 10 Hz, the lowest frequency of a line, `H` is 0.3; of a motion at 15 rad/s it leaves 0.2 %.
const WIDE: f64 = 0.06;
/// [s] Time between the postures of the arm that are used: it hardly changes its shape.
const BETWEEN: f64 = 0.05;
/// Most of them.
const PLACES: usize = 1000;
/// Counts within twice [`SPEED_WIDTH`] up to which a joint is at rest, held by dry friction.
const COUNTS_AT_REST: f64 = 1.5;

/// The posture of the arm at one sample.
pub struct Posture {
    /// `M` [kg·m², kg or kg·m] of the links.
    pub mass: DMatrix<f64>,
    /// Which joints move.
    pub moves: Vec<bool>,
}

/// Weighted second differences of position and torque of a joint, in one session or a part of it.
pub struct Piece {
    /// Whether it is held out.
    pub held_out: bool,
    /// [s] Time of its first sample since the start of the session.
    pub start: f64,
    /// [s] Time between samples; their median where times are uneven.
    pub dt: f64,
    /// Weight of each sample: 0 to 1, times the steps that it stands for.
    pub weight: Vec<f64>,
    /// `|θ̇|` [rad/s or m/s].
    pub speed: Vec<f64>,
    /// `w Δ²θ`.
    pub position: Vec<f64>,
    /// `w Δ²τ_m`.
    pub torque: Vec<f64>,
    /// The posture of the arm at some of its samples.
    pub places: Vec<Posture>,
    /// Steps between these.
    stride: usize,
    slow: Slow,
}

/// How the slow motion is removed.
enum Slow {
    /// By second differences over `h` [s].
    Differences(f64),
    /// By the difference from a mean; the times [s] of the samples since the start of the session.
    Means(Vec<f64>),
}

impl Piece {
    /// These samples of a session, at even times; `None` where a channel is missing or the joint hardly moves.
    pub fn new(model: &Model, joint: usize, session: &TimeSeries, part: Range<usize>, held_out: bool) -> Option<Self> {
        let (q, tau) = of_motor(model, joint, session)?;
        let dt = session.sample_interval();
        if dt.is_nan() || dt <= 0.0 {
            return None;
        }
        let Range { start: first, end: last } = part;
        let lag = ((DIFFERENCE / dt).round() as usize).max(1);
        let reach = ((SPEED_WIDTH / dt) as usize).max(1);
        let edge = reach.max(lag);
        if last < first + 2 * edge + 2 {
            return None;
        }
        let inner = first + edge..last - edge;
        let velocity: Vec<f64> =
            inner.clone().map(|k| (q[k + reach] - q[k - reach]) / (2.0 * reach as f64 * dt)).collect();
        let weight = weights(&velocity, model.joints[joint].encoder_step(), dt);
        let second = |x: &[f64]| -> Vec<f64> {
            inner.clone().zip(&weight).map(|(k, w)| w * (x[k + lag] - 2.0 * x[k] + x[k - lag])).collect()
        };
        let total: f64 = weight.iter().sum();
        let moves = weight.iter().any(|weight| *weight > 0.5);
        let (position, torque) = (second(q), second(&tau));
        let stride = stride(dt, inner.len());
        (total > 0.0 && moves).then(|| Self {
            held_out,
            start: session.time[inner.start] - session.time[0],
            dt,
            speed: velocity.iter().map(|v| v.abs()).collect(),
            position,
            torque,
            places: places(model, session, inner.step_by(stride), reach),
            stride,
            weight,
            slow: Slow::Differences(lag as f64 * dt),
        })
    }

    /// As [`new`](Self::new), for samples between pauses at uneven times.
    pub fn uneven(
        model: &Model,
        joint: usize,
        (session, sampling): (&TimeSeries, &Sampling),
        part: Range<usize>,
        held_out: bool,
    ) -> Option<Self> {
        let (q, tau) = of_motor(model, joint, session)?;
        let (time, dt) = (&session.time, sampling.median);
        let reach = ((SPEED_WIDTH / dt) as usize).max(1);
        let inner = sampling.inner(&part, WIDE.max(2.0 * reach as f64 * dt));
        // Where steps are long, fewer samples lie within the edge than the speed needs.
        let inner = inner.start.max(part.start + reach)..inner.end.min(part.end.saturating_sub(reach));
        if inner.is_empty() {
            return None;
        }
        let fast = |k: usize| {
            let window = sampling.around_time(time[k], WIDE)?;
            let of = |x: &[f64]| {
                let slow = window.averages(x);
                x[k] - slow.value + window.half_width().powi(2) / 14.0 * slow.curvature
            };
            Some((of(q), of(&tau)))
        };
        let fast: Option<(Vec<f64>, Vec<f64>)> = inner.clone().map(fast).collect();
        let (mut position, mut torque) = fast?;
        let speed = |k: usize| (q[k + reach] - q[k - reach]) / (time[k + reach] - time[k - reach]);
        let velocity: Vec<f64> = inner.clone().map(speed).collect();
        let mean = (time[inner.end - 1] - time[inner.start]) / inner.len() as f64;
        let mut weight = weights(&velocity, model.joints[joint].encoder_step(), mean);
        let moves = weight.iter().any(|weight| *weight > 0.5);
        let stride = stride(dt, inner.len());
        let stands_for = |k: usize| 0.5 * (time[k + 1] - time[k - 1]) / dt;
        inner.clone().zip(&mut weight).for_each(|(k, weight)| *weight *= stands_for(k));
        for signal in [&mut position, &mut torque] {
            signal.iter_mut().zip(&weight).for_each(|(x, weight)| *x *= weight);
        }
        moves.then(|| Self {
            held_out,
            start: time[inner.start] - time[0],
            dt,
            speed: velocity.iter().map(|v| v.abs()).collect(),
            position,
            torque,
            places: places(model, session, inner.clone().step_by(stride), reach),
            stride,
            weight,
            slow: Slow::Means(inner.map(|k| time[k] - time[0]).collect()),
        })
    }

    /// `H`.
    pub fn gain(&self, frequency: f64) -> f64 {
        match self.slow {
            Slow::Differences(h) => -4.0 * (PI * frequency * h).sin().powi(2),
            Slow::Means(_) => {
                let x = TAU * frequency * WIDE;
                1.0 - (1.0 + x * x / 14.0) * kernel_gain(x)
            }
        }
    }

    /// [s] Times of the samples since the start of the session, where they are uneven.
    pub fn uneven_times(&self) -> Option<&[f64]> {
        match &self.slow {
            Slow::Differences(_) => None,
            Slow::Means(times) => Some(times),
        }
    }

    /// [s] Time of a sample since the start of the session.
    pub fn time(&self, k: usize) -> f64 {
        self.uneven_times().map_or_else(|| self.start + k as f64 * self.dt, |times| times[k])
    }

    /// `Σ w`.
    pub fn total(&self) -> f64 {
        self.weight.iter().sum()
    }

    /// `Σ w R* (Δ²θ − R Δ²τ_m) e^{−iωt}` over the samples that `pick` selects, `t` since the start of the session, and their `Σ w |R|²`; `receptance`: `R` in
    /// each of the postures.
    pub fn matched(
        &self,
        frequency: f64,
        receptance: &[Complex<f64>],
        pick: &dyn Fn(usize) -> bool,
    ) -> (Complex<f64>, f64) {
        let (mut sum, mut total) = (Complex::default(), 0.0);
        let mut add = |k: usize, turn: Complex<f64>| {
            if self.weight[k] > 0.0 && pick(k) {
                let own = receptance[k / self.stride];
                sum += own.conj() * turn * (own * -self.torque[k] + self.position[k]);
                total += self.weight[k] * own.norm_sqr();
            }
        };
        if let Some(times) = self.uneven_times() {
            for (k, t) in times.iter().enumerate() {
                add(k, Complex::from_polar(1.0, -TAU * frequency * t));
            }
            return (sum, total);
        }
        let step = Complex::from_polar(1.0, -TAU * frequency * self.dt);
        let mut turn = Complex::from_polar(1.0, -TAU * frequency * self.start);
        for k in 0..self.weight.len() {
            add(k, turn);
            turn *= step;
        }
        (sum, total)
    }
}

/// Steps between the postures of so many samples.
fn stride(dt: f64, samples: usize) -> usize {
    ((BETWEEN / dt).round() as usize).max(samples.div_ceil(PLACES)).max(1)
}

/// 1 where the joint keeps moving, 0 where it is slow, with a cosine between them.
fn weights(velocity: &[f64], count: f64, dt: f64) -> Vec<f64> {
    let fastest = velocity.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let least = (COUNTS * count).max(SLOW * fastest);
    let samples = |time: f64| ((time / dt).round() as usize).max(1);
    let mut weight = vec![0.0; velocity.len()];
    let mut k = 0;
    while k < velocity.len() {
        let side = velocity[k].signum();
        let stretch = velocity[k..].iter().take_while(|v| v.abs() > least && v.signum() == side).count();
        let (from, to) = (k + samples(AROUND), (k + stretch).saturating_sub(samples(AROUND)));
        if to > from + samples(SHORTEST) {
            for (index, w) in weight[from..to].iter_mut().enumerate() {
                let inside = (index + 1).min(to - from - index) as f64 / samples(RISE) as f64;
                *w = 0.5 - 0.5 * (PI * inside.min(1.0)).cos();
            }
        }
        k += stretch.max(1);
    }
    weight
}

/// Position and torque of a motor. `None` where one is missing, or where the torque was measured behind the gear: the torque balance of the
/// rotor does not describe how ripple of motor and gear reaches the link.
fn of_motor<'s>(model: &Model, joint: usize, session: &'s TimeSeries) -> Option<(&'s [f64], Vec<f64>)> {
    let series =
        session.joint(&model.joints[joint].name).filter(|_| model.joints[joint].torque_at == TorqueAt::Motor)?;
    let position = series.get(Channel::Position)?;
    let (torque, _) = motor_torque(model, joint, series, series.get(Channel::Velocity))?;
    Some((position, torque))
}

/// The postures of the arm at these samples.
fn places(model: &Model, session: &TimeSeries, samples: impl Iterator<Item = usize>, half: usize) -> Vec<Posture> {
    let dof = model.joints.len();
    let mut dynamics = Dynamics::new(&model.robot);
    let mut mass = DMatrix::zeros(dof, dof);
    let positions: Vec<Option<&[f64]>> =
        model.joints.iter().map(|joint| session.joint(&joint.name).and_then(|s| s.get(Channel::Position))).collect();
    let place = |k: usize| {
        let q: Vec<f64> = positions.iter().map(|q| q.map_or(0.0, |q| q[k])).collect();
        dynamics.mass_matrix(&q, &mut mass);
        let passes = |(joint, q): (&crate::robot::JointModel, &Option<&[f64]>)| {
            q.is_some_and(|q| (q[k + half] - q[k - half]).abs() > COUNTS_AT_REST * joint.encoder_step())
        };
        Posture { mass: mass.clone(), moves: model.joints.iter().zip(&positions).map(passes).collect() }
    };
    samples.map(place).collect()
}

#[cfg(test)]
impl Piece {
    /// A piece of even weight whose position is that of a torque `d(t)` [N·m] in postures that yield by these `R`, each for the same time.
    pub fn of_torque(yielding: &[f64], samples: usize, dt: f64, d: &dyn Fn(f64) -> f64) -> Self {
        let stride = samples.div_ceil(yielding.len());
        // H of the differences is divided out by who uses the piece.
        let slow = Slow::Differences(DIFFERENCE);
        let position = (0..samples).map(|k| yielding[k / stride] * d(k as f64 * dt)).collect();
        Self {
            held_out: false,
            start: 0.0,
            dt,
            weight: vec![1.0; samples],
            speed: (0..samples).map(|k| 1.0 + (k % 100) as f64 / 50.0).collect(),
            position,
            torque: vec![0.0; samples],
            places: Vec::new(),
            stride,
            slow,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of the time the rotor yields against the torque, so that the plain sum of its positions is zero.
    #[test]
    fn recover_a_line_through_postures_that_yield_with_either_sign() {
        let (a, f, phase) = (0.07, 25.0, 0.4);
        let yielding = [2e-4, -2e-4, 1e-4, -1e-4];
        let piece = Piece::of_torque(&yielding, 8000, 1e-3, &|t| a * (TAU * f * t + phase).sin());
        let receptance = yielding.map(Complex::from);
        let (sum, total) = piece.matched(f, &receptance, &|_| true);
        let found = Complex::new(0.0, 2.0) * sum / total;
        // Whole periods in each posture: the mirrored line cancels to rounding.
        assert!((found - Complex::from_polar(a, phase)).norm() < 1e-9, "{found}");
        let plain = piece.matched(f, &[Complex::from(1.0); 4], &|_| true).0;
        assert!(plain.norm() < 1e-9 * a, "{plain}");
    }
}
