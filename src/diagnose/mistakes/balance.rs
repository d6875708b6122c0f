//! The torque balance of a recording under a nominal model with possibly large errors:
//!
//! ```text
//!   τ = α I(q, v, a) + κ L(q, v, a) + γ G(q) + δ₁ G₁(q) + δ₂ G₂(q) + Σ μ_k P_k(q, v, a)
//!     + J v̇ + F_C sgn v + F_V v + F_S sgn v exp(−|v|/v_S) + k q + c
//! ```
//! `I`: inertia of links and rotor with their velocity terms, computed with the slow acceleration of the links. `L`: the additional torque of the
//! links for the motor's full acceleration. In a gap, on a soft gear or with an eccentric encoder the motor accelerates and its link does not, so `κ`
//! may be as small as 0; the slow acceleration is common to both. `G`: weight. `G₁ G₂`: weight with gravity perpendicular to its nominal direction,
//! for a tilted base. `P_k`: 1 kg at six points around the last body's centre of mass, for a payload. `J`: a rotor that the model does not state; in
//! `I` otherwise. On a wrist it is most of the torque. Then friction with a falling part, a spring and an offset.
//!
//! Every coefficient has physical bounds: friction takes energy out of the motion (`F_C, F_V, F_S ≥ 0`), a spring pulls back, and
//! masses are positive and known within a factor. Under these bounds the residual, as a share of the torque's square, is small
//! if data and model are right, whichever effect is present; a wrong sign makes it one or more.

#![allow(clippy::needless_range_loop, reason = "rows and columns of a matrix are visited by one index")]

use nalgebra::{DMatrix, Vector3};
use rayon::prelude::*;

use crate::dynamics::Dynamics;
use crate::robot::{Inertia, Masses, Model, STANDARD_GRAVITY};

use super::rows::{JointRows, Rows};

/// Share of the squared torque above which changes are tried. Most correct recordings stay below it, so they need no search.
pub const SUSPICIOUS: f64 = 0.02;

/// Share above which a balance is not valid: half the torque in RMS.
pub const UNSOUND: f64 = 0.25;

/// Number of columns.
pub const COLUMNS: usize = 17;
/// Columns of links, rotor and payload.
const RIGID: usize = 12;
/// Column of the torque that only the motor's full acceleration shows; those between weight and it are of tilt and payload.
pub const FULL: usize = 10;
/// Column of a rotor of unknown inertia.
const ROTOR: usize = 11;
/// Factor by which inertia and weight may differ from the model's. It allows for inaccuracy (20 % of masses, 10 % of torque constants), effects
/// and a kernel that is too wide, with a margin of 2.
pub const MODEL_FACTOR: f64 = 2.5;
/// [1] Factor by which the rigid body of a model may be off, masses, centres and torque constant together: each is known within some tenths.
/// Unlike [`MODEL_FACTOR`] it leaves no room for effects and noise, which are in the bounds of a [`Size`]. On sound recordings these bounds
/// reach from below 1.13 to above 1.01.
pub const SIZE_FACTOR: f64 = 2.0;
/// [1] Share of a sum of squares below which a difference is rounding: some thousand times what sums of a million rows lose.
const ROUNDING: f64 = 1e-9;
/// [1] Largest part of gravity perpendicular to its nominal direction: a base tilted by 17°.
const ACROSS: f64 = 0.3;
/// Largest payload at each of its points, in masses of the machine.
const PAYLOAD: f64 = 0.1;
/// [m] Distance of those points from the last body's centre of mass.
const AWAY: f64 = 0.15;
/// `v_S` relative to the fastest speed of the session: low enough that friction falls and then rises again with viscous friction, and
/// independent of the unit of the velocity.
const SLOW: f64 = 0.1;
/// Least number of rows of a joint in each direction of motion.
pub const FEWEST_ROWS: usize = 25;
/// Iterations of the coordinate descent.
const SWEEPS: usize = 400;

