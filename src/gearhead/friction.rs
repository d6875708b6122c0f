//! Friction of a gearhead against speed, per direction: equation 6 of the paper, or its two lines of equation 9.
//!
//! ```text
//!   F(v) = (F_C + (F_S − F_C) e^{−|v|/v_S}) sgn v + F_V v         F_S |\
//!                                                                     | \       ___
//!   d1: a1 + b1 |v|,  |v| ≤ v_sw = (a1 − a2)/(b2 − b1)            F_C |. .`---´
//!   d2: a2 + b2 |v|,  |v| > v_sw                                      +--------------- |v|
//!                                                                        v_sw
//! ```
//! Sign: `F` opposes the motion; it is subtracted from the driving torque.
//! At rest friction is set-valued: it takes any value in `[−F(0⁻), F(0⁺)]` that keeps the rotor still.
//! Reference: L. Márton, B. Lantos (2009), equations 6 to 9.

/// Direction of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// v > 0.
    Positive,
    /// v < 0.
    Negative,
}

impl Direction {
    /// Direction of a velocity; positive at rest.
    pub fn of(velocity: f64) -> Self {
        if velocity < 0.0 { Self::Negative } else { Self::Positive }
    }

    /// +1 or −1.
    pub const fn sign(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }

    /// Index into `[positive, negative]` pairs.
    pub const fn index(self) -> usize {
        match self {
            Self::Positive => 0,
            Self::Negative => 1,
        }
    }
}

/// [1] `|v|/v_S` above which the falling part is left out: `e⁻⁴⁰` is 4e-18.
const FALLEN: f64 = 40.0;

/// One direction of equation 6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exponential {
    /// `F_C` [N·m or N] Coulomb friction, ≥ 0.
    pub coulomb: f64,
    /// `F_S` [N·m or N] breakaway friction, ≥ 0.
    pub breakaway: f64,
    /// `v_S` [rad/s or m/s] Stribeck velocity, > 0.
    pub stribeck_velocity: f64,
    /// `F_V` [N·m·s/rad or N·s/m] viscous friction.
    pub viscous: f64,
}

impl Exponential {
    /// Dry part `F_C + (F_S − F_C) e^{−|v|/v_S}` [N·m or N] at a speed `|v|`.
    pub fn dry(&self, speed: f64) -> f64 {
        self.coulomb + self.fall(speed)
    }

    /// `(F_S − F_C) e^{−|v|/v_S}`; zero where it is beyond the last digit of `F_C`.
    fn fall(&self, speed: f64) -> f64 {
        let x = speed / self.stribeck_velocity;
        if x > FALLEN { 0.0 } else { (self.breakaway - self.coulomb) * (-x).exp() }
    }
}

/// One direction of equation 9, magnitude against speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lines {
    /// `a1` [N·m or N] value at rest of the first line.
    pub a1: f64,
    /// `b1` [N·m·s/rad or N·s/m] slope of the first line, negative where friction falls with speed.
    pub b1: f64,
    /// `a2` [N·m or N] value at rest of the second line.
    pub a2: f64,
    /// `b2` [N·m·s/rad or N·s/m] slope of the second line.
    pub b2: f64,
}

impl Lines {
    /// `v_sw = (a1 − a2)/(b2 − b1)` [rad/s or m/s], equation 8.
    pub fn switch_velocity(&self) -> f64 {
        (self.a1 - self.a2) / (self.b2 - self.b1)
    }
}

/// Law of friction, a value per direction `[positive, negative]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrictionLaw {
    /// Equation 6.
    Exponential([Exponential; 2]),
    /// Equation 9.
    TwoLines([Lines; 2]),
}

/// The law of equation 9 for both directions, `[positive, negative]`.
pub type TwoLines = [Lines; 2];

/// Friction of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// The law for rotor and link together.
    pub law: FrictionLaw,
    /// [1] Part of it that acts on the link side of the gap, 0 to 1; the rest acts on the rotor.
    pub link_share: f64,
}

