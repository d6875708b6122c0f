//! Composes robot, controller, reference and sensors into a run.
//!
//! ```text
//!   Profile ──► Regulator ──► Plant ──► TimeSeries        one tick per control period:
//!                  ▲            │                          read the sensors, command currents, advance the machine
//!                  └── Reading ─┘
//! ```
//! A [`Scenario`] is the content of a scenario file; [`simulate`] runs it. [`closed_loop`] is the loop itself, for
//! users with their own machine, reference and [`Regulator`]. [`Scenario::carry_out`] carries out the scenario's procedure on the
//! recordings.

mod closed_loop;
mod contact;
mod cost;
mod design;
mod expect;
mod expect_diagnosis;
mod expect_tracking;
mod findings;
mod first_experiment;
mod known_gears;
mod measure;
mod procedure;
mod ranges;
mod reach;
mod read;
mod read_added_mass;
mod read_compensation;
mod read_controller;
mod read_obstacles;
mod read_reference;
mod read_speeds;
mod record;
mod recorded;
mod regulator;
mod rehearsal;
mod tracking;
mod trial;
mod truth;

pub use closed_loop::{Timing, closed_loop, simulate, simulate_keeping};
pub use contact::{Contact, ContactExpectation, UnmetContact};
pub use cost::{Cost, Limits, STEPS_A_SECOND};
pub use design::{Budget, DECIDES, Design, Forecast, Question, TriedExperiment, design};
pub use expect::{Expectation, Unmet};
pub use expect_diagnosis::{DiagnosisExpectation, EffectFigure, UnmetDiagnosis};
pub use expect_tracking::{TRACKING_QUANTITIES, TrackingExpectation, UnmetTracking};
pub use findings::{Findings, channels, reference_name};
pub use first_experiment::{FirstExperiment, first_experiment};
pub use measure::{ExpectedErrors, Measurands, Measurement, PlannedJoint, measurement};
pub use procedure::{Compensated, Conclusion, Found, Identified, Procedure};
pub use record::{Keep, Recorder};
pub use recorded::Recorded;
pub use regulator::{ControllerSettings, Feedback, Law, Regulator};
pub use tracking::{JointTracking, Known, Tracking, TrackingFigures, TrackingPlan, TrackingRun};
pub use trial::{Trial, trial};
pub use truth::Truth;

use std::path::PathBuf;

use crate::control::{Profile, Target};
use crate::dynamics::MotionCheck;
use crate::error::{Error, Place, Result};
use crate::plant::{Options, Plant};
use crate::robot::Model;
use crate::timeseries::{Drawn, JointSeries, TimeSeries};

/// The schema of a scenario file.
const SCHEMA: &str = "lostmotion/scenario/1";

/// [s] Interval at which a planned motion is checked; in between it is taken as straight.
const PLAN_INTERVAL: f64 = 0.01;

/// Number of samples of a planned motion that are checked at a time.
const PLAN_PIECE: f64 = 10_000.0;

/// One recording of a scenario: the machine starts anew, at rest on its reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// Its name, which is also that of its time series.
    pub name: String,
    /// The reference of the joints.
    pub profile: Profile,
    /// [s] Length of the recording.
    pub duration: f64,
    /// Its line and key in the scenario file.
    pub place: (Place, String),
}

/// A scenario: machine, motion, sensors and expectations.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// Its name.
    pub name: String,
    /// The question that it answers.
    pub question: String,
    /// Its file, as errors name it.
    pub source: PathBuf,
    /// The machine as its user describes it before any measurement; procedures get this model.
    pub model: Model,
    /// The machine that is simulated; procedures never get it.
    pub truth: Truth,
    /// Options of the simulation. Its seed is taken from `seed`.
    pub options: Options,
    /// Seed of the sensors' noise if none is given on the command line.
    pub seed: u64,
    /// [s] between two readings, and between two commands, > 0.
    pub control_period: f64,
    /// The controller of every joint.
    pub controller: ControllerSettings,
    /// The recordings, in order.
    pub sessions: Vec<Session>,
    /// What is done with them.
    pub procedure: Procedure,
    /// The motion that is tracked with and without compensation.
    pub tracking: Option<TrackingPlan>,
    /// Expectations about the identification.
    pub expectations: Vec<Expectation>,
    /// Expectations about the diagnosis.
    pub diagnosis_expectation: DiagnosisExpectation,
    /// Expectations about contacts.
    pub contact_expectations: Vec<ContactExpectation>,
    /// Expectations about tracking.
    pub tracking_expectations: Vec<TrackingExpectation>,
    /// Limits of the cost of a run.
    pub limits: Limits,
}

