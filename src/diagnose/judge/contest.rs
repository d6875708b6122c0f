//! The contest of sets: fits on some windows, scores on others.
//!
//! The baseline is fitted first, then what the regression named; the other sets build on the better of them, their ground. Where that is far from its
//! floor, the gears that explain the recordings best are sought, rigid ones for a baseline beside which nothing was named, and soft ones for the sets
//! that have them. Every set is fitted roughly from there: its starts are compared on the first seconds of the windows, the best of them are searched
//! along single lines, and beside a baseline near its floor what gains nothing by that is fitted no further. Then the leading sets are fitted closely,
//! with the union of the two best, and the baseline with them, also from where each of them ended: a rival must not win because its fit went on longer,
//! or found better values of what both have.

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;

use super::sets::{self, Known, Sets};
use super::{floor, starts};
use crate::error::Result;
use crate::likelihood::{
    Fitted, Gear, Hypothesis, Recording, SOFT_GEAR, Score, Settings, Start, UNEVEN_GAP, fit, fit_baseline,
    from_better_gears, most_probable, refine, score, seek_gears, seek_uneven_gaps, without,
};
use crate::robot::{JointModel, Model};
use crate::timeseries::Estimate;

/// [s] Scored part of each window by which the starts of a set are compared, and the number of starts that are compared on all of it.
const GLANCE: f64 = 2.0;
const KEPT: usize = 2;
/// Most steps of a rough fit and of a close one: Gauss and Newton's steps converge in three to five from a start in reach.
const ROUGH: usize = 4;
const CLOSE: usize = 8;
/// Most changes of the gears of a fit.
const GEARS_CHANGED: usize = 6;
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

    /// Number of its effects on their joints.
    pub fn entries(&self) -> usize {
        self.fitted.effects().len()
    }

    /// Its effects with their joints, sorted.
    fn named(&self) -> Vec<(String, Option<String>)> {
        let mut all: Vec<_> = self.fitted.effects().into_iter().map(|entry| (entry.effect, entry.joint)).collect();
        all.sort();
        all
    }

    fn has_the_entries_of(&self, other: &Self) -> bool {
        self.named() == other.named()
    }

    fn contains(&self, other: &Self) -> bool {
        let own = self.named();
        other.named().iter().all(|one| own.contains(one))
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

    /// The set with its fitted sizes, and the gears of their joints, as its start.
    fn fitted_start(&self) -> Hypothesis {
        let (effects, model) = (self.fitted.effects(), self.fitted.model());
        let acts_on = |joint: &JointModel| effects.iter().any(|entry| entry.joint.as_ref() == Some(&joint.name));
        let gear = |joint: &JointModel| {
            let share = joint.friction.map_or(0.0, |friction| friction.link_share);
            acts_on(joint).then_some(Gear { gap: joint.backlash.unwrap_or(0.0), share })
        };
        let gears = model.joints.iter().map(gear).collect();
        Hypothesis { starts: vec![Start { effects, gears }], ..self.hypothesis.clone() }
    }
}

/// What other sets build on: the baseline, or what the regression named.
struct Ground {
    /// As it was fitted, with the effects of that set.
    whole: Fitted,
    /// Without them.
    fitted: Fitted,
    /// That set as it was fitted; `None` for the baseline.
    start: Option<Hypothesis>,
    /// Whether it leaves nothing to be found in the windows to which it was fitted, and whether it explains those that judge as well: some constant gap explains the
    /// few reversals of one part, but not those of the other.
    finished: bool,
    explains_others: bool,
    /// The model as it was given, with the effects of that set.
    model: Model,
}

impl Ground {
    /// Whether a gap that varies may be what is missing.
    const fn asks_for_uneven_gaps(&self) -> bool {
        !(self.finished && self.explains_others)
    }

