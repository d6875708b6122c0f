//! Parameters of effects and baseline with standard errors: the linear coefficients, the shapes and the Stribeck velocities
//! are perturbed together (delta method), and the autocorrelation of the residual is counted.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::baseline::{COULOMB, FALLING, Falling, VISCOUS};
use super::problem::{Fitted, Part, Problem, Term};
use super::regression::NU;
use super::result::Measured;
use crate::effects::{Motion, SymmetricFriction};

/// Coefficients, shapes and Stribeck velocities with their covariance.
pub struct Uncertainty {
    covariance: DMatrix<f64>,
    /// Position of each joint's Stribeck velocity.
    stribeck_at: Vec<Option<usize>>,
    /// Position of each term's first shape parameter.
    shape_at: Vec<Vec<usize>>,
}

impl Uncertainty {
    /// Covariance of everything at the solution.
    pub fn new(problem: &Problem, terms: &[&Term], fitted: &Fitted) -> Option<Self> {
        let (mut system, _, _) = problem.system(terms, Part::Train, false);
        let mut unknowns = system.unknowns;
        let mut stribeck_at = Vec::new();
        for (joint, baseline) in problem.baseline.iter().enumerate() {
            let falling = fitted.solution.coefficients.get(fitted.baseline_at[joint] + FALLING).copied().unwrap_or(0.0);
            let derivative = baseline.stribeck_derivative(&problem.motion, joint).filter(|_| falling.abs() > 1e-12);
            stribeck_at.push(derivative.map(|column| {
                let rows = problem.rows(joint, Part::Train);
                system.blocks[joint].columns.push((unknowns, rows.iter().map(|row| falling * column[*row]).collect()));
                unknowns += 1;
                unknowns - 1
            }));
        }
        let mut shape_at = Vec::new();
        for (term, at) in terms.iter().zip(&fitted.term_at) {
            let mut positions = Vec::new();
            for index in 0..if term.effect.refines() { term.shape.len() } else { 0 } {
                let step = 1e-4 * term.shape[index].abs().max(1e-6);
                let mut shape = term.shape.clone();
                shape[index] += step;
                let moved = Term::new(&problem.motion, term.effect, &term.joints, shape);
                for (place, joint) in term.joints.iter().enumerate() {
                    let change = |row: &usize| -> f64 {
                        let columns = moved.columns[place].iter().zip(&term.columns[place]).enumerate();
                        columns
                            .map(|(k, (new, old))| {
                                fitted.solution.coefficients[at + k] * (new[*row] - old[*row]) / step
                            })
                            .sum()
                    };
                    let column = problem.rows(*joint, Part::Train).iter().map(change).collect();
                    system.blocks[*joint].columns.push((unknowns, column));
                }
                positions.push(unknowns);
                unknowns += 1;
            }
            shape_at.push(positions);
        }
        system.unknowns = unknowns;
        let mut covariance = system.solve(NU)?.covariance;
        let independence = problem.independence.iter().copied().fold(1.0, f64::min);
        covariance /= independence;
        Some(Self { covariance, stribeck_at, shape_at })
    }

    fn std_error(&self, gradient: &[(usize, f64)]) -> f64 {
        let mut g = DVector::zeros(self.covariance.nrows());
        for (index, slope) in gradient {
            g[*index] += slope;
        }
        (g.transpose() * &self.covariance * &g)[(0, 0)].max(0.0).sqrt()
    }
}

/// Parameters of one term by name, on its first joint.
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
            session: Vec::new(),
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
        let step = 1e-5 * uncertainty.covariance[(position, position)].sqrt().max(1e-12);
        let mut moved = c.clone();
        moved[position] += step;
        slope(position, values(&moved, &term.shape), step);
    }
    for (k, position) in uncertainty.shape_at[index].iter().enumerate() {
        let step = 1e-5 * uncertainty.covariance[(*position, *position)].sqrt().max(1e-12);
        let mut shape = term.shape.clone();
        shape[k] += step;
        slope(*position, values(c, &shape), step);
    }
    let specs = about.parameters.iter().zip(centre).zip(&gradients);
    specs
        .map(|((spec, value), gradient)| {
            let std_error = uncertainty.std_error(gradient);
            (spec.name.to_owned(), Measured { value, std_error, unit: spec.unit_for(kind) })
        })
        .collect()
}

/// A difference of angles may be off by a whole turn; other differences here are tiny.
fn angle_free(difference: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    if (difference.abs() - turn).abs() < 0.1 { difference - turn * difference.signum() } else { difference }
}

/// Friction of the baseline by name.
pub fn friction(
    problem: &Problem,
    joint: usize,
    fitted: &Fitted,
    uncertainty: &Uncertainty,
) -> BTreeMap<&'static str, Measured> {
    let kind = problem.motion.model.joints[joint].kind;
    let (effort, position) = (kind.effort_unit(), kind.position_unit());
    let at = fitted.baseline_at[joint];
    let law = problem.motion.joints[joint].friction;
    let mut friction = BTreeMap::new();
    let mut put = |name, value, gradient: &[(usize, f64)], unit| {
        friction.insert(name, Measured { value, std_error: uncertainty.std_error(gradient), unit });
    };
    put("coulomb", law.coulomb, &[(at + COULOMB, 1.0)], effort);
    let viscous_unit = if position == "rad" { "N·m·s/rad" } else { "N·s/m" };
    put("viscous", law.viscous, &[(at + VISCOUS, 1.0)], viscous_unit);
    match problem.baseline[joint].falling {
        Falling::Free(_) => {
            put("breakaway", law.breakaway, &[(at + COULOMB, 1.0), (at + FALLING, 1.0)], effort);
            let speed_unit = if position == "rad" { "rad/s" } else { "m/s" };
            if let Some(position) = uncertainty.stribeck_at[joint] {
                put("stribeck_velocity", law.stribeck_velocity, &[(position, 1.0)], speed_unit);
            }
        }
        Falling::Given(_) => put("breakaway", law.breakaway, &[(at + COULOMB, 1.0)], effort),
    }
    friction
}

/// Zero of the recorded torque by session.
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