/// Result of the balance of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balance {
    /// `Σ residual² / Σ τ²`.
    pub left: f64,
    /// Part of `Σ τ²` due to inertia alone, and due to weight alone, at their nominal size.
    pub parts: [f64; 2],
    /// Estimated scale of inertia and weight without bounds.
    pub free: f64,
    /// `α γ δ₁ δ₂ μ₁ … μ₆ κ J F_C F_V F_S k c`.
    pub coefficients: [f64; COLUMNS],
}

impl Balance {
    /// Distance of the coefficients of inertia and weight from one, `|ln α|` and `|ln γ|`, weighted by their part of the torque.
    pub fn oddness(&self) -> f64 {
        let of = |k: usize| self.coefficients[k].max(1e-9).ln().abs() * (10.0 * self.parts[k]).min(1.0);
        of(0) + of(1)
    }

    /// Factor of the torque at which the model's rigid body fits, if it is outside the accuracy of the model.
    pub fn needed_scale(&self) -> Option<f64> {
        (self.free > 0.0 && self.free.is_finite()).then(|| 1.0 / self.free).filter(|f| f.ln().abs() > MODEL_FACTOR.ln())
    }
}

/// Size of the rigid body's torque in a recording, relative to the model's: bounds that hold whatever the residual is.
///
/// With `τ = s (I + G) + κ L + friction + …`, least squares give `s` and leave the squares `u`, and `u₀` without `I + G`. If the whole residual
/// were proportional to the part of the torque that only `I + G` explains, `s` would be off by the share `√(u/(u₀ − u))`; it is off by less. So
/// noise, an effect, or a rigid body that is small beside friction widen the bounds. `κ` is free, because the links do not follow the motor in
/// a gap. A centre of mass that is off by millimetres changes the weight on a wrist's joint by its own size: the torque of such a first moment,
/// relative to what only `I + G` explains, widens the bounds too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Least `s`: a payload carries what it can.
    pub least: f64,
    /// Largest `s`: there is no payload. A payload adds to the torque of the model, so it only lowers `s`.
    pub largest: f64,
    /// Estimated `s` with a payload, and without.
    pub estimates: [f64; 2],
}

impl Size {
    /// The estimate next to one, if all values within the bounds are outside the accuracy of the model.
    pub fn impossible(&self) -> Option<f64> {
        let [with, without] = self.estimates;
        if self.least > SIZE_FACTOR {
            Some(with)
        } else if self.largest < 1.0 / SIZE_FACTOR {
            Some(without)
        } else {
            None
        }
    }

    /// The factor on the torque, next to `wanted`, that makes its size a possible one.
    pub fn possible_factor(&self, wanted: f64) -> f64 {
        let [least, largest] = [self.least, self.largest].map(|size| size * wanted);
        let nearest = match (least > SIZE_FACTOR, largest < 1.0 / SIZE_FACTOR) {
            (true, _) => self.least.recip(),
            (_, true) => self.largest.recip(),
            _ => wanted,
        };
        if nearest.is_finite() { nearest } else { wanted }
    }
}

