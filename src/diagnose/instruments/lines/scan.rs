//! Frequencies at which a joint may have a line, and the lines there.

use rayon::prelude::*;

use super::balance::{Stiffness, receptances};
use super::estimate::{Line, MeasuredPiece, estimated};
use super::piece::Piece;
use super::spectrum::{Spectrum, spectrum};
use super::{CHANCE, HIGHEST, LOWEST, PRESENT, beyond_chance};
use crate::robot::Model;
use crate::timeseries::side_by_side;

/// Largest number of peaks that are tried, and their least distance [Hz].
const MOST_TRIED: usize = 6;
const FOOT: f64 = 1.0;

/// A frequency that the training pieces together show beyond chance.
pub struct Peak {
    /// [Hz]
    pub frequency: f64,
    /// [nats] of the training pieces together.
    pub evidence: f64,
    /// Level of the noise in the position of each piece.
    noise: Vec<f64>,
}

/// The spectra of a joint, and what stands out.
pub struct Scan {
    /// Index of the joint.
    pub joint: usize,
    /// The strongest peaks, the strongest first.
    pub peaks: Vec<Peak>,
    /// Training pieces come before the held-out ones.
    pieces: Vec<Piece>,
    /// [Hz] Distance of the scanned frequencies.
    step: f64,
}

/// Number of samples of a piece's transform: twice as fine as its frequency resolution.
pub const fn length_of(longest: usize) -> usize {
    (2 * longest).next_power_of_two()
}

/// [bytes] Memory of a transform: complex samples, and the same again as work space.
pub const fn transform_bytes(length: usize) -> usize {
    32 * length
}

impl Scan {
    /// `None` without pieces to learn from and others to judge by, or where samples are too far apart.
    pub fn new(model: &Model, joint: usize, pieces: Vec<Piece>) -> Option<Self> {
        let trained = pieces.iter().take_while(|piece| !piece.held_out).count();
        let longest = pieces.iter().map(|piece| piece.weight.len()).max()?;
        let dt = pieces.iter().map(|piece| piece.dt).reduce(f64::max)?;
        if trained == 0
            || trained == pieces.len()
            || pieces.iter().any(|piece| piece.uneven_times().is_none() && (piece.dt / dt - 1.0).abs() > 1e-3)
        {
            return None;
        }
        let length = length_of(longest);
        let step = 1.0 / (length as f64 * dt);
        let (first, last) = ((LOWEST / step) as usize, ((HIGHEST.min(0.4 / dt)) / step) as usize);
        if last <= first + 8 {
            return None;
        }
        let [lowest, highest] = [first as f64 * step, last as f64 * step];
        let stiffness: Vec<Stiffness> =
            pieces.par_iter().map(|piece| Stiffness::new(model, joint, &piece.places, lowest, highest)).collect();
        let pairs: Vec<(&Piece, &Stiffness)> = pieces.iter().zip(&stiffness).collect();
        let spectra: Vec<Spectrum> = side_by_side(&pairs, transform_bytes(length), |(piece, stiffness)| {
            spectrum(stiffness, piece, length, step, [first, last])
        });
        let peaks = peaks(&spectra[..trained], model.joints.len(), |k| (first + k) as f64 * step);
        let noise = |k: usize, f: f64| {
            spectra.iter().zip(&stiffness).map(|(one, stiffness)| one.level[k] / stiffness.at(f).norm_sqr()).collect()
        };
        let peak =
            |(k, [frequency, evidence]): (usize, [f64; 2])| Peak { frequency, evidence, noise: noise(k, frequency) };
        let peaks = peaks.into_iter().map(peak).collect();
        Some(Self { joint, peaks, pieces, step })
    }

    /// The line at each peak that is one.
    pub fn lines<'s>(&'s self, model: &'s Model) -> impl Iterator<Item = Line> + 's {
        let trained = self.pieces.iter().take_while(|piece| !piece.held_out).count();
        let line = move |peak: &Peak| {
            let part = |(piece, noise): (&'s Piece, &f64)| MeasuredPiece {
                piece,
                receptance: receptances(model, self.joint, &piece.places, peak.frequency),
                noise: *noise,
            };
            let parts: Vec<MeasuredPiece> = self.pieces.par_iter().zip(&peak.noise).map(part).collect();
            estimated(parts.split_at(trained), peak.frequency, self.step)
        };
        self.peaks.iter().filter_map(line)
    }
}

/// Indices at which the training pieces together show something beyond chance, with frequency [Hz] and evidence [nats], the strongest first.
fn peaks(trained: &[Spectrum], joints: usize, frequency: impl Fn(usize) -> f64) -> Vec<(usize, [f64; 2])> {
    let count = trained.first().map_or(0, |spectrum| spectrum.power.len());
    let evidence = |k: usize| trained.iter().map(|spectrum| spectrum.power[k] / spectrum.level[k]).sum();
    let sums: Vec<f64> = (0..count).map(evidence).collect();
    let asked = beyond_chance(trained.len(), CHANCE / (sums.len() * joints) as f64);
    // A limit cycle of the loop is strong in one piece only, and would displace a line among the peaks that are tried.
    let seen = |k: usize| trained.iter().filter(|one| one.power[k] > PRESENT * one.level[k]).count();
    let mut all: Vec<usize> = (0..count).filter(|k| sums[*k] > asked && seen(*k) >= trained.len().min(2)).collect();
    all.sort_by(|a, b| sums[*b].total_cmp(&sums[*a]));
    let mut tried: Vec<(usize, [f64; 2])> = Vec::new();
    for k in all {
        let f = frequency(k);
        // A peak near a stronger one is its side lobe.
        if tried.len() < MOST_TRIED && tried.iter().all(|(_, [other, _])| (other - f).abs() >= FOOT) {
            tried.push((k, [f, sums[k]]));
        }
    }
    tried
}
