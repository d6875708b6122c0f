//! The motor's motion between the edges of its encoder.
//!
//! ```text
//!   edge between samples k − 1 and k:  θ = (x_{k−1} + x_k)/2 halfway between them;  straight lines from edge to edge
//!   θ̇(t) = (θ(t + h) − θ(t − h))/(2h)
//! ```
//! The position is right to a count of the encoder between two edges, and without delay.

use crate::identify::signals::Signals;

/// [s] Half of the span over which a velocity is taken: five half spans are as long as the shortest crossing of a gap.
const HALF_SPAN: f64 = 0.010;

/// Position and velocity of a motor at every sample. Joint side, SI.
#[derive(Debug, Clone)]
pub struct Motion {
    /// `θ` [rad or m].
    pub position: Vec<f64>,
    /// `θ̇` [rad/s or m/s].
    pub velocity: Vec<f64>,
}

impl Motion {
    /// The motion that the counts of a session show.
    pub fn of(signals: &Signals) -> Self {
        let position = if signals.count == 0.0 { signals.position.to_vec() } else { between_edges(signals) };
        let (clock, last) = (&signals.clock, position.len().saturating_sub(1));
        let velocity = |k: usize| {
            let (from, to) = (clock.before(k, HALF_SPAN), clock.after(k, HALF_SPAN).min(last));
            if from < to { (position[to] - position[from]) / clock.elapsed(from, to) } else { 0.0 }
        };
        let velocity = (0..position.len()).map(velocity).collect();
        Self { position, velocity }
    }
}

/// Straight lines from edge to edge; the readings themselves before the first edge and after the last.
fn between_edges(signals: &Signals) -> Vec<f64> {
    let (x, clock) = (signals.position, &signals.clock);
    let mut found = x.to_vec();
    let mut before: Option<usize> = None;
    for k in 1..x.len() {
        if x[k] == x[k - 1] {
            continue;
        }
        if let Some(edge) = before {
            let half = |k: usize| 0.5 * clock.elapsed(k - 1, k);
            let (start, end) = (0.5 * (x[edge - 1] + x[edge]), 0.5 * (x[k - 1] + x[k]));
            let whole = half(edge) + clock.elapsed(edge, k) - half(k);
            for (at, value) in found.iter_mut().enumerate().take(k).skip(edge) {
                *value = start + (end - start) * (half(edge) + clock.elapsed(edge, at)) / whole;
            }
        }
        before = Some(k);
    }
    found
}
