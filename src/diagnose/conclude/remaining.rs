//! What no effect explains, in words: of sessions that differ, shapes, residuals and loads one a joint, what says most first.

use super::odd_sessions::{Of, odd_sessions};
use super::{implausible, undecided, unexplained};
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::options::Rules;
use crate::diagnose::residuals::Residual;
use crate::diagnose::result::{FitError, Unexplained};
use crate::diagnose::select::selection::Selection;
use crate::robot::Masses;
use crate::timeseries::TimeSeries;

/// What is judged.
pub struct Remaining<'r, 'm> {
    /// The rows and the model.
    pub problem: &'r Problem<'m>,
    /// The effects and their fit.
    pub selection: &'r Selection,
    /// The recordings of the rows.
    pub sessions: &'r [&'r TimeSeries],
    /// Residuals of each joint.
    pub residuals: &'r [Residual],
    /// Floor of the sensors in every row of each joint [N·m or N].
    pub floor: &'r [Vec<f64>],
    /// Error figures.
    pub fit: &'r [FitError],
}

impl Remaining<'_, '_> {
    /// What remains, beside what instruments have `seen`.
    pub fn unexplained(&self, seen: Vec<Unexplained>, rules: &Rules) -> Vec<Unexplained> {
        let Self { problem, selection, residuals, fit, .. } = *self;
        let masses = problem.motion.model.masses;
        let mut all = self.odd(Of::MostRows);
        let odd = all.len();
        let patterns = match masses {
            Masses::Known => unexplained::unexplained(problem, &selection.terms(), rules, &|_| true),
            Masses::Estimated => unexplained::unjudged(problem, residuals),
        };
        // A shape that describes one session says nothing of all.
        add_silent(&mut all, patterns);
        all.extend(seen);
        all.extend(unexplained::shapeless(problem, residuals, fit, &all));
        if masses == Masses::Known {
            all.extend(unexplained::pressed(problem, residuals, &selection.fitted, fit, &all));
        }
        add_silent(&mut all, self.odd(Of::AllRows));
        all.extend(implausible::deviations(problem));
        undecided::add(problem, selection, rules, &mut all[odd..]);
        all
    }

    fn odd(&self, of: Of) -> Vec<Unexplained> {
        odd_sessions(self.problem, self.sessions, self.residuals, self.floor, of)
    }
}

/// Adds what is said of joints of which nothing was said before.
fn add_silent(all: &mut Vec<Unexplained>, further: Vec<Unexplained>) {
    let said: Vec<String> = all.iter().map(|known| known.joint.clone()).collect();
    all.extend(further.into_iter().filter(|one| !said.contains(&one.joint)));
}
