//! An independent machine for the tests of the identification: one joint with rotor, gap and link in fine steps, its own controller and
//! sensors. Shares no code with the crate's plant, drive or control: only the friction law's parameters.

use std::collections::BTreeMap;

use lostmotion::drive::{Amplifier, CurrentSensor, Encoder, Motor, Sensing, VelocitySensor};
use lostmotion::gearhead::{Direction, Friction, FrictionLaw};
use lostmotion::robot::{Body, Inertia, Joint, JointModel, Limits, Model, Robot};
use lostmotion::timeseries::{Channel, JointSeries, Samples, TimeSeries};
use lostmotion::units::{DEG, JointKind};
use nalgebra::{Isometry3, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// One joint of the generator.
#[derive(Debug, Clone)]
pub struct Machine {
    /// Motor turns per joint turn.
    pub ratio: f64,
    /// [kg·m²] rotor on the joint side.
    pub rotor: f64,
    /// [kg·m²] link about the axis.
    pub link: f64,
    /// [N·m] gravity torque amplitude, `m g l`, at q = 0 where the link is level; 0 for a vertical axis.
    pub gravity: f64,
    /// [rad] total gap.
    pub gap: f64,
    /// Friction of the joint.
    pub friction: Friction,
    /// Absolute or signed current sensing.
    pub sensing: Sensing,
    /// [N·m·s/rad] velocity gain.
    pub velocity_gain: f64,
    /// [1/s] position gain over velocity gain.
    pub position_rate: f64,
}

const TORQUE_CONSTANT: f64 = 0.023;
const COUNTS: f64 = 2000.0;
const NOISE: f64 = 0.030;
const RESOLUTION: f64 = 0.0098;
const STIFFNESS: f64 = 3000.0;
const DAMPING: f64 = 2.0;
/// [s] physics and sampling steps.
const STEP: f64 = 2e-5;
const SAMPLE: f64 = 1e-3;

impl Machine {
    /// What the identification is told: everything but friction and gap.
    pub fn nominal(&self) -> Model {
        let length = 0.2;
        let mass = self.gravity / 9.81 / length;
        let (mass, spin) =
            if self.gravity > 0.0 { (mass, self.link - mass * length * length) } else { (1.0, self.link) };
        let com = if self.gravity > 0.0 { Vector3::new(length, 0.0, 0.0) } else { Vector3::zeros() };
        let limits = Limits { lower: -3.0, upper: 3.0, effort: f64::INFINITY, velocity: f64::INFINITY };
        let (origin, axis) = (Isometry3::identity(), Vector3::z_axis());
        let name = "joint".to_owned();
        let joint =
            Joint { name: name.clone(), kind: JointKind::Revolute, origin, axis, limits, damping: 0.0, friction: 0.0 };
        let inertia = Inertia { mass, com, tensor: Matrix3::identity() * spin };
        let body = Body { name: "link".to_owned(), parent: None, joint, inertia, shapes: Vec::new() };
        let robot = Robot {
            name: "test".to_owned(),
            gravity: Vector3::new(0.0, -9.81, 0.0),
            drawn: Vec::new(),
            base_shapes: Vec::new(),
            unread_shapes: Vec::new(),
            bodies: vec![body],
            coupling: None,
        };
        let joint = JointModel {
            torque_at: lostmotion::robot::TorqueAt::Motor,
            constant_accuracy: None,
            name,
            kind: JointKind::Revolute,
            gear_ratio: self.ratio,
            rotor_inertia: Some(self.rotor / (self.ratio * self.ratio)),
            gear_stiffness: Some(STIFFNESS),
            gear_damping: Some(DAMPING),
            end_stop_stiffness: None,
            backlash: None,
            motor: Some(Motor { torque_constant: TORQUE_CONSTANT, resistance: None, inductance: None }),
            amplifier: Amplifier { voltage_limit: 24.0, current_limit: 18.0, current_time_constant: 4e-4 },
            encoder: Some(Encoder { counts_per_turn: COUNTS }),
            link_encoder: None,
            velocity_sensor: Some(VelocitySensor::PulsePeriod),
            current_sensor: Some(CurrentSensor { noise: NOISE, resolution: RESOLUTION, sensing: self.sensing }),
            friction: None,
        };
        Model {
            name: "test".to_owned(),
            source: Default::default(),
            urdf_text: String::new(),
            urdf: Default::default(),
            robot,
            joints: vec![joint],
            held: Vec::new(),
            remarks: Vec::new(),
            masses: lostmotion::robot::Masses::Known,
            accuracy: lostmotion::robot::Accuracy::EXACT,
            effects: Vec::new(),
            loads: Vec::new(),
            places: lostmotion::toml_input::Places::default(),
        }
    }

    /// The model that holds the truth.
    pub fn truth(&self) -> Model {
        let mut model = self.nominal();
        model.joints[0].friction = Some(self.friction);
        model.joints[0].backlash = Some(self.gap);
        model
    }

    /// The staircase of the paper's Figure 2: `steps` speeds of `increment` [rad/s] in both directions.
    pub fn staircase(&self, steps: usize, increment: f64, seed: u64) -> TimeSeries {
        let mut run = Run::new(self, seed);
        for step in 1..=steps {
            for sign in [1.0, -1.0] {
                let speed = step as f64 * increment;
                let cruise = (3.0 * DEG / speed).clamp(1.5, 6.0);
                run.stroke(sign * speed, cruise, speed / (20.0 * DEG));
            }
        }
        run.into_series()
    }
}

/// State and record of a run.
struct Run<'a> {
    machine: &'a Machine,
    random: ChaCha8Rng,
    time: f64,
    rotor: [f64; 2],
    link: [f64; 2],
    current: f64,
    reference: f64,
    last_edges: [f64; 2],
    directions: [f64; 2],
    count: f64,
    first: f64,
    channels: BTreeMap<Channel, Samples>,
    times: Vec<f64>,
}

