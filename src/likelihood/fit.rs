//! Fits the parameters of a hypothesis to recordings.
//!
//! ```text
//!   maximise  L(x, λ) − ½ Σ ρ x²           L: score of the training recordings [nat]
//!   (H + ρ + μ diag(H + ρ)) Δx = g − ρ x    g, H: gradient and information of the score (`filter`), μ: damping of Levenberg and Marquardt
//! ```
//! A gap is not stepped but searched along a line: where a flank is met, the derivative at the mean says little of a Gaussian that lies on both sides. Its error
//! follows from the curvature of the score, and from the derivative only how it goes with those of the other parameters.
//! The noise `λ` of each joint is fitted as well, first and between the steps: it begins large, where a wrong model leaves no track but a broad one, and falls
//! by itself as the model becomes better. What no parameter explains stays in it.
//! A hypothesis begins at the fit of the baseline or at the nominal values, with the most probable of its starts.
//! What is compared is the score of recordings that took no part in the fit: a parameter that only follows the noise loses there, whatever its prior.
//! References: K. Levenberg (1944), D. Marquardt (1963); S. Särkkä, L. Svensson (2023), Bayesian filtering and smoothing, section 16.3.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::gears::{self, Gear};
use super::hypothesis::{Hypothesis, Start};
use super::objective::{Fit, Slope};
use super::parameters::{self, NUMBERS, Parameter};
use super::recording::Recording;
use super::search::NOISE_TRIALS;
use super::subject::Setup;
use super::uneven::UnevenGap;
use super::{Score, Settings, scored, uneven};
use crate::error::Result;
use crate::robot::{EffectEntry, Model};
use crate::timeseries::Estimate;

/// Longest change of `x` in one step.
const LONGEST: f64 = 2.0;
/// Most trials of the damping in one step.
const MOST_TRIALS: usize = 3;
/// [nat] A step that gains less ends the fit.
const SMALL: f64 = 1.0;
/// `λ` where the baseline begins.
const NOISE_AT_FIRST: f64 = 3.0;
/// Least `λ` by which starts are compared and first refined: none of them is exact, and with less noise none would keep the track.
const NOISE_AT_STARTS: f64 = 1.0;
/// `λ` below which a joint misses nothing: a step above the least.
const NEARLY_EXACT: f64 = -1.0;
/// First steps of the searches of gaps, in `x`: 1.5 % of the gap, then less.
const GAP_STEPS: [f64; 2] = [0.1, 0.02];
/// Change of a gap, in `x`, by which the curvature of the score is taken: 0.3 %, of the amplitude of one that varies 0.2 % of its mean.
const CURVATURE_STEP: f64 = 0.02;
/// [1] Information of a direction of the bodies' values, in prior deviations, below which the motion does not show it.
const SHOWN: f64 = 0.1;
/// [s] Part of each recording by which that is decided.
const LOOK: f64 = 5.0;

/// A hypothesis with fitted parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// Name of the hypothesis.
    pub name: String,
    /// `λ` of each joint: the torque that the model misses is `e^λ` times the noise by the current sensor; at its least, −1.5, nothing is missed.
    pub lambda: Vec<f64>,
    /// [nat] Score of the training recordings, and of the prior beside it.
    pub nats: f64,
    /// See [`nats`](Self::nats); at most 0.
    pub prior: f64,
    /// Parameters by name, with the errors of their joint posterior.
    pub estimates: Vec<(String, Estimate)>,
    /// Steps that the fit took.
    pub steps: usize,
    model: Model,
    effects: Vec<EffectEntry>,
    parameters: Vec<Parameter>,
    x: Vec<f64>,
}

impl Fitted {
    /// The machine with its fitted parameters and effects, and how currents drive it.
    pub(super) fn setup(&self) -> Setup {
        parameters::setup(&self.model, &self.effects, &self.parameters, &self.x)
    }

