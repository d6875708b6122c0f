//! Delay, time constant and gain of a velocity channel by least squares, and which of the two lags the data show.
//!
//! ```text
//!   y(t) = g · LP_τ[v](t − T) + b + e        g, b: linear, solved for each T and τ
//! ```
//! To first order both lags are one, `T + τ`. They differ in second order: a low-pass also attenuates. A pure delay or a pure low-pass is ruled
//! out where its squared error exceeds that of both together, block by block, by more than [`RULED_OUT`] standard errors. If neither or both are
//! ruled out, both lags are given, with errors that are large and opposed where the data do not separate them.
//! Standard errors are those of sums over blocks of [`BLOCK`], so errors that last some time do not count as independent.

use nalgebra::{DMatrix, DVector};

use super::channel::{Channels, Stretch};
use crate::diagnose::fit::golden::golden_section;
use crate::effects::velocity_lag::LONGEST_LAG;
use crate::timeseries::Estimate;

/// [s] Length of a block: longer than kernel, delay and time constant.
const BLOCK: f64 = 1.0;
/// Least number of blocks whose sums show how they scatter.
const FEWEST_BLOCKS: usize = 6;
/// Standard errors beyond which a pure delay or a pure low-pass is ruled out: by chance in one of 370.
const RULED_OUT: f64 = 3.0;
/// Number of lags that are tried before the best is refined: steps of 19 ms, a twentieth of the period of motion up to 2.6 Hz.
const TRIED: usize = 16;
/// Steps of the golden section: 0.618¹⁴ of the interval is 0.1 %. This error of the lag is far below its standard error, because least
/// squares are flat at their minimum.
const STEPS: usize = 14;
/// [1] Range of the sum of both lags relative to that of the better one: a low-pass needs a longer time constant than a delay for one lag in
/// phase, `tan ω T` instead of `ω T`.
const AROUND: [f64; 2] = [0.5, 2.0];
/// [1] Systematic standard error of a lag in sample intervals: whether a reading belongs to the start or the end of its interval differs between
/// drives by up to half an interval, which the threshold covers; the times of recorded samples are known to some hundredths of it.
const SYSTEMATIC: f64 = 0.05;
/// [1] Squared correlation of the channel with the expected velocity below which it measures something else.
const ALIKE: f64 = 0.8;

/// Lags of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lags {
    /// `T` [s]; `None` where a low-pass alone explains the lag and a delay does not.
    pub delay: Option<Estimate>,
    /// `τ` [s]; `None` where a delay alone explains the lag and a low-pass does not.
    pub time_constant: Option<Estimate>,
    /// `T + τ` [s]
    pub total: Estimate,
    /// `g` [1]
    pub gain: Estimate,
    /// `b` [rad/s or m/s]
    pub offset: f64,
}

/// A model of the channel, with its linear parameters.
#[derive(Debug, Clone, Copy)]
pub struct Fitted {
    /// `T` [s]
    pub delay: f64,
    /// `τ` [s]
    pub time_constant: f64,
    /// `g` [1]
    pub gain: f64,
    /// `b` [rad/s or m/s]
    pub offset: f64,
    /// `Σ e²`
    squares: f64,
    /// `Σ (y − ȳ)²`
    power: f64,
}

impl Stretch {
    /// The compared points of the channel with these lags, of gain 1.
    pub fn lagging(&self, delay: f64, time_constant: f64) -> Vec<f64> {
        self.delayed(&self.filtered(time_constant), delay)
    }

    /// Compared points for training, counted from the first compared one.
    fn trained(&self) -> usize {
        self.held_out - self.first
    }
}

impl Channels {
    /// The model with these lags, its gain and offset fitted to the training points.
    pub fn at(&self, delay: f64, time_constant: f64) -> Fitted {
        // n, Σx, Σy, Σx², Σxy, Σy²
        let mut sums = [0.0; 6];
        for stretch in &self.stretches {
            let lagging = stretch.lagging(delay, time_constant);
            for (x, y) in lagging.iter().zip(&stretch.read[stretch.first..stretch.held_out]) {
                for (sum, value) in sums.iter_mut().zip([1.0, *x, *y, x * x, x * y, y * y]) {
                    *sum += value;
                }
            }
        }
        let [n, x, y, xx, xy, yy] = sums;
        let n = n.max(1.0);
        let (vx, cov, vy) = (xx - x * x / n, xy - x * y / n, yy - y * y / n);
        let gain = if vx > 0.0 { cov / vx } else { 0.0 };
        Fitted { delay, time_constant, gain, offset: (y - gain * x) / n, squares: vy - gain * cov, power: vy }
    }

