//! Where within a step a mode ends, and what follows.
//!
//! The root of a margin is found by the Illinois rule along the step's cubic Hermite interpolant; its error there,
//! `h⁴/384` of the fourth derivative, moves an event by less than a nanosecond at the steps in use.

use super::integrator::Integrator;
use super::joint::Phase;
use super::machine::Machine;
use super::mode::{Change, Event};
use super::state::State;
use super::step::{Held, Probe, Tried};
use crate::gearhead::Slip;

/// Shortest share of a step for which a new mode is tested.
const SHORTEST: f64 = 1e-3;

/// Most trials of a root: the Illinois rule needs about ten, and a margin with a kink inside the step a few more.
const MOST_TRIALS: usize = 50;

impl Integrator {
    /// The event that comes first in a step, and the share of the step before it.
    pub(super) fn earliest(&mut self, step: &Tried) -> Option<(Event, f64)> {
        let mut first: Option<(Event, f64)> = None;
        let mut offer = |event: Event, share: f64| {
            if first.is_none_or(|(_, earliest)| share < earliest) {
                first = Some((event, share));
            }
        };
        for joint in 0..step.state.joints.len() {
            for (kind, change) in Change::ALL.into_iter().enumerate() {
                let ends = [0, 1].map(|end| self.ends[end].margins[joint].0[kind]);
                if ends[1] < 0.0 {
                    let event = Event::Joint(joint, change);
                    offer(event, self.share_before(step, event, ends));
                }
            }
        }
        for near in 0..self.ends[1].barrier_margins.len() {
            let [(barrier, from), (_, to)] = [0, 1].map(|end| self.ends[end].barrier_margins[near]);
            if to < 0.0 {
                let event = Event::Barrier(barrier);
                offer(event, self.share_before(step, event, [from, to]));
            }
        }
        first
    }

    /// Changes every mode whose end the state has passed.
    pub(super) fn change_overdue(&mut self, state: &mut State, held: &Held) {
        for joint in 0..state.joints.len() {
            for (kind, change) in Change::ALL.into_iter().enumerate() {
                if self.ends[0].margins[joint].0[kind] < 0.0 {
                    self.change(state, held, Event::Joint(joint, change));
                }
            }
        }
        for near in 0..self.ends[0].barrier_margins.len() {
            let (barrier, margin) = self.ends[0].barrier_margins[near];
            if margin < 0.0 {
                self.change(state, held, Event::Barrier(barrier));
            }
        }
        self.begin(state, held);
    }

    /// Share of the step before an event, whose margin is known at the ends of the step.
    fn share_before(&mut self, step: &Tried, event: Event, ends: [f64; 2]) -> f64 {
        // A mode that has just begun starts at margin zero: what counts is whether the margin is positive for a while.
        let mut from = (0.0, ends[0]);
        let mut share = 0.5;
        while from.1 <= 0.0 && share > SHORTEST {
            from = (share, self.margin_at(step, event, share));
            share *= 0.25;
        }
        if from.1 > 0.0 { self.root(step, event, [from, (1.0, ends[1])]) } else { 0.0 }
    }

