//! Which effects a recording can tell apart, on one joint whose answer is known on paper.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use lostmotion::diagnose::Options;
use lostmotion::diagnose::separability::{Separability, of_recording};
use lostmotion::robot::Model;
use lostmotion::timeseries::{Channel, JointSeries, Samples, TimeSeries};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const URDF: &str = r#"<robot name="arm"><link name="base"/>
  <link name="upper"><inertial><mass value="1.5"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.012" iyz="0" izz="0.012"/></inertial></link>
  <joint name="joint1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="3" velocity="3"/></joint>
</robot>"#;
const MODEL: &str = "schema = \"lostmotion/model/1\"\nname = \"arm\"\nurdf = \"arm.urdf\"\n[joints.joint1]\ngear_ratio = 5.0\n\
    rotor_inertia = 0.0008\ngear_stiffness = 3000.0\ngear_damping = 2.0\nbacklash = 0.0\n[joints.joint1.motor]\ntorque_constant = 0.02\n\
    [joints.joint1.friction]\ncoulomb = 0.4\nbreakaway = 0.4\nstribeck_velocity = 0.05\nviscous = 0.3\n\
    [accuracy]\nmasses = 0.0\ncentres = 0.0\ninertias = 0.0\ntorque_constants = 0.0\nrotor_inertias = 0.0\n";
/// [N·m/A]
const TORQUE_PER_AMPERE: f64 = 0.1;

fn model() -> Model {
    Model::from_texts(MODEL, URDF, Path::new("model.toml")).expect("a good model")
}

/// 60 s of two sines, friction without a falling part, white noise of 30 mA, and a torque that the model lacks.
fn session(lacking: impl Fn(f64, f64, f64) -> f64) -> TimeSeries {
    let noise = Normal::new(0.0, 0.03).expect("a deviation");
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut channels: BTreeMap<Channel, Samples> = BTreeMap::new();
    let time: Vec<f64> = (0..60_000).map(|k| f64::from(k) * 1e-3).collect();
    for t in &time {
        let (mut q, mut v, mut a) = (0.0, 0.0, 0.0);
        for (size, f) in [(0.8, 0.11), (0.25, 0.31)] {
            let (sin, cos) = (TAU * f * t).sin_cos();
            q += size * sin;
            v += size * TAU * f * cos;
            a -= size * (TAU * f).powi(2) * sin;
        }
        let torque = (0.012 + 0.02) * a + 0.4 * v.signum() + 0.3 * v + lacking(q, v, a);
        channels.entry(Channel::Position).or_default().push(q);
        channels.entry(Channel::Current).or_default().push(torque / TORQUE_PER_AMPERE + noise.sample(&mut rng));
    }
    TimeSeries { name: "run".to_owned(), time, joints: vec![JointSeries { name: "joint1".to_owned(), channels }] }
}

fn told(effect: &str, lacking: impl Fn(f64, f64, f64) -> f64) -> Separability {
    told_by(&model(), effect, lacking)
}

fn told_by(model: &Model, effect: &str, lacking: impl Fn(f64, f64, f64) -> f64) -> Separability {
    of_recording(model, &[session(lacking)], &[(effect, vec![0])], &Options::default())
        .expect("a recording")
        .expect("an effect that can be told")
}

fn lost(told: &Separability, rival: &str) -> f64 {
    told.rivals.iter().find(|one| one.effect == rival).expect("a rival").nats
}

/// Information is the square of a torque: twice the amplitude shows and loses four times as much. Error and correlation come from the
/// residual, which is the same noise; what a fit of two coefficients takes of it is below a per cent.
#[test]
fn analytic_information_grows_with_the_square_of_an_effect() {
    let [one, two] = [0.02, 0.04].map(|size| told("cogging", |q, _, _| size * (20.0 * q).cos()));
    let close = |a: f64, b: f64| (b / a - 4.0).abs() < 0.1;
    assert!(close(one.visible, two.visible), "{} {}", one.visible, two.visible);
    let [one, two] = [&one, &two].map(|told| lost(told, "cable_spring"));
    assert!(close(one, two), "{one} {two}");
}

/// Where the law has no falling part an asymmetry of Coulomb friction is a constant torque, but for the 12 ms of a kernel at each of the
/// 60 reversals, within which both directions mix: about a thousandth of the time.
#[test]
fn analytic_a_constant_torque_is_an_asymmetry_of_friction() {
    let told = told("coulomb_asymmetry", |_, _, _| 0.06 * 0.4);
    assert!(told.visible > 1000.0, "{}", told.visible);
    assert!(lost(&told, "current_offset") < 2e-3 * told.visible, "{:?}", told.rivals);
    assert!(lost(&told, "viscous_asymmetry") > 0.1 * told.visible, "{:?}", told.rivals);
    assert!(told.closer_than(2e-3 * told.visible).contains(&"current_offset"));
    assert!(told.least() <= lost(&told, "current_offset"));
}

/// What follows the angle is no matter of speed: they share nothing.
#[test]
fn property_a_ripple_is_not_a_drag() {
    let told = told("cogging", |q, _, _| 0.03 * (20.0 * q).cos());
    assert!(lost(&told, "quadratic_drag") > 0.98 * told.visible, "{:?}", told.rivals);
    assert!(told.rivals.is_sorted_by(|a, b| a.nats <= b.nats));
    assert!(told.rivals.iter().all(|rival| (0.0..=1.0001 * told.visible).contains(&rival.nats)));
}

/// An effect that is not there shows next to nothing, whoever asks for it: a coefficient of noise is worth half a nat, and a shape
/// found among a hundred `ln 100` more.
#[test]
fn property_what_is_not_there_does_not_show() {
    let told = told("cogging", |_, _, _| 0.0);
    assert!(told.visible < 6.0, "{}", told.visible);
}

/// A rotor of 20 g·m² at the joint that is 25 % larger: where the model states it to 10 %, the deviation costs `½ (25/10)²` = 3.1 nats and
/// explains the rest. The coefficient is known to some per cent, so that the bound is to a tenth.
#[test]
fn analytic_what_the_stated_accuracy_allows_does_not_show() {
    let lacking = |_: f64, _: f64, a: f64| 0.25 * 0.02 * a;
    assert!(told("rotor_inertia", lacking).visible > 100.0);
    let mut rough = model();
    rough.accuracy.rotor_inertias = 0.1;
    let visible = told_by(&rough, "rotor_inertia", lacking).visible;
    assert!((visible / 3.125 - 1.0).abs() < 0.1, "{visible}");
    // An effect of another shape shows as before.
    let cogging = |q: f64, _: f64, _: f64| 0.03 * (20.0 * q).cos();
    let [exact, rough] = [&model(), &rough].map(|model| told_by(model, "cogging", cogging).visible);
    assert!((rough / exact - 1.0).abs() < 0.01, "{exact} {rough}");
}
