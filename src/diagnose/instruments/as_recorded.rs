//! The nominal model on the original recordings, before any correction.

use crate::diagnose::fit::pose::{nothing_moves, pose};
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::options::Options;
use crate::diagnose::rows::division::Division;
use crate::diagnose::select::selection::Nominal;
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// Residuals of the nominal model, with their rows.
pub struct AsRecorded {
    session: Vec<usize>,
    time: Vec<f64>,
    residuals: Vec<Vec<f64>>,
}

impl AsRecorded {
    /// Builds the problem and fits the nominal model.
    pub fn new(model: &Model, sessions: &[&TimeSeries], division: Division, options: &Options) -> Result<Self> {
        let mut problem = pose(model, sessions, division, options)?;
        let nominal = nominal(&mut problem).ok_or_else(|| nothing_moves(model))?;
        let (session, time) = (problem.motion.session, problem.motion.time);
        Ok(Self { session, time, residuals: nominal.residuals })
    }

    /// The residuals at the rows of another problem, each from the nearest row in time. Corrected recordings may have other kernels.
    pub fn at_rows_of(&self, problem: &Problem) -> Vec<Vec<f64>> {
        let (sessions, times) = (&problem.motion.session, &problem.motion.time);
        if *sessions == self.session && *times == self.time {
            return self.residuals.clone();
        }
        let nearest = |(session, time): (&usize, &f64)| {
            let first = self.session.partition_point(|own| own < session);
            let last = self.session.partition_point(|own| own <= session);
            let next = first + self.time[first..last].partition_point(|own| own < time);
            let candidates = [next.saturating_sub(1).max(first), next.min(last.saturating_sub(1)).max(first)];
            let distance = |row: &usize| (self.time[*row] - time).abs();
            candidates.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(first)
        };
        let rows: Vec<usize> = sessions.iter().zip(times).map(nearest).collect();
        self.residuals.iter().map(|values| rows.iter().map(|row| values[*row]).collect()).collect()
    }
}

/// The nominal model fitted to a problem.
pub fn nominal(problem: &mut Problem) -> Option<Nominal> {
    problem.settle(&[])?;
    Nominal::new(problem)
}
