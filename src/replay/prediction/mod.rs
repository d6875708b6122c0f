//! How far ahead a model predicts: the simulated machine follows the recording up to an instant, then the recorded torque alone drives it.
//!
//! ```text
//!   e_h(t) = q_rec(t + h) − q_sim(t + h | q_rec up to t, τ_rec from t to t + h)          h: the horizon
//! ```
//! No controller corrects the motion during the horizon, so that an error of the torque shows as what it moves: `½ Δτ/J h²` at first. Before,
//! an observer takes position, velocity and the flank that touches from the model and from the positions up to `t`; it adjusts itself to how
//! well the model fits, so that a wrong model starts from a state nearly as good as a right one does.
//! The *floor* is what encoder and current sensor leave of an exact model (`blurred`).

mod blurred;
mod compared;
mod observer;
mod releases;

use rayon::prelude::*;

use blurred::blurred;
pub use compared::{Ahead, AheadErrors, compare_predictions};
use observer::Observed;
use releases::Released;

use super::in_step::{Control, in_step};
use super::inputs::{self, Input};
use super::{Loop, Options, commands, longest_part};
use crate::dataset::{self, Session};
use crate::error::{Error, Result};
use crate::plant::{Options as PlantOptions, Plant};
use crate::robot::{JointModel, Model};
use crate::timeseries::{TimeSeries, root_mean_square};

/// [s] How far ahead is predicted: what a controller, a contact and a motion planner need.
pub const HORIZONS: [f64; 3] = [0.01, 0.1, 1.0];

/// [rad/s] Bandwidths of the observer that are tried, each twice the one before: a second of memory to a hundredth.
const BANDWIDTHS: [f64; 5] = [8.0, 16.0, 32.0, 64.0, 128.0];
/// [s] Time in which the observer settles: its slowest memory, eightfold, leaves `e⁻⁸` of a wrong start.
const SETTLES: f64 = 1.0;
/// [s] Part of the recordings on which bandwidths are compared.
const COMPARED: f64 = 20.0;
/// [s] Least part of each: three seconds once the observer has settled.
const LEAST_COMPARED: f64 = 4.0 * SETTLES;
/// Most instants from which one horizon is predicted, in all recordings together: an RMS of 300 errors is known to 4 %.
const MOST_RELEASES: usize = 300;

/// How much of each of several recordings is predicted, which takes as long as one of them alone.
#[derive(Debug, Clone, Copy)]
struct Extent {
    /// [s] Part on which bandwidths are compared.
    compared: f64,
    /// Most instants from which one horizon is predicted.
    releases: usize,
}

impl Extent {
    /// Of each of so many recordings.
    fn of(recordings: usize) -> Self {
        let recordings = recordings.max(1);
        Self {
            compared: (COMPARED / recordings as f64).max(LEAST_COMPARED),
            releases: MOST_RELEASES.div_ceil(recordings),
        }
    }

    /// [s] Longest part that is predicted: room for that many of the longest horizon.
    fn longest(self) -> f64 {
        SETTLES + self.releases as f64 * HORIZONS[HORIZONS.len() - 1]
    }
}

/// Errors of a model's predictions over one horizon on one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// The joint.
    pub joint: String,
    /// [s] The horizon.
    pub horizon: f64,
    /// Unit of the errors.
    pub unit: &'static str,
    /// [s] Times for which was predicted.
    pub time: Vec<f64>,
    /// [rad or m] Recorded minus predicted position at these times.
    pub error: Vec<f64>,
    /// [rad or m] RMS error that the sensors alone would leave of an exact model.
    pub floor: f64,
}

impl Predicted {
    /// [rad or m] RMS error.
    pub fn rms(&self) -> f64 {
        root_mean_square(&self.error)
    }
}

/// Predictions of the joints that can be predicted.
#[derive(Debug)]
pub struct Predictions<T> {
    /// Of these joints.
    pub made: Vec<T>,
    /// Why others have none, one [`Error::Diverged`] each: driven by the recorded torque, the simulated joint runs away. It is held on its recorded track.
    pub diverged: Vec<Error>,
}

impl<T> Predictions<T> {
    /// What `attempt` predicts while it holds the joints of these names; each whose motion diverges is held in the next attempt.
    ///
    /// # Errors
    /// As `attempt`, and where a held joint diverges.
    fn holding(attempt: impl Fn(&[String]) -> Result<Vec<T>>) -> Result<Self> {
        let (mut held, mut diverged) = (Vec::new(), Vec::new());
        loop {
            match attempt(&held) {
                Err(why) => match &why {
                    Error::Diverged { joint, .. } if !held.contains(joint) => {
                        held.push(joint.clone());
                        diverged.push(why);
                    }
                    _ => return Err(why),
                },
                Ok(made) => return Ok(Self { made, diverged }),
            }
        }
    }
}

/// Predicts the positions of a recording over each of [`HORIZONS`] that is no shorter than a sample, joint by joint; only joints that were recorded. Nothing is predicted in a
/// recording shorter than a horizon with the time in which the observer settles, nothing beyond its first 301 s, and nothing from currents without
/// their sign.
///
/// # Errors
/// As [`replay`](super::replay), but for a joint that diverges.
pub fn predict(model: &Model, session: &Session, options: &Options) -> Result<Predictions<Predicted>> {
    Predictions::holding(|held| predict_within(model, session, options, Extent::of(1), held))
}

