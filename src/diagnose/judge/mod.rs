//! A finished diagnosis and its recordings → probabilities of sets of effects, by the score of every sample.
//!
//! The regression judges rows of smooth motion; this stage simulates each set of effects along the recording, reversals, rests and gaps included
//! ([`likelihood`](crate::likelihood)). It is optional, since it takes minutes.
//! - `scope`: whether it applies; `windows`: the parts of the recordings that it uses
//! - `starts`: where the fit of an effect starts; `sets`: the sets that compete
//! - `contest`: fits and scores, first of all sets, then closer of the leading ones and of their unions
//! - `floor`: whether the best set explains the recording; `posterior`: probabilities
//! - `machine`: the machine with the most probable set, which can take the place of what the regression found

mod contest;
mod floor;
mod machine;
mod posterior;
mod scope;
mod sets;
/// Where the fit of an effect starts.
pub mod starts;
mod windows;

use crate::diagnose::options;
use crate::diagnose::result::{Diagnosis, Distance, JudgedName, JudgedSet, JudgedWindow, Judgement};
use crate::diagnose::rows::division::Division;
use crate::effects::Catalogue;
use crate::error::Result;
use crate::likelihood::{Recording, Settings};
use crate::timeseries::TimeSeries;
use contest::{Contender, Contest};
pub use machine::adopt;
use windows::Window;

/// Options of the stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// [s] Time after which no further set is tried; the fit of a set is not interrupted.
    pub seconds: f64,
    /// Effects that are tried beside what the regression named.
    pub unseen: Vec<&'static str>,
    /// [1] Part at the end of each training session that is held out when there are no held-out sessions, as in the diagnosis: nothing is fitted to it.
    pub held_out_share: f64,
    /// Effects that there are.
    pub catalogue: Catalogue,
}

impl Default for Options {
    /// Five minutes: two joints take one to five on two cores.
    fn default() -> Self {
        let options::Options { held_out_share, catalogue, .. } = options::Options::default();
        Self { seconds: 300.0, unseen: sets::UNSEEN.to_vec(), held_out_share, catalogue }
    }
}

/// [s] At the start of a window, not scored: the state of the gear is known after a reversal, which a window begins with or soon has.
const BURN_IN: f64 = 1.0;
/// [1] Probability from which an effect is listed.
const LISTED: f64 = 0.05;

