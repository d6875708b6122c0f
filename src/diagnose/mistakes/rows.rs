//! Smooth motion and torque of every joint in evenly spaced rows, for the torque balance.
//!
//! All rows have one kernel width, larger than in a diagnosis: a mistake changes a sign or a factor, not ten percent. A second, wider kernel smooths
//! the acceleration; the result is common to motor and link, whatever the gear does.

use std::sync::Arc;

use crate::diagnose::rows::kernel::Kernel;
use crate::diagnose::rows::signals::motor_torque;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};

/// [s] Half width of the kernel: with a coarse encoder (0.6 mrad at 1 kHz) the noise of the acceleration is 0.03 rad/s².
const HALF_WIDTH: f64 = 0.06;
/// Half width of the wide kernel relative to the narrow one. A motor that crosses a gap `g` accelerates by up to `1.44 g/w²` in the rows while its
/// link does not. For a wide gap of 0.01 rad that is 4 rad/s² at `w` = 0.06 s, more than slow motion needs, and 0.1 rad/s² at six times that width.
const WIDE: usize = 6;
/// [s] Smallest distance of rows.
const SPACING: f64 = 0.02;
/// Approximate number of rows of all sessions together.
const MOST_ROWS: f64 = 900.0;
/// A joint moves in a session if it covers at least this share of its largest motion in any session.
const MOVES: f64 = 0.02;
/// A joint rests below this share of its fastest speed in the session.
const REST: f64 = 0.04;
/// [1] Number of counts in the kernel's width below which the direction of motion is unknown.
const FEW_COUNTS: f64 = 3.0;

/// Rows of one session.
#[derive(Debug, Clone)]
pub struct Rows {
    /// Name of the session.
    pub session: String,
    /// Rows of each joint of the model.
    pub joints: Vec<JointRows>,
    /// Sample in the middle of each row.
    centres: Vec<usize>,
    kernel: Kernel,
    /// Kernel of the slow acceleration.
    wide: Arc<Kernel>,
    /// Position of each joint at evenly spaced times.
    position: Arc<Vec<Vec<f64>>>,
    /// Torque of each joint at the same times.
    torque: Arc<Vec<Vec<f64>>>,
    /// [s]
    interval: f64,
    /// Whether torques come from currents.
    pub from_current: bool,
}

/// Rows of one joint; empty torque where no torque was recorded.
#[derive(Debug, Clone, Default)]
pub struct JointRows {
    /// [rad or m]
    pub q: Vec<f64>,
    /// [rad/s or m/s]
    pub v: Vec<f64>,
    /// [rad/s² or m/s²]
    pub a: Vec<f64>,
    /// [rad/s² or m/s²] From the wide kernel: the acceleration that the link also has while it crosses a gap.
    pub slow: Vec<f64>,
    /// [N·m or N] motor torque on the joint side.
    pub tau: Vec<f64>,
    /// Whether the joint moves, so that friction has a direction.
    pub moves: Vec<bool>,
}

impl Rows {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.centres.len()
    }

    /// Torque of a joint read `lag` [s] later [N·m or N]; constant beyond the ends.
    pub fn torque_after(&self, joint: usize, lag: f64) -> Vec<f64> {
        let torque = &self.torque[joint];
        if torque.is_empty() {
            return Vec::new();
        }
        let centres = self.centres_after(lag, self.kernel.reach, torque.len());
        centres.map(|centre| self.kernel.averages(torque, centre).value).collect()
    }

    /// Gives a joint the motion that is recorded `lag` [s] later; constant beyond the ends.
    fn read_motion_after(&mut self, joint: usize, lag: f64) {
        let position = &self.position[joint];
        let centres = self.centres_after(lag, self.wide.reach, position.len());
        let own = &mut self.joints[joint];
        for (row, centre) in centres.enumerate() {
            let motion = self.kernel.averages(position, centre);
            (own.q[row], own.v[row], own.a[row]) = (motion.value, motion.rate, motion.curvature);
            own.slow[row] = self.wide.averages(position, centre).curvature;
        }
    }

    /// Middle samples of the rows `lag` [s] later, where a kernel of this reach fits into so many samples.
    fn centres_after(&self, lag: f64, reach: usize, samples: usize) -> impl Iterator<Item = usize> + use<> {
        let (first, last) = (reach, samples.saturating_sub(reach + 1));
        let shift = (lag / self.interval).round() as isize;
        let centres = self.centres.clone();
        centres.into_iter().map(move |centre| centre.saturating_add_signed(shift).clamp(first, last.max(first)))
    }
}

