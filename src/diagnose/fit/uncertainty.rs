//! Standard errors of all fitted parameters: a jackknife over blocks of time.
//!
//! Errors within some seconds are correlated: friction drifts, and an inaccurate law makes the same error in similar motion.
//! Therefore whole blocks `g` are removed, one after the other, and the solution moves by one Newton step to
//!
//! `δ_g = (A − A_g)⁻¹ s_g = L⁻ᵀ (1 − L⁻¹ A_g L⁻ᵀ)⁻¹ L⁻¹ s_g`, `A = L Lᵀ`, `s_g = Σ_{i∈g} x_i ψ(e_i)`,
//! `A_g = Σ_{i∈g} κ w_i x_i x_iᵀ/s²`, `A = Σ A_g`, `ψ(e) = w e/s²`,
//!
//! `var(cᵀβ) = Σ_g (cᵀδ_g)²`: a sandwich estimate that includes any correlation inside a block, over all joints together.
//! `κ = mean ψ′ / mean(w/s²)` of a joint converts weights to the slope of the loss. The columns `x` contain linear coefficients,
//! Stribeck velocities and shapes. Blocks of several lengths are tried and the largest variance is used, because errors of a
//! model last as long as the motion that shows them. A few blocks estimate their own scatter poorly: with `h_g = cᵀA⁻¹A_gA⁻¹c` the
//! combination `c` rests on `G_c = (Σ h_g)²/Σ h_g²` blocks, and the error is scaled so that ±1.96 of it contain 95 % of Student's t
//! with `G_c − 1` degrees of freedom.
//!
//! An error common to all blocks does not show in their scatter: smoothing, the direction within a row, the assumption of a rigid link. It
//! is treated as an error of the torque `T` that an effect moves, of the size `ε |T|`, `ε` = [`SYSTEMATIC`], in the worst direction and
//! independent of the scatter:
//!
//! `|cᵀδ| ≤ ε |T| √(cᵀ (XᵀX)⁻¹ c)`, `X` the columns of the effect's own coefficients and shapes. For one coefficient: `ε |β|`. A mass and its
//! position, whose columns are nearly parallel, have larger errors.
//! References: R. Bell, D. McCaffrey (2002), Bias reduction in standard errors for linear regression with multi-stage samples;
//! P. Huber (1981), Robust Statistics, ch. 7.

use nalgebra::{DMatrix, DVector};

use super::baseline::FALLING;
use super::problem::{Fitted, Part, Problem};
use super::regression::{Block, NU, Solution, System};
use super::term::Term;
use crate::distributions::{NORMAL_975, student_975};
use crate::linear::{Equilibrated, scale};

/// [s] Lengths of blocks: the length used by the folds, and about the duration of several moves.
const BLOCKS: [f64; 2] = [5.0, 15.0];
/// Relative error of an effect's torque by smoothing and by the assumption of a rigid link. Tilts, breakaway levels and amplitudes on which
/// the blocks agree to 0.05 % were 0.1 to 0.7 % from the truth on 40 machines (seeds 1 to 40 of `benches/hidden_effects`).
pub const SYSTEMATIC: f64 = 0.005;
/// Least number of blocks of a length.
const LEAST_BLOCKS: usize = 8;
/// Least value of 1 minus the leverage of a block that is corrected for.
const LEAST_FREEDOM: f64 = 0.2;

/// Uncertainty of coefficients, shapes and Stribeck velocities from the scatter between blocks.
pub struct Uncertainty {
    /// One jackknife per length of blocks.
    jackknives: Vec<Jackknife>,
    unknowns: usize,
    /// Position of each joint's Stribeck velocity.
    pub stribeck_at: Vec<Option<usize>>,
    /// Positions of each term's shape parameters.
    pub shape_at: Vec<Vec<usize>>,
    /// Position of the first deviation of the nominal model.
    pub deviations_at: usize,
    /// The torque of each term.
    moved: Vec<MovedTorque>,
}

