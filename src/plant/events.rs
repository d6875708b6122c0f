//! Where within a step a mode ends, and what follows.
//!
//! The root of a margin is found by the Illinois rule along the step's cubic Hermite interpolant; its error there,
//! `h⁴/384` of the fourth derivative, moves an event by less than a nanosecond at the steps in use.

use super::integrator::{Integrator, Source, State};
use super::joint::Phase;
use super::mode::{Change, Event};
use crate::gearhead::Slip;

/// Shortest share of a step for which a mode is given a chance to last.
const SHORTEST: f64 = 1e-3;

impl Integrator {
    /// The event that comes first in a step, and the share of the step before it.
    pub(super) fn earliest(&mut self, state: &State, commands: &[f64], h: f64, source: Source) -> Option<(Event, f64)> {
        let mut first: Option<(Event, f64)> = None;
        for joint in 0..state.joints.len() {
            for (kind, change) in Change::ALL.into_iter().enumerate() {
                let (from, to) = (self.margins[0][joint].0[kind], self.margins[1][joint].0[kind]);
                if to < 0.0 {
                    self.sooner(state, commands, h, source, (Event::Joint(joint, change), [from, to]), &mut first);
                }
            }
        }
        for near in 0..self.barrier_margins[1].len() {
            let ((barrier, from), (_, to)) = (self.barrier_margins[0][near], self.barrier_margins[1][near]);
            if to < 0.0 {
                self.sooner(state, commands, h, source, (Event::Barrier(barrier), [from, to]), &mut first);
            }
        }
        first
    }

    /// Changes every mode whose end lies behind the state.
    pub(super) fn change_overdue(&mut self, state: &mut State, commands: &[f64], source: Source) {
        for joint in 0..state.joints.len() {
            for (kind, change) in Change::ALL.into_iter().enumerate() {
                if self.margins[0][joint].0[kind] < 0.0 {
                    self.change(state, commands, Event::Joint(joint, change), source);
                }
            }
        }
        for near in 0..self.barrier_margins[0].len() {
            let (barrier, margin) = self.barrier_margins[0][near];
            if margin < 0.0 {
                self.change(state, commands, Event::Barrier(barrier), source);
            }
        }
        self.begin(state, commands, source);
    }

    /// Keeps an event if it comes before the first so far; its margin is known at the ends of the step.
    fn sooner(
        &mut self,
        state: &State,
        commands: &[f64],
        h: f64,
        source: Source,
        (event, ends): (Event, [f64; 2]),
        first: &mut Option<(Event, f64)>,
    ) {
        // A mode that has just begun has its end where it began: what counts is whether it is left for a while.
        let mut from = (0.0, ends[0]);
        let mut share = 0.5;
        while from.1 <= 0.0 && share > SHORTEST {
            from = (share, self.margin_at(state, commands, h, source, event, share));
            share *= 0.25;
        }
        let share =
            if from.1 > 0.0 { self.root(state, commands, h, source, event, [from, (1.0, ends[1])]) } else { 0.0 };
        if first.is_none_or(|(_, earliest)| share < earliest) {
            *first = Some((event, share));
        }
    }

    /// Share of the step at which a margin is zero between two shares with margins of opposite sign, by the Illinois rule along the
    /// step's interpolant.
    fn root(
        &mut self,
        state: &State,
        commands: &[f64],
        h: f64,
        source: Source,
        event: Event,
        ends: [(f64, f64); 2],
    ) -> f64 {
        let [(mut a, mut fa), (mut b, mut fb)] = ends;
        let mut side = 0;
        for _ in 0..50 {
            let s = (a * fb - b * fa) / (fb - fa);
            let f = self.margin_at(state, commands, h, source, event, s);
            if (b - a) < 1e-12 || f == 0.0 {
                return s;
            }
            if f > 0.0 {
                if (s - a).abs() < 1e-13 {
                    return s;
                }
                (a, fa) = (s, f);
                if side == 1 {
                    fb *= 0.5;
                }
                side = 1;
            } else {
                if (b - s).abs() < 1e-13 {
                    return s;
                }
                (b, fb) = (s, f);
                if side == -1 {
                    fa *= 0.5;
                }
                side = -1;
            }
        }
        0.5 * (a + b)
    }

