//! How far the torque that a fit predicts can be off in a row that it does not contain.
//!
//! ```text
//!   σ² = xᵀ A⁻¹ x + Σ d²,      A = κ Σ w x xᵀ · m² Σ w / Σ (w e)² + P
//! ```
//! with the columns `x` of baseline and deviations in the row, the weights `w`, residuals `e` and independent samples per row `κ` of the fit, the
//! slope `m` of its score against the secant, and the prior precisions `P`. The first part is the error of the fit, large where a row moves
//! faster than any that was fitted. `d` are the torques of one standard deviation of each nominal value: a fit that holds in its own rows
//! can still have taken one value for another.
//! Reference: P. Huber (1981), Robust Statistics, ch. 7 (errors of M-estimates of regression).

use nalgebra::{DMatrix, DVector};

use super::problem::{Fitted, Part, Problem};
use super::uncertainty::mean_slope;
use crate::linear::Equilibrated;

/// `σ` [N·m or N] of a joint's torque in each row, by a fit without terms; infinite where its rows do not determine it.
pub fn errors(problem: &Problem, fitted: &Fitted, joint: usize) -> Vec<f64> {
    let baseline = problem.baseline[joint].columns();
    let deviations = problem.inertial.as_ref().map_or(&[][..], |inertial| &inertial.columns[joint]);
    let columns: Vec<&Vec<f64>> = baseline.iter().chain(deviations).collect();
    let (solution, rows) = (&fitted.solution, problem.rows(joint, Part::Train));
    let (e, weights) = (&solution.residual[joint], &solution.weights[joint]);
    let slope = mean_slope(e, weights, solution.scale[joint]);
    let scores: f64 = e.iter().zip(weights).map(|(e, w)| (w * e).powi(2)).sum();
    let per_weight = slope * slope * weights.iter().sum::<f64>() / scores.max(f64::MIN_POSITIVE);
    let trust = problem.independence_of(fitted)[joint] * per_weight;
    let root: Vec<f64> = weights.iter().map(|weight| (weight * trust).sqrt()).collect();
    let weighted = DMatrix::from_fn(rows.len(), columns.len(), |i, k| root[i] * columns[k][rows[i]]);
    let mut information = weighted.tr_mul(&weighted);
    (baseline.len()..columns.len()).for_each(|k| information[(k, k)] += 1.0);
    let Some(information) = Equilibrated::new(&information) else {
        return vec![f64::INFINITY; problem.motion.rows()];
    };
    let of_row = |row: usize| {
        let x = DVector::from_iterator(columns.len(), columns.iter().map(|column| column[row]));
        let nominal: f64 = deviations.iter().map(|column| column[row].powi(2)).sum();
        (x.dot(&information.solve(&x)).max(0.0) + nominal).sqrt()
    };
    (0..problem.motion.rows()).map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::diagnose::fit::regression::NU;
    use crate::effects::drawn::{LENGTH, MODEL, NOISE, ROBOT, drawn};
    use crate::robot::Model;
    use crate::timeseries::root_mean_square;

    /// A fit of slow rows is off in the fastest row by what it states, in the RMS over draws of the noise. That of 200 draws scatters by
    /// 5 %; four times that.
    #[test]
    fn recover_the_error_of_a_fit_in_faster_rows() {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
        let errors: Vec<[f64; 2]> = (0..200).map(|seed| at_fastest_row(&model, seed)).collect();
        let in_errors: Vec<f64> = errors.iter().map(|[error, stated]| error / stated).collect();
        let ratio = root_mean_square(&in_errors);
        assert!((0.8..1.2).contains(&ratio), "{ratio}");
        // Far from its rows the fit knows less than in them: the noise of some thousand rows would leave a hundredth of it.
        let stated = errors.iter().map(|[_, stated]| stated / NOISE).fold(f64::INFINITY, f64::min);
        assert!(stated > 0.05, "{stated}");
    }

    /// Error and stated error [N·m] in the fastest row, of a fit of the rows at less than a fifth of its speed.
    fn at_fastest_row(model: &Model, seed: u64) -> [f64; 2] {
        let mut motion = drawn(model, 7, None, LENGTH);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
        let m = &mut motion.joints[0];
        let noise: Vec<f64> = m.v.iter().map(|_| NOISE * normal()).collect();
        for (row, noise) in noise.iter().enumerate() {
            m.torque[row] = m.rigid[row] + 2.0 * m.v[row].signum() + 1.3 * m.v[row] + noise;
        }
        let speed: Vec<f64> = m.v.iter().map(|v| v.abs()).collect();
        let fastest = (0..speed.len()).max_by(|a, b| speed[*a].total_cmp(&speed[*b])).expect("rows");
        let mut problem = Problem::new(motion, vec![false; speed.len()]);
        problem.zones[0] = speed.iter().map(|v| *v < 0.2 * speed[fastest]).collect();
        let fitted = problem.fit(&[], Part::Train, NU).expect("a fit");
        let error = problem.residual(&[], &fitted, 0)[fastest] - noise[fastest];
        [error, errors(&problem, &fitted, 0)[fastest]]
    }
}
