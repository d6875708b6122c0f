//! Replay: simulates a model under recorded inputs, for comparison with the recording.
//!
//! In open loop, recorded torques let any model drift away by metres, however good it is. So the machine's controller,
//! or a tracking one, corrects the recorded torque according to the difference of the positions ([`feedback`]). Three
//! figures per joint then measure how well the model fits: the RMS difference of position, of velocity, and of motor
//! torque. [`Loop::Open`] omits the correction, for comparison with figures from the literature: the position then
//! contains every error of the torque, integrated twice.
//! Both sides of every comparison go through the same zero-phase low-pass ([`low_pass`]).

mod commands;
mod compare;
mod drawing;
mod feedback;
mod gain;
mod in_step;
mod inputs;
mod low_pass;
mod pair;
pub mod prediction;

use std::borrow::Cow;

pub use compare::Side;
use drawing::Drawing;
use feedback::Feedback;
pub use gain::{Gain, Pairs};
use in_step::{Control, in_step};
use inputs::{Input, Taken};
pub use low_pass::low_pass;
pub use pair::{Compared, compare_models, compared};

use crate::dataset::Session;
use crate::effects::{Catalogue, JointState};
use crate::error::Result;
use crate::plant::{Engine, Options as PlantOptions, Plant};
use crate::robot::Model;
use crate::timeseries::{Channel, Clock, Drawn, Envelope, uninterrupted};

/// Channels of a recording that a replay reads; all others may be dropped.
pub const CHANNELS: [Channel; 4] = [Channel::Position, Channel::Torque, Channel::CommandCurrent, Channel::Current];

/// Whether a controller corrects the recorded torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Loop {
    /// By the machine's own controller, or a tracking one.
    #[default]
    Closed,
    /// None. A joint that was not recorded is held still even then.
    Open,
}

/// Options of a replay.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Whether feedback keeps the simulated machine close to the recorded one.
    pub control: Loop,
    /// Which engine computes the links' dynamics.
    pub engine: Engine,
    /// [Hz] Bandwidth of the tracking controller if the machine's own is not known, > 0.
    pub bandwidth: f64,
    /// [Hz] Cut-off of the low-pass on both sides of a comparison, > 0.
    pub cutoff: f64,
    /// Effects that a model may have.
    pub catalogue: Catalogue,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            control: Loop::Closed,
            engine: Engine::Rapier,
            bandwidth: 3.0,
            cutoff: 25.0,
            catalogue: Catalogue::default(),
        }
    }
}

/// Which signals were compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Observable {
    /// Motor position, joint side.
    Position,
    /// Derivative of the smoothed motor position.
    Velocity,
    /// Motor torque, joint side.
    Torque,
}

/// Difference between a simulated signal and the recorded one.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ChannelError {
    /// The joint.
    pub joint: String,
    /// The signals.
    pub quantity: Observable,
    /// Unit of `rms`.
    pub unit: &'static str,
    /// RMS of the difference.
    pub rms: f64,
    /// [1] `rms` divided by the RMS of the recorded signal; 0 if that is 0.
    pub relative: f64,
    /// Recorded minus simulated, sample by sample, after the low-pass; empty if it is not kept.
    #[serde(skip)]
    pub difference: Vec<f64>,
}

/// A simulated session with its comparison.
#[derive(Debug, Clone)]
pub struct Replay {
    /// Name of the session.
    pub session: String,
    /// [s] Sample times.
    pub time: Vec<f64>,
    /// The differences, joint by joint.
    pub errors: Vec<ChannelError>,
    /// Notes on the figures.
    pub notes: Vec<String>,
    /// The simulated machine for display: position, velocity, torque and true states.
    pub simulated: Drawn,
}

/// Simulates `model` under the inputs of `session`.
///
/// # Errors
/// A joint lacks position, or torque and current; in open loop, only the magnitude of its current is known; the model's
/// effects do not fit; or the simulation diverges.
pub fn replay(model: &Model, session: &Session, options: &Options) -> Result<Replay> {
    replayed(model, session, options, &mut |_| true)
}

