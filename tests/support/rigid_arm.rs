//! A rigid arm of two joints without gaps, and recordings of it by inverse dynamics: for tests of what a diagnosis decides, not of how
//! well it estimates.
#![allow(dead_code, reason = "every test file is its own crate and uses its own part")]

use std::collections::BTreeMap;
use std::path::Path;

use lostmotion::dynamics::Dynamics;
use lostmotion::effects::{self, Action, JointState};
use lostmotion::robot::{Accuracy, EffectEntry, Model};
use lostmotion::timeseries::{Channel, JointSeries, TimeSeries};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const URDF: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.15 0 0"/><mass value="1.5"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.012" iyz="0" izz="0.012"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.12 0 0"/><mass value="1.0"/><inertia ixx="0.0006" ixy="0" ixz="0" iyy="0.006" iyz="0" izz="0.006"/></inertial></link>
  <joint name="joint1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="3" velocity="3"/></joint>
  <joint name="joint2" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="3" velocity="3"/></joint>
</robot>"#;

/// Coulomb, breakaway, Stribeck velocity, viscous of both joints.
pub const FRICTION: [[f64; 4]; 2] = [[0.4, 0.48, 0.05, 0.4], [0.2, 0.23, 0.04, 0.2]];

/// An arm without gaps; friction is in the model file or not.
pub fn arm(with_friction: bool) -> Model {
    let joint = |index: usize| {
        let [coulomb, breakaway, v_s, viscous] = FRICTION[index];
        let friction = if with_friction {
            format!(
                "[joints.joint{}.friction]\ncoulomb = {coulomb}\nbreakaway = {breakaway}\nstribeck_velocity = {v_s}\nviscous = {viscous}\n",
                index + 1
            )
        } else {
            String::new()
        };
        format!(
            "[joints.joint{0}]\ngear_ratio = 5.0\nrotor_inertia = 0.0008\ngear_stiffness = 3000.0\ngear_damping = 2.0\nbacklash = 0.0\n\
             [joints.joint{0}.motor]\ntorque_constant = 0.02\n{friction}",
            index + 1
        )
    };
    let text =
        format!("schema = \"lostmotion/model/1\"\nname = \"arm\"\nurdf = \"arm.urdf\"\n{}{}", joint(0), joint(1));
    let model = Model::from_texts(&text, URDF, Path::new("model.toml")).expect("a good model");
    Model { accuracy: Accuracy::EXACT, ..model }
}

/// [s]
pub const INTERVAL: f64 = 0.002;

/// The currents that a rigid arm needs for a motion of four sines a joint, with what acts on it and white noise of 0.1 A (10 mN·m).
pub fn record(name: &str, truth: &Model, seed: u64, extra: &dyn Fn(usize, f64, f64) -> f64) -> TimeSeries {
    record_at(name, truth, seed, [0.07, 0.13, 0.23, 0.41], extra)
}

/// The same with sines about these frequencies [Hz].
pub fn record_at(
    name: &str,
    truth: &Model,
    seed: u64,
    frequencies: [f64; 4],
    extra: &dyn Fn(usize, f64, f64) -> f64,
) -> TimeSeries {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut model = truth.clone();
    let mut actions = Vec::new();
    for entry in &truth.effects {
        let effect = effects::find(&entry.effect).expect("an effect of the catalogue");
        let joint = entry.joint.as_ref().and_then(|name| model.robot.joint_index(name));
        actions.extend(effect.install(&mut model, joint, &entry.parameters).expect("it can be installed"));
    }
    let sines: Vec<Vec<[f64; 3]>> = (0..2)
        .map(|_| {
            frequencies
                .map(|f| {
                    [0.12 / f * rng.random_range(0.7..1.0), f * rng.random_range(0.9..1.1), rng.random_range(-3.0..3.0)]
                })
                .into()
        })
        .collect();
    let mut dynamics = Dynamics::new(&model.robot);
    let mut joints = ["joint1", "joint2"].map(|name| JointSeries { name: name.to_owned(), channels: BTreeMap::new() });
    let samples = 15_000;
    for k in 0..samples {
        let t = k as f64 * INTERVAL;
        let (mut q, mut v, mut a, mut tau) = ([0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]);
        for joint in 0..2 {
            for [size, f, phase] in &sines[joint] {
                let w = std::f64::consts::TAU * f;
                let (sin, cos) = (w * t + phase).sin_cos();
                q[joint] += size * sin;
                v[joint] += size * w * cos;
                a[joint] -= size * w * w * sin;
            }
        }
        dynamics.inverse(&q, &v, &a, &mut tau);
        for joint in 0..2 {
            let law = model.joints[joint].friction.expect("the truth has friction").law;
            let (mut level, mut drive) = (law.kinetic(v[joint]).abs(), extra(joint, q[joint], v[joint]));
            let state = JointState {
                time: t,
                motor_position: q[joint],
                motor_velocity: v[joint],
                link_position: q[joint],
                link_velocity: v[joint],
                gear_torque: tau[joint],
                ..JointState::default()
            };
            for action in &actions {
                if let Action::Joint(index, action) = action
                    && *index == joint
                {
                    level = action.dry_friction(&state, level);
                    drive += action.motor_torque(&state) + action.link_torque(&state);
                }
                if let Action::Stop(index, stop) = action
                    && *index == joint
                {
                    drive -= stop.side * stop.stiffness * (stop.side * (q[joint] - stop.place)).max(0.0);
                }
            }
            let torque =
                tau[joint] + model.joints[joint].reflected_inertia() * a[joint] + level * v[joint].signum() - drive;
            // The sum of twelve uniform numbers has a standard deviation of 1.
            let noise: f64 = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum();
            let current = torque / model.joints[joint].torque_per_ampere() + 0.1 * noise;
            joints[joint].channels.entry(Channel::Position).or_default().push(q[joint]);
            joints[joint].channels.entry(Channel::Current).or_default().push(current);
        }
    }
    let time = (0..samples).map(|k| k as f64 * INTERVAL).collect();
    TimeSeries { name: name.to_owned(), time, joints: joints.into() }
}

/// The arm with an effect.
pub fn with(effect: &str, joint: Option<&str>, parameters: &[(&str, f64)]) -> Model {
    let mut model = arm(true);
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    model.effects.push(EffectEntry { effect: effect.to_owned(), joint: joint.map(str::to_owned), parameters });
    model
}

/// Four sessions with waves up to 7 Hz, so that joints have transients.
pub fn fast_sessions(seed: u64) -> Vec<TimeSeries> {
    let session = |k: u64| record_at(&format!("fast_{k}"), &arm(true), seed + k, [0.1, 0.5, 3.0, 7.0], &|_, _, _| 0.0);
    (0..4).map(session).collect()
}
