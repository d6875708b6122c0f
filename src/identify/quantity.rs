//! An estimate with its uncertainty, beside the truth where that is known.

use serde::Serialize;

/// An estimated quantity: value, uncertainty, unit, and the truth where it is known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// Estimate, SI.
    pub value: f64,
    /// Standard error, same unit.
    pub std_error: f64,
    /// 95 % interval `[lower, upper]`, same unit.
    pub interval: [f64; 2],
    /// Unit of the above.
    pub unit: String,
    /// True value, where it is known.
    #[serde(rename = "true", skip_serializing_if = "Option::is_none")]
    pub truth: Option<f64>,
    /// `100 (value − true) / |true|` [%], where the truth is known and not zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_percent: Option<f64>,
}

impl Quantity {
    /// An estimate whose 95 % interval reaches `t` standard errors to either side.
    pub fn new(value: f64, std_error: f64, t: f64, unit: impl Into<String>) -> Self {
        let interval = [value - t * std_error, value + t * std_error];
        Self { value, std_error, interval, unit: unit.into(), truth: None, error_percent: None }
    }

    /// Writes the true value and the error beside the estimate.
    pub fn compare(&mut self, truth: f64) {
        self.truth = Some(truth);
        self.error_percent = (truth != 0.0).then(|| 100.0 * (self.value - truth) / truth.abs());
    }

    /// Whether the interval holds the true value; `None` where that is not known.
    pub fn covers_truth(&self) -> Option<bool> {
        self.truth.map(|truth| self.interval[0] <= truth && truth <= self.interval[1])
    }
}
