//! The recording for the Rerun viewer, read back.
#![cfg(feature = "rerun")]

use std::collections::{BTreeMap, BTreeSet};

use lostmotion::report::recording::{Motion, Trace, encode};
use lostmotion::report::{Document, Layer, Mark, Plot, Role, Section, Table};
use lostmotion::robot::{Body, Geometry, Inertia, Joint, Limits, Robot, Shape};
use lostmotion::timeseries::{Channel, Drawn, JointSeries, Samples, TimeSeries};
use lostmotion::units::JointKind;
use nalgebra::{Isometry3, Matrix3, Vector3};
use rerun::external::re_log_encoding::DecoderApp;
use rerun::log::{Chunk, LogMsg};

/// A link of 0.4 m that turns about z.
fn body(name: &str, parent: Option<usize>, reach: f64) -> Body {
    let limits = Limits { lower: -3.0, upper: 3.0, effort: 10.0, velocity: 1.0 };
    Body {
        name: format!("{name}_link"),
        parent,
        joint: Joint {
            name: name.to_owned(),
            kind: JointKind::Revolute,
            origin: Isometry3::translation(reach, 0.0, 0.2),
            axis: Vector3::z_axis(),
            limits,
            damping: 0.0,
            friction: 0.0,
        },
        inertia: Inertia { mass: 1.0, com: Vector3::zeros(), tensor: Matrix3::identity() },
        shapes: vec![Shape {
            link: format!("{name}_link"),
            pose: Isometry3::new(Vector3::new(0.2, 0.0, 0.0), Vector3::y() * std::f64::consts::FRAC_PI_2),
            geometry: Geometry::Capsule(0.05, 0.4),
        }],
    }
}

fn robot() -> Robot {
    let pedestal = Shape {
        link: "base".into(),
        pose: Isometry3::translation(0.0, 0.0, 0.1),
        geometry: Geometry::Cylinder(0.1, 0.2),
    };
    Robot {
        name: "two_links".into(),
        gravity: Vector3::new(0.0, 0.0, -9.81),
        drawn: Vec::new(),
        base_shapes: vec![pedestal],
        unread_shapes: Vec::new(),
        bodies: vec![body("shoulder", None, 0.0), body("elbow", Some(0), 0.4)],
        coupling: None,
    }
}

fn session() -> TimeSeries {
    let time: Vec<f64> = (0..20_000).map(|k| f64::from(k) * 1e-3).collect();
    let series = |f: &dyn Fn(f64) -> f64| time.iter().map(|&t| f(t)).collect::<Samples>();
    let joint = |name: &str, speed: f64| JointSeries {
        name: name.into(),
        channels: BTreeMap::from([
            (Channel::Position, series(&|t| (speed * t).sin())),
            (Channel::Velocity, series(&|t| speed * (speed * t).cos())),
            (Channel::ReferenceVelocity, series(&|t| 0.9 * speed * (speed * t).cos())),
            (Channel::TrueLinkPosition, series(&|t| (speed * t).sin() - 0.004)),
            (Channel::TrueMotorPosition, series(&|t| (speed * t).sin())),
            (Channel::Contact, series(&|t| (speed * t).cos().signum())),
            (Channel::Current, series(&|t| 2.0 * (speed * t).cos())),
            (Channel::GearTorque, series(&|t| 0.4 * (speed * t).cos())),
        ]),
    };
    TimeSeries { name: "made_up".into(), joints: vec![joint("shoulder", 1.0), joint("elbow", 1.7)], time }
}

fn document() -> Document {
    let friction = |v: f64| 0.27 + 0.19 * (-v / 1.5).exp() + 0.0106 * v;
    let curve: Vec<[f64; 2]> = (1..200).map(|k| [0.05 * f64::from(k), friction(0.05 * f64::from(k))]).collect();
    let points: Vec<[f64; 2]> = curve.iter().step_by(10).map(|[v, f]| [*v, f + 0.002]).collect();
    let plot = Plot::new("Friction of shoulder", "velocity [deg/s]", "friction [N·m]")
        .with(Layer::new("measured", Mark::Points, Role::Measured, points))
        .with(Layer::new("fit", Mark::Line, Role::Fit, curve));
    let mut table = Table::new("", &["", "injected", "recovered", "error"]);
    table.row(["F_C", "0.2718", "0.2721", "+0.11 %"]);
    let section = Section { tables: vec![table], plots: vec![plot.clone(), plot], ..Section::new("shoulder") };
    Document {
        title: "two_links".into(),
        verdict: "Friction and backlash recovered.".into(),
        warnings: Vec::new(),
        sections: vec![section],
        in_front: Some("elbow".into()),
    }
}