    /// Parameters and `x` with the gears of a start.
    fn with_gears(&self, x: &[f64], start: &Start) -> (Vec<Parameter>, Vec<f64>) {
        let (mut parameters, mut x) = (self.parameters.clone(), x.to_vec());
        parameters::put_gears(&self.model, &start.gears, &mut parameters, &mut x);
        (parameters, x)
    }

    /// Better gears of its joints, with the effects of those that are soft or vary.
    fn better_gears(&self, train: &[Recording], settings: &Settings) -> Vec<(Gear, Option<EffectEntry>)> {
        let setup = self.setup();
        let names: Vec<&String> = self.model.joints.iter().map(|joint| &joint.name).collect();
        let varies = |name: &String| self.effects.iter().any(|entry| uneven::is_of(entry, name));
        let uneven = uneven::around(&setup, &self.lambda, train, settings);
        let uneven = uneven.into_iter().zip(&names).map(|(gap, name)| gap.filter(|_| varies(name)));
        let uneven: Vec<Option<(f64, UnevenGap)>> = uneven.collect();
        // Where all gaps vary, nobody asks for the others.
        let even = match uneven.iter().any(Option::is_none) {
            true => gears::around(&setup, &self.lambda, train, settings),
            false => Vec::new(),
        };
        let better = names.iter().zip(uneven).enumerate().map(|(joint, (name, uneven))| match uneven {
            Some((share, gap)) => (Gear { gap: gap.gap, share }, Some(gap.entry(name))),
            None => (even[joint].gear, even[joint].entry(name)),
        });
        better.collect()
    }

    /// Effects, parameters and `x` without these effects.
    fn left(&self, dropped: &[usize]) -> (Vec<EffectEntry>, Vec<Parameter>, Vec<f64>) {
        let kept: Vec<usize> = (0..self.effects.len()).filter(|effect| !dropped.contains(effect)).collect();
        let effects = kept.iter().map(|effect| self.effects[*effect].clone()).collect();
        let own = self.parameters.iter().zip(&self.x);
        let left = own.filter_map(|(parameter, x)| Some((parameter.of_effects(&kept)?, *x)));
        let (parameters, x) = left.unzip();
        (effects, parameters, x)
    }

    /// The effects of the hypothesis with their fitted parameters.
    pub fn effects(&self) -> Vec<EffectEntry> {
        let mut model = self.setup().model;
        model.effects.split_off(model.effects.len() - self.effects.len())
    }

    /// The machine with its fitted parameters and effects.
    pub fn model(&self) -> Model {
        self.setup().model
    }

    /// Multiplies the errors of its estimates: of a fit that ended beside its best place.
    pub fn widen_errors(&mut self, factor: f64) {
        self.estimates.iter_mut().for_each(|(_, estimate)| estimate.std_error *= factor);
    }

    /// Its values of what every hypothesis has: hypotheses that contain its effects begin there.
    #[must_use]
    pub fn beside_effects(&self) -> Self {
        let all: Vec<usize> = (0..self.effects.len()).collect();
        let (effects, parameters, x) = self.left(&all);
        Self { effects, parameters, x, ..self.clone() }
    }

    /// The same parameters where another model of the machine has them, before any fit to it.
    #[must_use]
    pub fn at_values_of(&self, model: &Model) -> Self {
        let model = parameters::with_dry_friction(model);
        let bodies = self.parameters.iter().filter(|parameter| parameter.is_of_bodies()).cloned();
        let parameters: Vec<Parameter> = parameters::nuisances(&model).into_iter().chain(bodies).collect();
        Self { x: vec![0.0; parameters.len()], parameters, model, effects: Vec::new(), ..self.clone() }
    }

    /// Scores recordings under the fitted machine.
    ///
    /// # Errors
    /// As [`score`](super::score).
    pub fn score(&self, recordings: &[Recording], settings: &Settings) -> Result<Vec<Score>> {
        scored(&self.setup(), recordings, &self.lambda, settings)
    }
}