impl Friction {
    /// The part on the link side of the gap, as a law of its own.
    #[must_use]
    pub fn of_link(&self) -> Self {
        let s = self.link_share;
        let law = match self.law {
            // Two lines of height zero have no switch velocity.
            FrictionLaw::TwoLines(_) if s == 0.0 => {
                let none = Exponential { coulomb: 0.0, breakaway: 0.0, stribeck_velocity: 1.0, viscous: 0.0 };
                FrictionLaw::Exponential([none; 2])
            }
            FrictionLaw::TwoLines(lines) => FrictionLaw::TwoLines(lines.map(|line| Lines {
                a1: s * line.a1,
                b1: s * line.b1,
                a2: s * line.a2,
                b2: s * line.b2,
            })),
            FrictionLaw::Exponential(laws) => FrictionLaw::Exponential(laws.map(|law| Exponential {
                coulomb: s * law.coulomb,
                breakaway: s * law.breakaway,
                viscous: s * law.viscous,
                ..law
            })),
        };
        Self { law, link_share: 1.0 }
    }
}

impl FrictionLaw {
    /// Magnitude of friction at speed `|v|` in a direction; at `|v| = 0` the breakaway torque.
    pub fn magnitude(&self, direction: Direction, speed: f64) -> f64 {
        match self {
            Self::Exponential(law) => {
                let law = &law[direction.index()];
                law.dry(speed) + law.viscous * speed
            }
            Self::TwoLines(law) => {
                let line = law[direction.index()];
                if speed <= line.switch_velocity() { line.a1 + line.b1 * speed } else { line.a2 + line.b2 * speed }
            }
        }
    }

    /// `F_C` [N·m or N]: the dry part that is left at high speed in a direction.
    pub const fn coulomb(&self, direction: Direction) -> f64 {
        match self {
            Self::Exponential(law) => law[direction.index()].coulomb,
            Self::TwoLines(law) => law[direction.index()].a2,
        }
    }

    /// `F_V` [N·m·s/rad or N·s/m]: the slope at high speed in a direction.
    pub const fn viscous(&self, direction: Direction) -> f64 {
        match self {
            Self::Exponential(law) => law[direction.index()].viscous,
            Self::TwoLines(law) => law[direction.index()].b2,
        }
    }

    /// Magnitude of friction at speed `|v|` in a direction, and its slope `d|F|/d|v|` there.
    pub fn magnitude_and_slope(&self, direction: Direction, speed: f64) -> (f64, f64) {
        match self {
            Self::Exponential(law) => {
                let law = &law[direction.index()];
                let fall = law.fall(speed);
                (law.coulomb + fall + law.viscous * speed, law.viscous - fall / law.stribeck_velocity)
            }
            Self::TwoLines(law) => {
                let Lines { a1, b1, a2, b2 } = law[direction.index()];
                let low = speed <= law[direction.index()].switch_velocity();
                if low { (a1 + b1 * speed, b1) } else { (a2 + b2 * speed, b2) }
            }
        }
    }

    /// `F(v)` with its sign, for `v ≠ 0`.
    pub fn kinetic(&self, velocity: f64) -> f64 {
        let direction = Direction::of(velocity);
        direction.sign() * self.magnitude(direction, velocity.abs())
    }
}

/// Velocity after a step in which friction reduces the speed by at most `loss`, `[positive, negative]` direction [rad/s or m/s]: a
/// motion that friction can stop ends at rest.
///
/// ```text
///   v = max(0, v* − loss₊)  for v* > 0,   v = min(0, v* + loss₋)  else          v*: without friction, loss = h F/J
/// ```
#[inline]
pub fn slowed(free: f64, loss: [f64; 2]) -> f64 {
    if free > 0.0 { (free - loss[0]).max(0.0) } else { (free + loss[1]).min(0.0) }
}