    /// Share of the step at which a margin is zero between two shares with margins of opposite sign, by the Illinois rule along the
    /// step's interpolant.
    fn root(&mut self, step: &Tried, event: Event, ends: [(f64, f64); 2]) -> f64 {
        let [(mut a, mut fa), (mut b, mut fb)] = ends;
        let mut side = 0;
        for _ in 0..MOST_TRIALS {
            let s = (a * fb - b * fa) / (fb - fa);
            let f = self.margin_at(step, event, s);
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

    /// A margin at a share of a step.
    fn margin_at(&mut self, step: &Tried, event: Event, s: f64) -> f64 {
        let Tried { state, held, h } = *step;
        let time = state.time + s * h;
        if let Event::Joint(i, change) = event
            && !(change == Change::Link && state.modes[i].link == Slip::Stuck)
        {
            // The joint's own laws are enough. The friction that holds a link, and the distance of a barrier, depend on all joints.
            self.counts.probes += 1;
            let (law, mode, phase) = (&self.machine.coupled.laws[i], &state.modes[i], self.inside(step, i, s));
            let flow = law.flow(time, &phase, mode, held.commands[i]);
            return law.margins(time, &phase, mode, held.commands[i], &flow, 0.0).0[change as usize];
        }
        self.counts.probes += state.joints.len();
        for i in 0..state.joints.len() {
            self.probe.joints[i] = self.inside(step, i, s);
        }
        let Self { machine, probe: Probe { joints, rate, margins }, .. } = self;
        machine.respond(held.source, time, joints, &state.touching);
        let at = state.moved_to(time, joints, held.commands);
        machine.derivative(&at, rate);
        machine.coupled.margins(&at, margins);
        match event {
            Event::Joint(joint, change) => margins[joint].0[change as usize],
            Event::Barrier(barrier) => machine.coupled.barriers.margin(barrier, &state.touching),
        }
    }

    /// A joint at a share of a step.
    fn inside(&self, step: &Tried, i: usize, s: f64) -> Phase {
        let Tried { state, held, h } = step;
        let [rate, end_rate] = [0, 1].map(|end| &self.ends[end].rate[i]);
        let mut phase = hermite(&state.joints[i], rate, &self.runge_kutta.end[i], end_rate, *h, s);
        if state.modes[i].saturation == 0 {
            let remainder = self.machine.coupled.laws[i].power.remainder(s * h);
            phase.current = held.commands[i] + (state.joints[i].current - held.commands[i]) * remainder;
        }
        phase
    }

    /// Changes a mode at the state.
    pub(super) fn change(&mut self, state: &mut State, held: &Held, event: Event) {
        match event {
            Event::Joint(joint, Change::Contact) => self.change_contact(state, joint),
            Event::Joint(joint, Change::Rotor) => self.change_rotor(state, held, joint),
            Event::Joint(joint, Change::Link) => self.change_link(state, held, joint),
            Event::Joint(joint, Change::Saturation) => self.change_saturation(state, held, joint),
            Event::Barrier(barrier) => {
                self.machine.measure(&state.joints, &state.touching);
                state.done.dissipated += self.machine.coupled.barriers.change(barrier, &mut state.touching);
            }
        }
    }

    /// A flank is touched or left. Compression that remains when a tooth leaves relaxes in its own damper.
    fn change_contact(&self, state: &mut State, joint: usize) {
        let law = &self.machine.coupled.laws[joint];
        let (y, mode) = (&state.joints[joint], &mut state.modes[joint]);
        let before = law.elastic_energy(state.time, y, mode.contact);
        mode.contact = if mode.contact == 0 { law.nearer_flank(state.time, y) } else { 0 };
        state.done.dissipated += before - law.elastic_energy(state.time, y, mode.contact);
    }

    /// The voltage limit is met or left.
    fn change_saturation(&self, state: &mut State, held: &Held, joint: usize) {
        let law = &self.machine.coupled.laws[joint];
        let (y, mode) = (&state.joints[joint], &mut state.modes[joint]);
        let demand = law.power.demand(held.commands[joint], y.current, y.omega);
        mode.saturation = if mode.saturation == 0 { if demand > 0.0 { 1 } else { -1 } } else { 0 };
    }

    /// The rotor breaks away, passes the kink of its law, or comes to rest.
    fn change_rotor(&self, state: &mut State, held: &Held, joint: usize) {
        let law = &self.machine.coupled.laws[joint];
        let (y, mode, command) = (&mut state.joints[joint], &mut state.modes[joint], held.commands[joint]);
        if mode.rotor == Slip::Stuck {
            mode.rotor = Slip::towards(law.flow(state.time, y, mode, command).rotor_drive);
        } else if let Some(slip) = law.gearhead.rotor.beyond(mode.rotor, y.omega.abs()) {
            mode.rotor = slip;
        } else {
            y.omega = 0.0;
            mode.rotor = law.resting_rotor(state.time, y, mode, command);
        }
    }

    /// The link breaks away, passes the kink of its law, or comes to rest. Then it is decided again which links at rest stick.
    fn change_link(&mut self, state: &mut State, held: &Held, joint: usize) {
        let Self { machine, probe: Probe { rate, .. }, .. } = self;
        let (y, mode) = (&mut state.joints[joint], &mut state.modes[joint]);
        if mode.link == Slip::Stuck {
            machine.respond(held.source, state.time, &state.joints, &state.touching);
            machine.derivative(&state.under(held.commands), rate);
            state.modes[joint].link = Slip::towards(machine.coupled.holds[joint]);
        } else if let Some(slip) = machine.coupled.laws[joint].gearhead.link.beyond(mode.link, y.v.abs()) {
            mode.link = slip;
        } else {
            y.v = 0.0;
            mode.link = Slip::Stuck;
            machine.respond(held.source, state.time, &state.joints, &state.touching);
            let Machine { coupled, response, .. } = machine;
            coupled.settle_links(state, held.commands, response, rate);
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
