//! Residuals before and after, in the forms that a reader looks at: errors, series, maps, order spectrum.

use std::f64::consts::TAU;

use super::problem::{Fitted, Problem, Term};
use super::result::{Axis, FitError, OrderSpectrum, ResidualMap, ResidualSeries, Split};
use crate::replay::{Gain, Pairs};
use crate::timeseries::TimeSeries;
use crate::units::JointKind;

/// Bins of a map.
const BINS: usize = 40;
/// Orders of the motor angle in the spectrum.
const ORDERS: usize = 48;

/// Residuals of all rows of one joint.
pub struct Residual {
    /// Without effects, fitted by plain least squares.
    pub before: Vec<f64>,
    /// With the effects.
    pub after: Vec<f64>,
}

/// Torque of a row that a fit leaves over, all rows; sessions that no row was trained on get their own level and zero.
pub fn residual(problem: &Problem, terms: &[&Term], fitted: &Fitted, joint: usize) -> Vec<f64> {
    let baseline = &problem.baseline[joint];
    let c = &fitted.solution.coefficients;
    let mut residual = baseline.target(&problem.motion, joint);
    for (k, column) in baseline.columns(&problem.motion, joint).iter().enumerate() {
        let c = c[fitted.baseline_at[joint] + k];
        residual.iter_mut().zip(column).for_each(|(e, x)| *e -= c * x);
    }
    for (term, at) in terms.iter().zip(&fitted.term_at) {
        let Some(place) = term.joints.iter().position(|j| *j == joint) else { continue };
        for (k, column) in term.columns[place].iter().enumerate() {
            residual.iter_mut().zip(column).for_each(|(e, x)| *e -= c[at + k] * x);
        }
    }
    let rows = problem.rows(joint, super::problem::Part::HeldOut);
    let mut held_out: Vec<f64> = rows.iter().map(|row| residual[*row]).collect();
    problem.free_new_sessions(joint, terms, c, &fitted.term_at, &mut held_out);
    rows.iter().zip(held_out).for_each(|(row, e)| residual[*row] = e);
    residual
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value * value, count + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// RMS errors over the rigid zone, trained and held out.
pub fn fit_errors(problem: &Problem, residuals: &[Residual], floor: &[Vec<f64>]) -> Vec<FitError> {
    let mut errors = Vec::new();
    for (joint, residual) in residuals.iter().enumerate() {
        let model = &problem.motion.model.joints[joint];
        for (split, held) in [(Split::Train, false), (Split::HeldOut, true)] {
            let rows: Vec<usize> = (0..problem.motion.rows())
                .filter(|row| problem.zones[joint][*row] && problem.held_out[*row] == held)
                .collect();
            if rows.is_empty() {
                continue;
            }
            let rms = |values: &[f64]| root_mean_square(rows.iter().map(|row| values[*row]));
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

/// What the extended model gains over rows of one joint.
pub fn gain(problem: &Problem, rows: &[usize], residual: &Residual) -> Gain {
    let mut sessions: Vec<[Vec<f64>; 3]> = vec![<[Vec<f64>; 3]>::default(); problem.motion.sessions];
    for row in rows {
        let [time, before, after] = &mut sessions[problem.motion.session[*row]];
        time.push(problem.motion.time[*row]);
        before.push(residual.before[*row]);
        after.push(residual.after[*row]);
    }
    let pairs: Vec<Pairs> = sessions.iter().map(|[time, before, after]| Pairs { time, before, after }).collect();
    Gain::of(&pairs)
}

/// Residuals sample by sample.
pub fn series(problem: &Problem, sessions: &[&TimeSeries], residuals: &[Residual]) -> Vec<ResidualSeries> {
    let mut all = Vec::new();
    for (number, session) in sessions.iter().enumerate() {
        for (split, held) in [(Split::Train, false), (Split::HeldOut, true)] {
            let rows: Vec<usize> = (0..problem.motion.rows())
                .filter(|row| problem.motion.session[*row] == number && problem.held_out[*row] == held)
                .collect();
            if rows.is_empty() {
                continue;
            }
            for (joint, residual) in residuals.iter().enumerate() {
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
                    rigid: rows.iter().map(|row| problem.zones[joint][*row]).collect(),
                });
            }
        }
    }
    all
}

/// Mean residual of the rigid zone against velocity, position, motor angle and load.
pub fn maps(problem: &Problem, residuals: &[Residual]) -> Vec<ResidualMap> {
    let mut maps = Vec::new();
    for (joint, residual) in residuals.iter().enumerate() {
        let (m, model) = (&problem.motion.joints[joint], &problem.motion.model.joints[joint]);
        for axis in [Axis::Velocity, Axis::Position, Axis::MotorAngle, Axis::Load] {
            let value = |row: usize| match axis {
                Axis::Velocity => m.v[row],
                Axis::Position => m.q[row],
                Axis::MotorAngle => (model.gear_ratio * m.q[row]).rem_euclid(TAU),
                Axis::Load => m.link_torque[row],
            };
            let rows: Vec<usize> = (0..problem.motion.rows()).filter(|row| problem.zones[joint][*row]).collect();
            maps.push(map(&model.name, axis, &rows, value, residual));
        }
    }
    maps
}

fn map(joint: &str, axis: Axis, rows: &[usize], value: impl Fn(usize) -> f64, residual: &Residual) -> ResidualMap {
    let bounds = rows
        .iter()
        .map(|row| value(*row))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let width = ((bounds.1 - bounds.0) / BINS as f64).max(1e-300);
    let mut sums = vec![(0_usize, 0.0, 0.0); BINS];
    for row in rows {
        let bin = (((value(*row) - bounds.0) / width) as usize).min(BINS - 1);
        sums[bin].0 += 1;
        sums[bin].1 += residual.before[*row];
        sums[bin].2 += residual.after[*row];
    }
    let mut map = ResidualMap {
        joint: joint.to_owned(),
        axis,
        centre: Vec::new(),
        count: Vec::new(),
        before: Vec::new(),
        after: Vec::new(),
    };
    for (bin, (count, before, after)) in sums.into_iter().enumerate().filter(|(_, (count, _, _))| *count > 0) {
        map.centre.push(bounds.0 + (bin as f64 + 0.5) * width);
        map.count.push(count);
        map.before.push(before / count as f64);
        map.after.push(after / count as f64);
    }
    map
}

/// Amplitude of the residual of the rigid zone at whole orders of the motor angle, corrected for the kernel's gain.
pub fn order_spectrum(problem: &Problem, residuals: &[Residual]) -> Vec<OrderSpectrum> {
    let spectrum = |(joint, residual): (usize, &Residual)| {
        let model = &problem.motion.model.joints[joint];
        let rows: Vec<usize> = (0..problem.motion.rows()).filter(|row| problem.zones[joint][*row]).collect();
        let amplitude = |values: &[f64], order: usize| {
            let [cos, sin] = problem.motion.harmonic(joint, order as f64 * model.gear_ratio, |_, _| 1.0);
            let sums = rows.iter().fold([0.0; 5], |mut s, row| {
                let (c, d, e) = (cos[*row], sin[*row], values[*row]);
                for (sum, term) in s.iter_mut().zip([c * c, c * d, d * d, c * e, d * e]) {
                    *sum += term;
                }
                s
            });
            let determinant = sums[0] * sums[2] - sums[1] * sums[1];
            if determinant <= 1e-12 * sums[0] * sums[2] || rows.is_empty() {
                return 0.0;
            }
            let a = (sums[2] * sums[3] - sums[1] * sums[4]) / determinant;
            let b = (sums[0] * sums[4] - sums[1] * sums[3]) / determinant;
            a.hypot(b)
        };
        OrderSpectrum {
            joint: model.name.clone(),
            order: (1..=ORDERS).map(|order| order as f64).collect(),
            before: (1..=ORDERS).map(|order| amplitude(&residual.before, order)).collect(),
            after: (1..=ORDERS).map(|order| amplitude(&residual.after, order)).collect(),
        }
    };
    residuals.iter().enumerate().map(spectrum).collect()
}
