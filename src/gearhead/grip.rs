//! Friction of one side of a gearhead: its share of the joint's law plus friction of its own, smooth within each slip mode.
//!
//! ```text
//!   F_side = share · F(|v|) + own
//!   F(|v|) = F_C + D e^{−|v| σ} + F_V |v|          D = F_S − F_C, σ = 1/v_S; of two lines each is one such law with D = 0
//! ```
//! This is [`FrictionLaw`] in the form that an integrator needs: one smooth branch per slip mode, with the same values up to rounding.
//! A step may lead beyond the end of a mode before the end is located. There, at a negative speed, the exponential is continued
//! along its tangent at `|v| σ = −1`. Otherwise it would reach e⁷⁰ when a hammering rotor is thrown back within a step. A law that rises from rest,
//! `D < 0`, is reflected in its point at rest instead: along a tangent it would drive the rotor, ever harder, the way that it came.
//! Two lines meet at a kink, at the switch velocity: the slower and the faster line are modes of their own, so that the kink is
//! located like any other event.
//! Sign: a magnitude; it opposes the slip.
//! State: the [`Slip`], which the integrator stores.
//! Left out: changes of the level by effects, and the memory of friction ([`Memory`](super::Memory)).
//! Reference: L. Márton, B. Lantos (2009), equations 6 to 9.

use super::{Direction, Exponential, Friction, FrictionLaw, Lines, Slip};

/// Beyond this `|v| σ` the exponential adds nothing: e⁻⁴⁰ = 4e-18.
const GONE: f64 = 40.0;

/// One smooth piece of a law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Piece {
    /// `F_C`.
    coulomb: f64,
    /// `D`.
    drop: f64,
    /// `σ`.
    steepness: f64,
    /// `F_V`.
    viscous: f64,
}

impl Piece {
    fn exponential(law: &Exponential) -> Self {
        let Exponential { coulomb, breakaway, stribeck_velocity, viscous } = *law;
        Self { coulomb, drop: breakaway - coulomb, steepness: 1.0 / stribeck_velocity, viscous }
    }

    fn line(a: f64, b: f64) -> Self {
        Self { coulomb: a, viscous: b, ..Self::default() }
    }

    #[inline(always)]
    fn at(&self, speed: f64) -> f64 {
        let fallen = speed * self.steepness;
        let line = self.coulomb + self.viscous * speed;
        if self.drop == 0.0 || fallen > GONE {
            line
        } else if self.drop < 0.0 && fallen < 0.0 {
            line + self.drop * (2.0 - fallen.exp())
        } else if fallen < -1.0 {
            line - self.drop * std::f64::consts::E * fallen
        } else {
            line + self.drop * (-fallen).exp()
        }
    }
}

/// Friction of one side.
#[derive(Debug, Clone, PartialEq)]
pub struct Grip {
    /// [1] Part of the joint's law that acts on this side.
    pub share: f64,
    /// [N·m or N] Additional friction, the same at any speed.
    pub own: f64,
    /// Pieces of the joint's law, indexed by `Slip as usize`.
    pieces: [Piece; 6],
    /// [rad/s or m/s] Speed at which the slower piece ends, by direction.
    kinks: [f64; 2],
}

impl Grip {
    /// A share of a joint's law, plus the side's `own` friction.
    pub fn new(friction: Option<&Friction>, share: f64, own: f64) -> Self {
        let mut grip = Self { share, own, pieces: [Piece::default(); 6], kinks: [f64::INFINITY; 2] };
        for direction in [Direction::Positive, Direction::Negative] {
            let side = direction.index();
            let (slow, fast, kink) = match friction.map(|friction| &friction.law) {
                None => continue,
                Some(FrictionLaw::Exponential(law)) => {
                    let piece = Piece::exponential(&law[side]);
                    (piece, piece, f64::INFINITY)
                }
                Some(FrictionLaw::TwoLines(law)) => {
                    let Lines { a1, b1, a2, b2 } = law[side];
                    let (slow, fast) = (Piece::line(a1, b1), Piece::line(a2, b2));
                    // If the lines do not meet at a positive speed, the second is valid from rest on.
                    let kink = law[side].switch_velocity();
                    if kink > 0.0 { (slow, fast, kink) } else { (fast, fast, f64::INFINITY) }
                }
            };
            grip.pieces[Slip::of(direction, false) as usize] = slow;
            grip.pieces[Slip::of(direction, true) as usize] = fast;
            grip.kinks[side] = kink;
        }
        grip
    }

