//! Linear regression of several torques at once, with a heavy-tailed error.
//!
//! Each block (joint) has its own error scale `s`; blocks may share coefficients. The error is Student's t with `ν` degrees of freedom, so
//! that rows where the links do not follow (before a change of flank) have a small weight. The fit uses expectation maximisation:
//! `w = (ν + 1)/(ν + e²/s²)`, weighted least squares, `s² = Σ w e²/Σ w`. `ν = ∞` is plain least squares.
//! At convergence `Σ w` is the number of rows; dividing by `Σ w` during the iterations needs far fewer of them.
//! References: K. Lange, R. Little, J. Taylor (1989), Robust statistical modeling using the t distribution;
//! J. Kent, D. Tyler, Y. Vardi (1994), A curious likelihood identity for the multivariate t-distribution, for the faster scale.

use nalgebra::{Cholesky, DMatrix, DMatrixView, DVector, Dyn};

use crate::linear::Equilibrated;

/// Degrees of freedom of the error.
pub const NU: f64 = 3.0;
const MOST_ITERATIONS: usize = 40;
/// [1] Change of the mean log-likelihood at which iterations end.
const CONVERGED: f64 = 1e-7;

/// One torque: the left side, and the columns that may explain it.
#[derive(Debug, Clone, Default)]
pub struct Block {
    /// Left side.
    pub y: Vec<f64>,
    /// Index of the coefficient, and its column.
    pub columns: Vec<(usize, Vec<f64>)>,
}

/// Blocks that share one vector of coefficients.
#[derive(Debug, Clone, Default)]
pub struct System {
    /// One block per joint.
    pub blocks: Vec<Block>,
    /// Number of coefficients.
    pub unknowns: usize,
    /// Precision of a prior around 0 for some coefficients, `(index, 1/σ²)`.
    pub priors: Vec<(usize, f64)>,
    /// Independent samples per row of each block, where priors count against the rows; empty: every row counts.
    pub trust: Vec<f64>,
}

/// Result of a regression.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Coefficients.
    pub coefficients: DVector<f64>,
    /// Scale of each block's error.
    pub scale: Vec<f64>,
    /// Log-likelihood of each block, a constant left out.
    pub log_likelihood: Vec<f64>,
    /// Residual of each block.
    pub residual: Vec<Vec<f64>>,
    /// Weight of each row; 1 where the error is as large as expected.
    pub weights: Vec<Vec<f64>>,
}

impl Block {
    /// `y − Σ c · column`.
    pub fn residual(&self, coefficients: &DVector<f64>) -> Vec<f64> {
        let mut residual = self.y.clone();
        for (index, column) in &self.columns {
            let c = coefficients[*index];
            residual.iter_mut().zip(column).for_each(|(e, x)| *e -= c * x);
        }
        residual
    }
}

impl Block {
    /// `Σ w z zᵀ` over the rows, where `z` are the columns, then the left side.
    fn products(&self, weights: &[f64]) -> DMatrix<f64> {
        /// So many rows of some tens of columns stay in the processor's cache.
        const ROWS: usize = 128;
        let sides: Vec<&[f64]> = self.columns.iter().map(|(_, x)| &x[..]).chain([&self.y[..]]).collect();
        let n = sides.len();
        let mut products = DMatrix::zeros(n, n);
        let [mut columns, mut weighted] = [(); 2].map(|()| vec![0.0; ROWS * n]);
        for (first, weights) in (0..).step_by(ROWS).zip(weights.chunks(ROWS)) {
            let rows = weights.len();
            for (k, side) in sides.iter().enumerate() {
                columns[k * rows..(k + 1) * rows].copy_from_slice(&side[first..first + rows]);
            }
            for ((row, w), to) in weights.iter().enumerate().zip(weighted.chunks_exact_mut(n)) {
                to.iter_mut().zip(columns[row..].iter().step_by(rows)).for_each(|(to, x)| *to = x * w);
            }
            let columns = DMatrixView::from_slice(&columns, rows, n);
            products.gemm(1.0, &DMatrixView::from_slice(&weighted, n, rows), &columns, 1.0);
        }
        products
    }
}

/// Log-density of an error of scale `s`, a constant left out.
pub fn log_density(e: f64, s: f64, nu: f64) -> f64 {
    log_likelihood(&[e], s, nu)
}

/// Number of errors whose factors are multiplied before the logarithm; their product cannot overflow.
const FACTORS: usize = 8;

