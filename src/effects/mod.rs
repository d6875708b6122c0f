//! The catalogue of effects: possible causes of a difference between a measured arm and its simulation. One effect, one file.
//!
//! An effect has up to three traits. In the simulation it alters the model or acts on joints and readings ([`Effect::install`]), and it claims
//! measured phenomena. For a diagnosis, [`Diagnosable`] gives the torque that it adds to the measured motion, and `AtTurns` its action at
//! reversals; not every effect has these two.

pub mod about;
mod action;
mod catalogue;
#[cfg(test)]
pub mod drawn;
mod harmonic;
mod listed;
pub mod motion;
mod parameters;
mod phenomenon;
pub mod turns;

mod base_tilt;
mod cable_spring;
mod cogging;
mod coulomb_asymmetry;
mod counterbalance;
mod coupling_slip;
mod current_offset;
mod drive_dead_band;
mod dwell_stiction;
mod encoder_eccentricity;
mod external_contact;
mod falling;
mod joint_compliance;
mod kernel;
mod link_inertia;
mod load_dependent_friction;
mod payload;
mod periodic_disturbance;
mod position_dependent_backlash;
mod position_dependent_friction;
mod possible;
mod presliding;
mod quadratic_drag;
mod regularised_friction;
mod rotor_inertia;
mod sensor_delay;
mod stribeck;
mod thermal_friction_drift;
mod torque_constant_error;
mod torque_ripple;
mod transmission_error;
pub mod velocity_lag;
mod viscous_asymmetry;

pub use about::{About, Experiment, Kind, ParameterSpec, Scope};
pub use action::{
    Action, DriveAction, EncoderAction, GearAction, JointAction, JointState, Reading, SensorAction, Stop,
};
pub use catalogue::Catalogue;
pub use falling::{falling, falling_slope};
pub use harmonic::{Columns, Harmonic};
pub use kernel::kernel_gain;
pub use listed::{Applied, applied, install_listed};
pub use motion::{JointMotion, LeftOut, Motion, SymmetricFriction};
pub use parameters::Parameters;
pub use phenomenon::{Claim, Phenomenon};
pub use sensor_delay::{SENSOR_DELAY, take_current_delay, take_position_delay};
pub use torque_constant_error::FAR_OFF as TORQUE_CONSTANT_FAR_OFF;
pub use turns::{AtTurns, Trial, Turns};

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use crate::error::Result;
use crate::robot::Model;

/// The effects of this crate, in alphabetical order; a [`Catalogue`] contains these and others.
pub static CATALOGUE: &[&dyn Effect] = &[
    &base_tilt::BaseTilt,
    &cable_spring::CableSpring,
    &cogging::Cogging,
    &coulomb_asymmetry::CoulombAsymmetry,
    &counterbalance::Counterbalance,
    &coupling_slip::CouplingSlip,
    &current_offset::CurrentOffset,
    &drive_dead_band::DriveDeadBand,
    &dwell_stiction::DwellStiction,
    &encoder_eccentricity::EncoderEccentricity,
    &external_contact::ExternalContact,
    &joint_compliance::JointCompliance,
    &link_inertia::LinkInertia,
    &load_dependent_friction::LoadDependentFriction,
    &payload::Payload,
    &periodic_disturbance::PeriodicDisturbance,
    &position_dependent_backlash::PositionDependentBacklash,
    &position_dependent_friction::PositionDependentFriction,
    &presliding::Presliding,
    &quadratic_drag::QuadraticDrag,
    &regularised_friction::RegularisedFriction,
    &rotor_inertia::RotorInertia,
    &sensor_delay::SensorDelay,
    &stribeck::Stribeck,
    &thermal_friction_drift::ThermalFrictionDrift,
    &torque_constant_error::TorqueConstantError,
    &torque_ripple::TorqueRipple,
    &transmission_error::TransmissionError,
    &velocity_lag::VelocityLag,
    &viscous_asymmetry::ViscousAsymmetry,
];

/// The effect of this crate with a given name.
pub fn find(name: &str) -> Option<&'static dyn Effect> {
    CATALOGUE.iter().copied().find(|effect| effect.name() == name)
}

/// An entry of the catalogue: a difference between machine and nominal model that can be simulated.
///
/// Other crates can add their own: [`Catalogue::with`] adds an effect to those that simulation and diagnosis know.
pub trait Effect: Sync {
    /// Description of the effect.
    fn about(&self) -> &'static About;

    /// Its name, which is stable: `lostmotion list effects`, model files and reports use it.
    fn name(&self) -> &'static str {
        self.about().name
    }

    /// Installs it in a machine: alters the model and returns the actions that run while it moves.
    ///
    /// # Errors
    /// A parameter is missing, unknown or out of its range; the joint is missing where one is needed.
    fn install(
        &self,
        model: &mut Model,
        joint: Option<usize>,
        parameters: &BTreeMap<String, f64>,
    ) -> Result<Vec<Action>>;

    /// Experiments that show it or separate it from others, best first; an empty list means any experiment.
    fn shown_by(&self) -> &'static [Experiment] {
        &[]
    }

    /// Its second trait, if it has one: the torque by which a diagnosis identifies it.
    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        None
    }

    /// Its third trait, if it has one: a diagnosis identifies it at the reversals of a joint.
    fn at_turns(&self) -> Option<&dyn AtTurns> {
        None
    }

    /// Its parameters if it causes this phenomenon; `None` if it does not.
    fn claims(&self, _phenomenon: &Phenomenon) -> Option<Claim> {
        None
    }

    /// Whether a diagnosis can identify it only with a second encoder behind the gear.
    fn needs_link_encoder(&self) -> bool {
        let mut claimed = Phenomenon::KINDS.iter().filter(|kind| self.claims(kind).is_some()).peekable();
        let by_motor = self.diagnosable().is_some() || self.at_turns().is_some();
        !by_motor && claimed.peek().is_some() && claimed.all(Phenomenon::needs_link_encoder)
    }

    /// Whether a diagnosis can identify it by any method.
    fn can_be_told(&self) -> bool {
        self.diagnosable().is_some()
            || self.at_turns().is_some()
            || Phenomenon::KINDS.iter().any(|kind| self.claims(kind).is_some())
    }
}