    /// Magnitude of the joint's law [N·m or N] in this slip mode at a speed.
    #[inline(always)]
    pub fn level(&self, slip: Slip, speed: f64) -> f64 {
        self.pieces[slip as usize].at(speed)
    }

    /// `F_side` [N·m or N] at a level of the joint's law.
    #[inline(always)]
    pub fn torque(&self, level: f64) -> f64 {
        self.share * level + self.own
    }

    /// Whether there is any friction.
    pub fn holds(&self) -> bool {
        self.share > 0.0 || self.own > 0.0
    }

    /// Slope [N·m·s/rad or N·s/m] of the joint's law at high speed, in the direction of a slip.
    pub fn viscous(&self, slip: Slip) -> f64 {
        self.pieces[Slip::of(slip.direction().unwrap_or(Direction::Positive), true) as usize].viscous
    }

    /// The slip mode of a velocity; that of the positive direction at rest.
    pub fn slip(&self, velocity: f64) -> Slip {
        let direction = Direction::of(velocity);
        Slip::of(direction, velocity.abs() > self.kinks[direction.index()])
    }

    /// Distance of a speed from the end of a slip mode, negative beyond it.
    #[inline]
    pub fn margin(&self, slip: Slip, speed: f64) -> f64 {
        let kink = self.kinks[slip.direction().unwrap_or(Direction::Positive).index()];
        if slip.is_fast() { speed - kink } else { speed.min(kink - speed) }
    }

    /// The slip mode that follows when a mode has ended at a speed; `None`: the body comes to rest.
    pub fn beyond(&self, slip: Slip, speed: f64) -> Option<Slip> {
        let direction = slip.direction()?;
        let at_kink = slip.is_fast() || speed > 0.5 * self.kinks[direction.index()];
        at_kink.then(|| Slip::of(direction, !slip.is_fast()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One law in two forms: with `1/v_S` and branches for the integrator, and as equations 6 and 9 state it.
    #[test]
    fn property_a_grip_has_the_friction_of_its_law() {
        let exponential = |scale: f64| Exponential {
            coulomb: 0.4 * scale,
            breakaway: 0.7 * scale,
            stribeck_velocity: 0.013,
            viscous: 0.21 * scale,
        };
        let line = |scale: f64| Lines { a1: 0.7 * scale, b1: -8.0, a2: 0.4 * scale, b2: 0.2 * scale };
        let laws = [
            FrictionLaw::Exponential([exponential(1.0), exponential(1.3)]),
            FrictionLaw::TwoLines([line(1.0), line(1.3)]),
        ];
        for law in laws {
            let grip = Grip::new(Some(&Friction { law, link_share: 0.3 }), 1.0, 0.0);
            for velocity in (-400..=400).filter(|k| *k != 0).map(|k| 1e-6 * f64::from(k).powi(3)) {
                let found = grip.level(grip.slip(velocity), velocity.abs());
                let asked = law.kinetic(velocity).abs();
                // The exponent, up to 5000, is rounded once more: its error counts where e^{−x} x is largest, at x = 1. Beyond 40, e⁻⁴⁰ is left out.
                assert!((found - asked).abs() < 1e-14 * asked.abs().max(1.0), "{velocity}: {found} of {asked}");
            }
        }
    }

    /// A rotor that a step throws back beyond its reversal must not be driven by more than its friction at rest.
    #[test]
    fn property_a_law_that_rises_from_rest_is_bounded_beyond_a_reversal() {
        let piece = Piece { coulomb: 0.27, drop: -0.21, steepness: 300.0, viscous: 0.0 };
        let rest = piece.at(0.0);
        for speed in (1..=400).map(|k| 1e-6 * f64::from(k).powi(2)) {
            assert!((piece.at(speed) + piece.at(-speed) - 2.0 * rest).abs() < 1e-15, "reflected at {speed}");
            assert!(piece.at(-speed) >= rest + piece.drop, "{speed}");
        }
    }
}
