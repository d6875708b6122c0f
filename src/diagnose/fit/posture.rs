//! Unknown posture of the links behind their gears.
//!
//! The link of joint `j` is behind its rotor by half of the gap `b`, on the flank that the load presses, and by the wind-up `T/k` of the gear:
//!
//! ```text
//!   q_link = q − (b/2) sgn(T + s F_C sgn v) − T/k,      τ_i changes by  −(∂g_i/∂q_j) ((b/2) sgn(…) + T/k)
//! ```
//! with the load `T` of the links, the share `s` of Coulomb friction behind the gear and the gravity torque `g`. Where the model file gives no gap,
//! half a gap of 5 mrad at a slope of gravity of 20 N·m/rad is worth as much as a cable, and looks like one; so is a wind-up of 5 mrad where it gives no
//! stiffness. The columns here are those of one standard deviation of the gap and of the wind-up; a gear without a stiffness may be as soft as the usual
//! resonance has it. Inertial torques change by less than their own accuracy, and are left out.

use nalgebra::DVectorView;

use crate::effects::Motion;
use crate::identify::statistics::median;
use crate::units::JointKind;

/// [rad, m] One standard deviation of an unknown gap: a third of the widest that gears of robots have.
const GAP: [f64; 2] = [0.005, 1.7e-4];
/// `s` [1] Typical share of Coulomb friction behind the gear.
const SHARE_BEHIND: f64 = 0.25;
/// [1] Part of Coulomb friction over which the load changes the flank in the mean: the spread of that share.
const CHANGE_OF_FLANK: f64 = 0.1;

/// Torques of one standard deviation of each unknown value: `torques[value][joint][row]`, first the gaps, then the wind-ups.
pub struct Posture(Vec<Vec<Vec<f64>>>);

impl Posture {
    /// Number of values.
    pub const fn count(dof: usize) -> usize {
        2 * dof
    }

    /// For a motion of joints with the Coulomb friction `F_C`.
    pub fn new(motion: &Motion, coulomb: &[f64]) -> Self {
        let slopes = motion.gravity_slopes();
        let moved = |joint: usize, behind: Vec<f64>| -> Vec<Vec<f64>> {
            let torque = |slope: &Vec<f64>| slope.iter().zip(&behind).map(|(slope, behind)| -slope * behind).collect();
            slopes[joint].iter().map(torque).collect()
        };
        let joints = 0..motion.joints.len();
        let gaps = joints.clone().map(|joint| moved(joint, half_gap(motion, joint, coulomb[joint])));
        Self(gaps.chain(joints.map(|joint| moved(joint, wind_up(motion, joint)))).collect())
    }

    /// Adds the torque of a direction, given by its part in each value, to that of a joint.
    pub fn add_to(&self, torque: &mut [f64], joint: usize, direction: DVectorView<'_, f64>) {
        for (part, torques) in direction.iter().zip(&self.0).filter(|(part, _)| **part != 0.0) {
            torque.iter_mut().zip(&torques[joint]).for_each(|(sum, x)| *sum += part * x);
        }
    }
}

/// [rad or m] Half of one standard deviation of the gap, on the flank of each row. A gap that the model file gives is of its own size.
fn half_gap(motion: &Motion, joint: usize, coulomb: f64) -> Vec<f64> {
    let model = &motion.model.joints[joint];
    let half = 0.5 * model.backlash.unwrap_or_else(|| of_kind(GAP, model.kind));
    motion.column(joint, |m, row| {
        let pressing = m.link_torque[row] + SHARE_BEHIND * coulomb * m.direction[row];
        half * (pressing / (CHANGE_OF_FLANK * coulomb).max(f64::MIN_POSITIVE)).tanh()
    })
}

/// [rad or m] One standard deviation of the wind-up, by the standard error of the gear's compliance; none behind a gear that carries nothing.
fn wind_up(motion: &Motion, joint: usize) -> Vec<f64> {
    let (model, m) = (&motion.model.joints[joint], &motion.joints[joint]);
    let inertia = median(m.link_inertia.clone());
    let softness = if inertia > 0.0 { model.compliance_error(motion.model.accuracy.stiffness, inertia) } else { 0.0 };
    m.link_torque.iter().map(|torque| softness * torque).collect()
}

const fn of_kind([revolute, prismatic]: [f64; 2], kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => revolute,
        JointKind::Prismatic => prismatic,
    }
}
