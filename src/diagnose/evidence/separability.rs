//! Separability: which effects can replace one another on a recording, and the loss of likelihood if they do. It follows from the motion
//! alone and does not depend on the effects that are named.
//!
//! An effect adds the torque `S = Σ c_k column_k` to the measured motion. The baseline and a rival, with its own coefficients and its best
//! shape, can reproduce a part of `S`; the remainder is `S⊥`. In nats of expected log-likelihood it costs
//!
//! ```text
//!   Δ = ½ · (ν + 1)/(ν + 3) · n_eff/n · Σ S⊥²/s²
//! ```
//! `s` is the scale of the error and `n_eff/n` the independent samples per row, both of a fit that contains the effect; `(ν + 1)/(ν + 3)` is the
//! Fisher information of Student's t of unit scale. Only training rows count. Without a rival, `Δ` is the visibility of the effect itself.
//! A rival of one joint may act on every joint, each with its own shape.
//! The nominal model deviates within its stated accuracy beside every rival: a deviation of `z` standard deviations costs `½ z²`. One
//! additional row represents this cost: it is `1/√2` in the column of the deviation and 0 in all other columns. On one joint the deviations
//! are as free as their prior, whatever the other joints show, so that `Δ` is a lower bound for effects of a joint.
//! Left out: two rivals together; effects that are identified by other data than torque against motion: by a joint at rest, by the
//! command, by reversals.
//! Reference: C. R. Rao (1945), Information and the accuracy attainable in the estimation of statistical parameters.

use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use rayon::prelude::*;
use serde::Serialize;

use crate::diagnose::fit::cause::Cause;
use crate::diagnose::fit::golden::golden_section;
use crate::diagnose::fit::inertial::Inertial;
use crate::diagnose::fit::pose::pose;
use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::regression::NU;
use crate::diagnose::fit::term::Term;
use crate::diagnose::options::Options;
use crate::diagnose::rows::division::Division;
use crate::effects::{Diagnosable, Motion, Scope};
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// Approximate number of rows of a joint that are used.
const ROWS: usize = 2500;
/// Number of shapes above which they are evaluated only at the rows that are used.
const MANY_SHAPES: usize = 6;
/// Steps of the golden section between the best scanned shape and its neighbours.
const REFINEMENTS: usize = 12;
/// [1] Least part of a column's power that remains after the projection on the other columns.
const LEAST_LEFT: f64 = 1e-9;

/// How well a recording separates an effect from all others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Separability {
    /// [nats] Visibility of the effect beside the baseline.
    pub visible: f64,
    /// Loss when another effect replaces it, closest rival first.
    pub rivals: Vec<Rival>,
}

/// An effect that replaces another one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rival {
    /// Its name.
    pub effect: &'static str,
    /// [nats] Loss of expected log-likelihood.
    pub nats: f64,
}

impl Separability {
    /// [nats] Loss with the closest rival, or with the baseline alone.
    pub fn least(&self) -> f64 {
        self.rivals.first().map_or(self.visible, |closest| closest.nats.min(self.visible))
    }

    /// Names of the rivals with a loss below `nats`.
    pub fn closer_than(&self, nats: f64) -> Vec<&'static str> {
        self.rivals.iter().filter(|rival| rival.nats < nats).map(|rival| rival.effect).collect()
    }
}