    /// [nat] What a set has to gain by searches along single lines. Where much is missing, a set begins far below the baseline, whose parameters make up for it.
    fn hopeful(&self, set: &Hypothesis) -> f64 {
        let is_asked_for = || self.asks_for_uneven_gaps() && sets::names(set).iter().any(|name| name == UNEVEN_GAP);
        if self.finished && !is_asked_for() { HOPEFUL } else { f64::NEG_INFINITY }
    }
}

/// [nat] Score of the training windows and prior.
fn height(fitted: &Fitted) -> f64 {
    fitted.nats + fitted.prior
}

/// Puts a contender in the place of another if the training windows prefer it, whatever the others say of it.
fn prefer(place: &mut Contender, one: Contender) {
    if height(&one.fitted) > height(&place.fitted) {
        *place = one;
    }
}

/// The place of the best of some contenders.
fn best_of(contenders: &[Contender], places: impl IntoIterator<Item = usize>) -> Option<usize> {
    places.into_iter().max_by(|a, b| contenders[*a].nats.total_cmp(&contenders[*b].nats))
}

/// Puts a contender in the place of one with the same entries, or beside the others; gives its place.
fn enter(contenders: &mut Vec<Contender>, one: Contender) -> usize {
    let same = contenders.iter().position(|other| other.has_the_entries_of(&one));
    match same {
        Some(index) => prefer(&mut contenders[index], one),
        None => contenders.push(one),
    }
    same.unwrap_or(contenders.len() - 1)
}

impl Contest {
    /// Number of readings of some windows that are scored, all joints together.
    pub fn readings(&self, windows: &[Recording]) -> f64 {
        windows.iter().map(|one| one.readings(self.settings.burn_in)).sum::<usize>().max(1) as f64
    }

    /// [nat] a reading: the floor of a fit on some windows, see [`floor::floor`].
    pub fn floor(&self, fitted: &Fitted, windows: &[Recording]) -> Result<Option<f64>> {
        let exact = vec![floor::EXACT; fitted.lambda.len()];
        let scores = score(&fitted.model(), windows, &exact, &self.settings)?;
        Ok(floor::floor(&scores))
    }

    /// Whether a fit leaves nothing to be found in the windows to which it was fitted.
    fn is_finished(&self, fitted: &Fitted) -> Result<bool> {
        self.is_near(fitted, fitted.nats, &self.train)
    }

    /// Whether a contender is near its floor in the windows that judge.
    fn explains_others(&self, one: &Contender) -> Result<bool> {
        self.is_near(&one.fitted, one.nats, &self.judged)
    }

    /// Whether a fit is near its floor on some windows, which it scores with these `nats`.
    fn is_near(&self, fitted: &Fitted, nats: f64, windows: &[Recording]) -> Result<bool> {
        let mean = nats / self.readings(windows);
        Ok(floor::is_near(mean, self.floor(fitted, windows)?, &floor::missed(&fitted.lambda)))
    }

