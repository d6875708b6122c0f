//! Confirmation of the chosen effects: an effect is named if its parameters lie in their ranges and it gains on held-out data.
//!
//! The effects are chosen on the training data only. Here the held-out data are read once, for the gain of each effect. An effect without a
//! significant gain is withdrawn (where the held-out motion does not show it, the gain by cross-validation counts), the smallest gain first, and the rest is fitted again. Also withdrawn are an effect with a parameter that
//! a later fit moves out of its range, one on a joint of which the held-out data leave far more than the training data, the weakest of several effects that gain nothing together, one with too little evidence, an effect
//! that is no larger than its standard error or whose decisive parameter may be zero, one that is improbable, and one that a look-alike explains as well and whose own probability is below one half: it is more likely wrong than right.
//! Where an effect is withdrawn because its decisive parameter is smaller than its error, as the stiffness of a spring that is a constant torque, the
//! simpler effect is sought in its place. A load whose size guessed torque constants hide leaves no place to another kind of load.

use std::f64::consts::TAU;

use super::certainty::{by_chance, certainty, least_size};
use super::own_gains;
use super::selection::{Selection, Taken, evidence_beside, resettle};
use crate::diagnose::evidence::patterns::COVERED;
use crate::diagnose::fit::estimate;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::term::Term;
use crate::diagnose::fit::uncertainty::Uncertainty;
use crate::diagnose::options::{Inaccuracy, Rules};
use crate::diagnose::residuals::carried_over::CarriedOver;
use crate::diagnose::result::{EffectGain, Findings, FoundEffect, Withdrawn};
use crate::effects::{About, Catalogue};

/// [1] Probability below which a name is more likely wrong than right.
const LIKELY: f64 = 0.5;

/// [1] Probability below which a name is not given even without a look-alike: it is three times as likely wrong as right. Of names between this and
/// [`LIKELY`] on drawn arms, all two were right (`docs/blind.md`).
const UNLIKELY: f64 = 0.25;

/// A term that gets no name, why, and what would explain as much in its place.
struct Refused {
    index: usize,
    reason: String,
    rivals: Vec<String>,
    /// Whether it is no more than the effect that it would be without its decisive parameter.
    is_simpler: bool,
}

/// What is named, and what is withdrawn.
pub struct Confirmed {
    /// Gain of each term of the selection.
    pub gains: Vec<EffectGain>,
    /// [nats] Evidence of each term beside the others.
    pub strength: Vec<f64>,
    /// What was withdrawn.
    pub withdrawn: Vec<Withdrawn>,
}

/// Withdraws terms until all remaining ones gain on held-out data; `None` where the rest cannot be fitted.
///
/// The first `given` terms belong to the nominal model; of the others those are judged for which `is_effect` holds. Without `rules`, their
/// probability is judged elsewhere.
pub fn confirm(
    problem: &mut Problem,
    selection: &mut Selection,
    given: usize,
    is_effect: &dyn Fn(&Term) -> bool,
    rules: Option<&Rules>,
) -> Option<Confirmed> {
    let mut withdrawn = Vec::new();
    loop {
        // Evidence is computed with free deviations of the model; a gain is computed with the deviations held.
        problem.free();
        let strength = strength(problem, selection);
        problem.hold_again();
        let gains = own_gains::of_terms(problem, selection, given, &strength)?;
        let terms = selection.terms();
        let judged = || (given..terms.len()).filter(|index| is_effect(terms[*index]));
        let outside =
            judged().find_map(|index| Some((index, outside_of_range(problem, terms[index], selection, index)?)));
        let least = judged()
            .filter(|index| !gains[*index].shown())
            .min_by(|a, b| lower_end(&gains[*a]).total_cmp(&lower_end(&gains[*b])));
        let without_gain = least.map(|index| (index, of_gain(&gains[index])));
        let compensating = || {
            let judged: Vec<usize> = judged().collect();
            let index = least_of_compensating(problem, selection, &judged, &strength)?;
            Some((index, "together with the other effects named there, no gain on data held out".to_owned()))
        };
        let refuted = || {
            let judged: Vec<usize> = judged().collect();
            refuted(problem, selection, &judged, &strength)
        };
        let weak = || weakest(selection, &judged().collect::<Vec<_>>(), &strength, rules);
        let unsure = || least_sure(problem, selection, &judged().collect::<Vec<_>>(), rules);
        let alone = |(index, reason)| Refused { index, reason, rivals: Vec::new(), is_simpler: false };
        let found =
            outside.or(without_gain).or_else(compensating).or_else(refuted).or_else(weak).map(alone).or_else(unsure);
        let Some(Refused { index, reason, rivals, is_simpler }) = found else {
            return Some(Confirmed { gains, strength, withdrawn });
        };
        withdrawn.push(Withdrawn { effect: terms[index].effect.label(), joints: names(problem, terms[index]), reason });
        match is_simpler {
            true => problem.bar_for_simpler(terms[index]),
            false => problem.bar(terms[index]),
        }
        rivals.iter().for_each(|rival| problem.bar_rival(terms[index], rival));
        remove(selection, index);
        if given == 0 {
            selection.settle(problem)?;
        } else {
            selection.fitted = resettle(problem, &mut selection.taken)?;
        }
    }
}

