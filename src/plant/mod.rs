//! The simulated machine: links in rapier's world, rotors, gears, drives and sensors in joint space.
//!
//! The only place that names rapier3d.
//!
//! ```text
//!   J θ̈ = K i + τ_e − T − F_r       M(q) q̈ + h(q, q̇) = T + τ_l − c q̇ − F_l       L di/dt = u − R i − K θ̇
//! ```
//! One line per joint: [`joint`] contains the laws, [`coupled`] combines them, [`machine`] adds the links, [`integrator`] steps
//! (`runge_kutta`) between located events (`events`), [`mobility`] gives `M` and `h` between their evaluations (`pace`, `accuracy`), [`world`] is the
//! engine that corrects them ([`links`]).
//! [`contact`] is what stops a link: an end stop, or an [`obstacle`] in rapier's world.
//! All of it on the joint side, SI; positive current, torque and motion have one direction.
//! Where motor axes are coupled, `θ = C q` ([`Coupling`](crate::robot::Coupling)), `q` denotes the output `C q` of an axis' gear, and
//! `M`, `h` are those in these coordinates ([`rigid_body`]): every law except those of a joint itself keeps its form.

mod accuracy;
mod altered;
mod build;
pub mod carried;
pub mod contact;
pub mod coupled;
mod events;
mod fastest;
mod first_model;
pub mod integrator;
pub mod joint;
pub mod links;
pub mod machine;
pub mod mobility;
pub mod mode;
pub mod obstacle;
mod pace;
pub mod rigid_body;
mod runge_kutta;
mod sensors;
pub mod state;
pub mod step;
pub mod tangent;
mod transient;
pub mod world;

pub use accuracy::Accuracy;
use accuracy::Lull;
use build::moving_mode;
pub use contact::Touch;
pub use first_model::first_model;
pub use integrator::Counts;
use integrator::Integrator;
use joint::{Phase, Power};
use machine::Machine;
use mode::Mode;
pub use obstacle::Obstacle;
pub use rigid_body::RigidBody;
use sensors::{Sensors, Tracker};
use state::State;
pub use world::World;

use crate::dynamics::Dynamics;
use crate::effects::{Catalogue, JointState, Reading};
use crate::error::{Error, Result};
use crate::gearhead::Slip;
use crate::robot::Robot;

/// Version of the rigid-body engine, as Cargo.toml pins it.
pub const RAPIER_VERSION: &str = "0.36.1";

/// [1/s] Most Runge-Kutta steps a second: anything faster, such as a contact of a nanosecond or a ripple that is passed ten million
/// times a second, is not a motion of a machine.
const FASTEST_STEPS: f64 = 1e8;

/// [rad/s or m/s] Highest plausible speed of a joint: 100 000 turns a minute behind the gear.
pub const FASTEST_MOTION: f64 = 1e4;

/// Who computes `M(q)` and `h(q, q̇)` of the links.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Engine {
    /// The multibody in rapier's world.
    #[default]
    Rapier,
    /// The project's own recursive algorithms.
    Reduced,
}

/// How often the links' engine is asked for `M` and `h`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Evaluations {
    /// Built-in algorithms at the end of every interval, corrected by their difference from rapier. Rapier is asked every 20 ms, and at
    /// every interval while the difference changes.
    #[default]
    AsNeeded,
    /// At the end of every interval.
    EveryInterval,
    /// At every stage of every Runge-Kutta step: slow; the reference for the other settings.
    EveryStage,
}

/// How a machine is simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The rigid-body engine.
    pub engine: Engine,
    /// [s] Longest interval between two evaluations of `M` and `h`, > 0.
    pub step: f64,
    /// Runge-Kutta steps in such an interval, ≥ 1; more are taken where the stiffest gear needs them.
    pub substeps: usize,
    /// How exact it is; [`Options::coarse`] takes fewer steps as well.
    pub accuracy: Accuracy,
    /// How often the engine is asked.
    pub evaluations: Evaluations,
    /// Seed of the encoders' phases and the sensors' noise.
    pub seed: u64,
    /// Whether all sensors are exact.
    pub ideal_sensors: bool,
    /// Runge-Kutta steps after which a simulation stops; the effort of locating events counts as well.
    pub most_steps: usize,
    /// What stands in the way; only [`Engine::Rapier`] supports it.
    pub obstacles: Vec<Obstacle>,
    /// Effects that a model may have.
    pub catalogue: Catalogue,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            engine: Engine::Rapier,
            step: 1e-3,
            substeps: 2,
            accuracy: Accuracy::Fine,
            evaluations: Evaluations::AsNeeded,
            seed: 1,
            ideal_sensors: false,
            most_steps: usize::MAX,
            obstacles: Vec::new(),
            catalogue: Catalogue::default(),
        }
    }
}

