//! Expectations of a scenario about its tracking with compensation.

use std::fmt;

use super::tracking::{JointTracking, Tracking};

/// A bound of one figure of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackingExpectation {
    /// The joint.
    pub joint: String,
    /// Key of the scenario file: a name of `TRACKING_QUANTITIES`.
    pub quantity: &'static str,
    /// The bound, in the unit of the quantity.
    pub bound: f64,
}

/// A tracking expectation that failed.
#[derive(Debug, Clone, PartialEq)]
pub struct UnmetTracking {
    /// What was expected.
    pub expectation: TrackingExpectation,
    /// What was found; `None` if the joint was not tracked.
    pub found: Option<f64>,
}

/// A figure of a joint.
type Figure = fn(&JointTracking) -> f64;

/// Figures that can be expected, by the name of their key: its first word says whether the bound is the least or the most. The unit is %,
/// or that of the joint's position.
pub const TRACKING_QUANTITIES: [(&str, Figure); 4] = [
    ("least_reduction_percent", JointTracking::reduction_percent),
    ("least_share_percent", JointTracking::share_percent),
    ("most_variation_percent", JointTracking::variation_percent),
    ("most_rest_amplitude", |joint| joint.with.figures.rest_amplitude),
];

impl TrackingExpectation {
    /// The failure, if the tracking misses the expectation.
    pub fn check(&self, tracking: &Tracking) -> Option<UnmetTracking> {
        let figure = TRACKING_QUANTITIES.iter().find(|(name, _)| *name == self.quantity).map(|(_, figure)| figure);
        let joint = tracking.joints.iter().find(|joint| joint.joint == self.joint);
        let found = joint.zip(figure).map(|(joint, figure)| figure(joint));
        // NaN meets no expectation.
        let met = found.is_some_and(|found| if self.is_least() { found >= self.bound } else { found <= self.bound });
        (!met).then(|| UnmetTracking { expectation: self.clone(), found })
    }

    fn is_least(&self) -> bool {
        self.quantity.starts_with("least")
    }
}

impl fmt::Display for UnmetTracking {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TrackingExpectation { joint, quantity, bound } = &self.expectation;
        let side = if self.expectation.is_least() { "at least" } else { "at most" };
        match self.found {
            Some(found) => write!(f, "{joint}: {quantity} is {found:.4}, expected {side} {bound}"),
            None => write!(f, "{joint}: {quantity} expected, but this joint was not tracked"),
        }
    }
}
