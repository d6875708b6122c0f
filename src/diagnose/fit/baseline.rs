//! Free parameters of the nominal model: symmetric friction of equation 6, and the zero of a recorded torque.
//!
//! `τ_m − τ_rigid = (F_C + (F_S − F_C) e^{−|v|/v_S}) sgn v + F_V v (+ offset of the session, where a torque and not a current was recorded)`.
//! Where the model file gives no rotor inertia, `J q̈` joins them, `J` the rotor's inertia at the joint.
//! All parameters are linear except `v_S`, which is scanned (variable projection). Where the model file gives friction, its Stribeck part
//! is kept, and `F_C` and `F_V` are fitted again because they drift.

use crate::effects::{Motion, SymmetricFriction, falling as falling_column, falling_slope};
use crate::gearhead::{Direction, FrictionLaw};

/// How the falling part of friction enters the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Falling {
    /// Fitted, at the present value of the Stribeck velocity.
    Free(f64),
    /// As the model file gives it; the mean of both directions is subtracted from the torque first.
    Given(SymmetricFriction),
}

/// The free part of one joint's nominal model.
#[derive(Debug, Clone, PartialEq)]
pub struct JointBaseline {
    falling: Falling,
    /// Sessions whose torque has an offset of its own.
    pub offset_sessions: Vec<usize>,
    columns: Vec<Vec<f64>>,
    stribeck_derivative: Option<Vec<f64>>,
    target: Vec<f64>,
}

/// Positions in [`JointBaseline::columns`].
pub const COULOMB: usize = 0;
/// Viscous friction.
pub const VISCOUS: usize = 1;
/// `F_S − F_C`, where it is fitted.
pub const FALLING: usize = 2;

impl JointBaseline {
    /// The baseline of a joint; each of `sessions` has a torque offset of its own where no current was recorded.
    pub fn new(motion: &Motion, joint: usize, sessions: &[usize]) -> Self {
        let falling = match motion.model.joints[joint].friction {
            None => Falling::Free(stribeck_grid(motion, joint)[STRIBECK_STEPS / 2]),
            Some(friction) => Falling::Given(symmetric(&friction.law)),
        };
        let offset_sessions = if motion.joints[joint].has_current { Vec::new() } else { sessions.to_vec() };
        Self::with(motion, joint, falling, offset_sessions)
    }

    fn with(motion: &Motion, joint: usize, falling: Falling, offset_sessions: Vec<usize>) -> Self {
        let mut columns = vec![motion.joints[joint].direction.clone(), motion.joints[joint].v.clone()];
        let mut stribeck_derivative = None;
        let mut target = motion.column(joint, |m, row| m.torque[row] - m.rigid[row]);
        match falling {
            Falling::Free(v_s) => {
                columns.push(falling_column(motion, joint, v_s));
                stribeck_derivative = Some(falling_slope(motion, joint, v_s));
            }
            Falling::Given(law) => {
                let fixed = falling_column(motion, joint, law.stribeck_velocity);
                target.iter_mut().zip(fixed).for_each(|(e, x)| *e -= (law.breakaway - law.coulomb) * x);
            }
        }
        if motion.model.joints[joint].rotor_inertia.is_none() {
            columns.push(motion.joints[joint].a.clone());
        }
        for session in &offset_sessions {
            columns.push(motion.session.iter().map(|s| f64::from(u8::from(s == session))).collect());
        }
        Self { falling, offset_sessions, columns, stribeck_derivative, target }
    }

    /// The same baseline with another Stribeck velocity.
    pub fn at_stribeck_velocity(&self, motion: &Motion, joint: usize, v_s: f64) -> Self {
        Self::with(motion, joint, Falling::Free(v_s), self.offset_sessions.clone())
    }

    /// The falling part.
    pub fn falling(&self) -> Falling {
        self.falling
    }

    /// Number of columns.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// The columns, with one value per row.
    pub fn columns(&self) -> &[Vec<f64>] {
        &self.columns
    }

    /// Change of the friction column with the Stribeck velocity, per `F_S − F_C`.
    pub fn stribeck_derivative(&self) -> Option<&Vec<f64>> {
        self.stribeck_derivative.as_ref()
    }

    /// Left side of the regression: measured torque minus the part that the model file fixes.
    pub fn target(&self) -> &[f64] {
        &self.target
    }

    /// Position of the rotor's inertia in [`columns`](Self::columns), where it is fitted.
    pub fn rotor_at(&self) -> Option<usize> {
        let at = if matches!(self.falling, Falling::Free(_)) { FALLING + 1 } else { FALLING };
        (at + self.offset_sessions.len() < self.columns.len()).then_some(at)
    }

    /// The friction law of these coefficients.
    pub fn friction(&self, coefficients: &[f64]) -> SymmetricFriction {
        let (coulomb, viscous) = (coefficients[COULOMB], coefficients[VISCOUS]);
        match self.falling {
            Falling::Free(v_s) => SymmetricFriction {
                coulomb,
                breakaway: coulomb + coefficients[FALLING],
                stribeck_velocity: v_s,
                viscous,
            },
            Falling::Given(law) => {
                SymmetricFriction { coulomb, breakaway: coulomb + law.breakaway - law.coulomb, viscous, ..law }
            }
        }
    }
}

/// Number of Stribeck velocities that are scanned.
pub const STRIBECK_STEPS: usize = 24;

/// Stribeck velocities to scan: from 1/400 to 1/5 of the largest speed.
pub fn stribeck_grid(motion: &Motion, joint: usize) -> Vec<f64> {
    let fastest = motion.joints[joint].v.iter().fold(1e-9_f64, |most, v| most.max(v.abs()));
    let ratio = 80.0_f64.powf(1.0 / (STRIBECK_STEPS - 1) as f64);
    (0..STRIBECK_STEPS).map(|step| fastest / 400.0 * ratio.powi(step as i32)).collect()
}

/// Mean of both directions of motion.
fn symmetric(law: &FrictionLaw) -> SymmetricFriction {
    match law {
        FrictionLaw::Exponential([p, n]) => SymmetricFriction {
            coulomb: 0.5 * (p.coulomb + n.coulomb),
            breakaway: 0.5 * (p.breakaway + n.breakaway),
            stribeck_velocity: 0.5 * (p.stribeck_velocity + n.stribeck_velocity),
            viscous: 0.5 * (p.viscous + n.viscous),
        },
        FrictionLaw::TwoLines([p, n]) => {
            let at_rest = 0.5 * (law.magnitude(Direction::Positive, 0.0) + law.magnitude(Direction::Negative, 0.0));
            SymmetricFriction {
                coulomb: 0.5 * (p.a2 + n.a2),
                breakaway: at_rest,
                stribeck_velocity: 0.25 * (p.switch_velocity() + n.switch_velocity()),
                viscous: 0.5 * (p.b2 + n.b2),
            }
        }
    }
}
