//! Spectrum of the disturbance torque of a piece, and the level of its noise.

use nalgebra::Complex;

use super::balance::Stiffness;
use super::piece::Piece;
use crate::fourier::{Uneven, of_pair, transform};

/// [Hz] Distance on either side of a frequency over which its level is computed.
const AROUND: f64 = 2.0;
/// [Hz] Distance of the frequencies at which levels are computed.
const SPACING: f64 = 0.5;

/// `|E|²` at the frequencies `k · step`, and the level of its noise.
pub struct Spectrum {
    /// `|E|²`, starting at the first frequency.
    pub power: Vec<f64>,
    /// Mean of `|E|²` where there is no line, at the same frequencies.
    pub level: Vec<f64>,
}

/// The spectrum at the multiples `first..last` of `step` [Hz], which is `1/(length · dt)` of a piece at even times.
pub fn spectrum(stiffness: &Stiffness, piece: &Piece, length: usize, step: f64, [first, last]: [usize; 2]) -> Spectrum {
    let samples = piece.position.iter().zip(&piece.torque).map(|(position, torque)| Complex::new(*position, *torque));
    let z = match piece.uneven_times() {
        None => {
            let mut z = vec![Complex::default(); length];
            z.iter_mut().zip(samples).for_each(|(z, sample)| *z = sample);
            transform(&mut z);
            z
        }
        Some(times) => Uneven::new(times, step, length).transform(samples),
    };
    let power: Vec<f64> = (first..last)
        .map(|k| {
            let [position, torque] = of_pair(&z, k);
            let f = k as f64 * step;
            ((stiffness.at(f) * position - torque) / piece.gain(f)).norm_sqr()
        })
        .collect();
    let level = levels(&power, (AROUND / step) as usize, ((SPACING / step) as usize).max(1));
    Spectrum { power, level }
}

/// Mean of an exponential distribution with the median of the neighbours.
fn levels(power: &[f64], reach: usize, spacing: usize) -> Vec<f64> {
    let at = |centre: usize| {
        let (from, to) = (centre.saturating_sub(reach), (centre + reach).min(power.len()));
        // Neighbouring bins of a padded transform are nearly equal: a part of them is enough.
        let mut near: Vec<f64> = power[from..to].iter().step_by(4).copied().collect();
        let middle = near.len() / 2;
        (*near.select_nth_unstable_by(middle, f64::total_cmp).1 / std::f64::consts::LN_2).max(1e-300)
    };
    let known: Vec<f64> = (0..power.len()).step_by(spacing).map(at).collect();
    (0..power.len()).map(|k| known[((k + spacing / 2) / spacing).min(known.len() - 1)]).collect()
}