/// Torque that a term moves, and its sensitivity to the fitted parameters of the term.
struct MovedTorque {
    /// Positions of the term's coefficients and shapes.
    at: Vec<usize>,
    /// `|T|`, root of the sum over rows of all joints.
    size: f64,
    /// `(XᵀX)⁻¹`
    inverse: DMatrix<f64>,
}

/// Changes of the solution when each block is removed.
struct Jackknife {
    moved: Vec<DVector<f64>>,
    /// `A_g`
    information: Vec<DMatrix<f64>>,
    /// `A⁻¹`
    inverse: DMatrix<f64>,
    /// Coefficients with a prior, and their precision `p`.
    priors: Vec<(usize, f64)>,
}

impl Uncertainty {
    /// Scatter of all parameters at the solution; `None` where the columns do not determine the coefficients.
    pub fn new(problem: &Problem, terms: &[&Term], fitted: &Fitted) -> Option<Self> {
        let assembled = problem.system_of_deviating(terms);
        let deviations = assembled.inertial.range();
        let mut system = assembled.system;
        let stribeck_at = add_stribeck(problem, fitted, &mut system);
        let shape_at = add_shapes(problem, terms, fitted, &mut system);
        let of_term = |(index, term): (usize, &&Term)| {
            let own = fitted.term_at[index]..fitted.term_at[index] + term.coefficients();
            let mut own_rows = system.clone();
            // Only on the term's joints can its torque be taken for a deviation; there a deviation is as free as its prior allows.
            let others = |joint: usize| !term.joints.contains(&joint);
            (0..own_rows.blocks.len())
                .filter(|joint| others(*joint))
                .for_each(|joint| own_rows.blocks[joint] = Block::default());
            let beside: Vec<usize> = shape_at[index].iter().copied().chain(deviations.clone()).collect();
            MovedTorque::new(&own_rows, own, &beside, fitted.solution.coefficients.as_slice())
        };
        let moved = terms.iter().enumerate().map(of_term).collect::<Option<_>>()?;
        let solution = system.solve(NU)?;
        let rows: Vec<Vec<usize>> = (0..problem.baseline.len()).map(|joint| problem.rows(joint, Part::Train)).collect();
        let jackknives = BLOCKS.iter().filter_map(|length| {
            let block = |row: &usize| (problem.motion.session[*row], (problem.motion.time[*row] / length) as usize);
            let keys: Vec<Vec<_>> = rows.iter().map(|rows| rows.iter().map(block).collect()).collect();
            let mut all: Vec<_> = keys.iter().flatten().copied().collect();
            all.sort_unstable();
            all.dedup();
            let number = |key: &(usize, usize)| all.binary_search(key).unwrap_or(0);
            let blocks: Vec<Vec<usize>> = keys.iter().map(|keys| keys.iter().map(number).collect()).collect();
            (all.len() >= LEAST_BLOCKS || *length == BLOCKS[0])
                .then(|| Jackknife::new(&system, &solution, &blocks, all.len()))
                .flatten()
        });
        let jackknives: Vec<Jackknife> = jackknives.collect();
        (!jackknives.is_empty()).then_some(Self {
            jackknives,
            unknowns: system.unknowns,
            stribeck_at,
            shape_at,
            deviations_at: deviations.start,
            moved,
        })
    }

    /// Standard error of `Σ slope · coefficient`, each `(position, slope)`.
    pub fn std_error(&self, gradient: &[(usize, f64)]) -> f64 {
        let mut c = DVector::zeros(self.unknowns);
        for (position, slope) in gradient {
            c[*position] += slope;
        }
        self.jackknives.iter().map(|jackknife| jackknife.std_error(&c)).fold(0.0, f64::max)
    }

    /// Largest `Σ slope · error` of a term's coefficients and shapes for an error of its torque by [`SYSTEMATIC`].
    pub fn systematic(&self, term: usize, gradient: &[(usize, f64)]) -> f64 {
        self.moved[term].error(gradient)
    }

    /// `|c|/σ` of some coefficients together: `Σ c²/s²` with the scales `s`, divided by its standard error in the direction of the coefficients.
    pub fn size_in_errors(&self, at: std::ops::Range<usize>, coefficients: &DVector<f64>) -> f64 {
        let gradient: Vec<(usize, f64)> = at.map(|k| (k, coefficients[k] / self.spread(k).powi(2))).collect();
        let size: f64 = gradient.iter().map(|(k, slope)| slope * coefficients[*k]).sum();
        size / self.std_error(&gradient).max(1e-300)
    }