/// Judges a diagnosis by simulation; `progress` receives the current step and the finished share (0 to 1).
///
/// # Errors
/// The fitted model cannot be simulated, or a recording lacks a channel. Where the stage does not apply, the judgement says why.
pub fn judge(
    diagnosis: &Diagnosis,
    train: &[TimeSeries],
    hold_out: &[TimeSeries],
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Judgement> {
    let sessions: Vec<&TimeSeries> = train.iter().chain(hold_out).collect();
    if let Some(reason) = scope::refusal(diagnosis, &sessions) {
        return Ok(Judgement::not_applied(reason));
    }
    let model = &diagnosis.baseline_model;
    let recordings = sessions.iter().map(|session| Recording::new(model, session)).collect::<Result<Vec<_>>>()?;
    // One for each joint, as staircases move them, and two for the motion of all.
    let count = model.joints.len() + 2;
    let division = Division::of(&sessions, train.len(), options.held_out_share);
    let [fitted, judged] = windows::choose(model, &sessions, &recordings, division, count);
    if fitted.len() < 2 || judged.len() < 2 {
        return Ok(Judgement::not_applied("The recordings are too short for windows to fit and windows to judge."));
    }
    let cut = |windows: &[Window]| -> Vec<Recording> {
        windows.iter().map(|one| recordings[one.session].window(one.from, one.to)).collect()
    };
    let contest = Contest {
        train: cut(&fitted),
        judged: cut(&judged),
        joints: model.joints.len(),
        settings: Settings { burn_in: BURN_IN, catalogue: options.catalogue.clone(), ..Settings::default() },
        seconds: options.seconds,
    };
    let sets = sets::of(diagnosis, &options.unseen);
    let (contenders, not_tried) = contest.hold(model, &sets, progress)?;
    let mut judgement = conclude(diagnosis, &contest, &contenders)?;
    judgement.not_tried = not_tried;
    judgement.windows = [(&fitted, true), (&judged, false)]
        .into_iter()
        .flat_map(|(windows, fitted)| windows.iter().map(move |one| (one, fitted)))
        .map(|(one, fitted)| JudgedWindow {
            session: recordings[one.session].name.clone(),
            from: one.from,
            to: one.to,
            fitted,
        })
        .collect();
    Ok(judgement)
}

/// Distance of the best set from its floor and, where it is near, the probabilities; the first contender is the baseline.
fn conclude(diagnosis: &Diagnosis, contest: &Contest, contenders: &[Contender]) -> Result<Judgement> {
    let Some(baseline) = contenders.first() else { return Ok(Judgement::default()) };
    let mut order: Vec<&Contender> = contenders.iter().collect();
    order.sort_by(|a, b| b.nats.total_cmp(&a.nats));
    let best = order.first().copied().unwrap_or(baseline);
    let readings = contest.readings(&contest.judged);
    let distance = Distance {
        baseline: baseline.nats / readings,
        best: best.nats / readings,
        floor: contest.floor(&best.fitted, &contest.judged)?,
        missed_torque: floor::missed(&best.fitted.lambda),
    };
    let unexplained = floor::is_far(distance.best, distance.floor, &distance.missed_torque);
    let scored = order.iter().map(|one| posterior::Scored {
        effects: one.effects.len(),
        entries: one.entries(),
        nats: one.nats,
    });
    let scored: Vec<posterior::Scored> = scored.collect();
    let probabilities = posterior::of_sets(&scored, contest.settings.catalogue.iter().count(), contest.joints);
    let sets = order.iter().zip(&probabilities).map(|(one, probability)| JudgedSet {
        name: one.name().to_owned(),
        effects: one.effects.clone(),
        gain_nats: one.nats - baseline.nats,
        probability: (!unexplained).then_some(*probability),
        sizes: one.sizes(),
    });
    let sets = sets.collect();
    let names = if unexplained { Vec::new() } else { names(&order, &probabilities) };
    let catalogue = &contest.settings.catalogue;
    let machine = || machine::most_probable(diagnosis, baseline, &order, &probabilities, &names, catalogue);
    Ok(Judgement {
        machine: if unexplained { None } else { machine() },
        names,
        unexplained,
        distance: Some(distance),
        sets,
        ..Judgement::default()
    })
}

/// Effects that are not improbable, the most probable one first; contenders in falling order of their scores.
fn names(order: &[&Contender], probabilities: &[f64]) -> Vec<JudgedName> {
    let sets: Vec<Vec<String>> = order.iter().map(|one| one.effects.clone()).collect();
    let mut effects: Vec<String> = Vec::new();
    for effect in sets.iter().flatten() {
        if !effects.contains(effect) {
            effects.push(effect.clone());
        }
    }
    let share = |effect: &String, without: &str| {
        let others = sets.iter().zip(probabilities);
        let others = others.filter(|(set, _)| set.contains(effect) && !set.iter().any(|one| one == without));
        others.map(|(_, probability)| probability).sum::<f64>()
    };
    let name = |effect: &String| JudgedName {
        joints: most_probable_joints(effect, order, probabilities),
        probability: posterior::of_name(effect, &sets, probabilities),
        confusable_with: effects.iter().filter(|other| share(other, effect) >= LISTED).cloned().collect(),
        effect: effect.clone(),
    };
    let mut names: Vec<JudgedName> = effects.iter().map(name).filter(|name| name.probability >= LISTED).collect();
    names.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    names
}

/// Joints of an effect in the most probable set that contains it.
fn most_probable_joints(effect: &str, order: &[&Contender], probabilities: &[f64]) -> Vec<String> {
    let with = order.iter().zip(probabilities).filter(|(one, _)| one.effects.iter().any(|own| own == effect));
    let best = with.max_by(|a, b| a.1.total_cmp(b.1));
    best.map_or_else(Vec::new, |(one, _)| one.joints(effect))
}