/// The weakest of several terms that gain nothing together: of those of one joint alone, or of all.
fn least_of_compensating(
    problem: &Problem,
    selection: &Selection,
    judged: &[usize],
    strength: &[f64],
) -> Option<usize> {
    let terms = selection.terms();
    let of_joint = |joint: usize| -> Vec<usize> {
        judged.iter().copied().filter(|index| terms[*index].joints == [joint]).collect()
    };
    let groups = problem.joints().into_iter().map(of_joint).chain([judged.to_vec()]);
    groups
        .filter(|group| group.len() > 1)
        .find(|group| own_gains::gain_together(problem, selection, group) == Some(false))
        .and_then(|group| group.into_iter().min_by(|a, b| strength[*a].total_cmp(&strength[*b])))
}

/// The weakest term of one joint whose held-out data refute the fit, and why. A wave that the joint passes more than once has a shape of its own,
/// which no other cause takes, and what acts on several joints is determined by all of them.
fn refuted(problem: &Problem, selection: &Selection, judged: &[usize], strength: &[f64]) -> Option<(usize, String)> {
    let terms = selection.terms();
    let of_joint = |joint: usize| {
        let term = judged.iter().filter(|index| terms[**index].joints == [joint] && !is_wave(problem, terms[**index]));
        let index = term.copied().min_by(|a, b| strength[*a].total_cmp(&strength[*b]))?;
        let residual = problem.residual(&terms, &selection.fitted, joint);
        let carried = CarriedOver::to_held_out(problem, joint, &residual).filter(CarriedOver::is_refuted)?;
        let reason = format!(
            "{:.0} % of the torque are left in the data held out, {:.1} times what is left of the training data: those do not determine what acts on {}",
            carried.percent, carried.times, problem.motion.model.joints[joint].name
        );
        Some((index, reason))
    };
    problem.joints().into_iter().find_map(of_joint)
}

/// Whether a term repeats with an angle, and the joint passes more than one of its periods.
fn is_wave(problem: &Problem, term: &Term) -> bool {
    let (motion, joint) = (&problem.motion, term.joints[0]);
    let order = term.effect.harmonic().map(|harmonic| (harmonic.order)(motion, joint, &term.shape));
    order.is_some_and(|order| order * motion.range(joint) > COVERED * TAU)
}

/// The effect with the least evidence beside the others, where that is too little for a name. It was taken with more: on other joints as well,
/// or before the others were.
fn weakest(
    selection: &Selection,
    judged: &[usize],
    strength: &[f64],
    rules: Option<&Rules>,
) -> Option<(usize, String)> {
    let least = rules?.nats;
    let mut first = 0;
    let of_effect = selection.taken.iter().map(|taken| {
        let own = first..first + taken.terms.len();
        first = own.end;
        (own.start, strength[own].iter().sum::<f64>())
    });
    let weak = of_effect.filter(|(index, nats)| judged.contains(index) && *nats <= least);
    let (index, nats) = weak.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((index, format!("its evidence is only {nats:.1} nats")))
}

/// The least certain term, and why it is withdrawn: it is [too small](too_small), or [improbable](unlikely).
fn least_sure(problem: &Problem, selection: &Selection, judged: &[usize], rules: Option<&Rules>) -> Option<Refused> {
    if judged.is_empty() {
        return None;
    }
    let (terms, fitted) = (selection.terms(), &selection.fitted);
    let uncertainty = Uncertainty::new(problem, &terms, fitted)?;
    let parameters = |index: usize| estimate::parameters(problem, terms[index], index, fitted, &uncertainty);
    let size = |index: usize| {
        let at = fitted.term_at[index];
        let own = at..at + terms[index].coefficients();
        let all = uncertainty.size_in_errors(own, &fitted.solution.coefficients);
        [all, least_size(terms[index].effect.about(), &parameters(index))]
    };
    let taken: Vec<&Taken> =
        selection.taken.iter().flat_map(|taken| std::iter::repeat_n(taken, taken.terms.len())).collect();
    let certain = |index: &usize| {
        let place = (terms[*index], *index);
        let (mut rivals, p) = certainty(taken[*index], place, &parameters(*index), selection, &uncertainty, rules?);
        rivals.retain(|rival| look_alike(&problem.catalogue, terms[*index].effect.about(), rival));
        Some((rivals, p))
    };
    let small = judged.iter().filter_map(|index| Some((*index, too_small(size(*index), problem.baseline.len())?)));
    if let Some((index, least)) = small.min_by(|a, b| a.1.total_cmp(&b.1)) {
        let reason = format!("its size is only {least:.1} standard errors");
        let mut rivals = certain(&index).map_or_else(Vec::new, |(rivals, _)| rivals);
        rivals.extend(undetermined_with(problem, terms[index]));
        return Some(Refused {
            index,
            reason,
            rivals,
            is_simpler: is_simpler(size(index), terms[index].coefficients()),
        });
    }
    let certain: Vec<(Vec<String>, f64)> = judged.iter().filter_map(certain).collect();
    let refused = |(at, reason): (usize, String)| {
        let rivals = certain[at].0.clone();
        Refused { index: judged[at], reason, rivals, is_simpler: false }
    };
    unlikely(&certain).map(refused)
}

