//! Position against the range of the joint in the URDF.
//!
//! A joint covers at most its range, or a little more if the URDF is narrow. In degrees it covers 57 times as much, and as an angle of the motor
//! as many times as the gear ratio. There is no report where the torque balance confirms the scale by inertia or weight: then the range in the
//! URDF is wrong, or the joint turns continuously.

use super::balance;
use super::rows::Rows;
use crate::robot::{Masses, Model};
use crate::timeseries::{Channel, TimeSeries};
use crate::units::{DEG, JointKind};

/// Ranges covered above which the scale of a position is in doubt: a narrow URDF is exceeded by some tenths.
const DOUBTFUL: f64 = 1.5;
/// Ranges covered above which no other evidence is needed: more than any wrong URDF causes, and less than 57.
const RANGES: f64 = 5.0;
/// Part of the range by which a position in the right unit may leave it.
const MARGIN: f64 = 0.1;
/// Least share of the squared torque due to inertia or weight that confirms a scale.
const CONFIRMS: f64 = 0.02;

/// A joint that covers several times its range, and the factors that bring it back inside, with the names of the mistakes.
#[derive(Debug, Clone, PartialEq)]
pub struct Outside {
    /// The joint's index in the model.
    pub joint: usize,
    /// [rad or m] lowest and highest position.
    pub extent: [f64; 2],
    /// [1] Its width relative to the range of the joint.
    pub ranges: f64,
    /// Factor and name of the mistake.
    pub units: Vec<(f64, &'static str)>,
}

impl Outside {
    /// Whether a factor brings the joint back into its range.
    pub fn explained_by(&self, factor: f64) -> bool {
        self.units.iter().any(|(unit, _)| (unit / factor).ln().abs() < 1e-6)
    }
}

/// All such joints.
pub fn outside(model: &Model, sessions: &[&TimeSeries]) -> Vec<Outside> {
    let of_joint = |index: usize| {
        let joint = &model.joints[index];
        let [lower, upper] = model.robot.axis_range(index);
        let range = upper - lower;
        let [low, high] = extent(model, index, sessions)?;
        let n = joint.gear_ratio;
        let units = match joint.kind {
            JointKind::Revolute => [(DEG, "degrees_for_radians"), (1.0 / n, "motor_angle_for_joint_angle")],
            JointKind::Prismatic => [(1e-3, "millimetres_for_metres"), (1.0 / n, "motor_angle_for_joint_angle")],
        };
        let inside = |factor: f64| factor * low > lower - MARGIN * range && factor * high < upper + MARGIN * range;
        let units: Vec<(f64, &'static str)> = units.into_iter().filter(|(factor, _)| inside(*factor)).collect();
        let ranges = (high - low) / range;
        let far = range.is_finite() && range > 0.0 && ranges > DOUBTFUL && !units.is_empty();
        far.then_some(Outside { joint: index, extent: [low, high], ranges, units })
    };
    (0..model.joints.len()).filter_map(of_joint).collect()
}

/// Joints whose scale the torque balance does not confirm. They are reported where the balance itself finds no mistake.
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
