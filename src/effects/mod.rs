//! The catalogue: what can make a measured arm differ from its simulation. One effect, one file.
//!
//! An effect has two faces. In the simulation it alters the model or acts on joints and readings ([`Effect::install`]).
//! In a diagnosis it says which torque it would add to the measured motion ([`Diagnosable`]); not every effect can.

pub mod about;
mod action;
mod catalogue;
mod harmonic;
pub mod motion;
mod parameters;
mod phenomenon;
pub mod turns;

mod base_tilt;
mod cable_spring;
mod cogging;
mod coulomb_asymmetry;
mod coupling_slip;
mod current_offset;
mod drive_dead_band;
mod dwell_stiction;
mod encoder_eccentricity;
mod external_contact;
mod falling;
mod joint_compliance;
mod load_dependent_friction;
mod payload;
mod periodic_disturbance;
mod position_dependent_backlash;
mod position_dependent_friction;
mod presliding;
mod quadratic_drag;
mod rotor_inertia;
mod sensor_delay;
mod stribeck;
mod thermal_friction_drift;
mod torque_constant_error;
mod torque_ripple;
mod transmission_error;
mod viscous_asymmetry;

pub use about::{About, Experiment, Kind, ParameterSpec, Scope};
pub use action::{
    Action, DriveAction, EncoderAction, GearAction, JointAction, JointState, Reading, SensorAction, Stop,
};
pub use catalogue::Catalogue;
pub use falling::{falling, falling_slope};
pub use harmonic::Harmonic;
pub use motion::{JointMotion, Motion, SymmetricFriction};
pub use parameters::Parameters;
pub use phenomenon::{Claim, Phenomenon};
pub use turns::{AtTurns, Trial, Turns};

use std::collections::BTreeMap;

use crate::error::Result;
use crate::robot::Model;

/// The effects of this crate, in alphabetical order; [`Catalogue`] holds those and others.
pub static CATALOGUE: &[&dyn Effect] = &[
    &base_tilt::BaseTilt,
    &cable_spring::CableSpring,
    &cogging::Cogging,
    &coulomb_asymmetry::CoulombAsymmetry,
    &coupling_slip::CouplingSlip,
    &current_offset::CurrentOffset,
    &drive_dead_band::DriveDeadBand,
    &dwell_stiction::DwellStiction,
    &encoder_eccentricity::EncoderEccentricity,
    &external_contact::ExternalContact,
    &joint_compliance::JointCompliance,
    &load_dependent_friction::LoadDependentFriction,
    &payload::Payload,
    &periodic_disturbance::PeriodicDisturbance,
    &position_dependent_backlash::PositionDependentBacklash,
    &position_dependent_friction::PositionDependentFriction,
    &presliding::Presliding,
    &quadratic_drag::QuadraticDrag,
    &rotor_inertia::RotorInertia,
    &sensor_delay::SensorDelay,
    &stribeck::Stribeck,
    &thermal_friction_drift::ThermalFrictionDrift,
    &torque_constant_error::TorqueConstantError,
    &torque_ripple::TorqueRipple,
    &transmission_error::TransmissionError,
    &viscous_asymmetry::ViscousAsymmetry,
];

/// The effect of this crate of that name.
pub fn find(name: &str) -> Option<&'static dyn Effect> {
    CATALOGUE.iter().copied().find(|effect| effect.name() == name)
}

/// An entry of the catalogue: a difference between machine and nominal model that can be simulated.
///
/// Any crate can have its own: [`Catalogue::with`] adds it to those that simulation and diagnosis know.
pub trait Effect: Sync {
    /// What is known about it.
    fn about(&self) -> &'static About;