/// `Σ ln p(e)` of errors of scale `s`, a constant left out.
fn log_likelihood(errors: &[f64], s: f64, nu: f64) -> f64 {
    let shape = if nu.is_finite() {
        let relative = 1.0 / (nu * s * s);
        let factor = |e: &f64| 1.0 + relative * e * e;
        -0.5 * (nu + 1.0) * errors.chunks(FACTORS).map(|few| few.iter().map(factor).product::<f64>().ln()).sum::<f64>()
    } else {
        -0.5 * dot(errors, errors) / (s * s)
    };
    shape - errors.len() as f64 * s.ln()
}

/// Largest log-likelihood of errors over their scale. With a scale of their own, held-out rows may have any share of outliers.
pub fn profile_likelihood(errors: &[f64], nu: f64) -> f64 {
    let mut s2 = mean_square(errors).max(1e-24);
    for _ in 0..MOST_ITERATIONS {
        let weight = |e: f64| (nu + 1.0) / (nu + e * e / s2);
        let next = sum(errors, errors, |e, _| weight(e) * e * e) / sum(errors, errors, |e, _| weight(e)).max(1e-300);
        let next = next.max(1e-24);
        let settled = (next / s2).ln().abs() < 1e-4;
        s2 = next;
        if settled {
            break;
        }
    }
    log_likelihood(errors, s2.sqrt(), nu)
}

impl System {
    /// Precisions of the priors against rows that count as `independent` samples each.
    pub fn priors_per_row(&self, independent: f64) -> Vec<(usize, f64)> {
        self.priors.iter().map(|(at, precision)| (*at, precision / independent)).collect()
    }

    fn normal(&self, weights: &[Vec<f64>], scale: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
        let mut a = DMatrix::zeros(self.unknowns, self.unknowns);
        let mut b = DVector::zeros(self.unknowns);
        for (joint, ((block, weights), s)) in self.blocks.iter().zip(weights).zip(scale).enumerate() {
            let precision = self.trust.get(joint).unwrap_or(&1.0) / (s * s);
            let products = block.products(weights);
            for (k, (i, _)) in block.columns.iter().enumerate() {
                b[*i] += precision * products[(k, block.columns.len())];
                for (l, (j, _)) in block.columns[..=k].iter().enumerate() {
                    let sum = precision * products[(k, l)];
                    a[(*i, *j)] += sum;
                    if i != j {
                        a[(*j, *i)] += sum;
                    }
                }
            }
        }
        for (index, precision) in &self.priors {
            a[(*index, *index)] += precision;
        }
        (a, b)
    }

    /// Weighted least squares at these weights and scales; `None` where the columns do not determine the coefficients.
    pub fn weighted(&self, weights: &[Vec<f64>], scale: &[f64]) -> Option<DVector<f64>> {
        let (a, b) = self.normal(weights, scale);
        Some(Equilibrated::new(&a)?.solve(&b))
    }

    /// Fits the coefficients; `None` where the columns do not determine them.
    pub fn solve(&self, nu: f64) -> Option<Solution> {
        let weights = self.blocks.iter().map(|block| vec![1.0; block.y.len()]).collect();
        let scale = self.blocks.iter().map(|block| mean_square(&block.y).sqrt().max(1e-12)).collect();
        self.solve_from(nu, weights, scale)
    }

    /// As [`solve`](Self::solve), starting from the weights and scales of a similar solution.
    pub fn solve_from(&self, nu: f64, mut weights: Vec<Vec<f64>>, mut scale: Vec<f64>) -> Option<Solution> {
        let mut last = f64::NEG_INFINITY;
        let mut result = None;
        let rows: usize = self.blocks.iter().map(|block| block.y.len()).sum();
        for _ in 0..MOST_ITERATIONS {
            let coefficients = self.weighted(&weights, &scale)?;
            let residual: Vec<Vec<f64>> = self.blocks.iter().map(|block| block.residual(&coefficients)).collect();
            for ((e, w), s) in residual.iter().zip(&mut weights).zip(&mut scale) {
                *s = (sum(e, w, |e, w| w * e * e) / sum(w, w, |w, _| w).max(1e-300)).sqrt().max(1e-12);
                if nu.is_finite() {
                    let precision = 1.0 / (*s * *s);
                    w.iter_mut().zip(e).for_each(|(w, e)| *w = (nu + 1.0) / (nu + precision * e * e));
                }
            }
            let log_likelihood: Vec<f64> =
                residual.iter().zip(&scale).map(|(e, s)| log_likelihood(e, *s, nu)).collect();
            let total: f64 = log_likelihood.iter().sum();
            let settled = (total - last).abs() < CONVERGED * rows.max(1) as f64;
            last = total;
            result = Some((coefficients, log_likelihood, residual));
            if settled {
                break;
            }
        }
        let (coefficients, log_likelihood, residual) = result?;
        Some(Solution { coefficients, scale, log_likelihood, residual, weights })
    }
}