/// Fits the nuisances of a model alone: the baseline.
///
/// # Errors
/// As [`score`](super::score).
pub fn fit_baseline(model: &Model, train: &[Recording], settings: &Settings) -> Result<Fitted> {
    let model = &parameters::with_dry_friction(model);
    let lambda = vec![NOISE_AT_FIRST; model.joints.len()];
    let baseline = Hypothesis::baseline();
    let mut fit = Fit { model, effects: &[], parameters: parameters::nuisances(model), train, settings };
    let x = vec![0.0; fit.parameters.len()];
    let lambda = fit.noise(&x, lambda, NOISE_TRIALS)?;
    let directions = fit.directions(&lambda)?;
    fit.parameters.extend(parameters::inertial(model, &directions));
    let x = vec![0.0; fit.parameters.len()];
    fit.go(&baseline.name, x, lambda)
}

/// Fits a hypothesis, from the fit of the baseline to the same recordings.
///
/// # Errors
/// As [`score`](super::score); no start of the hypothesis can be simulated.
pub fn fit(hypothesis: &Hypothesis, baseline: &Fitted, train: &[Recording], settings: &Settings) -> Result<Fitted> {
    // The baseline may have bent its parameters to what it lacks: they also start where the nominal model has them.
    let nominal = vec![0.0; baseline.x.len()];
    let places: [&[f64]; 2] = [&baseline.x, &nominal];
    let tries: Vec<(&[f64], &Start)> =
        places.iter().flat_map(|x| hypothesis.starts.iter().map(move |start| (*x, start))).collect();
    let first = ranked(&tries, baseline, train, settings)?.first().map(|best| tries[*best]);
    let nothing = Start::new(Vec::new());
    let (x, start) = first.unwrap_or((&baseline.x, &nothing));
    let (mut all, mut x) = baseline.with_gears(x, start);
    all.extend(parameters::sizes(hypothesis, &start.effects, &settings.catalogue));
    x.resize(all.len(), 0.0);
    let fit = Fit { model: &baseline.model, effects: &start.effects, parameters: all, train, settings };
    // Gears were found with less noise than the baseline needs.
    let lambda = match start.gears.is_empty() {
        true => noisier(baseline),
        false => fit.noise(&x, noisier(baseline), NOISE_TRIALS)?,
    };
    let from = Place { x, lambda, ..Place::nowhere(fit.parameters.len()) };
    fit.go_on(&hypothesis.name, from, 0, baseline.nats + baseline.prior + settings.hopeful)
}

/// The hypothesis with its most probable starts alone, beside the parameters of the baseline: for a rough choice by a small part of the recordings.
///
/// # Errors
/// As [`fit`](fit()).
pub fn most_probable(
    hypothesis: &Hypothesis,
    baseline: &Fitted,
    recordings: &[Recording],
    count: usize,
    settings: &Settings,
) -> Result<Hypothesis> {
    if hypothesis.starts.len() <= count {
        return Ok(hypothesis.clone());
    }
    let tries: Vec<(&[f64], &Start)> = hypothesis.starts.iter().map(|start| (&baseline.x[..], start)).collect();
    let ranked = ranked(&tries, baseline, recordings, settings)?;
    let starts = ranked.into_iter().take(count).map(|index| hypothesis.starts[index].clone()).collect();
    Ok(Hypothesis { starts, ..hypothesis.clone() })
}

/// Drives a fit further: steps in all parameters, then a fine search.
///
/// # Errors
/// As [`fit`](fit()).
pub fn refine(fitted: &Fitted, train: &[Recording], settings: &Settings) -> Result<Fitted> {
    let Fitted { model, effects, parameters, .. } = fitted;
    let fit = Fit { model, effects, parameters: parameters.clone(), train, settings };
    let from = fit.climb(fitted.x.clone(), fitted.lambda.clone())?;
    fit.go_on(&fitted.name, from, GAP_STEPS.len() - 1, f64::NEG_INFINITY)
}

