//! Time of a whole diagnosis: two joints, 280 s at 1 kHz in four sessions, viscous friction that differs by direction on one joint, or on both.
//!
//! Wanted: 5 s on two cores, with the gaps and with both models replayed beside the session held out.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use divan::Bencher;
use lostmotion::dataset::Session;
use lostmotion::diagnose::{Options, diagnose};
use lostmotion::dynamics::Dynamics;
use lostmotion::replay::{self, compare_models};
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

/// A rigid arm along two sines a joint, encoder counted; the first `uneven` joints have viscous friction that differs by direction.
fn session(model: &Model, number: usize, uneven: usize) -> TimeSeries {
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
            let viscous = if joint < uneven && v[joint] > 0.0 { 0.5 } else { 0.35 };
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

/// Without the gaps: their measurement is a bench of the identification too.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn two_joints_280_s(bencher: Bencher) {
    let model = arm();
    let sessions: Vec<TimeSeries> = (0..4).map(|number| session(&model, number, 1)).collect();
    let options = Options { backlash: false, ..Options::default() };
    bencher.bench(|| diagnose(&model, &sessions[..3], &sessions[3..], &options, &mut |_, _| {}).expect("a diagnosis"));
}

/// All that `lostmotion diagnose` does but for files, with an effect to be found on none, one or both joints.
#[divan::bench(args = [0, 1, 2], sample_count = 5, sample_size = 1)]
fn two_joints_280_s_gaps_and_replay(bencher: Bencher, uneven: usize) {
    let model = arm();
    let sessions: Vec<TimeSeries> = (0..4).map(|number| session(&model, number, uneven)).collect();
    let judged = Session {
        series: sessions[3].clone(),
        notes: Vec::new(),
        source: PathBuf::from("made"),
        controllers: vec![None; model.joints.len()],
    };
    bencher.bench(|| {
        let options = Options::default();
        let found = diagnose(&model, &sessions[..3], &sessions[3..], &options, &mut |_, _| {}).expect("a diagnosis");
        let (nominal, extended) = (&found.baseline_model, &found.extended_model);
        compare_models(nominal, extended, std::slice::from_ref(&judged), &replay::Options::default()).expect("replays")
    });
}
