//! The trend of a parameter over repeated identifications of one machine.
//!
//! Repeat `k` at the time `t_k` gave `y_k` with the standard error `s_k`, as far as it is its own and not shared by all repeats. They may scatter by more than
//! that:
//!
//! ```text
//!   y_k = α + β (t_k − t̄) + e_k            var e_k = s_k² + τ²           w_k = 1/(s_k² + τ²)
//!   τ² ≥ 0 such that Σ w_k r_k² = Σ r_k²/s_k² / max(φ̃, 1)          φ̃: scatter in comparison with the errors stated
//!   t = β/σ_β,  σ_β² = 1/Σ w_k (t_k − t̄)²   with n − 2 degrees of freedom or more       t̄ weighted by w_k
//! ```
//! A parameter alone has `φ̃ = φ = Σ r_k²/s_k²/(n − 2)`, so that the sum is `n − 2`: `τ²` makes the residuals as large as the scatter seen, and never less
//! than the errors stated. With equal `s_k`, `σ_β` is therefore the usual standard error of a slope, or more, and `t` exceeds a quantile of Student's
//! distribution at most as often as it should. Several parameters [support each other](pool): if all scatter as stated, each is known better than by its own few residuals.
//!
//! A result that stands apart from the line through the others is left out, the most improbable one first: its distance has the variance
//! of that line there plus `s_k² + τ²`, with n − 3 degrees of freedom. Of the `N` results of all parameters, the probability that any is
//! left out although all are normal is at most the given level: the limit of one is `level/N`. More than half of the results stay.
//! Without this step one identification that went wrong would hide every trend.
//!
//! A set of parameters is tested together. With Holm's steps the probability that any of them is named although none drifts is at
//! most the given level, however their errors depend on each other: of `m` p-values in rising order the `i`-th (from 0) is compared
//! with `level/(m − i)`, up to the first that is larger.
//!
//! Left out: a scatter that repeats share for a time, such as that of a machine that warms up slowly; it looks like a drift.
//! References: R. C. Paule, J. Mandel (1982), Consensus values and weighting factors; J. Hartung, G. Knapp (2001), On tests of the
//! overall treatment effect in meta-analysis with normally distributed responses; S. Holm (1979).

mod pool;

use serde::Serialize;

use self::pool::{Pool, Ratio};
use super::quantity::Quantity;
use crate::distributions::{student_975, student_two_sided};

/// Fewest repeats of a trend: two coefficients, and one repeat to judge their scatter.
pub const FEWEST_REPEATS: usize = 3;

/// Relative accuracy of `τ²`.
const ACCURACY: f64 = 1e-12;

/// One parameter in one identification.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Repeat {
    /// `t` time of the identification, in any unit.
    pub time: f64,
    /// `y` estimate, SI.
    pub value: f64,
    /// `s` its standard error, without what all repeats share, > 0.
    pub std_error: f64,
}

/// One parameter of one joint over all identifications.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct History {
    /// Joint in the URDF.
    pub joint: String,
    /// Its key in `report.json`, `friction.exponential.positive.coulomb`.
    pub parameter: String,
    /// Unit of the values.
    pub unit: String,
    /// The repeats in the order of time.
    pub repeats: Vec<Repeat>,
}

/// The trend of one parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trend {
    /// What was measured and took part in the fit.
    #[serde(flatten)]
    pub history: History,
    /// The repeats that stand apart from the others and took no part in the fit.
    pub left_out: Vec<Repeat>,
    /// `t̄` weighted mean of the times.
    pub middle_time: f64,
    /// `α` weighted mean of the values, which is the line's value at `t̄`.
    pub mean: Quantity,
    /// The line at the time of the first repeat.
    pub start: Quantity,
    /// `β` change in a unit of time.
    pub slope: Quantity,
    /// `β (t_n − t_1)`: change from the first repeat to the last.
    pub change: Quantity,
    /// The same in per cent of `start`.
    pub change_percent: f64,
    /// `τ` scatter between repeats that their standard errors do not explain; same unit as the values.
    pub excess_scatter: f64,
    /// Degrees of freedom of `σ_β`.
    pub freedom: f64,
    /// Probability of a `|t|` as large as this, or larger, without a trend.
    pub p_value: f64,
    /// Largest p-value at which a change is named, by Holm's steps.
    pub p_limit: f64,
    /// Whether a change is named.
    pub changed: bool,
}

