//! Residues: terms that move little torque beside another effect of their joint, and are mostly what that effect's law leaves. They come back
//! where the other effect is withdrawn.

use super::selection::{Taken, resettle, terms_of};
use crate::diagnose::fit::problem::{Part, Problem};
use crate::diagnose::fit::term::Term;
use crate::diagnose::options::Rules;

/// A term that moves little torque beside another effect.
pub struct Residue {
    /// The term, as an effect.
    taken: Taken,
    /// The other effect.
    beside: &'static str,
}

/// Takes again what was dropped beside effects that are taken no longer; returns whether that is anything. It is no substitute for what was
/// withdrawn on its joint: both were taken together.
pub fn restore(residues: &mut Vec<Residue>, taken: &mut Vec<Taken>) -> bool {
    let is_taken = |residue: &Residue| taken.iter().any(|taken| taken.terms[0].effect.about().name == residue.beside);
    let (still, restored): (Vec<_>, Vec<_>) = std::mem::take(residues).into_iter().partition(is_taken);
    *residues = still;
    let before = taken.len();
    for Residue { taken: one, .. } in restored {
        let is_it = |term: &&Term| term.effect == one.terms[0].effect && term.joints == one.terms[0].joints;
        if !terms_of(taken).iter().any(is_it) {
            taken.push(one);
        }
    }
    taken.len() > before
}

/// RMS torque [N·m or N] that each taken effect moves on each joint: `moved[effect][joint]`.
fn moved_torque(problem: &Problem, taken: &[Taken]) -> Option<Vec<Vec<f64>>> {
    let all = terms_of(taken);
    let with = problem.fit_loosely(&all, Part::Train)?;
    let moved = |index: usize| {
        let others: Vec<&Term> =
            taken.iter().enumerate().filter(|(other, _)| *other != index).flat_map(|(_, taken)| &taken.terms).collect();
        let without = problem.fit_beside(&others, &with)?;
        let pairs = with.solution.residual.iter().zip(&without.solution.residual);
        Some(
            pairs
                .map(|(a, b)| {
                    let power: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
                    (power / a.len().max(1) as f64).sqrt()
                })
                .collect(),
        )
    };
    (0..taken.len()).map(moved).collect()
}

/// Drops terms that move little torque, in absolute terms or relative to another effect of their joint; returns the latter.
pub fn drop_residues(problem: &mut Problem, rules: &Rules, taken: &mut Vec<Taken>) -> Option<Vec<Residue>> {
    if taken.is_empty() {
        return Some(Vec::new());
    }
    let moved = moved_torque(problem, taken)?;
    let names: Vec<_> = taken.iter().map(|taken| taken.terms[0].effect.about()).collect();
    let beside = |joint: usize, own: usize, other: usize| {
        let (strong, weak) = (names[other], names[own]);
        let alike = strong.look_alikes.contains(&weak.name) || weak.look_alikes.contains(&strong.name);
        let part = if alike || strong.name == weak.name { rules.alike_residue } else { rules.residue };
        part * moved[other][joint]
    };
    let strongest = |joint: usize, own: usize| {
        let part = |other: &usize| beside(joint, own, *other);
        (0..moved.len()).max_by(|a, b| part(a).total_cmp(&part(b))).unwrap_or(own)
    };
    let of_others = |joint: usize, own: usize| beside(joint, own, strongest(joint, own));
    let least = |joint: usize, own: usize| rules.torque_of(names[own]) * problem.rms_torque(joint);
    let mut residues = Vec::new();
    for (own, one) in taken.iter_mut().enumerate() {
        let whole = one.clone();
        one.terms.retain(|term| {
            let over = |limit: &dyn Fn(usize, usize) -> f64| {
                term.joints.iter().any(|joint| moved[own][*joint] >= limit(*joint, own))
            };
            let enough = over(&|joint, own| of_others(joint, own).max(least(joint, own)));
            // A cause of the machine explains a part of anything: it stays out.
            if !enough && !term.is_machine() && over(&least) {
                let taken = Taken { terms: vec![term.clone()], ..whole.clone() };
                residues.push(Residue { taken, beside: names[strongest(term.joints[0], own)].name });
            }
            enough
        });
    }
    taken.retain(|taken| !taken.terms.is_empty());
    resettle(problem, taken)?;
    Some(residues)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Effect, find};

    fn taken(name: &str, joint: usize) -> Taken {
        let effect = find(name).and_then(Effect::diagnosable).expect("a diagnosable effect of the catalogue").into();
        let term = Term {
            effect,
            joints: vec![joint],
            shape: Vec::new(),
            free_shapes: 0,
            columns: Vec::new(),
            near: Vec::new(),
        };
        Taken { terms: vec![term], evidence: Vec::new(), rivals: Vec::new() }
    }

    fn names(taken: &[Taken]) -> Vec<(&'static str, usize)> {
        terms_of(taken).iter().map(|term| (term.effect.about().name, term.joints[0])).collect()
    }

    #[test]
    fn property_a_residue_stays_out_while_its_stronger_effect_is_taken_and_comes_back_once() {
        let residue = |name, joint| Residue { taken: taken(name, joint), beside: "payload" };
        let mut residues = vec![residue("rotor_inertia", 3), residue("rotor_inertia", 4), residue("cogging", 3)];
        let mut beside = vec![taken("payload", 0)];
        assert!(!restore(&mut residues, &mut beside));
        assert_eq!((names(&beside), residues.len()), (vec![("payload", 0)], 3));

        // The rotor of joint 4 was found again meanwhile.
        let mut without = vec![taken("rotor_inertia", 4)];
        assert!(restore(&mut residues, &mut without));
        assert_eq!(names(&without), [("rotor_inertia", 4), ("rotor_inertia", 3), ("cogging", 3)]);
        assert!(residues.is_empty() && !restore(&mut residues, &mut without));
    }
}
