//! How sure the name of an effect is: against its rivals, and against a size of zero.

use std::collections::BTreeMap;

use super::candidates::{Candidate, FAR};
use super::selection::{Selection, Taken};
use crate::diagnose::evidence::probability::beside_rivals;
use crate::diagnose::fit::term::Term;
use crate::diagnose::fit::uncertainty::Uncertainty;
use crate::diagnose::options::{MODEL_ERROR, Rules};
use crate::diagnose::result::Measured;
use crate::distributions::normal_upper_tail;
use crate::effects::About;

/// The rivals of a term that cannot be rejected, and the probability (0 to 1) that its effect is the right one; `position` counts the terms of
/// the selection.
pub fn certainty(
    taken: &Taken,
    (term, position): (&Term, usize),
    parameters: &BTreeMap<String, Measured>,
    selection: &Selection,
    uncertainty: &Uncertainty,
    rules: &Rules,
) -> (Vec<String>, f64) {
    let (confusable_with, probability) = rivals(taken, rules);
    let at = selection.fitted.term_at[position];
    let own = at..at + term.coefficients();
    let all = uncertainty.size_in_errors(own, &selection.fitted.solution.coefficients);
    let least = least_size(term.effect.about(), parameters);
    let by_chance = by_chance(all, 1).max(by_chance(least, selection.nominal.residuals.len()));
    (confusable_with, probability * (1.0 - by_chance))
}

/// [standard errors] Size of the least parameter without which an effect would be another; infinite where it has none.
pub fn least_size(about: &About, parameters: &BTreeMap<String, Measured>) -> f64 {
    let sizes = about.parameters.iter().filter(|spec| spec.is_size).filter_map(|spec| parameters.get(spec.name));
    sizes.map(|one| (one.value / one.std_error).abs()).fold(f64::INFINITY, f64::min)
}

/// Bound of Bonferroni on the probability that the largest of `tries` sizes that are zero reaches `z` standard errors: `2n (1 − Φ(z))`. A parameter
/// is tried on each of `n` joints, or links, and named where it is largest.
pub fn by_chance(z: f64, tries: usize) -> f64 {
    (2.0 * normal_upper_tail(z) * tries as f64).min(1.0)
}

/// Share of the evidence above which a rival cannot be rejected.
const CLOSE: f64 = 0.85;

/// Effects with nearly as much evidence, and the probability that the chosen effect is the right one.
fn rivals(taken: &Taken, rules: &Rules) -> (Vec<String>, f64) {
    let total: f64 = taken.evidence.iter().map(|evidence| evidence.nats).sum();
    let joints: Vec<usize> = taken.terms.iter().flat_map(|term| term.joints.clone()).collect();
    let own: usize = taken.terms.iter().map(Term::complexity).sum();
    // An inaccurate law costs evidence in proportion to the number of rows; the error that it leaves does not depend on that number.
    let worse = |rival: &Candidate| {
        let on = |joint: &usize| rival.evidence[*joint].worse_than(&taken.evidence[*joint]);
        joints.iter().map(on).fold(f64::NEG_INFINITY, f64::max)
    };
    // Many rows show a line of a thousandth of the torque beyond doubt; it is there or not, whatever else explains the torque.
    let slight = |rival: &Candidate| rival.log_scale() <= rules.log_scale && worse(rival) > MODEL_ERROR;
    let able =
        || taken.rivals.iter().filter(|rival| rival.is_sensible() && !slight(rival) && contested(rival, &joints).1 > 0);
    let close = |rival: &&Candidate| {
        let share = contested(rival, &joints).0 / total;
        share > CLOSE || share > FAR && worse(rival) < MODEL_ERROR
    };
    let names = able().filter(close).map(|rival| rival.effect().name().to_owned()).collect();
    let probability = probability(total, own, rules, able().map(|rival| contested(rival, &joints)));
    (names, probability)
}

/// Evidence [nats] and complexity of a rival where it competes for these joints: an effect of other joints explains nothing of theirs.
fn contested(rival: &Candidate, joints: &[usize]) -> (f64, usize) {
    if rival.terms[0].is_machine() {
        return (rival.total(), rival.complexity());
    }
    let nats = joints.iter().map(|joint| rival.evidence[*joint].nats).sum();
    let terms = rival.terms.iter().filter(|term| joints.contains(&term.joints[0]));
    (nats, terms.map(Term::complexity).sum())
}

