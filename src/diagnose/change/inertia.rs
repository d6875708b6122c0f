//! Whether a rotor's inertia has changed: the difference itself, against its errors.
//!
//! An inertia shows where a joint turns around and brakes, which is where the zone of a diagnosis leaves rows out, because the link may
//! float there. A comparison may look closer: the gap floats on both sides alike, and what it does to single rows is an error like any
//! other, whose size the scatter between blocks tells. Likelihoods cannot weigh such rows, since their errors hang together; so the
//! change is not tried as a candidate but estimated on every joint at once, `ΔJ_r ± σ`, beside everything else that has changed, and
//! counts where it stands out of `√(σ² + σ_n²)`, `σ_n` what is natural. An inertia does not wander from day to day: there is no spread
//! between sessions in it.

use super::quantity;
use super::robust::Estimates;
use super::select::{Changes, Sides};
use crate::diagnose::fit::cause::Cause;
use crate::diagnose::fit::problem::{Problem, Term};
use crate::diagnose::rows::zones::{Margins, rigid_zone};
use crate::effects::{Diagnosable, Effect};

/// Where the link floats for certain. On the tuning seeds 38100 to 38104 a change of 10 % is found within its error in these rows; in
/// an eighth as many, without braking, it had errors of up to 50 %.
const CLOSER: Margins = Margins { reversal: [0.0, 0.2], flank: [0.05, 0.15], doubt: [0.0, 0.0] };

/// Standard errors that a change has to exceed. The errors come from the scatter of blocks of 5 s, some 16 fast ones a side: Student's t
/// with as many degrees of freedom exceeds 3.5 as seldom as a normal error exceeds the 3.0 that other changes are asked for.
const SURE_OF_FEW: f64 = 3.5;

/// All changes with those of rotors' inertias that stand out, as the closer look estimates them, and the standing of the latter; `None`
/// where none stands out.
pub fn look_closer(
    problem: &mut Problem,
    changes: &Changes,
    coulomb: &[f64],
    sides: &Sides,
) -> Option<(Changes, Vec<f64>)> {
    let zones = rigid_zone(&problem.motion, coulomb, None, &problem.held_out, &CLOSER);
    let usual = std::mem::replace(&mut problem.zones, zones);
    let found = standing_out(problem, changes, sides);
    problem.zones = usual;
    found
}

/// Takes the changes of rotors' inertias out of what was selected: the closer look has the say.
pub fn drop_inertias(changes: &mut Changes) {
    let is_inertia = |term: &Term| term.effect.name() == quantity::rotor_inertia().name();
    for taken in &mut changes.taken {
        taken.terms.retain(|term| !is_inertia(term));
    }
    changes.taken.retain(|taken| !taken.terms.is_empty());
}

fn standing_out(problem: &Problem, changes: &Changes, sides: &Sides) -> Option<(Changes, Vec<f64>)> {
    let inertia = quantity::rotor_inertia();
    let mut joints: Vec<usize> =
        (0..problem.baseline.len()).filter(|joint| inertia.applies(&problem.motion, *joint)).collect();
    // All at once, then those that stand out among themselves: an inertia that has not changed takes nothing from one that has.
    loop {
        let terms: Vec<Term> = joints
            .iter()
            .map(|joint| Term::new(&problem.motion, Cause::change(inertia, sides.now.clone()), &[*joint], Vec::new()))
            .collect();
        let all: Vec<&Term> = changes.terms().into_iter().chain(&terms).collect();
        let first = all.len() - terms.len();
        let estimates = Estimates::new(problem, &all)?;
        let standings: Vec<f64> = terms
            .iter()
            .enumerate()
            .map(|(index, term)| {
                let own = estimates.std_error(&[(estimates.fitted.term_at[first + index], 1.0)]);
                let natural = inertia.natural * inertia.reference(problem, term.joints[0]).0;
                estimates.coefficient(first + index, 0).abs() / own.hypot(natural).max(1e-300)
            })
            .collect();
        let weakest = standings.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        if *weakest.1 >= SURE_OF_FEW {
            return Some((changes.with(terms, estimates), standings));
        }
        joints.remove(weakest.0);
        if joints.is_empty() {
            return None;
        }
    }
}
