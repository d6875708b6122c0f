//! One joint between motor and link: rotor, gap, friction, drive, and what effects add.
//!
//! ```text
//!   J θ̈ = K i + τ_e − T − F_r          rotor, F_r the rotor's share of friction against θ̇
//!   T = k p + d ẋ on a touching flank   x = θ − q, p = x ∓ b/2; 0 in the gap
//!   load = T + τ_l − c q̇ − F_l          on the link, F_l its share against q̇ and the URDF's friction, c the URDF's damping
//! ```
//! Every law is smooth within a [`Mode`]; a margin that turns negative tells that a mode has ended.

use super::mode::{Margins, Mode, Slip};
use crate::drive::PowerStage;
use crate::effects::{JointAction, JointState};
use crate::gearhead::{DeadZone, Direction, Friction};

/// Rotor, link and current of a joint; its derivative has the same shape.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Phase {
    /// `θ` rotor.
    pub theta: f64,
    /// `θ̇`.
    pub omega: f64,
    /// `q` link.
    pub q: f64,
    /// `q̇`.
    pub v: f64,
    /// `i`.
    pub current: f64,
}

impl Phase {
    /// `self + h · rate`.
    pub fn step(&self, h: f64, rate: &Self) -> Self {
        Self {
            theta: self.theta + h * rate.theta,
            omega: self.omega + h * rate.omega,
            q: self.q + h * rate.q,
            v: self.v + h * rate.v,
            current: self.current + h * rate.current,
        }
    }
}

/// Power [W] that flows in a joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Power {
    /// Done by the motor and by what effects add, on rotor and link.
    pub work: f64,
    /// Turned into heat by friction and dampers.
    pub dissipated: f64,
}

/// The laws of a joint with their constants.
pub struct JointLaws {
    /// `J` [kg·m² or kg] rotor inertia at the joint.
    pub rotor_inertia: f64,
    /// Drive.
    pub power: PowerStage,
    /// Gear.
    pub gear: DeadZone,
    /// Friction and the shares of it on rotor and link.
    pub friction: Option<Friction>,
    /// URDF `friction` of the link.
    pub link_coulomb: f64,
    /// `c`: URDF `damping` of the link.
    pub link_damping: f64,
    /// What effects add.
    pub actions: Vec<Box<dyn JointAction>>,
}

/// What a joint's own laws say at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flow {
    /// Current that flows [A].
    pub current: f64,
    /// `di/dt` [A/s].
    pub current_rate: f64,
    /// `T`.
    pub gear_torque: f64,
    /// Net torque on the rotor without friction.
    pub rotor_drive: f64,
    /// `θ̈`.
    pub rotor_acceleration: f64,
    /// Torque on the link, kinetic friction included.
    pub link_load: f64,
    /// Power, the link's friction included while it slips.
    pub power: Power,
}

impl JointLaws {
    /// Whether friction acts on the rotor at all.
    pub fn rotor_has_friction(&self) -> bool {
        self.friction.map_or(!self.actions.is_empty(), |friction| friction.link_share < 1.0)
    }

    /// Whether friction acts on the link at all.
    pub fn link_has_friction(&self) -> bool {
        self.link_coulomb > 0.0 || self.friction.is_some_and(|friction| friction.link_share > 0.0)
    }

    /// Friction magnitude on the rotor at a speed in a direction; at speed 0 what holds it.
    pub fn rotor_friction(&self, state: &JointState, direction: Direction, speed: f64) -> f64 {
        let share = self.friction.map_or(1.0, |friction| 1.0 - friction.link_share);
        share * self.level(state, direction, speed)
    }

    /// Friction magnitude on the link at a speed in a direction; at speed 0 what holds it.
    pub fn link_friction(&self, state: &JointState, direction: Direction, speed: f64) -> f64 {
        let share = self.friction.map_or(0.0, |friction| friction.link_share);
        let own = if share > 0.0 { share * self.level(state, direction, speed) } else { 0.0 };
        own + self.link_coulomb
    }

    fn level(&self, state: &JointState, direction: Direction, speed: f64) -> f64 {
        let mut level = self.friction.map_or(0.0, |friction| friction.law.magnitude(direction, speed));
        if !self.actions.is_empty() {
            // An effect reads the direction from the sign of the velocities: of the side that slips, or is about to.
            let velocity = direction.sign() * speed.max(f64::MIN_POSITIVE);
            let state = JointState { motor_velocity: velocity, link_velocity: velocity, ..*state };
            for action in &self.actions {
                level = action.dry_friction(&state, level);
            }
        }
        level
    }

    /// The state as effects see it.
    pub fn observe(&self, time: f64, y: &Phase, gear_torque: f64, current: f64) -> JointState {
        JointState {
            time,
            motor_position: y.theta,
            motor_velocity: y.omega,
            link_position: y.q,
            link_velocity: y.v,
            gear_torque,
            current,
        }
    }