impl Trend {
    /// The line at a time, and the 95 % interval of the line there: errors of `α` and `β` do not depend on each other.
    pub fn at(&self, time: f64) -> Quantity {
        let since = time - self.middle_time;
        let std_error = self.mean.std_error.hypot(since * self.slope.std_error);
        let value = self.mean.value + since * self.slope.value;
        Quantity::new(value, std_error, self.quantile(), &self.history.unit)
    }

    /// 95 % limits of the estimate of a repeat, if there is no trend.
    pub fn limits(&self, repeat: &Repeat) -> [f64; 2] {
        let half = self.quantile() * repeat.std_error.hypot(self.excess_scatter);
        [self.mean.value - half, self.mean.value + half]
    }

    /// 97.5 % quantile of Student's distribution with the degrees of freedom of the line.
    fn quantile(&self) -> f64 {
        student_975(self.freedom)
    }
}

/// The trend of every parameter with at least [`FEWEST_REPEATS`] repeats at different times; `level` is the probability that any change is
/// named although there is none.
pub fn trends(histories: &[History], unit_of_time: &str, level: f64) -> Vec<Trend> {
    let all: usize = histories.iter().map(|history| history.repeats.len()).sum();
    let improbable = level / all.max(1) as f64;
    let fits: Vec<Fit> = histories.iter().filter_map(|history| Fit::new(history, improbable)).collect();
    let pool = Pool::of(&fits.iter().map(|fit| fit.ratio).collect::<Vec<_>>());
    let mut found: Vec<Trend> = fits.into_iter().map(|fit| fit.trend(pool, unit_of_time)).collect();
    let mut order: Vec<usize> = (0..found.len()).collect();
    order.sort_by(|&a, &b| found[a].p_value.total_cmp(&found[b].p_value));
    let mut named = true;
    for (step, &k) in order.iter().enumerate() {
        found[k].p_limit = level / (order.len() - step) as f64;
        named &= found[k].p_value <= found[k].p_limit;
        found[k].changed = named;
    }
    found
}

/// `n − 2`.
fn freedom(repeats: &[Repeat]) -> f64 {
    repeats.len() as f64 - 2.0
}

/// Weighted sums of a straight line.
struct Line {
    /// `t̄` weighted mean of the times.
    middle: f64,
    /// `α` value there.
    level: f64,
    /// `β`.
    slope: f64,
    /// Variances of `α` and `β`; their errors do not depend on each other.
    variances: [f64; 2],
    /// `Σ w r²`.
    chi_squared: f64,
}

impl Line {
    /// The line with an excess variance `τ²`.
    fn new(repeats: &[Repeat], excess: f64) -> Self {
        let weight = |one: &Repeat| 1.0 / (one.std_error * one.std_error + excess);
        let sum = |of: &dyn Fn(&Repeat) -> f64| repeats.iter().map(|one| weight(one) * of(one)).sum::<f64>();
        let total = sum(&|_| 1.0);
        let middle = sum(&|one| one.time) / total;
        let level = sum(&|one| one.value) / total;
        let spread = sum(&|one| (one.time - middle).powi(2));
        let slope = sum(&|one| (one.time - middle) * (one.value - level)) / spread;
        let chi_squared = sum(&|one| (one.value - level - slope * (one.time - middle)).powi(2));
        Self { middle, level, slope, variances: [1.0 / total, 1.0 / spread], chi_squared }
    }
}

