//! Composes robot, controller, reference and sensors into a run.
//!
//! ```text
//!   Profile ──► Regulator ──► Plant ──► TimeSeries        one tick a control period:
//!                  ▲            │                          read the sensors, command currents, advance the machine
//!                  └── Reading ─┘
//! ```
//! A [`Scenario`] is the content of a scenario file; [`simulate`] runs it, [`closed_loop`] is the loop itself, for whoever
//! brings a machine, a reference and a [`Regulator`] of their own. [`Scenario::carry_out`] does with the recordings what the
//! scenario asks for.

mod closed_loop;
mod contact;
mod cost;
mod design;
mod expect;
mod expect_diagnosis;
mod findings;
mod procedure;
mod ranges;
mod read;
mod read_controller;
mod read_obstacles;
mod read_reference;
mod record;
mod recorded;
mod regulator;
mod truth;

pub use closed_loop::{Timing, closed_loop, simulate, simulate_keeping};
pub use contact::{Contact, ContactExpectation, UnmetContact};
pub use cost::{Cost, Limits, STEPS_A_SECOND};
pub use design::{Budget, DECIDES, Design, Prediction, Question, Trial, design};
pub use expect::{Expectation, Unmet};
pub use expect_diagnosis::{DiagnosisExpectation, EffectFigure, UnmetDiagnosis};
pub use findings::{Findings, channels, reference_name};
pub use procedure::{Conclusion, Found, Identified, Procedure};
pub use record::{Keep, Recorder};
pub use recorded::Recorded;
pub use regulator::{ControllerSettings, Feedback, Law, Regulator};
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

/// [s] Interval at which a planned motion is looked at; between two looks it is taken as straight.
const PLAN_INTERVAL: f64 = 0.01;

/// Looks at a planned motion at a time.
const PLAN_PIECE: f64 = 10_000.0;

/// One recording of a scenario: the machine starts anew, at rest on its reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// Its name, which its time series bears.
    pub name: String,
    /// What the joints are to do.
    pub profile: Profile,
    /// [s] how long is recorded.
    pub duration: f64,
    /// Line and key of the scenario file in which it stands.
    pub place: (Place, String),
}

/// A scenario: who moves, how, under which eyes, and what is expected.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// Its name.
    pub name: String,
    /// The question that it answers.
    pub question: String,
    /// Its file; what errors call it.
    pub source: PathBuf,
    /// The machine as its user describes it before anything was measured: what procedures are given.
    pub model: Model,
    /// The machine that is simulated: never given to a procedure.
    pub truth: Truth,
    /// How it is simulated. The seed in it is `seed`'s.
    pub options: Options,
    /// Seed of the sensors' noise where none is given on the command line.
    pub seed: u64,
    /// [s] between two readings, and between two commands, > 0.
    pub control_period: f64,
    /// The controller of every joint.
    pub controller: ControllerSettings,
    /// The recordings, in order.
    pub sessions: Vec<Session>,
    /// What is done with them.
    pub procedure: Procedure,
    /// What must come out of an identification.
    pub expectations: Vec<Expectation>,
    /// What must come out of a diagnosis.
    pub diagnosis_expectation: DiagnosisExpectation,
    /// What must be met on the way.
    pub contact_expectations: Vec<ContactExpectation>,
    /// What a run of it may cost.
    pub limits: Limits,
}

/// What a simulated scenario leaves behind.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The recordings, one a session: what the machine's sensors said, and beside it the truth in the channels that a
    /// simulation alone has, as far as they were to be kept.
    pub sessions: Vec<TimeSeries>,
    /// How each session is drawn, with the truth.
    pub drawn: Vec<Drawn>,
    /// What was touched, one list a session.
    pub contacts: Vec<Vec<Contact>>,
}

impl Run {
    /// The recordings as a real machine would have made them: without the truth. They share their samples with the run.
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
    /// Refuses a motion that leaves the joints' limits, lets links collide with each other, or starts with a link inside an
    /// obstacle. What it meets on its way it is meant to meet.
    ///
    /// # Errors
    /// The first time at which it happens, and to whom.
    pub fn check_motion(&self) -> Result<()> {
        let mut check = MotionCheck::new(&self.model.robot)?;
        let mut targets = vec![Target::default(); self.model.joints.len()];
        for session in &self.sessions {
            // Piece by piece, each from the end of the one before: a long session takes no more memory than a short one.
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
        for session in &self.sessions {
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
