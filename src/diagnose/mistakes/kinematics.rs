//! Position against velocity: over a time interval the position changes by the integral of the velocity, `Δq = b ∫ v dt`, `b = 1`.
//!
//! Low-pass filters, quantisation and noise of either channel keep `b` within some percent of one. A wrong unit, sign or time base
//! makes it −1, π/180, π/30, the gear ratio or a power of ten, which is far away in logarithm. `b = √(Σ Δq² / Σ (∫ v dt)²)` with the sign of
//! the correlation, so that noise of one channel does not bias it alone. If one channel is late, the correlation peaks at that lag.
//!
//! A low-pass also makes a velocity follow its position, but it rounds the motion: `∫ v dt` then correlates with the change of the position behind
//! the same low-pass better than with that of the position some time ago. Position and velocity of a joint come from one encoder through one
//! drive, which delays both; so a velocity that is late as a whole was recorded by another clock.

use crate::effects::velocity_lag::LONGEST_LAG;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};

/// Number of intervals of a session.
const STRETCHES: usize = 200;
/// Least number of samples in an interval.
const SHORTEST: usize = 10;
/// [counts] Range of a joint in a session below which its ratio is not judged: a velocity from counts is outdated where the joint stops between two of
/// them, and its integral is too large by up to three counts at every stop.
const FEWEST_COUNTS: f64 = 50.0;
/// Correlation of `Δq` and `∫ v dt` below which their ratio is not judged: they share 64 % of their squares.
const CORRELATED: f64 = 0.8;
/// A ratio above this factor, or below its inverse, is not caused by a filter.
pub const FAR: f64 = 1.5;
/// [s] Lag of one channel above which no transport delay explains it: `sensor_delay` ends at 0.1 s.
pub const LATE: f64 = 0.14;
/// [s] Lag above which no low-pass of a velocity explains it either: `velocity_lag` ends there.
pub const LATE_VELOCITY: f64 = LONGEST_LAG;
/// [s] Largest lag that is tried.
const LONGEST: f64 = 0.5;
/// Number of lags that are tried in each direction.
const STEPS: i32 = 20;

/// Ratio and lag between velocity and position of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratio {
    /// `b`, with its sign.
    pub ratio: f64,
    /// [1] Correlation of both, with its sign.
    pub correlation: f64,
    /// [s] Delay of the velocity relative to the position.
    pub lag: f64,
    /// Correlation at that lag.
    pub at_lag: f64,
}

impl Ratio {
    /// Whether the two agree.
    pub fn agrees(&self) -> bool {
        self.at_lag > CORRELATED && self.ratio.abs().ln().abs() < FAR.ln()
    }
}

/// Correlation of `∫ v dt` with the change of the position behind the low-pass that fits best.
pub fn behind_low_pass(model: &Model, joint: usize, sessions: &[&TimeSeries], channel: Channel) -> f64 {
    let name = &model.joints[joint].name;
    let behind = |time_constant: f64| {
        let mut sums = [0.0; 3];
        for session in sessions {
            let Some(series) = session.joint(name) else { continue };
            let (Some(q), Some(v)) = (series.get(Channel::Position), series.get(channel)) else { continue };
            let q = low_passed(&session.time, q, time_constant);
            if let Some(stretches) = Stretches::new(&session.time, &q, v) {
                stretches.add(&mut sums, 0.0);
            }
        }
        correlation(sums)
    };
    (1..=STEPS).map(|k| behind(f64::from(k) * LONGEST / f64::from(STEPS))).fold(0.0, f64::max)
}

/// `τ ẏ + y = x`, for an input that holds its value between samples; it starts at rest.
fn low_passed(time: &[f64], signal: &[f64], time_constant: f64) -> Vec<f64> {
    let mut passed = signal.to_vec();
    for k in 1..signal.len() {
        let share = -(-(time[k] - time[k - 1]) / time_constant).exp_m1();
        passed[k] = passed[k - 1] + share * (signal[k] - passed[k - 1]);
    }
    passed
}