/// How well a recording separates the terms `of` from all other effects, beside the remaining terms.
pub fn separability(problem: &Problem, terms: &[&Term], of: Range<usize>, fitted: &Fitted) -> Separability {
    let (own, beside): (Vec<_>, Vec<_>) = terms.iter().enumerate().partition(|(index, _)| of.contains(index));
    let beside: Vec<&Term> = beside.into_iter().map(|(_, term)| *term).collect();
    let (dof, joints) = (problem.baseline.len(), problem.joints());
    let mut signal = vec![vec![0.0; problem.motion.rows()]; dof];
    for (index, term) in &own {
        for (joint, columns) in term.joints.iter().zip(&term.columns) {
            for (k, column) in columns.iter().enumerate() {
                let c = fitted.solution.coefficients[fitted.term_at[*index] + k];
                signal[*joint].iter_mut().zip(column).for_each(|(sum, x)| *sum += c * x);
            }
        }
    }
    let scale = &fitted.solution.scale;
    let alone: Vec<Field> = joints.iter().map(|joint| Field::new(problem, &[*joint], &beside, scale)).collect();
    let together = Field::new(problem, &joints, &beside, scale);
    let missed: Vec<f64> = alone.iter().map(|field| power(&field.missed(&field.stretched(&signal)))).collect();
    let names: Vec<&str> = own.iter().map(|(_, term)| term.effect.name()).collect();
    let others: Vec<_> = problem.catalogue.diagnosable().filter(|effect| !names.contains(&effect.name())).collect();
    let lost = |effect: &&'static dyn Diagnosable| {
        let applies = |joint: usize| Cause::from(*effect).applies(&problem.motion, joint);
        let best =
            |field: &Field| field.best(*effect, &field.stretched(&signal)).map_or(f64::INFINITY, |best| best.left);
        let nats = match effect.about().scope {
            Scope::Machine if (0..dof).any(applies) => best(&together).min(missed.iter().sum()),
            Scope::Machine => missed.iter().sum(),
            Scope::Joint => joints
                .iter()
                .zip(alone.iter().zip(&missed))
                .map(|(joint, (field, missed))| if applies(*joint) { best(field).min(*missed) } else { *missed })
                .sum(),
        };
        Rival { effect: effect.name(), nats }
    };
    let mut rivals: Vec<Rival> = others.par_iter().map(lost).collect();
    rivals.sort_by(|a, b| a.nats.total_cmp(&b.nats));
    Separability { visible: missed.iter().sum(), rivals }
}

/// How well a recording separates one of the known effects of a machine from others. `present` are their names and joints (all joints for an
/// effect of the machine); the first is the effect in question. `None` where a diagnosis does not identify it by torque against motion.
///
/// # Errors
/// As [`diagnose`](crate::diagnose::diagnose).
pub fn of_recording(
    model: &Model,
    train: &[TimeSeries],
    present: &[(&str, Vec<usize>)],
    options: &Options,
) -> Result<Option<Separability>> {
    let sessions: Vec<&TimeSeries> = train.iter().collect();
    let division = Division::of(&sessions, sessions.len(), 0.0);
    let mut problem = pose(model, &sessions, division, options)?;
    let Some(terms) = present_terms(&mut problem, present) else { return Ok(None) };
    let terms: Vec<&Term> = terms.iter().collect();
    let asked = terms.iter().take_while(|term| term.effect.name() == present[0].0).count();
    let Some(fitted) = problem.fit(&terms, Part::Train, NU) else { return Ok(None) };
    problem.count_independent(&fitted);
    Ok(Some(separability(&problem, &terms, 0..asked, &fitted)))
}

/// Terms of effects that are known to be present, each with its best shape beside the others.
fn present_terms(problem: &mut Problem, present: &[(&str, Vec<usize>)]) -> Option<Vec<Term>> {
    let mut places: Vec<(&'static dyn Diagnosable, Vec<usize>)> = Vec::new();
    for (name, joints) in present {
        let effect = problem.catalogue.find(name)?.diagnosable()?;
        match effect.about().scope {
            Scope::Machine => places.push((effect, problem.joints())),
            Scope::Joint => {
                let axes = |joint: &usize| (effect, Cause::from(effect).axes(&problem.motion, *joint));
                places.extend(joints.iter().map(axes));
            }
        }
    }
    let mut terms: Vec<Term> = Vec::new();
    // First pass: the shape of each effect beside the previous ones; second pass: beside all others.
    for turn in 0..2 {
        for (index, (effect, joints)) in places.iter().enumerate() {
            let beside: Vec<&Term> =
                terms.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, term)| term).collect();
            let fitted = problem.settle(&beside)?;
            let field = Field::new(problem, joints, &beside, &fitted.solution.scale);
            let target: Vec<Vec<f64>> =
                (0..problem.baseline.len()).map(|joint| problem.baseline[joint].target().to_vec()).collect();
            let shape = field.best(*effect, &field.stretched(&target))?.shape;
            let term = Term::new(&problem.motion, *effect, joints, shape);
            // An effect that is identified by other data than torque against motion: by the command, or at reversals.
            if term.coefficients() == 0 {
                return None;
            }
            if turn == 0 { terms.push(term) } else { terms[index] = term }
        }
    }
    problem.settle(&terms.iter().collect::<Vec<_>>())?;
    Some(terms.into_iter().map(|t| Term::new(&problem.motion, t.effect, &t.joints, t.shape)).collect())
}

