//! The contest of sets: fits on some windows, scores on others.
//!
//! The baseline is fitted first, also from other gaps where it misses torque. Every set is fitted roughly from there: its starts are compared on the first seconds of the windows, the best of them are searched along single
//! lines, and what gains nothing by that is fitted no further. Then the leading sets are fitted closely, with the union of the two best, and the baseline with them, also
//! from where each of them ended: a rival must not win because its fit went on longer, or found better values of what both have.

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;

use super::sets;
use crate::error::Result;
use crate::likelihood::{
    Fitted, Hypothesis, Recording, Score, Settings, Start, fit, fit_baseline, most_probable, refine, with_other_gaps,
    without_effects,
};
use crate::robot::Model;
use crate::timeseries::Estimate;

/// [s] Scored part of each window by which the starts of a set are compared, and the number of starts that are compared on all of it.
const GLANCE: f64 = 2.0;
const KEPT: usize = 2;
/// Most steps of a rough fit and of a close one: Gauss and Newton's steps converge in three to five from a start in reach.
const ROUGH: usize = 4;
const CLOSE: usize = 8;
/// Most changes of the gaps of a fit.
const GAPS_CHANGED: usize = 4;
/// [nat] What a set has to gain by searches along single lines for all parameters to be fitted: one free size gains half a nat by chance, and
/// a search that ends beside the best place loses a few.
const HOPEFUL: f64 = 3.0;
/// [nat] Held-out gain from which a set leads, and is fitted closely: less is nothing under every prior.
const LEADS: f64 = 10.0;
/// Most sets that are fitted closely.
const LEADING: usize = 2;

/// Windows, settings and time of a contest.
pub struct Contest {
    pub train: Vec<Recording>,
    pub judged: Vec<Recording>,
    /// Number of joints.
    pub joints: usize,
    pub settings: Settings,
    /// [s]
    pub seconds: f64,
}

/// A fitted set.
pub struct Contender {
    /// Names of its effects in the catalogue, each once.
    pub effects: Vec<String>,
    pub fitted: Fitted,
    /// [nat] on the windows that judge.
    pub nats: f64,
    /// Its parameters.
    hypothesis: Hypothesis,
}

impl Contender {
    /// The effects with their joints as one name.
    pub fn name(&self) -> &str {
        if self.effects.is_empty() { "nothing" } else { &self.fitted.name }
    }

    /// Joints on which an effect of the set acts.
    pub fn joints(&self, effect: &str) -> Vec<String> {
        let own = self.fitted.effects().into_iter().filter(|entry| entry.effect == effect);
        own.filter_map(|entry| entry.joint).collect()
    }

    /// Sizes of its effects.
    pub fn sizes(&self) -> BTreeMap<String, Estimate> {
        let own = |name: &str| self.effects.iter().any(|effect| name.contains(effect.as_str()) && !name.contains('['));
        self.fitted.estimates.iter().filter(|(name, _)| own(name)).cloned().collect()
    }

    /// [nat] Score of the training windows and prior.
    fn height(&self) -> f64 {
        self.fitted.nats + self.fitted.prior
    }

    /// The set with its fitted sizes as its start.
    fn fitted_start(&self) -> Hypothesis {
        Hypothesis { starts: vec![Start::new(self.fitted.effects())], ..self.hypothesis.clone() }
    }
}

/// Puts a contender in its place if the training windows prefer it, whatever the others say of it.
fn prefer(contenders: &mut [Contender], (index, contender): (usize, Contender)) {
    if contender.height() > contenders[index].height() {
        contenders[index] = contender;
    }
}

impl Contest {
    /// Number of readings that are judged, all joints together.
    pub fn readings(&self) -> f64 {
        let of = |recording: &Recording| {
            let start = recording.time.first().copied().unwrap_or(0.0) + self.settings.burn_in;
            recording.len() - recording.time.partition_point(|time| *time < start)
        };
        let samples: usize = self.judged.iter().map(of).sum();
        (samples * self.joints).max(1) as f64
    }

    /// Fits and judges the baseline, these sets and what follows from them; the baseline is the first contender. Also gives the names of the
    /// sets for which there was no time.
    ///
    /// # Errors
    /// The baseline cannot be simulated. A set that cannot be is left out.
    pub fn hold(
        &self,
        model: &Model,
        sets: &[Hypothesis],
        progress: &mut dyn FnMut(&str, f64),
    ) -> Result<(Vec<Contender>, Vec<String>)> {
        let start = Instant::now();
        let over = || start.elapsed().as_secs_f64() > self.seconds;
        progress("simulating the baseline", 0.0);
        let rough = Settings { steps: CLOSE, rounds: 1, hopeful: HOPEFUL, ..self.settings.clone() };
        let baseline = self.with_gaps_changed(fit_baseline(model, &self.train, &rough)?, &rough)?;
        let mut contenders = vec![self.contender(&Hypothesis::baseline(), baseline.clone())?];
        let mut not_tried = Vec::new();
        let together = rayon::current_num_threads().max(1);
        for (round, some) in sets.chunks(together).enumerate() {
            if over() {
                not_tried.extend(some.iter().map(|set| set.name.clone()));
                continue;
            }
            let done = (round * together) as f64 / sets.len() as f64;
            progress(&format!("simulating {}", some[0].name), 0.3 + 0.5 * done);
            let tried: Vec<Result<Contender>> = some.par_iter().map(|set| self.rough(set, &baseline)).collect();
            contenders.extend(tried.into_iter().flatten());
        }
        progress("simulating the leading sets", 0.8);
        if over() {
            not_tried.push("unions of the leading sets".to_owned());
        } else {
            self.close(&mut contenders, &baseline);
        }
        Ok((contenders, not_tried))
    }

