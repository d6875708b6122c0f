//! The motor gives more or less torque per current than in the model: a warm magnet, another winding.
//!
//! `K_t → K_t (1 + a)` of the machine, with its back-EMF. The sensor still reads amperes, and a conversion to torque
//! with the nominal constant scales everything by `1/(1 + a)`: friction, inertia, gravity. The part that the nominal model fixes then has
//! an error of `c · τ_fixed`, `c = 1/(1 + a) − 1`. Friction that is fitted contains its part of the error, and has to be multiplied by `1 + a` in
//! the model with the true constant.
//! Left out: saturation of the iron, which reduces `K_t` at high current.
//! Reference: M. Gautier, S. Briot (2014), Global identification of joint drive gains and dynamic parameters of robots.

use std::collections::BTreeMap;

use super::parameters::{need, need_joint};
use super::{About, Action, Diagnosable, Effect, Experiment, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "torque_constant_error",
    summary: "The motor's torque constant differs from what the model says.",
    equation: "K_t → K_t (1 + a)",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[ParameterSpec::new("error", "a", "1", "relative error, positive where a current makes more torque")
        .between(-0.9, 10.0)],
    signature: "all torque of the joint is scaled: friction, inertia and gravity by one factor",
    look_alikes: &["payload", "rotor_inertia", "load_dependent_friction"],
    separate_by: "add a known mass or lift a known weight: the torque that it adds is scaled too; or measure the back-EMF",
    reference: "M. Gautier, S. Briot (2014), Global identification of joint drive gains and dynamic parameters of robots",
};

/// [1] Factor by which a torque constant is never off: magnets, temperature and tables of other windings make a few tenths.
pub const FAR_OFF: f64 = 2.0;

/// The torque constant differs.
pub struct TorqueConstantError;

impl Effect for TorqueConstantError {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let a = Parameters::check(&ABOUT, model, given)?.get("error");
        let joint = need_joint(&ABOUT, model, joint)?;
        let key = format!("joints.{}.motor.torque_constant", model.joints[joint].name);
        let motor = need(&ABOUT, &model.source, key, model.joints[joint].motor.as_mut())?;
        motor.torque_constant *= 1.0 + a;
        Ok(Vec::new())
    }

    fn shown_by(&self) -> &'static [Experiment] {
        &[Experiment::AddedMass, Experiment::Fast, Experiment::OneByOne]
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for TorqueConstantError {
    /// Where a torque was recorded, the constant was not used; where the model file guesses it, no value is an error.
    fn applies(&self, motion: &Motion, joint: usize) -> bool {
        let is_known = motion.model.joints[joint].motor.is_some() && !motion.model.accuracy.guesses_torque_constants();
        motion.joints[joint].has_current && is_known
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        let given = motion.model.joints[joint].friction.is_some();
        vec![motion.column(joint, |m, row| {
            // If the model file gives friction, its falling part is not fitted.
            let law = m.friction;
            let falling = if given { law.dry(m.v[row]) - law.coulomb } else { 0.0 };
            m.rigid[row] + falling * m.direction[row]
        })]
    }

    fn torque_factor(&self, parameters: &[f64]) -> f64 {
        1.0 + parameters[0]
    }

    /// Where the rigid body would need a factor beyond [`FAR_OFF`], it is the rigid body that is wrong, or a unit: friction of any size hides the
    /// scale of a torque that is mostly friction.
    fn is_itself(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> bool {
        let factor = 1.0 + self.parameters(motion, joint, shape, coefficients)[0];
        (1.0 / FAR_OFF..=FAR_OFF).contains(&factor)
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let c = coefficients[0];
        vec![-c / (1.0 + c)]
    }
}
