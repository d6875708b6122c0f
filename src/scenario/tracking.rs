//! Tracking of a motion by the model-based controller: without compensation, with friction and gap as they were identified, and as they are.
//!
//! ```text
//!   ε = mean |q_l − q_d|                          q_l: link, q_d: reference; Table I of the paper
//!   V = Σ |i_k − i_{k−1}|                         total variation of the current
//!   A = max − min of motor and link at the end    the larger of both, over REST
//! ```
//! Feedback sees the motor's sensors alone. The link, the current without the noise of its sensor, and the motor's true position are of the
//! simulation, and judge it. The three runs have the same sensor noise.

use rayon::prelude::*;

use super::closed_loop::run_session;
use super::{Keep, Scenario, Session};
use crate::error::Result;
use crate::robot::{JointModel, Model};
use crate::timeseries::{Channel, Drawn, Envelope, JointSeries, TimeSeries};
use crate::units::JointKind;

/// [s] End of a tracking session over which the machine has to be at rest. A cycle of a controller with a bandwidth of 1 Hz shows in it.
const REST: f64 = 1.0;

/// [s] Rest of the reference that a tracking session needs at its end: twice as long, so that the motion can settle.
pub const TAIL: f64 = 2.0 * REST;

/// The motion that is tracked, and how gaps are crossed: `[compensation]` of a scenario file.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackingPlan {
    /// The motion.
    pub session: Session,
    /// [s] time in which a motor crosses its gap, > 0.
    pub crossing_time: f64,
}

/// Figures of one joint in one run. SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackingFigures {
    /// `ε` [rad or m].
    pub mean_error: f64,
    /// [rad or m] largest `|q_l − q_d|`.
    pub largest_error: f64,
    /// `V` [A].
    pub current_variation: f64,
    /// `A` [rad or m].
    pub rest_amplitude: f64,
}

/// One run of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackingRun {
    /// Its figures.
    pub figures: TrackingFigures,
    /// `q_l − q_d` [rad or m] over time, reduced for display.
    pub error: Envelope,
}

/// What is known of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// Neither friction nor gap.
    Nothing,
    /// Its friction.
    Friction,
    /// Its friction and its gap.
    FrictionAndGap,
}

impl Known {
    const fn of(joint: &JointModel) -> Self {
        match (joint.friction.is_some(), joint.backlash.is_some()) {
            (false, _) => Self::Nothing,
            (true, false) => Self::Friction,
            (true, true) => Self::FrictionAndGap,
        }
    }
}

/// The runs of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointTracking {
    /// Its name.
    pub joint: String,
    /// Turning or sliding.
    pub kind: JointKind,
    /// What was identified, and is compensated.
    pub known: Known,
    /// Without compensation.
    pub without: TrackingRun,
    /// With what was identified.
    pub with: TrackingRun,
    /// With the true friction and gap.
    pub exact: TrackingRun,
}

impl JointTracking {
    /// [%] by which compensation reduces `ε`.
    pub fn reduction_percent(&self) -> f64 {
        self.reduction(&self.with)
    }

    /// [%] of the reduction with the true parameters that the identified ones reach.
    pub fn share_percent(&self) -> f64 {
        100.0 * self.reduction_percent() / self.reduction(&self.exact)
    }

    /// [%] by which compensation enlarges `V`.
    pub fn variation_percent(&self) -> f64 {
        let variation = |run: &TrackingRun| run.figures.current_variation;
        100.0 * (variation(&self.with) / variation(&self.without) - 1.0)
    }

    fn reduction(&self, run: &TrackingRun) -> f64 {
        100.0 * (1.0 - run.figures.mean_error / self.without.figures.mean_error)
    }
}

/// The runs of all joints that the motion moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracking {
    /// The joints in the order of the model.
    pub joints: Vec<JointTracking>,
    /// The runs reduced for display: without compensation, and with what was identified.
    pub drawn: Vec<Drawn>,
}

impl Scenario {
    /// Tracks the plan's motion three times; `identified` is the model with what was identified.
    ///
    /// # Errors
    /// The simulated motion diverges.
    pub(super) fn track(&self, plan: &TrackingPlan, identified: &Model, seed: u64) -> Result<Tracking> {
        let seed = seed.wrapping_add((self.sessions.len() as u64) << 32);
        let known = [None, Some(identified), Some(self.truth.machine())];
        let runs = known
            .into_par_iter()
            .map(|known| {
                let known = known.map(|known| (known, plan.crossing_time));
                run_session(self, &plan.session, Keep::Everything, seed, known, &mut |_| {})
            })
            .collect::<Result<Vec<_>>>()?;
        let judged = |joint: usize| {
            let run = |run: usize| TrackingRun::of(&runs[run].0, &runs[run].0.joints[joint]);
            let one = &self.model.joints[joint];
            Some(JointTracking {
                joint: one.name.clone(),
                kind: one.kind,
                known: Known::of(&identified.joints[joint]),
                without: run(0)?,
                with: run(1)?,
                exact: run(2)?,
            })
        };
        let tracks = plan.session.profile.tracks().iter().enumerate();
        let joints = tracks.filter(|(_, track)| track.way() > 0.0).filter_map(|(joint, _)| judged(joint)).collect();
        let names = ["without compensation", "with compensation"];
        let named =
            |(run, name): ((TimeSeries, Drawn, _), &str)| Drawn { name: format!("{}, {name}", run.1.name), ..run.1 };
        Ok(Tracking { joints, drawn: runs.into_iter().zip(names).map(named).collect() })
    }
}

impl TrackingRun {
    /// A joint's run; `None` if a channel is missing.
    fn of(series: &TimeSeries, joint: &JointSeries) -> Option<Self> {
        let link = joint.get(Channel::TrueLinkPosition)?;
        let reference = joint.get(Channel::ReferencePosition)?;
        let current = joint.get(Channel::TrueCurrent)?;
        let motor = joint.get(Channel::TrueMotorPosition)?;
        let error: Vec<f64> = link.iter().zip(reference).map(|(link, reference)| link - reference).collect();
        let magnitudes = || error.iter().map(|error| error.abs());
        let rest = series.time.partition_point(|time| *time < series.time.last().unwrap_or(&0.0) - REST);
        let figures = TrackingFigures {
            mean_error: magnitudes().sum::<f64>() / error.len() as f64,
            largest_error: magnitudes().fold(0.0, f64::max),
            current_variation: current.windows(2).map(|two| (two[1] - two[0]).abs()).sum(),
            rest_amplitude: span(&link[rest..]).max(span(&motor[rest..])),
        };
        Some(Self { figures, error: Envelope::of(&series.time, error.iter().copied()) })
    }
}

/// Largest minus smallest value.
fn span(values: &[f64]) -> f64 {
    let [low, high] =
        values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)]);
    high - low
}
