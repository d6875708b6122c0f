//! The size of a sampled signal, and of its white noise.

/// Root of the mean square [unit of the signal]; 0 without samples.
pub fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

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
