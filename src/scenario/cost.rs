//! Cost of a run, computed before memory of its size is allocated.
//!
//! ```text
//!   samples = Σ (⌊T/Δ⌋ + 1)         T [s] of a session, Δ control period
//!   memory  = 8 B · samples · n · (13 + 6 + w)      n joints: channels recorded, measured ones copied, w words to work with
//!   steps   = n · Σ T · rate + looks · (n + p/20)   rate [1/s] of Runge-Kutta steps; looks at the planned motion, p pairs of shapes each
//! ```
//! All in f64: a number that is too large to count is infinite, and above every limit.

use std::fmt;

use super::{PLAN_INTERVAL, Procedure, Scenario, Session};
use crate::dynamics::STEP;
use crate::error::{Error, Result};
use crate::plant::Plant;

/// Channels of a joint that are recorded, and those of them that its own drive would record.
const CHANNELS: f64 = 13.0 + 6.0;

/// [words per sample and joint] Additional memory of procedures and files at their peak. Measured at 400,000 samples of
/// six joints: 156 B per sample and joint without a procedure, 163 B with an identification, 310 B with a diagnosis or
/// a CSV. A diagnosis of a recording of that size needs 176 B itself.
const fn work(procedure: Procedure) -> f64 {
    match procedure {
        Procedure::None => 2.0,
        Procedure::Identify | Procedure::Compensate => 4.0,
        Procedure::Diagnose => 24.0,
    }
}

/// [1/s] Predicted steps times joints that one core computes in a second; the least value that was measured. With
/// torques of a few hertz, the machines of the catalogue have: emps 0.85e6, elbow 0.50e6, scara 0.66e6, sixaxis 0.77e6,
/// kr300 3.2e6, chain12 0.65e6.
pub const STEPS_A_SECOND: f64 = 5e5;

/// Limits of the cost of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// [B] of memory, > 0.
    pub memory: f64,
    /// Steps times joints, > 0.
    pub steps: f64,
}

impl Default for Limits {
    /// 4 GB, and the steps of one core in an hour.
    fn default() -> Self {
        Self { memory: 4e9, steps: 3600.0 * STEPS_A_SECOND }
    }
}

/// Cost of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Number of recordings.
    pub sessions: usize,
    /// [s] simulated.
    pub duration: f64,
    /// Samples per channel.
    pub samples: f64,
    /// [B] approximate memory at its peak.
    pub memory: f64,
    /// Steps times joints.
    pub steps: f64,
}

impl fmt::Display for Cost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.sessions == 1 { "" } else { "s" };
        let (duration, samples) = (grouped(self.duration), grouped(self.samples));
        write!(f, "{} session{plural}, {duration} s, {samples} samples, {}", self.sessions, Bytes(self.memory))
    }
}

/// A size of memory with its unit.
struct Bytes(f64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            size if size < 5e7 => write!(f, "{:.0} MB", (size / 1e6).ceil()),
            size if size < 1e10 => write!(f, "{:.1} GB", size / 1e9),
            size => write!(f, "{} GB", grouped((size / 1e9).ceil())),
        }
    }
}

/// A whole number with commas between its thousands.
fn grouped(value: f64) -> String {
    let digits = format!("{:.0}", value.round());
    let mut out = String::new();
    for (at, digit) in digits.char_indices() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A time with its unit.
fn lasting(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} minutes", s / 60.0),
        s if s < 172_800.0 => format!("{:.0} hours", s / 3600.0),
        s => format!("{} days", grouped(s / 86_400.0)),
    }
}

impl Scenario {
    /// The cost of a run.
    ///
    /// # Errors
    /// The machine cannot be built: an effect does not fit, a gear is too fast.
    pub fn cost(&self) -> Result<Cost> {
        let costs = self.costs()?;
        let sum = |of: fn(&Cost) -> f64| costs.iter().map(of).sum();
        Ok(Cost {
            sessions: costs.len(),
            duration: sum(|cost| cost.duration),
            samples: sum(|cost| cost.samples),
            memory: sum(|cost| cost.memory),
            steps: sum(|cost| cost.steps),
        })
    }

    /// As [`cost`](Self::cost), and refuses a cost above the scenario's limits.
    ///
    /// # Errors
    /// Names the session with the largest cost, and what would fit.
    pub fn affordable(&self) -> Result<Cost> {
        let cost = self.cost()?;
        let Limits { memory, steps } = self.limits;
        if cost.memory <= memory && cost.steps <= steps {
            return Ok(cost);
        }
        let longest = self.motions().max_by(|a, b| a.duration.total_cmp(&b.duration));
        let (place, key) = longest.map_or_else(|| (crate::error::Place::File, String::new()), |one| one.place.clone());
        let expected = if cost.memory > memory {
            let fits = cost.duration * memory / cost.memory;
            format!(
                "at most {}, which {} at this control period take; shorten it, or allow more with --max-memory {}",
                Bytes(memory),
                lasting(fits),
                Bytes(1.1 * cost.memory).to_string().replace([' ', ','], "")
            )
        } else {
            let (takes, allowed) = (cost.steps / STEPS_A_SECOND, steps / STEPS_A_SECOND);
            let minutes = (1.1 * takes / 60.0).ceil();
            format!(
                "at most {} of computing, not {}; shorten it, take softer gears or a longer plant.step, or allow more with \
                 --max-time {minutes}",
                lasting(allowed),
                lasting(takes)
            )
        };
        Err(Error::input(&self.source, place, key, cost, expected))
    }

    /// All checks of a run before its simulation: whether the machine can be built, whether the cost is within the
    /// limits, whether the motion is possible.
    ///
    /// # Errors
    /// The first that fails.
    pub fn check(&self) -> Result<Cost> {
        let cost = self.affordable()?;
        self.check_motion()?;
        Ok(cost)
    }

    fn costs(&self) -> Result<Vec<Cost>> {
        let joints = self.model.joints.len() as f64;
        let robot = &self.model.robot;
        let shapes = robot.base_shapes.len() + robot.bodies.iter().map(|body| body.shapes.len()).sum::<usize>();
        let pairs = 0.5 * (shapes * shapes) as f64;
        let mut bare = None;
        let cost = |session: &Session| {
            let model = self.truth.machine().in_session(&session.name);
            let loaded = self.model.loads.iter().any(|load| load.session == session.name);
            let rate = match bare {
                Some(rate) if !loaded => rate,
                _ => Plant::new(&model, &self.options)?.step_rate(self.control_period),
            };
            if !loaded {
                bare = Some(rate);
            }
            let Session { profile, duration, .. } = session;
            let samples = (duration / self.control_period + 1e-9).floor() + 1.0;
            let looks = duration / PLAN_INTERVAL + profile.way() / STEP;
            let looks = looks * (joints + pairs / 20.0);
            let memory = 8.0 * samples * (joints * (CHANNELS + work(self.procedure)) + 2.0);
            Ok(Cost { sessions: 1, duration: *duration, samples, memory, steps: joints * duration * rate + looks })
        };
        // A tracked motion is simulated three times.
        let tracked = self.tracking.iter().flat_map(|plan| [&plan.session; 3]);
        self.sessions.iter().chain(tracked).map(cost).collect()
    }
}
