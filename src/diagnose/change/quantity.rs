//! Quantities that the baseline fits freely and that may change: the terms of symmetric friction, and the rotor's inertia.
//!
//! ```text
//!   coulomb             ΔF_C · sgn v                          breakaway          ΔF_S · sgn v e^{−|v|/v_S}
//!   stribeck_velocity   Δv_S · (F_S − F_C) |v|/v_S² e^{−|v|/v_S} sgn v      (to first order)
//!   viscous             ΔF_V · v                              rotor_inertia      ΔJ_r · (J/J_r) θ̈,  J the inertia at the joint
//! ```
//! Each is treated as an effect of a joint with one coefficient: the change, positive for an increase.

use std::collections::BTreeMap;

use crate::diagnose::fit::baseline::{COULOMB, FALLING, Falling, VISCOUS};
use crate::diagnose::fit::problem::Problem;
use crate::effects::{About, Action, Diagnosable, Effect, Kind, Motion, ParameterSpec, Scope};
use crate::error::Result;
use crate::robot::Model;
use crate::units::JointKind;

/// Kind of quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum What {
    Coulomb,
    Breakaway,
    StribeckVelocity,
    Viscous,
    RotorInertia,
}

/// A free quantity of the baseline.
pub struct MachineQuantity {
    what: What,
    about: &'static About,
    /// [1] Relative natural variation from day to day: one standard deviation.
    pub natural: f64,
}

const fn about(
    name: &'static str,
    equation: &'static str,
    summary: &'static str,
    parameters: &'static [ParameterSpec],
) -> About {
    About {
        name,
        summary,
        equation,
        kind: Kind::Physics,
        scope: Scope::Joint,
        parameters,
        signature: "a term of the baseline that is larger or smaller than in the reference",
        look_alikes: &[],
        separate_by: "repeat both recordings with the same motions, slow and fast, both directions",
        reference: "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit (1994), A survey of models, analysis tools and compensation methods for the control of machines with friction",
    }
}

const CHANGE: &str = "value now minus value in the reference";
const EFFORT: &[ParameterSpec] = &[ParameterSpec::new("change", "Δ", "N·m", CHANGE)];
const SPEED: &[ParameterSpec] = &[ParameterSpec::new("change", "Δ", "rad/s", CHANGE)];
const DAMPING: &[ParameterSpec] = &[ParameterSpec::new("change", "Δ", "N·m·s/rad", CHANGE)];
const INERTIA: &[ParameterSpec] = &[ParameterSpec::new("change", "Δ", "kg·m²", CHANGE)];

/// All quantities. Natural variations: the Coulomb level of the EMPS axis differs by up to 5 % between two days (A. Janot 2019),
/// hence 2 % as one standard deviation; viscous friction varies by 3 % per kelvin of the grease. An inertia does not vary, but 1 % is the
/// difference between two motions for an arm that is not perfectly rigid.
pub static QUANTITIES: [MachineQuantity; 5] = [
    MachineQuantity {
        what: What::Coulomb,
        about: &about("coulomb", "F_C → F_C + Δ", "Coulomb friction has changed.", EFFORT),
        natural: 0.02,
    },
    MachineQuantity {
        what: What::Breakaway,
        about: &about("breakaway", "F_S → F_S + Δ", "Breakaway friction has changed.", EFFORT),
        natural: 0.03,
    },
    MachineQuantity {
        what: What::StribeckVelocity,
        about: &about("stribeck_velocity", "v_S → v_S + Δ", "The speed at which friction falls has changed.", SPEED),
        natural: 0.1,
    },
    MachineQuantity {
        what: What::Viscous,
        about: &about("viscous", "F_V → F_V + Δ", "Viscous friction has changed.", DAMPING),
        natural: 0.03,
    },
    MachineQuantity {
        what: What::RotorInertia,
        about: &about("rotor_inertia", "J_r → J_r + Δ", "The rotor's inertia has changed.", INERTIA),
        natural: 0.01,
    },
];

/// The quantity of a given name.
pub fn find(name: &str) -> Option<&'static MachineQuantity> {
    QUANTITIES.iter().find(|quantity| quantity.about.name == name)
}

/// The linear terms of friction.
pub fn levels() -> impl Iterator<Item = &'static MachineQuantity> {
    QUANTITIES.iter().filter(|quantity| matches!(quantity.what, What::Coulomb | What::Breakaway | What::Viscous))
}

/// The inertia of a rotor. Its error is fitted on both sides together, so that a wrong nominal value is not taken for a change.
pub fn rotor_inertia() -> &'static MachineQuantity {
    &QUANTITIES[4]
}

