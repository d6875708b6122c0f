//! Motor axes that move several joints, `θ = C q`: torques by virtual work, the simulated machine, its sensors, its model file.

#[path = "support/engines.rs"]
mod engines;
#[path = "support/machines.rs"]
mod machines;
#[path = "support/mod.rs"]
mod support;

use std::path::Path;

use engines::both_engines;
use lostmotion::drive::LinkEncoder;
use lostmotion::dynamics::Dynamics;
use lostmotion::plant::{Engine, Options, Plant};
use lostmotion::robot::{Coupling, EffectEntry, Inertia, Limits, Model, Robot};
use lostmotion::units::JointKind;
use machines::{body, friction, geared, plain, point_tensor};
use nalgebra::{DMatrix, DVector, Isometry3, Vector3};

fn coupling(n: usize, rows: &[f64]) -> Option<Coupling> {
    Some(Coupling::new(DMatrix::from_row_slice(n, n, rows)).expect("an invertible matrix"))
}

const MASS: f64 = 1.7;
const LENGTH: f64 = 0.25;
const RADIUS: f64 = 0.08;

/// A wrist whose last motor turns by the sum of both joints: bending about y, then turning about the flange's z axis, and a mass beside that axis.
fn wrist() -> Robot {
    let link = |mass, com| Inertia { mass, com, tensor: point_tensor(2e-3, 2e-3, 1e-3) };
    Robot {
        bodies: vec![
            body("bend", None, JointKind::Revolute, Isometry3::identity(), Vector3::y(), link(0.0, Vector3::zeros())),
            body(
                "turn",
                Some(0),
                JointKind::Revolute,
                Isometry3::identity(),
                Vector3::z(),
                link(MASS, Vector3::new(RADIUS, 0.0, LENGTH)),
            ),
        ],
        coupling: coupling(2, &[1.0, 0.0, 1.0, 1.0]),
        ..machines::planar_arm()
    }
}

/// `U = m g (l cos q5 − r sin q5 cos q6)`, `τ_q = ∂U/∂q`, and on the motors `τ_θ5 = τ_q5 − τ_q6`, `τ_θ6 = τ_q6`.
fn holding(q: [f64; 2]) -> [f64; 2] {
    let [(s5, c5), (s6, c6)] = q.map(f64::sin_cos);
    let weight = MASS * 9.81;
    let bend = -weight * (LENGTH * s5 + RADIUS * c5 * c6);
    let turn = weight * RADIUS * s5 * s6;
    [bend - turn, turn]
}

#[test]
fn analytic_torques_that_hold_a_wrist_with_a_mass() {
    let robot = wrist();
    for q in [[0.3, 0.9], [-1.2, 2.5], [1.4, -0.4]] {
        let theta = [q[0], q[0] + q[1]];
        let mut tau = [0.0; 2];
        Dynamics::new(&robot).gravity(&theta, &mut tau);
        for (found, expected) in tau.iter().zip(holding(q)) {
            // Rounding of products of numbers near 10.
            assert!((found - expected).abs() < 1e-13, "{q:?}: {tau:?} instead of {expected}");
        }
    }
}

/// A machine under the torques that hold it stays where it is: each gear transmits the torque of its own axis.
#[test]
fn analytic_a_wrist_at_rest_under_its_holding_torques() {
    let mut model = plain(wrist());
    // The springs of the gears give way; this stiff they do by less than 2e-7 rad.
    model.joints.iter_mut().for_each(|joint| joint.gear_stiffness = Some(2e7));
    model.joints.iter_mut().for_each(|joint| joint.gear_damping = Some(100.0));
    model.joints.iter_mut().for_each(|joint| joint.link_encoder = Some(LinkEncoder { resolution: 1e-9 }));
    let q = [0.7, -0.5];
    let theta = [q[0], q[0] + q[1]];
    for engine in [Engine::Rapier, Engine::Reduced] {
        let mut plant = Plant::new(&model, &Options { engine, ideal_sensors: true, ..Options::default() }).unwrap();
        plant.place(&theta);
        for _ in 0..200 {
            plant.advance(&holding(q), 1e-3).unwrap();
        }
        let readings = plant.read().to_vec();
        for k in 0..2 {
            // The springs wind up by T/k = 5/2e7 rad and swing by twice that, which changes the weight by 1e-6 of 5 N·m; 1e-6/0.02 rad/s² over
            // 0.2 s is 1e-6 rad.
            assert!((readings[k].position - theta[k]).abs() < 3e-6, "{engine:?}: {readings:?}");
            assert!((readings[k].link_position.unwrap() - q[k]).abs() < 3e-6, "{engine:?}: {readings:?}");
            assert!((plant.states()[k].gear_torque - holding(q)[k]).abs() < 0.02 * holding(q)[k].abs());
        }
    }
}