/// An effect that a diagnosis can identify by the torque that it adds.
///
/// It adds `Σ c_k · column_k` to the torque that the baseline needs for the measured motion.
/// The coefficients `c_k` are linear. A nonlinear parameter (an order, a radius) is a *shape*: a few starting values to scan, then refined.
pub trait Diagnosable: Effect {
    /// Whether the nominal model lacks it on this joint and the recording could show it.
    fn applies(&self, _motion: &Motion, _joint: usize) -> bool {
        true
    }

    /// Shapes to scan; one empty shape if all parameters are linear.
    fn shapes(&self, _motion: &Motion, _joint: usize) -> Vec<Vec<f64>> {
        vec![Vec::new()]
    }

    /// Whether a shape may be refined between the scanned ones.
    fn refines(&self) -> bool {
        true
    }

    /// Whether a shape is one that the machine gives, such as a turn of its motor. It then is no free parameter of the effect.
    fn is_given(&self, _motion: &Motion, _joint: usize, _shape: &[f64]) -> bool {
        false
    }

    /// How it repeats with the angle of its joint, if it does.
    fn harmonic(&self) -> Option<Harmonic> {
        None
    }

    /// Whether it may differ between two recordings of one machine.
    fn can_change(&self) -> bool {
        true
    }

    /// Whether it may be named several times on one machine or joint: with another order, on another link.
    fn several(&self) -> bool {
        self.harmonic().is_some_and(|harmonic| harmonic.several)
    }

    /// Names of effects that are likelier beforehand: one of them is named instead where its error is no larger than inaccurate laws make it.
    fn yields_to(&self) -> &'static [&'static str] {
        &[]
    }

    /// Whether it loads a link, also at rest, and so may hold it on one flank of its gear. An effect of one joint that does so acts on the
    /// joint, not on
    /// the axis of its motor: where axes are coupled, its [`columns`](Self::columns) are torques on the joint, and [`Motion::link`] is its position.
    fn loads_link(&self) -> bool {
        false
    }

    /// Whether a torque that is measured behind the gear shows it, as it shows a load on the link. A delay is not sought there: an elastic
    /// gear between the motor's encoder and the sensor looks like a delay of some tenths of a millisecond.
    fn shows_behind_gear(&self) -> bool {
        self.loads_link()
    }

    /// Torque on a joint [N·m or N] per unit of each coefficient, one value per row, which depends on that row only: the torque that the
    /// motor must add to the baseline. For an effect of the whole machine the coefficients are the same on every joint.
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>>;

    /// A better shape, where the coefficients that were fitted with this one give it.
    fn improved(&self, _motion: &Motion, _shape: &[f64], _coefficients: &[f64]) -> Option<Vec<f64>> {
        None
    }

    /// Coefficients that are expected near 0, by their index, each with the inverse of its variance.
    fn priors(&self, _shape: &[f64]) -> Vec<(usize, f64)> {
        Vec::new()
    }

    /// The columns of all joints, for an effect that computes them in one pass: `columns[joint][coefficient][row]`.
    fn columns_of_all(&self, _motion: &Motion, _shape: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        None
    }

    /// Torque by which each change of the bodies' parameters (a column, ten rows a body) alters the torque of these coefficients, for an effect whose
    /// torque is proportional to masses: `torque[joint][change][row]`.
    fn on_changed_bodies(
        &self,
        _motion: &Motion,
        _changes: &DMatrix<f64>,
        _coefficients: &[f64],
    ) -> Option<Vec<Vec<Vec<f64>>>> {
        None
    }

    /// Number of shape entries that may be refined, counted from the first; the entries after them are discrete choices.
    fn refined_shapes(&self, shape: &[f64]) -> usize {
        if self.refines() { shape.len() } else { 0 }
    }

    /// True torque of its joint relative to the torque that the nominal model computes from the current. Parameters fitted in nominal torque,
    /// mainly friction, have to be multiplied by it in a model with this effect.
    fn torque_factor(&self, _parameters: &[f64]) -> f64 {
        1.0
    }

    /// Whether these values are those of such an effect, beyond the ranges of its parameters.
    fn is_itself(&self, _motion: &Motion, _joint: usize, _shape: &[f64], _coefficients: &[f64]) -> bool {
        true
    }

    /// Coefficients of the nearest one that can exist, with the precision that the rows give them [1/coefficient²]; `None` where these are such.
    fn nearest_possible(
        &self,
        _motion: &Motion,
        _shape: &[f64],
        _coefficients: &[f64],
        _precision: &DMatrix<f64>,
    ) -> Option<Vec<f64>> {
        None
    }

    /// [A] Reading of the current sensor of its joint while no current flows.
    fn reading_at_rest(&self, _coefficients: &[f64]) -> f64 {
        0.0
    }

    /// Names of parameters that are angles (or positions) of the link: the rotor's angle determines them only to half a gap.
    fn angles_of_link(&self) -> &'static [&'static str] {
        &[]
    }

    /// Its parameters from the coefficients, in the order of [`About::parameters`]; parameters with a default may be missing at the end.
    fn parameters(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64>;
}
