//! Two models' predictions of the same recordings, beside the floor.

use rayon::prelude::*;

use super::{Extent, HORIZONS, Predicted, Prediction, Predictions, predict_within, predictions};
use crate::dataset::Session;
use crate::error::Result;
use crate::replay::Options;
use crate::replay::gain::{Gain, Pairs};
use crate::robot::{JointModel, Model};
use crate::timeseries::root_mean_square;

/// Errors of two models' predictions over one horizon on one joint, over all recordings together.
#[derive(Debug, Clone, PartialEq)]
pub struct Ahead {
    /// The joint.
    pub joint: String,
    /// [s] The horizon.
    pub horizon: f64,
    /// Unit of the errors.
    pub unit: &'static str,
    /// RMS error of the position by the first model.
    pub before: f64,
    /// RMS error by the second model.
    pub after: f64,
    /// RMS error that the sensors alone would leave, were the second model exact.
    pub floor: f64,
    /// By how much the error of the second is smaller.
    pub gain: Gain,
    /// Both errors at the times for which was predicted, one for each recording.
    pub errors: Vec<AheadErrors>,
}

/// Errors of two models' predictions of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct AheadErrors {
    /// The session.
    pub session: String,
    /// [s] Times for which was predicted.
    pub time: Vec<f64>,
    /// [rad or m] of the first model.
    pub before: Vec<f64>,
    /// [rad or m] of the second model.
    pub after: Vec<f64>,
}

/// Predicts the positions of recordings with two models; a model equal to the first is not simulated again. All recordings share the number of
/// instants from which [`predict`](super::predict) predicts in one. A joint that diverges with one model is held with both.
///
/// # Errors
/// As [`predict`](super::predict).
pub fn compare_predictions(
    before: &Model,
    after: &Model,
    sessions: &[Session],
    options: &Options,
) -> Result<Predictions<Ahead>> {
    Predictions::holding(|held| compare_holding(before, after, sessions, options, held))
}

/// [`compare_predictions`] with these joints held on their recorded track.
fn compare_holding(
    before: &Model,
    after: &Model,
    sessions: &[Session],
    options: &Options,
    held: &[String],
) -> Result<Vec<Ahead>> {
    let extent = Extent::of(sessions.len());
    let of_first = |session: &Session| Ok(predictions(before, session, options, extent, held, false)?.0);
    let of_second = |session: &Session| predict_within(after, session, options, extent, held);
    let first = || sessions.par_iter().map(of_first).collect::<Result<Vec<_>>>();
    let second = || sessions.par_iter().map(of_second).collect::<Result<Vec<_>>>();
    let (first, second) = match before == after {
        true => (None, second()?),
        false => {
            let (first, second) = rayon::join(first, second);
            (Some(first?), second?)
        }
    };
    let all = after.joints.iter().flat_map(|joint| HORIZONS.map(|horizon| (joint, horizon)));
    Ok(all.filter_map(|(joint, horizon)| ahead(joint, horizon, sessions, first.as_deref(), &second)).collect())
}

/// Both models' predictions over one horizon on one joint; `None` where nothing was predicted. `first` is `None` if both are the same.
fn ahead(
    joint: &JointModel,
    horizon: f64,
    sessions: &[Session],
    first: Option<&[Vec<Prediction>]>,
    second: &[Vec<Predicted>],
) -> Option<Ahead> {
    let after = second.iter().map(|of_session| {
        of_session.iter().find(|one| one.joint == joint.name && one.horizon == horizon && !one.time.is_empty())
    });
    let before = |number: usize, after: &Predicted| match first {
        None => Some(after.error.clone()),
        Some(first) => {
            let of_joint = first[number].iter().find(|one| one.joint == joint.name && one.horizon == horizon);
            of_joint.map(|one| one.error.clone())
        }
    };
    let both: Vec<(&Session, Vec<f64>, &Predicted)> = sessions
        .iter()
        .zip(after)
        .enumerate()
        .filter_map(|(number, (session, after))| Some((session, before(number, after?)?, after?)))
        .collect();
    let pairs: Vec<Pairs> =
        both.iter().map(|(_, before, after)| Pairs { time: &after.time, before, after: &after.error }).collect();
    let floors = both.iter().map(|(_, _, after)| after.floor.powi(2) * after.error.len() as f64).sum::<f64>();
    let count: usize = both.iter().map(|(_, _, after)| after.error.len()).sum();
    let errors = both.iter().map(|(session, before, after)| AheadErrors {
        session: session.series.name.clone(),
        time: after.time.clone(),
        before: before.clone(),
        after: after.error.clone(),
    });
    (count > 0).then(|| Ahead {
        joint: joint.name.clone(),
        horizon,
        unit: joint.kind.position_unit(),
        before: root_mean_square(&both.iter().flat_map(|(_, before, _)| before.clone()).collect::<Vec<_>>()),
        after: root_mean_square(&both.iter().flat_map(|(_, _, after)| after.error.clone()).collect::<Vec<_>>()),
        floor: (floors / count as f64).sqrt(),
        gain: Gain::of(&pairs),
        errors: errors.collect(),
    })
}