impl MachineQuantity {
    /// Its value in the baseline of a joint, and the derivative by the coefficients of that baseline in a loose fit.
    /// A rotor's inertia is not in the baseline: it has its nominal value.
    pub fn reference(&self, problem: &Problem, joint: usize) -> (f64, Vec<(usize, f64)>) {
        let law = problem.motion.joints[joint].friction;
        let baseline = &problem.baseline[joint];
        let free = matches!(baseline.falling(), Falling::Free(_));
        let fall = law.breakaway - law.coulomb;
        match self.what {
            What::Coulomb => (law.coulomb, vec![(COULOMB, 1.0)]),
            What::Breakaway if free => (law.breakaway, vec![(COULOMB, 1.0), (FALLING, 1.0)]),
            What::Breakaway => (law.breakaway, vec![(COULOMB, 1.0)]),
            What::StribeckVelocity if free => (law.stribeck_velocity, vec![(baseline.len(), 1.0 / fall)]),
            What::StribeckVelocity => (law.stribeck_velocity, Vec::new()),
            What::Viscous => (law.viscous, vec![(VISCOUS, 1.0)]),
            What::RotorInertia => (problem.motion.model.joints[joint].rotor_inertia.unwrap_or(0.0), Vec::new()),
        }
    }

    /// Whether a change of `other` changes this quantity too: the falling part is on top of the Coulomb level.
    pub fn follows(&self, other: &Self) -> bool {
        self.what == What::Breakaway && other.what == What::Coulomb
    }

    /// Whether it is part of the baseline; the rotor's inertia is fitted beside the baseline.
    pub fn is_of_baseline(&self) -> bool {
        self.what != What::RotorInertia
    }

    /// Its unit.
    pub fn unit(&self, kind: JointKind) -> &'static str {
        self.about.parameters[0].unit_for(kind)
    }

    /// Writes its value into a model.
    pub fn write(&self, model: &mut Model, joint: usize, value: f64) {
        use crate::gearhead::FrictionLaw;
        let joint = &mut model.joints[joint];
        if self.what == What::RotorInertia {
            joint.rotor_inertia = Some(value.max(0.0));
            return;
        }
        let Some(friction) = &mut joint.friction else { return };
        let FrictionLaw::Exponential(sides) = &mut friction.law else { return };
        for side in sides {
            match self.what {
                What::Coulomb => side.coulomb = value.max(0.0),
                What::Breakaway => side.breakaway = value.max(0.0),
                What::StribeckVelocity => side.stribeck_velocity = value.max(1e-9),
                What::Viscous => side.viscous = value.max(0.0),
                What::RotorInertia => {}
            }
        }
    }
}

impl Effect for MachineQuantity {
    fn about(&self) -> &'static About {
        self.about
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        use crate::gearhead::FrictionLaw;
        let change = crate::effects::Parameters::check(self.about, model, given)?.get("change");
        let Some(index) = joint else { return Ok(Vec::new()) };
        let law = match model.joints[index].friction.map(|friction| friction.law) {
            Some(FrictionLaw::Exponential([side, _])) => Some(side),
            _ => None,
        };
        let before = match (self.what, law) {
            (What::RotorInertia, _) => match model.joints[index].rotor_inertia {
                Some(inertia) => inertia,
                None => return Ok(Vec::new()),
            },
            (What::Coulomb, Some(law)) => law.coulomb,
            (What::Breakaway, Some(law)) => law.breakaway,
            (What::StribeckVelocity, Some(law)) => law.stribeck_velocity,
            (What::Viscous, Some(law)) => law.viscous,
            (_, None) => return Ok(Vec::new()),
        };
        self.write(model, index, before + change);
        Ok(Vec::new())
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for MachineQuantity {
    fn applies(&self, motion: &Motion, joint: usize) -> bool {
        let law = motion.joints[joint].friction;
        match self.what {
            What::Coulomb | What::Viscous | What::Breakaway => true,
            // Where friction hardly falls, the Stribeck velocity is not determined.
            What::StribeckVelocity => law.breakaway > 1.03 * law.coulomb,
            // An unknown inertia is in the baseline, which both sides share.
            What::RotorInertia => motion.model.joints[joint].rotor_inertia.is_some_and(|inertia| inertia > 0.0),
        }
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        let law = motion.joints[joint].friction;
        let v_s = law.stribeck_velocity;
        let model = &motion.model.joints[joint];
        let seen = model.reflected_inertia() / model.rotor_inertia.unwrap_or(0.0).max(1e-300);
        vec![motion.column(joint, |m, row| {
            let speed = m.v[row].abs();
            let falling = m.direction[row] * (-speed / v_s).exp();
            match self.what {
                What::Coulomb => m.direction[row],
                What::Viscous => m.v[row],
                What::Breakaway => falling,
                What::StribeckVelocity => (law.breakaway - law.coulomb) * speed / (v_s * v_s) * falling,
                What::RotorInertia => seen * m.a[row],
            }
        })]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0]]
    }
}