    /// Wind-up of the flank that touches, `(p, kp + dẋ)`; the sign of `side` names the flank.
    fn flank(&self, y: &Phase, side: f64) -> f64 {
        let compression = side * (y.theta - y.q) - 0.5 * self.gear.backlash;
        let rate = side * (y.omega - y.v);
        // Touching needs both: teeth that overlap, and a force that pushes.
        compression.min(compression + rate * self.gear.damping / self.gear.stiffness)
    }

    /// Contact that a state has: +1, 0, −1. A gear without a gap is always in contact.
    pub fn contact(&self, y: &Phase) -> i8 {
        if self.gear.backlash == 0.0 || self.flank(y, 1.0) > 0.0 {
            1
        } else if self.flank(y, -1.0) > 0.0 {
            -1
        } else {
            0
        }
    }

    /// The flank that a state in the gap is nearer to touching.
    pub fn nearer_flank(&self, y: &Phase) -> i8 {
        if self.flank(y, 1.0) >= self.flank(y, -1.0) { 1 } else { -1 }
    }

    /// Compression `p` of the touching flank, signed towards positive torque.
    pub fn compression(&self, y: &Phase, contact: i8) -> f64 {
        y.theta - y.q - 0.5 * f64::from(contact) * self.gear.backlash
    }

    /// Elastic energy [J] of the gear.
    pub fn elastic_energy(&self, y: &Phase, contact: i8) -> f64 {
        let p = self.compression(y, contact);
        if contact == 0 { 0.0 } else { 0.5 * self.gear.stiffness * p * p }
    }

    /// What the laws say within a mode.
    #[inline]
    pub fn flow(&self, time: f64, y: &Phase, mode: &Mode, command: f64) -> Flow {
        let current = self.power.current(command, y.current, y.omega, mode.saturation);
        let x_dot = y.omega - y.v;
        let mut damper = 0.0;
        let mut gear_torque = 0.0;
        if mode.contact != 0 {
            damper = self.gear.damping * x_dot;
            gear_torque = self.gear.stiffness * self.compression(y, mode.contact) + damper;
        }
        let motor_torque = self.power.torque_per_ampere * current;
        let mut rotor_drive = motor_torque - gear_torque;
        let mut link_load = gear_torque - self.link_damping * y.v;
        let mut power =
            Power { work: motor_torque * y.omega, dissipated: damper * x_dot + self.link_damping * y.v * y.v };
        let state = if self.actions.is_empty() {
            JointState::default()
        } else {
            let state = self.observe(time, y, gear_torque, current);
            for action in &self.actions {
                let (on_rotor, on_link) = (action.motor_torque(&state), action.link_torque(&state));
                rotor_drive += on_rotor;
                link_load += on_link;
                power.work += on_rotor * y.omega + on_link * y.v;
            }
            state
        };
        let mut rotor_acceleration = rotor_drive / self.rotor_inertia;
        if let Some(direction) = mode.rotor.direction() {
            let s = direction.sign();
            let friction = self.rotor_friction(&state, direction, s * y.omega);
            rotor_acceleration = (rotor_drive - s * friction) / self.rotor_inertia;
            power.dissipated += s * friction * y.omega;
        } else if mode.rotor == Slip::Stuck {
            rotor_acceleration = 0.0;
        }
        if let Some(direction) = mode.link.direction() {
            let s = direction.sign();
            let friction = self.link_friction(&state, direction, s * y.v);
            link_load -= s * friction;
            power.dissipated += s * friction * y.v;
        }
        Flow {
            current,
            current_rate: self.power.rate(command, y.current, y.omega, mode.saturation),
            gear_torque,
            rotor_drive,
            rotor_acceleration,
            link_load,
            power,
        }
    }

    /// How far the mode is from its end; `link_hold` is the friction that holds a link that sticks.
    pub fn margins(&self, time: f64, y: &Phase, mode: &Mode, command: f64, flow: &Flow, link_hold: f64) -> Margins {
        let contact = if self.gear.backlash == 0.0 {
            f64::INFINITY
        } else if mode.contact == 0 {
            -self.flank(y, 1.0).max(self.flank(y, -1.0))
        } else {
            self.flank(y, f64::from(mode.contact))
        };
        let state = if self.actions.is_empty() {
            JointState::default()
        } else {
            self.observe(time, y, flow.gear_torque, flow.current)
        };
        let rotor = mode.rotor.margin(y.omega, flow.rotor_drive, |d| self.rotor_friction(&state, d, 0.0));
        let link = mode.link.margin(y.v, link_hold, |d| self.link_friction(&state, d, 0.0));
        let demand = self.power.demand(command, y.current, y.omega);
        let saturation = match mode.saturation {
            0 => self.power.voltage_limit - demand.abs(),
            s => f64::from(s) * demand - self.power.voltage_limit,
        };
        Margins([contact, rotor, link, saturation])
    }
}
