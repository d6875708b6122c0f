//! Averages of autocorrelated samples.

/// Batches that the samples of a window are cut into for the standard error of their mean.
const BATCHES: usize = 16;

/// Arithmetic mean; NaN of nothing.
pub fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len() as f64
}

/// Median; NaN of nothing.
pub fn median(mut samples: Vec<f64>) -> f64 {
    let middle = samples.len() / 2;
    if samples.is_empty() { f64::NAN } else { *samples.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Mean and its standard error by batch means: the scatter of the means of 16 consecutive batches, each longer than the
/// correlation of the samples, carries that correlation into the error.
pub fn mean_with_error(samples: &[f64]) -> (f64, f64) {
    let batches = BATCHES.min(samples.len()).max(1);
    let means: Vec<f64> =
        (0..batches).map(|k| mean(&samples[k * samples.len() / batches..(k + 1) * samples.len() / batches])).collect();
    let scatter: f64 = means.iter().map(|m| (m - mean(&means)).powi(2)).sum::<f64>();
    let n = batches as f64;
    (mean(samples), (scatter / (n * (n - 1.0).max(1.0))).sqrt())
}
