//! Linear regression of several torques at once, with a heavy-tailed error.
//!
//! Each block (joint) has its own error scale `s`; blocks may share coefficients. The error is Student's t with `ν` degrees of freedom, so
//! that rows where the links do not follow (before a change of flank) have a small weight. The fit uses expectation maximisation:
//! `w = (ν + 1)/(ν + e²/s²)`, weighted least squares, `s² = Σ w e²/Σ w`. `ν = ∞` is plain least squares.
//! At convergence `Σ w` is the number of rows; dividing by `Σ w` during the iterations needs far fewer of them.
//! The matrix of the normal equations is formed anew only when the weights have changed: the gradient of the present weights decides where
//! iterations end, the matrix only how fast they get there.
//! References: K. Lange, R. Little, J. Taylor (1989), Robust statistical modeling using the t distribution;
//! J. Kent, D. Tyler, Y. Vardi (1994), A curious likelihood identity for the multivariate t-distribution, for the faster scale.

use nalgebra::{Cholesky, DMatrix, DMatrixView, DVector, Dyn};

use crate::linear::{Equilibrated, RIDGE};

/// Degrees of freedom of the error.
pub const NU: f64 = 3.0;
const MOST_ITERATIONS: usize = 40;
/// [1] Change of the mean log-likelihood at which iterations end.
const CONVERGED: f64 = 1e-7;
/// [1] Mean change of the weights at which the matrix is formed anew. A matrix that is off by a share `c` leaves that share of a step, less than the third
/// that the weights of three degrees of freedom leave anyway.
const CHANGED: f64 = 0.1;

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

    /// `Σ w z zᵀ` over the rows, where `z` are the columns.
    fn products(&self, weights: &[f64]) -> DMatrix<f64> {
        /// So many rows of some tens of columns stay in the processor's cache.
        const ROWS: usize = 128;
        let n = self.columns.len();
        let mut products = DMatrix::zeros(n, n);
        let [mut columns, mut weighted] = [(); 2].map(|()| vec![0.0; ROWS * n]);
        for (first, weights) in (0..).step_by(ROWS).zip(weights.chunks(ROWS)) {
            let rows = weights.len();
            for (to, (_, column)) in columns.chunks_exact_mut(rows).zip(&self.columns) {
                to.copy_from_slice(&column[first..first + rows]);
            }
            for ((row, w), to) in weights.iter().enumerate().zip(weighted.chunks_exact_mut(n.max(1))) {
                to.iter_mut().zip(columns[row..].iter().step_by(rows)).for_each(|(to, x)| *to = x * w);
            }
            let columns = DMatrixView::from_slice(&columns[..rows * n], rows, n);
            products.gemm(1.0, &DMatrixView::from_slice(&weighted[..rows * n], n, rows), &columns, 1.0);
        }
        products
    }

    fn formed(&self, weights: &[f64]) -> Formed {
        Formed { products: self.products(weights), weights: weights.to_vec() }
    }
}

/// The [`products`](Block::products) of a block at the weights of some iteration.
struct Formed {
    products: DMatrix<f64>,
    weights: Vec<f64>,
}

