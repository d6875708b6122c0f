//! Runge-Kutta 4 between located events.
//!
//! A step is taken within the modes that hold at its start (`runge_kutta`). Where a margin has turned negative at its end, the
//! earliest root of the margins along the step's cubic Hermite interpolant is found (`events`), the step is taken again up to
//! there, and the mode changes: a flank is touched or left, a rotor or link comes to rest or breaks away, the voltage limit is
//! met or left. If events are not located, every method is of first order. Where there are too many events to locate them all, the
//! method falls back to that, which bounds the cost of an interval.

use super::FASTEST_MOTION;
use super::joint::Power;
use super::machine::Machine;
use super::runge_kutta::RungeKutta;
use super::state::State;
use super::step::{Endpoint, Held, Probe, Step, Tried};

/// Most events that are located between two evaluations; a gap that is crossed a hundred times a millisecond counts as none.
const MAX_EVENTS: usize = 100;

/// Most events at one instant; then a step is taken in the present modes. Modes that alternate at one state have the same
/// motion there.
const MAX_EVENTS_AT_ONCE: usize = 16;

/// Computing effort of a run so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Evaluations of `M` and `h`.
    pub evaluations: usize,
    /// Evaluations of the engine that confirmed those of the built-in algorithms; 0 where the engine makes every evaluation.
    pub confirmations: usize,
    /// Runge-Kutta steps, those that were taken back or shortened included.
    pub steps: usize,
    /// Changes of mode.
    pub events: usize,
    /// Laws of a joint evaluated inside a step to locate an event.
    pub probes: usize,
    /// Steps at whose end alone modes were changed, because there were too many events to be located.
    pub crowded: usize,
}

impl Counts {
    /// Steps, plus the probes converted to steps of a machine with `n` joints: a step evaluates the laws of all joints four times.
    pub fn work(&self, n: usize) -> usize {
        self.steps + self.probes / (4 * n).max(1)
    }
}

/// Events met since an interval began.
#[derive(Default)]
struct Met {
    /// Those that a step has reached.
    events: usize,
    /// Those at the present instant.
    at_once: usize,
}

/// The integrator with its working memory.
pub struct Integrator {
    /// Steps, and probes as steps, after which it ends early.
    pub most_steps: usize,
    /// What moves.
    pub machine: Machine,
    pub(super) counts: Counts,
    pub(super) runge_kutta: RungeKutta,
    /// At the start and the end of the step.
    pub(super) ends: [Endpoint; 2],
    pub(super) probe: Probe,
}

impl Integrator {
    /// An integrator for a machine.
    pub fn new(machine: Machine, most_steps: usize) -> Self {
        let (n, barriers) = (machine.coupled.laws.len(), machine.coupled.barriers.count());
        Self {
            most_steps,
            machine,
            counts: Counts::default(),
            runge_kutta: RungeKutta::new(n),
            ends: [Endpoint::new(n, barriers), Endpoint::new(n, barriers)],
            probe: Probe::new(n),
        }
    }

    /// Computing effort so far.
    pub fn counts(&self) -> Counts {
        let Machine { evaluations, confirmations, .. } = self.machine;
        Counts { evaluations, confirmations, ..self.counts }
    }

    /// Integrates to a time under a constant command that may have jumped; `watch` sees every stretch between events. Ends early where
    /// `is_lost`.
    pub fn advance(
        &mut self,
        state: &mut State,
        held: Held,
        until: f64,
        substeps: usize,
        mut watch: impl FnMut(&Step),
    ) {
        let start = state.time;
        let length = (until - start) / substeps as f64;
        self.settle(state, &held);
        let mut met = Met::default();
        for k in 1..=substeps {
            let target = if k == substeps { until } else { start + k as f64 * length };
            while state.time < target {
                if self.is_lost(state) {
                    return;
                }
                self.advance_once(state, &held, target, &mut met, &mut watch);
            }
        }
    }

    /// A step to a time, or to the first event before it.
    fn advance_once(
        &mut self,
        state: &mut State,
        held: &Held,
        target: f64,
        met: &mut Met,
        watch: &mut impl FnMut(&Step),
    ) {
        let crowded = met.events >= MAX_EVENTS;
        if crowded {
            self.counts.crowded += 1;
            self.change_overdue(state, held);
        }
        let h = target - state.time;
        let work = self.step(state, held, h);
        self.reach(state, held, target);
        let forced = crowded || met.at_once >= MAX_EVENTS_AT_ONCE;
        let event = if forced { None } else { self.earliest(&Tried { state, held, h }) };
        let Some((event, share)) = event else {
            met.at_once = 0;
            self.accept(state, target, work, watch);
            self.ends.swap(0, 1);
            return;
        };
        if share * h > 0.0 && state.time + share * h > state.time {
            let work = self.step(state, held, share * h);
            self.accept(state, state.time + share * h, work, watch);
            met.events += 1;
            met.at_once = 0;
        }
        met.at_once += 1;
        self.counts.events += 1;
        self.change(state, held, event);
        self.begin(state, held);
    }

    /// Whether to stop: the motion has diverged, or has taken more steps than it may.
    fn is_lost(&self, state: &State) -> bool {
        let fine = |speed: f64| speed.abs() <= FASTEST_MOTION;
        self.counts.work(state.joints.len()) > self.most_steps
            || !state.joints.iter().all(|y| fine(y.omega) && fine(y.v))
    }

    /// Decides the modes of everything that rests, after the command may have jumped, with derivative and margins there.
    fn settle(&mut self, state: &mut State, held: &Held) {
        let Self { machine, ends: [start, _], .. } = self;
        machine.respond(held.source, state.time, &state.joints, &state.touching);
        let Machine { coupled, response, .. } = machine;
        start.power = coupled.settle(state, held.commands, response, &mut start.rate);
        start.take_margins(coupled, &state.under(held.commands), &state.touching);
    }

    /// Derivative and margins at the start of a step.
    pub(super) fn begin(&mut self, state: &State, held: &Held) {
        let Self { machine, ends: [start, _], .. } = self;
        machine.respond(held.source, state.time, &state.joints, &state.touching);
        start.take(machine, &state.under(held.commands), &state.touching);
    }

    /// A step of length `h` [s] from the state; its first rate is there already. Returns work and heat.
    fn step(&mut self, state: &State, held: &Held, h: f64) -> Power {
        self.counts.steps += 1;
        self.runge_kutta.step(&mut self.machine, state, held, h, &self.ends[0])
    }

    /// Derivative and margins at the end of a step.
    fn reach(&mut self, state: &State, held: &Held, time: f64) {
        let Self { machine, runge_kutta, ends: [_, end], .. } = self;
        machine.respond(held.source, time, &runge_kutta.end, &state.touching);
        end.take(machine, &state.moved_to(time, &runge_kutta.end, held.commands), &state.touching);
    }

    /// Moves the state to the end of the step.
    fn accept(&mut self, state: &mut State, time: f64, work: Power, watch: &mut impl FnMut(&Step)) {
        let end = &self.runge_kutta.end;
        watch(&Step { time: [state.time, time], joints: [&state.joints, end] });
        state.joints.copy_from_slice(end);
        state.time = time;
        state.done.work += work.work;
        state.done.dissipated += work.dissipated;
    }
}
