//! How probable a recording is under a model: a filter carries the simulated machine along it and scores every sample.
//!
//! ```text
//!   ln p(readings | currents, model) = Σ_jk ln p(reading of joint j at sample k | all readings before)        [nat]
//! ```
//! Everything that the simulation has, this judges: motion in the gap, reversals, rest. Two models differ by the evidence of the recording itself,
//! without a threshold, and the distance from what an exact model reaches is what remains unexplained.
//! [`score`] scores a model; [`fit_baseline`] and [`fit`](fit()) fit the parameters of a [`Hypothesis`] first. The equations are at the head of `filter`.

mod count;
mod covariance;
mod filter;
mod fit;
mod gears;
mod hypothesis;
mod objective;
mod parameters;
mod points;
mod recording;
mod search;
mod subject;
mod uneven;

pub use fit::{Fitted, fit, fit_baseline, from_better_gears, most_probable, refine, without};
pub use gears::{Gear, SOFT_GEAR, STIFFNESS, SoughtGear, hardly_soft, seek_gears};
pub use hypothesis::{Free, Hypothesis, Scale, Start};
pub use recording::Recording;
pub use uneven::{ORDERS, UNEVEN_GAP, UnevenGap, seek_uneven_gaps};

use filter::{Outcome, Run, Scored};
use rayon::prelude::*;
use subject::{Setup, Subject};

use crate::effects::Catalogue;
use crate::error::Result;
use crate::robot::Model;

/// How recordings are scored, and how far a fit is driven.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// [s] At the start of a recording, not scored: there the state is not known yet.
    pub burn_in: f64,
    /// `ε` [1] Share of readings that may be outliers.
    pub outliers: f64,
    /// `η` [1] Share of outliers that may be anywhere in the recorded range; 0: none. As rare among outliers as these among readings.
    pub anywhere: f64,
    /// [1] Noise of the torque on a link, as a share of that on its rotor.
    pub link_noise: f64,
    /// Most steps of a fit between two searches of its gaps.
    pub steps: usize,
    /// Searches of the gaps and sizes, each finer than the one before; at most two.
    pub rounds: usize,
    /// [nat] What a hypothesis has to gain over the baseline by searches along single lines, for all its parameters to be fitted; −∞: always.
    pub hopeful: f64,
    /// Effects that a model may have.
    pub catalogue: Catalogue,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            burn_in: 2.0,
            outliers: 1e-3,
            anywhere: 1e-3,
            link_noise: 0.3,
            steps: 10,
            rounds: 2,
            hopeful: f64::NEG_INFINITY,
            catalogue: Catalogue::default(),
        }
    }
}

/// The score of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    /// Name of the session.
    pub name: String,
    /// [nat] Sum of the readings that are scored ([`Recording::first_scored`]), one per joint.
    pub nats: Vec<f64>,
    /// Number of these readings, one per joint.
    pub readings: Vec<usize>,
    /// [s] Sample times since the start of the session.
    pub time: Vec<f64>,
    /// One per joint.
    pub joints: Vec<JointScore>,
}

/// The score of a joint, sample by sample, from the start of the recording.
#[derive(Debug, Clone, PartialEq)]
pub struct JointScore {
    /// `ℓ` [nat].
    pub nats: Vec<f64>,
    /// [1] Probability, predicted, of a lower reading than that which came.
    pub below: Vec<f64>,
    /// [1] Predicted probability of the count that came; 0 where positions are not counts.
    pub inside: Vec<f64>,
    /// [N·m or N] Torque beside the model's that the rotor would have needed. It is late by the time that an encoder needs to show a torque.
    pub missing: Vec<f64>,
}

impl Score {
    /// [nat] a reading.
    pub fn mean(&self) -> f64 {
        self.sum() / self.readings.iter().sum::<usize>().max(1) as f64
    }

    /// [nat] of all joints together.
    pub fn sum(&self) -> f64 {
        self.nats.iter().sum()
    }
}

/// Scores recordings under a model that misses a torque of `e^λ` times the noise by its current sensors; `lambda`: one per joint, −1.5 for an exact model.
///
/// # Errors
/// The model's effects do not fit, or the machine is too fast to be simulated.
pub fn score(model: &Model, recordings: &[Recording], lambda: &[f64], settings: &Settings) -> Result<Vec<Score>> {
    let setup = Setup { model: model.clone(), weight: 0.0, offsets: vec![0.0; model.joints.len()] };
    scored(&setup, recordings, lambda, settings)
}

/// Scores recordings under a setup.
fn scored(setup: &Setup, recordings: &[Recording], lambda: &[f64], settings: &Settings) -> Result<Vec<Score>> {
    let one = |recording: &Recording| -> Result<Score> {
        let outcome = run(setup, recording, lambda, settings, true)?;
        let name = recording.name.clone();
        let joints = outcome.scored.iter().map(|scored| joint_score(scored)).collect();
        Ok(Score { name, nats: outcome.nats, readings: outcome.readings, time: recording.time.clone(), joints })
    };
    recordings.par_iter().map(one).collect()
}

/// Carries a setup along a recording; with `keep` it records what each reading said.
fn run(setup: &Setup, recording: &Recording, lambda: &[f64], settings: &Settings, keep: bool) -> Result<Outcome> {
    let subject = || Subject::new(setup, recording, settings);
    Ok(Run::new(recording, settings, [subject()?, subject()?], Vec::new(), lambda).go(keep))
}

fn joint_score(scored: &[Scored]) -> JointScore {
    let all = |value: fn(&Scored) -> f64| scored.iter().map(value).collect();
    JointScore {
        nats: all(|one| one.said.nats),
        below: all(|one| one.said.below),
        inside: all(|one| one.said.inside),
        missing: all(|one| one.missing),
    }
}
