//! How a fit to some data carries over to others.

use crate::diagnose::fit::problem::{Part, Problem};
use crate::identify::statistics::typical;
use crate::timeseries::root_mean_square;

/// [%] of the torque that clean machines do not leave beside data that determine a joint.
pub const LEFT_CLEARLY: f64 = 15.0;

/// Factor by which data may leave more than those that were fitted, where they leave more than [`LEFT_CLEARLY`]: in reports on 160 joints of real and
/// foreign simulated arms, some of them on the same data, none leaves more than 1.9 times as much, but for three, on which something acts in the
/// held-out data alone, or whose training data do not determine friction (4 to 13 times).
const UNSEEN: f64 = 3.0;

/// What a fit leaves of the torque of a joint in some data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarriedOver {
    /// [N·m or N] Residual.
    pub left: f64,
    /// [%] The same, of the RMS torque of these data.
    pub percent: f64,
    /// [1] The same, relative to what the fit leaves of the data that it is compared with.
    pub times: f64,
}

impl CarriedOver {
    /// Held-out data beside training data, from the residual of every row of a joint; `None` where no row of either part is judged. If the judged
    /// rows include rows in which a link floats, the typical residual counts, since a few such rows dominate the RMS.
    pub fn to_held_out(problem: &Problem, joint: usize, residual: &[f64]) -> Option<Self> {
        let [trained, held_out] = [Part::Train, Part::HeldOut].map(|part| problem.judged_rows(joint, part));
        if trained.is_empty() || held_out.is_empty() {
            return None;
        }
        let all = rms(residual, &held_out);
        let typical = || typical(held_out.iter().map(|row| residual[*row]));
        let left = if problem.floating[joint] { all.min(typical()) } else { all };
        Some(Self::new(left, rms(&problem.motion.joints[joint].torque, &held_out), rms(residual, &trained)))
    }

    /// Of a residual that is left beside a torque, and a residual of other data, all in N·m or N.
    pub fn new(left: f64, torque: f64, others: f64) -> Self {
        Self { left, percent: 100.0 * left / torque, times: left / others.max(f64::MIN_POSITIVE) }
    }

    /// Whether these data refute the fit: something acts in them that the others do not show, or those do not determine the joint.
    pub fn is_refuted(&self) -> bool {
        self.percent > LEFT_CLEARLY && self.times > UNSEEN
    }
}

/// RMS of the values of some rows, above zero.
pub fn rms(values: &[f64], rows: &[usize]) -> f64 {
    root_mean_square(&rows.iter().map(|row| values[*row]).collect::<Vec<_>>()).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_refuted_where_much_is_left_and_much_more_than_of_the_others() {
        let refuted = |percent: f64, times: f64| CarriedOver { left: 1.0, percent, times }.is_refuted();
        assert!(refuted(31.0, 4.0) && !refuted(31.0, 1.9) && !refuted(9.0, 4.0));
    }
}
