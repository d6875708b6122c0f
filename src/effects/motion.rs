//! Measured motion of a machine for the diagnosis: smooth, on the joint side, at selected samples ("rows").
//!
//! A "joint" here is the axis of a motor divided by its gear ratio, where recordings measure position and torque. Where axes are
//! [coupled](crate::robot::Coupling), `θ = C q`, the links' torque, inertia and regressor are those of the axes, and [`Motion::link`] gives `q`.
//!
//! Every row averages torque and motion of the recording around its sample with the kernel
//! `K(s) = 15/(16 w) (1 − (s/w)²)²`, `|s| ≤ w`; its first and second derivative give velocity and acceleration.
//! An oscillation along the path, `cos(n θ)` at the order `n`, passes it with the gain
//! `K̂(x) = 15 ((3 − x²) sin x − 3 x cos x)/x⁵`, `x = n θ̇ w`, and its rates with gains of their own while the motion accelerates.

use std::borrow::Cow;

use nalgebra::DMatrix;

use super::kernel::{Gains, kernel_gain};
use crate::dynamics::Dynamics;
use crate::gearhead::{Exponential, Friction, FrictionLaw};
use crate::robot::{Accuracy, Body, Model, Robot, TorqueAt};

/// `ω/ω_r` [1] Largest frequency of a ripple in the rotor's torque that rows describe, over the resonance of the link on its gear. Rows take the link's
/// acceleration from the rotor, and the link's is `1/(1 − (ω/ω_r)²)` times that: 1.19 at this frequency.
const FOLLOWS: f64 = 0.4;

/// Smooth measured motion, row by row; the rows of the sessions follow each other.
#[derive(Debug, Clone)]
pub struct Motion<'a> {
    /// The nominal machine.
    pub model: &'a Model,
    /// Number of sessions.
    pub sessions: usize,
    /// Session of each row.
    pub session: Vec<usize>,
    /// Uninterrupted part of each row, counted over all sessions: a pause of the recording begins a new one.
    pub part: Vec<usize>,
    /// [s] Time of the first sample of each session.
    pub start: Vec<f64>,
    /// [s] Interval of the samples, the longest of the sessions.
    pub interval: f64,
    /// [s] Time of each row.
    pub time: Vec<f64>,
    /// `w` [s] Half width of each row's kernel.
    pub half_width: Vec<f64>,
    /// Motion of each joint, in the order of the model.
    pub joints: Vec<JointMotion>,
}

/// Motion and torque of one joint, one value per row.
#[derive(Debug, Clone, Default)]
pub struct JointMotion {
    /// `q` [rad or m] Motor position on the joint side.
    pub q: Vec<f64>,
    /// `v` [rad/s or m/s].
    pub v: Vec<f64>,
    /// `a` [rad/s² or m/s²].
    pub a: Vec<f64>,
    /// Direction of motion, averaged like all other signals: −1 to 1, 0 at rest.
    pub direction: Vec<f64>,
    /// 1 where the joint sticks and slips within the kernel while its averages look like those of a turn, else 0.
    pub sticks: Vec<f64>,
    /// `τ_m` [N·m or N] Measured motor torque.
    pub torque: Vec<f64>,
    /// `τ̇_m` [N·m/s or N/s], averaged more widely than the torque where its noise requires that.
    pub torque_rate: Vec<f64>,
    /// [N·m or N] Torque that the nominal rigid body with its rotor needs for this motion.
    pub rigid: Vec<f64>,
    /// [N·m or N] Torque through the gear that the nominal links need, without friction.
    pub link_torque: Vec<f64>,
    /// `M` [kg·m² or kg] Inertia of the nominal links about this joint, with the other joints fixed; without the rotor.
    pub link_inertia: Vec<f64>,
    /// `T/k` [rad or m] By how much the link is behind the rotor, as the nominal links load the nominal gear; 0 where its stiffness is unknown.
    pub wind_up: Vec<f64>,
    /// Symmetric friction of the baseline, at its present estimate.
    pub friction: SymmetricFriction,
    /// Whether a current was measured and not a torque.
    pub has_current: bool,
    /// `s u₀` [1] By how much the torque constant is larger, at its present estimate: the torque shows `1 − s u₀` of what loads the joint.
    pub scale: f64,
    /// Why its torque is not judged; `None` where it is. Its motion moves the other joints in any case.
    pub left_out: Option<LeftOut>,
}

