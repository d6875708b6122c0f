//! Two models under the inputs of the same recordings: the error of each, and the gain of the second.

use rayon::prelude::*;

use super::gain::{Gain, Pairs};
use super::{ChannelError, Observable, Options, Replay, replay};
use crate::dataset::Session;
use crate::error::Result;
use crate::robot::Model;

/// Errors of two models on one channel, over all recordings together.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// The joint.
    pub joint: String,
    /// The signals.
    pub quantity: Observable,
    /// Unit of the errors.
    pub unit: &'static str,
    /// RMS error of the first model.
    pub before: f64,
    /// RMS error of the second model.
    pub after: f64,
    /// By how much the error of the second is smaller.
    pub gain: Gain,
}

/// Simulates both models under the inputs of each session, in parallel if there are cores for it; a model equal to the
/// first is not simulated again. Returns the comparison and the replays of the first model.
///
/// # Errors
/// As [`replay`].
pub fn compare_models(
    before: &Model,
    after: &Model,
    sessions: &[Session],
    options: &Options,
) -> Result<(Vec<Compared>, Vec<Replay>)> {
    let models: &[&Model] = if before == after { &[before] } else { &[before, after] };
    let work: Vec<(&Model, &Session)> =
        models.iter().flat_map(|model| sessions.iter().map(|session| (*model, session))).collect();
    let mut replays: Vec<Replay> =
        work.into_par_iter().map(|(model, session)| replay(model, session, options)).collect::<Result<_>>()?;
    let compared = compared(&replays[..sessions.len()], &replays[replays.len() - sessions.len()..]);
    replays.truncate(sessions.len());
    Ok((compared, replays))
}

/// Compares the replays of two models; both lists contain the same recordings in the same order.
pub fn compared(before: &[Replay], after: &[Replay]) -> Vec<Compared> {
    let Some(first) = before.first() else { return Vec::new() };
    let channel = |(index, error): (usize, &ChannelError)| {
        let of = |replays: &[Replay]| rms(replays.iter().filter_map(|one| one.errors.get(index)));
        let pairs: Vec<Pairs> = before
            .iter()
            .zip(after)
            .filter_map(|(before, after)| {
                let (a, b) = (before.errors.get(index)?, after.errors.get(index)?);
                Some(Pairs { time: &before.time, before: &a.difference, after: &b.difference })
            })
            .collect();
        Compared {
            joint: error.joint.clone(),
            quantity: error.quantity,
            unit: error.unit,
            before: of(before),
            after: of(after),
            gain: Gain::of(&pairs),
        }
    };
    first.errors.iter().enumerate().map(channel).collect()
}

/// RMS over all samples of one channel.
fn rms<'e>(errors: impl Iterator<Item = &'e ChannelError>) -> f64 {
    let samples = errors.flat_map(|error| &error.difference);
    let (sum, count) = samples.fold((0.0, 0_usize), |(sum, count), e| (sum + e * e, count + 1));
    (sum / count.max(1) as f64).sqrt()
}
