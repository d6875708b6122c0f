//! Possible mistakes in data or model, each with the change that corrects it.

use super::balance;
use super::rows::{self, Rows};
use crate::robot::{JointModel, Model};

/// One mistake that can be corrected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// The torque of a joint has the other sign.
    TorqueSign(usize),
    /// Position and velocity of a joint have the other sign.
    MotionSign(usize),
    /// Position, velocity and torque of a joint have the other sign: its axis points the other way.
    AxisSign(usize),
    /// Torques of two joints are exchanged.
    SwapTorque(usize, usize),
    /// Positions of two joints are exchanged.
    SwapMotion(usize, usize),
    /// All channels of two joints are exchanged.
    SwapJoints(usize, usize),
    /// The torque of a joint, or of all joints, has to be multiplied by a factor.
    TorqueScale(Option<usize>, f64),
    /// The torques of all joints are another quantity than stated.
    AllTorques(Quantity),
    /// Position and velocity of a joint, or of all joints, have to be multiplied by a factor.
    MotionScale(Option<usize>, f64),
    /// Positions and velocities of all joints are those of the motors, times a factor: one joint alone does not fit beside the others.
    MotorMotions(f64),
    /// Time has to be multiplied by a factor.
    TimeScale(f64),
    /// Gravity points in the opposite direction.
    Gravity,
    /// The gear ratio of a joint has to be multiplied by a factor: the torque from a current with it, the rotor's inertia with its square.
    Ratio(usize, f64),
    /// The torque of a joint, or of all joints, has to be read later by a time [s].
    TorqueLag(Option<usize>, f64),
    /// Position and velocity of a joint have to be read later by a time [s].
    MotionLag(usize, f64),
    /// The torque of a joint, or of all joints, is a magnitude. It gets the sign of the torque that links, rotor and Coulomb friction need.
    Unsigned(Option<usize>),
}

/// What a channel holds instead of what is stated. One number relates the two on each joint: the torque constant, the gear ratio, or both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Torque of the joint in a channel of currents.
    JointTorqueAsCurrent,
    /// Torque of the motor in a channel of currents.
    MotorTorqueAsCurrent,
    /// Current in a channel of joint torques.
    CurrentAsTorque,
    /// Torque of the motor in a channel of joint torques.
    MotorTorqueAsJointTorque,
}

impl Quantity {
    /// Those that a channel of currents, or of torques, may hold instead.
    pub const fn instead_of(current: bool) -> [Self; 2] {
        if current {
            [Self::JointTorqueAsCurrent, Self::MotorTorqueAsCurrent]
        } else {
            [Self::CurrentAsTorque, Self::MotorTorqueAsJointTorque]
        }
    }

    /// Factor by which the torque of a joint has to be multiplied; `None` where the joint has no motor.
    pub fn factor(self, joint: &JointModel) -> Option<f64> {
        let constant = joint.motor.map(|motor| motor.torque_constant);
        match self {
            Self::JointTorqueAsCurrent => constant.map(|_| 1.0 / joint.torque_per_ampere()),
            Self::MotorTorqueAsCurrent => constant.map(|constant| 1.0 / constant),
            Self::CurrentAsTorque => constant.map(|_| joint.torque_per_ampere()),
            Self::MotorTorqueAsJointTorque => Some(joint.gear_ratio),
        }
    }
}

/// A change that the data demand.
#[derive(Debug, Clone, PartialEq)]
pub struct Culprit {
    /// The best change.
    pub change: Change,
    /// Other changes that are nearly as good.
    pub alternatives: Vec<Change>,
    /// The joint that shows it best.
    pub joint: usize,
    /// What that joint shows.
    pub evidence: Evidence,
}

/// What the torque balance of a joint shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Evidence {
    /// [%] RMS residual relative to the torque before and after the change.
    Residual([f64; 2]),
    /// [1] Torque of inertia and weight relative to the model's: estimate, least and largest possible value.
    Size([f64; 3]),
}

impl Change {
    /// The two joints whose channels are exchanged.
    pub const fn exchanged(self) -> Option<[usize; 2]> {
        match self {
            Self::SwapTorque(i, j) | Self::SwapMotion(i, j) | Self::SwapJoints(i, j) => Some([i, j]),
            _ => None,
        }
    }

    /// Whether model and motion stay unchanged, so that only the torque of the balance changes.
    pub const fn of_torque(self) -> bool {
        matches!(
            self,
            Self::TorqueSign(_)
                | Self::TorqueScale(..)
                | Self::AllTorques(_)
                | Self::TorqueLag(..)
                | Self::Unsigned(_)
                | Self::SwapTorque(..)
        )
    }