/// The machine prepared for the columns of one session.
struct Machine {
    links: Dynamics,
    weight: Dynamics,
    /// Nominal gravity, and two directions perpendicular to it.
    gravity: [Vector3<f64>; 3],
    /// The ten inertial parameters of 1 kg at each point of the payload.
    points: [[f64; 10]; 6],
    regressor: DMatrix<f64>,
    /// Inertia of each rotor at its joint; `None` where it is unknown.
    rotors: Vec<Option<f64>>,
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
            rotors: model.joints.iter().map(|joint| joint.rotor_inertia.map(|_| joint.reflected_inertia())).collect(),
        }
    }

    /// `I G G₁ G₂ P₁ … P₆ L v̇` of every joint; `slow`: accelerations from the wide kernel.
    fn columns(&mut self, q: &[f64], v: &[f64], [a, slow]: [&[f64]; 2], out: &mut [[f64; RIGID]]) {
        let mut tau = vec![0.0; q.len()];
        self.links.inverse(q, v, a, &mut tau);
        out.iter_mut().zip(&tau).for_each(|(out, tau)| out[FULL] = *tau);
        self.links.inverse(q, v, slow, &mut tau);
        for (joint, out) in out.iter_mut().enumerate() {
            out[0] = tau[joint] + self.rotors[joint].unwrap_or(0.0) * a[joint];
            out[ROTOR] = if self.rotors[joint].is_none() { a[joint] } else { 0.0 };
            out[FULL] -= tau[joint];
        }
        for (k, gravity) in self.gravity.into_iter().enumerate() {
            self.weight.set_gravity(gravity);
            self.weight.gravity(q, &mut tau);
            out.iter_mut().zip(&tau).for_each(|(out, tau)| out[1 + k] = *tau);
        }
        self.weight.set_gravity(self.gravity[0]);
        self.weight.regressor(q, v, slow, &mut self.regressor);
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

    /// The same rows with their torque multiplied by a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        scaled.b.iter_mut().for_each(|b| *b *= factor);
        scaled.power *= factor * factor;
        scaled
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows.iter().sum()
    }

    /// Gram matrix of all columns and, as the last one, the torque.
    pub fn with_torque(&self) -> DMatrix<f64> {
        DMatrix::from_fn(COLUMNS + 1, COLUMNS + 1, |i, j| match (i.min(j), i.max(j)) {
            (COLUMNS, COLUMNS) => self.power,
            (column, COLUMNS) => self.b[column],
            (column, other) => self.a[column][other],
        })
    }

    /// Coefficients of least squares within bounds, by coordinate descent.
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

    /// The same rows with `I + G` in the place of `I`.
    fn tied(&self) -> Self {
        let mut tied = self.clone();
        (0..COLUMNS).for_each(|i| tied.a[0][i] += tied.a[1][i]);
        (0..COLUMNS).for_each(|i| tied.a[i][0] += tied.a[i][1]);
        tied.b[0] += tied.b[1];
        tied
    }

    /// Size of the rigid body's torque; `None` where the rigid body explains nothing, or where there is too little motion.
    /// `moment`: what the first moment of the bodies that the joint carries may be off by [kg·m].
    pub fn size(&self, bounds: &[[f64; 2]; COLUMNS], moment: f64) -> Option<Size> {
        if self.is_short() {
            return None;
        }
        let tied = self.tied();
        let off = self.of_moment(moment);
        let mut free = *bounds;
        free[1] = [0.0, 0.0];
        free[FULL] = [0.0, f64::INFINITY];
        let of = |free: &[[f64; 2]; COLUMNS]| {
            let mut bounds = *free;
            bounds[0] = [0.0, 0.0];
            let left_without = tied.left(&tied.minimum(&bounds));
            bounds[0] = [0.0, f64::INFINITY];
            let x = tied.minimum(&bounds);
            let left = tied.left(&x);
            // `u₀ − u` is `s²` times the squares of what only `I + G` explains.
            (left_without - left > ROUNDING * left_without)
                .then(|| [x[0], (left.sqrt() + x[0] * off) / (left_without - left).sqrt()])
        };
        let [with, spread] = of(&free)?;
        free[4..FULL].fill([0.0, 0.0]);
        let [without, other] = of(&free)?;
        let [least, largest] = [with * (1.0 - spread), without * (1.0 + other)];
        Some(Size { least, largest, estimates: [with, without] })
    }

    /// `√Σ τ²` of a first moment along each axis of the last body [N·m or N]: opposite points of the payload differ by it.
    fn of_moment(&self, moment: f64) -> f64 {
        let along = |k: usize| self.a[k][k] - 2.0 * self.a[k][k + 1] + self.a[k + 1][k + 1];
        let squares: f64 = [4, 6, 8].into_iter().map(along).sum();
        moment / (2.0 * AWAY) * squares.max(0.0).sqrt()
    }

    /// Whether there is too little motion.
    pub fn is_short(&self) -> bool {
        self.rows.iter().any(|rows| *rows < FEWEST_ROWS) || self.power <= 0.0
    }

    /// Sum of squares that coefficients leave.
    fn left(&self, x: &[f64; COLUMNS]) -> f64 {
        let of = |i: usize| {
            let ax: f64 = (0..COLUMNS).map(|j| self.a[i][j] * x[j]).sum();
            x[i] * (ax - 2.0 * self.b[i])
        };
        (self.power + (0..COLUMNS).map(of).sum::<f64>()).max(0.0)
    }

    /// Common scale of inertia and weight without bounds: the scale of the larger of the two.
    fn free_scale(&self, bounds: &[[f64; 2]; COLUMNS]) -> f64 {
        let mut free = *bounds;
        free[..FULL].fill([0.0, 0.0]);
        [0, 1, FULL].into_iter().for_each(|k| free[k] = [0.0, f64::INFINITY]);
        let x = self.minimum(&free);
        let weight = [self.a[0][0] * x[0], self.a[1][1] * x[1]];
        if weight[0] >= weight[1] { x[0] } else { x[1] }
    }

    /// Least squares within bounds; `None` where there is too little motion.
    pub fn solve(&self, bounds: &[[f64; 2]; COLUMNS]) -> Option<Balance> {
        if self.is_short() {
            return None;
        }
        let x = self.minimum(bounds);
        Some(Balance {
            left: self.left(&x) / self.power,
            parts: [self.a[0][0] / self.power, self.a[1][1] / self.power],
            free: self.free_scale(bounds),
            coefficients: x,
        })
    }
}

