//! The rows of one joint's two encoders: the difference of motor and link position, and quantities that may cause it.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::contact::contact;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::rows::kernel::Kernel;
use crate::diagnose::rows::sampling::Sampling;
use crate::robot::{Masses, Model};
use crate::timeseries::{Channel, TimeSeries};
use crate::units::JointKind;

/// Share of friction that acts behind the gear if the model file does not give it.
const LINK_SHARE: f64 = 0.1;
/// Part of the largest load (95 % of the rows are below it) below which it is uncertain on which flank the link lies.
const UNLOADED: f64 = 0.05;

/// Rows of a joint where both encoders were recorded and the link lies on a flank, as far as that is known.
#[derive(Debug, Clone)]
pub struct Difference {
    /// Index of the joint.
    pub joint: usize,
    /// Rows of the motion.
    pub rows: Vec<usize>,
    /// `q − l` [rad or m] with the link's recording shifted by `lag`, averaged by the rows' kernel.
    pub ahead: Vec<f64>,
    /// `q` [rad or m].
    pub q: Vec<f64>,
    /// `q̇` [rad/s or m/s].
    pub v: Vec<f64>,
    /// Direction of motion, −1 to 1.
    pub direction: Vec<f64>,
    /// Torque [N·m or N] proportional to the wind-up; where masses are estimated it also contains friction before the gear.
    pub load: Vec<f64>,
    /// Whether `load` is the motor's torque, friction before the gear included.
    pub motor_side: bool,
}

/// Recording of a joint's second encoder. Where axes are coupled, the output of the axis' gear, `(C q)_i`, from the second encoders of all joints
/// that the axis moves.
fn recorded<'s>(session: &'s TimeSeries, model: &Model, joint: usize) -> Option<Cow<'s, [f64]>> {
    let of = |joint: usize| session.joint(&model.joints[joint].name)?.get(Channel::LinkPosition);
    let Some(coupling) = &model.robot.coupling else { return of(joint).map(Cow::Borrowed) };
    let mut output = vec![0.0; session.len()];
    for other in 0..model.joints.len() {
        let per_joint = coupling.axis_per_joint(joint, other);
        if per_joint != 0.0 {
            output.iter_mut().zip(of(other)?).for_each(|(sum, q)| *sum += per_joint * q);
        }
    }
    Some(Cow::Owned(output))
}

/// The difference with the link's recordings shifted so that a delay of `lag` [s] is removed.
pub fn difference(problem: &Problem, sessions: &[&TimeSeries], joint: usize, lag: f64) -> Option<Difference> {
    let motion = &problem.motion;
    let (m, model) = (&motion.joints[joint], &motion.model.joints[joint]);
    let motor_side = motion.model.masses == Masses::Estimated;
    let friction = |row: usize| m.friction.dry(m.v[row]) * m.direction[row] + m.friction.viscous * m.v[row];
    let links: Vec<_> = sessions.iter().map(|session| recorded(session, motion.model, joint)).collect();
    if links.iter().all(Option::is_none) {
        return None;
    }
    let contact = contact(problem, joint);
    let mut kernels: BTreeMap<usize, Kernel> = BTreeMap::new();
    let (mut rows, mut ahead) = (Vec::new(), Vec::new());
    for (number, (session, link)) in sessions.iter().zip(&links).enumerate() {
        let Some(link) = link.as_deref() else { continue };
        let dt = session.sample_interval();
        let sampling = Sampling::new(&session.time, dt);
        if sampling.uneven_share() > 0.0 {
            // At uneven times, the kernel's centre moves by the delay.
            for row in (0..motion.rows()).filter(|row| motion.session[*row] == number && contact[*row]) {
                let Some(window) = sampling.around_time(motion.time[row] + lag, motion.half_width[row]) else {
                    continue;
                };
                rows.push(row);
                ahead.push(m.q[row] - window.averages(link).value);
            }
            continue;
        }
        let link = shifted(link, lag / dt);
        for row in (0..motion.rows()).filter(|row| motion.session[*row] == number && contact[*row]) {
            let centre = session.time.partition_point(|time| *time < motion.time[row]);
            let reach = (motion.half_width[row] / dt) as usize;
            // Beyond the ends of the recording the position is unknown.
            let margin = reach + (lag.abs() / dt).ceil() as usize + 2;
            if centre < margin || centre + margin >= link.len() {
                continue;
            }
            let kernel = kernels.entry(reach).or_insert_with(|| Kernel::new(reach, dt));
            rows.push(row);
            ahead.push(m.q[row] - kernel.averages(&link, centre).value);
        }
    }
    if rows.is_empty() {
        return None;
    }
    let share = model.friction.map_or(LINK_SHARE, |friction| friction.link_share);
    let reflected = model.reflected_inertia();
    let load = |row: &usize| match motor_side {
        true => m.torque[*row] - reflected * m.a[*row],
        false => m.link_torque[*row] + share * friction(*row),
    };
    Some(Difference {
        joint,
        q: rows.iter().map(|row| m.q[*row]).collect(),
        v: rows.iter().map(|row| m.v[*row]).collect(),
        direction: rows.iter().map(|row| m.direction[*row]).collect(),
        load: rows.iter().map(load).collect(),
        rows,
        ahead,
        motor_side,
    })
}

