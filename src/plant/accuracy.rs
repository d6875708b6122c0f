//! How error is traded against speed: the longest steps of the gears' motion, and how long an answer of the engine is used.

use super::{Evaluations, Options};

/// Longest step times the fastest oscillation of the gears: the phase of Runge-Kutta 4 then lags by `(ωh)⁵/120 = 1.5e-4` rad per step.
const FINE_STEP: f64 = 0.45;

/// The same where a hundredth of a degree is enough: an oscillation loses `(ωh)⁶/72`, 4 % of its energy, and lags by 0.02 rad in a step. Its
/// amplitude is the wind-up of a gear, some 1e-4 rad. Runge-Kutta 4 is stable up to 2.8.
const COARSE_STEP: f64 = 1.2;

/// [rad/s² or m/s²] An extrapolation that is right: 1e-4 at the end of a millisecond are 2e-8 rad/s of velocity.
const FINE_SURPRISE: f64 = 1e-4;

/// The same where a hundredth of a degree is enough, 2e-4 rad: 1e-2 during the 20 ms in which a controller notices are 2e-6 rad.
const COARSE_SURPRISE: f64 = 1e-2;

/// [s] Longest time between two evaluations of the links while nothing happens: a period of the fastest motion that a slow arm is given.
const LONGEST_INTERVAL: f64 = 0.02;

/// [s] Longest time between two answers of rapier, with which the built-in algorithms agree to rounding.
const FINE_CONFIRMATION: f64 = 0.02;

/// The same where a hundredth of a degree is enough.
const COARSE_CONFIRMATION: f64 = 0.1;

/// How exact a simulation is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Accuracy {
    /// 1e-4 degrees.
    #[default]
    Fine,
    /// 1e-2 degrees: steps may be longer, and the links are evaluated less often while nothing happens.
    Coarse,
}

impl Accuracy {
    /// Longest step times the fastest oscillation of the gears.
    pub(super) fn longest_step(self) -> f64 {
        match self {
            Self::Fine => FINE_STEP,
            Self::Coarse => COARSE_STEP,
        }
    }

    /// [s] Longest time between two answers of an engine that agrees with the built-in algorithms.
    pub(super) fn confirmation(self) -> f64 {
        match self {
            Self::Fine => FINE_CONFIRMATION,
            Self::Coarse => COARSE_CONFIRMATION,
        }
    }

    /// [rad/s² or m/s²] Largest error of an extrapolation that is right.
    pub(super) fn no_surprise(self) -> f64 {
        match self {
            Self::Fine => FINE_SURPRISE,
            Self::Coarse => COARSE_SURPRISE,
        }
    }
}

/// Share of the surprise allowed at which the next interval may be twice as long: the error of a cubic then grows by `2⁴`.
const CALM_SHARE: f64 = 1.0 / 16.0;

/// Coriolis torques change by `c (|v| + δv) δv` where a velocity has changed by `δv`; this times the inertia is the largest `c` of usual arms.
const CORIOLIS: f64 = 4.0;

/// A stretch of time in which nothing happens: the links are not evaluated until it is over.
///
/// It lasts twice as long as the one before if that ended without a surprise, at most [`LONGEST_INTERVAL`]. A change of mode or of a
/// velocity ends it.
pub(super) struct Lull {
    allowed: f64,
    /// [s] its length, and its end.
    length: f64,
    end: f64,
    /// Events before it, and velocities at its start.
    events: usize,
    velocities: Vec<f64>,
}

impl Lull {
    /// For so many joints; there is none with fine accuracy, or where every interval is to have its evaluation.
    pub fn new(joints: usize, options: &Options) -> Self {
        let wanted = options.accuracy == Accuracy::Coarse && options.evaluations == Evaluations::AsNeeded;
        let allowed = if wanted { options.accuracy.no_surprise() } else { 0.0 };
        Self { allowed, length: 0.0, end: f64::NEG_INFINITY, events: 0, velocities: vec![0.0; joints] }
    }

    /// Ends it.
    pub fn stop(&mut self) {
        (self.length, self.end) = (0.0, f64::NEG_INFINITY);
    }

    /// Whether it goes on at a time that has been reached.
    pub fn lasts(&self, time: f64, events: usize, velocities: impl Iterator<Item = f64>) -> bool {
        // Times are sums of intervals: rounding must not add one.
        if time >= self.end - 1e-9 || events != self.events {
            return false;
        }
        let (mut fastest, mut change) = (0.0_f64, 0.0_f64);
        for (velocity, before) in velocities.zip(&self.velocities) {
            fastest = fastest.max(velocity.abs());
            change = change.max((velocity - before).abs());
        }
        CORIOLIS * (fastest + change) * change <= self.allowed
    }

    /// Begins the next one where the links were evaluated, at the end of an interval and with this surprise.
    pub fn begin(
        &mut self,
        [start, time]: [f64; 2],
        surprise: f64,
        events: usize,
        velocities: impl Iterator<Item = f64>,
    ) {
        let interval = time - start;
        let calm = self.allowed > 0.0 && surprise <= CALM_SHARE * self.allowed && events == self.events;
        self.length = if calm { (2.0 * self.length).min(LONGEST_INTERVAL).max(interval) } else { interval };
        (self.end, self.events) = (time + self.length, events);
        self.velocities.iter_mut().zip(velocities).for_each(|(before, velocity)| *before = velocity);
    }
}