/// Selects rows by session, joint and row.
pub type Mask<'a> = dyn Fn(usize, usize, usize) -> bool + Sync + 'a;

/// Columns of the balance by session, row and joint.
#[derive(Debug)]
pub struct Columns {
    /// Number of joints.
    dof: usize,
    /// Columns of each joint, by session and row.
    of_sessions: Vec<Vec<Vec<[f64; RIGID]>>>,
}

impl Columns {
    /// The columns of a model along the motion of the rows.
    pub fn new(model: &Model, rows: &[Rows]) -> Self {
        let dof = model.joints.len();
        let of_session = |session: &Rows| {
            let mut machine = Machine::new(model, &session.session);
            let of_row = |row: usize| {
                let of = |pick: fn(&JointRows) -> &Vec<f64>| -> Vec<f64> {
                    session.joints.iter().map(|own| pick(own)[row]).collect()
                };
                let mut columns = vec![[0.0; RIGID]; dof];
                let accelerations = [&*of(|own| &own.a), &*of(|own| &own.slow)];
                machine.columns(&of(|own| &own.q), &of(|own| &own.v), accelerations, &mut columns);
                columns
            };
            (0..session.len()).map(of_row).collect()
        };
        Self { dof, of_sessions: rows.par_iter().map(of_session).collect() }
    }

    /// Normal equations of all joints.
    pub fn normals(&self, rows: &[Rows], mask: &Mask<'_>) -> Vec<Normal> {
        let mut normals = vec![Normal::new(); self.dof];
        for (number, (session, columns)) in rows.iter().zip(&self.of_sessions).enumerate() {
            for (joint, own) in session.joints.iter().enumerate().filter(|(_, own)| !own.tau.is_empty()) {
                let fastest = own.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
                for row in (0..session.len()).filter(|row| mask(number, joint, *row)) {
                    let (q, v) = (own.q[row], own.v[row]);
                    let mut all = [0.0; COLUMNS];
                    all[..RIGID].copy_from_slice(&columns[row][joint]);
                    let falling = (-v.abs() / (SLOW * fastest)).exp() * v.signum();
                    all[RIGID..].copy_from_slice(&[v.signum(), v, falling, q, 1.0]);
                    normals[joint].add(&all, own.tau[row], v > 0.0);
                }
            }
        }
        normals
    }

    /// `I + L + G` of one joint [N·m or N], by session and row.
    pub fn rigid(&self, joint: usize) -> Vec<Vec<f64>> {
        let of_row = |columns: &Vec<[f64; RIGID]>| columns[joint][0] + columns[joint][FULL] + columns[joint][1];
        self.of_sessions.iter().map(|session| session.iter().map(of_row).collect()).collect()
    }
}

/// Balances of all joints; `None` for a joint without torque or with too few rows of motion.
pub fn balances(model: &Model, rows: &[Rows], mask: &Mask<'_>) -> Vec<Option<Balance>> {
    let bounds = bounds(model);
    Columns::new(model, rows).normals(rows, mask).iter().map(|normal| normal.solve(&bounds)).collect()
}

