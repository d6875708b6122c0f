//! One joint between motor and link: drive and rotor, the laws of its [`Gearhead`], and what effects add.
//!
//! ```text
//!   J θ̈ = K i + τ_e − T − F_r          rotor; F_r, T, F_l: the gearhead's rotor side, touching flank and link side
//!   load = T + τ_l − c q̇ − F_l          on the link; c the URDF's damping
//! ```
//! Every law is smooth within a [`Mode`]; a margin that turns negative tells that a mode has ended.

use super::mode::{Change, Margins, Mode};
use crate::drive::PowerStage;
use crate::effects::{DriveAction, GearAction, JointAction, JointState};
use crate::gearhead::{Flank, Gearhead, Grip, Slip};

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
    /// State of the friction's memory, 0 if it has none.
    pub memory: f64,
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
            memory: self.memory + h * rate.memory,
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
    /// Gearhead; the URDF's `friction` is that of the link's bearing.
    pub gearhead: Gearhead,
    /// `c`: URDF `damping` of the link; 0 where axes are coupled ([`coupled`](super::coupled)).
    pub link_damping: f64,
    /// What effects add.
    pub actions: Vec<Box<dyn JointAction>>,
    /// What effects do to the gear's flanks.
    pub gears: Vec<Box<dyn GearAction>>,
    /// What effects do to the command.
    pub drives: Vec<Box<dyn DriveAction>>,
    /// Whether no effect acts on rotor, gear or link.
    pub plain: bool,
    /// Whether the axis moves its own joint alone; otherwise `q` is the gear's output `(C q)_i`, and these laws do not contain what acts
    /// on the joint.
    pub moves_joint: bool,
}

/// Results of a joint's own laws at an instant.
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
    /// Rate of the friction's memory.
    pub memory_rate: f64,
    /// Power, the link's friction included while it slips.
    pub power: Power,
}

