//! Strokes to and fro, at whose reversals the gap is measured.
//!
//! ```text
//!   q̇_d   /\      /\          way 2.6 L,  L = max(l, 2 b)          a = s F_C/I
//!     ___/  \    /  \         up with 2 a, down with 0.7 a, 0.4 a, 0.6 a, 0.5 a in turn
//!            \  /    \
//!             \/
//! ```
//! `l`: lag of the joint at a reversal; `b`: gap. A stroke is long enough for the controller to take up the lag and settle, so that the
//! joint brakes as its reference does. The braking is gentler than the friction `s F_C` on the link's side alone would brake the link of
//! inertia `I`: so the link stays on the flank that drives it, and the rotor crosses the whole gap. The joint brakes up to 1.5 times as hard
//! as its reference; with 0.95 a, one link in six left its flank up to a second before the turn. After a reversal the flank pushes, so the
//! joint may accelerate faster than it brakes, and has time for more reversals. With seven times `a` the controller has not settled when the
//! stroke brakes: single gaps of joint 1 scattered by 1.0 counts instead of 0.35.
//! No stretch has a constant speed: windows so soon after a reversal would make the friction worse that the same recordings give.
//!
//! Where in a count a rotor stops decides most of the error of a reversal: of a fit that only counts edges, four fifths of its variance. The turns
//! of strokes of one kind are attracted to a phase, probably because each edge takes a little torque from the controller. That phase depends on
//! the deceleration, so the plan has four kinds. `cargo bench --bench experiment -- reversals` prints these scatters and parts of a variance, of
//! the strokes as they are planned here.
//! Every pair of strokes ends 2.618 counts further on: multiples of the golden ratio spread the phases of a count evenly for any number.

use super::information::Possible;
use crate::control::SpeedStep;
use crate::robot::JointModel;

/// Share of the friction on the link's side, where the model gives none: small, as a bearing's.
const LEAST_SHARE: f64 = 0.1;
/// Decelerations of the pairs of strokes in turn, as parts of what the link's own friction gives.
const GENTLER: [f64; 4] = [0.7, 0.4, 0.6, 0.5];
/// Acceleration after a reversal, as a multiple of the same.
const FASTER: f64 = 2.0;
/// Gaps that are expected where the model gives none, in encoder counts.
const EXPECTED: f64 = 10.0;
/// Reversals of one recording that an identification uses.
pub const PER_RECORDING: usize = 12;
/// [counts] By which a pair of strokes ends beyond its start.
const ADVANCE: f64 = 2.618;
/// Way of a stroke per lag.
const WAY: f64 = 2.6;
/// [counts] Least way of a stroke: an identification needs ten for a reversal.
const LEAST_WAY: f64 = 15.0;

/// The strokes of a joint, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strokes {
    /// [rad or m] Way of a stroke.
    way: f64,
    /// [rad/s or m/s] Fastest.
    fastest: f64,
    /// `a` [rad/s² or m/s²] With which the link's own friction brakes it.
    gentle: f64,
    /// [rad/s² or m/s²] After a reversal.
    pub acceleration: f64,
    /// [rad or m] By which a pair ends beyond its start.
    pub advance: f64,
}

/// What the strokes are planned for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reversing {
    /// `l` [rad or m]
    pub lag: f64,
    /// [kg·m² or kg] of the link.
    pub inertia: f64,
    /// [rad/s² or m/s²]
    pub acceleration: f64,
    /// [rad/s or m/s]
    pub fastest: f64,
}

/// The gap that is expected [rad or m].
pub fn expected_gap(joint: &JointModel) -> f64 {
    joint.backlash.unwrap_or(EXPECTED * joint.encoder_step())
}

impl Strokes {
    /// The strokes of a joint.
    pub fn of(joint: &JointModel, possible: &Possible, motion: &Reversing) -> Self {
        let count = joint.encoder_step();
        let long = motion.lag.max(2.0 * expected_gap(joint)).max(LEAST_WAY / WAY * count);
        let share = joint.friction.map_or(LEAST_SHARE, |friction| friction.link_share).max(LEAST_SHARE);
        let gentle = (share * possible.smallest_coulomb() / motion.inertia).min(motion.acceleration);
        let acceleration = (FASTER * gentle).min(motion.acceleration);
        Self { way: WAY * long, fastest: motion.fastest, gentle, acceleration, advance: ADVANCE * count }
    }

    /// Deceleration [rad/s² or m/s²] and top speed [rad/s or m/s] of the stroke of this number.
    fn braking(&self, stroke: usize) -> (f64, f64) {
        let deceleration = GENTLER[stroke / 2 % GENTLER.len()] * self.gentle;
        let speed = (2.0 * self.way / (1.0 / self.acceleration + 1.0 / deceleration)).sqrt();
        (deceleration, speed.min(self.fastest))
    }

    /// [s] Of a recording with so many reversals.
    pub fn time(&self, reversals: usize) -> f64 {
        let ramps = |step: &SpeedStep| step.velocity.abs() * (1.0 / self.acceleration + 1.0 / step.deceleration);
        self.steps(reversals, 1.0).iter().map(|step| step.duration + ramps(step)).sum()
    }

    /// [rad or m] Longest way of a stroke.
    pub fn way(&self) -> f64 {
        self.way + self.advance
    }

    /// The steps with this number of reversals, the first in a direction of +1 or −1.
    pub fn steps(&self, reversals: usize, direction: f64) -> Vec<SpeedStep> {
        let step = |k: usize| {
            let (sign, further) = if k.is_multiple_of(2) { (direction, self.advance) } else { (-direction, 0.0) };
            let (deceleration, speed) = self.braking(k);
            SpeedStep { velocity: sign * speed, duration: further / speed, deceleration }
        };
        (0..=reversals).map(step).collect()
    }
}

/// Reversals of each recording: as few recordings as hold them all, about equally long.
pub fn recordings(reversals: usize) -> Vec<usize> {
    let number = reversals.div_ceil(PER_RECORDING).max(1);
    (0..number).map(|k| (reversals + k) / number).collect()
}