    /// [s] First-order estimate of the lag: `y ≈ g (v − L v̇)`, and the share of the channel's squares [1] that it leaves.
    pub fn roughly(&self) -> [f64; 2] {
        let rows: usize = self.stretches.iter().map(Stretch::trained).sum();
        let mut matrix: DMatrix<f64> = DMatrix::zeros(3, 3);
        let mut vector: DVector<f64> = DVector::zeros(3);
        let (mut mean, mut squares) = (0.0, 0.0);
        for stretch in &self.stretches {
            for k in stretch.first..stretch.held_out {
                let (row, y) = ([stretch.expected[k], stretch.slope[k], 1.0], stretch.read[k]);
                for i in 0..3 {
                    vector[i] += row[i] * y;
                    (0..3).for_each(|j| matrix[(i, j)] += row[i] * row[j]);
                }
                mean += y;
                squares += y * y;
            }
        }
        let power = squares - mean * mean / rows.max(1) as f64;
        let Some(c) = matrix.cholesky().map(|cholesky| cholesky.solve(&vector)) else { return [0.0, 1.0] };
        let left = (squares - c.dot(&vector)) / power.max(1e-300);
        [if c[0] > 0.0 { -c[1] / c[0] } else { 0.0 }, left]
    }

    /// The best of the lags [s] that `lags` gives for a parameter from 0 to 1.
    fn best(&self, lags: &dyn Fn(f64) -> [f64; 2]) -> Fitted {
        let step = 1.0 / TRIED as f64;
        let squares = |k: usize| self.along(lags, k as f64 * step).squares;
        let tried = (0..=TRIED).map(|k| (k, squares(k)));
        let best = tried.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |(k, _)| k as f64 * step);
        self.refined(lags, [(best - step).max(0.0), (best + step).min(1.0)])
    }

    fn along(&self, lags: &dyn Fn(f64) -> [f64; 2], x: f64) -> Fitted {
        let [delay, time_constant] = lags(x);
        self.at(delay, time_constant)
    }

    /// The best of these lags between two values of the parameter.
    fn refined(&self, lags: &dyn Fn(f64) -> [f64; 2], ends: [f64; 2]) -> Fitted {
        let x = narrowed(ends, |x| -self.along(lags, x).squares);
        // The best value may be at an end: a lag of zero.
        let better = |best: Fitted, x: f64| {
            let one = self.along(lags, x);
            if one.squares < best.squares { one } else { best }
        };
        ends.into_iter().fold(self.along(lags, x), better)
    }

    /// The lags of the channel in the training data; `None` where it does not follow the position, or where there is too little motion.
    pub fn lags(&self) -> Option<Lags> {
        let late = self.best(&|x| [x * LONGEST_LAG, 0.0]);
        let smooth = self.best(&|x| [0.0, x * LONGEST_LAG]);
        let total = if late.squares < smooth.squares { late.delay } else { smooth.time_constant };
        // To first order the total is known and its division is not.
        let divided = |share: f64| {
            let lags = move |x: f64| [x * total * (1.0 - share), x * total * share];
            self.refined(&lags, AROUND)
        };
        let both = divided(narrowed([0.0, 1.0], |share| -divided(share).squares));
        let both = [late, smooth].into_iter().fold(both, |a, b| if b.squares <= a.squares { b } else { a });
        if both.squares > (1.0 - ALIKE) * both.power {
            return None;
        }
        let [no_delay, no_filter] = [self.ruled_out(&smooth, &both)?, self.ruled_out(&late, &both)?];
        match (no_filter, no_delay) {
            // A delay alone is possible, a low-pass alone is not.
            (false, true) => self.estimated(&late, [true, false]),
            (true, false) => self.estimated(&smooth, [false, true]),
            _ => self.estimated(&both, [true, true]),
        }
    }

    /// Whether a model's squared errors are larger than those of the best one beyond the scatter of blocks; `None` with too few blocks.
    fn ruled_out(&self, model: &Fitted, best: &Fitted) -> Option<bool> {
        let errors = |fitted: &Fitted| self.by_block(|stretch| vec![stretch.errors(fitted)], |_, e| e[0] * e[0]);
        let differences: Vec<f64> = errors(model).iter().zip(errors(best)).map(|(a, b)| a - b).collect();
        let n = differences.len();
        if n < FEWEST_BLOCKS {
            return None;
        }
        let total: f64 = differences.iter().sum();
        let mean = total / n as f64;
        let scatter: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() * n as f64 / (n - 1) as f64;
        Some(total > RULED_OUT * scatter.sqrt())
    }

    /// Sums over blocks of the training points: `of` gives signals of a stretch, `term` what is added for their values at a point.
    fn by_block<T: Default + std::ops::AddAssign>(
        &self,
        of: impl Fn(&Stretch) -> Vec<Vec<f64>>,
        term: impl Fn(&Stretch, &[f64]) -> T,
    ) -> Vec<T> {
        let mut blocks = Vec::new();
        for stretch in &self.stretches {
            let signals = of(stretch);
            let mut number = usize::MAX;
            for k in 0..stretch.trained() {
                let own = ((stretch.time[stretch.first + k] - stretch.time[stretch.first]) / BLOCK) as usize;
                if own != number {
                    blocks.push(T::default());
                    number = own;
                }
                let values: Vec<f64> = signals.iter().map(|signal| signal[k]).collect();
                if let Some(block) = blocks.last_mut() {
                    *block += term(stretch, &values);
                }
            }
        }
        blocks
    }

    /// Estimates with their errors; `free`: whether delay and time constant are fitted.
    fn estimated(&self, fitted: &Fitted, free: [bool; 2]) -> Option<Lags> {
        let Fitted { delay, time_constant, gain, offset, .. } = *fitted;
        // A tenth of a step: the slopes of the signal over it are those at the lag, up to 1e-4 of their change over a step.
        let probe = 0.1 * self.step;
        let slope = |stretch: &Stretch, later: [f64; 2]| -> Vec<f64> {
            let here = stretch.lagging(delay, time_constant);
            let there = stretch.lagging(delay + later[0], time_constant + later[1]);
            here.iter().zip(there).map(|(a, b)| gain * (b - a) / probe).collect()
        };
        let probes =
            [[probe, 0.0], [0.0, probe]].into_iter().zip(free).filter(|(_, free)| *free).map(|(probe, _)| probe);
        let probes: Vec<[f64; 2]> = probes.collect();
        let count = probes.len() + 2;
        let signals = |stretch: &Stretch| {
            let mut signals: Vec<Vec<f64>> = probes.iter().map(|probe| slope(stretch, *probe)).collect();
            signals.push(stretch.lagging(delay, time_constant));
            signals.push(vec![1.0; stretch.trained()]);
            signals.push(stretch.errors(fitted));
            signals
        };
        let scores = self.by_block(signals, |_, values| Sums::of(values));
        let blocks = scores.len();
        if blocks < FEWEST_BLOCKS.max(count + 1) {
            return None;
        }
        let mut information: DMatrix<f64> = DMatrix::zeros(count, count);
        let mut scatter: DMatrix<f64> = DMatrix::zeros(count, count);
        for sums in &scores {
            let (squares, score) = sums.parts(count);
            information += squares;
            scatter += &score * score.transpose();
        }
        let inverse = information.cholesky()?.inverse();
        let covariance = &inverse * scatter * &inverse * (blocks as f64 / (blocks - count) as f64);
        let systematic = SYSTEMATIC * self.step;
        let error = |index: usize| covariance[(index, index)].max(0.0).sqrt();
        let lags = probes.len();
        let of_total: f64 = (0..lags).flat_map(|i| (0..lags).map(move |j| (i, j))).map(|at| covariance[at]).sum();
        let estimate = |value: f64, index: usize| Estimate { value, std_error: error(index).hypot(systematic) };
        Some(Lags {
            delay: free[0].then(|| estimate(delay, 0)),
            time_constant: free[1].then(|| estimate(time_constant, lags - 1)),
            total: Estimate { value: delay + time_constant, std_error: of_total.max(0.0).sqrt().hypot(systematic) },
            gain: Estimate { value: gain, std_error: error(lags) },
            offset,
        })
    }
}