    /// Fits and judges the baseline, these sets and what follows from them; the baseline is the first contender. Also gives the names of the
    /// sets for which there was no time.
    ///
    /// # Errors
    /// The baseline cannot be simulated. A set that cannot be is left out.
    pub fn hold(
        &self,
        model: &Model,
        sets: &Sets,
        progress: &mut dyn FnMut(&str, f64),
    ) -> Result<(Vec<Contender>, Vec<String>)> {
        let start = Instant::now();
        let over = || start.elapsed().as_secs_f64() > self.seconds;
        progress("simulating the baseline", 0.0);
        let (mut contenders, ground) = self.ground(model, sets.known.as_ref())?;
        // Beside nothing, what is tried beside the regression's set is already there.
        let others = sets.others.iter().filter(|one| ground.start.is_some() || !sets.more.contains(one));
        let [more, others] = self.sought([sets.more.clone(), others.cloned().collect()], &ground, progress);
        let beside_known = |one: Hypothesis| match &ground.start {
            Some(known) => sets::joined(&[known.clone(), one]),
            None => one,
        };
        let more: Vec<Hypothesis> = more.into_iter().map(beside_known).collect();
        let baseline = contenders[0].fitted.clone();
        let tried: Vec<(&Hypothesis, &Fitted)> =
            more.iter().map(|set| (set, &ground.fitted)).chain(others.iter().map(|set| (set, &baseline))).collect();
        let mut not_tried = Vec::new();
        let together = rayon::current_num_threads().max(1);
        for (round, some) in tried.chunks(together).enumerate() {
            if over() {
                not_tried.extend(some.iter().map(|(set, _)| set.name.clone()));
                continue;
            }
            let done = (round * together) as f64 / tried.len() as f64;
            progress(&format!("simulating {}", some[0].0.name), 0.3 + 0.5 * done);
            let fitted: Vec<Result<Contender>> =
                some.par_iter().map(|(set, from)| self.rough(set, from, ground.hopeful(set))).collect();
            contenders.extend(fitted.into_iter().flatten());
        }
        progress("simulating the leading sets", 0.8);
        if over() {
            not_tried.push("unions of the leading sets".to_owned());
        } else {
            self.close(&mut contenders, &ground);
        }
        let readings = self.readings(&self.judged);
        for one in &mut contenders {
            let floor = self.floor(&one.fitted, &self.judged).unwrap_or_default();
            one.fitted.widen_errors(floor::allowance(one.nats / readings, floor, readings));
        }
        Ok((contenders, not_tried))
    }

    /// The baseline, what the regression named, and the better of them, on which other sets build.
    fn ground(&self, model: &Model, known: Option<&Known>) -> Result<(Vec<Contender>, Ground)> {
        let settings = Settings { steps: CLOSE, rounds: 1, ..self.settings.clone() };
        let fitted = fit_baseline(model, &self.train, &settings)?;
        let mut finished = self.is_finished(&fitted)?;
        let mut contenders = vec![self.contender(&Hypothesis::baseline(), fitted)?];
        // What cannot be simulated is no ground.
        if let Some((known, Ok(with))) =
            known.map(|known| (known, self.with_known(known, &contenders[0].fitted, finished)))
        {
            if height(&with.fitted) > height(&contenders[0].fitted) + HOPEFUL {
                let mut model = known.model.clone();
                model.effects.extend(with.fitted.effects());
                let finished = self.is_finished(&with.fitted)?;
                let explains_others = self.explains_others(&with)?;
                let (whole, start) = (with.fitted.clone(), Some(with.fitted_start()));
                contenders.push(with);
                let fitted = whole.beside_effects();
                return Ok((contenders, Ground { whole, fitted, start, finished, explains_others, model }));
            }
            contenders.push(with);
        } else if !finished {
            let other = fit_baseline(&self.with_rigid_gears(model), &self.train, &settings)?;
            if height(&other) > height(&contenders[0].fitted) {
                finished = self.is_finished(&other)?;
                contenders[0] = self.contender(&Hypothesis::baseline(), other)?;
            }
        }
        let explains_others = self.explains_others(&contenders[0])?;
        let (fitted, model) = (contenders[0].fitted.clone(), model.clone());
        let ground = Ground { whole: fitted.clone(), fitted, start: None, finished, explains_others, model };
        Ok((contenders, ground))
    }

    /// What the regression named, fitted closely where the baseline is far from its floor.
    fn with_known(&self, Known { set, model }: &Known, baseline: &Fitted, finished: bool) -> Result<Contender> {
        if finished {
            return self.rough(set, baseline, HOPEFUL);
        }
        let rough = self.rough(set, &baseline.at_values_of(model), f64::NEG_INFINITY)?;
        let settings = Settings { steps: CLOSE, rounds: 1, ..self.settings.clone() };
        self.contender(set, refine(&rough.fitted, &self.train, &settings)?)
    }