    /// Scale of one coefficient, for the steps of numerical derivatives.
    pub fn spread(&self, position: usize) -> f64 {
        self.jackknives[0].inverse[(position, position)].max(0.0).sqrt().max(1e-12)
    }
}

impl MovedTorque {
    /// For the coefficients `own` and the further columns `beside` of a term, its shapes and the deviations of the nominal model; `None` where
    /// its columns are linearly dependent. Columns that move no torque are left out.
    fn new(system: &System, own: std::ops::Range<usize>, beside: &[usize], coefficients: &[f64]) -> Option<Self> {
        let moves = |block: &Block, at: &usize| {
            block.columns.iter().any(|(of, column)| of == at && column.iter().any(|torque| *torque != 0.0))
        };
        let all = own.clone().chain(beside.iter().copied());
        let at: Vec<usize> = all.filter(|at| system.blocks.iter().any(|block| moves(block, at))).collect();
        let mut gram = DMatrix::zeros(at.len(), at.len());
        for block in &system.blocks {
            let columns: Vec<_> =
                at.iter().map(|at| block.columns.iter().find(|(position, _)| position == at)).collect();
            for (i, one) in columns.iter().enumerate() {
                for (j, other) in columns.iter().enumerate() {
                    if let (Some((_, one)), Some((_, other))) = (one, other) {
                        gram[(i, j)] += one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
                    }
                }
            }
        }
        let beta = DVector::from_fn(at.len(), |i, _| if own.contains(&at[i]) { coefficients[at[i]] } else { 0.0 });
        let size = beta.dot(&(&gram * &beta)).max(0.0).sqrt();
        // What has a prior moves by one standard deviation of it at most: a ridge of (ε |T|)² in these units.
        for (i, at) in at.iter().enumerate() {
            let precision: f64 = system.priors.iter().filter(|(of, _)| of == at).map(|(_, precision)| precision).sum();
            gram[(i, i)] += precision * (SYSTEMATIC * size).powi(2);
        }
        Some(Self { at, size, inverse: Equilibrated::new(&gram)?.inverse() })
    }

    fn error(&self, gradient: &[(usize, f64)]) -> f64 {
        let slope = |at: &usize| gradient.iter().filter(|(position, _)| position == at).map(|(_, slope)| slope).sum();
        let c = DVector::from_iterator(self.at.len(), self.at.iter().map(slope));
        SYSTEMATIC * self.size * c.dot(&(&self.inverse * &c)).max(0.0).sqrt()
    }
}

impl Jackknife {
    /// `blocks[joint][row of the system]`: block of each row, of `count` blocks.
    fn new(system: &System, solution: &Solution, blocks: &[Vec<usize>], count: usize) -> Option<Self> {
        let n = system.unknowns;
        let mut information = vec![DMatrix::zeros(n, n); count];
        let mut score = vec![DVector::zeros(n); count];
        for (joint, block) in system.blocks.iter().enumerate() {
            let (e, w, s) = (&solution.residual[joint], &solution.weights[joint], solution.scale[joint]);
            let slope = mean_slope(e, w, s);
            let trust = system.trust.get(joint).copied().unwrap_or(1.0);
            for (row, (group, (e, w))) in blocks[joint].iter().zip(e.iter().zip(w)).enumerate() {
                let weight = trust * w / (s * s);
                for (position, (i, x)) in block.columns.iter().enumerate() {
                    score[*group][*i] += x[row] * weight * e;
                    let weighted = slope * weight * x[row];
                    for (j, other) in &block.columns[..=position] {
                        information[*group][(*i.max(j), *i.min(j))] += weighted * other[row];
                    }
                }
            }
        }
        for matrix in &mut information {
            matrix.fill_upper_triangle_with_lower_triangle();
        }
        let mut all: DMatrix<f64> = information.iter().fold(DMatrix::zeros(n, n), |sum, matrix| sum + matrix);
        system.priors.iter().for_each(|(at, precision)| all[(*at, *at)] += precision);
        let factor = Equilibrated::new(&all)?;
        let (lower, size, inverse) = (factor.lower(), factor.size(), factor.inverse());
        let step = |(a, s): (&DMatrix<f64>, &DVector<f64>)| {
            // L⁻¹ A_g L⁻ᵀ; its eigenvalues are the leverage of the block.
            let half = lower.solve_lower_triangular(&scale(a, size))?;
            let leverage = lower.solve_lower_triangular(&half.transpose())?.symmetric_eigen();
            let whitened = lower.solve_lower_triangular(&s.component_mul(size))?;
            let mut turned = leverage.eigenvectors.tr_mul(&whitened);
            turned.zip_apply(&leverage.eigenvalues, |x, h| *x /= (1.0 - h).max(LEAST_FREEDOM));
            let corrected = &leverage.eigenvectors * turned;
            Some(lower.tr_solve_lower_triangular(&corrected)?.component_mul(size))
        };
        let moved = information.iter().zip(&score).map(step).collect::<Option<_>>()?;
        Some(Self { moved, information, inverse, priors: system.priors.clone() })
    }