/// Other loads that look like one whose size nothing tells. Where torque constants are guesses, what hides its size is the scale of all torque, and a load of
/// another kind is no more than what the fit without the first has left.
fn undetermined_with(problem: &Problem, term: &Term) -> Vec<String> {
    if !term.effect.loads_machine() || !problem.motion.model.accuracy.guesses_torque_constants() {
        return Vec::new();
    }
    let loads = problem.causes.iter().filter(|cause| cause.loads_machine());
    let names =
        loads.map(|cause| cause.name()).filter(|name| look_alike(&problem.catalogue, term.effect.about(), name));
    names.map(str::to_owned).collect()
}

/// Whether one of two effects lists the other as a look-alike.
fn look_alike(catalogue: &Catalogue, about: &About, other: &str) -> bool {
    let listed = || catalogue.find(other).is_some_and(|other| other.about().look_alikes.contains(&about.name));
    about.look_alikes.contains(&other) || listed()
}

/// [1] Chance of a parameter of zero above which its size decides nothing: that of a 95 % interval.
const CHANCE: f64 = 0.05;

/// [standard errors] The size of an effect that is too small for a name: that of all its coefficients together below one, or that of a parameter without
/// which it would be another effect reached by [chance](by_chance) on one of `joints`.
fn too_small([all, least]: [f64; 2], joints: usize) -> Option<f64> {
    (all < 1.0 || by_chance(least, joints) > CHANCE).then_some(all.min(least))
}

/// Whether an effect is no more than the one that it would be without its decisive parameter: that parameter is smaller than its error, and the effect
/// as a whole is not. With a single coefficient nothing would be left of it.
fn is_simpler([all, least]: [f64; 2], coefficients: usize) -> bool {
    coefficients > 1 && all >= 1.0 && least < 1.0
}

/// The least probable of several names, each with the look-alikes among its rivals and its probability, if it has one and is less probable than
/// [`LIKELY`], or has none and is less probable than [`UNLIKELY`]; and the words for it.
fn unlikely(certain: &[(Vec<String>, f64)]) -> Option<(usize, String)> {
    let least = |rivals: &[String]| if rivals.is_empty() { UNLIKELY } else { LIKELY };
    let undecided = certain.iter().enumerate().filter(|(_, (rivals, p))| *p < least(rivals));
    let (at, (rivals, probability)) = undecided.min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
    let words = format!("it is only {:.0} % probable", 100.0 * probability);
    Some((
        at,
        if rivals.is_empty() { words } else { format!("{words}: {} would explain as much", rivals.join(" or ")) },
    ))
}

/// Divides effects that are seen in other data than torque along the motion: those with a gain and parameters in range, and the others.
pub fn part(effects: Vec<FoundEffect>, catalogue: &Catalogue) -> Findings {
    let mut findings = Findings::default();
    for found in effects {
        let about = catalogue.find(&found.effect).map(crate::effects::Effect::about);
        let value = |name: &str| found.parameters.get(name).map(|measured| measured.value);
        let outside = about.and_then(|about| outside(about, &value));
        match outside.or_else(|| (!found.gain.shown()).then(|| of_gain(&found.gain))) {
            None => findings.effects.push(found),
            Some(reason) => {
                findings.withdrawn.push(Withdrawn { effect: found.effect, joints: found.joints, reason });
            }
        }
    }
    findings
}

/// [nats] Evidence of each term beside all others.
fn strength(problem: &Problem, selection: &Selection) -> Vec<f64> {
    let of_taken = |index: usize| {
        let taken = &selection.taken[index];
        let evidence = evidence_beside(problem, &selection.taken, index, Inaccuracy::NONE)
            .unwrap_or_else(|| taken.evidence.clone());
        let of_term = |term: &Term| term.joints.iter().map(|joint| evidence[*joint].nats).sum::<f64>();
        taken.terms.iter().map(of_term).collect::<Vec<f64>>()
    };
    (0..selection.taken.len()).flat_map(of_taken).collect()
}

