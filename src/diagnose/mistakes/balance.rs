//! The torque balance of a recording under a nominal model that may be a good deal off:
//!
//! ```text
//!   τ = α I(q, v, a) + γ G(q) + δ₁ G₁(q) + δ₂ G₂(q) + Σ μ_k P_k(q, v, a) + F_C sgn v + F_V v + k q + c
//! ```
//! `I`: inertia of links and rotor with their velocity terms; `G`: weight; `G₁ G₂`: weight with gravity across its nominal direction,
//! for a base that is not level; `P_k`: 1 kg at six points around the last body's centre of mass, for a payload; then friction, a spring, an offset. Every
//! coefficient has the bounds of what is physics: friction takes energy out of the motion (`F_C, F_V ≥ 0`), a spring pulls back,
//! masses are positive and known within a factor. What the balance leaves under these bounds, as a share of the torque's square, is small
//! where the data and the model are what they say they are, whatever effect is at work; an exchanged sign makes it one or more.

#![allow(clippy::needless_range_loop, reason = "rows and columns of a matrix are visited by one index")]

use nalgebra::{DMatrix, Vector3};
use rayon::prelude::*;

use crate::dynamics::Dynamics;
use crate::robot::{Inertia, JointModel, Masses, Model, STANDARD_GRAVITY};

use super::rows::Rows;

/// Number of columns.
const COLUMNS: usize = 14;
/// Columns of the rigid body.
const RIGID: usize = 10;
/// Factor by which inertia and weight may differ from the model's: what accuracy (20 % of masses, 10 % of torque constants), effects and a
/// kernel that is too wide leave of 1, with a margin of 2.
pub const MODEL_FACTOR: f64 = 2.5;
/// [1] Part of gravity across its nominal direction: a base that leans by 17°.
const ACROSS: f64 = 0.3;
/// Payload at each of its points at most, in masses of the machine.
const PAYLOAD: f64 = 0.1;
/// [m] Distance of those points from the last body's centre of mass.
const AWAY: f64 = 0.15;
/// Rows that a joint needs in each direction of motion.
pub const FEWEST_ROWS: usize = 25;
/// Sweeps of the coordinate descent.
const SWEEPS: usize = 400;

/// What the balance of one joint leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balance {
    /// `Σ residual² / Σ τ²`.
    pub left: f64,
    /// Part of `Σ τ²` that inertia alone makes, and weight alone, at their nominal size.
    pub parts: [f64; 2],
    /// Factor of the torque that inertia and weight ask for, were their size free.
    pub free: f64,
    /// `α γ δ₁ δ₂ μ₁ … μ₆ F_C F_V k c`.
    pub coefficients: [f64; COLUMNS],
}

impl Balance {
    /// How far the coefficients of inertia and weight are from one, `|ln α|` and `|ln γ|`, as far as these matter.
    pub fn oddness(&self) -> f64 {
        let of = |k: usize| self.coefficients[k].max(1e-9).ln().abs() * (10.0 * self.parts[k]).min(1.0);
        of(0) + of(1)
    }

    /// Factor of the torque at which the model's rigid body would fit, where that lies outside of what its accuracy allows.
    pub fn needed_scale(&self) -> Option<f64> {
        (self.free > 0.0 && self.free.is_finite()).then(|| 1.0 / self.free).filter(|f| f.ln().abs() > MODEL_FACTOR.ln())
    }
}

/// The machine prepared for the columns of one session.
struct Machine {
    links: Dynamics,
    weight: Dynamics,
    /// Nominal gravity and two directions across it.
    gravity: [Vector3<f64>; 3],
    /// The ten numbers of 1 kg at each point of the payload.
    points: [[f64; 10]; 6],
    regressor: DMatrix<f64>,
    rotors: Vec<f64>,
}

impl Machine {
    fn new(model: &Model, session: &str) -> Self {
        let robot = model.in_session(session).robot;
        let nominal = robot.gravity;
        let strength = if nominal.norm() > 0.0 { nominal.norm() } else { STANDARD_GRAVITY.norm() };
        let along = if nominal.norm() > 0.0 { nominal / strength } else { -Vector3::z() };
        let side = if along.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        let first = along.cross(&side).normalize();
        let second = along.cross(&first);
        let mut links = Dynamics::new(&robot);
        links.set_gravity(Vector3::zeros());
        let centre = robot.bodies.last().map_or(Vector3::zeros(), |body| body.inertia.com);
        let point = |k: usize| {
            let mut com = centre;
            com[k / 2] += if k.is_multiple_of(2) { AWAY } else { -AWAY };
            Inertia { mass: 1.0, com, ..Inertia::zero() }.parameters()
        };
        Self {
            weight: Dynamics::new(&robot),
            links,
            gravity: [nominal, first * strength, second * strength],
            points: std::array::from_fn(point),
            regressor: DMatrix::zeros(robot.dof(), 10 * robot.dof()),
            rotors: model.joints.iter().map(JointModel::reflected_inertia).collect(),
        }
    }

