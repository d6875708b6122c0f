//! Search for effects at the reversals of a joint: every effect is tried from all its starting points, the best are refined, and an effect that
//! explains rows that were not used for its fit is named.

use super::TurnRules;
use super::attempt::{Planted, Setting, TurnFit};
use super::judge::TurnLikelihood;
use super::path::Path;
use super::turn_rows::TurnRows;
use crate::diagnose::fit::problem::{Part, Problem};
use crate::diagnose::fit::regression::Solution;
use crate::diagnose::residuals::gains;
use crate::diagnose::rows::reversals::rests;
use crate::effects::{AtTurns, Trial, Turns};
use crate::replay::Gain;
use crate::robot::TorqueAt;
use crate::timeseries::TimeSeries;
use crate::timeseries::side_by_side;

/// Starting values of an unknown gap, in counts of the encoder.
const GAPS: [f64; 5] = [0.0, 4.0, 8.0, 14.0, 22.0];
/// Starting values of the link share.
const SHARES: [f64; 2] = [0.15, 0.4];
/// Relative difference allowed between the gap and that of the model file.
const KNOWN: f64 = 0.25;
/// Size relative to the trial below which the effect counts as absent.
const LEAST_PART: f64 = 0.1;
/// Largest factor on the size of a trial.
const MOST_PARTS: f64 = 3.0;
/// [standard errors] Half the width of an interval of 95 %.
const INTERVAL: f64 = 1.96;
/// [nats, rows taken as independent] Gain of a trial in training below which it is not refined.
const LEAST_GAIN: f64 = 15.0;
/// Largest number of starting points that are refined: gap, link share and effect depend on each other, and one start may end in a local maximum.
const STARTS: usize = 3;
/// Gain relative to the best one that a further starting point needs.
const LEAST_OF_BEST: f64 = 0.5;

/// The result for one effect at a joint's reversals.
#[derive(Clone)]
pub struct TurnCandidate {
    /// The effect.
    pub effect: &'static dyn AtTurns,
    /// Index of the joint.
    pub joint: usize,
    /// Its parameters with standard errors.
    pub values: Vec<[f64; 2]>,
    /// [nats] Gain of likelihood by cross-validation within the training data, reduced for the choice of starting points.
    pub folds: f64,
    /// Logarithm of the ratio of error scales, without the effect over with it.
    pub log_scale: f64,
    /// Gain in the torque error on held-out rows around reversals.
    pub gain: Gain,
}

impl TurnCandidate {
    /// [nats] Evidence for the effect, minus its reserve.
    pub fn total(&self) -> f64 {
        self.folds - self.effect.reserve()
    }

    fn accepted(&self, rules: &TurnRules) -> bool {
        let falls = self.log_scale > rules.log_scale.max(self.effect.least_fall());
        self.total() > rules.nats && falls && self.is_there()
    }

    /// Whether the interval of every [size](crate::effects::ParameterSpec::is_size) of the effect excludes zero.
    fn is_there(&self) -> bool {
        let mut sizes = self.effect.about().parameters.iter().zip(&self.values).filter(|(spec, _)| spec.is_size);
        sizes.all(|(_, [value, std_error])| value.abs() > INTERVAL * std_error)
    }
}

/// All results by decreasing evidence; the first one of a joint explains it, and the others are its rivals.
pub fn candidates(problem: &Problem, sessions: &[&TimeSeries], residuals: &[Vec<f64>]) -> Vec<TurnCandidate> {
    let joints: Vec<usize> = (0..residuals.len()).collect();
    let of_joint = |joint: &usize| of_joint(problem, *joint, sessions, &residuals[*joint]);
    let mut found: Vec<TurnCandidate> = side_by_side(&joints, held(problem), of_joint).into_iter().flatten().collect();
    found.sort_by(|a, b| b.total().total_cmp(&a.total()));
    found
}

/// [bytes] Memory of a joint while one effect is tried: six signals of the path, and three of the gear that is simulated along it.
fn held(problem: &Problem) -> usize {
    72 * Path::instants(&problem.motion)
}