/// [%] Lower end of the interval.
const fn lower_end(gain: &EffectGain) -> f64 {
    gain.gain_interval_percent[0]
}

fn of_gain(gain: &EffectGain) -> String {
    let [low, high] = gain.gain_interval_percent;
    format!("no gain on data held out: {:.1} % ({low:.1} to {high:.1})", gain.gain_percent)
}

/// Description of the first parameter of a term that lies outside its range; or that the values of the term are not those of such an
/// effect.
fn outside_of_range(problem: &Problem, term: &Term, selection: &Selection, index: usize) -> Option<String> {
    let at = selection.fitted.term_at[index];
    let coefficients = &selection.fitted.solution.coefficients.as_slice()[at..at + term.coefficients()];
    let about = term.effect.about();
    let values = term.effect.parameters(&problem.motion, term.joints[0], &term.shape, coefficients);
    let value =
        |name: &str| about.parameters.iter().position(|spec| spec.name == name).and_then(|k| values.get(k).copied());
    let unlike = || {
        let itself = term.effect.is_itself(&problem.motion, term.joints[0], &term.shape, coefficients);
        (!itself).then(|| "fitted together with all others, its values are not those of such an effect".to_owned())
    };
    outside(about, &value).or_else(unlike)
}

fn outside(about: &About, value: &dyn Fn(&str) -> Option<f64>) -> Option<String> {
    about.parameters.iter().find_map(|spec| {
        let found = value(spec.name)?;
        (!(spec.min..=spec.max).contains(&found))
            .then(|| format!("{} = {found:.3}, outside {} to {}", spec.name, spec.min, spec.max))
    })
}

/// Names of the joints that a term acts on.
pub(super) fn names(problem: &Problem, term: &Term) -> Vec<String> {
    term.own_joints().iter().map(|joint| problem.motion.model.joints[*joint].name.clone()).collect()
}

/// Removes one term; `index` counts the terms of all effects.
fn remove(selection: &mut Selection, index: usize) {
    let mut position = 0;
    for taken in &mut selection.taken {
        taken.terms.retain(|_| {
            position += 1;
            position - 1 != index
        });
    }
    selection.taken.retain(|taken| !taken.terms.is_empty());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its words name the parameter, its value and the range.
    #[test]
    fn property_a_parameter_outside_its_range_is_a_reason() {
        let about = crate::effects::find("rotor_inertia").expect("an effect").about();
        let words = outside(about, &|name| (name == "error").then_some(-3.5));
        assert_eq!(words.as_deref(), Some("error = -3.500, outside -0.9 to 10"));
        assert_eq!(outside(about, &|name| (name == "error").then_some(0.2)), None);
        assert_eq!(outside(about, &|_| None), None);
    }

    #[test]
    fn property_a_load_whose_interval_contains_zero_has_no_name_and_a_ripple_of_its_own_error_has() {
        assert_eq!([too_small([5.0, 1.7], 1), too_small([0.9, f64::INFINITY], 1)], [Some(1.7), Some(0.9)]);
        assert_eq!([too_small([1.4, f64::INFINITY], 6), too_small([5.0, 2.0], 1)], [None, None]);
        // The largest of six: 2 · 6 (1 − Φ(2.638)) = 0.05.
        assert_eq!([too_small([5.0, 2.62], 6), too_small([5.0, 2.65], 6)], [Some(2.62), None]);
    }

    /// A spring whose stiffness may be zero is a constant torque; one whose stiffness is doubtful may be a spring.
    #[test]
    fn property_only_a_parameter_within_its_error_leaves_a_simpler_effect() {
        let simpler = |all: f64, least: f64| is_simpler([all, least], 2);
        assert!(!is_simpler([20.0, 0.7], 1), "a contact whose stiffness is doubtful");
        assert_eq!(
            [simpler(20.0, 0.7), simpler(20.0, 1.7), simpler(0.9, 0.7), simpler(20.0, f64::INFINITY)],
            [true, false, false, false]
        );
    }

    #[test]
    fn property_a_name_is_withdrawn_that_is_more_likely_wrong_than_right() {
        let name = |rivals: &[&str], probability: f64| (rivals.iter().map(ToString::to_string).collect(), probability);
        assert_eq!(unlikely(&[]), None);
        assert_eq!(unlikely(&[name(&["payload"], 0.5), name(&[], 0.43)]), None);
        assert_eq!(unlikely(&[name(&[], 0.1)]), Some((0, "it is only 10 % probable".to_owned())));
        let (at, words) = unlikely(&[name(&["cogging"], 0.49), name(&["payload", "link_inertia"], 0.44)]).unwrap();
        assert_eq!(
            (at, words.as_str()),
            (1, "it is only 44 % probable: payload or link_inertia would explain as much")
        );
    }
}
