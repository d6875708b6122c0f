//! The machines that come with the project: both engines alike, their books closed, coarse and fine steps alike.

use std::path::Path;

use crate::engines::both_engines;
use crate::exactness;
use crate::machines::*;
use lostmotion::dynamics::{Dynamics, MotionCheck};
use lostmotion::plant::{Engine, Evaluations, Options, Plant, RigidBody};
use lostmotion::robot::{JointModel, Model};
use nalgebra::DMatrix;

fn load(name: &str) -> Model {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut model = Model::load(&root.join("robots").join(name).join("model.toml")).unwrap();
    // A nominal model leaves out what is to be identified: the test wants all of it.
    for joint in &mut model.joints {
        let scale = joint.reflected_inertia();
        joint.backlash.get_or_insert(0.004);
        joint.friction.get_or_insert(friction(2.0 * scale, 3.0 * scale, 0.03, 4.0 * scale, 0.3));
    }
    model
}

fn robots() -> Vec<(&'static str, Model)> {
    vec![
        ("scara", load("scara")),
        ("emps", load("emps")),
        ("elbow", load("elbow")),
        ("sixaxis", load("sixaxis")),
        ("chain12", load("chain12")),
    ]
}

/// Currents that shake every joint against its friction and across its gap: accelerations of ±`a` of rotor and link together.
fn shake(model: &Model, t: f64) -> Vec<f64> {
    let level = |joint: &lostmotion::robot::JointModel| {
        let resting = joint.friction.map_or(0.0, |f| f.law.magnitude(lostmotion::gearhead::Direction::Positive, 0.0));
        (1.5 * resting + 8.0 * joint.reflected_inertia()) / joint.torque_per_ampere()
    };
    model.joints.iter().enumerate().map(|(i, joint)| level(joint) * ((9.0 + i as f64) * t + i as f64).sin()).collect()
}

#[test]
fn property_energy_closes_on_every_robot() {
    for (name, model) in robots() {
        for engine in [Engine::Rapier, Engine::Reduced] {
            let mut plant = Plant::new(&model, &Options { engine, ideal_sensors: true, ..Options::default() }).unwrap();
            let start = plant.energy();
            for k in 0..1000 {
                plant.advance(&shake(&model, f64::from(k) * 1e-3), 1e-3).unwrap();
            }
            let end = plant.energy();
            let gap = end.work - end.dissipated - (end.stored - start.stored);
            println!("{name} {engine:?}: {end:?}, gap {gap:.1e} J");
            assert!(end.dissipated > 0.0);
            // Of what has been turned over: work may return and come to nothing.
            assert!(gap.abs() < 1e-4 * (end.work.abs() + end.dissipated), "{name} {engine:?}: {gap:e} of {end:?}");
        }
    }
}

#[test]
fn equivalent_engines_on_every_robot() {
    for (name, model) in robots() {
        let mut plants = both_engines(&model);
        let mut worst = 0.0_f64;
        let mut moved = vec![0.0_f64; model.joints.len()];
        for k in 0..1000 {
            let command = shake(&model, f64::from(k) * 1e-3);
            plants.iter_mut().for_each(|plant| plant.advance(&command, 1e-3).unwrap());
            for (i, (a, b)) in plants[0].states().iter().zip(plants[1].states()).enumerate() {
                worst = worst.max((a.link_position - b.link_position).abs());
                moved[i] = moved[i].max(a.motor_position.abs());
            }
        }
        println!("{name}: {worst:.1e}, moved {moved:.2?}");
        assert!(worst < 1e-8, "{name}: {worst:e}");
        assert!(moved.iter().all(|&m| m > 1e-3), "{name}: {moved:?}");
    }
}

/// A machine and its position and velocity controllers at 1 kHz, on exact sensors, gravity compensated.
struct ClosedLoop {
    plant: Plant,
    links: Dynamics,
    integral: Vec<f64>,
    /// [kg·m²] of rotor and link, one a joint.
    inertia: Vec<f64>,
    torque_per_ampere: Vec<f64>,
    mass: DMatrix<f64>,
    gravity: Vec<f64>,
}

impl ClosedLoop {
    fn new(model: &Model, options: Options) -> Self {
        let n = model.joints.len();
        let mut links = Dynamics::new(&model.robot);
        let (mut mass, mut gravity) = (DMatrix::zeros(n, n), vec![0.0; n]);
        let start: Vec<f64> = (0..n).map(|joint| swing(n, joint, 0.0)[0]).collect();
        links.evaluate(&start, &vec![0.0; n], &mut mass, &mut gravity);
        let inertia = (0..n).map(|i| mass[(i, i)] + model.joints[i].reflected_inertia()).collect();
        let torque_per_ampere = model.joints.iter().map(JointModel::torque_per_ampere).collect();
        let mut plant = Plant::new(model, &Options { ideal_sensors: true, ..options }).unwrap();
        plant.place(&start);
        Self { plant, links, integral: vec![0.0; n], inertia, torque_per_ampere, mass, gravity }
    }

