//! Reproducible random numbers: one ChaCha stream per sensor, identical on every computer.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

/// A stream of random numbers that a seed and a stream number determine.
#[derive(Debug, Clone)]
pub struct Noise(ChaCha8Rng);

impl Noise {
    /// Stream number `stream` of a seed; the streams are independent.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        Self(rng)
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        // 53 bits: every number is a multiple of 2⁻⁵³.
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Gaussian of mean 0 and standard deviation 1.
    pub fn gaussian(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}
