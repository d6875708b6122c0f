//! Other methods of the literature, on the recordings that the program's own estimators use.
//!
//! | method | gives | from |
//! |---|---|---|
//! | [`SwitchingLeastSquares`](Method::SwitchingLeastSquares) | gap | reversals with gentle braking, as those of a staircase |
//! | [`LimitCycle`](Method::LimitCycle) | gap | a square wave of torque that moves the motor within its gap |
//! | [`Lugre`](Method::Lugre) | stiffness and damping of bristles | slow reversals of a torque that makes nothing slip; small steps of it |
//!
//! A method looks for the motion that it needs in every session. Without such a motion it is not listed; where the motion is there and
//! the data do not determine the quantity, it says why and what would be needed, and gives no number. Nothing else depends on it.

mod limit_cycle;
mod lugre;
mod motion;
mod switching;

use serde::Serialize;

use super::quantity::Quantity;
use super::result::FrictionIdentification;
use crate::gearhead::Direction;
use crate::robot::{EffectEntry, JointModel, Model};
use crate::timeseries::TimeSeries;

/// Name of the effect whose parameters are those of the bristles.
const PRESLIDING: &str = "presliding";

/// A method of the literature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The gap by iterated linear least squares with switching functions, J. Vörös (2010).
    SwitchingLeastSquares,
    /// The gap from an oscillation of the motor within it, M. Ruderman, S. Yamada, H. Fujimoto (2019).
    LimitCycle,
    /// Presliding of the LuGre model, C. Canudas de Wit and others (1995, 1997).
    Lugre,
}

/// What a method makes of the recordings of a joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodEstimate {
    /// Name of the method.
    pub method: &'static str,
    /// Author, year, title.
    pub reference: &'static str,
    /// [s] Duration of the sessions that it uses.
    pub duration: f64,
    /// `b` [rad or m] total gap at the joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash: Option<Quantity>,
    /// `σ0` [N·m/rad or N/m] stiffness of the bristles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<Quantity>,
    /// `σ1` [N·m·s/rad or N·s/m] damping of the bristles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<Quantity>,
    /// Why it gives nothing, and what would be needed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
}

impl Method {
    /// All of them, in the order of the report.
    pub const ALL: [Self; 3] = [Self::SwitchingLeastSquares, Self::LimitCycle, Self::Lugre];

    /// Its name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SwitchingLeastSquares => "switching_least_squares",
            Self::LimitCycle => "limit_cycle",
            Self::Lugre => "lugre",
        }
    }

    /// The quantities that it estimates, by the names of [`MethodEstimate::quantities`].
    pub const fn estimates(self) -> &'static [&'static str] {
        match self {
            Self::SwitchingLeastSquares | Self::LimitCycle => &["gap"],
            Self::Lugre => &["stiffness", "damping"],
        }
    }

    /// Where it is published.
    pub const fn reference(self) -> &'static str {
        match self {
            Self::SwitchingLeastSquares => {
                "J. Vörös (2010), Modeling and identification of systems with backlash, Automatica 46"
            }
            Self::LimitCycle => {
                "M. Ruderman, S. Yamada, H. Fujimoto (2019), Backlash identification in two-mass systems by delayed relay feedback, \
                 ASME J. Dyn. Syst. Meas. Control 141"
            }
            Self::Lugre => {
                "C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky (1995), A new model for control of systems with friction, \
                 IEEE Trans. Automatic Control 40"
            }
        }
    }

    /// What it makes of the recordings of a joint with this friction in steady motion. `None` where no session has the motion that it
    /// needs.
    pub fn estimate(
        self,
        model: &Model,
        joint: usize,
        data: &[TimeSeries],
        friction: &FrictionIdentification,
    ) -> Option<MethodEstimate> {
        let mut found = MethodEstimate {
            method: self.name(),
            reference: self.reference(),
            duration: 0.0,
            backlash: None,
            stiffness: None,
            damping: None,
            refused: None,
        };
        let law = friction.preferred_law();
        let gap: Result<Quantity, String>;
        (found.duration, gap) = match self {
            Self::SwitchingLeastSquares => {
                let known = switching::Known { law: &law, slowest: friction.speeds[0] };
                switching::estimate(model, joint, data, &known)?
            }
            Self::LimitCycle => {
                let at_rest = [Direction::Positive, Direction::Negative].map(|side| law.magnitude(side, 0.0));
                limit_cycle::estimate(model, joint, data, at_rest[0].min(at_rest[1]))?
            }
            Self::Lugre => {
                let (duration, bristles) = lugre::estimate(model, joint, data, &law)?;
                found.duration = duration;
                match bristles {
                    Ok(bristles) => (found.stiffness, found.damping) = (Some(bristles.stiffness), bristles.damping),
                    Err(why) => found.refused = Some(why),
                }
                return Some(found);
            }
        };
        match gap {
            Ok(gap) => found.backlash = Some(gap),
            Err(why) => found.refused = Some(why),
        }
        Some(found)
    }
}

impl MethodEstimate {
    /// What was estimated, by the name of its row.
    pub fn quantities(&self) -> impl Iterator<Item = (&'static str, &Quantity)> {
        let all = [("gap", &self.backlash), ("stiffness", &self.stiffness), ("damping", &self.damping)];
        all.into_iter().filter_map(|(name, found)| Some((name, found.as_ref()?)))
    }

    /// Writes the true values beside the estimates, where the joint or the machine's effects have them.
    pub(super) fn compare(&mut self, truth: &JointModel, effects: &[EffectEntry]) {
        let own = |one: &&EffectEntry| one.effect == PRESLIDING && one.joint.as_deref() == Some(truth.name.as_str());
        if let Some(bristles) = effects.iter().find(own) {
            for (found, name) in [(&mut self.stiffness, "stiffness"), (&mut self.damping, "damping")] {
                if let (Some(found), Some(value)) = (found, bristles.parameters.get(name)) {
                    found.compare(*value);
                }
            }
        }
        if let (Some(found), Some(gap)) = (&mut self.backlash, truth.backlash) {
            found.compare(gap);
        }
    }
}