    /// `I G G₁ G₂ P₁ … P₆` of every joint.
    fn columns(&mut self, q: &[f64], v: &[f64], a: &[f64], out: &mut [[f64; RIGID]]) {
        let mut tau = vec![0.0; q.len()];
        self.links.inverse(q, v, a, &mut tau);
        for (joint, out) in out.iter_mut().enumerate() {
            out[0] = tau[joint] + self.rotors[joint] * a[joint];
        }
        for (k, gravity) in self.gravity.into_iter().enumerate() {
            self.weight.set_gravity(gravity);
            self.weight.gravity(q, &mut tau);
            out.iter_mut().zip(&tau).for_each(|(out, tau)| out[1 + k] = *tau);
        }
        self.weight.set_gravity(self.gravity[0]);
        self.weight.regressor(q, v, a, &mut self.regressor);
        let last = 10 * (q.len() - 1);
        for (joint, out) in out.iter_mut().enumerate() {
            for (k, point) in self.points.iter().enumerate() {
                out[4 + k] = (0..10).map(|i| self.regressor[(joint, last + i)] * point[i]).sum();
            }
        }
    }
}

/// Normal equations of the rows of one joint.
#[derive(Debug, Clone)]
pub struct Normal {
    a: [[f64; COLUMNS]; COLUMNS],
    b: [f64; COLUMNS],
    power: f64,
    rows: [usize; 2],
}

impl Normal {
    const fn new() -> Self {
        Self { a: [[0.0; COLUMNS]; COLUMNS], b: [0.0; COLUMNS], power: 0.0, rows: [0; 2] }
    }

    fn add(&mut self, columns: &[f64; COLUMNS], y: f64, forwards: bool) {
        for i in 0..COLUMNS {
            for j in 0..COLUMNS {
                self.a[i][j] += columns[i] * columns[j];
            }
            self.b[i] += columns[i] * y;
        }
        self.power += y * y;
        self.rows[usize::from(forwards)] += 1;
    }

    /// Those of two parts of the rows.
    fn joined(mut self, other: &Self) -> Self {
        for i in 0..COLUMNS {
            for j in 0..COLUMNS {
                self.a[i][j] += other.a[i][j];
            }
            self.b[i] += other.b[i];
        }
        self.power += other.power;
        self.rows = [self.rows[0] + other.rows[0], self.rows[1] + other.rows[1]];
        self
    }

    /// The same rows with their torque multiplied.
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        scaled.b.iter_mut().for_each(|b| *b *= factor);
        scaled.power *= factor * factor;
        scaled
    }

    /// Coefficients of least squares within bounds, one after the other.
    fn minimum(&self, bounds: &[[f64; 2]; COLUMNS]) -> [f64; COLUMNS] {
        let mut x: [f64; COLUMNS] = std::array::from_fn(|i| 0.0_f64.clamp(bounds[i][0], bounds[i][1]));
        for _ in 0..SWEEPS {
            for i in 0..COLUMNS {
                if self.a[i][i] > 0.0 {
                    let others: f64 = (0..COLUMNS).filter(|j| *j != i).map(|j| self.a[i][j] * x[j]).sum();
                    x[i] = ((self.b[i] - others) / self.a[i][i]).clamp(bounds[i][0], bounds[i][1]);
                }
            }
        }
        x
    }

    /// Scale of inertia and weight together where nothing bounds it: that of the one that matters more.
    fn free_scale(&self, bounds: &[[f64; 2]; COLUMNS]) -> f64 {
        let mut free = *bounds;
        (free[0], free[1]) = ([0.0, f64::INFINITY], [0.0, f64::INFINITY]);
        free[2..RIGID].fill([0.0, 0.0]);
        let x = self.minimum(&free);
        let weight = [self.a[0][0] * x[0], self.a[1][1] * x[1]];
        if weight[0] >= weight[1] { x[0] } else { x[1] }
    }

    /// Least squares within bounds; `None` where there is too little motion.
    pub fn solve(&self, bounds: &[[f64; 2]; COLUMNS]) -> Option<Balance> {
        if self.rows.iter().any(|rows| *rows < FEWEST_ROWS) || self.power <= 0.0 {
            return None;
        }
        let x = self.minimum(bounds);
        let mut left = self.power;
        for i in 0..COLUMNS {
            let ax: f64 = (0..COLUMNS).map(|j| self.a[i][j] * x[j]).sum();
            left += x[i] * (ax - 2.0 * self.b[i]);
        }
        Some(Balance {
            left: (left / self.power).max(0.0),
            parts: [self.a[0][0] / self.power, self.a[1][1] / self.power],
            free: self.free_scale(bounds),
            coefficients: x,
        })
    }
}