fn of_joint(problem: &Problem, joint: usize, sessions: &[&TimeSeries], residual: &[f64]) -> Vec<TurnCandidate> {
    let model = &problem.motion.model.joints[joint];
    let (count, gap) = (model.encoder_step(), model.backlash);
    // A sensor behind the gear does not see the rotor reverse.
    if count <= 0.0 || model.torque_at == TorqueAt::Link {
        return Vec::new();
    }
    let largest = gap.map_or(GAPS[GAPS.len() - 1] * count, |gap| 1.5 * gap);
    let channel = TurnRows::new(problem, joint, sessions, residual, largest);
    if channel.part(Part::Train).len() < TurnRules::FEWEST || channel.part(Part::HeldOut).is_empty() {
        return Vec::new();
    }
    let Some(nominal) = nominal(&channel, gap, count) else { return Vec::new() };
    let turns =
        Turns { motion: &problem.motion, joint, gap: nominal.setting.gap, rests: rests(&problem.motion, joint) };
    let Some(nominal) = Predicted::of(&channel, nominal) else { return Vec::new() };
    let effects: Vec<&'static dyn AtTurns> =
        problem.catalogue.at_turns().filter(|effect| effect.applies(&turns)).collect();
    let of_effect = |effect: &&'static dyn AtTurns| {
        let (starts, tried) = best_trials(&channel, &nominal.fit, *effect, &turns);
        let fits = starts.iter().filter_map(|setting| channel.fitted(setting));
        let fit = fits.max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))?;
        let values = &fit.setting.planted.first()?.values;
        if !effect.visible(&turns, values) {
            return None;
        }
        let plain = without_claim(&channel, &fit, effect.without_claim(&turns, values));
        let before =
            plain.as_ref().filter(|plain| plain.likelihood.folds > nominal.likelihood.folds).unwrap_or(&nominal);
        judged(&channel, before, &Predicted::of(&channel, fit)?, tried)
    };
    side_by_side(&effects, held(problem), of_effect).into_iter().flatten().collect()
}

/// Gears to start from; a gap from the model file stays close to its value.
fn starts(gap: Option<f64>, count: f64) -> Vec<Setting> {
    let gaps: Vec<f64> = gap.map_or(GAPS.map(|gap| gap * count).to_vec(), |gap| vec![gap]);
    let within = gap.map_or([0.0, f64::INFINITY], |gap| [(1.0 - KNOWN) * gap, (1.0 + KNOWN) * gap]);
    let pairs = gaps.iter().flat_map(|gap| SHARES.iter().map(|share| (*gap, *share)));
    pairs.map(|(gap, share)| Setting { gap, share, within, planted: Vec::new() }).collect()
}

/// The gear without effects.
fn nominal(channel: &TurnRows, gap: Option<f64>, count: f64) -> Option<TurnFit> {
    let best = starts(gap, count)
        .into_iter()
        .filter_map(|setting| Some((channel.likelihood(&setting)?, setting)))
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    channel.fitted(&best.1)
}