impl Difference {
    /// Flank in contact, −1 to 1, where `friction` [N·m or N] of the load does not pass through the gear.
    pub fn side(&self, friction: f64) -> Vec<f64> {
        if !self.motor_side {
            return self.load.iter().map(|load| load.signum()).collect();
        }
        let carried: Vec<f64> = self.load.iter().zip(&self.direction).map(|(load, d)| load - friction * d).collect();
        let mut sizes: Vec<f64> = carried.iter().map(|load| load.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let unloaded = UNLOADED * sizes[(0.95 * (sizes.len() - 1) as f64) as usize].max(1e-300);
        carried.iter().map(|load| (load / unloaded).clamp(-1.0, 1.0)).collect()
    }

    /// Other causes of a difference of the two encoders: a constant per session, and the mounting of the second encoder on its link, which
    /// is a sine of its angle (a slope for a linear scale).
    pub fn mounting(&self, problem: &Problem) -> Vec<Vec<f64>> {
        let motion = &problem.motion;
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for session in 0..motion.sessions {
            let column: Vec<f64> =
                self.rows.iter().map(|row| f64::from(u8::from(motion.session[*row] == session))).collect();
            if column.iter().any(|value| *value > 0.0) {
                columns.push(column);
            }
        }
        match motion.model.joints[self.joint].kind {
            JointKind::Revolute => {
                columns.push(self.q.iter().map(|q| q.cos() - 1.0).collect());
                columns.push(self.q.iter().map(|q| q.sin()).collect());
            }
            JointKind::Prismatic => columns.push(self.q.clone()),
        }
        columns
    }

    /// The rows that `keep` selects.
    pub fn filtered(&self, keep: impl Fn(usize) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.rows.len()).filter(|index| keep(self.rows[*index])).collect();
        let pick = |values: &[f64]| -> Vec<f64> { kept.iter().map(|index| values[*index]).collect() };
        Self {
            joint: self.joint,
            rows: kept.iter().map(|index| self.rows[*index]).collect(),
            ahead: pick(&self.ahead),
            q: pick(&self.q),
            v: pick(&self.v),
            direction: pick(&self.direction),
            load: pick(&self.load),
            motor_side: self.motor_side,
        }
    }
}

/// The signal `by` samples later, with a cubic through four neighbours (Catmull and Rom 1974); constant beyond its ends.
fn shifted(signal: &[f64], by: f64) -> Vec<f64> {
    let whole = by.floor();
    let x = by - whole;
    let at = |index: f64| signal[index.clamp(0.0, (signal.len() - 1) as f64) as usize];
    (0..signal.len())
        .map(|index| {
            let first = index as f64 + whole;
            let [a, b, c, d] = [-1.0, 0.0, 1.0, 2.0].map(|offset| at(first + offset));
            b + 0.5 * x * (c - a + x * (2.0 * a - 5.0 * b + 4.0 * c - d + x * (3.0 * (b - c) + d - a)))
        })
        .collect()
}
