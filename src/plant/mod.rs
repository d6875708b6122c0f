//! The simulated machine: links in rapier's world, rotors, gears, drives and sensors in joint space.
//!
//! The only place that names rapier3d.
//!
//! ```text
//!   J θ̈ = K i + τ_e − T − F_r       M(q) q̈ + h(q, q̇) = T + τ_l − c q̇ − F_l       L di/dt = u − R i − K θ̇
//! ```
//! One line a joint: [`joint`] holds the laws, [`coupled`] joins them, [`integrator`] steps between located events,
//! [`mobility`] carries `M` and `h` from one evaluation of the engine to the next, [`world`] is the engine.
//! All of it on the joint side, SI; positive current, torque and motion have one direction.

pub mod coupled;
pub mod integrator;
pub mod joint;
pub mod mobility;
pub mod mode;
pub mod rigid_body;
mod sensors;
pub mod world;

use coupled::Coupled;
use integrator::{Integrator, Source, State, Step};
use joint::{JointLaws, Phase, Power};
use mobility::Surprise;
use mode::{Mode, Slip};
pub use rigid_body::RigidBody;
use sensors::{Sensors, Tracker};
pub use world::World;

use crate::drive::PowerStage;
use crate::dynamics::Dynamics;
use crate::effects::{self, Action, JointState, Reading};
use crate::error::{Error, Place, Result};
use crate::gearhead::DeadZone;
use crate::robot::{JointModel, Model, Robot};

/// Version of the rigid-body engine, as Cargo.toml pins it.
pub const RAPIER_VERSION: &str = "0.36.1";

/// Who computes `M(q)` and `h(q, q̇)` of the links.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Engine {
    /// The multibody in rapier's world.
    #[default]
    Rapier,
    /// The project's own recursive algorithms.
    Reduced,
}

/// How a machine is simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The rigid-body engine.
    pub engine: Engine,
    /// [s] Longest interval between two evaluations of `M` and `h`, > 0.
    pub step: f64,
    /// Runge-Kutta steps in such an interval, ≥ 1; more are taken where the stiffest gear asks for them.
    pub substeps: usize,
    /// Whether `M` and `h` are evaluated at every stage of every Runge-Kutta step instead: slow, and what the rest is measured by.
    pub every_stage: bool,
    /// Seed of the encoders' phases and the sensors' noise.
    pub seed: u64,
    /// Whether all sensors are exact.
    pub ideal_sensors: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { engine: Engine::Rapier, step: 1e-3, substeps: 3, every_stage: false, seed: 1, ideal_sensors: false }
    }
}

/// Where the energy of a machine is and went. `work = dissipated + stored − stored at the start`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// [J] done since the start by the motors and by effects' torques.
    pub work: f64,
    /// [J] turned into heat since the start by friction and dampers.
    pub dissipated: f64,
    /// [J] of motion, of the gears' springs and of gravity.
    pub stored: f64,
}

/// Longest step times the fastest pole of a gear: Runge-Kutta 4 then loses `(ωh)⁵/120 = 4e-5` of an oscillation a step.
const LONGEST_STEP: f64 = 0.35;

/// Longest step times the fastest pole where only stability counts.
const STABLE_STEP: f64 = 1.0;

/// An extrapolation that is right: 1e-5 rad/s² at the end of a millisecond are 2e-9 rad/s of velocity.
const NO_SURPRISE: Surprise = Surprise { mobility: 1e-7, acceleration: 1e-5 };

/// An extrapolation after which the interpolation is right: its error is 24 times smaller.
const SOME_SURPRISE: Surprise = Surprise { mobility: 1e-4, acceleration: 1e-1 };

/// [rad/s] Fastest motion of a gear that is simulated: 3 µs a step.
const FASTEST: f64 = 1e5;

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
    /// Whether the last extrapolation was right.
    calm: bool,
    every_stage: bool,
    state: State,
    saved: State,
    saved_trackers: Vec<Tracker>,
    commands: Vec<f64>,
    states: Vec<JointState>,
    readings: Vec<Reading>,
}