    /// The model with the rigid gears that explain the recordings best.
    fn with_rigid_gears(&self, model: &Model) -> Model {
        let mut model = model.clone();
        let gears = seek_gears(&model, &self.glances(), false, &self.settings);
        for (joint, gear) in model.joints.iter_mut().zip(&gears) {
            joint.backlash = Some(gear.gear.gap);
            joint.friction.iter_mut().for_each(|friction| friction.link_share = gear.gear.share);
        }
        model
    }

    /// Sets with their soft gears and their gaps that vary at those that explain the recordings best, where the ground is far from its floor.
    fn sought<const N: usize>(
        &self,
        mut sets: [Vec<Hypothesis>; N],
        ground: &Ground,
        progress: &mut dyn FnMut(&str, f64),
    ) -> [Vec<Hypothesis>; N] {
        let any = |sets: &[Vec<Hypothesis>; N], effect: &str| {
            sets.iter().flatten().any(|set| sets::names(set).iter().any(|name| name == effect))
        };
        if !ground.finished && any(&sets, SOFT_GEAR) {
            progress("seeking soft gears", 0.15);
            let gears = seek_gears(&ground.model, &self.glances(), true, &self.settings);
            let at = |set: &Hypothesis| starts::at_sought_gears(set, &ground.model, &gears);
            sets = sets.map(|sets| sets.iter().map(at).collect());
        }
        if ground.asks_for_uneven_gaps() && any(&sets, UNEVEN_GAP) {
            progress("seeking gaps that vary", 0.25);
            let gaps = seek_uneven_gaps(&ground.whole, &ground.model, &self.train, &self.settings);
            let model = ground.whole.model();
            sets = sets.map(|sets| starts::at_uneven_gaps(sets, &model, &gaps));
        }
        sets
    }

    /// A set, fitted roughly; `hopeful`: see [`Settings::hopeful`].
    fn rough(&self, set: &Hypothesis, baseline: &Fitted, hopeful: f64) -> Result<Contender> {
        let settings = Settings { steps: ROUGH, rounds: 1, hopeful, ..self.settings.clone() };
        let set = most_probable(set, baseline, &self.glances(), KEPT, &settings)?;
        let fitted = fit(&set, baseline, &self.train, &settings)?;
        self.contender(&set, fitted)
    }

    /// The first parts of the windows.
    fn glances(&self) -> Vec<Recording> {
        self.train.iter().map(|one| self.glance(one)).collect()
    }

    /// The first part of a window.
    fn glance(&self, window: &Recording) -> Recording {
        let from = window.time.first().copied().unwrap_or(0.0);
        window.window(from, from + self.settings.burn_in + GLANCE)
    }

    /// Fits the leading sets and the baseline closely, and the union of the two best.
    fn close(&self, contenders: &mut Vec<Contender>, ground: &Ground) {
        let least = contenders[0].nats + LEADS;
        let mut order: Vec<usize> = (1..contenders.len()).filter(|one| contenders[*one].nats > least).collect();
        order.sort_by(|a, b| contenders[*b].nats.total_cmp(&contenders[*a].nats));
        // What the best set has without some of its entries follows from its own fit.
        let best = order.first().copied();
        order.retain(|one| best.is_none_or(|best| best == *one || !contenders[best].contains(&contenders[*one])));
        order.truncate(LEADING);
        // A baseline that is far from its floor may only not have been fitted far enough.
        if order.is_empty() && (ground.finished || ground.start.is_some()) {
            return;
        }
        let baseline = contenders[0].fitted.clone();
        let union = match order[..] {
            [one, other] => self.union(&contenders[one], &contenders[other], &baseline),
            _ => None,
        };
        let settings = Settings { steps: CLOSE, rounds: 1, ..self.settings.clone() };
        let again: Vec<usize> = order.iter().copied().chain(ground.start.is_none().then_some(0)).collect();
        let closer = |index: &usize| -> Result<(usize, Contender)> {
            let old = &contenders[*index];
            let fitted = self.closely(&old.fitted, &settings)?;
            Ok((*index, self.contender(&old.hypothesis, fitted)?))
        };
        let refined: Vec<Result<(usize, Contender)>> = again.par_iter().map(closer).collect();
        refined.into_iter().flatten().for_each(|(index, one)| prefer(&mut contenders[index], one));
        let beside = |index: &usize| -> Result<Contender> {
            let all: Vec<usize> = (0..contenders[*index].entries()).collect();
            self.without(&contenders[*index], &all, f64::INFINITY, &settings)
        };
        let beside: Vec<Result<Contender>> = order.par_iter().map(beside).collect();
        contenders.extend(union);
        beside.into_iter().flatten().for_each(|one| {
            enter(contenders, one);
        });
        self.thin_out(contenders, &settings);
    }

