//! Limits of range, speed and acceleration of a machine's joints in an experiment that is planned automatically.
//!
//! Every joint stays in the middle of its range (80 % of it, at most 1.2 rad or 0.3 m to either side), below 60 % of
//! its speed limit (at most 2 rad/s or 0.3 m/s), and below the acceleration that a third of its effort limit gives; it
//! reaches full speed in a third of a second at best.

use nalgebra::DMatrix;

use crate::dynamics::Dynamics;
use crate::robot::{Body, JointModel, Model};
use crate::units::JointKind;

/// Limits of one joint in an experiment, SI.
pub(super) struct Reach {
    /// The joint's name.
    pub name: String,
    /// [rad or m] Middle of its room.
    pub middle: f64,
    /// [rad or m] From there to either end.
    pub half: f64,
    /// [rad/s or m/s]
    pub speed: f64,
    /// [rad/s² or m/s²]
    pub acceleration: f64,
    /// [kg·m² or kg] Rotor and link at zero, the other joints held.
    pub inertia: f64,
    /// [N·m·s/rad or N·s/m], [N·m/rad or N/m] Proportional and integral gain of its velocity controller.
    pub gains: [f64; 2],
}

/// Limits of all joints.
pub(super) fn reaches(model: &Model) -> Vec<Reach> {
    let dof = model.joints.len();
    let mut mass = DMatrix::zeros(dof, dof);
    Dynamics::new(&model.robot).mass_matrix(&vec![0.0; dof], &mut mass);
    let rooms = rooms(model);
    let reach = |index: usize| {
        let joint = &model.joints[index];
        let [middle, half, speed] = rooms[index];
        let inertia = mass[(index, index)] + joint.reflected_inertia();
        let effort = model.robot.bodies[index].joint.limits.effort;
        let acceleration = (effort / 3.0 / inertia).min(3.0 * speed);
        // A loop of 17 rad/s, with an integral a third as fast: well below the filter of a velocity sensor of 20 ms.
        let gains = [17.0 * inertia, 100.0 * inertia];
        Reach { name: joint.name.clone(), middle, half, speed, acceleration, inertia, gains }
    };
    (0..dof).map(reach).collect()
}

/// Middle and half [rad or m] of the range that each axis may use, and its speed [rad/s or m/s]: those of its joint, or where axes are coupled such
/// that no joint leaves its own.
fn rooms(model: &Model) -> Vec<[f64; 3]> {
    let of_joint = |(joint, body): (&JointModel, &Body)| {
        let limits = body.joint.limits;
        let (most_half, most_speed) = match joint.kind {
            JointKind::Revolute => (1.2, 2.0),
            JointKind::Prismatic => (0.3, 0.3),
        };
        // An end that the file does not give is as far away as an experiment needs.
        let whole = 2.5 * most_half;
        let (low, high) = match (limits.lower.is_finite(), limits.upper.is_finite()) {
            (true, true) => (limits.lower, limits.upper),
            (true, false) => (limits.lower, limits.lower + whole),
            (false, true) => (limits.upper - whole, limits.upper),
            (false, false) => (-0.5 * whole, 0.5 * whole),
        };
        let (middle, half) = (0.5 * (low + high), 0.4 * (high - low));
        [middle, half.min(most_half), (0.6 * limits.velocity).min(most_speed)]
    };
    let rooms: Vec<[f64; 3]> = model.joints.iter().zip(&model.robot.bodies).map(of_joint).collect();
    let Some(coupling) = &model.robot.coupling else { return rooms };
    let each = |k: usize| rooms.iter().map(|room| room[k]).collect::<Vec<f64>>();
    let mut middles = each(0);
    coupling.axes(&each(0), &mut middles);
    let (halves, speeds) = (coupling.within(&each(1)), coupling.within(&each(2)));
    (0..rooms.len()).map(|axis| [middles[axis], halves[axis], speeds[axis]]).collect()
}

/// Postures to start in: all joints at zero, or as near to it as their room allows; the middle of their rooms; and a little to either side of the first.
pub(super) fn starts(reaches: &[Reach]) -> Vec<Vec<f64>> {
    let near_zero = |reach: &Reach| 0.0_f64.clamp(reach.middle - 0.5 * reach.half, reach.middle + 0.5 * reach.half);
    let from = |of: &dyn Fn(&Reach) -> f64| reaches.iter().map(of).collect::<Vec<f64>>();
    let (zero, middle) = (from(&near_zero), from(&|reach| reach.middle));
    let bent = |sign: f64| zero.iter().zip(reaches).map(|(zero, reach)| zero + sign * reach.half).collect();
    vec![zero.clone(), middle, bent(0.25), bent(-0.25)]
}
