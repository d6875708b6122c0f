//! Position against the range of the joint in the URDF.
//!
//! A joint covers its range at most, and a little more where the URDF is narrow; in degrees it covers 57 times as much, as an angle of the motor as
//! many times as the gear turns. Silent where the torque balance confirms the scale by inertia or weight: the range in the URDF is wrong then, or the joint
//! turns on and on.

use super::balance;
use super::rows::Rows;
use crate::robot::{Masses, Model};
use crate::timeseries::{Channel, TimeSeries};
use crate::units::{DEG, JointKind};

/// Ranges that a position covers where its scale is in doubt: a narrow URDF is left by some tenths.
const DOUBTFUL: f64 = 1.5;
/// Ranges that it covers where nothing else is needed: above what any wrong URDF does, and below 57.
const RANGES: f64 = 5.0;
/// Part of the range by which a position in the right unit may leave it.
const MARGIN: f64 = 0.1;
/// Share of the squared torque that inertia or weight have to make to confirm a scale.
const CONFIRMS: f64 = 0.02;

/// A joint that covers several times its range, and the factors that would bring it inside, with their names.
#[derive(Debug, Clone, PartialEq)]
pub struct Outside {
    /// The joint's index in the model.
    pub joint: usize,
    /// [rad or m] lowest and highest position.
    pub extent: [f64; 2],
    /// [1] its width in ranges of the joint.
    pub ranges: f64,
    /// Factor and name of the mistake.
    pub units: Vec<(f64, &'static str)>,
}

impl Outside {
    /// Whether a factor brings the joint inside of its range.
    pub fn explained_by(&self, factor: f64) -> bool {
        self.units.iter().any(|(unit, _)| (unit / factor).ln().abs() < 1e-6)
    }
}

/// All such joints.
pub fn outside(model: &Model, sessions: &[&TimeSeries]) -> Vec<Outside> {
    let of_joint = |index: usize| {
        let joint = &model.joints[index];
        let limits = model.robot.bodies[index].joint.limits;
        let range = limits.upper - limits.lower;
        let [low, high] = extent(model, index, sessions)?;
        let n = joint.gear_ratio;
        let units = match joint.kind {
            JointKind::Revolute => [(DEG, "degrees_for_radians"), (1.0 / n, "motor_angle_for_joint_angle")],
            JointKind::Prismatic => [(1e-3, "millimetres_for_metres"), (1.0 / n, "motor_angle_for_joint_angle")],
        };
        let inside =
            |factor: f64| factor * low > limits.lower - MARGIN * range && factor * high < limits.upper + MARGIN * range;
        let units: Vec<(f64, &'static str)> = units.into_iter().filter(|(factor, _)| inside(*factor)).collect();
        let ranges = (high - low) / range;
        let far = range.is_finite() && range > 0.0 && ranges > DOUBTFUL && !units.is_empty();
        far.then_some(Outside { joint: index, extent: [low, high], ranges, units })
    };
    (0..model.joints.len()).filter_map(of_joint).collect()
}

/// Those that the torque balance does not confirm: they are reported where it finds nothing itself.
pub fn unconfirmed<'o>(model: &Model, rows: &[Rows], outside: &'o [Outside]) -> Vec<&'o Outside> {
    if outside.is_empty() {
        return Vec::new();
    }
    let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
    let balances = balance::balances(model, rows, &moves);
    let confirmed = |one: &&Outside| {
        let sure = |balance: balance::Balance| {
            balance.left < balance::SUSPICIOUS && balance.parts.iter().any(|part| *part > CONFIRMS)
        };
        model.masses == Masses::Known && balances[one.joint].is_some_and(sure)
    };
    outside.iter().filter(|one| one.ranges > RANGES && !confirmed(one)).collect()
}

/// Lowest and highest position of a joint.
fn extent(model: &Model, joint: usize, sessions: &[&TimeSeries]) -> Option<[f64; 2]> {
    let name = &model.joints[joint].name;
    let positions = sessions.iter().filter_map(|session| session.joint(name)?.get(Channel::Position));
    let [low, high] =
        positions.flatten().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], q| [low.min(*q), high.max(*q)]);
    (high > low).then_some([low, high])
}