/// [`predict`] in a part of the recording, with these joints held on their recorded track.
fn predict_within(
    model: &Model,
    session: &Session,
    options: &Options,
    extent: Extent,
    held: &[String],
) -> Result<Vec<Predicted>> {
    let (predictions, floors) = predictions(model, session, options, extent, held, true)?;
    Ok(predictions.into_iter().zip(floors).map(|(one, floor)| one.with(floor)).collect())
}

/// The predictions of [`predict_within`], and the floor of each if `floors`, which takes as long again.
fn predictions(
    model: &Model,
    session: &Session,
    options: &Options,
    extent: Extent,
    held: &[String],
    floors: bool,
) -> Result<(Vec<Prediction>, Vec<f64>)> {
    let mut model = model.in_session(&session.series.name);
    let session = &*longest_part(session, &mut Vec::new());
    let session = &*in_step(&mut model, session, Control::Other);
    let model = &model;
    let session = &*commands::that_drove(model, session, options.bandwidth, &mut Vec::new());
    let inputs_of = |session: &Session| -> Result<Vec<Input>> {
        let mut inputs = inputs::inputs(model, session, Loop::Closed, &mut Vec::new())?;
        let joints = model.joints.iter().zip(&mut inputs);
        joints.filter(|(joint, _)| held.contains(&joint.name)).for_each(|(_, input)| input.hold());
        Ok(inputs)
    };
    let inputs = inputs_of(session)?;
    let horizons = horizons(&session.series);
    if inputs.iter().any(|input| input.magnitude) || horizons.is_empty() {
        return Ok((Vec::new(), Vec::new()));
    }
    let steps: Vec<f64> = model.joints.iter().zip(&inputs).map(|(joint, input)| encoder_step(joint, input)).collect();
    let followed = Followed { model, time: &session.series.time, inputs: &inputs, steps: &steps, options, extent };
    let bandwidths = followed.best_bandwidths(horizons[0])?;
    let samples = followed.samples_within(extent.longest());
    let all = |followed: &Followed| -> Result<Vec<Prediction>> {
        let observed = followed.observe(&bandwidths, samples, &horizons)?;
        let horizons = horizons.iter().zip(&observed.released);
        let predicted = horizons.map(|(horizon, released)| followed.predictions(&observed, *horizon, released));
        Ok(predicted.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
    };
    let recorded = || Ok::<_, Error>(all(&followed)?.into_iter().filter(|one| one.recorded).collect::<Vec<_>>());
    if !floors {
        return Ok((recorded()?, Vec::new()));
    }
    let blurred_inputs = inputs_of(&blurred(model, session, &inputs))?;
    let by_others = || all(&Followed { inputs: &blurred_inputs, ..followed });
    let (predictions, by_others) = rayon::join(recorded, by_others);
    let (predictions, by_others) = (predictions?, by_others?);
    let others = by_others.iter().zip(steps.iter().cycle()).filter(|(one, _)| one.recorded);
    let floors = predictions.iter().zip(others).map(|(one, (other, step))| one.floor_beside(other, *step)).collect();
    Ok((predictions, floors))
}

/// The horizons that a recording resolves.
fn horizons(series: &TimeSeries) -> Vec<f64> {
    /// Times of samples are rounded, and jitter.
    const NEARLY: f64 = 0.9;
    HORIZONS.into_iter().filter(|horizon| *horizon >= NEARLY * series.sample_interval()).collect()
}

/// Predictions over one horizon on one joint.
struct Prediction {
    joint: String,
    unit: &'static str,
    recorded: bool,
    horizon: f64,
    /// [s] Times for which was predicted.
    time: Vec<f64>,
    /// [rad or m] The prediction, as the joint's encoder sees it.
    position: Vec<f64>,
    /// [rad or m] Recorded minus predicted position.
    error: Vec<f64>,
}

impl Prediction {
    /// The floor [rad or m] from the same prediction by other sensors, with this step [rad or m] of the encoder.
    fn floor_beside(&self, other: &Self, step: f64) -> f64 {
        let differences = self.position.iter().zip(&other.position).map(|(one, other)| (one - other).powi(2));
        let mean = differences.sum::<f64>() / self.position.len().max(1) as f64;
        (0.5 * mean + step * step / 12.0).sqrt()
    }

    /// Its errors, with their floor.
    fn with(self, floor: f64) -> Predicted {
        Predicted {
            joint: self.joint,
            horizon: self.horizon,
            unit: self.unit,
            time: self.time,
            error: self.error,
            floor,
        }
    }
}

/// [rad or m] Step of a joint's encoder: of the model, otherwise of the recording; 0 if neither has one.
fn encoder_step(joint: &JointModel, input: &Input) -> f64 {
    let found = || dataset::encoder_step(&[&input.position]).unwrap_or(0.0);
    if joint.encoder.is_some() { joint.encoder_step() } else { found() }
}

/// A recording and the model that follows it.
#[derive(Clone, Copy)]
struct Followed<'a> {
    model: &'a Model,
    /// [s] Sample times.
    time: &'a [f64],
    inputs: &'a [Input],
    /// [rad or m] Steps of the encoders.
    steps: &'a [f64],
    options: &'a Options,
    extent: Extent,
}