/// All algorithms agree in the coordinates of the axes: `τ = M a + C v + g = Y π`, `½ vᵀ M v` is the kinetic energy, `Ṁ − 2 C` is skew-symmetric.
#[test]
fn equivalent_algorithms_in_the_coordinates_of_axes() {
    let mut rng = support::random(5);
    let n = 5;
    for _ in 0..10 {
        let mut robot = support::random_chain(&mut rng, n);
        let lower = support::numbers(&mut rng, n * n, 1.0);
        let lower = DMatrix::from_fn(n, n, |i, j| {
            if i == j {
                1.5
            } else if i > j {
                lower[i * n + j]
            } else {
                0.0
            }
        });
        robot.coupling = Coupling::new(lower);
        let mut dynamics = Dynamics::new(&robot);
        let [q, v, a] = [2.0, 1.0, 3.0].map(|size| support::numbers(&mut rng, n, size));
        let (mut m, mut c, mut y) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n), DMatrix::zeros(n, 10 * n));
        let (mut tau, mut bias, mut g, mut back) = (vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        dynamics.inverse(&q, &v, &a, &mut tau);
        dynamics.gravity(&q, &mut g);
        dynamics.coriolis_matrix(&q, &v, &mut c);
        dynamics.mass_matrix_and_bias(&q, &v, &mut m, &mut bias);
        dynamics.regressor(&q, &v, &a, &mut y);
        dynamics.forward(&q, &v, &tau, &mut back);
        let vector = |values: &[f64]| DVector::from_column_slice(values);
        let pi: Vec<f64> = robot.bodies.iter().flat_map(|body| body.inertia.parameters()).collect();
        let size = vector(&tau).amax().max(1.0);
        // Rounding through inverses whose condition is below 1e3.
        let near = |found: DVector<f64>| assert!((found - vector(&tau)).amax() < 1e-11 * size);
        near(&m * vector(&a) + vector(&bias));
        near(&m * vector(&a) + &c * vector(&v) + vector(&g));
        near(&y * vector(&pi));
        assert!((vector(&back) - vector(&a)).amax() < 1e-8 * vector(&a).amax());
        let kinetic = 0.5 * vector(&v).dot(&(&m * vector(&v)));
        assert!((dynamics.kinetic_energy(&q, &v) / kinetic - 1.0).abs() < 1e-11);
        // Central difference over h: rounding 1e-16/h and the third derivative h²/6, both 1e-10 at 1e-5.
        let h = 1e-5;
        let mut at = |step: f64| {
            let moved: Vec<f64> = q.iter().zip(&v).map(|(q, v)| q + step * v).collect();
            let mut mass = DMatrix::zeros(n, n);
            dynamics.mass_matrix(&moved, &mut mass);
            mass
        };
        let skew = (at(h) - at(-h)) / (2.0 * h) - 2.0 * &c;
        assert!((&skew + skew.transpose()).amax() < 1e-7 * m.amax(), "{}", &skew + skew.transpose());
    }
}

/// Six joints with a coupled wrist, a cable on the last, end stops and dampers on joints that two motors move.
fn six() -> Model {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/sixaxis/model.toml");
    let mut model = Model::load(&file).unwrap();
    let mut rows = DMatrix::identity(6, 6);
    (rows[(4, 3)], rows[(5, 3)], rows[(5, 4)]) = (-0.02, 0.015, 1.0);
    model.robot.coupling = Coupling::new(rows);
    for joint in 3..6 {
        model.robot.bodies[joint].joint.damping = 0.3;
    }
    model.robot.bodies[4].joint.limits = Limits { lower: -0.02, upper: 0.02, ..model.robot.bodies[4].joint.limits };
    model.joints[4].end_stop_stiffness = Some(3000.0);
    let parameters = [("stiffness".to_owned(), 4.0), ("rest_position".to_owned(), 0.4)].into();
    model.effects =
        vec![EffectEntry { effect: "cable_spring".to_owned(), joint: Some("joint6".to_owned()), parameters }];
    model
}

fn shake(model: &Model, t: f64) -> Vec<f64> {
    let level = |joint: &lostmotion::robot::JointModel| {
        let resting = joint.friction.map_or(0.0, |f| f.law.magnitude(lostmotion::gearhead::Direction::Positive, 0.0));
        (2.0 * resting + 8.0 * joint.reflected_inertia()) / joint.torque_per_ampere()
    };
    model.joints.iter().enumerate().map(|(i, joint)| level(joint) * ((9.0 + i as f64) * t + i as f64).sin()).collect()
}

/// The cable's torque on joint 6 works on two motors; its energy `½ c (q6 − q0)²` is work given back by what effects add.
#[test]
fn property_energy_closes_with_a_coupled_wrist() {
    let model = six();
    for engine in [Engine::Rapier, Engine::Reduced] {
        let mut plant = Plant::new(&model, &Options { engine, ideal_sensors: true, ..Options::default() }).unwrap();
        let start = plant.energy();
        let mut touched = false;
        for k in 0..1000 {
            plant.advance(&shake(&model, f64::from(k) * 1e-3), 1e-3).unwrap();
            touched |= plant.touches().any(|touch| touch.body == 4);
        }
        let end = plant.energy();
        let gap = end.work - end.dissipated - (end.stored - start.stored);
        println!("{engine:?}: {end:?}, gap {gap:.1e} J");
        assert!(touched && end.dissipated > 0.0);
        // As for machines that are not coupled, of what has been turned over.
        assert!(gap.abs() < 1e-4 * (end.work.abs() + end.dissipated), "{engine:?}: {gap:e} of {end:?}");
    }
}

