//! Golden section search: the maximum of a function with one peak between two ends, one evaluation per step.
//! Reference: J. Kiefer (1953), Sequential minimax search for a maximum.

/// Narrows `[low, high]` about the peak of `f` until `enough(low, high)`.
pub fn golden_section(
    [mut low, mut high]: [f64; 2],
    mut enough: impl FnMut(f64, f64) -> bool,
    mut f: impl FnMut(f64) -> f64,
) -> (f64, f64) {
    if enough(low, high) {
        return (low, high);
    }
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (f(left), f(right));
    loop {
        if at_left > at_right {
            (high, right, at_right) = (right, left, at_left);
            if enough(low, high) {
                return (low, high);
            }
            left = high - ratio * (high - low);
            at_left = f(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            if enough(low, high) {
                return (low, high);
            }
            right = low + ratio * (high - low);
            at_right = f(right);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::golden_section;

    #[test]
    fn recover_the_peak_of_a_parabola() {
        let mut evaluations = 0;
        let (low, high) = golden_section(
            [0.0, 4.0],
            |low, high| high - low < 1e-3,
            |x| {
                evaluations += 1;
                -(x - 1.234_f64).powi(2)
            },
        );
        assert!(low <= 1.234 && 1.234 <= high && high - low < 1e-3, "{low} {high}");
        // Each evaluation after the first shortens the interval by 38 %: ln(4000)/0.481 = 17.2.
        assert_eq!(evaluations, 19);
    }
}
