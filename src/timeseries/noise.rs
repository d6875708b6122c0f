//! The white noise of a sampled signal.

/// Standard deviation of the white noise of a signal [unit of the signal]: its third differences have 20 times the variance of the noise; the
/// median is robust against motion.
pub fn white_noise(signal: &[f64]) -> f64 {
    let mut differences: Vec<f64> = signal.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs()).collect();
    if differences.is_empty() {
        return 0.0;
    }
    let middle = differences.len() / 2;
    // The median of |x| of a normal variable is 0.6745 standard deviations.
    *differences.select_nth_unstable_by(middle, f64::total_cmp).1 / 0.6745 / 20.0_f64.sqrt()
}
