//! Residuals before and after: error figures, and residuals per sample. Maps, shares and spectra are in their own files.

use super::Residual;
use super::gains;
use super::shares;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::result::{FitError, ResidualSeries, Split};
use crate::replay::Gain;
use crate::timeseries::TimeSeries;
use crate::timeseries::root_mean_square;
use crate::units::JointKind;

/// RMS errors over the rigid zone, for training data and held-out data.
pub fn fit_errors(problem: &Problem, residuals: &[Residual], floor: &[Vec<f64>]) -> Vec<FitError> {
    let mut errors = Vec::new();
    for (joint, residual) in residuals.iter().enumerate() {
        let model = &problem.motion.model.joints[joint];
        for (split, held) in [(Split::Train, false), (Split::HeldOut, true)] {
            let rows: Vec<usize> = (0..problem.motion.rows())
                .filter(|row| problem.judged[joint][*row] && problem.held_out[*row] == held)
                .collect();
            if rows.is_empty() {
                continue;
            }
            let rms = |values: &[f64]| root_mean_square(&rows.iter().map(|row| values[*row]).collect::<Vec<f64>>());
            let torque = rms(&problem.motion.joints[joint].torque).max(1e-300);
            let (before, after) = (rms(&residual.before), rms(&residual.after));
            errors.push(FitError {
                joint: model.name.clone(),
                quantity: if model.kind == JointKind::Revolute { "torque" } else { "force" },
                unit: model.kind.effort_unit(),
                split,
                before,
                after,
                floor: rms(&floor[joint]),
                before_percent: 100.0 * before / torque,
                after_percent: 100.0 * after / torque,
                gain: gain(problem, &rows, residual),
            });
        }
    }
    errors
}

/// The gain of the extended model over rows of one joint.
pub fn gain(problem: &Problem, rows: &[usize], residual: &Residual) -> Gain {
    let pick = |values: &[f64]| rows.iter().map(|row| values[*row]).collect::<Vec<f64>>();
    gains::of_rows(&problem.motion, rows, [&pick(&residual.before), &pick(&residual.after)])
}

/// Residuals per sample.
pub fn series(problem: &Problem, sessions: &[&TimeSeries], residuals: &[Residual]) -> Vec<ResidualSeries> {
    let zones: Vec<_> = (0..residuals.len()).map(|joint| shares::zones(problem, joint)).collect();
    let mut all = Vec::new();
    for (number, session) in sessions.iter().enumerate() {
        for (split, held) in [(Split::Train, false), (Split::HeldOut, true)] {
            let rows: Vec<usize> = (0..problem.motion.rows())
                .filter(|row| problem.motion.session[*row] == number && problem.held_out[*row] == held)
                .collect();
            if rows.is_empty() {
                continue;
            }
            for joint in problem.joints() {
                let residual = &residuals[joint];
                let (m, model) = (&problem.motion.joints[joint], &problem.motion.model.joints[joint]);
                let pick = |values: &[f64]| -> Vec<f64> { rows.iter().map(|row| values[*row]).collect() };
                all.push(ResidualSeries {
                    session: session.name.clone(),
                    joint: model.name.clone(),
                    kind: model.kind,
                    split,
                    time: pick(&problem.motion.time),
                    position: pick(&m.q),
                    velocity: pick(&m.v),
                    motor_angle: rows.iter().map(|row| model.gear_ratio * m.q[*row]).collect(),
                    load: pick(&m.link_torque),
                    torque: pick(&m.torque),
                    before: pick(&residual.before),
                    after: pick(&residual.after),
                    zone: rows.iter().map(|row| zones[joint][*row]).collect(),
                    rigid: rows.iter().map(|row| problem.judged[joint][*row]).collect(),
                });
            }
        }
    }
    all
}
