//! The smoothing kernel of torque and motion: `K(s) = 15/(16 w) (1 − (s/w)²)²`, `|s| ≤ w`, without phase shift.
//!
//! Its derivatives give the rates of the same average, so position, velocity, acceleration and torque of a row are consistent for any `w`.
//! The second derivative weights samples like the curvature of a parabola fitted over the window (Savitzky and Golay 1964).

/// Weights for sampled signals at one half width.
#[derive(Debug, Clone)]
pub struct Kernel {
    /// Samples on either side.
    pub reach: usize,
    /// `w` [s]
    pub half_width: f64,
    value: Vec<f64>,
    rate: Vec<f64>,
    curvature: Vec<f64>,
}

/// Averages of a signal around a sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Averages {
    /// The mean.
    pub value: f64,
    /// Average of the first derivative.
    pub rate: f64,
    /// Average of the second derivative.
    pub curvature: f64,
}

impl Kernel {
    /// A kernel of `reach ≥ 2` samples on either side, with the sample interval `dt` [s].
    pub fn new(reach: usize, dt: f64) -> Self {
        let offset = |index: usize| index as f64 - reach as f64;
        let count = 2 * reach + 1;
        let span = reach as f64 + 0.5;
        let s = |index: usize| offset(index) / span;
        let mut value: Vec<f64> = (0..count).map(|i| (1.0 - s(i) * s(i)).powi(2)).collect();
        let total: f64 = value.iter().sum();
        value.iter_mut().for_each(|weight| *weight /= total);
        let mut rate: Vec<f64> = (0..count).map(|i| s(i) * (1.0 - s(i) * s(i))).collect();
        let slope: f64 = rate.iter().enumerate().map(|(i, weight)| weight * offset(i) * dt).sum();
        rate.iter_mut().for_each(|weight| *weight /= slope);
        let mut curvature: Vec<f64> = (0..count).map(|i| 12.0 * s(i) * s(i) - 4.0).collect();
        let mean = curvature.iter().sum::<f64>() / count as f64;
        curvature.iter_mut().for_each(|weight| *weight -= mean);
        let bend: f64 = curvature.iter().enumerate().map(|(i, weight)| 0.5 * weight * (offset(i) * dt).powi(2)).sum();
        curvature.iter_mut().for_each(|weight| *weight /= bend);
        Self { reach, half_width: span * dt, value, rate, curvature }
    }

    /// Averages around a sample that is at least `reach` samples away from both ends.
    pub fn averages(&self, signal: &[f64], centre: usize) -> Averages {
        let window = &signal[centre - self.reach..=centre + self.reach];
        let mut averages = Averages::default();
        // Subtract the value at the centre, so that a large constant costs no precision.
        let origin = signal[centre];
        for (index, sample) in window.iter().enumerate() {
            let x = sample - origin;
            averages.value += self.value[index] * x;
            averages.rate += self.rate[index] * x;
            averages.curvature += self.curvature[index] * x;
        }
        averages.value += origin;
        averages
    }

    /// `Σ weight²` [1/s²] of the rate: the gain for the variance of independent noise.
    pub fn rate_noise_gain(&self) -> f64 {
        self.rate.iter().map(|weight| weight * weight).sum()
    }

    /// `Σ weight²` of value and of curvature: the gain for the variance of independent noise.
    pub fn noise_gain(&self) -> (f64, f64) {
        let squares = |weights: &[f64]| weights.iter().map(|weight| weight * weight).sum();
        (squares(&self.value), squares(&self.curvature))
    }
}

/// `K(s)` of `w = 1`, |s| ≤ 1.
pub fn density(s: f64) -> f64 {
    15.0 / 16.0 * (1.0 - s * s).powi(2)
}

/// `K'(s)` of `w = 1`, |s| ≤ 1.
pub fn density_slope(s: f64) -> f64 {
    -15.0 / 4.0 * s * (1.0 - s * s)
}

/// Share of the kernel before `x = s/w`, 0 to 1.
pub fn share_before(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    0.5 + 15.0 / 16.0 * (x - 2.0 / 3.0 * x.powi(3) + 0.2 * x.powi(5))
}
