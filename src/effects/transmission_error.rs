//! The link does not follow the rotor evenly: the teeth have position errors.
//!
//! `q = θ + e sin(z θ + φ)` for a gear without torque, `z` periods per turn of the joint. At a constant rotor speed `ω` the link's velocity
//! ripples by `e z ω` and its acceleration by `e z² ω²`: the torque at tooth order grows with the square of speed. The torque `T` on
//! the link takes `T (1 + e z cos(z θ + φ))` from the rotor, so no work is lost.
//!
//! On the motor's side, with `s = sin(z θ + φ)`: the links need the additional torque `e M s̈`, and the lever of the flank adds `e T ∂s/∂θ`.
//! `T` is as measured: a centre of mass that is off by 3 mm gives a wrist a weight of the size of that of its links.
//! It does not matter whether the motor or the link moves unevenly, because the motor's ripple is measured.
//! Left out: the torque of the ripple on other joints and on friction behind the gear; other harmonics (each is a separate effect);
//! tooth stiffness that varies with the same order.
//! Reference: J. D. Smith (2003), Gear Noise and Vibration; F. H. Ghorbel, P. S. Gandhi, F. Alpeter (2001), On the kinematic error in
//! harmonic drive gears.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::parameters::{misfit, need_joint};
use super::{About, Action, Diagnosable, Effect, GearAction, Harmonic, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::gearhead::Mesh;
use crate::robot::Model;

static ABOUT: About = About {
    name: "transmission_error",
    summary: "The link leads and lags the rotor periodically: the teeth have position errors.",
    equation: "q = θ + e sin(z θ + φ) without torque",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("amplitude", "e", "rad (joint)", "amplitude at the joint").between(0.0, 1.0),
        ParameterSpec::new("teeth", "z", "1", "periods per turn of the joint").between(0.0, 10_000.0),
        ParameterSpec::new("phase", "φ", "rad", "phase at θ = 0").between(-TAU, TAU).or(0.0),
    ],
    signature: "a ripple at tooth order that grows with the square of speed",
    look_alikes: &["cogging", "torque_ripple", "position_dependent_friction"],
    separate_by: "several speeds: the torque of cogging stays, that of the teeth grows with the square of speed",
    reference: "J. D. Smith (2003), Gear Noise and Vibration",
};

/// Smallest number of periods per turn of the joint that is tried: fewer look like gravity.
const LEAST_TEETH: usize = 3;
/// Largest number of periods per turn of the joint that is tried.
const MOST_TEETH: usize = 400;
/// Periods per turn of the motor that are tried whatever their number per turn of the joint: what a shaft or the wave generator of a strain wave gear
/// does once and twice a turn is their largest error (F. H. Ghorbel et al. 2001).
const OF_MOTOR: [f64; 2] = [1.0, 2.0];
/// `e z` [1] Largest ripple of the link's speed relative to the rotor's. The torque is linear in `e` up to terms of `(e z)²`, and gears ripple by a
/// few per cent: harmonic drives by 6 % (0.3 mrad, 200 periods).
const LARGEST_RIPPLE: f64 = 0.3;
/// `z |θ̇| w` above which the gain of the rows' kernel is below one tenth.
const LAST_PASSED: f64 = 5.0;

/// The link leads and lags the rotor periodically.
pub struct TransmissionError;

struct Teeth {
    amplitude: f64,
    teeth: f64,
    phase: f64,
}

impl GearAction for Teeth {
    fn alter(&self, _time: f64, theta: f64, mesh: &mut Mesh) {
        let (sin, cos) = (self.teeth * theta + self.phase).sin_cos();
        mesh.offset += self.amplitude * sin;
        mesh.offset_slope += self.amplitude * self.teeth * cos;
    }

    fn fastest(&self, speed: f64) -> f64 {
        self.teeth * speed
    }
}

impl Effect for TransmissionError {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let (amplitude, teeth) = (given.get("amplitude"), given.get("teeth"));
        if amplitude * teeth >= 1.0 {
            let expected = format!("less than 1/teeth = {:.3e}, or the link would turn back", 1.0 / teeth);
            return Err(misfit(&ABOUT, model, "amplitude", amplitude, expected));
        }
        Ok(vec![Action::Gear(joint, Box::new(Teeth { amplitude, teeth, phase: given.get("phase") }))])
    }
    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

/// Columns of a line at an order [1/turn].
fn columns_at(motion: &Motion, joint: usize, z: f64) -> Vec<Vec<f64>> {
    let m = &motion.joints[joint];
    let added = |row: usize| {
        let [_, curvature] = motion.harmonic_rates(joint, row, z);
        let (sin, cos) = (z * m.q[row]).sin_cos();
        let lever = motion.through_gear(joint, row) * z * motion.gain(joint, row, z);
        [m.link_inertia[row] * curvature[0] - lever * sin, m.link_inertia[row] * curvature[1] + lever * cos]
    };
    let rows: Vec<[f64; 2]> = (0..motion.rows()).map(added).collect();
    [0, 1].map(|k| rows.iter().map(|row| row[k]).collect()).into()
}

/// Periods per turn of the joint that the motor's turns make.
fn of_motor(motion: &Motion, joint: usize) -> [f64; 2] {
    OF_MOTOR.map(|order| order * motion.model.joints[joint].gear_ratio)
}

impl Diagnosable for TransmissionError {
    fn shapes(&self, motion: &Motion, joint: usize) -> Vec<Vec<f64>> {
        let m = &motion.joints[joint];
        let fastest = m.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let narrowest = motion.half_width.iter().copied().fold(f64::INFINITY, f64::min);
        let most = (LAST_PASSED / (fastest * narrowest).max(1e-12)).min(MOST_TEETH as f64) as usize;
        // Periods per turn have no meaning on a sliding joint.
        let turns = motion.model.joints[joint].kind == crate::units::JointKind::Revolute;
        if !turns {
            return Vec::new();
        }
        let of_motor = of_motor(motion, joint).into_iter().filter(|teeth| *teeth >= LEAST_TEETH as f64);
        (LEAST_TEETH..=most).map(|teeth| teeth as f64).chain(of_motor).map(|teeth| vec![teeth]).collect()
    }

    fn refines(&self) -> bool {
        false
    }

    fn is_given(&self, motion: &Motion, joint: usize, shape: &[f64]) -> bool {
        of_motor(motion, joint).iter().any(|teeth| (teeth - shape[0]).abs() < 1e-9 * teeth)
    }

    /// Few periods with a large amplitude imitate an inertia that varies with the angle.
    fn is_itself(&self, _motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> bool {
        coefficients[0].hypot(coefficients[1]) * shape[0] < LARGEST_RIPPLE
    }

    fn harmonic(&self) -> Option<Harmonic> {
        Some(Harmonic { order: |_, _, shape| shape[0], several: true, in_narrow_rows: Some(columns_at) })
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        columns_at(motion, joint, shape[0])
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        // e sin(x + φ) = e sin φ · cos x + e cos φ · sin x
        vec![coefficients[0].hypot(coefficients[1]), shape[0], coefficients[0].atan2(coefficients[1])]
    }
}
