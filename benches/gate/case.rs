//! One machine: the regression gives friction and gap, the baseline and every rival are fitted to the same windows, and windows that took no part decide.

use std::time::Instant;

use lostmotion::diagnose::judge::starts;
use lostmotion::diagnose::{Options, diagnose};
use lostmotion::error::Result;
use lostmotion::likelihood::{Fitted, Recording, Score, Settings, fit, fit_baseline};
use lostmotion::robot::Model;
use lostmotion::timeseries::{Estimate, TimeSeries};
use rayon::prelude::*;

use super::lines;

/// [s] Windows for training in the staircase and in each of two fast runs, and for judging in the staircase and the third run; the burn-in is within.
const SLOW: [f64; 2] = [20.0, 30.0];
const FAST: [f64; 2] = [3.0, 11.0];
const SLOW_JUDGED: [f64; 2] = [50.0, 60.0];
const FAST_JUDGED: [f64; 2] = [3.0, 15.0];
/// Lines of a joint from which a periodic disturbance is sought.
const LINES: usize = 2;

/// How a rival did.
pub struct Rival {
    pub name: String,
    /// [nat] Gain over the baseline on the training windows and on those held out.
    pub train: f64,
    pub held_out: f64,
    pub lambda: Vec<f64>,
    pub steps: usize,
    pub sizes: Vec<(String, Estimate)>,
    pub seconds: f64,
}

/// What became of a machine.
pub struct Case {
    pub name: String,
    /// Effects that were hidden, each with its joint.
    pub hidden: Vec<String>,
    /// What the regression names first.
    pub named: Option<String>,
    pub baseline: Fitted,
    /// [nat] a sample, held out, of the baseline, and of the true machine where it is known.
    pub unexplained: f64,
    pub floor: Option<f64>,
    /// Best first.
    pub rivals: Vec<Rival>,
    /// [s] of the regression, and of everything after it.
    pub seconds: [f64; 2],
}

/// A machine as the gate is given it.
pub struct Given {
    pub name: String,
    pub hidden: Vec<String>,
    pub nominal: Model,
    /// The machine that moved, for the floor alone.
    pub truth: Option<Model>,
    /// Staircase and three fast runs.
    pub sessions: Vec<TimeSeries>,
}

impl Case {
    pub fn new(given: Given, effects: &[String]) -> Result<Self> {
        let start = Instant::now();
        let Given { name, hidden, nominal, truth, sessions } = given;
        let found = diagnose(&nominal, &sessions[..3], &sessions[3..], &Options::default(), &mut |_, _| {})?;
        let named = found.effects.first().map(|effect| effect.effect.clone());
        let model = found.baseline_model;
        let regression = start.elapsed().as_secs_f64();
        let settings = Settings::default();
        let window = |session: usize, [from, to]: [f64; 2]| -> Result<Recording> {
            Ok(Recording::new(&model, &sessions[session])?.window(from, to))
        };
        let train = [window(0, SLOW)?, window(1, FAST)?, window(2, FAST)?];
        let judged = [window(0, SLOW_JUDGED)?, window(3, FAST_JUDGED)?];
        let baseline = fit_baseline(&model, &train, &settings)?;
        let before = baseline.score(&judged, &settings)?;
        let missing = baseline.score(&train[1..], &settings)?;
        let lines: Vec<Vec<f64>> =
            (0..model.joints.len()).map(|joint| lines::strongest(&missing, joint, LINES)).collect();
        let hypotheses = effects.iter().flat_map(|effect| starts::of(effect, &model, &lines)).collect::<Vec<_>>();
        let rival = |hypothesis: &lostmotion::likelihood::Hypothesis| -> Result<Rival> {
            let start = Instant::now();
            let fitted = fit(hypothesis, &baseline, &train, &settings)?;
            let after = fitted.score(&judged, &settings)?;
            let own = |(name, _): &&(String, Estimate)| effects.iter().any(|effect| name.contains(effect.as_str()));
            Ok(Rival {
                name: fitted.name.clone(),
                train: fitted.nats - baseline.nats,
                held_out: sum(&after) - sum(&before),
                lambda: fitted.lambda.clone(),
                steps: fitted.steps,
                sizes: fitted.estimates.iter().filter(own).cloned().collect(),
                seconds: start.elapsed().as_secs_f64(),
            })
        };
        let mut rivals: Vec<Rival> = hypotheses.par_iter().map(rival).collect::<Result<_>>()?;
        rivals.sort_by(|a, b| b.held_out.total_cmp(&a.held_out));
        let exact = vec![-1.5; model.joints.len()];
        let floor =
            |truth: &Model| lostmotion::likelihood::score(truth, &judged, &exact, &settings).map(|of| mean(&of));
        Ok(Self {
            name,
            hidden,
            named,
            unexplained: mean(&before),
            floor: truth.as_ref().map(floor).transpose()?,
            baseline,
            rivals,
            seconds: [regression, start.elapsed().as_secs_f64() - regression],
        })
    }

    /// The rival that gains most, where it gains more than this.
    pub fn first(&self, nats: f64) -> Option<&Rival> {
        self.rivals.first().filter(|one| one.held_out > nats)
    }

    /// Whether a rival is one of what was hidden.
    pub fn is_hidden(&self, rival: &Rival) -> bool {
        let effect = rival.name.split(' ').next().unwrap_or_default();
        self.hidden.iter().any(|hidden| hidden.split(' ').next() == Some(effect))
    }
}

fn sum(scores: &[Score]) -> f64 {
    scores.iter().map(Score::sum).sum()
}

/// [nat] a sample and joint.
fn mean(scores: &[Score]) -> f64 {
    let readings: usize = scores.iter().flat_map(|score| &score.readings).sum();
    sum(scores) / readings.max(1) as f64
}
