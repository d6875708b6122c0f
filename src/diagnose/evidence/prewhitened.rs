//! The rows of one joint after a filter that makes the errors white, for the evidence of a line beside slow errors.
//!
//! ```text
//!   e_i = Σ_k φ_k e_{i−k} + u_i          k = 1 … 3, least squares over neighbouring rows of the residual e;  u is nearly white
//!   x'_i = x_i − Σ_k φ_k x_{i−k}         the same for the torque and for every column
//! ```
//! The regression of the filtered rows is the one with the smallest errors: the more a slow error, of friction or of a nominal mass,
//! repeats from row to row, the less it counts. Three terms describe the overlap of neighbouring kernels and one slow decay.
//! Left out: errors whose spectrum differs between fast and slow motion.
//! References: D. Cochrane, G. H. Orcutt (1949), Application of least squares regression to relationships containing auto-correlated error
//! terms; G. E. P. Box, G. M. Jenkins (1970), Time Series Analysis, ch. 3.2.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::fit::problem::{FOLDS, Fitted, Part, Problem};
use crate::diagnose::fit::regression::{Block, NU, Score, Solution, System};
use crate::diagnose::fit::term::Term;
use crate::diagnose::fit::uncertainty::mean_slope;
use crate::linear::Equilibrated;

/// Number of `φ`.
const LAGS: usize = 3;
/// Least number of filtered rows for each column.
const ROWS_PER_COLUMN: usize = 5;

/// Filtered rows of a joint, with their regression.
pub struct Prewhitened {
    filter: Filter,
    /// Fold of each row.
    fold: Vec<usize>,
    /// All columns, those of the line last.
    system: System,
    /// Number of columns of the line.
    own: usize,
    solution: Solution,
    /// Gain of likelihood over the gain at constant weights.
    slope: f64,
}

/// The autoregression, and the rows that have all predecessors.
struct Filter {
    phi: Vec<f64>,
    kept: Vec<usize>,
}

impl Filter {
    /// Fitted to the residual of these rows; `None` where too few of them are neighbours.
    fn new(problem: &Problem, rows: &[usize], residual: &[f64]) -> Option<Self> {
        let part = &problem.motion.part;
        let follows = |i: &usize| {
            let first = rows[i - LAGS];
            rows[*i] == first + LAGS && part[rows[*i]] == part[first]
        };
        let kept: Vec<usize> = (LAGS..rows.len()).filter(follows).collect();
        let lagged = |k: usize, l: usize| kept.iter().map(|i| residual[i - k] * residual[i - l]).sum::<f64>();
        let a = DMatrix::from_fn(LAGS, LAGS, |k, l| lagged(k + 1, l + 1));
        let b = DVector::from_fn(LAGS, |k, _| lagged(0, k + 1));
        let phi = Equilibrated::new(&a)?.solve(&b).as_slice().to_vec();
        phi.iter().all(|phi| phi.is_finite()).then_some(Self { phi, kept })
    }

    fn apply(&self, x: &[f64]) -> Vec<f64> {
        let of_row = |i: &usize| x[*i] - self.phi.iter().enumerate().map(|(k, phi)| phi * x[i - 1 - k]).sum::<f64>();
        self.kept.iter().map(of_row).collect()
    }
}

