//! Averages of autocorrelated samples.

/// Number of batches into which the samples of a window are divided for the standard error of their mean.
const BATCHES: usize = 16;

/// Arithmetic mean; NaN if there are no samples.
pub fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len() as f64
}

/// Median; NaN if there are no samples.
pub fn median(mut samples: Vec<f64>) -> f64 {
    let middle = samples.len() / 2;
    if samples.is_empty() { f64::NAN } else { *samples.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Standard deviation of normal errors by their median, `1.4826 median |e|`, which less than half of them cannot decide; NaN if there are none.
///
/// Reference: P. Rousseeuw, C. Croux (1993), Alternatives to the median absolute deviation.
pub fn typical(errors: impl Iterator<Item = f64>) -> f64 {
    1.4826 * median(errors.map(f64::abs).collect())
}

/// Mean and its standard error by batch means: each of 16 consecutive batches is longer than the correlation of the samples,
/// so the scatter of the batch means contains this correlation.
pub fn mean_with_error(samples: &[f64]) -> (f64, f64) {
    let batches = BATCHES.min(samples.len()).max(1);
    let means: Vec<f64> =
        (0..batches).map(|k| mean(&samples[k * samples.len() / batches..(k + 1) * samples.len() / batches])).collect();
    let scatter: f64 = means.iter().map(|m| (m - mean(&means)).powi(2)).sum::<f64>();
    let n = batches as f64;
    (mean(samples), (scatter / (n * (n - 1.0).max(1.0))).sqrt())
}