/// The rows with the motion of a joint read `lag` [s] later.
pub fn with_motion_after(model: &Model, rows: &[Rows], joint: usize, lag: f64) -> Vec<Rows> {
    let mut rows = rows.to_vec();
    rows.iter_mut().for_each(|session| session.read_motion_after(joint, lag));
    mark_motion(model, &mut rows, joint);
    rows
}

/// Rows of every session in which all joints of the model have a position and at least one has a torque; sessions that are too short are left out.
pub fn rows(model: &Model, sessions: &[&TimeSeries]) -> Vec<Rows> {
    let total: f64 = sessions.iter().filter_map(|s| Some(s.time.last()? - s.time.first()?)).sum();
    let spacing = SPACING.max(total / MOST_ROWS);
    let mut rows: Vec<Rows> = sessions.iter().filter_map(|session| of_session(model, session, spacing)).collect();
    for joint in 0..model.joints.len() {
        mark_motion(model, &mut rows, joint);
    }
    rows
}

fn of_session(model: &Model, session: &TimeSeries, spacing: f64) -> Option<Rows> {
    let interval = session.sample_interval();
    if interval.is_nan() || interval <= 0.0 {
        return None;
    }
    let reach = ((HALF_WIDTH / interval).round() as usize).max(3);
    let grid = grid(&session.time, interval)?;
    let far = WIDE * reach;
    if grid.len() < 4 * far {
        return None;
    }
    let (kernel, wide) = (Kernel::new(reach, interval), Kernel::new(far, interval));
    let step = ((spacing / interval).round() as usize).max(1);
    let centres: Vec<usize> = (far..grid.len() - far).step_by(step).collect();
    let mut joints = Vec::with_capacity(model.joints.len());
    let mut positions = Vec::with_capacity(model.joints.len());
    let mut torques = Vec::with_capacity(model.joints.len());
    let mut from_current = true;
    for (index, joint) in model.joints.iter().enumerate() {
        let series = session.joint(&joint.name)?;
        let position = resampled(&session.time, series.get(Channel::Position)?, &grid);
        let direction = series.get(Channel::Velocity).or_else(|| series.get(Channel::ReferenceVelocity));
        let torque = motor_torque(model, index, series, direction).map_or(Vec::new(), |(torque, current)| {
            from_current &= current;
            resampled(&session.time, &torque, &grid)
        });
        let mut rows = JointRows::default();
        for centre in &centres {
            let motion = kernel.averages(&position, *centre);
            rows.q.push(motion.value);
            rows.v.push(motion.rate);
            rows.a.push(motion.curvature);
            rows.slow.push(wide.averages(&position, *centre).curvature);
        }
        if !torque.is_empty() {
            rows.tau = centres.iter().map(|centre| kernel.averages(&torque, *centre).value).collect();
        }
        joints.push(rows);
        positions.push(position);
        torques.push(torque);
    }
    let (wide, position, torque) = (Arc::new(wide), Arc::new(positions), Arc::new(torques));
    let session = session.name.clone();
    Some(Rows { session, joints, centres, kernel, wide, position, torque, interval, from_current })
}

/// Evenly spaced times over a session.
fn grid(time: &[f64], interval: f64) -> Option<Vec<f64>> {
    let (first, last) = (*time.first()?, *time.last()?);
    let count = (last - first) / interval;
    // A session with most samples missing is not used.
    (count.is_finite() && count < 4.0 * time.len() as f64)
        .then(|| (0..=count as usize).map(|k| first + k as f64 * interval).collect())
}

/// A signal at other times, by linear interpolation.
fn resampled(time: &[f64], values: &[f64], grid: &[f64]) -> Vec<f64> {
    let mut next = 1;
    let at = |t: &f64| {
        while next + 1 < time.len() && time[next] < *t {
            next += 1;
        }
        let part = ((t - time[next - 1]) / (time[next] - time[next - 1])).clamp(0.0, 1.0);
        values[next - 1] + part * (values[next] - values[next - 1])
    };
    if values.len() < 2 { vec![0.0; grid.len()] } else { grid.iter().map(at).collect() }
}

/// Marks the rows in which a joint moves.
fn mark_motion(model: &Model, rows: &mut [Rows], joint: usize) {
    let covers = |rows: &Rows| {
        let q = &rows.joints[joint].q;
        q.iter().copied().fold(f64::NEG_INFINITY, f64::max) - q.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let most = rows.iter().map(covers).fold(0.0, f64::max);
    let count = model.joints[joint].encoder_step();
    for session in rows {
        let here = covers(session);
        let width = 2.0 * session.kernel.half_width;
        let own = &mut session.joints[joint];
        let fastest = own.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let rest = (REST * fastest).max(FEW_COUNTS * count / width);
        let moves = here > 0.0 && here >= MOVES * most;
        own.moves = own.v.iter().map(|v| moves && v.abs() > rest).collect();
    }
}