    fn std_error(&self, c: &DVector<f64>) -> f64 {
        let variance = self.moved.iter().map(|moved| c.dot(moved).powi(2)).sum::<f64>();
        let carrier = &self.inverse * c;
        let held = self.information.iter().map(|a| carrier.dot(&(a * &carrier)));
        let (sum, squares) = held.fold((0.0, 0.0), |(sum, squares), h| (sum + h, squares + h * h));
        let effective = if squares > 0.0 { sum * sum / squares } else { 1.0 };
        // What the blocks do not tell is as uncertain as its prior: the variance of −A⁻¹ P z for z ~ N(0, P⁻¹).
        let stated: f64 = self.priors.iter().map(|(at, precision)| precision * carrier[*at].powi(2)).sum();
        (variance.sqrt() * widening(effective - 1.0)).hypot(stated.sqrt())
    }
}

/// `t_{0.975}(ν)/z_{0.975}`, ν ≥ 2.
fn widening(freedom: f64) -> f64 {
    student_975(freedom.max(2.0)) / NORMAL_975
}

/// `mean ψ′ · s² / mean w`: the slope of Student's score against its secant.
pub fn mean_slope(e: &[f64], w: &[f64], s: f64) -> f64 {
    let slope = |e: &f64| {
        let z2 = (e / s).powi(2);
        (NU + 1.0) * (NU - z2) / (NU + z2).powi(2)
    };
    let slopes: f64 = e.iter().map(slope).sum();
    (slopes / w.iter().sum::<f64>().max(1e-300)).clamp(0.1, 1.0)
}

/// Adds a column for each fitted Stribeck velocity, and returns the positions.
fn add_stribeck(problem: &Problem, fitted: &Fitted, system: &mut System) -> Vec<Option<usize>> {
    let mut positions = Vec::new();
    for (joint, baseline) in problem.baseline.iter().enumerate() {
        let falling = fitted.solution.coefficients.get(fitted.baseline_at[joint] + FALLING).copied().unwrap_or(0.0);
        let derivative = baseline.stribeck_derivative().filter(|_| falling.abs() > 1e-12);
        positions.push(derivative.map(|column| {
            let rows = problem.rows(joint, Part::Train);
            let column = rows.iter().map(|row| falling * column[*row]).collect();
            system.blocks[joint].columns.push((system.unknowns, column));
            system.unknowns += 1;
            system.unknowns - 1
        }));
    }
    positions
}

