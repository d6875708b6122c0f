//! Friction with memory, which is one state: bristles that bend before they slip, or contacts that grow at rest.
//!
//! ```text
//!   Bristles (LuGre)   ż = v − σ0 |v| z/g(v)        F = σ0 z + σ1 ż + F_V v     g: the dry part of the friction law
//!   Rest               φ̇ = (1 − φ)/T − |v| φ/D      F_dry → F_dry + ΔF φ
//! ```
//! Bristles replace the set-valued law: below `g` they are a spring of stiffness `σ0` with hysteresis; at constant speed they
//! give the law itself. They store the energy `σ0 z²/2`. At rest `φ = 1 − e^{−t/T}`, and sliding over the distance `D` wears it off.
//! Left out: `σ1` that falls with speed; bristles behind the gear, where friction stays dry.
//! Reference: C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky (1995), A new model for control of systems with friction,
//! equations 1 to 3; J. H. Dieterich (1979), Modeling of rock friction 1, for contacts that grow at rest and wear off by sliding.

/// Memory of the friction of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Memory {
    /// Deflection `z` [rad or m] of the bristles on the rotor.
    Bristles {
        /// `σ0` [N·m/rad or N/m] > 0.
        stiffness: f64,
        /// `σ1` [N·m·s/rad or N·s/m] ≥ 0.
        damping: f64,
    },
    /// Share `φ` [1], 0 to 1, of the full growth `ΔF` of contacts at rest.
    Rest {
        /// `ΔF` [N·m or N] ≥ 0.
        growth: f64,
        /// `T` [s] > 0.
        time_constant: f64,
        /// `D` [rad or m] > 0.
        slip_distance: f64,
    },
}

impl Memory {
    /// Rate of the state, at a velocity at which the dry part of friction is `dry` > 0.
    pub fn rate(&self, state: f64, velocity: f64, dry: f64) -> f64 {
        match *self {
            Self::Bristles { stiffness, .. } => velocity - stiffness * velocity.abs() / dry * state,
            Self::Rest { time_constant, slip_distance, .. } => {
                (1.0 - state) / time_constant - velocity.abs() / slip_distance * state
            }
        }
    }

    /// Change of the state in a step `h` [s] over which velocity and dry friction are constant: `ṡ = r − f (s − s₀)`, solved exactly.
    pub fn change(&self, state: f64, velocity: f64, dry: f64, h: f64) -> f64 {
        let (forgets, rate) = (self.forgets(velocity.abs(), dry), self.rate(state, velocity, dry));
        let decay = if forgets * h > 1e-9 { -(-forgets * h).exp_m1() / forgets } else { h };
        rate * decay
    }

    /// [1/s] Decay rate of the state at a speed.
    pub fn forgets(&self, speed: f64, dry: f64) -> f64 {
        match *self {
            Self::Bristles { stiffness, .. } => stiffness * speed / dry,
            Self::Rest { time_constant, slip_distance, .. } => 1.0 / time_constant + speed / slip_distance,
        }
    }

    /// `σ0 z + σ1 Δz/Δt` [N·m or N] of bristles at a state that changes by `change` in a time `dt` [s]; contacts that grow at rest have no
    /// force of their own.
    pub fn force(&self, state: f64, change: f64, dt: f64) -> f64 {
        match *self {
            Self::Bristles { stiffness, damping } => stiffness * state + damping * change / dt,
            Self::Rest { .. } => 0.0,
        }
    }

    /// Increase [N·m or N] of the level of dry friction.
    pub fn level(&self, state: f64) -> f64 {
        match *self {
            Self::Bristles { .. } => 0.0,
            Self::Rest { growth, .. } => growth * state,
        }
    }

    /// [J] Stored energy.
    pub fn energy(&self, state: f64) -> f64 {
        match *self {
            Self::Bristles { stiffness, .. } => 0.5 * stiffness * state * state,
            Self::Rest { .. } => 0.0,
        }
    }
}