/// As [`replay`]; `see` gets both sides of each signal, and no differences are kept.
///
/// # Errors
/// As [`replay`].
pub fn replay_seen(
    model: &Model,
    session: &Session,
    options: &Options,
    see: &mut dyn FnMut(&Side<'_>),
) -> Result<Replay> {
    replayed(model, session, options, &mut |side| {
        see(side);
        false
    })
}

/// As [`replay`]; `see` gets both sides of each signal and returns whether their difference is kept.
fn replayed(
    model: &Model,
    session: &Session,
    options: &Options,
    see: &mut dyn FnMut(&Side<'_>) -> bool,
) -> Result<Replay> {
    let mut model = model.in_session(&session.series.name);
    let mut notes = Vec::new();
    let session = &*longest_part(session, &mut notes);
    let session = &*in_step(&mut model, session, Control::Own);
    let model = &model;
    let session = &*commands::that_drove(model, session, options.bandwidth, &mut notes);
    let inputs = inputs::inputs(model, session, options.control, &mut notes)?;
    let (simulated, mut drawn) = simulate(model, session, &inputs, options)?;
    let time = &session.series.time;
    let clock = Clock::new(time);
    let mut errors = Vec::new();
    for (index, (input, simulated)) in inputs.iter().zip(simulated).enumerate() {
        let channels = &mut drawn.joints[index].channels;
        let mut seen = |side: &Side<'_>| {
            let envelope = Envelope::of(side.time, side.simulated.iter().copied());
            channels.insert(side.quantity.channel(), envelope);
            see(side)
        };
        errors.extend(compare::compare(&model.joints[index], input, simulated, &clock, options.cutoff, &mut seen));
    }
    if options.control == Loop::Open {
        // The torque is an input here, not a result.
        errors.retain(|error| error.quantity != Observable::Torque);
    }
    Ok(Replay { session: session.series.name.clone(), time: time.clone(), errors, notes, simulated: drawn })
}

/// The session, or its longest part without a pause: what the machine did in a pause is unknown, so no simulation can follow it.
fn longest_part<'s>(session: &'s Session, notes: &mut Vec<String>) -> Cow<'s, Session> {
    let parts = uninterrupted(&session.series.time);
    let longest = parts.iter().max_by_key(|part| part.len()).filter(|_| parts.len() > 1);
    let Some(longest) = longest else { return Cow::Borrowed(session) };
    let series = session.series.part(longest.clone());
    let ends = [longest.start, longest.end - 1].map(|k| session.series.time[k]);
    notes.push(format!(
        "{}: the recording pauses; its longest part is replayed, {:.3} to {:.3} s",
        series.name, ends[0], ends[1]
    ));
    Cow::Owned(Session { series, ..session.clone() })
}

/// Compared signals of a simulated joint.
#[derive(Debug)]
struct Simulated {
    /// [rad or m]
    position: Vec<f64>,
    /// [N·m or N]
    torque: Vec<f64>,
}

/// The simulated joints, and the true states of the machine for display.
fn simulate(model: &Model, session: &Session, inputs: &[Input], options: &Options) -> Result<(Vec<Simulated>, Drawn)> {
    let time = &session.series.time;
    let catalogue = options.catalogue.clone();
    let plant_options =
        PlantOptions { engine: options.engine, ideal_sensors: true, catalogue, ..PlantOptions::default() };
    let mut plant = Plant::new(model, &plant_options)?;
    let mut feedback = feedback::of_joints(model, session, inputs, options);
    let start: Vec<JointState> = feedback.iter().map(Feedback::start).collect();
    plant.launch(&start);

    let n = model.joints.len();
    let empty = || Simulated { position: Vec::with_capacity(time.len()), torque: Vec::with_capacity(time.len()) };
    let mut joints: Vec<Simulated> = (0..n).map(|_| empty()).collect();
    let mut drawing = Drawing::new(model, time.len());
    let steps = feedback.iter().map(|one| one.steps).max().unwrap_or(1);
    let (mut commands, mut taken) = (vec![0.0; n], vec![Taken::default(); n]);
    let mut readings = Vec::with_capacity(n);
    for (k, &now) in time.iter().enumerate() {
        readings.clear();
        readings.extend_from_slice(plant.read());
        for i in 0..n {
            let torque_per_ampere = model.joints[i].torque_per_ampere();
            let state = plant.states()[i];
            taken[i] = inputs[i].taken(k, torque_per_ampere, &state, &readings[i]);
            let asked = taken[i].torque + feedback[i].correction(readings[i].position, now);
            commands[i] = asked / torque_per_ampere;
            let commanded = inputs[i].commanded;
            let torque = if commanded { asked + taken[i].added } else { torque_per_ampere * readings[i].current };
            joints[i].position.push(readings[i].position);
            joints[i].torque.push(torque);
            drawing.sample(i, now, &state, f64::from(plant.contact(i)));
        }
        let Some(next) = time.get(k + 1) else { continue };
        let interval = (next - now) / steps as f64;
        plant.advance(&commands, interval)?;
        for step in 1..steps {
            let now = now + step as f64 * interval;
            for (i, feedback) in feedback.iter_mut().enumerate().filter(|(_, feedback)| feedback.steps > 1) {
                let position = plant.states()[i].motor_position + taken[i].misread;
                commands[i] =
                    (taken[i].torque + feedback.correction(position, now)) / model.joints[i].torque_per_ampere();
            }
            plant.advance(&commands, interval)?;
        }
    }
    Ok((joints, drawing.finish(&session.series)))
}
