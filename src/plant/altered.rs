//! What effects do to the laws of a joint.
//!
//! A joint without effects never comes here: its laws are those of [`joint`](super::joint) alone.

use super::joint::{Flow, JointLaws, Phase};
use crate::effects::JointState;
use crate::gearhead::{Memory, Mesh};

impl JointLaws {
    /// Command [A] after the current limit and the effects on the drive.
    pub fn command(&self, command: f64) -> f64 {
        self.drives.iter().fold(self.power.clamp(command), |command, drive| drive.command(command))
    }

    /// Positions of the flanks of the gear.
    #[cold]
    pub(super) fn mesh(&self, time: f64, theta: f64) -> Mesh {
        let mut mesh = Mesh::with_gap(self.gearhead.dead_zone.backlash);
        self.gears.iter().for_each(|gear| gear.alter(time, theta, &mut mesh));
        mesh
    }

    /// Adds the effects on gear, rotor and link to `flow`; returns the state that the effects see.
    #[cold]
    pub(super) fn act(&self, time: f64, y: &Phase, contact: i8, flow: &mut Flow) -> JointState {
        if !self.gears.is_empty() && contact != 0 {
            self.mesh_anew(time, y, f64::from(contact), flow);
        }
        let state = self.observe(time, y, flow.gear_torque, flow.current);
        for action in &self.actions {
            let on_link = if self.moves_joint { action.link_torque(&state) } else { 0.0 };
            let on_rotor = action.motor_torque(&state);
            flow.rotor_drive += on_rotor;
            flow.link_load += on_link;
            flow.power.work += on_rotor * y.omega + on_link * y.v;
        }
        if let Some(memory) = &self.gearhead.memory {
            self.remember(memory, &state, flow);
        }
        state
    }

    /// Replaces the torque of a perfect gear by that of the mesh: `T` drives the link, `λ T` brakes the rotor.
    fn mesh_anew(&self, time: f64, y: &Phase, side: f64, flow: &mut Flow) {
        let x_dot = y.omega - y.v;
        let mesh = self.mesh(time, y.theta);
        let flank = mesh.flank([y.theta, y.omega], [y.q, y.v], side);
        let gear = &self.gearhead.dead_zone;
        let torque = gear.push(&flank);
        flow.rotor_drive += flow.gear_torque - mesh.lever(side) * torque;
        flow.link_load += torque - flow.gear_torque;
        flow.power.work += torque * mesh.offset_rate;
        flow.power.dissipated += gear.damping * (flank.p_dot * flank.p_dot - x_dot * x_dot);
        flow.gear_torque = torque;
    }

    /// Writes the rate of the friction's memory. Bristles are friction themselves: `F = σ0 z + σ1 ż + F_V v` brakes the rotor, and the
    /// part of `F v` that they do not store is heat.
    fn remember(&self, memory: &Memory, state: &JointState, flow: &mut Flow) {
        let (v, z) = (state.motor_velocity, state.memory);
        let (dry, viscous) = self.dry_and_viscous(state, v);
        flow.memory_rate = memory.rate(z, v, dry);
        if let Memory::Bristles { stiffness, .. } = *memory {
            // The rate is the change in a second.
            let friction = memory.force(z, flow.memory_rate, 1.0) + viscous * v;
            flow.rotor_drive -= friction;
            flow.power.dissipated += friction * v - stiffness * z * flow.memory_rate;
        }
    }

    /// `g` [N·m or N] and `F_V` [N·m·s/rad or N·s/m] of the rotor's friction at a velocity.
    fn dry_and_viscous(&self, state: &JointState, velocity: f64) -> (f64, f64) {
        let rotor = &self.gearhead.rotor;
        let slip = rotor.slip(velocity);
        let viscous = rotor.share * rotor.viscous(slip);
        let level = self.friction(rotor, state, slip, velocity.abs());
        ((level - viscous * velocity.abs()).max(f64::MIN_POSITIVE), viscous)
    }

    /// A level of friction after the effects. They read the direction from the sign of the velocities: those of the side that
    /// slips, or is about to slip.
    #[cold]
    pub(super) fn altered(&self, level: f64, state: &JointState, velocity: f64) -> f64 {
        let grown = self.gearhead.memory.map_or(0.0, |memory| memory.level(state.memory));
        let state = JointState { motor_velocity: velocity, link_velocity: velocity, ..*state };
        self.actions.iter().fold(level + grown, |level, action| action.dry_friction(&state, level))
    }

    /// Stiffness and damping of bristles, 0 without.
    pub(super) fn bristles(&self) -> (f64, f64) {
        match self.gearhead.memory {
            Some(Memory::Bristles { stiffness, damping }) => (stiffness, damping),
            _ => (0.0, 0.0),
        }
    }

    /// [1/s] Fastest rate that effects cause in an interval [s] from a state with this acceleration of the rotor, 0 without effects:
    /// decay of the friction's memory, ripples that are passed.
    #[inline]
    pub(super) fn haste(&self, y: &Phase, acceleration: f64, interval: f64) -> f64 {
        if self.plain { 0.0 } else { self.haste_at(y, y.omega.abs() + 2.0 * acceleration.abs() * interval) }
    }

    #[cold]
    fn haste_at(&self, y: &Phase, speed: f64) -> f64 {
        let state = self.observe(0.0, y, 0.0, 0.0);
        let forgets = self
            .gearhead
            .memory
            .map_or(0.0, |memory| memory.forgets(speed, self.dry_and_viscous(&state, speed.copysign(y.omega)).0));
        let ripples = self.actions.iter().map(|action| action.fastest(speed));
        ripples.chain(self.gears.iter().map(|gear| gear.fastest(speed))).fold(forgets, f64::max)
    }
}
