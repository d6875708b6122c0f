//! The direction in which a joint moves within a kernel.
//!
//! The friction of a row is that of the mean of `sgn v`. The averages `v` and `a` alone do not tell the course between: with `|v| < |a| w`, a velocity that
//! changes linearly passes zero at `s = −v/a`, and the joint goes back by `½ |a| w² (1 − |v/(a w)|)²`. A joint that sticks and slips can have
//! the same averages without going back. While it sticks, friction is whatever holds it. The positions tell the two apart.

use super::kernel::share_before;

/// [1] Share of the expected way back below which a joint does not turn. One that turns goes back by about all of it, by less where it rests meanwhile; one
/// that sticks and slips does not go back at all.
const TURNS: f64 = 0.25;

/// Mean of `sgn v` over a kernel of half width `w` [s], for a velocity that changes linearly within it with the average velocity `v` and acceleration `a`:
/// −1 to 1, and 0 at rest, with both below the velocity `rest` [rad/s or m/s].
pub fn direction([v, a, w]: [f64; 3], rest: f64) -> f64 {
    let change = a * w;
    if v.abs() < rest && change.abs() < rest {
        0.0
    } else if v.abs() >= change.abs() {
        v.signum()
    } else {
        change.signum() * (1.0 - 2.0 * share_before(-v / change))
    }
}

/// Whether a joint sticks and slips in a kernel whose averages look like those of a turn. `positions` [rad or m] are those of the kernel, `step` is one
/// count. A way back of less than some counts decides nothing: then the joint is taken to turn.
pub fn sticks([v, a, w]: [f64; 3], positions: &[f64], step: f64) -> bool {
    let change = a * w;
    v.abs() < change.abs()
        && way_back(positions) + step < TURNS * 0.5 * change.abs() * w * (1.0 - (v / change).abs()).powi(2)
}

/// The longest way that positions go against the direction in which they go on the whole.
fn way_back(positions: &[f64]) -> f64 {
    let (Some(first), Some(last)) = (positions.first(), positions.last()) else { return 0.0 };
    let forward = (last - first).signum();
    let mut furthest = f64::NEG_INFINITY;
    let back = positions.iter().map(|q| {
        furthest = furthest.max(forward * q);
        furthest - forward * q
    });
    back.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::diagnose::rows::kernel::Kernel;

    /// [rad] One count.
    const COUNT: f64 = 1e-5;
    /// [rad/s]
    const REST: f64 = 1e-3;
    /// [s]
    const DT: f64 = 1e-3;
    /// Samples on either side.
    const REACH: usize = 60;

    /// Direction, 0 where it sticks, and mean of `sgn v` over the kernel, of a motion `q(t)` [rad] with velocity `v(t)`, read in whole counts around the time `t`.
    fn both(t: f64, q: impl Fn(f64) -> f64, v: impl Fn(f64) -> f64) -> [f64; 2] {
        let time: Vec<f64> = (0..=2 * REACH).map(|k| t + DT * (k as f64 - REACH as f64)).collect();
        let kernel = Kernel::new(REACH, DT);
        let positions: Vec<f64> = time.iter().map(|t| (q(*t) / COUNT).round() * COUNT).collect();
        let signs: Vec<f64> = time.iter().map(|t| if v(*t) == 0.0 { 0.0 } else { v(*t).signum() }).collect();
        let averages = kernel.averages(&positions, REACH);
        let of_averages = [averages.rate, averages.curvature, kernel.half_width];
        let found = if sticks(of_averages, &positions, COUNT) { 0.0 } else { direction(of_averages, REST) };
        [found, kernel.averages(&signs, REACH).value]
    }

    /// One slip of 30 ms, from rest to rest, anywhere in a kernel of 121 ms. Wherever the averages tell of a turn there is none; of one that is shorter
    /// than a count nothing is known, but it is less than a hundredth of the kernel.
    #[test]
    fn property_a_joint_that_sticks_and_slips_does_not_turn() {
        let (length, slip) = (0.03, 2e-3);
        let q = |t: f64| slip * 0.5 * (1.0 - (PI * (t / length).clamp(0.0, 1.0)).cos());
        let v = |t: f64| if (0.0..length).contains(&t) { 1.0 } else { 0.0 };
        let found: Vec<f64> = (0..110).map(|k| both(0.015 + DT * (f64::from(k) - 55.0), q, v)[0]).collect();
        assert!(found.iter().all(|direction| *direction == 0.0 || *direction > 0.98), "{found:?}");
        assert!(found.iter().filter(|direction| **direction == 0.0).count() > 60, "{found:?}");
    }

    /// At the turn of `A sin ω t`, `v` is linear but for `(ω w)²/6` of it: 0.6 % with 1 Hz and 0.5 % of the kernel's edges; one count moves the
    /// time of the turn by some percent of the kernel where `½ a w²` is ten counts.
    #[test]
    fn closed_form_the_turn_of_a_sine_has_the_mean_of_its_signs() {
        for amplitude in [1e-3, 0.1] {
            let omega = 2.0 * PI;
            for k in -12..=12 {
                let t = 0.25 + 0.005 * f64::from(k);
                let [found, mean] =
                    both(t, |t| amplitude * (omega * t).sin(), |t| omega * amplitude * (omega * t).cos());
                assert!((found - mean).abs() < 0.1, "{amplitude} {k}: {found} {mean}");
            }
        }
    }

    /// A joint that rests for a third of the kernel while it turns goes back nearly as far as the averages tell: it turns. How long it rests they do not
    /// tell: only the sign of their direction is right.
    #[test]
    fn property_a_joint_that_rests_while_it_turns_turns() {
        let (speed, rest) = (0.1, 0.02);
        let q = |t: f64| -speed * (t.abs() - rest).max(0.0);
        let v = |t: f64| if t.abs() < rest { 0.0 } else { -speed * t.signum() };
        for k in (-30..=30).filter(|k| *k != 0) {
            let [found, mean] = both(DT * f64::from(k), q, v);
            assert!(found * mean > 0.0, "{k}: {found} {mean}");
        }
    }
}
