//! A first model of a robot file that can be simulated. Its rotors and gears are guesses, which the model file has as comments.
//!
//! ```text
//!   M(0) = L D Lᵀ                         D_i: inertia of joint i while the joints before it are free
//!   k = max(ω² M, F/θ)                    M, F: largest inertia and load at the joint in drawn postures;  ω = 2π · 15 Hz
//!   J = max(0.3 M, F/(θ ω²))              rotor at the joint, where the file gives none
//!   F = G + F_C + c v                     weight, and friction and damping that the file states, at a common speed
//!   k ≤ ω_max²/A,  d = 2 ζ √(k/A)         A = 1/J + W: rotor against link, W the acceleration of the link per torque
//! ```
//! `M(0)` is positive definite if each `D_i > 0`. Links without an inertia do no harm within a chain whose last link has one. Three axes
//! that intersect and carry a point mass make `M(0)` singular: no inertia resists a rotation about the line through the mass. The last of
//! such joints is held.
//!
//! `ω`: gear manufacturers require a resonance of the load on its gear, the rotor held, of at least 8 Hz for base axes of robots, and
//! 15 Hz for their hand axes, SCARA and welding robots. The posture of the largest inertia has 15 Hz here, all others more.
//! `θ`: a gear yields by some 5 mrad under its peak torque; here by twice that under its load. This decides where links are light
//! compared with the load, as in fingers; a rotor that is sized for such a gear is as heavy, relative to the gear, as other rotors.
//! `0.3`: matched inertias (`J = M`) accelerate fastest, and drives are commonly built with loads of up to ten times the rotor; this is the geometric
//! mean of 1 and 0.1.
//! References: Harmonic Drive AG, Engineering Data HFUS-2A (2014), torsional stiffness, and selection by the resonance frequency of the output side.
//! K. Pasch, W. Seering (1984), On the drive systems for high-performance machines.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::path::Path;

use nalgebra::DMatrix;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Plant;
use crate::dynamics::Dynamics;
use crate::error::Result;
use crate::robot::{First, Limits, Model, Robot, USUAL_RESONANCE, two_digits};
use crate::units::JointKind;

/// [1] Least `D_i` as a share of `M_ii`. Rounding leaves some 1e-15 where it is zero; joints of real arms keep more than 1e-4.
const LEAST_SHARE: f64 = 1e-9;

/// `ω` [rad/s] Resonance of the largest inertia at a joint on its gear, the rotor held.
const OMEGA: f64 = USUAL_RESONANCE;

/// `ω_max` [rad/s] Fastest rotor against its link: 3 kHz, 25 µs a step.
const OMEGA_MAX: f64 = TAU * 3000.0;

/// `ζ` [1] Damping ratio of a rotor against its link: assumed, as of greased gears of steel.
const ZETA: f64 = 0.2;

/// `θ` [rad or m] How far a gear yields under weight and friction.
const fn yielding(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => 0.01,
        JointKind::Prismatic => 0.001,
    }
}

/// [1] Inertia of a rotor at the joint as a share of the largest inertia that the joint carries.
const ROTOR_SHARE: f64 = 0.3;

/// [kg·m²] Smallest rotor inertia: that of a motor of 6 mm.
const LEAST_ROTOR: f64 = 1e-9;

/// [kg·m²] Largest rotor inertia: that of a wind turbine.
const MOST_ROTOR: f64 = 1e6;

/// [N·m/rad or N/m] Smallest stiffness in a model file, whatever load the gear carries.
const LEAST_STIFFNESS: f64 = 1e-12;
/// [N·m/rad or N/m] Largest stiffness in a model file.
const MOST_STIFFNESS: f64 = 1e10;

/// [1] Accuracy of a placeholder, one standard deviation as a share of its value: half or three times of it would be no surprise.
const GUESSED: f64 = 1.0;

/// Number of postures in which inertias are computed; a placeholder of two digits needs no more.
const POSTURES: usize = 64;

/// [rad/s or m/s] Speed at which a joint works against the damping that the file states.
const fn common_speed(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => 1.0,
        JointKind::Prismatic => 0.2,
    }
}

/// A model of every joint that turns or slides and has an inertia to move, with gears and drives of common size where the file gives
/// none. A gear that no simulation can follow is left unknown and counts as rigid.
///
/// # Errors
/// The file cannot be read, or is refused as in [`Model::load`].
pub fn first_model(file: &Path) -> Result<First> {
    let mut held = BTreeMap::new();
    let mut first = First::of(file, &held)?;
    while let Some(joint) = without_inertia(&first.model) {
        let reason = "no inertia resists it while the joints before it are free, and it is held at zero; give the links behind it \
                      an inertia tensor if it is to move";
        held.insert(first.model.joints[joint].name.clone(), reason.to_owned());
        first = First::of(file, &held)?;
    }
    complete(&mut first);
    // Each pass removes the stiffness of one gear.
    while let Some(joint) = Plant::too_fast(&first.model)? {
        let own = &mut first.model.joints[joint];
        if own.gear_stiffness.is_none() {
            break;
        }
        (own.gear_stiffness, own.gear_damping) = (None, None);
    }
    Ok(first)
}