impl Stretch {
    /// `e` of the compared points [rad/s or m/s], held-out ones included.
    pub fn errors(&self, fitted: &Fitted) -> Vec<f64> {
        let lagging = self.lagging(fitted.delay, fitted.time_constant);
        let read = &self.read[self.first..];
        read.iter().zip(lagging).map(|(y, x)| y - fitted.gain * x - fitted.offset).collect()
    }
}

/// Place of the maximum of a function with one peak between two ends.
fn narrowed(ends: [f64; 2], f: impl FnMut(f64) -> f64) -> f64 {
    let mut left = STEPS;
    let done = |_: f64, _: f64| {
        left -= 1;
        left == 0
    };
    let (low, high) = golden_section(ends, done, f);
    0.5 * (low + high)
}

/// Products of the columns of a linear model and its error, summed.
#[derive(Default)]
struct Sums(Vec<f64>);

impl Sums {
    /// Products of all pairs of the columns and the error, which is last.
    fn of(values: &[f64]) -> Self {
        Self(values.iter().flat_map(|a| values.iter().map(move |b| a * b)).collect())
    }

    /// `Σ x xᵀ` and `Σ x e` of this number of columns.
    fn parts(&self, count: usize) -> (DMatrix<f64>, DVector<f64>) {
        let at = |i: usize, j: usize| self.0[i * (count + 1) + j];
        (DMatrix::from_fn(count, count, at), DVector::from_fn(count, |i, _| at(i, count)))
    }
}

impl std::ops::AddAssign for Sums {
    fn add_assign(&mut self, other: Self) {
        if self.0.is_empty() {
            *self = other;
        } else {
            self.0.iter_mut().zip(other.0).for_each(|(sum, value)| *sum += value);
        }
    }
}