impl Followed<'_> {
    /// The bandwidth [rad/s] for each joint with which this horizon is predicted best at the start of the recording. Those at the ends are tried
    /// where one beside them is the best so far.
    fn best_bandwidths(&self, horizon: f64) -> Result<Vec<f64>> {
        let [first, middle @ .., last] = BANDWIDTHS;
        let middle = self.best_of(&middle, horizon)?;
        let ends = [(first, BANDWIDTHS[1]), (last, BANDWIDTHS[BANDWIDTHS.len() - 2])];
        let wanted = ends.iter().filter(|(_, beside)| middle.iter().any(|(_, best)| best == beside));
        let ends = self.best_of(&wanted.map(|(end, _)| *end).collect::<Vec<_>>(), horizon)?;
        Ok(middle.iter().zip(ends).map(|(middle, end)| if end.0 < middle.0 { end.1 } else { middle.1 }).collect())
    }

    /// For each joint the least error [rad or m] with one of these bandwidths, and that bandwidth [rad/s].
    fn best_of(&self, bandwidths: &[f64], horizon: f64) -> Result<Vec<(f64, f64)>> {
        let samples = self.samples_within(self.extent.compared);
        let errors = |bandwidth: &f64| -> Result<Vec<(f64, f64)>> {
            let observed = self.observe(&vec![*bandwidth; self.inputs.len()], samples, &[horizon])?;
            let predicted = self.predictions(&observed, horizon, &observed.released[0])?;
            let error = |one: &Prediction| match one.error.is_empty() {
                true => f64::INFINITY,
                false => root_mean_square(&one.error),
            };
            Ok(predicted.iter().map(|one| (error(one), *bandwidth)).collect())
        };
        let all = bandwidths.par_iter().map(errors).collect::<Result<Vec<_>>>()?;
        let better = |one: (f64, f64), other: (f64, f64)| if other.0 < one.0 { other } else { one };
        let none = vec![(f64::INFINITY, BANDWIDTHS[0]); self.inputs.len()];
        Ok(all.into_iter().fold(none, |best, of| best.into_iter().zip(of).map(|(a, b)| better(a, b)).collect()))
    }

    /// Number of samples in the first part of the recording, so long [s].
    fn samples_within(&self, duration: f64) -> usize {
        let start = self.time.first().copied().unwrap_or(0.0);
        self.time.partition_point(|time| *time - start <= duration)
    }

    /// Predictions over a horizon from the instants at which the machine was released, one for each joint.
    fn predictions(&self, observed: &Observed, horizon: f64, released: &[Released]) -> Result<Vec<Prediction>> {
        let ends: Vec<usize> = released.iter().map(|one| self.end(one.sample, horizon)).collect();
        let positions = releases::positions(self, observed, released, &ends)?;
        let joints = self.model.joints.iter().zip(self.inputs).zip(positions);
        let predicted = joints.map(|((joint, input), position)| Prediction {
            joint: joint.name.clone(),
            unit: joint.kind.position_unit(),
            recorded: input.recorded,
            horizon,
            time: ends.iter().map(|end| self.time[*end]).collect(),
            error: ends.iter().zip(&position).map(|(end, predicted)| input.position[*end] - predicted).collect(),
            position,
        });
        Ok(predicted.collect())
    }

    /// The sample at the end of a horizon that begins at `sample`: the last that is no later, but at least one on.
    fn end(&self, sample: usize, horizon: f64) -> usize {
        /// Times are rounded.
        const ROUNDING: f64 = 1e-9;
        let until = self.time[sample] + horizon + ROUNDING;
        let end = sample + self.time[sample..].partition_point(|time| *time <= until) - 1;
        end.max(sample + 1).min(self.time.len() - 1)
    }

    /// The samples among the first `samples` at which the machine is let go for a horizon.
    fn releases(&self, horizon: f64, samples: usize) -> Vec<usize> {
        let (Some(first), Some(last)) = (self.time.first(), self.time[..samples].last()) else { return Vec::new() };
        let (from, to) = (first + SETTLES, last - horizon);
        let spacing = horizon.max((to - from) / self.extent.releases as f64);
        let count = if to > from { ((to - from) / spacing) as usize } else { 0 };
        let mut at: Vec<usize> =
            (0..count).map(|k| self.time.partition_point(|time| *time < from + k as f64 * spacing)).collect();
        at.dedup();
        at.retain(|sample| sample + 1 < samples);
        at
    }

    /// The simulated machine, with exact sensors.
    fn plant(&self) -> Result<Plant> {
        let Options { engine, catalogue, .. } = self.options;
        let catalogue = catalogue.clone();
        Plant::new(
            self.model,
            &PlantOptions { engine: *engine, ideal_sensors: true, catalogue, ..PlantOptions::default() },
        )
    }
}