    /// Its name, a contract: `lostmotion list effects`, model files, reports.
    fn name(&self) -> &'static str {
        self.about().name
    }

    /// Puts it into a machine: alters the model, returns what acts while it moves.
    ///
    /// # Errors
    /// A parameter is missing, unknown or out of its range; the joint is missing where one is needed.
    fn install(
        &self,
        model: &mut Model,
        joint: Option<usize>,
        parameters: &BTreeMap<String, f64>,
    ) -> Result<Vec<Action>>;

    /// Experiments that show it or tell it from others, the best first; none: any may.
    fn shown_by(&self) -> &'static [Experiment] {
        &[]
    }

    /// Its other face, where it has one: how a diagnosis tells it.
    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        None
    }

    /// Its third face, where it has one: how a diagnosis tells it by the turns of a joint.
    fn at_turns(&self) -> Option<&dyn AtTurns> {
        None
    }

    /// Its parameters where it causes this phenomenon; `None` where it is not the cause.
    fn claims(&self, _phenomenon: &Phenomenon) -> Option<Claim> {
        None
    }

    /// Whether a diagnosis can identify it by a second encoder behind the gear only.
    fn needs_link_encoder(&self) -> bool {
        let mut claimed = Phenomenon::KINDS.iter().filter(|kind| self.claims(kind).is_some()).peekable();
        let by_motor = self.diagnosable().is_some() || self.at_turns().is_some();
        !by_motor && claimed.peek().is_some() && claimed.all(Phenomenon::needs_link_encoder)
    }

    /// Whether a diagnosis can identify it, one way or another.
    fn can_be_told(&self) -> bool {
        self.diagnosable().is_some()
            || self.at_turns().is_some()
            || Phenomenon::KINDS.iter().any(|kind| self.claims(kind).is_some())
    }
}

/// An effect that a diagnosis can tell by the torque that it adds.
///
/// It adds `Σ c_k · column_k` to the torque that the baseline needs for the measured motion.
/// The coefficients `c_k` are linear; what is not linear (an order, a radius) is a *shape*: a few starting values to scan, then refined.
pub trait Diagnosable: Effect {
    /// Whether the nominal model lacks it on this joint and the recording could show it.
    fn applies(&self, _motion: &Motion, _joint: usize) -> bool {
        true
    }

    /// Shapes to scan; one empty shape where everything is linear.
    fn shapes(&self, _motion: &Motion, _joint: usize) -> Vec<Vec<f64>> {
        vec![Vec::new()]
    }

    /// Whether a shape may be refined between the scanned ones.
    fn refines(&self) -> bool {
        true
    }

    /// How it repeats with the angle of its joint, where it does.
    fn harmonic(&self) -> Option<Harmonic> {
        None
    }

    /// Whether it pushes a link, at rest too, and so may hold it on one flank of its gear.
    fn loads_link(&self) -> bool {
        false
    }

    /// Torque on a joint [N·m or N] per unit of each coefficient, one value a row, which depends on that row alone: what the motor must add to the baseline.
    /// For an effect of the whole machine the coefficients are the same on every joint.
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>>;

    /// How many entries of a shape are numbers that may be refined, counted from the first; those after them are choices.
    fn refined_shapes(&self, shape: &[f64]) -> usize {
        if self.refines() { shape.len() } else { 0 }
    }

    /// True torque of its joint over what the nominal model makes of the current: what was fitted in nominal torque, friction before
    /// all, has to be multiplied by it in a model that has this effect.
    fn torque_factor(&self, _parameters: &[f64]) -> f64 {
        1.0
    }

    /// Whether an effect of this strength is what its name says, beyond the ranges of its parameters.
    fn is_itself(&self, _motion: &Motion, _joint: usize, _shape: &[f64], _coefficients: &[f64]) -> bool {
        true
    }

    /// [A] What the current sensor of its joint reads while no current flows.
    fn reading_at_rest(&self, _coefficients: &[f64]) -> f64 {
        0.0
    }

    /// Names of parameters that are angles (or places) of the link: the rotor's tell them to half a gap.
    fn angles_of_link(&self) -> &'static [&'static str] {
        &[]
    }

    /// Its parameters from the coefficients, in the order of [`About::parameters`]; those with a default may be missing at the end.
    fn parameters(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64>;
}
