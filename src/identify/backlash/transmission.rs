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

/// Members whose steps in contact are taken side by side.
const LANES: usize = 4;

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

impl Member {
    /// Factors on the friction law of rotor and link.
    fn factors(&self) -> [f64; 2] {
        let on_link = self.level * self.share;
        [self.level - on_link, on_link]
    }
}

/// What stays the same in the steps of a member within a sample.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    /// [s]
    h: f64,
    /// [N·m or N] of the motor.
    tau: f64,
    /// [N·m or N] that the link needs from the gear, beside its friction.
    gravity: f64,
    /// Change of the rotor's velocity per torque.
    of_rotor: f64,
    /// Change of the link's velocity per torque.
    of_link: f64,
    /// Loss of the rotor's velocity by friction, `[positive, negative]`.
    rotor: [f64; 2],
    /// Loss of the link's velocity.
    link: [f64; 2],
}

impl Step {
    /// Velocities of rotor and link after a step under a torque of the gear.
    #[inline(always)]
    fn velocities(&self, v: f64, w: f64, torque: f64) -> [f64; 2] {
        [
            slowed(v + self.of_rotor * (self.tau - torque), self.rotor),
            slowed(w + self.of_link * (torque - self.gravity), self.link),
        ]
    }

    /// Free flight under a constant torque: the mean velocity is exact.
    fn fly(&self, member: &mut Member, torque: f64) {
        let [v, w] = self.velocities(member.v, member.w, torque);
        member.theta += 0.5 * self.h * (member.v + v);
        member.q += 0.5 * self.h * (member.w + w);
        (member.v, member.w) = (v, w);
    }
}

/// Steps members through a sample on the spring: the new velocity keeps the oscillation's energy. The steps of one member wait for each other, those
/// of several do not.
fn press<const N: usize>(members: &mut [Member], gear: &DeadZone, pressed: &[(usize, Step); N]) {
    let mut theta = pressed.map(|(k, _)| members[k].theta);
    let mut q = pressed.map(|(k, _)| members[k].q);
    let mut v = pressed.map(|(k, _)| members[k].v);
    let mut w = pressed.map(|(k, _)| members[k].w);
    for _ in 0..CONTACT_STEPS {
        for (i, (_, step)) in pressed.iter().enumerate() {
            let torque = gear.of_flanks(theta[i] - q[i], v[i] - w[i]);
            [v[i], w[i]] = step.velocities(v[i], w[i], torque);
            theta[i] += step.h * v[i];
            q[i] += step.h * w[i];
        }
    }
    for (i, (k, _)) in pressed.iter().enumerate() {
        let member = &mut members[*k];
        (member.theta, member.q, member.v, member.w) = (theta[i], q[i], v[i], w[i]);
    }
}

impl Transmission {
    /// `G(q)`.
    pub fn gravity_at(&self, q: f64) -> f64 {
        self.gravity + self.gravity_slope * (q - self.origin)
    }

    /// Steps members by `dt` [s], each under its motor torque, all under the coupling `K` to other joints [N·m or N], gap `b`.
    pub fn advance(&self, members: &mut [Member], gap: f64, torques: &[f64], coupling: f64, dt: f64) {
        let gear = DeadZone { backlash: gap, ..self.dead_zone };
        let mut pressed = [(0, Step::default()); LANES];
        let mut waiting = 0;
        for k in 0..members.len() {
            let (member, tau) = (&mut members[k], torques[k]);
            let x = member.theta - member.q;
            let gravity = self.gravity_at(member.q) + coupling;
            if self.rests(member, tau, || gear.of_flanks(x, 0.0), gravity) {
                continue;
            }
            let reach = self.reach(member, tau, dt);
            if 0.5 * gap - x.abs() >= reach {
                let torque = gear.of_flanks(x, member.v - member.w);
                self.step_of(member, tau, gravity, dt, reach / dt).fly(member, torque);
                continue;
            }
            pressed[waiting] = (k, self.step_of(member, tau, gravity, dt / CONTACT_STEPS as f64, reach / dt));
            waiting += 1;
            if waiting == LANES {
                press(members, &gear, &pressed);
                waiting = 0;
            }
        }
        for one in &pressed[..waiting] {
            press(members, &gear, &[*one]);
        }
    }

