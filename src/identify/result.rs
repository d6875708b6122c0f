//! What an identification returns: the content of `report.json` and what a plot of it needs.

use serde::Serialize;

use super::backlash::BacklashIdentification;
use super::methods::MethodEstimate;
use super::points::Point;
use super::published::PublishedEstimates;
use super::quantity::Quantity;
use crate::gearhead::{Direction, Exponential, Friction, FrictionLaw, Lines};
use crate::robot::Model;
use crate::units::JointKind;

/// Two values of the same kind, one per direction of motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PerDirection<T> {
    /// Motion in the positive direction.
    pub positive: T,
    /// Motion in the negative direction; magnitudes against speed.
    pub negative: T,
}

impl<T> PerDirection<T> {
    /// The value of a direction.
    pub fn of(&self, direction: Direction) -> &T {
        match direction {
            Direction::Positive => &self.positive,
            Direction::Negative => &self.negative,
        }
    }

    /// Both values, positive direction first.
    pub fn each(&self) -> [&T; 2] {
        [&self.positive, &self.negative]
    }
}

/// The two-line law of equations 7 to 9 in one direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LinesEstimate {
    /// `a1` value at rest of the line of low speeds.
    pub a1: Quantity,
    /// `b1` slope of the line of low speeds.
    pub b1: Quantity,
    /// `a2` value at rest of the line of high speeds.
    pub a2: Quantity,
    /// `b2` slope of the line of high speeds.
    pub b2: Quantity,
    /// Speed at which the lines meet, equation 8.
    pub switch_velocity: Quantity,
    /// RMS difference to the true curve over the measured speeds, per cent of its RMS; where the truth is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve_error_percent: Option<f64>,
}

/// The exponential law of equation 6 in one direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExponentialEstimate {
    /// `F_C` Coulomb friction.
    pub coulomb: Quantity,
    /// `F_S` breakaway friction.
    pub breakaway: Quantity,
    /// `v_S` Stribeck velocity.
    pub stribeck_velocity: Quantity,
    /// `F_V` viscous friction.
    pub viscous: Quantity,
    /// RMS difference to the true curve over the measured speeds, per cent of its RMS; where the truth is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve_error_percent: Option<f64>,
}

impl LinesEstimate {
    /// The law with the estimated values.
    pub fn law(&self) -> Lines {
        Lines { a1: self.a1.value, b1: self.b1.value, a2: self.a2.value, b2: self.b2.value }
    }
}

impl ExponentialEstimate {
    /// The law with the estimated values.
    pub fn law(&self) -> Exponential {
        Exponential {
            coulomb: self.coulomb.value,
            breakaway: self.breakaway.value,
            stribeck_velocity: self.stribeck_velocity.value,
            viscous: self.viscous.value,
        }
    }
}

/// Which of the two laws describes the measurement points better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LawKind {
    /// Equation 6.
    Exponential,
    /// Equation 9.
    TwoLines,
}

/// Friction of a joint: both laws, and which of them the data prefer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrictionIdentification {
    /// The law with the smaller sum of absolute residuals; both have four coefficients a direction.
    pub preferred: LawKind,
    /// Equations 7 to 9.
    pub lines: PerDirection<LinesEstimate>,
    /// Equation 6.
    pub exponential: PerDirection<ExponentialEstimate>,
    /// [rad/s or m/s] smallest and largest speed measured: the laws are valid between them, and are compared with a truth there.
    pub speeds: [f64; 2],
}

impl FrictionIdentification {
    /// The law of either kind with its estimated values.
    pub fn law(&self, kind: LawKind) -> FrictionLaw {
        match kind {
            LawKind::Exponential => FrictionLaw::Exponential(self.exponential.each().map(ExponentialEstimate::law)),
            LawKind::TwoLines => FrictionLaw::TwoLines(self.lines.each().map(LinesEstimate::law)),
        }
    }

    /// The law that the data prefer.
    pub fn preferred_law(&self) -> FrictionLaw {
        self.law(self.preferred)
    }
}

/// What was identified on one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointIdentification {
    /// Name of the joint in the URDF.
    pub joint: String,
    /// Turning or sliding: decides the units.
    pub kind: JointKind,
    /// Friction of rotor and link together.
    pub friction: FrictionIdentification,
    /// `C_ii` of equation 11 [N·m·s²/rad² or N·s²/m²], beyond what the rigid-body model already explains.
    pub centrifugal: Quantity,
    /// The gap; absent where the data show no usable reversal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash: Option<BacklashIdentification>,
    /// What the paper's own estimators make of the same recordings.
    pub published: PublishedEstimates,
    /// What other methods of the literature make of them; those that find the motion that they need.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub methods: Vec<MethodEstimate>,
    /// The measurement points, one per steady window, in the order of time.
    pub points: Vec<Point>,
    /// What the reader should know: a channel that was missing, a sign that was recovered, windows that were dropped.
    pub notes: Vec<String>,
}

impl JointIdentification {
    /// Friction torque of a point minus the preferred law at its velocity [N·m or N].
    pub fn residual(&self, point: &Point) -> f64 {
        point.friction - self.friction.preferred_law().kinetic(point.velocity)
    }
}

/// The result of an identification.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identification {
    /// The joints that the data move, in the order of the model.
    pub joints: Vec<JointIdentification>,
    /// The joints that were moved at constant velocity and could not be identified.
    pub left_out: Vec<NotIdentified>,
}

/// A joint that was moved and could not be identified.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NotIdentified {
    /// The joint.
    pub joint: String,
    /// Why.
    pub reason: String,
}

impl Identification {
    /// The joint of that name.
    pub fn joint(&self, name: &str) -> Option<&JointIdentification> {
        self.joints.iter().find(|joint| joint.joint == name)
    }

    /// The model with the identified friction and gap. The share of the friction that acts on the link stays that of the model. If the
    /// model has no friction, the share is the one found at the reversals, or zero if none was found.
    pub fn apply(&self, model: &Model) -> Model {
        let mut model = model.clone();
        for found in &self.joints {
            let Some(index) = model.joints.iter().position(|joint| joint.name == found.joint) else { continue };
            let measured = found.backlash.as_ref().and_then(|backlash| backlash.link_share.as_ref());
            let measured = measured.map_or(0.0, |share| share.value.clamp(0.0, 1.0));
            let link_share = model.joints[index].friction.map_or(measured, |friction| friction.link_share);
            model.set_friction(index, Friction { law: found.friction.preferred_law(), link_share });
            if let Some(backlash) = &found.backlash {
                model.joints[index].backlash = Some(backlash.best.mean.value.max(0.0));
            }
        }
        model
    }
}