/// Result of a simulated scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The recordings, one per session: sensor readings, and the truth in the channels that only a simulation has, as
    /// far as they are kept.
    pub sessions: Vec<TimeSeries>,
    /// Each session reduced for display, with the truth.
    pub drawn: Vec<Drawn>,
    /// Contacts, one list per session.
    pub contacts: Vec<Vec<Contact>>,
    /// Seed of the sensors' noise.
    pub seed: u64,
}

impl Run {
    /// The recordings of a real machine: without the truth. They share their samples with the run.
    pub fn measured(&self) -> Vec<TimeSeries> {
        let seen = |joint: &JointSeries| JointSeries {
            name: joint.name.clone(),
            channels: (joint.channels.iter())
                .filter(|(channel, _)| !record::TRUTH.contains(channel))
                .map(|(channel, samples)| (*channel, samples.clone()))
                .collect(),
        };
        let session = |session: &TimeSeries| TimeSeries {
            name: session.name.clone(),
            time: session.time.clone(),
            joints: session.joints.iter().map(seen).collect(),
        };
        self.sessions.iter().map(session).collect()
    }
}

impl Scenario {
    /// All motions of the machine: the recordings, then the motion that is tracked.
    fn motions(&self) -> impl Iterator<Item = &Session> {
        self.sessions.iter().chain(self.tracking.iter().map(|plan| &plan.session))
    }

    /// Refuses a motion that leaves the joints' limits, lets links collide with each other, or starts with a link
    /// inside an obstacle. Contacts with obstacles along the way are intended.
    ///
    /// # Errors
    /// The first fault: its time, and the joints or links.
    pub fn check_motion(&self) -> Result<()> {
        let mut check = MotionCheck::new(&self.model.robot)?;
        let mut targets = vec![Target::default(); self.model.joints.len()];
        for session in self.motions() {
            // Piece by piece, each from the end of the one before: a long session needs no more memory than a short
            // one.
            let last = (session.duration / PLAN_INTERVAL).ceil();
            let mut first = 0.0;
            while first < last {
                let samples = (last - first).min(PLAN_PIECE) as usize + 1;
                let time = |k: usize| ((first + k as f64) * PLAN_INTERVAL).min(session.duration);
                let times: Vec<f64> = (0..samples).map(time).collect();
                let mut paths = vec![Vec::with_capacity(samples); targets.len()];
                for &time in &times {
                    session.profile.sample(time, &mut targets);
                    for (path, target) in paths.iter_mut().zip(&targets) {
                        path.push(target.position);
                    }
                }
                let paths: Vec<&[f64]> = paths.iter().map(Vec::as_slice).collect();
                check.check(&times, &paths)?;
                first += PLAN_PIECE;
            }
        }
        if self.options.obstacles.is_empty() { Ok(()) } else { self.check_starts() }
    }

    fn check_starts(&self) -> Result<()> {
        let mut plant = Plant::new(self.truth.machine(), &self.options)?;
        for session in self.motions() {
            plant.place(&session.profile.start());
            if let Some((touch, obstacle)) = plant.touches().find_map(|touch| Some((touch, touch.obstacle?))) {
                let link = &self.model.robot.bodies[touch.body].name;
                let expected = format!("a place clear of {link} where {} starts", session.name);
                let key = format!("obstacles.{}", self.options.obstacles[obstacle].shape.link);
                return Err(Error::input(&self.source, Place::File, key, "", expected));
            }
        }
        Ok(())
    }
}