fn recording() -> Vec<u8> {
    let (robot, session) = (robot(), session());
    let residual = |label, role, size: f64| Trace {
        joint: "elbow".into(),
        panel: "residual",
        label,
        role,
        time: session.time.clone(),
        values: session.time.iter().map(|t| size * (40.0 * t).sin()).collect(),
    };
    let traces = vec![residual("before", Role::Before, 0.02), residual("after", Role::After, 0.004)];
    let bytes = encode(&document(), &[Motion { robot: &robot, session: Drawn::of(&session), obstacles: &[], traces }])
        .unwrap()
        .unwrap();
    if let Some(path) = std::env::var_os("LOSTMOTION_KEEP_RECORDING") {
        std::fs::write(path, &bytes).unwrap();
    }
    bytes
}

#[test]
fn property_recording_holds_arm_traces_plots_and_result() {
    let bytes = recording();
    let paths = |kind: rerun::StoreKind| -> BTreeSet<String> {
        let messages = DecoderApp::decode_lazy(bytes.as_slice()).map(|message| message.expect("a message"));
        let of_kind = messages.filter_map(|message| match message {
            LogMsg::ArrowMsg(store, content) if store.kind() == kind => Some(content),
            _ => None,
        });
        of_kind.map(|content| Chunk::from_arrow_msg(&content).expect("a chunk").entity_path().to_string()).collect()
    };
    let logged = paths(rerun::StoreKind::Recording);
    for expected in [
        "/result",
        "/arm/base/0",
        "/arm/shoulder_link",
        "/arm/elbow_link/0",
        "/joints/shoulder/velocity/reference",
        "/joints/shoulder/velocity/measured",
        "/joints/elbow/current/measured",
        "/joints/elbow/torque/gear",
        "/joints/elbow/contact/flank",
        "/joints/elbow/gap/motor_minus_link",
        "/joints/elbow/residual/before",
        "/joints/elbow/residual/after",
        "/plots/0/layers/0",
        "/plots/1/layers/1",
    ] {
        assert!(logged.contains(expected), "{expected} is missing among {logged:#?}");
    }
    assert!(!logged.contains("/joints/shoulder/residual/before"), "a residual that no one gave");
    let arranged = paths(rerun::StoreKind::Blueprint);
    assert!(arranged.contains("/viewport"), "no layout among {arranged:?}");
    // arm, result, two plots, residual to contact of two joints
    assert!(arranged.iter().filter(|path| path.starts_with("/view/") && !path.contains("ViewContents")).count() >= 12);
}

#[test]
fn property_the_joint_of_the_result_is_in_front() {
    let bytes = recording();
    let messages = DecoderApp::decode_lazy(bytes.as_slice()).map(|message| message.expect("a message"));
    let arranged = messages.filter_map(|message| match message {
        LogMsg::ArrowMsg(store, content) if store.kind() == rerun::StoreKind::Blueprint => Some(content),
        _ => None,
    });
    let chunks: Vec<(String, String)> = arranged
        .map(|content| {
            let path = Chunk::from_arrow_msg(&content).expect("a chunk").entity_path().to_string();
            (path, format!("{:?}", content.batch))
        })
        .collect();
    let named = |name: &str| {
        let has_name = |(path, content): &&(String, String)| {
            path.starts_with("/container/")
                && content.contains("display_name")
                && content.contains(&format!("{name:?}"))
        };
        chunks.iter().find(has_name).map(|(path, _)| path.clone())
    };
    let [tabs, elbow] = ["Joints", "elbow"].map(|name| named(name).expect("a container"));
    let front = chunks.iter().find(|(path, content)| *path == tabs && content.contains("active_tab"));
    let (_, content) = front.expect("a tab in front");
    assert!(content.contains(elbow.trim_start_matches('/')), "{elbow} is not in front: {content}");
}

#[test]
fn property_recordings_stay_small() {
    // 20 s of two joints at 1 kHz are 3 MB as they are; thinned, a run of any length stays below that.
    assert!(recording().len() < 3_000_000);
}
