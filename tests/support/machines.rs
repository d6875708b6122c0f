//! Machines for the tests, built without files.
#![allow(dead_code)]

use std::collections::BTreeMap;
use std::path::PathBuf;

use lostmotion::drive::{Amplifier, CurrentSensor, Encoder, Motor, Sensing, VelocitySensor};
use lostmotion::gearhead::{Exponential, Friction, FrictionLaw};
use lostmotion::robot::{Body, EffectEntry, Inertia, Joint, JointModel, Limits, Model, Robot};
use lostmotion::units::JointKind;
use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};

pub const UNLIMITED: Limits =
    Limits { lower: f64::NEG_INFINITY, upper: f64::INFINITY, effort: f64::INFINITY, velocity: f64::INFINITY };

pub fn body(
    name: &str,
    parent: Option<usize>,
    kind: JointKind,
    origin: Isometry3<f64>,
    axis: Vector3<f64>,
    inertia: Inertia,
) -> Body {
    Body {
        name: format!("{name}_link"),
        parent,
        joint: Joint {
            name: name.to_owned(),
            kind,
            origin,
            axis: Unit::new_normalize(axis),
            limits: UNLIMITED,
            damping: 0.0,
            friction: 0.0,
        },
        inertia,
        shapes: Vec::new(),
    }
}

pub fn point_tensor(x: f64, y: f64, z: f64) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(x, y, z))
}

/// Masses of the planar arm of the practice sets.
pub const L1: f64 = 0.3;
pub const M1: f64 = 1.5;
pub const C1: f64 = 0.15;
pub const I1: f64 = 0.012;
pub const M2: f64 = 1.4;
pub const C2: f64 = 0.157;
pub const I2: f64 = 0.012;

/// Two vertical axes: gravity does not act on the joints.
pub fn planar_arm() -> Robot {
    let inertia =
        |mass, com, izz| Inertia { mass, com: Vector3::new(com, 0.0, 0.0), tensor: point_tensor(0.3 * izz, izz, izz) };
    Robot {
        name: "planar".to_owned(),
        gravity: Vector3::new(0.0, 0.0, -9.81),
        drawn: Vec::new(),
        base_shapes: Vec::new(),
        unread_shapes: Vec::new(),
        bodies: vec![
            body("joint1", None, JointKind::Revolute, Isometry3::identity(), Vector3::z(), inertia(M1, C1, I1)),
            body(
                "joint2",
                Some(0),
                JointKind::Revolute,
                Isometry3::translation(L1, 0.0, 0.0),
                Vector3::z(),
                inertia(M2, C2, I2),
            ),
        ],
        coupling: None,
    }
}

/// One joint about a vertical axis with this inertia.
pub fn turntable(inertia: f64) -> Robot {
    Robot {
        name: "turntable".to_owned(),
        gravity: Vector3::new(0.0, 0.0, -9.81),
        drawn: Vec::new(),
        base_shapes: Vec::new(),
        unread_shapes: Vec::new(),
        bodies: vec![body(
            "joint1",
            None,
            JointKind::Revolute,
            Isometry3::identity(),
            Vector3::z(),
            Inertia { mass: 1.0, com: Vector3::zeros(), tensor: point_tensor(inertia, inertia, inertia) },
        )],
        coupling: None,
    }
}

/// A pendulum about a horizontal axis, hanging at q = 0.
pub fn pendulum(mass: f64, length: f64) -> Robot {
    Robot {
        name: "pendulum".to_owned(),
        gravity: Vector3::new(0.0, 0.0, -9.81),
        drawn: Vec::new(),
        base_shapes: Vec::new(),
        unread_shapes: Vec::new(),
        bodies: vec![body(
            "joint1",
            None,
            JointKind::Revolute,
            Isometry3::identity(),
            Vector3::y(),
            Inertia { mass, com: Vector3::new(0.0, 0.0, -length), tensor: point_tensor(1e-3, 1e-3, 1e-3) },
        )],
        coupling: None,
    }
}

/// A mass on a slide in the direction of an axis; gravity pulls along −z.
pub fn slide(mass: f64, axis: Vector3<f64>) -> Robot {
    let inertia = Inertia { mass, com: Vector3::zeros(), tensor: point_tensor(1e-2, 1e-2, 1e-2) };
    let body = body("joint1", None, JointKind::Prismatic, Isometry3::identity(), axis, inertia);
    Robot { name: "slide".to_owned(), bodies: vec![body], ..turntable(1.0) }
}

/// A joint with nothing but inertia and a stiff gear: no friction, no gap, ideal drive, no sensors.
pub fn plain_joint(name: &str) -> JointModel {
    JointModel {
        name: name.to_owned(),
        kind: JointKind::Revolute,
        gear_ratio: 1.0,
        rotor_inertia: Some(0.02),
        gear_stiffness: Some(3000.0),
        gear_damping: Some(2.0),
        end_stop_stiffness: None,
        backlash: None,
        motor: Some(Motor { torque_constant: 1.0, resistance: None, inductance: None }),
        amplifier: Amplifier {
            voltage_limit: f64::INFINITY,
            current_limit: f64::INFINITY,
            current_time_constant: 4e-4,
        },
        encoder: None,
        link_encoder: None,
        velocity_sensor: None,
        current_sensor: None,
        friction: None,
        torque_at: lostmotion::robot::TorqueAt::Motor,
        constant_accuracy: None,
    }
}

