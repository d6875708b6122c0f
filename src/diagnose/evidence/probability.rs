//! Probability that a named effect is right: all ways of naming use one calibration, so that a number means the same everywhere.

/// Intercept and slope of the probability's logarithmic odds against those of the evidence: the raw evidence is too confident where it is
/// strong, and not confident enough where rivals are near. `ln p/(1 − p) = 1.7 + 0.33 · min(−ln(odds against), 6)`. Fitted to 207 effects named on
/// tuning machines (`benches/blind`, seeds 1400 to 1411 and 2000 to 7103; `benches/hidden_effects`, seeds 1 to 40), in bins of the
/// uncalibrated probability: below 0.6, 6 of 7 are right; to 0.9, 13 of 14; to 0.985, 7 of 9; above, 173 of 177. It also holds with lines,
/// slips and
/// withdrawn names, and on 64 clean machines, because weak evidence has odds of its own: on 220 machines (seeds 1400 to 1411, 2000 to 7101,
/// 20000 to 20078, 31000 to 36100) 135 of 137 effects named are right, 127 of 127 of those above 0.97.
const CALIBRATION: [f64; 2] = [1.7, 0.33];
/// The same for the odds of look-alikes and other rivals. An exact model leaves small differences between rivals, which are right; errors of a
/// rough one favour any of them. Of names with raw odds below 1.5, 6 of 7 were right on the planar arms above, 11 of 17 on six joints under
/// gravity with exact and rough models (`benches/blind`, field seeds 63000, 986000, 992000, 994000, 1030000), from there to 9, 13 of 14 and 1 of 7,
/// above, 173 of 177 and 109 of 116.
const AGAINST_RIVALS: [f64; 2] = [0.9, 0.46];
/// Logarithmic odds above which stronger evidence changes nothing.
const SUREST: f64 = 6.0;

/// Probability [0 to 1] from the odds against, ≥ 0.
pub fn calibrated(odds_against: f64) -> f64 {
    logistic(CALIBRATION, odds_against)
}

/// Probability [0 to 1] from the odds of rivals and from those of no effect at all, each against the effect, ≥ 0.
pub fn beside_rivals(of_rivals: f64, of_none: f64) -> f64 {
    calibrated(of_none) * logistic(AGAINST_RIVALS, of_rivals) / logistic(AGAINST_RIVALS, 0.0)
}

fn logistic([intercept, slope]: [f64; 2], odds_against: f64) -> f64 {
    let log_odds = -odds_against.max(1e-300).ln();
    1.0 / (1.0 + (-intercept - slope * log_odds.clamp(-SUREST, SUREST)).exp())
}

/// Odds against a true value above `least`, with the logistic approximation of the normal distribution.
pub fn odds_against(value: f64, least: f64, std_error: f64) -> f64 {
    (-1.702 * (value - least) / std_error.max(1e-300)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stronger_evidence_is_never_less_probable_and_never_certain() {
        let odds = [1e9, 10.0, 1.0, 0.1, 1e-3, 1e-9];
        let probabilities = odds.map(calibrated);
        assert!(probabilities.windows(2).all(|pair| pair[0] <= pair[1]), "{probabilities:?}");
        assert!(probabilities.iter().all(|p| *p > 0.0 && *p < 1.0), "{probabilities:?}");
    }

    /// At equal evidence a name is right in seven of ten cases, `1/(1 + e^−0.9)` = 0.71, and no surer than without rivals.
    #[test]
    fn a_dead_heat_is_told_as_such() {
        assert!((beside_rivals(1.0, 0.0) - 0.71).abs() < 0.01, "{}", beside_rivals(1.0, 0.0));
        assert_eq!(beside_rivals(0.0, 0.02), calibrated(0.02));
        assert!(beside_rivals(1.0, 1.0) < beside_rivals(1.0, 0.0));
    }

    #[test]
    fn two_standard_errors_leave_odds_of_one_in_thirty() {
        // The normal distribution has 1 in 43 beyond 2 standard errors; the logistic approximation differs by less than 0.01 in probability.
        let odds = odds_against(3.0, 1.0, 1.0);
        assert!((odds / (1.0 + odds) - 0.0228).abs() < 0.01, "{odds}");
    }
}
