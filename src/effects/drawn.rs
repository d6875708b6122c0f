//! For tests: a drawn motion of one joint, with an error of its torque that no effect makes, and a line that one does.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{JointMotion, Motion, kernel_gain};
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
            let gain = kernel_gain(order * 45.0 * v * HALF_WIDTH);
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