/// Adds a column for each refined shape parameter, and returns the positions.
fn add_shapes(problem: &Problem, terms: &[&Term], fitted: &Fitted, system: &mut System) -> Vec<Vec<usize>> {
    let mut all = Vec::new();
    for (term, at) in terms.iter().zip(&fitted.term_at) {
        let mut positions = Vec::new();
        for index in 0..term.effect.refined_shapes(&term.shape) {
            let step = 1e-4 * term.shape[index].abs().max(1e-6);
            let mut shape = term.shape.clone();
            shape[index] += step;
            let moved = Term::new(&problem.motion, term.effect, &term.joints, shape);
            for (place, joint) in term.joints.iter().enumerate() {
                let change = |row: &usize| -> f64 {
                    let columns = moved.columns[place].iter().zip(&term.columns[place]).enumerate();
                    let slope = |(k, (new, old)): (usize, (&Vec<f64>, &Vec<f64>))| {
                        fitted.solution.coefficients[at + k] * (new[*row] - old[*row]) / step
                    };
                    columns.map(slope).sum()
                };
                let column = problem.rows(*joint, Part::Train).iter().map(change).collect();
                system.blocks[*joint].columns.push((system.unknowns, column));
            }
            positions.push(system.unknowns);
            system.unknowns += 1;
        }
        all.push(positions);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::regression::{Block, NU, System};
    use super::{Jackknife, MovedTorque, SYSTEMATIC, widening};

    /// Two unit columns at an angle α, the second a shape. A perpendicular error `ε |β|` of the torque moves both coefficients by
    /// `ε |β|/sin α`; with one column alone the error is `ε |β|`.
    #[test]
    fn analytic_an_error_across_nearly_parallel_columns_weighs_more() {
        let (beta, angle) = (-2.0, 0.2_f64);
        let columns = vec![(0, vec![1.0, 0.0]), (1, vec![angle.cos(), angle.sin()])];
        let system = System { blocks: vec![Block { y: vec![0.0; 2], columns }], unknowns: 2, ..System::default() };
        let error = |shapes: &[usize], position| {
            MovedTorque::new(&system, 0..1, shapes, &[beta]).expect("two columns").error(&[(position, 1.0)])
        };
        let expected = SYSTEMATIC * 2.0;
        // The ridge changes the inverse by 1e-10/sin² α.
        assert!((error(&[], 0) / expected - 1.0).abs() < 1e-8);
        assert!((error(&[1], 0) * angle.sin() / expected - 1.0).abs() < 1e-8);
        assert!((error(&[1], 1) * angle.sin() / expected - 1.0).abs() < 1e-8);
    }

    /// The error of a mean with errors constant within each block is given by the number of blocks, not of rows.
    #[test]
    fn analytic_errors_of_whole_blocks_count_once() {
        let (count, length) = (40, 50);
        // Quantiles of a uniform distribution, ordered so that neighbours differ, plus a little noise of rows.
        let level = |block: usize| ((block * 17 % count) as f64 + 0.5) / count as f64 - 0.5;
        let y = (0..count * length).map(|row| 3.0 + level(row / length) + 0.01 * (row as f64 * 1.7).sin()).collect();
        let columns = vec![(0, vec![1.0; count * length])];
        let system = System { blocks: vec![Block { y, columns }], unknowns: 1, ..System::default() };
        let blocks = [(0..count * length).map(|row| row / length).collect()];
        let solution = system.solve(NU).expect("a mean");
        let jackknife = Jackknife::new(&system, &solution, &blocks, count).expect("a scatter");
        let found = jackknife.std_error(&nalgebra::DVector::from_element(1, 1.0)) / widening(count as f64 - 1.0);
        // Huber: σ = √(mean ψ²)/mean ψ′/√G over the blocks, and G/(G − 1) for the leverage of each block.
        let z: Vec<f64> = (0..count).map(|block| level(block) / solution.scale[0]).collect();
        let psi = |z: &f64| (NU + 1.0) * z / (NU + z * z);
        let slope = |z: &f64| (NU + 1.0) * (NU - z * z) / (NU + z * z).powi(2);
        let power: f64 = z.iter().map(|z| psi(z).powi(2)).sum();
        let expected = solution.scale[0] * power.sqrt() / z.iter().map(slope).sum::<f64>();
        let expected = expected * count as f64 / (count as f64 - 1.0);
        // The noise of rows, 3 % of the spread of levels, is not in the formula.
        assert!((found / expected - 1.0).abs() < 0.01, "{found} against {expected}");
    }
}
