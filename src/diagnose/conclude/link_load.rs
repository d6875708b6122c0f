//! Whether a named effect holds a link on one flank of its gear. Then the rotor reverses without crossing the gap, or crosses it
//! where a model of rotor, gap and link does not expect it.
//!
//! While the rotor reverses, a link without a load stays at rest by its own friction `s F_C`. A larger steady torque presses it
//! against one flank all the time. Correcting the motor's torque does not help, because the motion of the link stays the same. So the RMS
//! torque of the named effects, computed at rest (without acceleration), is compared with the joint's Coulomb friction.
//! Gravity of the nominal model is not judged here: the estimate of the gap includes it at every reversal.

use crate::diagnose::fit::problem::Problem;
use crate::diagnose::rows::gentlest::gentlest;
use crate::diagnose::select::selection::Selection;
use crate::effects::Motion;
use crate::timeseries::TimeSeries;
use crate::timeseries::root_mean_square;

/// Part of Coulomb friction above which a torque holds the link on a flank: on the machines of tuning seeds 4800 to 4901 it was 0.1 to
/// 0.45.
const HOLDS: f64 = 0.3;

/// Why the gap of a joint cannot be measured in the first sessions of a problem; `None` where no named effect prevents it.
pub fn why_not(problem: &Problem, selection: &Selection, joint: usize, sessions: &[&TimeSeries]) -> Option<String> {
    let motion = &problem.motion;
    let gentle = gentlest(motion.model, joint, sessions);
    let is_used = |number: usize| {
        sessions.get(number).is_some_and(|session| gentle.iter().any(|gentle| std::ptr::eq(*gentle, *session)))
    };
    let used: Vec<bool> = (0..motion.sessions).map(is_used).collect();
    let moves = |row: &usize| used[motion.session[*row]] && motion.joints[joint].direction[*row] != 0.0;
    let rows: Vec<usize> = (0..motion.rows()).filter(moves).collect();
    let at_rest = at_rest(&motion.at_rows(&rows));
    let mut torque = vec![0.0; rows.len()];
    let mut names: Vec<&str> = Vec::new();
    let terms = selection.terms().into_iter().zip(&selection.fitted.term_at);
    for (term, at) in terms.filter(|(term, _)| term.effect.loads_link() && term.joints.contains(&joint)) {
        names.push(term.effect.name());
        let coefficients = &selection.fitted.solution.coefficients.as_slice()[*at..];
        let place = term.joints.iter().position(|axis| *axis == joint).unwrap_or(0);
        for (column, c) in term.effect.columns_at(&at_rest, &term.joints, place, &term.shape).iter().zip(coefficients) {
            torque.iter_mut().zip(column).for_each(|(torque, x)| *torque += c * x);
        }
    }
    let held = root_mean_square(&torque);
    let coulomb = motion.joints[joint].friction.coulomb;
    (!names.is_empty() && held > HOLDS * coulomb).then(|| {
        let unit = motion.model.joints[joint].kind.effort_unit();
        format!(
            "{} holds the link on a flank of the gear ({held:.2} {unit} RMS, {:.0} % of Coulomb friction): the link does not cross the gap at a reversal as the estimate of the gap assumes",
            names.join(" and "),
            100.0 * held / coulomb.max(1e-300)
        )
    })
}

/// The positions of a motion, with zero speed.
fn at_rest<'m>(motion: &Motion<'m>) -> Motion<'m> {
    let mut still = motion.clone();
    for joint in &mut still.joints {
        joint.v.fill(0.0);
        joint.a.fill(0.0);
    }
    still
}
