//! Throws: abrupt displacements of a rotor, window by window.
//!
//! ```text
//!   D(t) = 2T²/(h₊ + h₋) ((θ(t+h₊) − θ(t))/h₊ − (θ(t) − θ(t−h₋))/h₋)        h₊, h₋: the times of samples nearest to T
//!   by the motor alone 0 … τ T²/J, rotor alone;   e = excess of D beyond this range · h₊ h₋/T²
//! ```
//! `D` is the second difference `θ(t+T) − 2θ(t) + θ(t−T)` where samples lie at even times; elsewhere it contains no velocity either, and the last
//! factor makes one encoder count worth the same everywhere.
//!
//! What is ordinary is told by the other windows of the same session. The `K` largest of them lie above the next one, `r`, by `β` in the mean. Windows
//! beyond a throw `e > r` have, with an exponential tail whose `β` is known from `K` windows only, the share
//!
//! ```text
//!   p(e) = (K + 1)/N · (1 + (e − r)/(K β))^(−K)
//! ```
//! Throws are whole counts, nearly: with a mean excess of `m` counts, and one more window counted with an excess of one, `β = 1/ln(1 + 1/(m + 1/K))` counts.
//! Reference: S. Coles (2001), An Introduction to Statistical Modeling of Extreme Values, ch. 4 (peaks over a threshold).

use std::ops::Range;

use crate::diagnose::rows::sampling::Sampling;
use crate::diagnose::rows::signals::motor_torque;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};

/// `T` [s].
const STEP: f64 = 8e-3;
/// [steps] Largest difference of `h₊` and `h₋` from `T`: the nearest sample is half a step off, or one step where steps are twice as long.
const ASTRAY: f64 = 0.9;
/// [s] Largest distance between throws of one slip.
pub const TOGETHER: f64 = 0.03;
/// [s] Time before and after a throw that belongs to it: rotor and controller oscillate.
const AROUND: [f64; 2] = [0.05, 0.5];
/// [s] At the start of a session: drives are switched on and links settle, in every session at the same time.
const SETTLED: f64 = 1.0;
/// `K` Windows that tell the tail: enough that `β` is known to a quarter, and 1 in 33 of a session of 40 s.
const TAIL: usize = 20;

/// The throws of a joint in one session.
pub struct Throws {
    /// [s] Since the start of the session.
    time: Vec<f64>,
    /// `e` [rad or m] of each sample; positive beyond what the motor can do.
    excess: Vec<f64>,
    /// [rad or m] One count of the encoder on the joint side.
    count: f64,
}

/// The largest throw of each other window, in descending order.
pub struct Ordinary {
    throws: Vec<f64>,
    count: f64,
}

impl Throws {
    /// In parts of a session; `None` where the recording does not tell.
    pub fn of(model: &Model, joint: usize, session: &TimeSeries, parts: &[Range<usize>]) -> Option<Self> {
        let rotor = model.joints[joint].reflected_inertia();
        let count = model.joints[joint].encoder_step();
        let dt = session.sample_interval();
        let series = session.joint(&model.joints[joint].name)?;
        let q = series.get(Channel::Position)?;
        let (torque, _) = motor_torque(model, joint, series, series.get(Channel::Velocity))?;
        let lag = (STEP / dt).round();
        if !(1.0..q.len() as f64 / 4.0).contains(&lag) || rotor <= 0.0 || count <= 0.0 {
            return None;
        }
        let lag = lag as usize;
        let sampling = Sampling::new(&session.time, dt);
        let long = parts.iter().flat_map(|part| sampling.within(part)).filter(|piece| piece.len() >= 4 * lag);
        let bends = Bends { time: &session.time, q, torque: &torque, dt, step: lag as f64 * dt, rotor };
        let (time, excess) = long
            .flat_map(|part| bends.of(part))
            .map(|(k, e)| (session.time[k] - session.time[0], e))
            .filter(|(at, excess)| *at > SETTLED && excess.is_finite())
            .unzip();
        Some(Self { time, excess, count })
    }

    /// The largest throw within [`TOGETHER`] of a time, and when; `None` where nothing was recorded.
    pub fn near(&self, time: f64) -> Option<(f64, f64)> {
        let (first, last) = (self.at(time - TOGETHER), self.at(time + TOGETHER));
        let largest = (first..last).max_by(|a, b| self.excess[*a].total_cmp(&self.excess[*b]))?;
        Some((self.time[largest], self.excess[largest]))
    }

    /// When the largest throw is, outside the times around some others.
    pub fn largest(&self, outside: &[f64]) -> Option<f64> {
        let free = (0..self.time.len()).filter(|k| !outside.iter().any(|time| belongs(self.time[*k], *time)));
        free.max_by(|a, b| self.excess[*a].total_cmp(&self.excess[*b])).map(|k| self.time[k])
    }