impl Options {
    /// Where an error of a hundredth of a degree is enough: one step in an interval, where the gears allow it.
    #[must_use]
    pub fn coarse() -> Self {
        Self { substeps: 1, accuracy: Accuracy::Coarse, ..Self::default() }
    }
}

/// Energy balance of a machine: `work = dissipated + stored − stored at the start`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// [J] done since the start by the motors and by effects' torques.
    pub work: f64,
    /// [J] turned into heat since the start by friction and dampers.
    pub dissipated: f64,
    /// [J] of motion, of the springs of gears and barriers, and of gravity.
    pub stored: f64,
}

/// A machine that moves.
pub struct Plant {
    integrator: Integrator,
    sensors: Vec<Sensors>,
    robot: Robot,
    step: f64,
    /// [1/s] Runge-Kutta steps a second.
    rate: f64,
    /// [rad/s] Fastest pole of a gear.
    fastest: f64,
    /// [rad/s² or m/s²] Largest error of an extrapolation that is right.
    no_surprise: f64,
    /// How long the links are not evaluated.
    lull: Lull,
    /// Whether the last extrapolation was right.
    calm: bool,
    every_stage: bool,
    /// [1/s] Highest rate of steps that an interval has needed since the machine was placed.
    asked: f64,
    state: State,
    saved: State,
    saved_trackers: Vec<Tracker>,
    commands: Vec<f64>,
    states: Vec<JointState>,
    readings: Vec<Reading>,
}

impl Plant {
    /// Puts everything to rest at these positions [rad or m] of the gears' outputs, which are those of the links or `C q` where axes are coupled;
    /// rotors in the middle of their gaps, time and work at zero.
    pub fn place(&mut self, positions: &[f64]) {
        let at_rest = |&q: &f64| Phase { theta: q, q, ..Phase::default() };
        self.start(0.0, positions.iter().map(at_rest).collect());
    }

    /// Puts rotors and links into this motion; currents as given, time and work at zero.
    pub fn launch(&mut self, states: &[JointState]) {
        self.launch_at(0.0, states);
    }

    /// As [`launch`](Self::launch), at a time [s] since the start: effects that depend on it go on from there.
    pub fn launch_at(&mut self, time: f64, states: &[JointState]) {
        let moving = |state: &JointState| Phase {
            theta: state.motor_position,
            omega: state.motor_velocity,
            q: state.link_position,
            v: state.link_velocity,
            current: state.current,
            memory: state.memory,
        };
        self.start(time, states.iter().map(moving).collect());
    }

    /// Moves rotor and link of a joint together, by a way [rad or m] and a velocity [rad/s or m/s]: what the gear transmits stays as it is.
    pub fn shift(&mut self, joint: usize, way: f64, velocity: f64) {
        let y = &mut self.state.joints[joint];
        y.theta += way;
        y.q += way;
        y.omega += velocity;
        y.v += velocity;
        let law = &self.integrator.machine.coupled.laws[joint];
        self.state.modes[joint] = moving_mode(law, self.state.time, y);
        let JointState { gear_torque, current, .. } = self.states[joint];
        self.states[joint] = law.observe(self.state.time, y, gear_torque, current);
    }

    fn start(&mut self, time: f64, joints: Vec<Phase>) {
        self.state.time = time;
        self.asked = 0.0;
        self.lull.stop();
        self.state.done = Power::default();
        self.commands.fill(0.0);
        for (i, y) in joints.iter().enumerate() {
            self.state.modes[i] = moving_mode(&self.integrator.machine.coupled.laws[i], time, y);
            self.sensors[i].restart(y);
        }
        self.state.joints = joints;
        let Self { integrator, state, .. } = self;
        integrator.machine.start(time, &state.joints);
        let Machine { coupled, links, .. } = &mut integrator.machine;
        coupled.barriers.start(links.engine.as_mut(), &state.joints, &mut state.touching);
        self.observe();
    }

    /// Present readings of the sensors, one per joint. Every call is a sampling instant: it draws noise and advances filters.
    pub fn read(&mut self) -> &[Reading] {
        for (i, sensors) in self.sensors.iter_mut().enumerate() {
            let joints = &self.state.joints;
            let q = self.robot.joint_of_axes(i, |axis| joints[axis].q);
            self.readings[i] = sensors.read(self.state.time, &joints[i], q, self.states[i].current);
        }
        &self.readings
    }

    /// Holds a command current [A], one per joint, for a duration [s]; nothing moves in a duration that is not positive.
    ///
    /// # Errors
    /// A command is not a number, the motion needs too many steps, or it has diverged: a velocity beyond [`FASTEST_MOTION`], or no number at all.
    /// Then the machine must be placed again.
    pub fn advance(&mut self, command_current: &[f64], duration: f64) -> Result<()> {
        for (i, law) in self.integrator.machine.coupled.laws.iter().enumerate() {
            self.commands[i] = law.command(command_current[i]);
            self.require(i, "command current", self.commands[i], f64::MAX)?;
        }
        let start = self.state.time;
        if duration > 0.0 && start + duration > start {
            let pieces = (duration / self.step - 1e-9).ceil().max(1.0);
            for piece in 1..=pieces as usize {
                let last = piece as f64 == pieces;
                self.advance_piece(if last { start + duration } else { start + duration * piece as f64 / pieces });
                self.require_motion()?;
            }
        }
        self.observe();
        Ok(())
    }