#[test]
fn equivalent_engines_with_a_coupled_wrist() {
    let model = six();
    let mut plants = both_engines(&model);
    let mut worst = 0.0_f64;
    for k in 0..1000 {
        let command = shake(&model, f64::from(k) * 1e-3);
        plants.iter_mut().for_each(|plant| plant.advance(&command, 1e-3).unwrap());
        for (a, b) in plants[0].states().iter().zip(plants[1].states()) {
            worst = worst.max((a.link_position - b.link_position).abs());
        }
    }
    println!("{worst:.1e}");
    // As for machines that are not coupled.
    assert!(worst < 1e-8, "{worst:e}");
}

/// A matrix that couples nothing changes nothing but the last digits.
#[test]
fn equivalent_an_identity_is_no_coupling() {
    let plain = geared(machines::planar_arm());
    let mut model = plain.clone();
    model.robot.coupling = coupling(2, &[1.0, 0.0, 0.0, 1.0]);
    let mut plants = [&plain, &model].map(|model| Plant::new(model, &Options::default()).unwrap());
    for k in 0..500 {
        let command = shake(&plain, f64::from(k) * 1e-3);
        plants.iter_mut().for_each(|plant| plant.advance(&command, 1e-3).unwrap());
    }
    for (a, b) in plants[0].states().iter().zip(plants[1].states()) {
        // Rounding of 1e-16 that events and a gap amplify over half a second.
        assert!((a.motor_position - b.motor_position).abs() < 1e-9 && a.motor_position.abs() > 1e-3);
    }
}

/// The friction of an axis is that of its motor: a wrist that turns its last motor alone moves one joint and meets one friction.
#[test]
fn analytic_friction_belongs_to_the_motor() {
    let mut robot = wrist();
    robot.gravity = Vector3::zeros();
    let mut model = plain(robot);
    for joint in &mut model.joints {
        joint.friction = Some(friction(1.0, 1.0, 0.1, 0.0, 0.3));
    }
    let mut plant = Plant::new(&model, &Options { ideal_sensors: true, ..Options::default() }).unwrap();
    plant.place(&[0.0, 0.0]);
    for _ in 0..100 {
        plant.advance(&[0.95, 0.0], 1e-3).unwrap();
    }
    // The gear's spring holds what the rotor's share of friction leaves.
    assert!(plant.states().iter().all(|state| state.motor_velocity.abs() < 1e-9), "{:?}", plant.states());
    for _ in 0..100 {
        plant.advance(&[0.95, 1.5], 1e-3).unwrap();
    }
    assert!(plant.states()[1].motor_velocity > 0.1, "{:?}", plant.states());
}

const URDF: &str = r#"<robot name="arm"><link name="base"/>
<joint name="a" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/></joint>
<link name="l1"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="b" type="continuous"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/></joint>
<link name="l2"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;

fn read(rows: &str) -> lostmotion::error::Result<Model> {
    let text = format!(
        "schema = \"lostmotion/model/1\"\nname = \"arm\"\nurdf = \"arm.urdf\"\n[joints.a]\ngear_ratio = 10.0\n[joints.b]\ngear_ratio = 10.0\n{rows}"
    );
    Model::from_texts(&text, URDF, Path::new("model.toml"))
}

#[test]
fn equivalent_a_coupling_is_read_and_written() {
    let model = read("[coupling]\nb = { a = -1.0, b = 1.0 }\n").unwrap();
    assert_eq!(model.robot.coupling, coupling(2, &[1.0, 0.0, -1.0, 1.0]));
    let again = Model::from_texts(&model.to_toml(Path::new("arm.urdf")), URDF, Path::new("model.toml")).unwrap();
    assert_eq!(again.robot.coupling, model.robot.coupling);
    assert_eq!(read("").unwrap().robot.coupling, None);
}

#[test]
fn property_a_wrong_coupling_is_refused_where_it_stands() {
    for (rows, place, expected) in [
        ("[coupling]\nb = { a = 1.0, b = 0.0 }\n", "coupling", "invertible"),
        ("[coupling]\nb = { a = 1.0 }\n", "coupling", "invertible"),
        ("[coupling]\nb = { }\n", "coupling", "invertible"),
        ("[coupling]\nc = { a = 1.0 }\n", "coupling.c", "a joint of this model"),
        ("[coupling]\nb = { c = 1.0, b = 1.0 }\n", "coupling.b.c", "a joint of this model"),
        ("[coupling]\nb = { a = \"one\", b = 1.0 }\n", "coupling.b.a", "motion of the axis"),
        ("[coupling]\nb = [1.0, 1.0]\n", "coupling.b", "a table"),
        ("coupling = 3\n", "", ""),
    ] {
        let said = read(rows).expect_err(rows).to_string();
        assert!(said.contains(place) && said.contains(expected), "{rows}: {said}");
    }
}