/// Score test: lower bound of the gain in a block's log-likelihood by new columns, at constant weights and scale.
#[derive(Debug)]
pub struct Score {
    weighted: Vec<Vec<f64>>,
    factor: Option<Cholesky<f64, Dyn>>,
    gradient: Vec<f64>,
    weights: Vec<f64>,
}

impl Score {
    /// Prepares the test for a block at its solution.
    ///
    /// `priors` are precisions of coefficients, as in a [`System`], per row of the block.
    pub fn new(block: &Block, residual: &[f64], weights: &[f64], scale: f64, priors: &[(usize, f64)]) -> Self {
        let weights: Vec<f64> = weights.iter().map(|w| w / (scale * scale)).collect();
        let weighted =
            block.columns.iter().map(|(_, x)| x.iter().zip(&weights).map(|(x, w)| x * w).collect()).collect();
        let n = block.columns.len();
        let mut a = block.products(&weights).view((0, 0), (n, n)).into_owned();
        for (i, (index, _)) in block.columns.iter().enumerate() {
            a[(i, i)] += priors.iter().filter(|(of, _)| of == index).map(|(_, precision)| precision).sum::<f64>();
            a[(i, i)] = a[(i, i)] * (1.0 + 1e-9) + 1e-300;
        }
        let gradient = residual.iter().zip(&weights).map(|(e, w)| e * w).collect();
        Self { weighted, factor: Cholesky::new(a), gradient, weights }
    }

    /// The test for new columns that are multiplied by `amplitude` first.
    #[must_use]
    pub fn times(&self, amplitude: &[f64]) -> Self {
        let product = |values: &Vec<f64>| values.iter().zip(amplitude).map(|(x, size)| x * size).collect();
        Self {
            weighted: self.weighted.iter().map(product).collect(),
            gradient: product(&self.gradient),
            weights: self.weights.iter().zip(amplitude).map(|(w, size)| w * size * size).collect(),
            factor: self.factor.clone(),
        }
    }

    /// The gain of these columns: half the quadratic form of their score.
    pub fn gain(&self, new: &[Vec<f64>]) -> f64 {
        let Some(factor) = &self.factor else { return 0.0 };
        let (m, n) = (new.len(), self.weighted.len());
        let b = DVector::from_iterator(m, new.iter().map(|x| dot(x, &self.gradient)));
        let cross = DMatrix::from_fn(n, m, |i, k| dot(&self.weighted[i], &new[k]));
        let mut own = DMatrix::zeros(m, m);
        for k in 0..m {
            let weighted: Vec<f64> = new[k].iter().zip(&self.weights).map(|(x, w)| x * w).collect();
            for l in 0..=k {
                own[(k, l)] = dot(&weighted, &new[l]);
                own[(l, k)] = own[(k, l)];
            }
        }
        let before = own.diagonal();
        own -= cross.transpose() * factor.solve(&cross);
        // A linear combination of the other columns adds nothing.
        if (0..m).any(|k| own[(k, k)] < 1e-6 * before[k]) {
            return 0.0;
        }
        Cholesky::new(own).map_or(0.0, |own| 0.5 * b.dot(&own.solve(&b)))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    sum(a, b, |a, b| a * b)
}

/// `Σ f(a, b)` in several partial sums, so that the processor can add them in parallel.
fn sum(a: &[f64], b: &[f64], f: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sums = [0.0; 8];
    let (a, b) = (a.chunks_exact(sums.len()), b.chunks_exact(sums.len()));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| f(*a, *b)).sum();
    for (a, b) in a.zip(b) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += f(*a, *b));
    }
    sums.iter().sum::<f64>() + rest
}

fn mean_square(values: &[f64]) -> f64 {
    dot(values, values) / values.len().max(1) as f64
}