/// The best starting points of an effect, and their number.
fn best_trials(
    channel: &TurnRows,
    nominal: &TurnFit,
    effect: &'static dyn AtTurns,
    turns: &Turns,
) -> (Vec<Setting>, usize) {
    let trials = effect.trials(turns);
    let tried = trials.len();
    let given = turns.motion.model.joints[turns.joint].backlash;
    let mut good: Vec<(f64, Setting)> = Vec::new();
    for trial in trials {
        let proportional = trial.proportional;
        // An effect proportional to a parameter starts from the fit without it. For any other effect, gap and share of that fit may already
        // imitate the effect, so it starts from all gears.
        let starts = if proportional {
            vec![nominal.setting.clone()]
        } else {
            starts(given, turns.motion.model.joints[turns.joint].encoder_step())
        };
        for mut setting in starts {
            setting.planted.push(Planted::new(effect, trial.clone()));
            let Some([lack, _]) = channel.simulate(&setting) else { continue };
            let (base, further): (_, Vec<Vec<f64>>) = if proportional {
                let change = lack.iter().zip(&nominal.lack).map(|(with, without)| with - without).collect();
                (&nominal.lack, std::iter::once(change).chain(nominal.columns.iter().cloned()).collect())
            } else {
                (&lack, nominal.columns.clone())
            };
            let Some(solution) = channel.fit(Part::Train, base, &further) else { continue };
            let gained = solution.log_likelihood[0] - nominal.log_likelihood;
            let part = if proportional { solution.coefficients[0] } else { 1.0 };
            if part < LEAST_PART || gained < LEAST_GAIN {
                continue;
            }
            setting.planted[0].values[0] *= part.min(MOST_PARTS);
            good.push((gained, setting));
        }
    }
    good.sort_by(|a, b| b.0.total_cmp(&a.0));
    let enough = good.first().map_or(0.0, |(most, _)| LEAST_OF_BEST * most);
    let starts = good.into_iter().filter(|(gained, _)| *gained >= enough).take(STARTS);
    (starts.map(|(_, setting)| setting).collect(), tried)
}

/// A fit and its predictions.
struct Predicted {
    fit: TurnFit,
    likelihood: TurnLikelihood,
    solution: Solution,
}

impl Predicted {
    fn of(channel: &TurnRows, fit: TurnFit) -> Option<Self> {
        let (likelihood, solution) = channel.predict(&fit)?;
        Some(Self { fit, likelihood, solution })
    }
}

/// The best fit of an effect [without its claim](AtTurns::without_claim), in the gear of a fit with it.
fn without_claim(channel: &TurnRows, fit: &TurnFit, trials: Vec<Trial>) -> Option<Predicted> {
    let effect = fit.setting.planted.first()?.effect;
    let fits = trials.into_iter().filter_map(|trial| {
        channel.fitted(&Setting { planted: vec![Planted::new(effect, trial)], ..fit.setting.clone() })
    });
    Predicted::of(channel, fits.max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))?)
}

/// What speaks for an effect, `after` it was installed, against a fit `before`.
fn judged(channel: &TurnRows, before: &Predicted, after: &Predicted, tried: usize) -> Option<TurnCandidate> {
    let planted = after.fit.setting.planted.first()?;
    // Take the number of independent rows from the richer model: an effect that is left out makes correlated errors.
    let independence = after.likelihood.independence;
    let variances = channel.variances(&after.fit, &after.solution, independence)?;
    let values = planted
        .values
        .iter()
        .zip(&planted.scales)
        .enumerate()
        .map(|(k, (value, scale))| [*value, variances[2 + k].max(0.0).sqrt().hypot(TurnRules::SYSTEMATIC * scale)]);
    let held_out = channel.part(Part::HeldOut);
    let errors = |one: &Predicted| {
        channel.system(&held_out, &one.fit.lack, &one.fit.columns).blocks[0].residual(&one.solution.coefficients)
    };
    let rows: Vec<usize> = held_out.iter().map(|index| channel.rows[*index]).collect();
    let gain = gains::of_rows(&channel.problem.motion, &rows, [&errors(before), &errors(after)]);
    Some(TurnCandidate {
        effect: planted.effect,
        joint: channel.joint,
        values: values.collect(),
        folds: independence * (after.likelihood.folds - before.likelihood.folds) - (tried as f64).ln(),
        log_scale: (before.likelihood.scale / after.likelihood.scale).ln(),
        gain,
    })
}

/// The results that are named: the strongest of each joint, and the same effect on other joints with enough evidence of their own.
pub fn named(found: &[TurnCandidate], rules: &TurnRules) -> Vec<TurnCandidate> {
    let strongest = |joint: usize| found.iter().find(|candidate| candidate.joint == joint);
    found
        .iter()
        .filter(|candidate| candidate.accepted(rules))
        .filter(|candidate| {
            strongest(candidate.joint).is_some_and(|best| best.effect.name() == candidate.effect.name())
        })
        .cloned()
        .collect()
}
