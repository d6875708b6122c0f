//! Two models' predictions of the same recordings, beside the floor.

use rayon::prelude::*;

use super::{HORIZONS, Predicted, predict, rms};
use crate::dataset::Session;
use crate::error::Result;
use crate::replay::Options;
use crate::replay::gain::{Gain, Pairs};
use crate::robot::{JointModel, Model};

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

/// Predicts the positions of recordings with two models; a model equal to the first is not simulated again.
///
/// # Errors
/// As [`predict`].
pub fn compare_predictions(
    before: &Model,
    after: &Model,
    sessions: &[Session],
    options: &Options,
) -> Result<Vec<Ahead>> {
    let models: &[&Model] = if before == after { &[before] } else { &[before, after] };
    let work: Vec<(&Model, &Session)> =
        models.iter().flat_map(|model| sessions.iter().map(|session| (*model, session))).collect();
    let predicted: Vec<Vec<Predicted>> =
        work.into_par_iter().map(|(model, session)| predict(model, session, options)).collect::<Result<_>>()?;
    let (first, second) = (&predicted[..sessions.len()], &predicted[predicted.len() - sessions.len()..]);
    let all = after.joints.iter().flat_map(|joint| HORIZONS.map(|horizon| (joint, horizon)));
    Ok(all.filter_map(|(joint, horizon)| ahead(joint, horizon, sessions, [first, second])).collect())
}

/// Both models' predictions over one horizon on one joint; `None` where nothing was predicted.
fn ahead(joint: &JointModel, horizon: f64, sessions: &[Session], models: [&[Vec<Predicted>]; 2]) -> Option<Ahead> {
    let [first, second] = models.map(|predicted| {
        let wanted = |one: &&Predicted| one.joint == joint.name && one.horizon == horizon && !one.time.is_empty();
        predicted.iter().map(move |one| one.iter().find(wanted))
    });
    let both: Vec<(&Session, &Predicted, &Predicted)> = sessions
        .iter()
        .zip(first.zip(second))
        .filter_map(|(session, (first, second))| Some((session, first?, second?)))
        .collect();
    let pairs: Vec<Pairs> = both
        .iter()
        .map(|(_, first, second)| Pairs { time: &first.time, before: &first.error, after: &second.error })
        .collect();
    let floors = both.iter().map(|(_, _, second)| second.floor.powi(2) * second.error.len() as f64).sum::<f64>();
    let count: usize = both.iter().map(|(_, _, second)| second.error.len()).sum();
    let errors = both.iter().map(|(session, first, second)| AheadErrors {
        session: session.series.name.clone(),
        time: first.time.clone(),
        before: first.error.clone(),
        after: second.error.clone(),
    });
    (count > 0).then(|| Ahead {
        joint: joint.name.clone(),
        horizon,
        unit: joint.kind.position_unit(),
        before: rms(&both.iter().flat_map(|(_, first, _)| first.error.clone()).collect::<Vec<_>>()),
        after: rms(&both.iter().flat_map(|(_, _, second)| second.error.clone()).collect::<Vec<_>>()),
        floor: (floors / count as f64).sqrt(),
        gain: Gain::of(&pairs),
        errors: errors.collect(),
    })
}
