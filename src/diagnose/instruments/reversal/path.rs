//! The measured motion of one joint on an even grid of times, and the kernel that averages a torque on that grid to rows.
//!
//! Smooth rows would blur the jump of a rotor through its gap. Its position is therefore taken from the encoder's edges: at an edge the
//! position is known to within one sample, and it is linear between edges. Velocity, load and inertia are those of the rows, with linear
//! interpolation. A torque on the grid is constant from one instant to the next, and a row averages it like the recording.

use nalgebra::DMatrix;

use crate::dynamics::Dynamics;
use crate::effects::{Motion, SymmetricFriction};
use crate::timeseries::{Channel, TimeSeries};

/// Number of grid steps in the narrowest half width of a kernel.
const STEPS: f64 = 4.0;
/// [s] Smallest and largest step of the grid.
const GRID: [f64; 2] = [5e-4, 2e-3];

/// Motion of one joint on a grid; sessions follow each other.
#[derive(Debug, Clone)]
pub struct Path {
    /// Index of the joint.
    pub joint: usize,
    /// `h` [s] Time between instants.
    pub step: f64,
    /// Uninterrupted parts of sessions with their instants.
    pub spans: Vec<Span>,
    /// `θ` [rad or m].
    pub theta: Vec<f64>,
    /// `θ̇` [rad/s or m/s].
    pub v: Vec<f64>,
    /// `L` [N·m or N] Torque through the gear that the link needs without friction, if it follows the rotor.
    pub load: Vec<f64>,
    /// `I θ̈` [N·m or N] The part of it due to the link's own inertia.
    pub inertial: Vec<f64>,
    /// `I` [kg·m² or kg] Inertia of everything that the joint moves, with the other joints fixed.
    pub inertia: Vec<f64>,
    /// `F` Friction of rotor and link together.
    pub friction: SymmetricFriction,
    /// Dry part of `F(θ̇)` [N·m or N].
    pub dry: Vec<f64>,
}

/// Instants of a session between two pauses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Index of the session.
    pub session: usize,
    /// First instant.
    pub start: usize,
    /// The one after the last.
    pub end: usize,
    /// [s] Time of the first instant.
    pub from: f64,
    /// [s] Time between instants.
    pub step: f64,
}

impl Span {
    /// `t` [s] Time of an instant.
    pub fn time(&self, k: usize) -> f64 {
        self.from + (k - self.start) as f64 * self.step
    }
}

/// [s] Step of the grid for the rows of a motion.
fn step(motion: &Motion) -> f64 {
    let narrowest = motion.half_width.iter().copied().fold(f64::INFINITY, f64::min);
    (narrowest / STEPS).clamp(GRID[0], GRID[1])
}

impl Path {
    /// The path of a joint in sessions, in the order of the motion's sessions; a pause of a recording begins a new span.
    pub fn new(motion: &Motion, joint: usize, sessions: &[&TimeSeries]) -> Self {
        let step = step(motion);
        // Reserve the memory, so that growing signals are not copied.
        let room = Self::instants(motion) + motion.sessions;
        let [theta, v, load, inertial, inertia, dry] = [(); 6].map(|()| Vec::with_capacity(room));
        let spans = Vec::new();
        let friction = motion.joints[joint].friction;
        let mut path = Self { joint, step, spans, theta, v, load, inertial, inertia, friction, dry };
        let inertia = inertia_at_rows(motion, joint);
        let mut first = 0;
        while first < motion.rows() {
            let (session, part) = (motion.session[first], motion.part[first]);
            let end = (first..motion.rows()).find(|row| motion.part[*row] != part).unwrap_or(motion.rows());
            let name = &motion.model.joints[joint].name;
            let recorded = sessions[session].joint(name).and_then(|series| series.get(Channel::Position));
            let edges = recorded.map_or(Vec::new(), |position| edges(&sessions[session].time, position));
            path.append(motion, session, first..end, &inertia, &edges);
            first = end;
        }
        path
    }

    /// Approximate number of instants of the path of a joint.
    pub fn instants(motion: &Motion) -> usize {
        let steps = motion.time.windows(2).zip(motion.part.windows(2)).filter(|(_, part)| part[0] == part[1]);
        (steps.map(|(time, _)| time[1] - time[0]).sum::<f64>() / step(motion)) as usize
    }