    /// [1/s] Runge-Kutta steps a second, at least, under commands that are held for a period [s].
    pub fn step_rate(&self, period: f64) -> f64 {
        let pieces = (period / self.step - 1e-9).ceil().max(1.0);
        self.rate.max(pieces / period)
    }

    /// Refuses a motion that has diverged, or cannot be followed.
    fn require_motion(&self) -> Result<()> {
        if self.asked > FASTEST_STEPS {
            let fastest = |a: &(usize, &Phase), b: &(usize, &Phase)| a.1.omega.abs().total_cmp(&b.1.omega.abs());
            let joint = self.state.joints.iter().enumerate().max_by(fastest).map_or(0, |(joint, _)| joint);
            return self.require(joint, "rate of steps that an effect or a contact needs", self.asked, FASTEST_STEPS);
        }
        let (steps, limit) = (self.integrator.counts().work(self.commands.len()), self.integrator.most_steps);
        if steps > limit {
            return Err(Error::TooManySteps { time: self.state.time, steps, limit });
        }
        for (i, y) in self.state.joints.iter().enumerate() {
            self.require(i, "motor velocity", y.omega, FASTEST_MOTION)?;
            self.require(i, "link velocity", y.v, FASTEST_MOTION)?;
            self.require(i, "motor position", y.theta, f64::MAX)?;
            self.require(i, "link position", y.q, f64::MAX)?;
            self.require(i, "current", y.current, f64::MAX)?;
        }
        Ok(())
    }

    fn require(&self, joint: usize, quantity: &'static str, value: f64, limit: f64) -> Result<()> {
        if value.abs() <= limit {
            return Ok(());
        }
        let joint = self.robot.bodies[joint].joint.name.clone();
        Err(Error::Diverged { time: self.state.time, joint, quantity, value, limit })
    }

    fn observe(&mut self) {
        self.integrator.machine.measure(&self.state.joints, &self.state.touching);
        let State { time, joints, modes, .. } = &self.state;
        for (i, law) in self.integrator.machine.coupled.laws.iter().enumerate() {
            let flow = law.flow(*time, &joints[i], &modes[i], self.commands[i]);
            self.states[i] = law.observe(*time, &joints[i], flow.gear_torque, flow.current);
        }
    }

    /// True states, one per joint.
    pub fn states(&self) -> &[JointState] {
        &self.states
    }

    /// Flank of a joint's gear that touches: +1, 0 in the gap, −1. A gear without a gap reports the direction of its torque.
    pub fn contact(&self, joint: usize) -> i8 {
        if self.integrator.machine.coupled.laws[joint].gearhead.dead_zone.backlash == 0.0 {
            let torque = self.states[joint].gear_torque;
            return if torque > 0.0 { 1 } else { -i8::from(torque < 0.0) };
        }
        self.state.modes[joint].contact
    }

    /// What links are pressed against now.
    pub fn touches(&self) -> impl Iterator<Item = Touch> + '_ {
        self.integrator.machine.coupled.barriers.touches(&self.state.touching)
    }

    /// Whether rotor and link of a joint are held by friction.
    pub fn sticks(&self, joint: usize) -> [bool; 2] {
        let Mode { rotor, link, .. } = self.state.modes[joint];
        [rotor == Slip::Stuck, link == Slip::Stuck]
    }

    /// [s] since the machine was placed.
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Computing effort since the machine was built.
    pub fn counts(&self) -> Counts {
        self.integrator.counts()
    }

    /// Work, heat and stored energy, to check their balance.
    pub fn energy(&self) -> Energy {
        let State { time, joints, modes, touching, done } = &self.state;
        let q: Vec<f64> = joints.iter().map(|y| y.q).collect();
        let v: Vec<f64> = joints.iter().map(|y| y.v).collect();
        let mut links = Dynamics::new(&self.robot);
        let mut stored = links.kinetic_energy(&q, &v) + links.potential_energy(&q);
        stored += self.integrator.machine.coupled.barriers.energy(touching);
        for (i, law) in self.integrator.machine.coupled.laws.iter().enumerate() {
            stored += 0.5 * law.rotor_inertia * joints[i].omega * joints[i].omega;
            stored += law.elastic_energy(*time, &joints[i], modes[i].contact);
            stored += law.gearhead.memory.map_or(0.0, |memory| memory.energy(joints[i].memory));
        }
        Energy { work: done.work, dissipated: done.dissipated, stored }
    }
}