impl Prewhitened {
    /// The training rows of a joint with these terms, of which the one at `index` is the line; `fitted` is their loose fit.
    pub fn new(problem: &Problem, terms: &[&Term], fitted: &Fitted, (index, joint): (usize, usize)) -> Option<Self> {
        let rows = problem.rows(joint, Part::Train);
        let filter = Filter::new(problem, &rows, &fitted.solution.residual[joint])?;
        let assembled = problem.system_of(&[joint], terms, Part::Train, true);
        let line = assembled.term_at[index]..assembled.term_at[index] + terms[index].coefficients();
        let block = &assembled.system.blocks[joint];
        let (last, first): (Vec<_>, Vec<_>) = block.columns.iter().partition(|(at, _)| line.contains(at));
        let own = last.len();
        let all: Vec<&(usize, Vec<f64>)> = first.into_iter().chain(last).collect();
        let priors = assembled
            .system
            .priors
            .iter()
            .filter_map(|(of, precision)| Some((all.iter().position(|(at, _)| at == of)?, *precision)));
        let priors: Vec<(usize, f64)> = priors.collect();
        let columns = all.iter().enumerate().map(|(at, (_, column))| (at, filter.apply(column))).collect();
        let block = Block { y: filter.apply(&block.y), columns };
        let unknowns = all.len();
        if own == 0 || filter.kept.len() < ROWS_PER_COLUMN * unknowns {
            return None;
        }
        let system = System { blocks: vec![block], unknowns, priors, trust: Vec::new() };
        let solution = system.solve(NU)?;
        let slope = mean_slope(&solution.residual[0], &solution.weights[0], solution.scale[0]);
        let fold_of = |i: &usize| (0..FOLDS).find(|fold| problem.is_in(rows[*i], Part::Fold(*fold))).unwrap_or(0);
        let fold = filter.kept.iter().map(fold_of).collect();
        Some(Self { filter, fold, system, own, solution, slope })
    }

    /// Gain of likelihood [nats of rows] by the line on rows that its coefficients were not fitted to, at most that on the rows of the fit.
    pub fn gain(&self) -> Option<f64> {
        let all = vec![true; self.fold.len()];
        let fitted = self.fall(&all, &all)?;
        let mut elsewhere = 0.0;
        for fold in 0..FOLDS {
            let inside: Vec<bool> = self.fold.iter().map(|of| *of == fold).collect();
            let outside: Vec<bool> = inside.iter().map(|inside| !inside).collect();
            if inside.contains(&true) && outside.contains(&true) {
                elsewhere += self.fall(&outside, &inside)?;
            }
        }
        Some(elsewhere.min(fitted))
    }

    /// Gain by the line on the rows `judged`, with coefficients fitted to the rows `used`.
    fn fall(&self, used: &[bool], judged: &[bool]) -> Option<f64> {
        let [without, with] = [self.system.unknowns - self.own, self.system.unknowns].map(|count| {
            let residual = self.residual(count, used)?;
            let rows = residual.iter().zip(&self.solution.weights[0]).zip(judged).filter(|(_, judged)| **judged);
            Some(rows.map(|((e, w), _)| w * e * e).sum::<f64>())
        });
        Some((without? - with?) / (2.0 * self.solution.scale[0].powi(2) * self.slope))
    }

    /// Residual of all rows with the first `count` columns, fitted to some rows at the weights of the solution.
    fn residual(&self, count: usize, used: &[bool]) -> Option<Vec<f64>> {
        let block = &self.system.blocks[0];
        let columns = block.columns[..count].to_vec();
        let priors = self.system.priors.iter().copied().filter(|(at, _)| *at < count).collect();
        let whole = Block { y: block.y.clone(), columns };
        let weights = self.solution.weights[0].iter().zip(used).map(|(w, used)| if *used { *w } else { 0.0 }).collect();
        let system = System { blocks: vec![whole], unknowns: count, priors, trust: Vec::new() };
        let solution = system.solve_from(f64::INFINITY, vec![weights], self.solution.scale.clone())?;
        Some(solution.residual.into_iter().next().unwrap_or_default())
    }

    /// Gains of likelihood [nats of rows] by other columns beside all these, for several sets of one value per training row of the joint.
    pub fn gains_of(&self, sets: &[Vec<Vec<f64>>]) -> Vec<f64> {
        let Solution { residual, weights, scale, .. } = &self.solution;
        let score = Score::new(&self.system.blocks[0], &residual[0], &weights[0], scale[0], &self.system.priors);
        let filtered = |set: &Vec<Vec<f64>>| set.iter().map(|column| self.filter.apply(column)).collect::<Vec<_>>();
        sets.iter().map(|set| score.gain(&filtered(set)) / self.slope).collect()
    }
}
