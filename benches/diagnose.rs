//! Time of a whole diagnosis: two joints, 280 s at 1 kHz in four sessions, viscous friction that differs by direction on one joint.
//!
//! Wanted: 5 s on two cores, gaps not counted (their measurement is a bench of the identification).

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use divan::Bencher;
use lostmotion::diagnose::{Options, diagnose};
use lostmotion::dynamics::Dynamics;
use lostmotion::robot::Model;
use lostmotion::timeseries::{Channel, JointSeries, TimeSeries};

const URDF: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.15 0 0"/><mass value="1.5"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.012" iyz="0" izz="0.012"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.12 0 0"/><mass value="1.0"/><inertia ixx="0.0006" ixy="0" ixz="0" iyy="0.006" iyz="0" izz="0.006"/></inertial></link>
  <joint name="joint1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="3" velocity="3"/></joint>
  <joint name="joint2" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="3" velocity="3"/></joint>
</robot>"#;

fn main() {
    divan::main();
}

fn arm() -> Model {
    let joint = |name: &str| {
        format!(
            "[joints.{name}]\ngear_ratio = 5.0\nrotor_inertia = 0.0008\ngear_stiffness = 3000.0\ngear_damping = 2.0\n\
             [joints.{name}.motor]\ntorque_constant = 0.023\n[joints.{name}.encoder]\ncounts_per_turn = 2000\n"
        )
    };
    let text = format!(
        "schema = \"lostmotion/model/1\"\nname = \"arm\"\nurdf = \"arm.urdf\"\n{}{}",
        joint("joint1"),
        joint("joint2")
    );
    Model::from_texts(&text, URDF, Path::new("model.toml")).expect("a good model")
}

/// A rigid arm along two sines a joint, encoder counted.
fn session(model: &Model, number: usize) -> TimeSeries {
    let mut dynamics = Dynamics::new(&model.robot);
    let mut joints = ["joint1", "joint2"].map(|name| JointSeries { name: name.to_owned(), channels: BTreeMap::new() });
    for k in 0..70_000 {
        let t = f64::from(k) * 1e-3;
        let (mut q, mut v, mut a, mut tau) = ([0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]);
        for joint in 0..2 {
            for (size, f) in [(0.8, 0.05), (0.25, 0.31)] {
                let w = TAU * f * (1.0 + 0.1 * joint as f64 + 0.03 * number as f64);
                let (sin, cos) = (w * t).sin_cos();
                q[joint] += size * sin;
                v[joint] += size * w * cos;
                a[joint] -= size * w * w * sin;
            }
        }
        dynamics.inverse(&q, &v, &a, &mut tau);
        for joint in 0..2 {
            let viscous = if joint == 0 && v[joint] > 0.0 { 0.5 } else { 0.35 };
            let friction = (0.4 + 0.06 * (-v[joint].abs() / 0.05).exp()) * v[joint].signum() + viscous * v[joint];
            let torque = tau[joint] + model.joints[joint].reflected_inertia() * a[joint] + friction;
            let count = model.joints[joint].encoder_step();
            let channels = &mut joints[joint].channels;
            channels.entry(Channel::Position).or_default().push((q[joint] / count).floor() * count);
            channels.entry(Channel::Current).or_default().push(torque / model.joints[joint].torque_per_ampere());
        }
    }
    let time = (0..70_000).map(|k| f64::from(k) * 1e-3).collect();
    TimeSeries { name: format!("session {number}"), time, joints: joints.into() }
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn two_joints_280_s(bencher: Bencher) {
    let model = arm();
    let sessions: Vec<TimeSeries> = (0..4).map(|number| session(&model, number)).collect();
    let options = Options { backlash: false, ..Options::default() };
    bencher.bench(|| diagnose(&model, &sessions[..3], &sessions[3..], &options, &mut |_, _| {}).expect("a diagnosis"));
}