impl Formed {
    fn differs(&self, weights: &[f64]) -> bool {
        sum(weights, &self.weights, |now, then| (now - then).abs()) > CHANGED * sum(weights, weights, |w, _| w)
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

    /// Precision `1/s²` of a row of a block, with what it counts against the priors.
    fn precision(&self, block: usize, scale: f64) -> f64 {
        self.trust.get(block).unwrap_or(&1.0) / (scale * scale)
    }

    /// Matrix of the normal equations, of the [`products`](Block::products) of each block.
    fn matrix<'p>(&self, products: impl Iterator<Item = &'p DMatrix<f64>>, scale: &[f64]) -> DMatrix<f64> {
        let mut a = DMatrix::zeros(self.unknowns, self.unknowns);
        for (joint, ((block, products), s)) in self.blocks.iter().zip(products).zip(scale).enumerate() {
            let precision = self.precision(joint, *s);
            for (k, (i, _)) in block.columns.iter().enumerate() {
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
        a
    }

    /// How the weighted errors of the rows and the priors pull the coefficients.
    fn gradient(&self, residual: &[Vec<f64>], weights: &[Vec<f64>], scale: &[f64], at: &DVector<f64>) -> DVector<f64> {
        let mut gradient = DVector::zeros(self.unknowns);
        for (joint, ((block, e), (w, s))) in self.blocks.iter().zip(residual).zip(weights.iter().zip(scale)).enumerate()
        {
            let precision = self.precision(joint, *s);
            let weighted: Vec<f64> = e.iter().zip(w).map(|(e, w)| precision * w * e).collect();
            block.columns.iter().for_each(|(index, column)| gradient[*index] += dot(column, &weighted));
        }
        for (index, precision) in &self.priors {
            gradient[*index] -= precision * at[*index];
        }
        gradient
    }

    /// Coefficients minus `at` by the normal equations, which reach the least squares in one step where `a` is of the gradient's weights; `None` where
    /// the columns do not determine them.
    fn step(&self, a: &DMatrix<f64>, gradient: DVector<f64>, at: &DVector<f64>) -> Option<DVector<f64>> {
        let ridge = RIDGE * a.diagonal().component_mul(at);
        Some(Equilibrated::new(a)?.solve(&(gradient - ridge)))
    }

    /// Weighted least squares at these weights and scales; `None` where the columns do not determine the coefficients.
    pub fn weighted(&self, weights: &[Vec<f64>], scale: &[f64]) -> Option<DVector<f64>> {
        let products: Vec<_> =
            self.blocks.iter().zip(weights).map(|(block, weights)| block.products(weights)).collect();
        let (zero, y) = (DVector::zeros(self.unknowns), self.left_sides());
        self.step(&self.matrix(products.iter(), scale), self.gradient(&y, weights, scale, &zero), &zero)
    }

    fn left_sides(&self) -> Vec<Vec<f64>> {
        self.blocks.iter().map(|block| block.y.clone()).collect()
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
        let mut of_blocks: Vec<f64> = Vec::new();
        let mut coefficients = DVector::zeros(self.unknowns);
        let mut residual = self.left_sides();
        let mut formed: Vec<Formed> = self.blocks.iter().zip(&weights).map(|(block, w)| block.formed(w)).collect();
        let rows: usize = self.blocks.iter().map(|block| block.y.len()).sum();
        for _ in 0..MOST_ITERATIONS {
            for ((block, weights), formed) in self.blocks.iter().zip(&weights).zip(&mut formed) {
                if formed.differs(weights) {
                    *formed = block.formed(weights);
                }
            }
            let a = self.matrix(formed.iter().map(|formed| &formed.products), &scale);
            let gradient = self.gradient(&residual, &weights, &scale, &coefficients);
            coefficients += self.step(&a, gradient, &coefficients)?;
            residual = self.blocks.iter().map(|block| block.residual(&coefficients)).collect();
            for ((e, w), s) in residual.iter().zip(&mut weights).zip(&mut scale) {
                *s = (sum(e, w, |e, w| w * e * e) / sum(w, w, |w, _| w).max(1e-300)).sqrt().max(1e-12);
                if nu.is_finite() {
                    let precision = 1.0 / (*s * *s);
                    w.iter_mut().zip(e).for_each(|(w, e)| *w = (nu + 1.0) / (nu + precision * e * e));
                }
            }
            of_blocks = residual.iter().zip(&scale).map(|(e, s)| log_likelihood(e, *s, nu)).collect();
            let total: f64 = of_blocks.iter().sum();
            let settled = (total - last).abs() < CONVERGED * rows.max(1) as f64;
            last = total;
            if settled {
                break;
            }
        }
        Some(Solution { coefficients, scale, log_likelihood: of_blocks, residual, weights })
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
        let mut a = block.products(&weights);
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

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Two blocks that share a coefficient with a prior; one row in ten is far off.
    fn system(seed: u64) -> System {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
        let block = |own: usize, size: f64| {
            let columns: Vec<(usize, Vec<f64>)> =
                [own, own + 1, 4].map(|index| (index, (0..500).map(|_| normal()).collect())).into();
            let y = (0..500).map(|row| {
                let far = if row % 10 == 0 { 20.0 } else { 1.0 };
                columns.iter().map(|(index, x)| (*index as f64 - 1.5) * x[row]).sum::<f64>() + far * size * normal()
            });
            Block { y: y.collect(), columns }
        };
        let (one, other) = {
            let mut block = block;
            (block(0, 0.1), block(2, 2.0))
        };
        System { blocks: vec![one, other], unknowns: 5, priors: vec![(4, 0.5)], trust: vec![0.2, 0.2] }
    }

    /// The solution is where weighted least squares at its own weights would stay, although the matrix is not formed at every iteration.
    #[test]
    fn property_the_solution_is_the_least_squares_of_its_weights() {
        for seed in 0..5 {
            let system = system(seed);
            let solution = system.solve(NU).expect("a solution");
            let again = system.weighted(&solution.weights, &solution.scale).expect("a solution");
            // Iterations end when they gain less than 1e-4 nats in these 1000 rows: √(2e-4) = 1.4 % of a standard error, the least of which is 0.01.
            assert!((&again - &solution.coefficients).amax() < 1.4e-4, "{again} {}", solution.coefficients);
            // Weighted by 0.2 samples a row, 500 rows of the first block determine the coefficients to 0.1/√100, of the second to 2/√100.
            for (index, value) in solution.coefficients.iter().enumerate() {
                let sigma = if [0, 1, 4].contains(&index) { 0.01 } else { 0.2 };
                assert!((value - (index as f64 - 1.5)).abs() < 4.0 * sigma, "{index}: {value}");
            }
        }
    }
}