/// Why the torque of a joint is not judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeftOut {
    /// A session has neither its current nor its torque.
    NotRecorded,
    /// It moves too little to show its friction.
    HardlyMoves,
}

/// The baseline's law `(F_C + (F_S − F_C) e^{−|v|/v_S}) sgn v + F_V v`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SymmetricFriction {
    /// `F_C` [N·m or N].
    pub coulomb: f64,
    /// `F_S` [N·m or N].
    pub breakaway: f64,
    /// `v_S` [rad/s or m/s] > 0.
    pub stribeck_velocity: f64,
    /// `F_V` [N·m·s/rad or N·s/m].
    pub viscous: f64,
}

impl Default for SymmetricFriction {
    fn default() -> Self {
        Self { coulomb: 0.0, breakaway: 0.0, stribeck_velocity: 1.0, viscous: 0.0 }
    }
}

impl SymmetricFriction {
    /// The law of either direction.
    pub const fn law(&self) -> Exponential {
        Exponential {
            coulomb: self.coulomb,
            breakaway: self.breakaway,
            stribeck_velocity: self.stribeck_velocity,
            viscous: self.viscous,
        }
    }

    /// As the friction of a gear: the same law in both directions, all of it on the motor's side of the gap.
    pub fn on_motor(&self) -> Friction {
        Friction { law: FrictionLaw::Exponential([self.law(); 2]), link_share: 0.0 }
    }

    /// Dry part [N·m or N] at a velocity, ≥ 0.
    pub fn dry(&self, velocity: f64) -> f64 {
        self.law().dry(velocity.abs())
    }
}

impl JointMotion {
    /// [rad or m] Position of the links behind the gear, `q − T/k`.
    pub fn link_position(&self, row: usize) -> f64 {
        self.q[row] - self.wind_up.get(row).copied().unwrap_or(0.0)
    }

    /// With `of` applied to every signal.
    pub fn each(&self, of: &dyn Fn(&[f64]) -> Vec<f64>) -> Self {
        Self {
            q: of(&self.q),
            v: of(&self.v),
            a: of(&self.a),
            direction: of(&self.direction),
            sticks: of(&self.sticks),
            torque: of(&self.torque),
            torque_rate: of(&self.torque_rate),
            rigid: of(&self.rigid),
            link_torque: of(&self.link_torque),
            link_inertia: of(&self.link_inertia),
            wind_up: of(&self.wind_up),
            friction: self.friction,
            has_current: self.has_current,
            scale: self.scale,
            left_out: self.left_out,
        }
    }
}

