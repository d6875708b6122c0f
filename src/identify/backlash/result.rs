//! Results: each measured value, their mean, and the reversals that were left out, with the reason.

use super::reversal::FEWEST;
use crate::identify::quantity::Quantity;

/// Standard errors to either side of a 95 % interval of a normal distribution.
pub(super) const NORMAL_95: f64 = 1.96;
/// Standard errors from which a gap is seen: one that is never crossed looks like none, and is seldom beyond two.
pub(super) const SEEN: f64 = 5.0;

/// The gap of one joint by every estimator.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BacklashIdentification {
    /// Joint in the URDF.
    pub joint: String,
    /// Equation 15 with the filter that noisy current needs.
    pub paper: EstimatorResult,
    /// Equation 15 taken literally: raw current, first local minimum.
    pub paper_literal: EstimatorResult,
    /// The estimator whose result the program uses.
    pub best: EstimatorResult,
    /// [1] Part of the friction that acts on the link, a by-product of `best`; `None` if the data do not determine it.
    pub link_share: Option<Quantity>,
    /// A typical reversal of `paper`, for a figure; `None` if it has no value.
    #[serde(skip)]
    pub shown: Option<ShownReversal>,
}

impl BacklashIdentification {
    /// Whether a gap is there beyond doubt.
    pub(super) fn is_seen(&self) -> bool {
        self.best.values.len() >= FEWEST && self.best.is_seen()
    }

    /// Whether the link share, for whose errors a gap makes up, is found well.
    pub(super) fn share_is_known(&self) -> bool {
        /// Its error relative to itself: where gaps were off by a fifth and more it was 0.07 to 0.13, elsewhere mostly 0.03 (tuning seeds 3011 to 3016).
        const WELL: f64 = 0.05;
        self.link_share.as_ref().is_some_and(|share| share.std_error < WELL * share.value)
    }

    /// Whether two gaps differ by no more than their errors allow.
    pub(super) fn agrees_with(&self, other: &Self) -> bool {
        let [one, other] = [&self.best.mean, &other.best.mean];
        (one.value - other.value).abs() < NORMAL_95 * one.std_error.hypot(other.std_error)
    }
}

/// Signals around one reversal, and what equation 15 integrates there.
#[derive(Debug, Clone, PartialEq)]
pub struct ShownReversal {
    /// [s] Sample times.
    pub time: Vec<f64>,
    /// [rad/s or m/s] measured velocity.
    pub velocity: Vec<f64>,
    /// [N·m or N] motor torque, proportional to the measured current.
    pub torque: Vec<f64>,
    /// [N·m or N] the same, filtered: the minimum is sought in it.
    pub filtered: Vec<f64>,
    /// `t1`, `t2` as indices of these samples.
    pub ends: [usize; 2],
    /// `b_i` [rad or m] the area between them.
    pub area: f64,
}

impl BacklashIdentification {
    /// Writes the true gap and the errors beside every estimate.
    pub fn compare(&mut self, truth: f64) {
        for estimator in [&mut self.best, &mut self.paper, &mut self.paper_literal] {
            estimator.mean.compare(truth);
        }
    }

    /// Whether the gap that `best` found cannot be distinguished from zero: its 95 % interval reaches zero.
    pub fn consistent_with_zero(&self) -> bool {
        self.best.mean.interval[0] <= 0.0
    }
}

/// One estimator's gap.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct EstimatorResult {
    /// Name of the estimator.
    pub name: &'static str,
    /// `b` [rad or m] total gap at the joint, and its standard error.
    pub mean: Quantity,
    /// [%] `Σ|b_i − b|/(n b)`, the paper's mean deviation of the single values from their mean.
    pub mean_deviation_percent: f64,
    /// The value of each reversal.
    pub values: Vec<ReversalGap>,
    /// The reversals that give no value.
    pub left_out: Vec<LeftOut>,
}

/// The gap seen at one reversal.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ReversalGap {
    /// [s] When the rotor turned.
    pub time: f64,
    /// [rad/s or m/s] Steady velocity after the reversal, with its sign.
    pub velocity: f64,
    /// `b_i` [rad or m].
    pub gap: f64,
    /// [rad or m] Its standard error; NaN where the estimator has none for a single value.
    #[serde(skip_serializing_if = "not_a_number")]
    pub std_error: f64,
}

/// Takes a reference because serde requires one.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn not_a_number(value: &f64) -> bool {
    value.is_nan()
}

/// A reversal that gives no value of the gap.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct LeftOut {
    /// [s] When the rotor turned.
    pub time: f64,
    /// Why.
    pub reason: Reason,
}

/// Why a reversal gives no value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// No minimum of the current between the turn and the steady motion.
    NoMinimum,
    /// The velocity channel does not change its sign.
    NoZeroCrossing,
    /// The load rests on one flank through the reversal: gravity outweighs the link's friction.
    CarriedByLoad,
    /// The recording starts too late before it or ends too early after it.
    Truncated,
    /// The measured motion does not fit a rotor, a gap and a link of this model.
    Unexplained,
}

impl EstimatorResult {
    /// Whether its mean is a gap, whatever its error.
    pub(super) fn is_seen(&self) -> bool {
        self.mean.value > SEEN * self.mean.std_error
    }

    /// With a standard error that all its values share.
    pub(super) fn with_shared(mut self, std_error: f64) -> Self {
        let Quantity { value, std_error: own, unit, .. } = self.mean;
        self.mean = Quantity::new(value, own.hypot(std_error), NORMAL_95, unit);
        self
    }

    /// Mean and the paper's mean deviation of single values, the standard error from their scatter.
    pub(super) fn of_values(
        name: &'static str,
        unit: &'static str,
        values: Vec<ReversalGap>,
        left_out: Vec<LeftOut>,
    ) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().map(|one| one.gap).sum::<f64>() / n;
        let scatter = values.iter().map(|one| (one.gap - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let mean_deviation_percent = mean_deviation_percent(&values, mean);
        Self {
            name,
            mean: Quantity::new(mean, (scatter / n).sqrt(), NORMAL_95, unit),
            mean_deviation_percent,
            values,
            left_out,
        }
    }
}

/// `100 Σ|b_i − b|/(n b)`.
pub(super) fn mean_deviation_percent(values: &[ReversalGap], mean: f64) -> f64 {
    100.0 * values.iter().map(|one| (one.gap - mean).abs()).sum::<f64>() / (values.len() as f64 * mean)
}