/// Drives a fit further from better gears around its own, where there are some.
///
/// # Errors
/// As [`fit`](fit()).
pub fn from_better_gears(fitted: &Fitted, train: &[Recording], settings: &Settings) -> Result<Fitted> {
    let Fitted { model, effects, lambda, .. } = fitted;
    let exact = |lambda: &f64| *lambda < NEARLY_EXACT;
    let all = lambda.iter().all(exact);
    // A joint that misses nothing keeps its gear: a search with more noise may lead away from it.
    let is_sought = |joint: usize| all || !exact(&lambda[joint]);
    let better = fitted.better_gears(train, settings).into_iter().enumerate();
    let better = better.map(|(joint, better)| Some(better).filter(|_| is_sought(joint)));
    let (gears, sizes): (Vec<_>, Vec<_>) = better.map(Option::unzip).unzip();
    let sizes: Vec<EffectEntry> = sizes.into_iter().flatten().flatten().collect();
    let (parameters, mut x) = fitted.with_gears(&fitted.x, &Start { effects: Vec::new(), gears });
    parameters::put_sizes(effects, &sizes, &parameters, &mut x);
    let fit = Fit { model, effects, parameters, train, settings };
    let lambda = fit.noise(&x, lambda.clone(), NOISE_TRIALS)?;
    let from = fit.climb(x, lambda)?;
    fit.go_on(&fitted.name, from, GAP_STEPS.len() - 1, f64::NEG_INFINITY)
}

/// A fit without some of its effects, from where it brought the parameters that remain: a rival must not win because it found better values of what both
/// have. `name`: of the smaller hypothesis, `dropped`: indices of the effects.
///
/// # Errors
/// As [`fit`](fit()).
pub fn without(
    fitted: &Fitted,
    dropped: &[usize],
    name: &str,
    train: &[Recording],
    settings: &Settings,
) -> Result<Fitted> {
    let Fitted { model, lambda, .. } = fitted;
    let (effects, parameters, x) = fitted.left(dropped);
    let fit = Fit { model, effects: &effects, parameters, train, settings };
    let from = fit.climb(x, lambda.clone())?;
    fit.go_on(name, from, GAP_STEPS.len() - 1, f64::NEG_INFINITY)
}

/// Multiplies row and column of a parameter.
fn scale(matrix: &mut DMatrix<f64>, parameter: usize, factor: f64) {
    matrix.row_mut(parameter).scale_mut(factor);
    matrix.column_mut(parameter).scale_mut(factor);
}

/// `λ` by which starts are compared and first refined.
fn noisier(baseline: &Fitted) -> Vec<f64> {
    baseline.lambda.iter().map(|lambda| lambda.max(NOISE_AT_STARTS)).collect()
}

/// Indices of the tries that can be simulated, the most probable one first; fails where there is none.
fn ranked(
    tries: &[(&[f64], &Start)],
    baseline: &Fitted,
    recordings: &[Recording],
    settings: &Settings,
) -> Result<Vec<usize>> {
    let noisier = noisier(baseline);
    let tried = |(x, start): &(&[f64], &Start)| -> Result<f64> {
        let (parameters, x) = baseline.with_gears(x, start);
        let setup = parameters::setup(&baseline.model, &start.effects, &parameters, &x);
        Ok(scored(&setup, recordings, &noisier, settings)?.iter().map(Score::sum).sum())
    };
    let scores: Vec<Result<f64>> = tries.par_iter().map(tried).collect();
    let mut scored = Vec::new();
    let mut failure = None;
    for (index, score) in scores.into_iter().enumerate() {
        match score {
            Ok(score) => scored.push((score, index)),
            Err(error) => failure = Some(error),
        }
    }
    // A stable sort: of equal starts the first remains first.
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    match failure {
        Some(error) if scored.is_empty() => Err(error),
        _ => Ok(scored.into_iter().map(|(_, index)| index).collect()),
    }
}

