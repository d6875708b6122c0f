//! Parameters of effects and baseline with standard errors: the linear coefficients, the shapes and the Stribeck velocities
//! are perturbed together (delta method) in the covariance of [`Uncertainty`].

use std::collections::BTreeMap;

use nalgebra::DVector;

use super::baseline::{COULOMB, FALLING, Falling, VISCOUS};
use super::problem::{Fitted, Problem};
use super::term::Term;
use super::uncertainty::{SYSTEMATIC, Uncertainty};
use crate::diagnose::result::Measured;
use crate::effects::{Motion, SymmetricFriction};

/// [1] Multiple of the largest torque or speed of a joint from which the error of a parameter says that the data do not determine it.
const UNDETERMINED: f64 = 10.0;

/// Parameters of one term by name, for its first joint.
pub fn parameters(
    problem: &Problem,
    term: &Term,
    index: usize,
    fitted: &Fitted,
    uncertainty: &Uncertainty,
) -> BTreeMap<String, Measured> {
    let about = term.effect.about();
    let joint = term.joints[0];
    let kind = problem.motion.model.joints[joint].kind;
    let baseline = &problem.baseline[joint];
    let at = fitted.term_at[index];
    let friction_at = fitted.baseline_at[joint];
    let probe = |friction: SymmetricFriction| -> Motion {
        let mut joints =
            problem.motion.joints.iter().map(|_| crate::effects::JointMotion::default()).collect::<Vec<_>>();
        joints[joint].friction = friction;
        Motion {
            model: problem.motion.model,
            sessions: problem.motion.sessions,
            start: Vec::new(),
            interval: problem.motion.interval,
            session: Vec::new(),
            part: Vec::new(),
            time: Vec::new(),
            half_width: Vec::new(),
            joints,
        }
    };
    let values = |c: &DVector<f64>, shape: &[f64]| -> Vec<f64> {
        let own: Vec<f64> = (0..baseline.len()).map(|k| c[friction_at + k]).collect();
        let coefficients: Vec<f64> = (0..term.coefficients()).map(|k| c[at + k]).collect();
        term.effect.parameters(&probe(baseline.friction(&own)), joint, shape, &coefficients)
    };
    let c = &fitted.solution.coefficients;
    let centre = values(c, &term.shape);
    let mut gradients = vec![Vec::new(); centre.len()];
    let mut slope = |position: usize, moved: Vec<f64>, step: f64| {
        for (gradient, (new, old)) in gradients.iter_mut().zip(moved.iter().zip(&centre)) {
            gradient.push((position, angle_free(new - old) / step));
        }
    };
    for position in (at..at + term.coefficients()).chain(friction_at..friction_at + baseline.len()) {
        let step = 1e-5 * uncertainty.spread(position);
        let mut moved = c.clone();
        moved[position] += step;
        slope(position, values(&moved, &term.shape), step);
    }
    for (k, position) in uncertainty.shape_at[index].iter().enumerate() {
        let step = 1e-5 * uncertainty.spread(*position);
        let mut shape = term.shape.clone();
        shape[k] += step;
        slope(*position, values(c, &shape), step);
    }
    let specs = about.parameters.iter().zip(centre).zip(&gradients);
    specs
        .map(|((spec, value), gradient)| {
            let std_error = uncertainty.std_error(gradient).hypot(uncertainty.systematic(index, gradient));
            (spec.name.to_owned(), Measured { value, std_error, unit: spec.unit_for(kind) })
        })
        // Leave out parameters of another form of the effect, which were not fitted.
        .filter(|(_, measured)| measured.value != 0.0 || measured.std_error != 0.0)
        .collect()
}

/// Largest magnitude of a signal.
fn largest(signal: &[f64]) -> f64 {
    signal.iter().fold(f64::MIN_POSITIVE, |most, value| most.max(value.abs()))
}

/// Reduces a difference of angles by a whole turn where needed; other differences here are tiny.
fn angle_free(difference: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    if (difference.abs() - turn).abs() < 0.1 { difference - turn * difference.signum() } else { difference }
}

/// Friction of the baseline by parameter name.
pub fn friction(
    problem: &Problem,
    joint: usize,
    fitted: &Fitted,
    uncertainty: &Uncertainty,
) -> BTreeMap<&'static str, Measured> {
    let kind = problem.motion.model.joints[joint].kind;
    let effort = kind.effort_unit();
    let at = fitted.baseline_at[joint];
    let law = problem.motion.joints[joint].friction;
    let mut friction = BTreeMap::new();
    let motion = &problem.motion.joints[joint];
    let [torque, speed] = [&motion.torque, &motion.v].map(|signal| largest(signal));
    // A parameter that the data do not determine has no error, or one beyond all that was recorded: it is left out, so that it does not look exact.
    let mut put = |name, value: f64, gradient: &[(usize, f64)], unit, scale: f64| {
        let statistical = uncertainty.std_error(gradient);
        if statistical > 0.0 && statistical < UNDETERMINED * scale {
            friction.insert(name, Measured { value, std_error: statistical.hypot(SYSTEMATIC * value), unit });
        }
    };
    put("coulomb", law.coulomb, &[(at + COULOMB, 1.0)], effort, torque);
    put("viscous", law.viscous, &[(at + VISCOUS, 1.0)], kind.damping_unit(), torque / speed);
    match problem.baseline[joint].falling() {
        Falling::Free(_) => {
            put("breakaway", law.breakaway, &[(at + COULOMB, 1.0), (at + FALLING, 1.0)], effort, torque);
            if let Some(position) = uncertainty.stribeck_at[joint] {
                put("stribeck_velocity", law.stribeck_velocity, &[(position, 1.0)], kind.velocity_unit(), speed);
            }
        }
        Falling::Given(_) => put("breakaway", law.breakaway, &[(at + COULOMB, 1.0)], effort, torque),
    }
    friction
}

/// Inertia of the rotor at the motor shaft, where the model file gives none; `None` if the fit gives none above zero.
pub fn rotor_inertia(problem: &Problem, joint: usize, fitted: &Fitted, uncertainty: &Uncertainty) -> Option<Measured> {
    let squared = problem.motion.model.joints[joint].gear_ratio.powi(2);
    let at = fitted.baseline_at[joint] + problem.baseline[joint].rotor_at()?;
    let value = problem.rotors(fitted)[joint]?;
    let std_error = (uncertainty.std_error(&[(at, 1.0)]) / squared).hypot(SYSTEMATIC * value);
    Some(Measured { value, std_error, unit: "kg·m²" })
}

/// Offset of the recorded torque by session.
pub fn offsets(
    problem: &Problem,
    joint: usize,
    fitted: &Fitted,
    uncertainty: &Uncertainty,
    sessions: &[&crate::timeseries::TimeSeries],
) -> BTreeMap<String, Measured> {
    let baseline = &problem.baseline[joint];
    let first = fitted.baseline_at[joint] + baseline.len() - baseline.offset_sessions.len();
    let unit = problem.motion.model.joints[joint].kind.effort_unit();
    let offset = |(k, session): (usize, &usize)| {
        let (value, std_error) = (fitted.solution.coefficients[first + k], uncertainty.std_error(&[(first + k, 1.0)]));
        (sessions[*session].name.clone(), Measured { value, std_error, unit })
    };
    baseline.offset_sessions.iter().enumerate().map(offset).collect()
}