    /// What is ordinary away from a time and from some others; `None` where too little was recorded to tell.
    pub fn ordinary(&self, time: f64, outside: &[f64]) -> Option<Ordinary> {
        let mut windows: Vec<(usize, f64)> = Vec::new();
        let away =
            |at: f64| !belongs(at, time) && !belongs(time, at) && !outside.iter().any(|other| belongs(at, *other));
        for (at, excess) in self.time.iter().zip(&self.excess).filter(|(at, _)| away(**at)) {
            let window = (at / (2.0 * TOGETHER)) as usize;
            match windows.last_mut() {
                Some((last, largest)) if *last == window => *largest = largest.max(*excess),
                _ => windows.push((window, *excess)),
            }
        }
        (windows.len() > 2 * TAIL)
            .then(|| Ordinary::of(windows.into_iter().map(|(_, largest)| largest).collect(), self.count))
    }

    fn at(&self, time: f64) -> usize {
        self.time.partition_point(|other| *other < time)
    }
}

impl Ordinary {
    /// Of more than `2 K` windows, by an encoder with this count [rad or m].
    pub fn of(mut throws: Vec<f64>, count: f64) -> Self {
        throws.sort_by(|a, b| b.total_cmp(a));
        Self { throws, count }
    }

    /// `N`
    pub fn windows(&self) -> usize {
        self.throws.len()
    }

    /// `p(e)`: share of windows with a larger throw, above 0 and at most 1.
    pub fn share_beyond(&self, throw: f64) -> f64 {
        let windows = self.windows() as f64;
        let beyond = self.throws[TAIL];
        if throw <= beyond {
            let larger = self.throws.partition_point(|other| *other >= throw);
            return (larger + 1) as f64 / (windows + 1.0);
        }
        let tail = TAIL as f64;
        let mean = self.throws[..TAIL].iter().map(|throw| throw - beyond).sum::<f64>() / (tail * self.count);
        let decay = self.count / (1.0 + 1.0 / (mean + 1.0 / tail)).ln();
        let share = (tail + 1.0) / windows * (1.0 + (throw - beyond) / (tail * decay)).powi(-(TAIL as i32));
        share.max(f64::MIN_POSITIVE)
    }

    /// The throw that a share of the windows exceeds, not below zero.
    pub fn exceeded_by(&self, share: f64) -> f64 {
        let at = (share * self.throws.len() as f64) as usize;
        self.throws[at.min(self.throws.len() - 1)].max(0.0)
    }
}

/// Whether a throw belongs to one at a time.
fn belongs(throw: f64, time: f64) -> bool {
    throw > time - AROUND[0] && throw < time + AROUND[1]
}

/// Displacements of a rotor, sample by sample.
struct Bends<'s> {
    time: &'s [f64],
    q: &'s [f64],
    torque: &'s [f64],
    /// [s] Median step.
    dt: f64,
    /// `T` [s].
    step: f64,
    rotor: f64,
}

impl Bends<'_> {
    /// Samples of an uninterrupted part, with `e` [rad or m].
    fn of(&self, part: Range<usize>) -> Vec<(usize, f64)> {
        let Self { time, torque, dt, step, .. } = *self;
        let mut found = Vec::new();
        let (mut before, mut after, mut sum) = (part.start, part.start, torque[part.start]);
        let fits = |h: f64| (h - step).abs() < ASTRAY * dt;
        for k in part.clone() {
            while time[before] < time[k] - step - 0.5 * dt {
                sum -= torque[before];
                before += 1;
            }
            while after + 1 < part.end && time[after] < time[k] + step - 0.5 * dt {
                after += 1;
                sum += torque[after];
            }
            let h = [time[after] - time[k], time[k] - time[before]];
            if h.into_iter().all(fits) {
                found.push((k, self.excess([before, k, after], h, sum / (after - before + 1) as f64)));
            }
        }
        found
    }

    /// `e` from three samples, `[h₊, h₋]` apart, and the mean torque between them.
    fn excess(&self, [before, k, after]: [usize; 3], [ahead, behind]: [f64; 2], torque: f64) -> f64 {
        let (q, square) = (self.q, self.step * self.step);
        let driven = torque / self.rotor * square;
        let slopes = (q[after] - q[k]) / ahead - (q[k] - q[before]) / behind;
        let bent = 2.0 * square / (ahead + behind) * slopes;
        (bent - driven.max(0.0)).max(driven.min(0.0) - bent) * (ahead * behind / square)
    }
}