pub fn friction(coulomb: f64, breakaway: f64, stribeck_velocity: f64, viscous: f64, link_share: f64) -> Friction {
    let one = Exponential { coulomb, breakaway, stribeck_velocity, viscous };
    Friction { law: FrictionLaw::Exponential([one, one]), link_share }
}

pub fn model(robot: Robot, joints: Vec<JointModel>) -> Model {
    Model {
        name: robot.name.clone(),
        source: PathBuf::new(),
        urdf: PathBuf::new(),
        urdf_text: String::new(),
        robot,
        joints,
        held: Vec::new(),
        remarks: Vec::new(),
        masses: lostmotion::robot::Masses::Known,
        accuracy: lostmotion::robot::Accuracy::EXACT,
        effects: Vec::<EffectEntry>::new(),
        loads: Vec::new(),
        places: lostmotion::toml_input::Places::default(),
    }
}

/// A plain joint for every body of a robot.
pub fn plain(robot: Robot) -> Model {
    let joints = robot.bodies.iter().map(|body| plain_joint(&body.joint.name)).collect();
    model(robot, joints)
}

/// The planar arm with gears, friction, gaps, drives and sensors.
pub fn scara() -> Model {
    let joint = |name: &str, gear_ratio, rotor_inertia, backlash, friction| JointModel {
        gear_ratio,
        rotor_inertia: Some(rotor_inertia),
        backlash: Some(backlash),
        motor: Some(Motor { torque_constant: 0.023, resistance: Some(0.5), inductance: Some(0.0005) }),
        amplifier: Amplifier { voltage_limit: 24.0, current_limit: 18.0, current_time_constant: 4e-4 },
        encoder: Some(Encoder { counts_per_turn: 2000.0 }),
        velocity_sensor: Some(VelocitySensor::LowPass(0.02)),
        current_sensor: Some(CurrentSensor { noise: 0.03, resolution: 0.0098, sensing: Sensing::Signed }),
        friction: Some(friction),
        ..plain_joint(name)
    };
    model(
        planar_arm(),
        vec![
            joint("joint1", 5.375, 6.29e-4, 0.0103, friction(0.442, 0.509, 0.0603, 0.407, 0.4)),
            joint("joint2", 10.0 / 3.0, 1.903e-3, 0.0064, friction(0.173, 0.187, 0.0408, 0.187, 0.4)),
        ],
    )
}

/// A random tree of that many joints of both kinds, with full inertia tensors.
pub fn random_tree(mut uniform: impl FnMut() -> f64, joints: usize) -> Robot {
    let mut bodies = Vec::with_capacity(joints);
    for i in 0..joints {
        let mut vector = |scale: f64| Vector3::from_fn(|_, _| scale * (2.0 * uniform() - 1.0));
        let translation = vector(0.4);
        let rotation = UnitQuaternion::from_scaled_axis(vector(2.0));
        let axis = vector(1.0);
        let com = vector(0.2);
        // Tensor of a cloud of points: always physical.
        let mut tensor = Matrix3::zeros();
        for _ in 0..4 {
            let r = vector(0.2);
            tensor += 0.5 * (Matrix3::identity() * r.norm_squared() - r * r.transpose());
        }
        let parent = if i == 0 { None } else { Some(((uniform() * i as f64) as usize).max(i.saturating_sub(2))) };
        let kind = if uniform() < 0.7 { JointKind::Revolute } else { JointKind::Prismatic };
        bodies.push(body(
            &format!("joint{i}"),
            parent,
            kind,
            Isometry3::from_parts(Translation3::from(translation), rotation),
            axis,
            Inertia { mass: 0.5 + 2.0 * uniform(), com, tensor },
        ));
    }
    Robot {
        name: "tree".to_owned(),
        gravity: Vector3::new(1.0, -2.0, -9.0),
        drawn: Vec::new(),
        base_shapes: Vec::new(),
        unread_shapes: Vec::new(),
        bodies,
        coupling: None,
    }
}

pub fn no_parameters() -> BTreeMap<String, f64> {
    BTreeMap::new()
}

/// A chain of that many revolute joints with axes in turn vertical and horizontal, lighter towards its end.
pub fn chain(joints: usize) -> Robot {
    let link = |i: usize| {
        let scale = 0.75_f64.powi(i as i32);
        let inertia = Inertia {
            mass: 2.0 * scale,
            com: Vector3::new(0.0, 0.0, 0.1),
            tensor: point_tensor(8e-3 * scale, 8e-3 * scale, 2e-3 * scale),
        };
        let axis = if i.is_multiple_of(2) { Vector3::z() } else { Vector3::y() };
        let parent = i.checked_sub(1);
        body(&format!("joint{i}"), parent, JointKind::Revolute, Isometry3::translation(0.0, 0.0, 0.2), axis, inertia)
    };
    Robot { name: "chain".to_owned(), bodies: (0..joints).map(link).collect(), ..planar_arm() }
}

/// Every joint of a robot with the gear, friction, drive and sensors of the planar arm's second.
pub fn geared(robot: Robot) -> Model {
    let second = scara().joints[1].clone();
    let joints =
        robot.bodies.iter().map(|body| JointModel { name: body.joint.name.clone(), ..second.clone() }).collect();
    model(robot, joints)
}