    /// A margin inside a step.
    fn margin_at(&mut self, state: &State, commands: &[f64], h: f64, source: Source, event: Event, s: f64) -> f64 {
        let time = state.time + s * h;
        if let Event::Joint(i, change) = event
            && !(change == Change::Link && state.modes[i].link == Slip::Stuck)
        {
            // The joint's own laws tell. What holds a link that sticks, and where a barrier is, depends on all of them.
            self.counts.probes += 1;
            let (law, mode, phase) = (&self.coupled.laws[i], &state.modes[i], self.inside(state, commands, h, i, s));
            let flow = law.flow(time, &phase, mode, commands[i]);
            return law.margins(time, &phase, mode, commands[i], &flow, 0.0).0[change as usize];
        }
        self.counts.probes += state.joints.len();
        let mut probe = std::mem::take(&mut self.probe);
        for (i, phase) in probe.iter_mut().enumerate() {
            *phase = self.inside(state, commands, h, i, s);
        }
        self.respond(source, time, &probe, &state.touching);
        let Self { coupled, response, probe_rate, probe_margins, .. } = self;
        coupled.derivative(time, &probe, &state.modes, commands, response, probe_rate);
        coupled.margins(time, &probe, &state.modes, commands, probe_margins);
        self.probe = probe;
        match event {
            Event::Joint(joint, change) => self.probe_margins[joint].0[change as usize],
            Event::Barrier(barrier) => self.coupled.barriers.margin(barrier, &state.touching),
        }
    }

    /// A joint inside a step.
    fn inside(&self, state: &State, commands: &[f64], h: f64, i: usize, s: f64) -> Phase {
        let mut phase = hermite(&state.joints[i], &self.rates[0][i], &self.end[i], &self.end_rate[i], h, s);
        if state.modes[i].saturation == 0 {
            let remainder = self.coupled.laws[i].power.remainder(s * h);
            phase.current = commands[i] + (state.joints[i].current - commands[i]) * remainder;
        }
        phase
    }

    /// Changes a mode at the state.
    pub(super) fn change(&mut self, state: &mut State, commands: &[f64], event: Event, source: Source) {
        match event {
            Event::Joint(joint, change) => self.change_joint(state, commands, joint, change, source),
            Event::Barrier(barrier) => {
                self.measure(&state.joints, &state.touching);
                state.done.dissipated += self.coupled.barriers.change(barrier, &mut state.touching);
            }
        }
    }

    fn change_joint(&mut self, state: &mut State, commands: &[f64], joint: usize, change: Change, source: Source) {
        let law = &self.coupled.laws[joint];
        let (y, mode) = (&mut state.joints[joint], &mut state.modes[joint]);
        match change {
            Change::Contact => {
                let before = law.elastic_energy(state.time, y, mode.contact);
                mode.contact = if mode.contact == 0 { law.nearer_flank(state.time, y) } else { 0 };
                // Compression that remains when a tooth leaves relaxes in its own damper.
                state.done.dissipated += before - law.elastic_energy(state.time, y, mode.contact);
            }
            Change::Saturation => {
                let demand = law.power.demand(commands[joint], y.current, y.omega);
                mode.saturation = if mode.saturation == 0 { if demand > 0.0 { 1 } else { -1 } } else { 0 };
            }
            Change::Rotor if mode.rotor == Slip::Stuck => {
                let flow = law.flow(state.time, y, mode, commands[joint]);
                mode.rotor = Slip::towards(flow.rotor_drive);
            }
            Change::Rotor => {
                if let Some(slip) = law.gearhead.rotor.beyond(mode.rotor, y.omega.abs()) {
                    mode.rotor = slip;
                    return;
                }
                y.omega = 0.0;
                mode.rotor = Slip::Stuck;
                let flow = law.flow(state.time, y, mode, commands[joint]);
                if law.margins(state.time, y, mode, commands[joint], &flow, 0.0).0[1] < 0.0 {
                    mode.rotor = Slip::towards(flow.rotor_drive);
                }
            }
            Change::Link if mode.link == Slip::Stuck => {
                self.respond(source, state.time, &state.joints, &state.touching);
                let Self { coupled, response, probe_rate, .. } = self;
                coupled.derivative(state.time, &state.joints, &state.modes, commands, response, probe_rate);
                state.modes[joint].link = Slip::towards(coupled.holds[joint]);
            }
            Change::Link => {
                if let Some(slip) = law.gearhead.link.beyond(mode.link, y.v.abs()) {
                    mode.link = slip;
                    return;
                }
                y.v = 0.0;
                mode.link = Slip::Stuck;
                self.respond(source, state.time, &state.joints, &state.touching);
                let Self { coupled, response, probe_rate, .. } = self;
                let modes = &mut state.modes;
                coupled.settle_links(state.time, &state.joints, modes, commands, response, probe_rate);
            }
        }
    }
}

/// Cubic through two states and their rates, at a share of the step between them.
fn hermite(y0: &Phase, r0: &Phase, y1: &Phase, r1: &Phase, h: f64, s: f64) -> Phase {
    let (s2, s3) = (s * s, s * s * s);
    let (a, b) = (3.0 * s2 - 2.0 * s3, s - 2.0 * s2 + s3);
    let c = s3 - s2;
    let at = |f: fn(&Phase) -> f64| f(y0) + a * (f(y1) - f(y0)) + h * (b * f(r0) + c * f(r1));
    Phase {
        theta: at(|p| p.theta),
        omega: at(|p| p.omega),
        q: at(|p| p.q),
        v: at(|p| p.v),
        current: at(|p| p.current),
        memory: at(|p| p.memory),
    }
}