impl Plant {
    /// Builds the machine of a model, with its effects installed, at rest at zero.
    ///
    /// # Errors
    /// An effect is unknown or its parameters do not fit.
    pub fn new(model: &Model, options: &Options) -> Result<Self> {
        let mut model = model.clone();
        let actions = install(&mut model)?;
        let mut laws: Vec<JointLaws> =
            model.joints.iter().zip(&model.robot.bodies).map(|(joint, body)| laws_of(joint, &body.joint)).collect();
        let mut sensors: Vec<Sensors> = (model.joints.iter().enumerate())
            .map(|(i, joint)| Sensors::new(joint, options.ideal_sensors, options.seed, i as u64))
            .collect();
        for action in actions {
            match action {
                Action::Joint(joint, action) => laws[joint].actions.push(action),
                Action::Sensor(joint, action) => sensors[joint].push(action),
            }
        }
        let links: Box<dyn RigidBody> = match options.engine {
            Engine::Rapier => Box::new(World::new(&model.robot)),
            Engine::Reduced => Box::new(Dynamics::new(&model.robot)),
        };
        let n = laws.len();
        let state = State {
            time: 0.0,
            joints: vec![Phase::default(); n],
            modes: laws.iter().map(resting_mode).collect(),
            done: Power::default(),
        };
        let mut plant = Self {
            integrator: Integrator::new(Coupled::new(laws), links),
            robot: model.robot.clone(),
            step: options.step,
            rate: 0.0,
            fastest: 0.0,
            calm: false,
            every_stage: options.every_stage,
            saved: state.clone(),
            saved_trackers: sensors.iter().map(|sensors| sensors.tracker).collect(),
            sensors,
            state,
            commands: vec![0.0; n],
            states: vec![JointState::default(); n],
            readings: vec![Reading::default(); n],
        };
        plant.place(&vec![0.0; n]);
        let (joint, fastest) = plant.integrator.fastest();
        if !fastest.is_finite() || fastest > FASTEST {
            let key = format!("joints.{}.gear_stiffness", model.joints[joint].name);
            let expected = format!(
                "a gear between rotor and link whose fastest motion is below {FASTEST:.0} rad/s, with inertia on both sides \
                 (here {fastest:.3e} rad/s)"
            );
            return Err(Error::input(&model.source, Place::File, key, model.joints[joint].gear_stiffness, expected));
        }
        let asked = options.substeps.max(1) as f64 / options.step;
        plant.fastest = fastest;
        plant.rate = asked.max(fastest / LONGEST_STEP);
        Ok(plant)
    }

    /// Puts everything to rest at these link positions [rad or m], rotors in the middle of their gaps, time and work at zero.
    pub fn place(&mut self, positions: &[f64]) {
        let at_rest = |&q: &f64| Phase { theta: q, q, ..Phase::default() };
        self.start(positions.iter().map(at_rest).collect());
    }

    /// Puts rotors and links into this motion; currents as given, time and work at zero.
    pub fn launch(&mut self, states: &[JointState]) {
        let moving = |state: &JointState| Phase {
            theta: state.motor_position,
            omega: state.motor_velocity,
            q: state.link_position,
            v: state.link_velocity,
            current: state.current,
        };
        self.start(states.iter().map(moving).collect());
    }

    fn start(&mut self, joints: Vec<Phase>) {
        self.state.time = 0.0;
        self.state.done = Power::default();
        self.commands.fill(0.0);
        for (i, y) in joints.iter().enumerate() {
            let law = &self.integrator.coupled.laws[i];
            let towards = |velocity: f64| if velocity == 0.0 { Slip::Stuck } else { Slip::towards(velocity) };
            let mode = &mut self.state.modes[i];
            *mode = resting_mode(law);
            mode.contact = law.contact(y);
            if mode.rotor != Slip::Free {
                mode.rotor = towards(y.omega);
            }
            if mode.link != Slip::Free {
                mode.link = towards(y.v);
            }
            self.sensors[i].restart(y);
        }
        self.state.joints = joints;
        self.integrator.mobility.clear();
        self.integrator.push_node(0.0, &self.state.joints);
        self.observe();
    }

    /// What the sensors say now, one a joint. Every call is a sampling instant: it draws noise and advances filters.
    pub fn read(&mut self) -> &[Reading] {
        for (i, sensors) in self.sensors.iter_mut().enumerate() {
            self.readings[i] = sensors.read(self.state.time, &self.state.joints[i], self.states[i].current);
        }
        &self.readings
    }

    /// Holds a command current [A], one a joint, for a duration [s].
    pub fn advance(&mut self, command_current: &[f64], duration: f64) {
        for (i, law) in self.integrator.coupled.laws.iter().enumerate() {
            self.commands[i] = law.power.clamp(command_current[i]);
        }
        let start = self.state.time;
        let pieces = (duration / self.step - 1e-9).ceil().max(1.0);
        for piece in 1..=pieces as usize {
            let until =
                if piece as f64 == pieces { start + duration } else { start + duration * piece as f64 / pieces };
            self.advance_piece(until);
        }
        self.observe();
    }

    /// One interval between evaluations, the cheapest way that holds: under the extrapolated response if it turns out right;
    /// else again under the response interpolated with what the engine said at its end; else with the engine at every stage.
    fn advance_piece(&mut self, until: f64) {
        if self.every_stage || !self.integrator.mobility.is_full() {
            self.go_through(until, Source::Engine);
            self.integrator.push_node(until, &self.state.joints);
            return;
        }
        let surprise = if self.calm { self.try_out(until) } else { self.look_ahead(until) };
        let done = self.calm && surprise.within(&NO_SURPRISE);
        self.calm = surprise.within(&NO_SURPRISE);
        if done {
            self.integrator.mobility.accept(until);
        } else if surprise.within(&SOME_SURPRISE) {
            self.integrator.mobility.accept(until);
            self.go_through(until, Source::Polynomial);
        } else {
            self.go_through(until, Source::Engine);
            self.integrator.push_node(until, &self.state.joints);
        }
    }