/// The line whose excess variance makes `Σ w r²` as large as `target`, and that variance. The sum falls as the variance grows.
fn balanced(repeats: &[Repeat], target: f64) -> (Line, f64) {
    let line = Line::new(repeats, 0.0);
    if line.chi_squared <= target {
        return (line, 0.0);
    }
    // Bounds: with weights of at least 1/(s² + τ²) for the largest s², the sum cannot exceed the target beyond this.
    let largest = repeats.iter().map(|one| one.std_error * one.std_error).fold(0.0, f64::max);
    let (mut low, mut high) = (0.0, line.chi_squared * largest / target);
    while high - low > ACCURACY * high {
        let middle = 0.5 * (low + high);
        if Line::new(repeats, middle).chi_squared > target { low = middle } else { high = middle }
    }
    (Line::new(repeats, high), high)
}

/// Divides repeats into those of the fit and those that stand apart: a p-value below `improbable`.
fn divided(repeats: &[Repeat], improbable: f64) -> [Vec<Repeat>; 2] {
    let (mut kept, mut apart) = (repeats.to_vec(), Vec::new());
    while kept.len() > FEWEST_REPEATS && 2 * (kept.len() - 1) > repeats.len() {
        let tested = (0..kept.len()).map(|k| (k, distance(&kept, k)));
        match tested.min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((k, p)) if p < improbable => apart.push(kept.remove(k)),
            _ => break,
        }
    }
    [kept, apart]
}

/// p-value of the distance of a repeat from the line through the others.
fn distance(repeats: &[Repeat], k: usize) -> f64 {
    let mut others = repeats.to_vec();
    let one = others.remove(k);
    let (line, excess) = balanced(&others, freedom(&others));
    let since = one.time - line.middle;
    let variance = line.variances[0] + since * since * line.variances[1] + one.std_error * one.std_error + excess;
    student_two_sided((one.value - line.level - since * line.slope) / variance.sqrt(), freedom(&others))
}

/// One parameter without the repeats that stand apart.
struct Fit {
    history: History,
    left_out: Vec<Repeat>,
    /// `φ`.
    ratio: Ratio,
}

impl Fit {
    /// `None` where there are too few repeats, or all at one time.
    fn new(history: &History, improbable: f64) -> Option<Self> {
        let [kept, left_out] = divided(&history.repeats, improbable);
        let (first, last) = (kept.first()?.time, kept.last()?.time);
        if kept.len() < FEWEST_REPEATS || last <= first {
            return None;
        }
        let freedom = freedom(&kept);
        let ratio = Ratio { value: Line::new(&kept, 0.0).chi_squared / freedom, freedom };
        Some(Self { history: History { repeats: kept, ..history.clone() }, left_out, ratio })
    }

    /// The trend, its p-value not yet compared.
    fn trend(self, pool: Pool, unit_of_time: &str) -> Trend {
        let Self { history, left_out, ratio: own } = self;
        let Ratio { value: ratio, freedom } = pool.beside(own);
        let repeats = &history.repeats;
        let (line, excess) = balanced(repeats, own.freedom * own.value / ratio.max(1.0));
        let [of_level, of_slope] = line.variances.map(f64::sqrt);
        let unit = history.unit.as_str();
        let of = |value: f64, std_error: f64, unit: &str| Quantity::new(value, std_error, student_975(freedom), unit);
        let (before, span) = (line.middle - repeats[0].time, repeats[repeats.len() - 1].time - repeats[0].time);
        let start = of(line.level - line.slope * before, of_level.hypot(before * of_slope), unit);
        Trend {
            left_out,
            middle_time: line.middle,
            mean: of(line.level, of_level, unit),
            slope: of(line.slope, of_slope, &format!("{unit}/{unit_of_time}")),
            change: of(line.slope * span, of_slope * span, unit),
            change_percent: 100.0 * line.slope * span / start.value.abs(),
            start,
            excess_scatter: excess.sqrt(),
            freedom,
            p_value: student_two_sided(line.slope / of_slope, freedom),
            p_limit: 0.0,
            changed: false,
            history,
        }
    }
}
