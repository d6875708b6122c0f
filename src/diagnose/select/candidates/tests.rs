//! Lines at orders of the motor angle in slow errors: false alarms, and a planted line.

use std::f64::consts::TAU;
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::effects::{CATALOGUE, Catalogue, JointMotion, Motion};
use crate::robot::Model;

pub const ROBOT: &str = "<robot name=\"one\"><link name=\"base\"/><link name=\"arm\"><inertial><mass value=\"1\"/>\
    <inertia ixx=\"0.2\" ixy=\"0\" ixz=\"0\" iyy=\"0.2\" iyz=\"0\" izz=\"0.2\"/></inertial></link>\
    <joint name=\"joint1\" type=\"revolute\"><parent link=\"base\"/><child link=\"arm\"/><axis xyz=\"0 0 1\"/>\
    <limit lower=\"-3\" upper=\"3\" effort=\"30\" velocity=\"9\"/></joint></robot>";
pub const MODEL: &str = "schema = \"lostmotion/model/1\"\nname = \"one\"\nurdf = \"one.urdf\"\n[accuracy]\nmasses = 0\ncentres = 0\n\
    inertias = 0\n[joints.joint1]\ngear_ratio = 45.0\nrotor_inertia = 2e-5\nbacklash = 0.0\n[joints.joint1.motor]\n\
    torque_constant = 0.02\n";

/// [s] Distance of rows, half width of their kernels, and length of the recording.
const STEP: f64 = 0.0036;
const HALF_WIDTH: f64 = 0.006;
pub const LENGTH: f64 = 10.0;
/// [N·m] White noise of the torque.
pub const NOISE: f64 = 0.15;

/// A line of this order and amplitude [N·m] that the rotor feels.
pub type Line = Option<(f64, f64)>;

/// A motion of three drawn waves, and a torque with friction, a slow error of correlation time 0.1 to 0.5 s, white noise, and errors of the
/// model: friction that falls and grows with speed in a way that no baseline contains, a mass, a spring.
pub fn drawn<'m>(model: &'m Model, seed: u64, line: Line, length: f64) -> Motion<'m> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let waves: Vec<[f64; 3]> = (0..3)
        .map(|_| [rng.random_range(0.2..0.7), TAU * rng.random_range(0.15..0.8), rng.random_range(0.0..TAU)])
        .collect();
    let errors: [f64; 4] = std::array::from_fn(|_| rng.random_range(-0.4..0.4));
    let keep: f64 = (-STEP / rng.random_range(0.1..0.5_f64)).exp();
    let slow_size = rng.random_range(0.2..1.0);
    let mut normal = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
    let mut m = JointMotion { has_current: true, ..JointMotion::default() };
    let mut slow = 0.0;
    let rows = (length / STEP) as usize;
    for row in 0..rows {
        let t = row as f64 * STEP;
        let sum =
            |of: &dyn Fn(f64, f64, f64) -> f64| waves.iter().map(|[a, w, phi]| of(*a, *w, w * t + phi)).sum::<f64>();
        let (q, v) = (sum(&|a, _, x| a * x.sin()), sum(&|a, w, x| a * w * x.cos()));
        let a = sum(&|a, w, x| -a * w * w * x.sin());
        slow = keep * slow + (1.0 - keep * keep).sqrt() * slow_size * normal();
        let rigid = 0.25 * a;
        let wrong =
            errors[0] * v.signum() * (-v.abs() / 0.3).exp() + errors[1] * v * v.abs() + errors[2] * a + errors[3] * q;
        let ripple = line.map_or(0.0, |(order, size)| {
            let gain = crate::effects::kernel_gain(order * 45.0 * v * HALF_WIDTH);
            size * gain * (order * 45.0 * q + 0.7).sin()
        });
        m.q.push(q);
        m.v.push(v);
        m.a.push(a);
        m.direction.push(v.signum());
        m.torque.push(rigid + 2.0 * v.signum() + 1.3 * v + wrong + slow + NOISE * normal() - ripple);
        m.torque_rate.push(0.0);
        m.rigid.push(rigid);
        m.link_torque.push(0.2 * a);
        m.link_inertia.push(0.2);
    }
    Motion {
        model,
        sessions: 1,
        session: vec![0; rows],
        part: vec![0; rows],
        start: vec![0.0],
        interval: STEP,
        time: (0..rows).map(|row| row as f64 * STEP).collect(),
        half_width: vec![HALF_WIDTH; rows],
        joints: vec![m],
    }
}

/// Cogging, torque ripple and friction that varies with the angle, judged on a drawn recording.
fn judged(model: &Model, seed: u64, line: Line) -> Vec<Candidate> {
    let motion = drawn(model, seed, line, LENGTH);
    let held_out = vec![false; motion.rows()];
    let mut problem = Problem::new(motion, held_out);
    let names = ["cogging", "torque_ripple", "position_dependent_friction"];
    let lines: Catalogue = CATALOGUE.iter().filter(|effect| names.contains(&effect.about().name)).copied().collect();
    problem.name_from(lines);
    let fitted = problem.settle(&[]).expect("a baseline");
    problem.count_independent(&fitted);
    candidates(&mut problem, &[], &Rules::default())
}

/// The order in periods per motor turn of a candidate.
fn order(candidate: &Candidate) -> f64 {
    let shape = candidate.terms[0].shape[0];
    if candidate.effect().name() == "position_dependent_friction" { shape / 45.0 } else { shape }
}

/// No line is named where there is none. A name needs evidence that chance reaches once in e¹² for each of three effects: once in 50,000
/// recordings. The slow errors are not exactly exponential around their level, so that one false alarm in the 240 draws is accepted: at a rate of
/// one in a thousand, two or more have a probability of 2 %. Waves too slow to be lines are shapes of the stroke, which the errors do contain.
#[test]
fn property_slow_errors_show_no_line() {
    let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
    let mut named = Vec::new();
    for seed in 0..240 {
        let found = judged(&model, seed, None);
        let is_line = |candidate: &&Candidate| candidate.is_accepted(&Rules::default()) && order(candidate) > 0.5;
        named.extend(found.iter().filter(is_line).map(|one| (seed, one.effect().name(), order(one), one.total())));
    }
    assert!(named.len() <= 1, "{} false alarms: {named:?}", named.len());
}

/// A line of 1.5 N·m beside slow errors of up to 1 N·m is found at its order and with the right law on 17 of these 20 recordings, and one
/// of 0.5 N·m on 10. Orders are scanned in rows that are not filtered: where slow errors weigh more than the line there, it is not among
/// the orders that are judged. No other line is named in its place.
#[test]
fn recover_a_line_in_slow_errors() {
    let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
    let first = |size: f64, seed: u64| {
        let found = judged(&model, seed, Some((3.0, size)));
        let mut lines = found.iter().filter(|one| one.is_accepted(&Rules::default()) && order(one) > 0.5);
        lines.next().map(|one| (one.effect().name(), order(one)))
    };
    let right =
        |named: &Option<(&str, f64)>| named.is_some_and(|(name, n)| name == "cogging" && (n - 3.0).abs() < 1e-9);
    for (size, least) in [(0.5, 8), (1.5, 14)] {
        let named: Vec<_> = (1000..1020).map(|seed| first(size, seed)).collect();
        // A rate of 0.5 or 0.85 gives fewer than that in 13 and 2 of a hundred sets of 20.
        assert!(named.iter().filter(|named| right(named)).count() >= least, "{size} N·m: {named:?}");
        assert!(named.iter().flatten().all(|(name, _)| *name == "cogging"), "{size} N·m: {named:?}");
    }
}