impl<'a> Run<'a> {
    fn new(machine: &'a Machine, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let quantum = 2.0 * std::f64::consts::PI / COUNTS / machine.ratio;
        let start = random.random::<f64>() * quantum;
        let count = (start / quantum).floor();
        Self {
            machine,
            random,
            time: 0.0,
            rotor: [start, 0.0],
            link: [start - 0.5 * machine.gap, 0.0],
            current: 0.0,
            reference: count * quantum,
            last_edges: [-1e9, -1e9],
            directions: [0.0, 0.0],
            count,
            first: start,
            channels: BTreeMap::new(),
            times: Vec::new(),
        }
    }

    fn quantum(&self) -> f64 {
        2.0 * std::f64::consts::PI / COUNTS / self.machine.ratio
    }

    fn stroke(&mut self, velocity: f64, cruise: f64, ramp: f64) {
        let samples = ((cruise + 2.0 * ramp) / SAMPLE).round() as usize + 200;
        for k in 0..samples {
            let t = k as f64 * SAMPLE;
            let profile = if t < ramp {
                t / ramp
            } else if t < ramp + cruise {
                1.0
            } else {
                (1.0 - (t - ramp - cruise) / ramp).max(0.0)
            };
            self.sample(velocity * profile);
        }
    }

    fn sample(&mut self, reference: f64) {
        let m = self.machine;
        let gain = m.ratio * TORQUE_CONSTANT;
        let position = self.count * self.quantum();
        let elapsed = self.time - self.last_edges[0];
        let period = self.last_edges[0] - self.last_edges[1];
        let same = self.directions[0] == self.directions[1];
        let velocity = if same { self.directions[0] * self.quantum() / period.max(elapsed) } else { 0.0 };
        let noise: f64 = (0..12).map(|_| self.random.random::<f64>()).sum::<f64>() - 6.0;
        let read = ((self.current + NOISE * noise) / RESOLUTION).round() * RESOLUTION;
        let read = if m.sensing == Sensing::Absolute { read.abs() } else { read };
        self.times.push(self.times.len() as f64 * SAMPLE);
        for (channel, value) in [
            (Channel::Position, position),
            (Channel::Velocity, velocity),
            (Channel::Current, read),
            (Channel::ReferenceVelocity, reference),
            (Channel::TrueMotorVelocity, self.rotor[1]),
            (Channel::TrueMotorPosition, self.rotor[0]),
        ] {
            self.channels.entry(channel).or_default().push(value);
        }
        let torque = -m.velocity_gain * ((velocity - reference) + m.position_rate * (position - self.reference))
            + m.gravity * (self.rotor[0] - self.first).cos();
        let command = (torque / gain).clamp(-18.0, 18.0);
        self.reference += reference * SAMPLE;
        for _ in 0..(SAMPLE / STEP).round() as usize {
            self.current += (command - self.current) * (STEP / 4e-4);
            self.step(gain * self.current);
        }
    }

    fn step(&mut self, motor: f64) {
        let m = self.machine;
        let (x, rate) = (self.rotor[0] - self.link[0], self.rotor[1] - self.link[1]);
        let half = 0.5 * m.gap;
        let gear = if x > half {
            (STIFFNESS * (x - half) + DAMPING * rate).max(0.0)
        } else if x < -half {
            (STIFFNESS * (x + half) + DAMPING * rate).min(0.0)
        } else {
            0.0
        };
        let share = m.friction.link_share;
        let weight = m.gravity * self.link[0].cos();
        self.rotor[1] = slide(self.rotor[1], motor - gear, m.rotor, &m.friction.law, 1.0 - share);
        self.link[1] = slide(self.link[1], gear - weight, m.link, &m.friction.law, share);
        self.rotor[0] += STEP * self.rotor[1];
        self.link[0] += STEP * self.link[1];
        self.time += STEP;
        let count = (self.rotor[0] / self.quantum()).floor();
        if count != self.count {
            self.last_edges = [self.time, self.last_edges[0]];
            self.directions = [(count - self.count).signum(), self.directions[0]];
            self.count = count;
        }
    }

    fn into_series(self) -> TimeSeries {
        let joint = JointSeries { name: "joint".to_owned(), channels: self.channels };
        TimeSeries { name: "generated".to_owned(), time: self.times, joints: vec![joint] }
    }
}

/// Velocity after a step under dry friction of one mass: sticks where friction can stop it within the step.
fn slide(v: f64, torque: f64, inertia: f64, law: &FrictionLaw, share: f64) -> f64 {
    let free = v + STEP * torque / inertia;
    let speed = if v * free > 0.0 { v.abs() } else { 0.0 };
    let drop = STEP * share * law.magnitude(Direction::of(free), speed) / inertia;
    if free.abs() <= drop { 0.0 } else { free - drop.copysign(free) }
}
