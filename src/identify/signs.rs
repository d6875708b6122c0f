//! Recovers the sign of a current of which only the magnitude was measured, by a shunt below the bridge.
//!
//! While a joint moves, its motor works against friction and gravity, `τ ≈ G(q) + F sgn q̇`, which has a sign. The direction is known
//! from the encoder, and `G` from the model. The only unknown is a mean level `F`: it is chosen such that `|G + F sgn q̇|` is nearest to
//! the measured magnitude.
//! Where `G` and friction nearly cancel, the sign is uncertain and the window is left out: rectified noise would bias the average.
//! At rest the sign is that of the last motion. Left out: braking by the motor, which steady windows do not contain.

use super::signals::Signals;

/// [s] Half the time over which the direction is taken.
const HALF: f64 = 0.1;
/// Levels of friction that are tried, up to the largest torque that was read plus the largest gravity.
const LEVELS: usize = 400;
/// Part of the level below which an expected torque has no certain sign.
const DOUBT: f64 = 0.25;

/// Gives the torque its sign; returns, for every sample, whether it is certain.
pub fn recover(signals: &mut Signals, gravity: &[f64]) -> Vec<bool> {
    let directions = directions(signals);
    let level = level(&signals.torque, gravity, &directions);
    let mut certain = Vec::with_capacity(directions.len());
    for ((torque, gravity), direction) in signals.torque.iter_mut().zip(gravity).zip(&directions) {
        let expected = gravity + level * direction;
        *torque = torque.abs().copysign(expected);
        certain.push(expected.abs() >= DOUBT * level);
    }
    certain
}

/// Direction of the motion at every sample; while the encoder stands still, the direction before.
fn directions(signals: &Signals) -> Vec<f64> {
    let clock = &signals.clock;
    let last = signals.position.len() - 1;
    let mut direction = 0.0;
    (0..=last)
        .map(|k| {
            let to = clock.after(k, HALF).clamp((k + 1).min(last), last);
            let from = clock.before(k, HALF).min(k.saturating_sub(1));
            let way = signals.position[to] - signals.position[from];
            if way.abs() > 1.5 * signals.count {
                direction = way.signum();
            }
            direction
        })
        .collect()
}

/// The level of friction that explains the magnitudes best, least absolute error over the samples in motion.
fn level(magnitude: &[f64], gravity: &[f64], directions: &[f64]) -> f64 {
    let largest = |x: &[f64]| x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let top = largest(magnitude) + largest(gravity);
    let stride = (magnitude.len() / 5000).max(1);
    let error = |level: f64| -> f64 {
        let samples = (0..magnitude.len()).step_by(stride).filter(|&k| directions[k] != 0.0);
        samples.map(|k| (magnitude[k].abs() - (gravity[k] + level * directions[k]).abs()).abs()).sum()
    };
    let levels = (1..=LEVELS).map(|k| top * k as f64 / LEVELS as f64);
    levels.map(|level| (error(level), level)).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(top, |(_, level)| level)
}