    /// Fits the best set without each of its entries, and so on while that hardly loses: the gear of one joint must not be soft because its set found that of
    /// another joint.
    fn thin_out(&self, contenders: &mut Vec<Contender>, settings: &Settings) {
        let Some(mut from) = best_of(contenders, 0..contenders.len()) else { return };
        while contenders[from].entries() > 1 {
            let least = contenders[from].nats - LEADS;
            let entries = (0..contenders[from].entries()).into_par_iter();
            let thinner: Vec<Result<Contender>> =
                entries.map(|entry| self.without(&contenders[from], &[entry], least, settings)).collect();
            let places: Vec<usize> = thinner.into_iter().flatten().map(|one| enter(contenders, one)).collect();
            match best_of(contenders, places).filter(|next| contenders[*next].nats >= least) {
                Some(next) => from = next,
                None => return,
            }
        }
    }

    /// A contender without some of its entries, from its own fit: as it is where it then still reaches `enough` [nat], so that an entry of no size is dropped and
    /// nothing else changes; otherwise fitted again.
    fn without(&self, one: &Contender, dropped: &[usize], enough: f64, settings: &Settings) -> Result<Contender> {
        let effects = one.fitted.effects();
        let kept = effects.iter().enumerate().filter(|(index, _)| !dropped.contains(index));
        let name = sets::name(&kept.map(|(_, entry)| entry).collect::<Vec<_>>());
        let hypothesis = one.hypothesis.without(dropped, name);
        let as_it_is = Settings { steps: 0, rounds: 0, ..settings.clone() };
        let with = |settings: &Settings| -> Result<Contender> {
            self.contender(&hypothesis, without(&one.fitted, dropped, &hypothesis.name, &self.train, settings)?)
        };
        match with(&as_it_is)? {
            left if left.nats >= enough => Ok(left),
            _ => with(settings),
        }
    }

    /// A fit driven further, and where it is then far from its floor, also from better gears as long as that gains.
    fn closely(&self, fitted: &Fitted, settings: &Settings) -> Result<Fitted> {
        let mut best = refine(fitted, &self.train, settings)?;
        for _ in 0..GEARS_CHANGED {
            if self.is_finished(&best)? {
                break;
            }
            let other = from_better_gears(&best, &self.train, settings)?;
            let gain = height(&other) - height(&best);
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
        self.rough(&sets::joined(&[one.fitted_start(), other.fitted_start()]), baseline, f64::NEG_INFINITY).ok()
    }

    fn contender(&self, hypothesis: &Hypothesis, fitted: Fitted) -> Result<Contender> {
        let nats = self.judged_nats(&fitted)?;
        Ok(Contender { effects: sets::names(hypothesis), fitted, nats, hypothesis: hypothesis.clone() })
    }

    /// [nat] on the windows that judge.
    fn judged_nats(&self, fitted: &Fitted) -> Result<f64> {
        Ok(fitted.score(&self.judged, &self.settings)?.iter().map(Score::sum).sum())
    }
}