    /// A set, fitted roughly.
    fn rough(&self, set: &Hypothesis, baseline: &Fitted) -> Result<Contender> {
        let settings = Settings { steps: ROUGH, rounds: 1, hopeful: HOPEFUL, ..self.settings.clone() };
        let glance: Vec<Recording> = self.train.iter().map(|one| self.glance(one)).collect();
        let set = most_probable(set, baseline, &glance, KEPT, &settings)?;
        let fitted = fit(&set, baseline, &self.train, &settings)?;
        self.contender(&set, fitted)
    }

    /// The first part of a window.
    fn glance(&self, window: &Recording) -> Recording {
        let from = window.time.first().copied().unwrap_or(0.0);
        window.window(from, from + self.settings.burn_in + GLANCE)
    }

    /// Fits the leading sets and the baseline closely, and the union of the two best.
    fn close(&self, contenders: &mut Vec<Contender>, baseline: &Fitted) {
        let least = contenders[0].nats + LEADS;
        let mut order: Vec<usize> = (1..contenders.len()).filter(|one| contenders[*one].nats > least).collect();
        order.sort_by(|a, b| contenders[*b].nats.total_cmp(&contenders[*a].nats));
        order.truncate(LEADING);
        // A baseline that misses torque may only not have been fitted far enough.
        if order.is_empty() && baseline.lambda.iter().all(|lambda| *lambda <= 0.0) {
            return;
        }
        let union = match order[..] {
            [one, other] => self.union(&contenders[one], &contenders[other], baseline),
            _ => None,
        };
        let settings = Settings { steps: CLOSE, rounds: 1, ..self.settings.clone() };
        let again: Vec<usize> = order.iter().copied().chain([0]).collect();
        let closer = |index: &usize| -> Result<(usize, Contender)> {
            let old = &contenders[*index];
            let fitted = self.closely(&old.fitted, &settings)?;
            Ok((*index, self.contender(&old.hypothesis, fitted)?))
        };
        let refined: Vec<Result<(usize, Contender)>> = again.par_iter().map(closer).collect();
        refined.into_iter().flatten().for_each(|one| prefer(contenders, one));
        let beside = |index: &usize| -> Result<(usize, Contender)> {
            let fitted = without_effects(&contenders[*index].fitted, baseline, &self.train, &settings)?;
            Ok((0, self.contender(&contenders[0].hypothesis, fitted)?))
        };
        let beside: Vec<Result<(usize, Contender)>> = order.par_iter().map(beside).collect();
        beside.into_iter().flatten().for_each(|one| prefer(contenders, one));
        contenders.extend(union);
    }

    /// A fit driven further, also from other gaps.
    fn closely(&self, fitted: &Fitted, settings: &Settings) -> Result<Fitted> {
        self.with_gaps_changed(refine(fitted, &self.train, settings)?, settings)
    }

    /// A fit that misses torque, driven further from other gaps as long as that gains.
    fn with_gaps_changed(&self, fitted: Fitted, settings: &Settings) -> Result<Fitted> {
        let mut best = fitted;
        for _ in 0..GAPS_CHANGED {
            if best.lambda.iter().all(|lambda| *lambda <= 0.0) {
                break;
            }
            let other = with_other_gaps(&best, &self.train, &Settings { rounds: 2, ..settings.clone() })?;
            let gain = other.nats + other.prior - best.nats - best.prior;
            if gain > 0.0 {
                best = other;
            }
            if gain < HOPEFUL {
                break;
            }
        }
        Ok(best)
    }

    /// Two sets together, from their fitted sizes; `None` where they have an effect in common, or cannot be simulated together.
    fn union(&self, one: &Contender, other: &Contender, baseline: &Fitted) -> Option<Contender> {
        let shared = one.fitted.effects().iter().any(|entry| {
            other.fitted.effects().iter().any(|also| also.effect == entry.effect && also.joint == entry.joint)
        });
        if shared {
            return None;
        }
        self.rough(&sets::joined(&[one.fitted_start(), other.fitted_start()]), baseline).ok()
    }

    fn contender(&self, hypothesis: &Hypothesis, fitted: Fitted) -> Result<Contender> {
        let nats = fitted.score(&self.judged, &self.settings)?.iter().map(Score::sum).sum();
        Ok(Contender { effects: sets::names(hypothesis), fitted, nats, hypothesis: hypothesis.clone() })
    }
}