    fn append(
        &mut self,
        motion: &Motion,
        session: usize,
        rows: std::ops::Range<usize>,
        inertia: &[f64],
        edges: &[[f64; 2]],
    ) {
        let m = &motion.joints[self.joint];
        let start = self.theta.len();
        let (from, to) = (motion.time[rows.start], motion.time[rows.end - 1]);
        let (mut row, mut edge) = (rows.start, 0);
        for k in 0..=((to - from) / self.step) as usize {
            let t = from + k as f64 * self.step;
            while row + 2 < rows.end && motion.time[row + 1] <= t {
                row += 1;
            }
            let next = (row + 1).min(rows.end - 1);
            let span = (motion.time[next] - motion.time[row]).max(1e-12);
            let x = ((t - motion.time[row]) / span).clamp(0.0, 1.0);
            let between = |values: &[f64]| values[row] + x * (values[next] - values[row]);
            while edge + 2 < edges.len() && edges[edge + 1][0] <= t {
                edge += 1;
            }
            self.theta.push(match edges.get(edge..edge + 2) {
                Some([[t0, q0], [t1, q1]]) => q0 + (q1 - q0) * ((t - t0) / (t1 - t0)).clamp(0.0, 1.0),
                _ => between(&m.q),
            });
            let v = between(&m.v);
            self.v.push(v);
            self.dry.push(self.friction.dry(v));
            self.load.push(between(&m.link_torque));
            let inertia = between(inertia);
            self.inertia.push(inertia);
            self.inertial.push(inertia * between(&m.a));
        }
        self.spans.push(Span { session, start, end: self.theta.len(), from, step: self.step });
    }

    /// The kernels of rows on the grid.
    pub fn windows(&self, motion: &Motion, rows: &[usize]) -> Windows {
        let mut windows = Windows { first: Vec::new(), ends: Vec::new(), weights: Vec::new() };
        for row in rows {
            let (t, w) = (motion.time[*row], motion.half_width[*row]);
            let covers = |span: &&Span| span.session == motion.session[*row] && t <= span.time(span.end);
            let span = self.spans.iter().find(covers);
            let Some(span) = span else {
                windows.first.push(0);
                windows.ends.push(windows.weights.len());
                continue;
            };
            let at =
                |t: f64| span.start + (((t - span.from) / self.step).max(0.0) as usize).min(span.end - span.start - 1);
            let (first, last) = (at(t - w), at(t + w));
            windows.first.push(first);
            let before = windows.weights.len();
            for k in first..=last {
                // The torque of an instant applies for one step.
                let s = (span.time(k) + 0.5 * self.step - t) / w;
                windows.weights.push((1.0 - s * s).max(0.0).powi(2));
            }
            let sum: f64 = windows.weights[before..].iter().sum();
            windows.weights[before..].iter_mut().for_each(|weight| *weight /= sum.max(1e-300));
            windows.ends.push(windows.weights.len());
        }
        windows
    }
}

/// The kernels of some rows on the grid.
#[derive(Debug, Clone)]
pub struct Windows {
    first: Vec<usize>,
    ends: Vec<usize>,
    weights: Vec<f64>,
}

impl Windows {
    /// Averages of a torque on the grid over the rows.
    pub fn averages(&self, torque: &[f64]) -> Vec<f64> {
        let mut start = 0;
        self.first
            .iter()
            .zip(&self.ends)
            .map(|(first, end)| {
                let weights = &self.weights[start..*end];
                start = *end;
                weights.iter().zip(&torque[*first..]).map(|(weight, torque)| weight * torque).sum()
            })
            .collect()
    }
}

/// Instants and positions at which a recorded position changes: midway between the two readings.
fn edges(time: &[f64], position: &[f64]) -> Vec<[f64; 2]> {
    let pairs = time.windows(2).zip(position.windows(2));
    pairs.filter(|(_, q)| q[0] != q[1]).map(|(t, q)| [0.5 * (t[0] + t[1]), 0.5 * (q[0] + q[1])]).collect()
}

fn inertia_at_rows(motion: &Motion, joint: usize) -> Vec<f64> {
    let dof = motion.joints.len();
    let mut dynamics = Dynamics::new(&motion.model.robot);
    let (mut q, mut mass) = (vec![0.0; dof], DMatrix::zeros(dof, dof));
    let at = |row: usize| {
        motion.joints.iter().zip(&mut q).for_each(|(m, q)| *q = m.q[row]);
        dynamics.mass_matrix(&q, &mut mass);
        mass[(joint, joint)]
    };
    (0..motion.rows()).map(at).collect()
}