/// Gives every joint a rotor and a gear where the file gives none.
fn complete(first: &mut First) {
    let First { model, placeholders } = first;
    let loads = largest_loads(&model.robot);
    let n = model.joints.len();
    let mut mass = DMatrix::zeros(n, n);
    Dynamics::new(&model.robot).mass_matrix(&vec![0.0; n], &mut mass);
    let mobility = mass.cholesky().map(|cholesky| cholesky.inverse());
    for (i, joint) in model.joints.iter_mut().enumerate() {
        let name = joint.name.clone();
        let link = &model.robot.bodies[i].joint;
        let Load { inertia, weight } = loads[i];
        let speed = common_speed(link.kind).min(link.limits.velocity);
        let under_load = (weight + link.friction + link.damping * speed) / yielding(link.kind);
        let stiffness = (OMEGA * OMEGA * inertia).max(under_load);
        let squared = joint.gear_ratio * joint.gear_ratio;
        joint.rotor_inertia.get_or_insert_with(|| {
            placeholders.guess(&name, "rotor_inertia");
            let at_joint = (ROTOR_SHARE * inertia).max(under_load / (OMEGA * OMEGA));
            two_digits((at_joint / squared).clamp(LEAST_ROTOR, MOST_ROTOR))
        });
        let a = 1.0 / joint.reflected_inertia() + mobility.as_ref().map_or(0.0, |w| w[(i, i)]);
        let stiffness = two_digits(stiffness.min(OMEGA_MAX * OMEGA_MAX / a).clamp(LEAST_STIFFNESS, MOST_STIFFNESS));
        joint.gear_stiffness = Some(stiffness);
        joint.gear_damping = Some(two_digits(2.0 * ZETA * (stiffness / a).sqrt()));
        placeholders.guess(&name, "gear_stiffness");
        placeholders.guess(&name, "gear_damping");
    }
    state_accuracy(first);
}

/// States how well placeholders are known, so that no diagnosis takes their errors for a cause. Guesses are left out of the model file.
fn state_accuracy(First { model, placeholders }: &mut First) {
    if model.joints.iter().any(|joint| placeholders.marks(&joint.name, "motor.torque_constant")) {
        model.accuracy.torque_constants = GUESSED;
        placeholders.mark_accuracy("torque_constants");
    }
}

/// The largest load of a joint.
#[derive(Debug, Clone, Copy, Default)]
struct Load {
    /// [kg·m² or kg]
    inertia: f64,
    /// [N·m or N]
    weight: f64,
}

/// The largest inertia and weight that each joint carries in postures drawn within its limits, all joints at zero among them.
fn largest_loads(robot: &Robot) -> Vec<Load> {
    let n = robot.dof();
    let mut dynamics = Dynamics::new(robot);
    let (mut mass, mut weight) = (DMatrix::zeros(n, n), vec![0.0; n]);
    let mut largest = vec![Load::default(); n];
    let mut posture = vec![0.0; n];
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..POSTURES {
        dynamics.mass_matrix(&posture, &mut mass);
        dynamics.gravity(&posture, &mut weight);
        for (i, largest) in largest.iter_mut().enumerate() {
            largest.inertia = largest.inertia.max(mass[(i, i)]);
            largest.weight = largest.weight.max(weight[i].abs());
        }
        for (q, body) in posture.iter_mut().zip(&robot.bodies) {
            let [low, high] = room(body.joint.kind, body.joint.limits);
            *q = low + (high - low) * rng.random::<f64>();
        }
    }
    largest
}

/// [rad or m] Range of a joint: that of the file where it has both ends, else a turn, or half a metre.
fn room(kind: JointKind, limits: Limits) -> [f64; 2] {
    let half = match kind {
        JointKind::Revolute => PI,
        JointKind::Prismatic => 0.25,
    };
    let Limits { lower, upper, .. } = limits;
    if lower.is_finite() && upper.is_finite() { [lower, upper] } else { [lower.max(-half), upper.min(half)] }
}

/// The first joint `i` with `D_i = 0`.
fn without_inertia(model: &Model) -> Option<usize> {
    let n = model.joints.len();
    let mut d = DMatrix::zeros(n, n);
    Dynamics::new(&model.robot).mass_matrix(&vec![0.0; n], &mut d);
    let diagonal = d.diagonal();
    for i in 0..n {
        if d[(i, i)] <= LEAST_SHARE * diagonal[i] {
            return Some(i);
        }
        for row in i + 1..n {
            let share = d[(row, i)] / d[(i, i)];
            for column in i + 1..n {
                d[(row, column)] -= share * d[(i, column)];
            }
        }
    }
    None
}