    /// Goes through an interval in full; where that turns out to be wrong, everything is as before.
    fn try_out(&mut self, until: f64) -> Surprise {
        self.saved.copy_from(&self.state);
        self.saved_trackers.iter_mut().zip(&self.sensors).for_each(|(saved, sensors)| *saved = sensors.tracker);
        self.go_through(until, Source::Polynomial);
        let surprise = self.integrator.offer_node(until, &self.state.joints);
        if !surprise.within(&NO_SURPRISE) {
            self.state.copy_from(&self.saved);
            self.sensors.iter_mut().zip(&self.saved_trackers).for_each(|(sensors, saved)| sensors.tracker = *saved);
        }
        surprise
    }

    /// Looks at the end of an interval in the fewest steps that are stable.
    fn look_ahead(&mut self, until: f64) -> Surprise {
        let Self { integrator, state, saved, commands, fastest, .. } = self;
        let steps = ((until - state.time) * *fastest / STABLE_STEP).ceil().max(1.0) as usize;
        saved.copy_from(state);
        integrator.settle(saved, commands, Source::Polynomial);
        integrator.advance(saved, commands, until, steps, Source::Polynomial, |_| {});
        integrator.offer_node(until, &saved.joints)
    }

    fn go_through(&mut self, until: f64, source: Source) {
        let Self { integrator, sensors, state, commands, rate, .. } = self;
        let steps = ((until - state.time) * *rate - 1e-6).ceil().max(1.0) as usize;
        integrator.settle(state, commands, source);
        integrator.advance(state, commands, until, steps, source, |step: &Step| {
            for (i, sensors) in sensors.iter_mut().enumerate() {
                sensors.watch(step.time, &step.joints[0][i], &step.joints[1][i]);
            }
        });
    }

    fn observe(&mut self) {
        let State { time, joints, modes, .. } = &self.state;
        for (i, law) in self.integrator.coupled.laws.iter().enumerate() {
            let flow = law.flow(*time, &joints[i], &modes[i], self.commands[i]);
            self.states[i] = law.observe(*time, &joints[i], flow.gear_torque, flow.current);
        }
    }

    /// True states, one a joint.
    pub fn states(&self) -> &[JointState] {
        &self.states
    }

    /// Flank of a joint's gear that touches: +1, 0 in the gap, −1. A gear without a gap reports the direction of its torque.
    pub fn contact(&self, joint: usize) -> i8 {
        if self.integrator.coupled.laws[joint].gear.backlash == 0.0 {
            let torque = self.states[joint].gear_torque;
            return if torque > 0.0 { 1 } else { -i8::from(torque < 0.0) };
        }
        self.state.modes[joint].contact
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

    /// Work, heat and what is stored, for the audit.
    pub fn energy(&self) -> Energy {
        let State { joints, modes, done, .. } = &self.state;
        let q: Vec<f64> = joints.iter().map(|y| y.q).collect();
        let v: Vec<f64> = joints.iter().map(|y| y.v).collect();
        let mut links = Dynamics::new(&self.robot);
        let mut stored = links.kinetic_energy(&q, &v) + links.potential_energy(&q);
        for (i, law) in self.integrator.coupled.laws.iter().enumerate() {
            stored += 0.5 * law.rotor_inertia * joints[i].omega * joints[i].omega;
            stored += law.elastic_energy(&joints[i], modes[i].contact);
        }
        Energy { work: done.work, dissipated: done.dissipated, stored }
    }
}

fn install(model: &mut Model) -> Result<Vec<Action>> {
    let mut actions = Vec::new();
    for entry in model.effects.clone() {
        let unknown = |key: &str, value: &str, expected: &str| {
            Error::input(&model.source, Place::File, format!("effects.{key}"), value, expected)
        };
        let effect = effects::find(&entry.effect)
            .ok_or_else(|| unknown("effect", &entry.effect, "a name of the catalogue (`lostmotion list effects`)"))?;
        let joint = match &entry.joint {
            Some(name) => Some(
                (model.joints.iter().position(|joint| &joint.name == name))
                    .ok_or_else(|| unknown("joint", name, "a joint that the model lists"))?,
            ),
            None => None,
        };
        actions.extend(effect.install(model, joint, &entry.parameters)?);
    }
    Ok(actions)
}

fn laws_of(joint: &JointModel, link: &crate::robot::Joint) -> JointLaws {
    JointLaws {
        rotor_inertia: joint.reflected_inertia(),
        power: PowerStage::new(&joint.motor, &joint.amplifier, joint.torque_per_ampere()),
        gear: DeadZone {
            backlash: joint.backlash.unwrap_or(0.0),
            stiffness: joint.gear_stiffness,
            damping: joint.gear_damping,
        },
        friction: joint.friction,
        link_coulomb: link.friction,
        link_damping: link.damping,
        actions: Vec::new(),
    }
}

fn resting_mode(law: &JointLaws) -> Mode {
    let slip = |has_friction: bool| if has_friction { Slip::Stuck } else { Slip::Free };
    Mode {
        contact: i8::from(law.gear.backlash == 0.0),
        rotor: slip(law.rotor_has_friction()),
        link: slip(law.link_has_friction()),
        saturation: 0,
    }
}
