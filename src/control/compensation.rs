//! Feedforward of friction and the inverse of the gap: what a controller adds when it knows the gear of a joint.
//!
//! ```text
//!   motor ──► F_r ──► gap b ──► F_l ──► link          F_l = share F,  F_r = (1 − share) F,  F(0) = 0
//!
//!   T_d = R(q_d, q̇_d, q̈_d) + F_l(q̇_d)                torque that the gear must pass; R: links alone
//!   σ = sgn T_d                                       flank that must touch
//!   θ_d = q_d + s,    s: s_0 → σ b/2 in a time T      s_0 + (σ b/2 − s_0)(10 u³ − 15 u⁴ + 6 u⁵),  u = t/T
//!   τ_ff = F_r(q̇_d + ṡ) + F_l(q̇_d) + J s̈             J: rotor
//! ```
//! Signs: a positive `T_d` drives the link in its positive direction; the rotor then leads it by half the gap. Friction is what the motor has
//! to overcome, so it is added with the sign of the velocity.
//! The flank follows from the torque, not from the velocity alone: a link that is braked harder than its own friction would, or one that
//! gravity pulls, lies on the other flank. At rest its friction takes any value within breakaway, and so does `T_d`: if that range contains zero,
//! the flank stays as it is. A new crossing begins only after the last one has ended.
//! Everything follows from the reference. Feedback cannot excite it, so it adds no limit cycle: at rest `τ_ff = 0` and `s` is constant.
//! State: `σ`, and where and when the present crossing began.
//! Left out: wind-up of the gear (0.01° on the paper's arm), and the distance that a link coasts within the gap.
//! Reference: L. Márton, B. Lantos (2009), section IV, after its references 6 and 12.

use super::Target;

/// Friction torque `F(v)` [N·m or N] for `v ≠ 0`, with the sign of `v`.
pub type FrictionCurve = Box<dyn Fn(f64) -> f64 + Send>;

/// A gear as its controller knows it. Joint side, SI.
pub struct KnownGear {
    /// `F` of rotor and link together.
    pub friction: FrictionCurve,
    /// [1] Part of the friction that acts on the link, 0 to 1.
    pub link_share: f64,
    /// `b` [rad or m] total gap, ≥ 0.
    pub backlash: f64,
    /// `J` [kg·m² or kg] reflected inertia of the rotor, ≥ 0.
    pub rotor_inertia: f64,
    /// `T` [s] time to cross the gap, > 0.
    pub crossing_time: f64,
}

/// What is added to reference and torque of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Feedforward {
    /// `s` [rad or m] by which the motor leads the link.
    pub shift: f64,
    /// `ṡ` [rad/s or m/s].
    pub shift_velocity: f64,
    /// `τ_ff` [N·m or N].
    pub torque: f64,
}

/// Compensation of one joint.
pub struct Compensation {
    gear: KnownGear,
    /// `σ` −1, 0 or 1; 0 until a flank is first needed.
    flank: f64,
    /// `s_0` [rad or m] where the present crossing began.
    from: f64,
    /// [s] since it began.
    elapsed: f64,
}

impl Compensation {
    /// At rest in the middle of the gap.
    pub const fn new(gear: KnownGear) -> Self {
        let elapsed = gear.crossing_time;
        Self { gear, flank: 0.0, from: 0.0, elapsed }
    }

    /// What is added at the present target, `period` [s] after the last call. `rigid` is `R` [N·m or N].
    pub fn advance(&mut self, target: &Target, rigid: f64, period: f64) -> Feedforward {
        self.elapsed = (self.elapsed + period).min(self.gear.crossing_time);
        let needed = self.needed_flank(target, rigid);
        if needed != self.flank && self.elapsed >= self.gear.crossing_time {
            (self.from, self.elapsed) = (self.end(), 0.0);
            self.flank = needed;
        }
        let time = self.gear.crossing_time;
        let (u, way) = (self.elapsed / time, self.end() - self.from);
        let shift = self.from + way * u * u * u * (10.0 + u * (6.0 * u - 15.0));
        let shift_velocity = way / time * 30.0 * u * u * (1.0 - u) * (1.0 - u);
        let shift_acceleration = way / (time * time) * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u);
        let share = self.gear.link_share;
        let friction =
            (1.0 - share) * self.friction(target.velocity + shift_velocity) + share * self.friction(target.velocity);
        Feedforward { shift, shift_velocity, torque: friction + self.gear.rotor_inertia * shift_acceleration }
    }

    /// `σ b/2`, where the present crossing ends.
    fn end(&self) -> f64 {
        0.5 * self.gear.backlash * self.flank
    }

    /// The flank that passes the target's torque; the present one where both could.
    fn needed_flank(&self, target: &Target, rigid: f64) -> f64 {
        let share = self.gear.link_share;
        let resting = target.velocity == 0.0 && target.acceleration == 0.0;
        let [lowest, highest] = if resting {
            [-f64::MIN_POSITIVE, f64::MIN_POSITIVE].map(|velocity| rigid + share * (self.gear.friction)(velocity))
        } else {
            [rigid + share * self.friction(target.velocity); 2]
        };
        if lowest > 0.0 {
            1.0
        } else if highest < 0.0 {
            -1.0
        } else {
            self.flank
        }
    }

    /// `F(v)`, zero at rest.
    fn friction(&self, velocity: f64) -> f64 {
        if velocity == 0.0 { 0.0 } else { (self.gear.friction)(velocity) }
    }
}
