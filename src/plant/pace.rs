//! From one evaluation of the engine to the next: how often an interval is simulated.
//!
//! In most intervals there is no surprise: the extrapolated response turns out right, and one pass is enough. After a surprise the
//! end of the next interval is first estimated in a few coarse steps, so that the full pass can interpolate. Where even that would
//! be wrong, the engine is asked at every stage.
//! With [`Coarse`](super::Accuracy::Coarse) accuracy one evaluation serves several intervals while nothing happens (`accuracy`).

use super::machine::Source;
use super::step::{Held, Step};
use super::{FASTEST_STEPS, Plant};

/// Longest step times the fastest decay of a gear that does not oscillate: for one step, a share `1/120` of the decaying motion is
/// wrong, and this error decays with it in a few steps. Momentum is conserved whatever the step.
pub(super) const LONGEST_STEP_DAMPED: f64 = 1.0;

/// Longest step times the fastest motion of links against barriers: an impact is half an oscillation in 16 steps, and its
/// restitution is right within 1e-5.
const LONGEST_STEP_TOUCHING: f64 = 0.2;

/// Longest step times the fastest pole where only stability counts.
const STABLE_STEP: f64 = 1.0;

/// [rad/s² or m/s²] An extrapolation after which the interpolation is right: its error is 24 times smaller.
const SOME_SURPRISE: f64 = 1.0;

impl Plant {
    /// One interval between evaluations, and the engine's answer at its end if that is due.
    pub(super) fn advance_piece(&mut self, until: f64) {
        self.pass(until);
        self.integrator.machine.confirm(until, &self.state.joints);
    }

    /// One interval between evaluations, in the cheapest way that is accurate: under the extrapolated response if it turns out right;
    /// else again under the response interpolated with the evaluation at its end; else with an evaluation at every stage.
    fn pass(&mut self, until: f64) {
        if self.every_stage || !self.integrator.machine.mobility.is_full() {
            self.go_through(until, Source::Engine);
            self.integrator.machine.push_node(until, &self.state.joints);
            return;
        }
        let start = self.state.time;
        let surprise = if self.calm { self.try_out(until) } else { Some(self.look_ahead(until)) };
        let Some(surprise) = surprise else { return };
        let done = self.calm && surprise <= self.no_surprise;
        self.calm = surprise <= self.no_surprise;
        if done {
            self.integrator.machine.mobility.accept(until);
            let (events, velocities) = (self.integrator.counts().events, self.state.joints.iter().map(|y| y.v));
            self.lull.begin([start, until], surprise, events, velocities);
            return;
        }
        self.lull.stop();
        if surprise <= SOME_SURPRISE {
            self.integrator.machine.mobility.accept(until);
            self.go_through(until, Source::Polynomial);
        } else {
            self.go_through(until, Source::Engine);
            self.integrator.machine.push_node(until, &self.state.joints);
        }
    }

    /// Simulates an interval in full; if the extrapolation turns out to be wrong, restores the state before it. `None` in a lull, where
    /// the extrapolation goes on.
    fn try_out(&mut self, until: f64) -> Option<f64> {
        self.saved.copy_from(&self.state);
        self.saved_trackers.iter_mut().zip(&self.sensors).for_each(|(saved, sensors)| *saved = sensors.tracker);
        self.go_through(until, Source::Polynomial);
        if self.lull.lasts(until, self.integrator.counts().events, self.state.joints.iter().map(|y| y.v)) {
            return None;
        }
        let surprise = self.integrator.machine.offer_node(until, &self.state.joints, &self.state.modes);
        if surprise > self.no_surprise {
            self.state.copy_from(&self.saved);
            self.sensors.iter_mut().zip(&self.saved_trackers).for_each(|(sensors, saved)| sensors.tracker = *saved);
        }
        Some(surprise)
    }

    /// Estimates the end of an interval in the fewest steps that are stable.
    fn look_ahead(&mut self, until: f64) -> f64 {
        let Self { integrator, state, saved, commands, fastest, asked, .. } = self;
        saved.copy_from(state);
        let fastest = fastest.max(integrator.machine.look(saved, until)).max(integrator.machine.haste(saved, until));
        let rate = fastest / STABLE_STEP;
        *asked = asked.max(rate);
        let steps = ((until - state.time) * rate.min(FASTEST_STEPS)).ceil().max(1.0) as usize;
        let held = Held { commands, source: Source::Polynomial };
        integrator.advance(saved, held, until, steps, |_| {});
        integrator.machine.offer_node(until, &saved.joints, &saved.modes)
    }

    fn go_through(&mut self, until: f64, source: Source) {
        let Self { integrator, sensors, state, commands, rate, asked, .. } = self;
        let rate = rate.max(integrator.machine.look(state, until) / LONGEST_STEP_TOUCHING);
        let rate = rate.max(integrator.machine.haste(state, until) / STABLE_STEP);
        *asked = asked.max(rate);
        let steps = ((until - state.time) * rate.min(FASTEST_STEPS) - 1e-6).ceil().max(1.0) as usize;
        integrator.advance(state, Held { commands, source }, until, steps, |step: &Step| {
            for (i, sensors) in sensors.iter_mut().enumerate() {
                sensors.watch(step.time, &step.joints[0][i], &step.joints[1][i]);
            }
        });
    }
}
