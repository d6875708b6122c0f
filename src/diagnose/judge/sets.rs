//! Sets of effects as hypotheses: what the regression named, that set with a member less, another or more, and effects that the regression cannot see.

use super::starts;
use crate::diagnose::result::Diagnosis;
use crate::likelihood::{Free, Hypothesis, Scale, Start};
use crate::robot::{EffectEntry, Model};

/// Effects that leave no torque in smooth motion away from reversals, which is what the regression judges. `presliding` is not among them: the filter
/// corrects the rotor's angle, but not the bend of the bristles, so that it loses the track of a machine that has them.
pub const UNSEEN: [&str; 3] = ["joint_compliance", "dwell_stiction", "position_dependent_backlash"];

/// A size from the regression may be off by so many standard errors, and at least by this share of itself: laws differ between the two stages.
const ERRORS: f64 = 3.0;
const LEAST_SHARE: f64 = 0.05;
/// Most starts of a set of several effects.
const MOST_STARTS: usize = 64;

/// Sets that compete with the baseline.
pub struct Sets {
    /// All that the regression named.
    pub known: Option<Known>,
    /// Sets that lack a part of it.
    pub others: Vec<Hypothesis>,
    /// What is tried beside all of it.
    pub more: Vec<Hypothesis>,
}

/// What the regression named.
pub struct Known {
    pub set: Hypothesis,
    /// The machine without these effects, with the friction and the gaps that the regression found beside them.
    pub model: Model,
}

/// The sets of a diagnosis; `unseen`: effects to try beside what was named.
pub fn of(diagnosis: &Diagnosis, unseen: &[&str]) -> Sets {
    let model = &diagnosis.baseline_model;
    let named = named(diagnosis);
    let more: Vec<Hypothesis> = unseen.iter().flat_map(|effect| starts::of(effect, model, &[])).collect();
    if named.is_empty() {
        return Sets { known: None, others: Vec::new(), more };
    }
    let mut others = Vec::new();
    for (index, found) in diagnosis.effects.iter().take(named.len()).enumerate() {
        let rest: Vec<Hypothesis> = without(&named, index);
        if !rest.is_empty() {
            others.push(joined(&rest));
        }
        let rivals = found.confusable_with.iter().flat_map(|rival| starts::of(rival, model, &[]));
        others.extend(rivals.map(|rival| joined(&[rest.clone(), vec![rival]].concat())));
    }
    others.extend(more.iter().cloned());
    let known = joined(&named);
    let mut names = vec![known.name.clone()];
    others.retain(|set| {
        let new = !names.contains(&set.name);
        names.push(set.name.clone());
        new
    });
    let mut model = diagnosis.extended_model.clone();
    model.effects.truncate(diagnosis.baseline_model.effects.len());
    Sets { known: Some(Known { set: known, model }), others, more }
}

fn without(named: &[Hypothesis], index: usize) -> Vec<Hypothesis> {
    named.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, one)| one.clone()).collect()
}

/// What the regression named, one hypothesis for each effect: its values are the starts, and what it measured is free.
fn named(diagnosis: &Diagnosis) -> Vec<Hypothesis> {
    let [before, after] = [&diagnosis.baseline_model.effects, &diagnosis.extended_model.effects];
    let added = after.get(before.len()..).unwrap_or(&[]);
    let one = |(entry, found): (&EffectEntry, &crate::diagnose::FoundEffect)| {
        let free = found.parameters.iter().filter(|(_, measured)| measured.std_error > 0.0);
        let free = free.map(|(parameter, measured)| Free {
            effect: 0,
            parameter: parameter.clone(),
            scale: Scale::By((ERRORS * measured.std_error).max(LEAST_SHARE * measured.value.abs())),
        });
        Hypothesis { name: name(&[entry]), starts: vec![Start::new(vec![entry.clone()])], free: free.collect() }
    };
    added.iter().zip(&diagnosis.effects).map(one).collect()
}

/// One hypothesis of several: all of their effects, from every combination of their starts up to a limit.
pub fn joined(parts: &[Hypothesis]) -> Hypothesis {
    let mut starts = vec![Start::new(Vec::new())];
    let mut free = Vec::new();
    let mut effects = 0;
    for part in parts {
        let both = |start: &Start, more: &Start| {
            let joints = start.gears.len().max(more.gears.len());
            let gear = |joint: usize| [more, start].into_iter().find_map(|one| *one.gears.get(joint)?);
            Start { effects: [&start.effects[..], &more.effects].concat(), gears: (0..joints).map(gear).collect() }
        };
        starts = starts.iter().flat_map(|start| part.starts.iter().map(move |more| both(start, more))).collect();
        starts.truncate(MOST_STARTS);
        free.extend(part.free.iter().map(|free| Free { effect: free.effect + effects, ..free.clone() }));
        effects += part.starts.first().map_or(0, |start| start.effects.len());
    }
    let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    Hypothesis { name: names.join(" + "), starts, free }
}

/// What a set of effects on their joints is called.
pub fn name(entries: &[&EffectEntry]) -> String {
    let one = |entry: &&EffectEntry| match &entry.joint {
        Some(joint) => format!("{} {joint}", entry.effect),
        None => entry.effect.clone(),
    };
    entries.iter().map(one).collect::<Vec<_>>().join(" + ")
}

/// Names of its effects in the catalogue, each once.
pub fn names(hypothesis: &Hypothesis) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for entry in hypothesis.starts.iter().take(1).flat_map(|start| &start.effects) {
        if !names.contains(&entry.effect) {
            names.push(entry.effect.clone());
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(effect: &str, starts: usize) -> Hypothesis {
        let entry = || EffectEntry { effect: effect.to_owned(), joint: None, parameters: [].into() };
        let free = Free { effect: 0, parameter: "size".to_owned(), scale: Scale::By(1.0) };
        Hypothesis {
            name: effect.to_owned(),
            starts: (0..starts).map(|_| Start::new(vec![entry()])).collect(),
            free: vec![free],
        }
    }

    #[test]
    fn property_a_set_has_all_effects_and_the_parameters_of_each() {
        let set = joined(&[one("a", 2), one("b", 3)]);
        assert_eq!((set.starts.len(), set.starts[0].effects.len()), (6, 2));
        assert_eq!(set.free.iter().map(|free| free.effect).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(names(&set), ["a", "b"]);
        assert_eq!(set.name, "a + b");
    }

    #[test]
    fn property_starts_of_a_set_are_limited() {
        assert_eq!(joined(&[one("a", 48), one("b", 48)]).starts.len(), MOST_STARTS);
    }
}
