//! Training sessions of which far more torque is left than of the others: another load, another scale, something that acts in them alone.
//!
//! ```text
//!   e_s > 3 e_o,   e_s > 10 floors,   e_s > 15 % of the session's torque
//! ```
//! with the residual `e_s` of a session and the median `e_o` of those of the other training sessions. A robust fit follows most rows, so
//! that the session that differs is left over, and no effect that acts in all sessions describes it.
//! Reference: P. J. Huber, E. M. Ronchetti (2009), Robust Statistics, ch. 1 (gross errors).

use super::unexplained::FAR_ABOVE_FLOOR;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::residuals::Residual;
use crate::diagnose::residuals::carried_over::{CarriedOver, rms};
use crate::diagnose::result::Unexplained;
use crate::identify::statistics::typical;
use crate::timeseries::TimeSeries;

/// Judged rows that a session needs: the RMS of 20 independent ones is within 16 % (one standard deviation).
const LEAST_ROWS: usize = 20;

/// How the residual of a session is measured: by most of its rows, or by all of them.
pub enum Of {
    /// The typical residual: an episode of a few seconds does not count.
    MostRows,
    /// The RMS, where no link floats.
    AllRows,
}

/// Sessions that differ, by joint. `floor` is that of the sensors in every row.
pub fn odd_sessions(
    problem: &Problem,
    sessions: &[&TimeSeries],
    residuals: &[Residual],
    floor: &[Vec<f64>],
    of: Of,
) -> Vec<Unexplained> {
    let of_joint = |joint: usize| {
        let residual = &residuals[joint].after;
        let left = |rows: &[usize]| match of {
            Of::AllRows if !problem.floating[joint] => rms(residual, rows),
            _ => typical(rows.iter().map(|row| residual[*row])),
        };
        let rows = by_session(problem, joint, sessions.len());
        let trained = |rows: &&Vec<usize>| !problem.held_out[rows[0]];
        let odd = |own: &Vec<usize>| -> Option<(String, CarriedOver, f64)> {
            let mut others: Vec<f64> =
                rows.iter().filter(|rows| *rows != own).filter(trained).map(|rows| left(rows)).collect();
            others.sort_by(f64::total_cmp);
            // The lower one of two: of three sessions that differ each from the others, none is odd.
            let usual = *others.get(others.len().checked_sub(1)? / 2)?;
            let torque = rms(&problem.motion.joints[joint].torque, own);
            let carried = CarriedOver::new(left(own), torque, usual);
            let floors = carried.left / rms(&floor[joint], own);
            let name = sessions[problem.motion.session[own[0]]].name.clone();
            (carried.is_refuted() && floors > FAR_ABOVE_FLOOR).then_some((name, carried, floors))
        };
        let found: Vec<_> = rows.iter().filter(trained).filter_map(odd).collect();
        words(&found).map(|pattern| Unexplained { joint: problem.motion.model.joints[joint].name.clone(), pattern })
    };
    problem.joints().into_iter().filter_map(of_joint).collect()
}

/// Judged rows of a joint in each session that has enough of them. A session of both parts counts with its training rows.
fn by_session(problem: &Problem, joint: usize, sessions: usize) -> Vec<Vec<usize>> {
    let mut rows: Vec<Vec<usize>> = vec![Vec::new(); sessions];
    let judged = (0..problem.motion.rows()).filter(|row| problem.judged[joint][*row]);
    judged.for_each(|row| rows[problem.motion.session[row]].push(row));
    for own in &mut rows {
        if own.iter().any(|row| !problem.held_out[*row]) {
            own.retain(|row| !problem.held_out[*row]);
        }
    }
    rows.retain(|own| own.len() >= LEAST_ROWS);
    rows
}

/// What is said of the sessions of a joint that differ.
fn words(found: &[(String, CarriedOver, f64)]) -> Option<String> {
    let (_, carried, floors) = found.iter().max_by(|a, b| a.1.times.total_cmp(&b.1.times))?;
    let names: Vec<&str> = found.iter().map(|(name, ..)| name.as_str()).collect();
    let [sessions, them] = if names.len() == 1 { ["session", "it"] } else { ["sessions", "them"] };
    Some(format!(
        "{sessions} {}: {:.0} % of the torque, {floors:.0} times what the sensors and {:.0} times what the model leaves of the other sessions: another load or scale, or something that acts in {them} alone. Leave {them} out, or find what differs by `--reference`",
        names.join(" and "),
        carried.percent,
        carried.times,
    ))
}