/// Correlation of `Σ Δq²`, `Σ Δq V`, `Σ V²` [1].
fn correlation([qq, qv, vv]: [f64; 3]) -> f64 {
    if qq > 0.0 && vv > 0.0 { qv / (qq * vv).sqrt() } else { 0.0 }
}

/// Range of a position in its smallest changes from sample to sample; zero for a joint at rest.
fn counts(q: &[f64]) -> f64 {
    let changes = q.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|change| *change > 0.0);
    let [lowest, highest] = [f64::min, f64::max].map(|of| q.iter().copied().reduce(of).unwrap_or(0.0));
    (highest - lowest) / changes.fold(f64::INFINITY, f64::min)
}

/// Ratio of a joint over all sessions, for one velocity channel; `None` where the channels are not correlated.
pub fn ratio(model: &Model, joint: usize, sessions: &[&TimeSeries], channel: Channel) -> Option<Ratio> {
    let name = &model.joints[joint].name;
    let stretches: Vec<Stretches> = sessions
        .iter()
        .filter_map(|session| {
            let series = session.joint(name)?;
            Stretches::new(&session.time, series.get(Channel::Position)?, series.get(channel)?)
        })
        .collect();
    let sums = |lag: f64| {
        let mut sums = [0.0; 3];
        stretches.iter().for_each(|one| one.add(&mut sums, lag));
        sums
    };
    let here = sums(0.0);
    let step = LONGEST / f64::from(STEPS);
    let (lag, at_lag) = (-STEPS..=STEPS)
        .map(|k| f64::from(k) * step)
        .map(|lag| (lag, correlation(sums(lag))))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()).then(b.0.abs().total_cmp(&a.0.abs())))?;
    let best = if at_lag.abs() > correlation(here).abs() { sums(lag) } else { here };
    (at_lag.abs() > CORRELATED).then(|| Ratio {
        ratio: (best[0] / best[2]).sqrt().copysign(at_lag),
        correlation: correlation(here),
        lag,
        at_lag,
    })
}

/// Position and integral of the velocity of one session.
struct Stretches<'a> {
    time: &'a [f64],
    q: &'a [f64],
    integral: Vec<f64>,
    length: usize,
}

impl<'a> Stretches<'a> {
    /// `None` where the session is too short, or hardly moves the joint.
    fn new(time: &'a [f64], q: &'a [f64], v: &[f64]) -> Option<Self> {
        let length = (time.len() / STRETCHES).max(SHORTEST);
        if time.len() < 4 * length || counts(q) < FEWEST_COUNTS {
            return None;
        }
        let mut integral = vec![0.0; time.len()];
        for k in 1..time.len() {
            integral[k] = integral[k - 1] + 0.5 * (v[k] + v[k - 1]) * (time[k] - time[k - 1]);
        }
        Some(Self { time, q, integral, length })
    }

    /// Integral of the velocity at a time within the session, interpolated.
    fn integral_at(&self, t: f64) -> f64 {
        let next = self.time.partition_point(|x| *x < t).clamp(1, self.time.len() - 1);
        let (from, to) = (self.time[next - 1], self.time[next]);
        self.integral[next - 1] + (t - from) / (to - from) * (self.integral[next] - self.integral[next - 1])
    }

    /// Adds `Σ Δq²`, `Σ Δq V`, `Σ V²` of the stretches, the velocity read `lag` [s] later.
    fn add(&self, sums: &mut [f64; 3], lag: f64) {
        let (n, last) = (self.time.len(), self.time.len() - 1);
        let at = |k: usize| {
            let t = self.time[k] + lag;
            let inside = (self.time[0]..=self.time[last]).contains(&t);
            inside.then(|| self.integral_at(t))
        };
        for start in (0..n - self.length).step_by(self.length) {
            if let (Some(from), Some(to)) = (at(start), at(start + self.length)) {
                let (dq, dv) = (self.q[start + self.length] - self.q[start], to - from);
                sums[0] += dq * dq;
                sums[1] += dq * dv;
                sums[2] += dv * dv;
            }
        }
    }
}