/// Probability that an effect with this evidence is the true one. Every model is somewhat inaccurate, so differences of evidence count relative
/// to the evidence. A rival, with its evidence and complexity, is penalised if it has more parameters than the effect. No effect at all is a rival too, with as much evidence
/// as inaccurate laws leave behind.
pub fn probability(total: f64, own: usize, rules: &Rules, rivals: impl Iterator<Item = (f64, usize)>) -> f64 {
    let unit = rules.tied(total);
    let odds = |difference: f64| (difference / unit).exp();
    let of_rival = |(nats, complexity): (f64, usize)| {
        let extra = complexity.saturating_sub(own).min(1) as f64;
        odds(nats - total - extra * (rules.tie * total + unit))
    };
    let of_rivals: f64 = rivals.map(of_rival).sum();
    beside_rivals(of_rivals, odds(rules.further - total))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::evidence::prediction::Evidence;
    use crate::effects::{Effect, find};

    /// Of a name on one of two joints, by evidence and the fall of the error's logarithm.
    fn candidate(name: &str, joint: usize, nats: f64, log_scale: f64) -> Candidate {
        let effect = find(name).and_then(Effect::diagnosable).expect("a diagnosable effect of the catalogue").into();
        let columns = vec![vec![Vec::new()]];
        let term = Term { effect, joints: vec![joint], shape: Vec::new(), free_shapes: 0, columns, near: Vec::new() };
        let mut evidence = vec![Evidence { error: 1.0, ..Evidence::default() }; 2];
        evidence[joint] = Evidence { nats, log_scale, error: (-log_scale).exp() };
        Candidate { terms: vec![term], evidence, choice: vec![0.0; 2], oddity: None }
    }

    /// A spring that halves the error has little evidence beside deviations that imitate it. A ripple of one percent of the error with three times the
    /// evidence does not make it less probable, nor does one of another joint; one that lowers the error by as much does.
    #[test]
    fn property_a_rival_that_could_not_explain_as_much_takes_no_probability() {
        let rules = Rules::default();
        let of = |rival: Candidate| {
            let Candidate { terms, evidence, .. } = candidate("cable_spring", 0, 20.0, 0.7);
            rivals(&Taken { terms, evidence, rivals: vec![rival] }, &rules)
        };
        let (names, without) = of(candidate("cogging", 0, 0.0, 0.0));
        assert!(names.is_empty() && without > 0.5, "{without}");
        for other in [candidate("cogging", 1, 60.0, 0.7), candidate("cogging", 0, 60.0, 0.01)] {
            let (names, beside) = of(other);
            assert!(names.is_empty() && beside >= without, "{names:?} {beside} {without}");
        }
        let (names, beside) = of(candidate("cogging", 0, 60.0, 0.7));
        assert!(names == ["cogging"] && beside < 0.5 * without, "{names:?} {beside} {without}");
    }

    fn measured(values: [(&str, f64, f64); 2]) -> BTreeMap<String, Measured> {
        let one =
            |(name, value, std_error): (&str, f64, f64)| (name.to_owned(), Measured { value, std_error, unit: "" });
        values.map(one).into()
    }

    /// Both coefficients of the spring together are 50 standard errors: a constant torque would be as much.
    #[test]
    fn property_a_spring_is_as_sure_as_its_stiffness() {
        let about = find("cable_spring").expect("of the catalogue").about();
        let spring = measured([("stiffness", 2.5, 2.7), ("rest_position", 0.95, 0.98)]);
        let size = least_size(about, &spring).min(50.0);
        assert_eq!(size, 2.5 / 2.7);
        // 2 (1 − Φ(0.9259)) = 0.3545.
        assert!((by_chance(size, 1) - 0.3545).abs() < 1e-4);
        assert_eq!([by_chance(size, 3), by_chance(f64::INFINITY, 6)], [1.0, 0.0]);
    }

    #[test]
    fn property_a_phase_near_zero_says_nothing_of_the_size() {
        let about = find("cogging").expect("of the catalogue").about();
        let ripple = measured([("amplitude", 0.5, 0.05), ("phase", 0.01, 0.5)]);
        assert_eq!(least_size(about, &ripple), f64::INFINITY);
    }
}