/// Which rows take part, by session, joint and row.
pub type Mask<'a> = dyn Fn(usize, usize, usize) -> bool + Sync + 'a;

/// Normal equations of all joints.
pub fn normals(model: &Model, rows: &[Rows], mask: &Mask<'_>) -> Vec<Normal> {
    let dof = model.joints.len();
    let of_session = |(number, session): (usize, &Rows)| {
        let mut normals = vec![Normal::new(); dof];
        let mut machine = Machine::new(model, &session.session);
        let mut columns = vec![[0.0; RIGID]; dof];
        let (mut q, mut v, mut a) = (vec![0.0; dof], vec![0.0; dof], vec![0.0; dof]);
        for row in 0..session.len() {
            if (0..dof).all(|joint| !mask(number, joint, row)) {
                continue;
            }
            for (joint, own) in session.joints.iter().enumerate() {
                (q[joint], v[joint], a[joint]) = (own.q[row], own.v[row], own.a[row]);
            }
            machine.columns(&q, &v, &a, &mut columns);
            for (joint, own) in session.joints.iter().enumerate() {
                if own.tau.is_empty() || !mask(number, joint, row) {
                    continue;
                }
                let mut all = [0.0; COLUMNS];
                all[..RIGID].copy_from_slice(&columns[joint]);
                all[RIGID..].copy_from_slice(&[own.v[row].signum(), own.v[row], own.q[row], 1.0]);
                normals[joint].add(&all, own.tau[row], own.v[row] > 0.0);
            }
        }
        normals
    };
    let parts: Vec<Vec<Normal>> = rows.par_iter().enumerate().map(of_session).collect();
    parts.into_iter().fold(vec![Normal::new(); dof], |sum, part| {
        sum.into_iter().zip(&part).map(|(sum, part)| sum.joined(part)).collect()
    })
}

/// `I + G` of one joint [N·m or N], session by session and row by row.
pub fn rigid(model: &Model, rows: &[Rows], joint: usize) -> Vec<Vec<f64>> {
    let dof = model.joints.len();
    let of_session = |session: &Rows| {
        let mut machine = Machine::new(model, &session.session);
        let mut columns = vec![[0.0; RIGID]; dof];
        let of_row = |row: usize| {
            let of = |pick: fn(&super::rows::JointRows) -> &Vec<f64>| -> Vec<f64> {
                session.joints.iter().map(|own| pick(own)[row]).collect()
            };
            machine.columns(&of(|own| &own.q), &of(|own| &own.v), &of(|own| &own.a), &mut columns);
            columns[joint][0] + columns[joint][1]
        };
        (0..session.len()).map(of_row).collect()
    };
    rows.iter().map(of_session).collect()
}

/// Balances of all joints; `None` where a joint has no torque or too few rows of motion.
pub fn balances(model: &Model, rows: &[Rows], mask: &Mask<'_>) -> Vec<Option<Balance>> {
    let bounds = bounds(model);
    normals(model, rows, mask).iter().map(|normal| normal.solve(&bounds)).collect()
}

/// What the coefficients may be.
pub fn bounds(model: &Model) -> [[f64; 2]; COLUMNS] {
    let factor = match model.masses {
        Masses::Known => [1.0 / MODEL_FACTOR, MODEL_FACTOR],
        // A guess says the sign, and no more.
        Masses::Estimated => [0.0, f64::INFINITY],
    };
    let mass: f64 = model.robot.bodies.iter().map(|body| body.inertia.mass).sum();
    let (across, any, positive) = ([-ACROSS, ACROSS], [f64::NEG_INFINITY, f64::INFINITY], [0.0, f64::INFINITY]);
    let mut bounds = [[0.0, PAYLOAD * mass]; COLUMNS];
    bounds[..4].copy_from_slice(&[factor, factor, across, across]);
    bounds[RIGID..].copy_from_slice(&[positive, positive, positive, any]);
    bounds
}
