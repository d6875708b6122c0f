//! How far a fitted machine is from what it would reach if it were exact.
//!
//! ```text
//!   floor = c ⟨Σ P ln P⟩     over a lower count, this count and a higher one, as the filter of the machine predicts them without missed torque
//! ```
//! The mean is the score of readings that come with the predicted probabilities; `c` is the caution of the filter, which allows for more noise than there is. Readings shortly after an outlier are left out: there the
//! filter has widened itself, and a wrong machine would lower its own floor.

use crate::likelihood::{JointScore, Score};

/// `λ` of a machine that misses nothing, the least that a fit takes.
pub const EXACT: f64 = -1.5;
/// `c` [1]: the filter takes the noise of the motor's torque 1.3 times that of the current sensor, and adds a part on the link. The score of a healthy machine
/// with its fitted parameters came to this share of the mean (tuning seed 800000), and to 1.01 of that of the true machine.
const CAUTION: f64 = 0.68;
/// [1] Score of a machine that is right, relative to its floor: 1.00 and 1.03 on healthy machines with exact and inexact nominal values, 2.7 where friction of
/// another law is missing, 5 where a compliance is (`docs/gate.md`, tuning seeds).
const RIGHT: f64 = 1.3;
/// [1] The same below which nothing better is sought: beyond what healthy machines reach.
const NEAR: f64 = 1.1;
/// [1] Torque that a machine that is right may miss, relative to the noise by its current sensors: its `λ` came to −1.5, a factor of 0.2, and wrong ones
/// kept 1.2 to 80.
const MISSED: f64 = 1.0;
/// [1] Probability of a reading below which it is an outlier, and readings [1] that are left out after one.
const OUTLIER: f64 = 1e-3;
const AFTER: usize = 100;

/// [nat] a reading, of joints scored without missed torque; `None` where nothing was read as predicted, so that none can be computed.
pub fn floor(scores: &[Score]) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for score in scores {
        for (joint, readings) in score.joints.iter().zip(&score.readings) {
            let of_joint = expected(joint, joint.nats.len().saturating_sub(*readings));
            sum += of_joint.0;
            count += of_joint.1;
        }
    }
    (count > 0.0).then(|| CAUTION * sum / count)
}

/// Sum of the expected scores from a reading on, and their number.
fn expected(joint: &JointScore, from: usize) -> (f64, f64) {
    let (mut sum, mut count, mut wait) = (0.0, 0.0, 0);
    for (below, inside) in joint.below.iter().zip(&joint.inside).skip(from) {
        if *inside < OUTLIER {
            wait = AFTER;
        }
        if wait > 0 {
            wait -= 1;
            continue;
        }
        sum += [*below, *inside, 1.0 - below - inside].map(term).iter().sum::<f64>();
        count += 1.0;
    }
    (sum, count)
}

/// `P ln P`.
fn term(p: f64) -> f64 {
    if p > 0.0 { p * p.ln() } else { 0.0 }
}

/// [1] What the errors of a fit are multiplied by where a machine scores this much a reading, of so many readings.
///
/// ```text
///   L(x) = L_max − ½ (Δx/σ)²  ⇒  |Δx| = σ √(2 D),      D = readings · (1.1 floor − score), at least 0
/// ```
/// A fit that ended beside its best place is off by that, if the parameter alone is: `σ √(1 + 2 D)` contains it. Within a tenth of the floor healthy machines are
/// as far from it.
pub fn allowance(score: f64, floor: Option<f64>, readings: f64) -> f64 {
    let missing = floor.map_or(0.0, |floor| readings * (NEAR * floor - score).max(0.0));
    (1.0 + 2.0 * missing).sqrt()
}

/// Whether a score is so far from its floor, or so much torque missed, that the machine lacks something else.
pub fn is_far(score: f64, floor: Option<f64>, missed: &[f64]) -> bool {
    floor.is_none_or(|floor| score < RIGHT * floor) || missed.iter().any(|missed| *missed > MISSED)
}

/// Whether a score is as near to its floor as those of healthy machines, and no more torque is missed.
pub fn is_near(score: f64, floor: Option<f64>, missed: &[f64]) -> bool {
    floor.is_some_and(|floor| score >= NEAR * floor) && missed.iter().all(|missed| *missed <= MISSED)
}

/// Torque that is missed at these `λ`, relative to the noise by the current sensors.
pub fn missed(lambda: &[f64]) -> Vec<f64> {
    lambda.iter().map(|lambda| lambda.exp()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_floor_of_an_even_chance_is_the_logarithm_of_two() {
        let joint = JointScore { nats: vec![0.0; 4], below: vec![0.5; 4], inside: vec![0.5; 4], missing: vec![0.0; 4] };
        let score = Score {
            name: String::new(),
            nats: vec![0.0],
            readings: vec![3],
            time: vec![0.0, 1.0, 2.0, 3.0],
            joints: vec![joint],
        };
        let floor = floor(&[score]).expect("readings");
        assert!((floor + CAUTION * std::f64::consts::LN_2).abs() < 1e-12);
    }

    #[test]
    fn analytic_a_score_that_a_parabola_explains_lies_within_the_allowance() {
        let (sigma, readings, floor) = (0.02, 1e4, -0.03);
        for away in [0.0, 1.0, 5.0, 30.0] {
            let score = NEAR * floor - 0.5 * f64::powi(away, 2) / readings;
            let error = sigma * allowance(score, Some(floor), readings);
            // σ √(1 + (Δx/σ)²), to rounding.
            assert!((error - sigma * f64::hypot(1.0, away)).abs() < 1e-6, "{away}: {error}");
        }
        // What is as near as a healthy machine, or has no floor, stays as it is.
        assert_eq!(allowance(-0.0305, Some(floor), readings), 1.0);
        assert_eq!(allowance(-0.3, None, readings), 1.0);
    }

    #[test]
    fn property_what_is_far_is_not_judged() {
        assert!(!is_far(-0.030, Some(-0.029), &missed(&[EXACT, EXACT])));
        assert!(is_near(-0.030, Some(-0.029), &missed(&[EXACT, EXACT])));
        assert!(!is_near(-0.035, Some(-0.030), &missed(&[EXACT, EXACT])));
        assert!(is_far(-0.090, Some(-0.044), &missed(&[EXACT, EXACT])));
        assert!(is_far(-0.030, Some(-0.029), &missed(&[3.0, EXACT])));
        assert!(is_far(-0.030, None, &missed(&[EXACT])) && !is_near(-0.030, None, &missed(&[EXACT])));
    }
}