impl Motion<'_> {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.time.len()
    }

    /// [s] Time of a row since its session began.
    pub fn since_start(&self, row: usize) -> f64 {
        self.time[row] - self.start[self.session[row]]
    }

    /// [s] Time that the rows of all sessions span.
    pub fn duration(&self) -> f64 {
        let span = |session: usize| {
            let first = self.session.partition_point(|of| *of < session);
            let last = self.session.partition_point(|of| *of <= session);
            if last > first { self.time[last - 1] - self.time[first] } else { 0.0 }
        };
        (0..self.sessions).map(span).sum()
    }

    /// The same motion at some of its rows.
    pub fn at_rows(&self, rows: &[usize]) -> Self {
        let pick = |values: &[f64]| -> Vec<f64> { rows.iter().filter_map(|row| values.get(*row).copied()).collect() };
        Self {
            model: self.model,
            sessions: self.sessions,
            start: self.start.clone(),
            interval: self.interval,
            session: rows.iter().map(|row| self.session[*row]).collect(),
            part: rows.iter().map(|row| self.part[*row]).collect(),
            time: pick(&self.time),
            half_width: pick(&self.half_width),
            joints: self.joints.iter().map(|joint| joint.each(&pick)).collect(),
        }
    }

    /// `T` [N·m or N] Torque through the gear, as it was measured: the motor's without what its rotor and friction take.
    pub fn through_gear(&self, joint: usize, row: usize) -> f64 {
        let (m, model) = (&self.joints[joint], &self.model.joints[joint]);
        match model.torque_at {
            TorqueAt::Link => m.torque[row],
            TorqueAt::Motor => {
                let friction = m.friction.dry(m.v[row]) * m.direction[row] + m.friction.viscous * m.v[row];
                m.torque[row] - model.reflected_inertia() * m.a[row] - friction
            }
        }
    }

    /// `s_K` [1] How well the scale of a joint's torque is known, one standard deviation. Drives compute the torque that they report from their
    /// current: it is as well known as a usual torque constant, or better where the model says so, however little the model knows of the motor. A
    /// sensor behind the gear is exact.
    pub fn scale_accuracy(&self, joint: usize) -> f64 {
        let stated = self.model.constant_accuracy(joint);
        match (self.model.joints[joint].torque_at, self.joints[joint].has_current) {
            (TorqueAt::Link, _) => 0.0,
            (TorqueAt::Motor, true) => stated,
            (TorqueAt::Motor, false) => stated.min(Accuracy::default().torque_constants),
        }
    }

    /// Gain of the kernel of a row for `cos(order · q)` of a joint.
    pub fn gain(&self, joint: usize, row: usize, order: f64) -> f64 {
        kernel_gain(order * self.joints[joint].v[row] * self.half_width[row])
    }

    /// A column: one value per row of a joint.
    pub fn column(&self, joint: usize, value: impl Fn(&JointMotion, usize) -> f64) -> Vec<f64> {
        let motion = &self.joints[joint];
        (0..self.rows()).map(|row| value(motion, row)).collect()
    }

    /// `ω_r` [rad/s] Resonance of the link on its gear with the rotor held; infinite where the gear counts as rigid.
    fn resonance(&self, joint: usize, row: usize) -> f64 {
        let model = &self.model.joints[joint];
        let inertia = self.joints[joint].link_inertia.get(row).filter(|_| model.gear_stiffness.is_some());
        inertia.map_or(f64::INFINITY, |inertia| model.resonance(*inertia))
    }

    /// The columns `cos(order · q)` and `sin(order · q)` after the kernel, times `amplitude`, in rows that are passed so slowly that the link
    /// follows its rotor: up to 0.4 of their resonance, where the stiffness of the gear is stated.
    pub fn harmonic(&self, joint: usize, order: f64, amplitude: impl Fn(&JointMotion, usize) -> f64) -> [Vec<f64>; 2] {
        let motion = &self.joints[joint];
        let mut columns = [Vec::with_capacity(self.rows()), Vec::with_capacity(self.rows())];
        for row in 0..self.rows() {
            let (sin, cos) = (order * motion.q[row]).sin_cos();
            let scale = amplitude(motion, row) * self.passed(joint, row, order);
            columns[0].push(scale * cos);
            columns[1].push(scale * sin);
        }
        columns
    }

    /// Gain of the kernel of a row for `cos(order · q)` of a joint; 0 where the link cannot follow its rotor.
    pub fn passed(&self, joint: usize, row: usize, order: f64) -> f64 {
        let follows = (order * self.joints[joint].v[row]).abs() <= FOLLOWS * self.resonance(joint, row);
        if follows { self.gain(joint, row, order) } else { 0.0 }
    }

    /// First and second time derivative of `cos(order · q)` and `sin(order · q)` after the kernel:
    /// `[[d cos, d sin], [d² cos, d² sin]]` of a row, to first order in the acceleration.
    pub fn harmonic_rates(&self, joint: usize, row: usize, order: f64) -> [[f64; 2]; 2] {
        let m = &self.joints[joint];
        let (v, a) = (order * m.v[row], order * m.a[row]);
        let (sin, cos) = (order * m.q[row]).sin_cos();
        let w = self.half_width[row];
        let Gains { value, rate, curvature } = Gains::at(v * w);
        let (drift, v2) = (rate * a * w, value * v * v);
        [
            [drift * cos - value * v * sin, drift * sin + value * v * cos],
            [-curvature * a * sin - v2 * cos, curvature * a * cos - v2 * sin],
        ]
    }

    /// Position of a joint's link [rad or m] in each row, which is the position of its axis where axes are not coupled. The wind-up
    /// of its gear is left out.
    pub fn link(&self, joint: usize) -> Cow<'_, [f64]> {
        match &self.model.robot.coupling {
            None => Cow::Borrowed(&self.joints[joint].q),
            Some(coupling) => (0..self.joints[joint].q.len())
                .map(|row| coupling.joint(joint, |axis| self.joints[axis].q[row]))
                .collect(),
        }
    }

    /// Adds the torque that the URDF's damping of joints takes from axes that do not move these joints alone: `(C⁻ᵀ c C⁻¹ − diag) θ̇`. The
    /// part by which an axis damps its own motion is viscous friction of the baseline.
    pub fn damp(&mut self) {
        let robot = &self.model.robot;
        let Some(coupling) = &robot.coupling else { return };
        let per_axis = |joint: usize, axis: usize| coupling.joint_per_axis(joint, axis);
        let damping = |i: usize, k: usize| -> f64 {
            let of_joint = |(j, body): (usize, &Body)| per_axis(j, i) * body.joint.damping * per_axis(j, k);
            robot.bodies.iter().enumerate().map(of_joint).sum()
        };
        for axis in 0..self.joints.len() {
            for other in (0..self.joints.len()).filter(|other| *other != axis) {
                let c = damping(axis, other);
                if c != 0.0 {
                    let torque: Vec<f64> = self.joints[other].v.iter().map(|v| c * v).collect();
                    let joint = &mut self.joints[axis];
                    joint.rigid.iter_mut().zip(&torque).for_each(|(sum, torque)| *sum += torque);
                    joint.link_torque.iter_mut().zip(&torque).for_each(|(sum, torque)| *sum += torque);
                }
            }
        }
    }

    /// Adds the torque for known masses that the model's last body carries in some sessions; `names` are the names of the sessions.
    pub fn carry<'n>(&mut self, names: impl Iterator<Item = &'n str>) {
        for (number, name) in names.enumerate() {
            let Some(load) = self.model.load_in(name) else { continue };
            let rows: Vec<usize> = (0..self.rows()).filter(|row| self.session[*row] == number).collect();
            let own = self.at_rows(&rows);
            let (torques, inertias) = (own.inverse_dynamics(&load, false), own.link_inertias(&load));
            for (joint, (torque, inertia)) in self.joints.iter_mut().zip(torques.iter().zip(&inertias)) {
                for ((row, torque), inertia) in rows.iter().zip(torque).zip(inertia) {
                    joint.rigid[*row] += torque;
                    joint.link_torque[*row] += torque;
                    joint.link_inertia[*row] += inertia;
                }
            }
        }
    }

    /// Change of the nominal gravity torque with the position of each joint's link: `slopes[moved][joint][row]` [N·m/rad or N/m].
    pub fn gravity_slopes(&self) -> Vec<Vec<Vec<f64>>> {
        /// [rad or m] The second derivative adds half of this, relative to a torque; rounding 1e-10.
        const STEP: f64 = 1e-6;
        let dof = self.joints.len();
        let mut slopes = vec![vec![Vec::with_capacity(self.rows()); dof]; dof];
        let mut dynamics = Dynamics::new(&self.model.robot);
        let [mut here, mut beside] = [(); 2].map(|()| vec![0.0; dof]);
        for row in 0..self.rows() {
            let mut q: Vec<f64> = self.joints.iter().map(|motion| motion.link_position(row)).collect();
            dynamics.gravity(&q, &mut here);
            for (moved, slopes) in slopes.iter_mut().enumerate() {
                let from = q[moved];
                q[moved] += STEP;
                dynamics.gravity(&q, &mut beside);
                q[moved] = from;
                for ((slope, beside), here) in slopes.iter_mut().zip(&beside).zip(&here) {
                    slope.push((beside - here) / STEP);
                }
            }
        }
        slopes
    }

    /// Distance that a joint covers, the largest of all sessions [rad or m].
    pub fn range(&self, joint: usize) -> f64 {
        let mut bounds = vec![(f64::INFINITY, f64::NEG_INFINITY); self.sessions];
        for (session, q) in self.session.iter().zip(&self.joints[joint].q) {
            let (low, high) = &mut bounds[*session];
            *low = low.min(*q);
            *high = high.max(*q);
        }
        bounds.iter().map(|(low, high)| high - low).fold(0.0, f64::max)
    }

    /// Inertia of a robot's links about each joint along the measured motion, with the other joints fixed: `inertias[joint][row]`.
    pub fn link_inertias(&self, robot: &Robot) -> Vec<Vec<f64>> {
        let dof = self.joints.len();
        let mut dynamics = Dynamics::new(robot);
        let mut mass = nalgebra::DMatrix::zeros(dof, dof);
        let mut inertias = vec![Vec::with_capacity(self.rows()); dof];
        for row in 0..self.rows() {
            let q: Vec<f64> = self.joints.iter().map(|motion| motion.link_position(row)).collect();
            dynamics.mass_matrix(&q, &mut mass);
            inertias.iter_mut().enumerate().for_each(|(joint, inertia)| inertia.push(mass[(joint, joint)]));
        }
        inertias
    }

    /// Torque of all joints for changes of the bodies' [parameters](crate::robot::Inertia::parameters), one column of `changes` each:
    /// `torques[joint][change][row]`.
    pub fn regressed(&self, changes: &DMatrix<f64>) -> Vec<Vec<Vec<f64>>> {
        self.regressed_on(&self.model.robot, false, changes)
    }

    /// As [`regressed`](Self::regressed), on another robot; with `still`, the torque at rest (v = a = 0).
    pub fn regressed_on(&self, robot: &Robot, still: bool, changes: &DMatrix<f64>) -> Vec<Vec<Vec<f64>>> {
        let dof = self.joints.len();
        let mut torques = vec![vec![Vec::with_capacity(self.rows()); changes.ncols()]; dof];
        let mut dynamics = Dynamics::new(robot);
        let rest = vec![0.0; dof];
        let mut y = DMatrix::zeros(dof, changes.nrows());
        // Changes of one body alone are the common case.
        let of_change = |row: &usize| changes.row(*row).iter().any(|change| *change != 0.0);
        let first = (0..changes.nrows()).find(of_change).unwrap_or(0);
        let count = (first..changes.nrows()).rfind(of_change).map_or(0, |last| last + 1 - first);
        let changes = changes.rows(first, count);
        let mut product = DMatrix::zeros(dof, changes.ncols());
        for row in 0..self.rows() {
            let each =
                |of: fn(&JointMotion) -> &Vec<f64>| -> Vec<f64> { self.joints.iter().map(|m| of(m)[row]).collect() };
            let q: Vec<f64> = self.joints.iter().map(|motion| motion.link_position(row)).collect();
            match still {
                true => dynamics.regressor(&q, &rest, &rest, &mut y),
                false => dynamics.regressor(&q, &each(|m| &m.v), &each(|m| &m.a), &mut y),
            }
            y.columns(first, count).mul_to(&changes, &mut product);
            for (joint, torques) in torques.iter_mut().enumerate() {
                torques.iter_mut().enumerate().for_each(|(k, torque)| torque.push(product[(joint, k)]));
            }
        }
        torques
    }

    /// Torque of all joints that a robot needs along the measured motion, `torques[joint][row]`;
    /// with `still`, the torque at rest (v = a = 0).
    pub fn inverse_dynamics(&self, robot: &Robot, still: bool) -> Vec<Vec<f64>> {
        let dof = self.joints.len();
        let mut torques = vec![Vec::with_capacity(self.rows()); dof];
        let mut dynamics = Dynamics::new(robot);
        let (mut q, mut v, mut a, mut tau) = (vec![0.0; dof], vec![0.0; dof], vec![0.0; dof], vec![0.0; dof]);
        for row in 0..self.rows() {
            for (joint, motion) in self.joints.iter().enumerate() {
                q[joint] = motion.link_position(row);
                if !still {
                    v[joint] = motion.v[row];
                    a[joint] = motion.a[row];
                }
            }
            dynamics.inverse(&q, &v, &a, &mut tau);
            for (torque, value) in torques.iter_mut().zip(tau.iter()) {
                torque.push(*value);
            }
        }
        torques
    }
}