    /// Model and rows after the correction.
    pub fn undone(self, model: &Model, rows: &[Rows]) -> (Model, Vec<Rows>) {
        let (mut model, mut rows) = (model.clone(), rows.to_vec());
        let dof = model.joints.len();
        let joints = |which: Option<usize>| which.map_or((0..dof).collect::<Vec<_>>(), |joint| vec![joint]);
        match self {
            Self::TorqueSign(joint) => scale_torque(&mut rows, &[joint], -1.0),
            Self::MotionSign(joint) => scale_motion(&mut rows, &[joint], [-1.0; 4]),
            Self::AxisSign(joint) => {
                scale_motion(&mut rows, &[joint], [-1.0; 4]);
                scale_torque(&mut rows, &[joint], -1.0);
            }
            Self::SwapTorque(i, j) => swap(&model, &mut rows, [i, j], [false, true]),
            Self::SwapMotion(i, j) => swap(&model, &mut rows, [i, j], [true, false]),
            Self::SwapJoints(i, j) => swap(&model, &mut rows, [i, j], [true, true]),
            Self::TorqueScale(which, factor) => scale_torque(&mut rows, &joints(which), factor),
            Self::AllTorques(quantity) => {
                for (index, joint) in model.joints.iter().enumerate() {
                    scale_torque(&mut rows, &[index], quantity.factor(joint).unwrap_or(1.0));
                }
            }
            Self::MotionScale(which, factor) => scale_motion(&mut rows, &joints(which), [factor; 4]),
            Self::MotorMotions(factor) => {
                for (index, joint) in model.joints.iter().enumerate() {
                    scale_motion(&mut rows, &[index], [factor / joint.gear_ratio; 4]);
                }
            }
            Self::TimeScale(factor) => {
                let (rate, curvature) = (1.0 / factor, 1.0 / (factor * factor));
                scale_motion(&mut rows, &joints(None), [1.0, rate, curvature, curvature]);
            }
            Self::Gravity => model.robot.gravity = -model.robot.gravity,
            Self::Ratio(joint, factor) => {
                model.joints[joint].gear_ratio *= factor;
                scale_torque(&mut rows, &[joint], factor);
            }
            Self::TorqueLag(which, lag) => {
                for session in &mut rows {
                    for joint in joints(which) {
                        session.joints[joint].tau = session.torque_after(joint, lag);
                    }
                }
            }
            Self::MotionLag(joint, lag) => rows = rows::with_motion_after(&model, &rows, joint, lag),
            Self::Unsigned(which) => joints(which).into_iter().for_each(|joint| sign(&model, &mut rows, joint)),
        }
        (model, rows)
    }
}

fn scale_torque(rows: &mut [Rows], joints: &[usize], factor: f64) {
    for session in rows {
        for joint in joints {
            session.joints[*joint].tau.iter_mut().for_each(|tau| *tau *= factor);
        }
    }
}

fn scale_motion(rows: &mut [Rows], joints: &[usize], factors: [f64; 4]) {
    for session in rows {
        for joint in joints {
            let own = &mut session.joints[*joint];
            for (values, factor) in [&mut own.q, &mut own.v, &mut own.a, &mut own.slow].into_iter().zip(factors) {
                values.iter_mut().for_each(|value| *value *= factor);
            }
        }
    }
}

/// Exchanges motion, torque or both of two joints. A current read for the wrong joint is converted with the gear of the other joint.
fn swap(model: &Model, rows: &mut [Rows], [i, j]: [usize; 2], [motion, torque]: [bool; 2]) {
    let gain = model.joints[i].torque_per_ampere() / model.joints[j].torque_per_ampere();
    for session in rows {
        let (mut one, mut other) = (session.joints[i].clone(), session.joints[j].clone());
        if motion {
            for (a, b) in [
                (&mut one.q, &mut other.q),
                (&mut one.v, &mut other.v),
                (&mut one.a, &mut other.a),
                (&mut one.slow, &mut other.slow),
            ] {
                std::mem::swap(a, b);
            }
        }
        if torque {
            std::mem::swap(&mut one.tau, &mut other.tau);
            if session.from_current {
                one.tau.iter_mut().for_each(|tau| *tau *= gain);
                other.tau.iter_mut().for_each(|tau| *tau /= gain);
            }
        }
        (session.joints[i], session.joints[j]) = (one, other);
    }
}

/// Number of values of Coulomb friction that are tried, from zero to the largest torque.
const FRICTIONS: usize = 40;

/// Gives the torque of a joint the sign of `I + G + F_C sgn v`, with the `F_C` for which the magnitudes fit best.
fn sign(model: &Model, rows: &mut [Rows], joint: usize) {
    let rigid = balance::Columns::new(model, rows).rigid(joint);
    let largest =
        rows.iter().flat_map(|session| &session.joints[joint].tau).fold(0.0_f64, |most, tau| most.max(tau.abs()));
    let needed = |session: usize, row: usize, v: f64, coulomb: f64| rigid[session][row] + coulomb * v.signum();
    let error = |coulomb: f64| -> f64 {
        let of_session = |(number, session): (usize, &Rows)| -> f64 {
            let own = &session.joints[joint];
            let moving = own.tau.iter().enumerate().filter(|(row, _)| own.moves[*row]);
            moving.map(|(row, tau)| (tau.abs() - needed(number, row, own.v[row], coulomb).abs()).powi(2)).sum()
        };
        rows.iter().enumerate().map(of_session).sum()
    };
    let frictions = (0..FRICTIONS).map(|k| largest * k as f64 / FRICTIONS as f64);
    let coulomb = frictions.min_by(|a, b| error(*a).total_cmp(&error(*b))).unwrap_or(0.0);
    for (number, session) in rows.iter_mut().enumerate() {
        let own = &mut session.joints[joint];
        for (row, tau) in own.tau.iter_mut().enumerate() {
            *tau = tau.abs().copysign(needed(number, row, own.v[row], coulomb));
        }
    }
}