/// Rows of some joints as one vector, each divided by its error, without the part that the baseline can reproduce.
struct Field<'p, 'm> {
    problem: &'p Problem<'m>,
    joints: Vec<usize>,
    /// Rows of each joint.
    rows: Vec<Vec<usize>>,
    /// The motion at those rows, for each joint.
    motions: Vec<Motion<'m>>,
    /// Factor from the torque of a joint to the square root of nats.
    factor: Vec<f64>,
    /// Number of deviations of the nominal model, each with one row for its cost.
    deviations: usize,
    basis: Vec<Vec<f64>>,
}

/// The best result of an effect.
struct Best {
    shape: Vec<f64>,
    /// [nats]
    left: f64,
}

impl<'p, 'm> Field<'p, 'm> {
    fn new(problem: &'p Problem<'m>, joints: &[usize], beside: &[&Term], scale: &[f64]) -> Self {
        let (mut rows, mut factor) = (Vec::new(), Vec::new());
        for joint in joints {
            let all = problem.rows(*joint, Part::Train);
            let stride = all.len().div_ceil(ROWS).max(1);
            let information = (NU + 1.0) / (NU + 3.0) * problem.independence[*joint] * stride as f64;
            factor.push((0.5 * information).sqrt() / scale[*joint]);
            rows.push(all.into_iter().step_by(stride).collect::<Vec<_>>());
        }
        let motions = rows.iter().map(|rows| problem.motion.at_rows(rows)).collect();
        let deviations = problem.inertial.as_ref().map_or(0, Inertial::count);
        let mut field = Self { problem, joints: joints.to_vec(), rows, motions, factor, deviations, basis: Vec::new() };
        for (place, joint) in joints.iter().enumerate() {
            let baseline = &problem.baseline[*joint];
            for column in baseline.columns().iter().chain(baseline.stribeck_derivative()) {
                let mut only = vec![Vec::new(); joints.len()];
                only[place] = field.picked(place, column);
                field.take_out(&field.joined(&only));
            }
        }
        for term in beside {
            for k in 0..term.coefficients() {
                let of_joint = |(place, joint): (usize, &usize)| {
                    let at = term.joints.iter().position(|other| other == joint);
                    at.map_or(Vec::new(), |at| field.picked(place, &term.columns[at][k]))
                };
                let parts: Vec<Vec<f64>> = joints.iter().enumerate().map(of_joint).collect();
                field.take_out(&field.joined(&parts));
            }
        }
        field.deviate();
        field
    }

    /// Takes out what deviations of the nominal model can reproduce at the cost of their prior.
    fn deviate(&mut self) {
        let Some(inertial) = &self.problem.inertial else { return };
        for k in 0..self.deviations {
            let of_joint = |(place, joint): (usize, &usize)| self.picked(place, &inertial.columns[*joint][k]);
            let parts: Vec<Vec<f64>> = self.joints.iter().enumerate().map(of_joint).collect();
            let mut column = self.joined(&parts);
            let cost = column.len() - self.deviations + k;
            column[cost] = FRAC_1_SQRT_2;
            self.take_out(&column);
        }
    }

    fn picked(&self, place: usize, column: &[f64]) -> Vec<f64> {
        self.rows[place].iter().map(|row| column[*row]).collect()
    }

    /// One vector from one part per joint, each divided by its error; a missing part and the rows of the deviations are zero.
    fn joined(&self, parts: &[Vec<f64>]) -> Vec<f64> {
        let mut all = Vec::new();
        for ((part, rows), factor) in parts.iter().zip(&self.rows).zip(&self.factor) {
            all.extend((0..rows.len()).map(|row| part.get(row).map_or(0.0, |value| factor * value)));
        }
        all.resize(all.len() + self.deviations, 0.0);
        all
    }

