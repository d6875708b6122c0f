//! Lines in the torque that the baseline misses: frequencies from which a periodic disturbance is fitted.

use std::f64::consts::TAU;

use lostmotion::likelihood::Score;

/// [Hz] Where mains, their harmonics and converters lie, and the spacing: a fifth of the width of a line of ten seconds.
const RANGE: [f64; 2] = [10.0, 140.0];
const SPACING: f64 = 0.02;
/// [Hz] Two lines are no closer.
const APART: f64 = 0.5;

/// The strongest frequencies [Hz] of a joint, in all recordings together; times count from the start of each session.
pub fn strongest(scores: &[Score], joint: usize, count: usize) -> Vec<f64> {
    let steps = ((RANGE[1] - RANGE[0]) / SPACING) as usize;
    let mut power: Vec<(f64, f64)> = (0..steps)
        .map(|k| {
            let frequency = RANGE[0] + SPACING * k as f64;
            (scores.iter().map(|score| power_of(score, joint, frequency)).sum(), frequency)
        })
        .collect();
    power.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut found: Vec<f64> = Vec::new();
    for (_, frequency) in power {
        if found.len() < count && found.iter().all(|one| (one - frequency).abs() > APART) {
            found.push(frequency);
        }
    }
    found
}

/// Power of one frequency, by a rotating phasor.
fn power_of(score: &Score, joint: usize, frequency: f64) -> f64 {
    let missing = &score.joints[joint].missing;
    let (mut re, mut im) = (0.0, 0.0);
    let interval = (score.time[score.time.len() - 1] - score.time[0]) / (score.time.len() - 1) as f64;
    let (sin, cos) = (TAU * frequency * interval).sin_cos();
    let (mut s, mut c) = (0.0, 1.0);
    // Outliers pull no line.
    let spread = (missing.iter().map(|torque| torque.abs()).sum::<f64>() / missing.len() as f64) * 5.0;
    for torque in missing {
        let torque = torque.clamp(-spread, spread);
        (re, im) = (re + torque * c, im + torque * s);
        (s, c) = (s * cos + c * sin, c * cos - s * sin);
    }
    (re * re + im * im) / missing.len() as f64
}
