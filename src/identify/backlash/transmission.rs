//! Rotor, gap and link of one joint, stepped under a known motor torque. Joint side.
//!
//! ```text
//!   J v̇ = τ − T(x, ẋ) − (1 − s) F(v)         x = θ − q
//!   I ẇ = T(x, ẋ) − s F(w) − G(q) − K        T: the gearhead's flanks, b < 0 meaning that they are preloaded; F: its law
//! ```
//! `K` is the coupling to the other joints: what their accelerations, and all velocities, ask of this one.
//! Friction is set-valued: a motion that it can stop within a step ends at rest, and stays at rest until the torque exceeds breakaway.
//! In the gap and at rest a whole sample is one step; near and in contact it is [`CONTACT_STEPS`].

use crate::gearhead::{DeadZone, Direction, FrictionLaw, slowed};

/// Steps per sample in contact: the rotor's oscillation on the gear's stiffness advances by 0.1 rad per step at 400 rad/s and 1 ms.
pub(super) const CONTACT_STEPS: usize = 5;

/// What is known of a joint at one reversal.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Transmission {
    /// `J` [kg·m² or kg] rotor inertia at the joint.
    pub rotor_inertia: f64,
    /// `I` [kg·m² or kg] inertia of all that the joint moves, at this posture.
    pub link_inertia: f64,
    /// The flanks; their gap is the unknown.
    pub dead_zone: DeadZone,
    /// `F` friction of rotor and link together.
    pub friction: FrictionLaw,
    /// Friction at rest, `[positive, negative]` direction.
    pub breakaway: [f64; 2],
    /// `G` [N·m or N] gravity's torque at `origin`: what a motor needs to hold the link.
    pub gravity: f64,
    /// `dG/dq` [N·m/rad or N/m].
    pub gravity_slope: f64,
    /// [rad or m] position that `gravity` belongs to.
    pub origin: f64,
}

/// A guess at the state of rotor and link, with the friction that it assumes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Member {
    /// `θ` [rad or m] rotor.
    pub theta: f64,
    /// `v` [rad/s or m/s] rotor.
    pub v: f64,
    /// `q` [rad or m] link.
    pub q: f64,
    /// `w` [rad/s or m/s] link.
    pub w: f64,
    /// `s` [1] part of the friction that acts on the link.
    pub share: f64,
    /// [1] Factor on the friction law.
    pub level: f64,
    /// Flank that was in contact at first: +1 or −1.
    pub side: f64,
}

impl Transmission {
    /// `G(q)`.
    pub fn gravity_at(&self, q: f64) -> f64 {
        self.gravity + self.gravity_slope * (q - self.origin)
    }

    /// Steps a member by `dt` [s] under the motor torque `tau` and the coupling `K` to other joints [N·m or N], gap `b`.
    pub fn advance(&self, member: &mut Member, gap: f64, tau: f64, coupling: f64, dt: f64) {
        let gear = DeadZone { backlash: gap, ..self.dead_zone };
        let x = member.theta - member.q;
        let on_link = member.level * member.share;
        let on_rotor = member.level - on_link;
        let gravity = self.gravity_at(member.q) + coupling;
        if member.v == 0.0 && member.w == 0.0 {
            let torque = gear.of_flanks(x, 0.0);
            if self.holds(on_rotor, tau - torque) && self.holds(on_link, torque - gravity) {
                return;
            }
        }
        let reach = 2.0 * (member.v - member.w).abs() * dt + tau.abs() / self.rotor_inertia * dt * dt;
        let steps = if 0.5 * gap - x.abs() < reach { CONTACT_STEPS } else { 1 };
        let h = dt / steps as f64;
        let rotor = self.levels(member.v, on_rotor, reach / dt);
        let link = self.levels(member.w, on_link, reach / dt);
        // Change of velocity per torque in a step, computed once: two divisions instead of four in every step.
        let [of_rotor, of_link] = [h / self.rotor_inertia, h / self.link_inertia];
        for _ in 0..steps {
            let torque = gear.of_flanks(member.theta - member.q, member.v - member.w);
            let v = slowed(member.v + of_rotor * (tau - torque), rotor.map(|friction| of_rotor * friction));
            let w = slowed(member.w + of_link * (torque - gravity), link.map(|friction| of_link * friction));
            if steps == 1 {
                // Free flight under a constant torque: the mean velocity is exact.
                member.theta += 0.5 * h * (member.v + v);
                member.q += 0.5 * h * (member.w + w);
            } else {
                // On the spring: the new velocity keeps the oscillation's energy.
                member.theta += h * v;
                member.q += h * w;
            }
            (member.v, member.w) = (v, w);
        }
    }

    /// Whether friction at rest holds against a torque.
    fn holds(&self, factor: f64, tau: f64) -> bool {
        tau.abs() <= factor * self.breakaway[Direction::of(tau).index()]
    }

    /// Friction in either direction at a speed, `[positive, negative]`; zero in a direction that is more than `change` away.
    fn levels(&self, velocity: f64, factor: f64, change: f64) -> [f64; 2] {
        if velocity == 0.0 {
            return self.breakaway.map(|level| factor * level);
        }
        let at = |direction| factor * self.friction.magnitude(direction, velocity.abs());
        [
            if velocity < -change { 0.0 } else { at(Direction::Positive) },
            if velocity > change { 0.0 } else { at(Direction::Negative) },
        ]
    }
}