    /// Torques of all joints and rows as one such vector.
    fn stretched(&self, torque: &[Vec<f64>]) -> Vec<f64> {
        let parts: Vec<Vec<f64>> =
            self.joints.iter().enumerate().map(|(place, joint)| self.picked(place, &torque[*joint])).collect();
        self.joined(&parts)
    }

    /// Adds a direction that the baseline can reproduce.
    fn take_out(&mut self, column: &[f64]) {
        if let Some(direction) = without(column.to_vec(), &self.basis) {
            self.basis.push(direction);
        }
    }

    /// The part of a vector that the baseline cannot reproduce.
    fn missed(&self, vector: &[f64]) -> Vec<f64> {
        let mut left = vector.to_vec();
        self.basis.iter().for_each(|direction| subtract(&mut left, direction));
        left
    }

    /// [nats] Remainder of a vector (without the baseline's part) after a fit of an effect with this shape.
    fn left(&self, effect: &'static dyn Diagnosable, shape: &[f64], many: bool, missed: &[f64]) -> f64 {
        let cause = Cause::from(effect);
        let of_joint = |place: usize| -> Vec<Vec<f64>> {
            if many {
                return cause.columns_at(&self.motions[place], &self.joints, place, shape);
            }
            let columns = cause.columns_at(&self.problem.motion, &self.joints, place, shape);
            columns.iter().map(|column| self.picked(place, column)).collect()
        };
        let columns: Vec<Vec<Vec<f64>>> = (0..self.joints.len()).map(of_joint).collect();
        let mut left = missed.to_vec();
        let mut own: Vec<Vec<f64>> = Vec::new();
        for k in 0..columns.first().map_or(0, Vec::len) {
            let parts: Vec<Vec<f64>> = columns.iter().map(|of_joint| of_joint[k].clone()).collect();
            let Some(column) = without(self.joined(&parts), &self.basis) else { continue };
            if let Some(direction) = without(column, &own) {
                subtract(&mut left, &direction);
                own.push(direction);
            }
        }
        power(&left)
    }

    /// The shape of an effect with the smallest remainder of a vector; `None` where the effect has no shape.
    fn best(&self, effect: &'static dyn Diagnosable, vector: &[f64]) -> Option<Best> {
        let missed = self.missed(vector);
        let shapes = effect.shapes(&self.problem.motion, self.joints[0]);
        let many = shapes.len() > MANY_SHAPES;
        let left = |shape: &[f64]| self.left(effect, shape, many, &missed);
        let tried: Vec<f64> = shapes.iter().map(|shape| left(shape)).collect();
        let at = (0..shapes.len()).min_by(|a, b| tried[*a].total_cmp(&tried[*b]))?;
        let mut best = Best { shape: shapes[at].clone(), left: tried[at] };
        if !effect.refines() || best.shape.len() != 1 || shapes.len() < 2 {
            return Some(best);
        }
        let ends = [shapes[at.saturating_sub(1)][0], shapes[(at + 1).min(shapes.len() - 1)][0]];
        let mut steps = 0..=REFINEMENTS;
        golden_section(
            ends,
            |_, _| steps.next().is_none(),
            |value| {
                let left = left(&[value]);
                if left < best.left {
                    best = Best { shape: vec![value], left };
                }
                -left
            },
        );
        Some(best)
    }
}

/// The part of a vector orthogonal to some orthonormal directions, scaled to unit length; `None` where nothing remains.
fn without(mut vector: Vec<f64>, directions: &[Vec<f64>]) -> Option<Vec<f64>> {
    let before = power(&vector);
    // Two passes are enough for orthogonality to the last digit (W. Kahan).
    for _ in 0..2 {
        directions.iter().for_each(|direction| subtract(&mut vector, direction));
    }
    let after = power(&vector);
    if after.is_nan() || after <= LEAST_LEFT * before {
        return None;
    }
    let size = after.sqrt();
    vector.iter_mut().for_each(|x| *x /= size);
    Some(vector)
}

/// Subtracts the part along a direction of unit length from a vector.
fn subtract(vector: &mut [f64], direction: &[f64]) {
    let along: f64 = vector.iter().zip(direction).map(|(x, d)| x * d).sum();
    vector.iter_mut().zip(direction).for_each(|(x, d)| *x -= along * d);
}

fn power(vector: &[f64]) -> f64 {
    vector.iter().map(|x| x * x).sum()
}
