//! The loop of sensors, controller and machine, and a scenario's run through it.

use std::sync::Mutex;

use rayon::prelude::*;

use super::{Contact, Keep, Recorder, Regulator, Run, Scenario, Session};
use crate::control::{Profile, Target};
use crate::error::Result;
use crate::plant::{Options, Plant};
use crate::robot::Model;
use crate::timeseries::{Drawn, TimeSeries};

/// Times at which a closed loop ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// [s] between two ticks, > 0.
    pub period: f64,
    /// [s] until the last tick.
    pub duration: f64,
}

impl Timing {
    /// Number of ticks, the one at the start included.
    pub fn ticks(&self) -> usize {
        ((self.duration / self.period + 1e-9).floor() as usize).saturating_add(1)
    }
}

/// Moves a machine along a reference from its present state, and records every tick. `progress` is called from time to
/// time with the simulated seconds.
///
/// # Errors
/// The motion diverges.
pub fn closed_loop(
    plant: &mut Plant,
    regulator: &mut Regulator,
    reference: &Profile,
    timing: Timing,
    keep: Keep,
    progress: &mut dyn FnMut(f64),
) -> Result<Recorder> {
    let n = plant.states().len();
    let mut targets = vec![Target::default(); n];
    let mut readings = Vec::with_capacity(n);
    let ticks = timing.ticks();
    let mut recorder = Recorder::new(keep, n, ticks);
    for tick in 0..ticks {
        let time = tick as f64 * timing.period;
        reference.sample(time, &mut targets);
        readings.clear();
        readings.extend_from_slice(plant.read());
        let commands = regulator.command(&readings, &targets);
        recorder.sample(plant, &readings, &targets, commands);
        plant.advance(commands, timing.period)?;
        if tick % 1000 == 0 {
            progress(time);
        }
    }
    Ok(recorder)
}

/// Simulates the sessions of a scenario under a seed, in parallel, and keeps everything. `progress` is called with the
/// simulated seconds and their total.
///
/// # Errors
/// The run exceeds the scenario's limits; the planned motion leaves the limits or collides; an effect of the model does
/// not fit; the simulated motion diverges.
pub fn simulate(scenario: &Scenario, seed: u64, progress: &(dyn Fn(f64, f64) + Sync)) -> Result<Run> {
    simulate_keeping(Keep::Everything, scenario, seed, progress)
}

/// As [`simulate`], for long sessions whose complete data would not fit in memory.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_keeping(
    keep: Keep,
    scenario: &Scenario,
    seed: u64,
    progress: &(dyn Fn(f64, f64) + Sync),
) -> Result<Run> {
    scenario.check()?;
    let all: f64 = scenario.sessions.iter().map(|session| session.duration).sum();
    let done = Mutex::new(vec![0.0; scenario.sessions.len()]);
    let report = |number: usize, time: f64| {
        let sum = done.lock().map_or(0.0, |mut done| {
            done[number] = time;
            done.iter().sum()
        });
        progress(sum, all);
    };
    let sessions = scenario
        .sessions
        .par_iter()
        .enumerate()
        .map(|(number, session)| {
            // Each session has its own noise and encoder phases.
            let seed = seed.wrapping_add((number as u64) << 32);
            run_session(scenario, session, keep, seed, None, &mut |time| report(number, time))
        })
        .collect::<Result<Vec<_>>>()?;
    progress(all, all);
    let mut run = Run { sessions: Vec::new(), drawn: Vec::new(), contacts: Vec::new(), seed };
    for (session, drawn, contacts) in sessions {
        run.sessions.push(session);
        run.drawn.push(drawn);
        run.contacts.push(contacts);
    }
    Ok(run)
}

/// One session: a new machine, at rest at the start of its reference. Returns the recording, its reduced copy for
/// display, and the contacts. With `known`, friction and gaps of that model are compensated, each gap crossed in that time [s].
pub(super) fn run_session(
    scenario: &Scenario,
    session: &Session,
    keep: Keep,
    seed: u64,
    known: Option<(&Model, f64)>,
    progress: &mut dyn FnMut(f64),
) -> Result<(TimeSeries, Drawn, Vec<Contact>)> {
    let Scenario { truth, model, options, control_period, controller, .. } = scenario;
    let model = &model.in_session(&session.name);
    let most_steps = (scenario.limits.steps / model.joints.len().max(1) as f64) as usize;
    let machine = truth.machine().in_session(&session.name);
    let mut plant = Plant::new(&machine, &Options { seed, most_steps, ..options.clone() })?;
    plant.place(&session.profile.start());
    let mut regulator = Regulator::new(model, controller, *control_period);
    if let Some((known, crossing_time)) = known {
        regulator.compensate(known, crossing_time);
    }
    let timing = Timing { period: *control_period, duration: session.duration };
    let mut recorder = closed_loop(&mut plant, &mut regulator, &session.profile, timing, keep, progress)?;
    let contacts = recorder.take_contacts(model, &options.obstacles);
    let (series, drawn) = recorder.finish(&session.name, model);
    Ok((series, drawn, contacts))
}