    /// Bound of what a rotor moves by against its link within `dt` [s], on either side of which there is no flank [rad or m].
    pub fn reach(&self, member: &Member, tau: f64, dt: f64) -> f64 {
        2.0 * (member.v - member.w).abs() * dt + tau.abs() / self.rotor_inertia * dt * dt
    }

    /// Whether rotor and link are at rest, and friction holds both against the motor, the gear and gravity.
    fn rests(&self, member: &Member, tau: f64, torque: impl Fn() -> f64, gravity: f64) -> bool {
        if member.v != 0.0 || member.w != 0.0 {
            return false;
        }
        let [on_rotor, on_link] = member.factors();
        let torque = torque();
        self.holds(on_rotor, tau - torque) && self.holds(on_link, torque - gravity)
    }

    /// What stays the same in steps of `h` [s] of a member, whose speeds change by at most `change`.
    fn step_of(&self, member: &Member, tau: f64, gravity: f64, h: f64, change: f64) -> Step {
        // Change of velocity per torque in a step, computed once: two divisions instead of four in every step.
        let [of_rotor, of_link] = [h / self.rotor_inertia, h / self.link_inertia];
        let [on_rotor, on_link] = member.factors();
        let rotor = self.levels(member.v, on_rotor, change).map(|friction| of_rotor * friction);
        let link = self.levels(member.w, on_link, change).map(|friction| of_link * friction);
        Step { h, tau, gravity, of_rotor, of_link, rotor, link }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gearhead::Exponential;

    /// Seven members, more than go side by side: in the gap, on either flank, and at rest. Together they move as each alone does, to the bit: a
    /// likelihood does not depend on which members are in contact at the same time.
    #[test]
    fn property_members_together_move_as_each_alone() {
        let law = Exponential { coulomb: 0.4, breakaway: 0.6, stribeck_velocity: 0.05, viscous: 0.3 };
        let machine = Transmission {
            rotor_inertia: 0.5,
            link_inertia: 1.5,
            dead_zone: DeadZone { backlash: 0.0, stiffness: 3000.0, damping: 6.0 },
            friction: FrictionLaw::Exponential([law; 2]),
            breakaway: [0.6; 2],
            gravity: 0.1,
            gravity_slope: 0.2,
            origin: 0.0,
        };
        let gap = 8e-3;
        let member = |theta: f64, v: f64, w: f64| {
            let side = if theta < 0.0 { -1.0 } else { 1.0 };
            Member { theta, v, q: 0.0, w, share: 0.3, level: 1.0 + theta, side }
        };
        let start = [
            member(4.1e-3, 0.2, 0.2),
            member(0.0, 0.1, -0.1),
            member(-4.2e-3, -0.3, -0.29),
            member(0.0, 0.0, 0.0),
            member(4.05e-3, -0.02, 0.01),
            member(3.9e-3, 0.4, 0.0),
            member(-4.0e-3, 0.01, 0.02),
        ];
        let torques = [1.0, -0.5, -2.0, 0.1, 0.3, 1.5, 0.2];
        let (mut together, mut alone) = (start, start);
        for _ in 0..50 {
            machine.advance(&mut together, gap, &torques, 0.05, 1e-3);
            for (member, torque) in alone.iter_mut().zip(&torques) {
                machine.advance(std::slice::from_mut(member), gap, &[*torque], 0.05, 1e-3);
            }
        }
        assert_eq!(together, alone);
        assert_eq!(together[3], start[3], "held by friction");
        assert!(together.iter().zip(&start).filter(|(now, before)| now.theta != before.theta).count() == 6);
    }
}