/// Bounds of the coefficients.
pub fn bounds(model: &Model) -> [[f64; 2]; COLUMNS] {
    let factor = match model.masses {
        Masses::Known => [1.0 / MODEL_FACTOR, MODEL_FACTOR],
        // Estimated masses give the sign only.
        Masses::Estimated => [0.0, f64::INFINITY],
    };
    let mass: f64 = model.robot.bodies.iter().map(|body| body.inertia.mass).sum();
    let (across, any, positive) = ([-ACROSS, ACROSS], [f64::NEG_INFINITY, f64::INFINITY], [0.0, f64::INFINITY]);
    let mut bounds = [[0.0, PAYLOAD * mass]; COLUMNS];
    bounds[..4].copy_from_slice(&[factor, factor, across, across]);
    bounds[FULL] = [0.0, factor[1]];
    bounds[ROTOR] = positive;
    bounds[RIGID..].copy_from_slice(&[positive, positive, positive, positive, any]);
    bounds
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use super::*;
    use crate::diagnose::mistakes::rows::rows;
    use crate::effects::drawn::{MODEL, ROBOT};
    use crate::timeseries::{Channel, JointSeries, TimeSeries};

    /// A light link on a rotor of 0.3 kg m² that the model does not state: `τ = (0.01 + J) v̇ + 0.1 sgn v`.
    #[test]
    fn analytic_an_unknown_rotor_is_a_part_of_the_balance() {
        let text = MODEL.replace("rotor_inertia = 2e-5\n", "");
        let model = Model::from_texts(&text, &ROBOT.replace("0.2", "0.01"), Path::new("model.toml")).expect("a model");
        let time: Vec<f64> = (0..10_000).map(|k| 0.002 * f64::from(k)).collect();
        let position = time.iter().map(|t| t.sin() + 0.3 * (2.7 * t).sin()).collect::<Vec<f64>>();
        let torque = time.iter().map(|t| {
            let (v, a) = (t.cos() + 0.81 * (2.7 * t).cos(), -t.sin() - 0.81 * 2.7 * (2.7 * t).sin());
            0.31 * a + 0.1 * v.signum()
        });
        let channels = [(Channel::Position, position.into()), (Channel::Torque, torque.collect::<Vec<f64>>().into())];
        let joints = vec![JointSeries { name: "joint1".to_owned(), channels: BTreeMap::from(channels) }];
        let rows = rows(&model, &[&TimeSeries { name: "one".to_owned(), time, joints }]);
        let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
        let found = balances(&model, &rows, &moves)[0].expect("a balance");
        // One joint does not tell a rotor from its link, or from masses at four points beside the axis.
        let beside: f64 = found.coefficients[4..8].iter().sum();
        let rotor = 0.31 - 0.01 * found.coefficients[0] - AWAY.powi(2) * beside;
        // Accelerations of links are those of the wide kernel, which rounds them by some percent: of 0.03 of 0.31.
        assert!((found.coefficients[ROTOR] / rotor - 1.0).abs() < 0.01, "{found:?}");
        // 1.4e-5 are left, of links behind the wide kernel and of rows around turns, which average the direction; without `J` 0.78 would be.
        assert!(found.left < 1e-4, "{found:?}");
    }

    /// A torque across the rigid body's own, but for the share `s`: with `s = 1e-3` its size is `s (1 ± 1/s)`, and one that explains `1e-12` of the squares
    /// has none.
    #[test]
    fn analytic_a_share_that_is_lost_in_rounding_has_no_size() {
        let size = |s: f64| {
            let mut normal = Normal { power: 1.0, rows: [FEWEST_ROWS; 2], ..Normal::new() };
            normal.a[0][0] = 1.0;
            normal.b[0] = s;
            normal.size(&[[0.0, 0.0]; COLUMNS], 0.0)
        };
        let Some(Size { least, largest, .. }) = size(1e-3) else { panic!("a size") };
        // `√(1 − s²)` beside `s`, and rounding.
        assert!((least + 0.999).abs() < 1e-5 && (largest - 1.001).abs() < 1e-5, "{least} {largest}");
        assert_eq!(size(1e-6), None);
    }
}