    /// A millisecond; returns motor and link angles.
    fn advance(&mut self, time: f64) -> Vec<[f64; 2]> {
        let Self { plant, links, integral, inertia, torque_per_ampere, mass, gravity } = self;
        let q: Vec<f64> = plant.states().iter().map(|state| state.motor_position).collect();
        links.evaluate(&q, &vec![0.0; q.len()], mass, gravity);
        let command: Vec<f64> = (0..q.len())
            .map(|joint| {
                let [position, velocity] = swing(q.len(), joint, time);
                let error = velocity - plant.states()[joint].motor_velocity + 4.0 * (position - q[joint]);
                integral[joint] += 4.0 * error * 1e-3;
                (gravity[joint] + inertia[joint] * 15.0 * (error + integral[joint])) / torque_per_ampere[joint]
            })
            .collect();
        plant.advance(&command, 1e-3).unwrap();
        plant.states().iter().map(|state| [state.motor_position, state.link_position]).collect()
    }
}

/// Position and velocity wanted of a joint: to and fro, each at its own pace, from a bent arm; the less the more joints there are,
/// so that the drives can do it.
fn swing(joints: usize, joint: usize, time: f64) -> [f64; 2] {
    let (size, omega) = (1.2 / joints as f64, 6.0 + 0.5 * joint as f64);
    let middle = [0.2, 0.5, -0.4][joint % 3];
    [middle - size * (omega * time).cos(), size * omega * (omega * time).sin()]
}

/// The arms with many joints in closed loop: to and fro under gravity, through gaps and stick. Engines agree, the books close,
/// and the default steps are within 1e-4 degrees of four times as many, with the links asked at every stage.
#[test]
fn equivalent_closed_loop_of_many_joints() {
    let motions = [
        (
            "sixaxis",
            "| six joints under gravity in closed loop, 2 s (against steps a quarter as long, links asked at every stage) |",
        ),
        ("chain12", "| twelve joints, the same |"),
    ];
    for (name, row) in motions {
        let model = load(name);
        let own = Options { engine: Engine::Reduced, ..Options::default() };
        let fine = Options { step: 2.5e-4, evaluations: Evaluations::EveryStage, ..own.clone() };
        let rapier = Options { evaluations: Evaluations::EveryInterval, ..Options::default() };
        let mut loops = [rapier, own, fine].map(|options| ClosedLoop::new(&model, options));
        let start = loops[0].plant.energy();
        let (mut engines, mut steps) = (0.0_f64, 0.0_f64);
        // Flanks met and reversals, counted at the control's instants; flank and last velocity a joint.
        let mut events = [0; 2];
        let mut before: Vec<(i8, f64)> = vec![(0, 0.0); model.joints.len()];
        for k in 0..2000 {
            let [rapier, own, fine] = loops.each_mut().map(|one| one.advance(f64::from(k) * 1e-3));
            for (joint, before) in before.iter_mut().enumerate() {
                for side in 0..2 {
                    engines = engines.max((rapier[joint][side] - own[joint][side]).abs());
                    steps = steps.max((own[joint][side] - fine[joint][side]).abs());
                }
                let plant = &loops[0].plant;
                let (flank, velocity) = (plant.contact(joint), plant.states()[joint].motor_velocity);
                events[0] += usize::from(flank != before.0 && flank != 0);
                events[1] += usize::from(velocity * before.1 < 0.0);
                // A motor that rests between has turned back when it moves again.
                *before = (flank, if velocity == 0.0 { before.1 } else { velocity });
            }
        }
        let end = loops[0].plant.energy();
        let gap = end.work - end.dissipated - (end.stored - start.stored);
        let [met, reversals] = events;
        println!(
            "{name}: engines {engines:.1e} rad, steps {:.1e} deg, energy {gap:.1e} of {:.1} J, {met} flanks met, {reversals} reversals",
            steps.to_degrees(),
            end.dissipated
        );
        exactness::says(row, &[met as f64, reversals as f64, steps.to_degrees()]);
        // What a replay may depend on the engine by, and what is promised of the plant.
        assert!(engines < 1e-8, "{name}: {engines:e} rad");
        assert!(steps.to_degrees() < 1e-4, "{name}: {:e} deg", steps.to_degrees());
        assert!(gap.abs() < 1e-4 * end.dissipated, "{name}: {gap:e} of {end:?}");
        assert!(met > model.joints.len() && reversals >= model.joints.len(), "{name}: {events:?}");
    }
}

/// The shapes of a robot leave each joint its range, the others at zero: none is barred by the housing of its neighbour.
#[test]
fn property_every_joint_has_its_whole_range() {
    for (name, model) in robots() {
        let mut check = MotionCheck::new(&model.robot).unwrap();
        let n = model.joints.len();
        for (joint, body) in model.robot.bodies.iter().enumerate() {
            for limit in [body.joint.limits.lower, body.joint.limits.upper] {
                let mut positions = vec![[0.0, 0.0]; n];
                positions[joint][1] = limit;
                let positions: Vec<&[f64]> = positions.iter().map(|path| path.as_slice()).collect();
                let found = check.check(&[0.0, 1.0], &positions);
                assert!(found.is_ok(), "{name}, {} to {limit}: {}", body.joint.name, found.unwrap_err());
            }
        }
    }
}