impl JointLaws {
    /// Magnitude of the friction of a side that slips, at a speed; at speed 0, the most that friction holds against this slip.
    #[inline(always)]
    pub(super) fn friction(&self, grip: &Grip, state: &JointState, slip: Slip, speed: f64) -> f64 {
        let mut level = grip.level(slip, speed);
        if !self.plain && grip.share > 0.0 {
            level = self.altered(level, state, slip.sign() * speed.max(f64::MIN_POSITIVE));
        }
        grip.torque(level)
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
            memory: y.memory,
        }
    }

    /// A flank of the gear; the sign of `side` names it.
    fn flank(&self, time: f64, y: &Phase, side: f64) -> Flank {
        if self.gears.is_empty() {
            self.gearhead.dead_zone.flank(y.theta - y.q, y.omega - y.v, side)
        } else {
            self.mesh(time, y.theta).flank([y.theta, y.omega], [y.q, y.v], side)
        }
    }

    /// Distance of a flank from the change between contact and separation.
    pub(super) fn overlap(&self, time: f64, y: &Phase, side: f64) -> f64 {
        self.gearhead.dead_zone.overlap(&self.flank(time, y, side))
    }

    /// Contact that a state has: +1, 0, −1. A gear without a gap is always in contact.
    pub fn contact(&self, time: f64, y: &Phase) -> i8 {
        self.gearhead.dead_zone.touching(|side| self.flank(time, y, side))
    }

    /// The flank that a state in the gap is nearer to touching.
    pub fn nearer_flank(&self, time: f64, y: &Phase) -> i8 {
        if self.overlap(time, y, 1.0) >= self.overlap(time, y, -1.0) { 1 } else { -1 }
    }

    /// Elastic energy [J] of the gear.
    pub fn elastic_energy(&self, time: f64, y: &Phase, contact: i8) -> f64 {
        if contact == 0 {
            return 0.0;
        }
        self.gearhead.dead_zone.energy(&self.flank(time, y, f64::from(contact)))
    }

    /// Evaluates the laws within a mode.
    #[inline(always)]
    pub fn flow(&self, time: f64, y: &Phase, mode: &Mode, command: f64) -> Flow {
        let current = self.power.current(command, y.current, y.omega, mode.saturation);
        let x_dot = y.omega - y.v;
        let mut damper = 0.0;
        let mut gear_torque = 0.0;
        if mode.contact != 0 {
            let gear = &self.gearhead.dead_zone;
            damper = gear.damping * x_dot;
            gear_torque = gear.push(&gear.flank(y.theta - y.q, x_dot, f64::from(mode.contact)));
        }
        let motor_torque = self.power.torque_per_ampere * current;
        let mut flow = Flow {
            current,
            current_rate: self.power.rate(command, y.current, y.omega, mode.saturation),
            gear_torque,
            rotor_drive: motor_torque - gear_torque,
            rotor_acceleration: 0.0,
            link_load: gear_torque - self.link_damping * y.v,
            memory_rate: 0.0,
            power: Power { work: motor_torque * y.omega, dissipated: damper * x_dot + self.link_damping * y.v * y.v },
        };
        let mut state = JointState::default();
        if !self.plain {
            state = self.act(time, y, mode.contact, &mut flow);
        }
        if mode.rotor != Slip::Stuck {
            let s = mode.rotor.sign();
            let friction =
                if s == 0.0 { 0.0 } else { self.friction(&self.gearhead.rotor, &state, mode.rotor, s * y.omega) };
            flow.rotor_acceleration = (flow.rotor_drive - s * friction) / self.rotor_inertia;
            flow.power.dissipated += s * friction * y.omega;
        }
        let s = mode.link.sign();
        if s != 0.0 {
            let friction = self.friction(&self.gearhead.link, &state, mode.link, s * y.v);
            flow.link_load -= s * friction;
            flow.power.dissipated += s * friction * y.v;
        }
        flow
    }

    /// What a rotor at rest does under the torque that acts: it sticks, or slips in the direction of the torque.
    pub fn resting_rotor(&self, time: f64, y: &Phase, mode: &Mode, command: f64) -> Slip {
        let stuck = Mode { rotor: Slip::Stuck, ..*mode };
        let flow = self.flow(time, y, &stuck, command);
        let margin = self.margins(time, y, &stuck, command, &flow, 0.0).0[Change::Rotor as usize];
        if margin < 0.0 { Slip::towards(flow.rotor_drive) } else { Slip::Stuck }
    }

    /// How far the mode is from its end; `link_hold` is the friction that holds a link that sticks.
    #[inline]
    pub fn margins(&self, time: f64, y: &Phase, mode: &Mode, command: f64, flow: &Flow, link_hold: f64) -> Margins {
        let contact = if self.gearhead.dead_zone.backlash == 0.0 {
            f64::INFINITY
        } else if mode.contact == 0 {
            -self.overlap(time, y, 1.0).max(self.overlap(time, y, -1.0))
        } else {
            self.overlap(time, y, f64::from(mode.contact))
        };
        let state =
            if self.plain { JointState::default() } else { self.observe(time, y, flow.gear_torque, flow.current) };
        let side = |grip: &Grip, slip: Slip, velocity: f64, hold: f64| match slip {
            Slip::Free => f64::INFINITY,
            Slip::Stuck => self.friction(grip, &state, Slip::towards(hold), 0.0) - hold.abs(),
            slips => grip.margin(slips, slips.sign() * velocity),
        };
        let rotor = side(&self.gearhead.rotor, mode.rotor, y.omega, flow.rotor_drive);
        let link = side(&self.gearhead.link, mode.link, y.v, link_hold);
        let demand = self.power.demand(command, y.current, y.omega);
        let saturation = match mode.saturation {
            0 => self.power.voltage_limit - demand.abs(),
            s => f64::from(s) * demand - self.power.voltage_limit,
        };
        Margins([contact, rotor, link, saturation])
    }
}