/// Where a fit has come to.
struct Place {
    /// [nat] Score and prior.
    height: f64,
    x: Vec<f64>,
    lambda: Vec<f64>,
    slope: Slope,
    steps: usize,
}

impl Place {
    /// Before anything has been scored.
    fn nowhere(size: usize) -> Self {
        let slope = Slope { nats: 0.0, gradient: DVector::zeros(size), information: DMatrix::zeros(size, size) };
        Self { height: f64::NEG_INFINITY, x: Vec::new(), lambda: Vec::new(), slope, steps: 0 }
    }
}

impl Fit<'_> {
    /// Directions in which the motion shows the bodies' values: eigenvectors of the information in units of their prior deviations.
    fn directions(&self, lambda: &[f64]) -> Result<Vec<DVector<f64>>> {
        let size = NUMBERS * self.model.joints.len();
        let accuracy = &self.model.accuracy;
        if accuracy.masses == 0.0 && accuracy.centres == 0.0 && accuracy.inertias == 0.0 {
            return Ok(Vec::new());
        }
        let units: Vec<DVector<f64>> =
            (0..size).map(|k| DVector::from_fn(size, |row, _| f64::from(u8::from(row == k)))).collect();
        let part = |recording: &Recording| {
            let from = recording.time.first().copied().unwrap_or(0.0);
            recording.window(from, from + self.settings.burn_in + LOOK)
        };
        let parts: Vec<Recording> = self.train.iter().map(part).collect();
        let alone = Fit { parameters: parameters::inertial(self.model, &units), ..*self };
        let slope = alone.slope(&vec![0.0; size], lambda, &parts)?;
        let share: f64 = parts.iter().map(Recording::len).sum::<usize>() as f64
            / self.train.iter().map(Recording::len).sum::<usize>().max(1) as f64;
        let eigen = slope.information.symmetric_eigen();
        let shown = (0..size).filter(|k| eigen.eigenvalues[*k] / share > SHOWN);
        Ok(shown.map(|k| eigen.eigenvectors.column(k).into_owned()).collect())
    }

    /// Steps, then searches and steps in turn: a gap that is searched under a wrong friction makes up for it.
    fn go(&self, name: &str, x: Vec<f64>, lambda: Vec<f64>) -> Result<Fitted> {
        let from = self.climb(x, lambda)?;
        self.go_on(name, from, 0, f64::NEG_INFINITY)
    }

    /// Searches and steps in turn, with finer and finer searches of the gaps; only searches where these do not come to the height `hopeful` [nat].
    fn go_on(&self, name: &str, from: Place, first: usize, hopeful: f64) -> Result<Fitted> {
        let mut best = from;
        for gap_step in GAP_STEPS.into_iter().skip(first).take(self.settings.rounds) {
            let (x, lambda) = self.search(best.x.clone(), best.lambda.clone(), gap_step)?;
            if hopeful > f64::NEG_INFINITY {
                let height = self.height(&x, &lambda);
                if height < hopeful {
                    let slope = Slope { nats: height + self.prior(&x), ..best.slope };
                    best = Place { height, x, lambda, slope, ..best };
                    break;
                }
            }
            let again = self.climb(x, lambda)?;
            let gain = again.height - best.height;
            if gain > 0.0 {
                best = Place { steps: best.steps + again.steps, ..again };
            }
        }
        self.fitted(name, best)
    }

    /// Steps until they gain nothing.
    fn climb(&self, mut x: Vec<f64>, mut lambda: Vec<f64>) -> Result<Place> {
        let mut damping = 1e-2;
        let mut here: Option<Place> = None;
        for steps in 0..=self.settings.steps {
            // The noise changes slowly, and costs as much as a step.
            if steps % 2 == 0 {
                lambda = self.noise(&x, lambda, 1)?;
            }
            let slope = self.slope(&x, &lambda, self.train)?;
            let height = slope.nats - self.prior(&x);
            let gain = height - here.as_ref().map_or(f64::NEG_INFINITY, |here| here.height);
            if gain > 0.0 {
                here = Some(Place { height, x: x.clone(), lambda: lambda.clone(), slope, steps });
            }
            let Some(place) = here.as_ref().filter(|_| gain > SMALL) else { break };
            let Some(better) = self.step(&x, &lambda, &place.slope, &mut damping)? else { break };
            x = better;
        }
        let nowhere = || Place { x, lambda, ..Place::nowhere(self.parameters.len()) };
        Ok(here.unwrap_or_else(nowhere))
    }

    /// A better `x`, if there is one.
    fn step(&self, x: &[f64], lambda: &[f64], slope: &Slope, damping: &mut f64) -> Result<Option<Vec<f64>>> {
        let here = slope.nats - self.prior(x);
        for _ in 0..MOST_TRIALS {
            let mut matrix = self.posterior(slope);
            for k in 0..x.len() {
                matrix[(k, k)] *= 1.0 + *damping;
            }
            let pull = |k: usize| match self.is_gap(k) {
                true => 0.0,
                false => slope.gradient[k] - self.parameters[k].precision * x[k],
            };
            // Gaps stay.
            for gap in (0..x.len()).filter(|k| self.is_gap(*k)) {
                scale(&mut matrix, gap, 0.0);
                matrix[(gap, gap)] = 1.0;
            }
            let Some(factor) = matrix.cholesky() else { return Ok(None) };
            let step = factor.solve(&DVector::from_fn(x.len(), |k, _| pull(k)));
            let shrink = (LONGEST / step.amax().max(f64::MIN_POSITIVE)).min(1.0);
            let moved: Vec<f64> = x.iter().zip(step.iter()).map(|(x, step)| x + shrink * step).collect();
            if self.height(&moved, lambda) > here {
                *damping = (*damping / 10.0).max(1e-6);
                return Ok(Some(moved));
            }
            *damping *= 10.0;
        }
        Ok(None)
    }

    /// Information of score and prior together.
    fn posterior(&self, slope: &Slope) -> DMatrix<f64> {
        let precisions = self.parameters.iter().map(|parameter| parameter.precision);
        &slope.information + DMatrix::from_diagonal(&DVector::from_iterator(self.parameters.len(), precisions))
    }

    /// With errors by the information; that of a gap, and of how it varies, is scaled to the curvature of the score.
    fn fitted(&self, name: &str, place: Place) -> Result<Fitted> {
        let Place { height, x, lambda, mut slope, steps } = place;
        for k in (0..x.len()).filter(|k| self.shapes_gap(*k)) {
            let at = |step: f64| {
                let mut moved = x.clone();
                moved[k] += step;
                self.height(&moved, &lambda)
            };
            let bend = 2.0 * height - at(CURVATURE_STEP) - at(-CURVATURE_STEP);
            let curvature = (bend / CURVATURE_STEP.powi(2)).max(0.0);
            let own = slope.information[(k, k)];
            scale(&mut slope.information, k, if own > 0.0 { (curvature / own).sqrt() } else { 0.0 });
            slope.information[(k, k)] = curvature;
        }
        let inverse = self.posterior(&slope).cholesky().map(|factor| factor.inverse());
        let error = |k: usize| inverse.as_ref().map_or(f64::NAN, |inverse| inverse[(k, k)].max(0.0).sqrt());
        let estimate = |(k, parameter): (usize, &Parameter)| {
            let (value, std_error) = (parameter.value(x[k]), parameter.slope(x[k]) * error(k));
            (parameter.name.clone(), Estimate { value, std_error })
        };
        Ok(Fitted {
            name: name.to_owned(),
            nats: slope.nats,
            prior: -self.prior(&x),
            estimates: self.parameters.iter().enumerate().map(estimate).collect(),
            steps,
            model: self.model.clone(),
            effects: self.effects.to_vec(),
            parameters: self.parameters.clone(),
            lambda,
            x,
        })
    }
}