#[test]
fn property_a_link_without_inertia_is_refused() {
    let mut robot = planar_arm();
    robot.bodies[1].inertia.mass = 0.0;
    robot.bodies[1].inertia.tensor.fill(0.0);
    let error = Plant::new(&plain(robot), &Options::default()).err().expect("must be refused").to_string();
    assert!(error.contains("joint2"), "{error}");
}

#[test]
fn analytic_gravity_is_held_by_the_motor() {
    // A pendulum at 30 degrees held still: K i = m g l sin q, and the gear is wound up by T/k.
    let mut plant = Plant::new(&plain(pendulum(1.0, 0.1)), &Options::default()).unwrap();
    let q = 30.0_f64.to_radians();
    let load = 9.81 * 0.1 * q.sin();
    plant.launch(&[lostmotion::effects::JointState {
        link_position: q,
        motor_position: q + load / 3000.0,
        ..Default::default()
    }]);
    plant.advance(&[load], 1.0).unwrap();
    // Rounding of 1e-15 grows with the pendulum's unstable balance of rotor torque: e^{t} at most.
    assert!((plant.states()[0].link_position - q).abs() < 1e-9);
}

#[test]
fn equivalent_engines_over_the_staircase() {
    // ±0.5 to 10 deg/s in steps of 0.5 deg/s, a second each way, one joint at a time, under PI control with exact sensors.
    let model = load("scara");
    let mut plants = both_engines(&model);
    let n = model.joints.len();
    let inertia = [0.3, 0.05];
    let mut integral = vec![vec![0.0; n]; 2];
    let mut worst = 0.0_f64;
    let mut travel = [0.0_f64; 2];
    for k in 0..80_000 {
        let t = f64::from(k) * 1e-3;
        let moving = usize::from(t >= 40.0);
        let stair = ((t % 40.0) / 2.0).floor() + 1.0;
        let speed = 0.5_f64.to_radians() * stair * if t % 2.0 < 1.0 { 1.0 } else { -1.0 };
        for (plant, integral) in plants.iter_mut().zip(&mut integral) {
            let mut command = vec![0.0; n];
            for joint in 0..2 {
                let error = if joint == moving { speed } else { 0.0 } - plant.states()[joint].motor_velocity;
                let gain = 60.0 * inertia[joint] / model.joints[joint].torque_per_ampere();
                integral[joint] += 30.0 * gain * error * 1e-3;
                command[joint] = gain * error + integral[joint];
            }
            plant.advance(&command, 1e-3).unwrap();
        }
        for (a, b) in plants[0].states().iter().zip(plants[1].states()) {
            worst =
                worst.max((a.link_position - b.link_position).abs().max((a.motor_position - b.motor_position).abs()));
        }
        travel[moving] = travel[moving].max(plants[0].states()[moving].link_position.abs());
    }
    println!("staircase: engines differ by {worst:.1e} rad, travel {travel:.3?}");
    // What a replay may depend on the engine by: a ten-thousandth of an encoder count.
    assert!(worst < 1e-8, "{worst:e}");
    assert!(travel.iter().all(|&q| q > 0.1), "{travel:?}");
}

#[test]
fn analytic_load_raises_the_breakaway_of_an_effect() {
    // A rotor at rest on a gear that a blocked link has wound up by T: friction holds it up to τ = T + F + μ T.
    let (level, mu, load) = (0.2, 0.15, 1.0);
    let joint = lostmotion::robot::JointModel {
        friction: Some(friction(level, level, 0.1, 0.0, 0.0)),
        ..plain_joint("joint1")
    };
    for (coefficient, expected) in [(0.0, load + level), (mu, load + level + mu * load)] {
        let mut model = model(turntable(1e9), vec![joint.clone()]);
        model.effects.push(lostmotion::robot::EffectEntry {
            effect: "load_dependent_friction".to_owned(),
            joint: Some("joint1".to_owned()),
            parameters: [("coefficient".to_owned(), coefficient)].into(),
        });
        let mut plant = Plant::new(&model, &Options { ideal_sensors: true, ..Options::default() }).unwrap();
        plant.launch(&[lostmotion::effects::JointState { motor_position: load / 3000.0, ..Default::default() }]);
        let mut torque = load;
        plant.advance(&[torque], 1e-3).unwrap();
        while plant.sticks(0)[0] && torque < 2.0 * expected {
            torque += 1e-4;
            plant.advance(&[torque], 1e-3).unwrap();
        }
        // The ramp's step of 1e-4; the heavy link gives way by 1e-9 rad.
        assert!((torque / expected - 1.0).abs() < 2e-4, "{torque} {expected}");
    }
}
