//! Whether a rotor's inertia has changed: its difference, compared with the standard error.
//!
//! An inertia shows where a joint reverses and brakes. The rigid zone leaves these rows out, because the link may float there. A comparison
//! can use them: the link floats in its gap on both sides, and the effect on single rows is an error like any
//! other, whose size follows from the scatter between blocks. Likelihoods are not valid for such rows, because their errors are correlated. So the
//! change is not tried as a candidate but estimated on all joints at once, `ΔJ_r ± σ`, beside all other changes. It
//! counts if it is large compared with `√(σ² + σ_n²)`, where `σ_n` is the natural variation. An inertia does not vary from day to day, so
//! no spread between sessions is added.

use super::quantity;
use super::robust::Estimates;
use super::select::{Changes, Sides};
use crate::diagnose::fit::cause::Cause;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::term::Term;
use crate::diagnose::rows::zones::{Margins, rigid_zone};
use crate::effects::{Diagnosable, Effect};

/// Margins that leave out only rows in which the link floats for certain. On the tuning seeds 38100 to 38104 a change of 10 % is found
/// within its error in these rows; in one eighth as many rows, without braking, its errors were up to 50 %.
const CLOSER: Margins = Margins { reversal: [0.0, 0.2], flank: [0.05, 0.15], doubt: [0.0, 0.0] };

/// Standard errors that a change has to exceed. The errors come from the scatter of blocks of 5 s, some 16 fast ones per side: Student's t
/// with as many degrees of freedom exceeds 3.5 with the probability that a normal error exceeds 3.0, the limit for other changes.
const SURE_OF_FEW: f64 = 3.5;

/// All changes, including those of rotor inertias that are significant in these rows, and by how many standard errors each of the latter
/// differs from zero; `None` where no inertia is significant.
pub fn look_closer(
    problem: &mut Problem,
    changes: &Changes,
    coulomb: &[f64],
    sides: &Sides,
) -> Option<(Changes, Vec<f64>)> {
    let zones = rigid_zone(&problem.motion, coulomb, None, &problem.held_out, &CLOSER, problem.widest_gap);
    let usual = std::mem::replace(&mut problem.zones, zones);
    let found = standing_out(problem, changes, sides);
    problem.zones = usual;
    found
}

/// Removes changes of rotor inertias from the selection: they are decided by the closer look.
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
        problem.joints().into_iter().filter(|joint| inertia.applies(&problem.motion, *joint)).collect();
    // Estimate all at once, then the significant ones again: an unchanged inertia then takes nothing from a changed one.
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
