//! Runge-Kutta 4 between located events.
//!
//! A step is taken within the modes that hold at its start. Where a margin has turned negative at its end, the earliest root
//! of the margins along the step's cubic Hermite interpolant is found, the step is taken again up to there, and the mode
//! changes: a flank is touched or left, a rotor or link comes to rest or breaks away, the voltage limit is met or left.
//! Without that every method is of first order; it is what remains where events crowd so much that they cannot all be located,
//! and bounds the cost of an interval. The current is the fastest of all; while it is not limited by the voltage its
//! course under a constant command is known, and it is put in as it is (`transient`).

use nalgebra::DMatrix;

use super::FASTEST_MOTION;
use super::coupled::Coupled;
use super::joint::{Phase, Power};
use super::links::Links;
use super::mobility::{Mobility, Response};
use super::mode::{Margins, Mode};
use super::transient::Transient;
use crate::gearhead::Slip;

/// Where `W` and `a₀` come from during a stretch of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// From the engine, at every stage.
    Engine,
    /// From the polynomial through evaluations.
    Polynomial,
}

/// The state of a machine at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// `t` [s].
    pub time: f64,
    /// One a joint.
    pub joints: Vec<Phase>,
    /// One a joint.
    pub modes: Vec<Mode>,
    /// One a barrier: whether it is touched.
    pub touching: Vec<bool>,
    /// [J] done and dissipated since the start.
    pub done: Power,
}

impl State {
    /// Takes over another state without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.time = other.time;
        self.joints.copy_from_slice(&other.joints);
        self.modes.copy_from_slice(&other.modes);
        self.touching.copy_from_slice(&other.touching);
        self.done = other.done;
    }
}

/// How fast the gears of a machine are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fastest {
    /// [rad/s] Of those that oscillate.
    pub oscillation: f64,
    /// [1/s] Of those that damping brings to rest without.
    pub decay: f64,
}

impl Fastest {
    /// [rad/s] Whichever is faster.
    pub fn pole(&self) -> f64 {
        self.oscillation.max(self.decay)
    }
}

/// A step or the part of it up to an event.
pub struct Step<'a> {
    /// [s] start and end.
    pub time: [f64; 2],
    /// State at start and end, one a joint.
    pub joints: [&'a [Phase]; 2],
}

/// What a run has taken so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Evaluations of `M` and `h`.
    pub evaluations: usize,
    /// Answers of the engine by which those between them were confirmed; none where the engine makes every evaluation.
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
    /// Steps, and the probes as the steps that take as long on a machine of `n` joints: a step evaluates the laws of all joints four times.
    pub fn work(&self, n: usize) -> usize {
        self.steps + self.probes / (4 * n).max(1)
    }
}

/// The stepper with its room to work.
pub struct Integrator {
    /// What it has taken so far.
    pub counts: Counts,
    /// Steps, and probes as steps, after which it ends early.
    pub most_steps: usize,
    /// The machine's laws.
    pub coupled: Coupled,
    /// The links.
    pub links: Links,
    /// Their response between evaluations.
    pub mobility: Mobility,
    pub(super) response: Response,
    pub(super) mass: DMatrix<f64>,
    pub(super) bias: Vec<f64>,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) rates: [Vec<Phase>; 4],
    pub(super) power: Power,
    pub(super) end_rate: Vec<Phase>,
    pub(super) end_power: Power,
    /// [s] Step that the transients belong to.
    pub(super) transients_of: f64,
    /// Of the currents in that step, one a joint.
    pub(super) transients: Vec<Transient>,
    pub(super) stage: Vec<Phase>,
    pub(super) end: Vec<Phase>,
    pub(super) probe: Vec<Phase>,
    pub(super) probe_rate: Vec<Phase>,
    pub(super) margins: [Vec<Margins>; 2],
    pub(super) probe_margins: Vec<Margins>,
    /// Those of the near barriers, each with its index.
    pub(super) barrier_margins: [Vec<(usize, f64)>; 2],
}

/// Events that are located between two evaluations; a gap that is crossed a hundred times a millisecond is as good as none.
const MAX_EVENTS: usize = 100;

/// Events without time passing, after which a step is taken in the modes that hold: modes that take turns at one state do
/// the same there.
const MAX_EVENTS_AT_ONCE: usize = 16;

impl Integrator {
    /// For a machine with these laws and links.
    pub fn new(coupled: Coupled, links: Links, most_steps: usize) -> Self {
        let n = coupled.laws.len();
        let phases = || vec![Phase::default(); n];
        let margins = || vec![Margins([f64::INFINITY; 4]); n];
        let count = coupled.barriers.count();
        let barriers = || Vec::with_capacity(count);
        Self {
            counts: Counts::default(),
            most_steps,
            coupled,
            links,
            mobility: Mobility::new(n),
            response: Response::new(n),
            mass: DMatrix::zeros(n, n),
            bias: vec![0.0; n],
            q: vec![0.0; n],
            v: vec![0.0; n],
            rates: [phases(), phases(), phases(), phases()],
            power: Power::default(),
            end_rate: phases(),
            end_power: Power::default(),
            transients_of: 0.0,
            transients: vec![Transient::default(); n],
            stage: phases(),
            end: phases(),
            probe: phases(),
            probe_rate: phases(),
            margins: [margins(), margins()],
            probe_margins: margins(),
            barrier_margins: [barriers(), barriers()],
        }
    }

    /// Evaluates the links at a state.
    fn evaluate(&mut self, time: f64, y: &[Phase]) {
        self.counts.evaluations += 1;
        self.take(y);
        self.links.evaluate(time, &self.q, &self.v, &mut self.mass, &mut self.bias);
    }

    fn take(&mut self, y: &[Phase]) {
        for (i, phase) in y.iter().enumerate() {
            self.q[i] = phase.q;
            self.v[i] = phase.v;
        }
    }

    /// Forgets the past and starts from a state.
    pub fn start(&mut self, y: &[Phase]) {
        self.mobility.clear();
        self.take(y);
        self.links.start(0.0, &self.q, &self.v);
        self.push_node(0.0, y);
    }

    /// Asks the engine at a state that the motion has reached, if that is due.
    pub fn confirm(&mut self, time: f64, y: &[Phase]) {
        if self.links.is_due(time) {
            self.counts.confirmations += 1;
            self.take(y);
            self.links.ask(time, &self.q, &self.v);
        }
    }

    /// Evaluates the links at a state and adds that to the polynomial's nodes.
    pub fn push_node(&mut self, time: f64, y: &[Phase]) {
        self.evaluate(time, y);
        self.mobility.push(time, &self.mass, &self.bias);
    }

    /// Evaluates the links at a state that was reached just now, and compares the answer with what the polynomial says there: the
    /// *surprise* [rad/s² or m/s²], the largest error of an acceleration under the torques that act.
    ///
    /// ```text
    ///   max_i |Σ_j δW_ij τ_j − δa₀_i| / (1 + J_i W_ii)
    /// ```
    /// The divisor, for a joint whose flanks touch, is what its rotor adds to its inertia. No number counts as infinite.
    pub fn offer_node(&mut self, time: f64, y: &[Phase], modes: &[Mode]) -> f64 {
        if y.iter().any(|phase| !(phase.q.is_finite() && phase.v.is_finite())) {
            return f64::INFINITY;
        }
        self.evaluate(time, y);
        self.mobility.offer(time, &self.mass, &self.bias, &mut self.response);
        let mut surprise = 0.0_f64;
        for (i, law) in self.coupled.laws.iter().enumerate() {
            let miss = self.mobility.miss(i, &self.coupled.torques, &self.response).abs();
            let carried = if modes[i].contact == 0 { 0.0 } else { law.rotor_inertia * self.response.w(i, i) };
            surprise = surprise.max(if miss.is_nan() { f64::INFINITY } else { miss / (1.0 + carried) });
        }
        surprise
    }

    /// Everything that the derivative at a time and a state needs of links and barriers.
    pub(super) fn respond(&mut self, source: Source, time: f64, y: &[Phase], touching: &[bool]) {
        self.measure(y, touching);
        match source {
            Source::Polynomial => self.mobility.at(time, &mut self.response),
            Source::Engine => {
                self.evaluate(time, y);
                self.mobility.exact(&self.mass, &self.bias, &mut self.response);
            }
        }
    }

    /// Looks which barriers can be touched until a time; returns a bound [1/s] of the fastest motion against them, 0 for none.
    pub fn look(&mut self, state: &State, until: f64) -> f64 {
        let Self { coupled, links, mobility, response, .. } = self;
        coupled.barriers.look(links.engine.as_mut(), &state.joints, &state.touching, [state.time, until]);
        if coupled.barriers.are_far() {
            return 0.0;
        }
        mobility.newest(response);
        coupled.barriers.fastest(response)
    }

    /// [1/s] Fastest motion that effects bring until a time, 0 without.
    pub fn haste(&self, state: &State, until: f64) -> f64 {
        let Coupled { laws, flows, .. } = &self.coupled;
        let joints = laws.iter().zip(flows).zip(&state.joints);
        joints.fold(0.0, |most, ((law, flow), y)| most.max(law.haste(y, flow.rotor_acceleration, until - state.time)))
    }

    /// Where the links stand to the barriers that are near.
    #[inline]
    pub fn measure(&mut self, y: &[Phase], touching: &[bool]) {
        let Self { coupled, links, .. } = self;
        if !coupled.barriers.are_far() {
            coupled.barriers.measure(links.engine.as_mut(), y, touching);
        }
    }

    /// Fastest motion of the gears at the newest evaluation, and the joint that takes part in it most.
    ///
    /// With all flanks touching the wind-ups obey `ẍ + A D ẋ + A K x = 0`, `A = J⁻¹ + W`: links couple them, so that the largest
    /// eigenvalue of `K^½ A K^½` is above its largest diagonal entry. Damping is looked at one gear at a time.
    pub fn fastest(&mut self) -> (usize, Fastest) {
        self.mobility.newest(&mut self.response);
        let Self { coupled, response, .. } = self;
        let laws = &coupled.laws;
        let a = |i: usize, j: usize| response.w(i, j) + if i == j { 1.0 / laws[i].rotor_inertia } else { 0.0 };
        let (mut joint, mut fastest) = (0, Fastest { oscillation: 0.0, decay: 0.0 });
        for (i, law) in laws.iter().enumerate() {
            let (sigma_0, sigma_1) = law.bristles();
            let omega_squared = law.gearhead.dead_zone.stiffness * a(i, i) + sigma_0 / law.rotor_inertia;
            let delta = 0.5 * (law.gearhead.dead_zone.damping * a(i, i) + sigma_1 / law.rotor_inertia);
            let before = fastest.pole();
            if delta * delta > omega_squared {
                fastest.decay = fastest.decay.max(delta + (delta * delta - omega_squared).sqrt());
            } else {
                fastest.oscillation = fastest.oscillation.max(omega_squared.sqrt());
            }
            if fastest.pole() > before || !a(i, i).is_finite() {
                joint = i;
            }
            if !a(i, i).is_finite() {
                fastest.oscillation = f64::INFINITY;
            }
        }
        if fastest.pole().is_finite() {
            let n = laws.len();
            let stiffness = |i: usize, j: usize| {
                (laws[i].gearhead.dead_zone.stiffness * laws[j].gearhead.dead_zone.stiffness).sqrt()
            };
            let squared = DMatrix::from_fn(n, n, |i, j| stiffness(i, j) * a(i, j));
            fastest.oscillation = squared.symmetric_eigenvalues().max().max(0.0).sqrt().max(fastest.oscillation);
        }
        (joint, fastest)
    }

    /// Decides the modes of everything that rests, after the command may have jumped, with derivative and margins there.
    fn settle(&mut self, state: &mut State, commands: &[f64], source: Source) {
        self.respond(source, state.time, &state.joints, &state.touching);
        let Self { coupled, response, rates, .. } = self;
        let State { time, joints, modes, .. } = state;
        self.power = coupled.settle(*time, joints, modes, commands, response, &mut rates[0]);
        self.measure_margins(state, commands);
    }

    /// Whether going on is in vain: the motion has diverged, or has taken more steps than it may.
    fn is_lost(&self, state: &State) -> bool {
        let fine = |speed: f64| speed.abs() <= FASTEST_MOTION;
        self.counts.work(state.joints.len()) > self.most_steps
            || !state.joints.iter().all(|y| fine(y.omega) && fine(y.v))
    }

    /// Integrates to a time under a constant command that may have jumped; `watch` sees every stretch between events. Ends early where
    /// `is_lost`.
    pub fn advance(
        &mut self,
        state: &mut State,
        commands: &[f64],
        until: f64,
        substeps: usize,
        source: Source,
        mut watch: impl FnMut(&Step),
    ) {
        let start = state.time;
        let length = (until - start) / substeps as f64;
        self.settle(state, commands, source);
        let (mut events, mut at_once) = (0, 0);
        for k in 1..=substeps {
            let target = if k == substeps { until } else { start + k as f64 * length };
            while state.time < target {
                if self.is_lost(state) {
                    return;
                }
                let crowded = events >= MAX_EVENTS;
                if crowded {
                    self.counts.crowded += 1;
                    self.change_overdue(state, commands, source);
                }
                let h = target - state.time;
                let work = self.step(state, commands, h, source);
                self.end_derivative(state, target, commands, source);
                let forced = crowded || at_once >= MAX_EVENTS_AT_ONCE;
                let event = if forced { None } else { self.earliest(state, commands, h, source) };
                let Some((event, share)) = event else {
                    at_once = 0;
                    self.accept(state, target, work, &mut watch);
                    std::mem::swap(&mut self.rates[0], &mut self.end_rate);
                    self.power = self.end_power;
                    let [before, after] = &mut self.margins;
                    std::mem::swap(before, after);
                    self.barrier_margins.swap(0, 1);
                    continue;
                };
                if share * h > 0.0 && state.time + share * h > state.time {
                    let work = self.step(state, commands, share * h, source);
                    self.accept(state, state.time + share * h, work, &mut watch);
                    events += 1;
                    at_once = 0;
                }
                at_once += 1;
                self.counts.events += 1;
                self.change(state, commands, event, source);
                self.begin(state, commands, source);
            }
        }
    }

    /// Derivative and margins at the start of a step.
    pub(super) fn begin(&mut self, state: &State, commands: &[f64], source: Source) {
        self.respond(source, state.time, &state.joints, &state.touching);
        let Self { coupled, response, rates, .. } = self;
        self.power = coupled.derivative(state.time, &state.joints, &state.modes, commands, response, &mut rates[0]);
        self.measure_margins(state, commands);
    }

    /// Margins at the start of a step.
    fn measure_margins(&mut self, state: &State, commands: &[f64]) {
        let Self { coupled, margins, barrier_margins, .. } = self;
        coupled.margins(state.time, &state.joints, &state.modes, commands, &mut margins[0]);
        barrier_margins[0].clear();
        barrier_margins[0].extend(coupled.barriers.margins(&state.touching));
    }

    /// A step of length `h` from the state, into `self.end`; its first rate is there already. Returns work and heat.
    fn step(&mut self, state: &State, commands: &[f64], h: f64, source: Source) -> Power {
        let t = state.time;
        self.counts.steps += 1;
        self.remember_transients(h);
        let mut power = [self.power; 4];
        let mut stages = std::mem::take(&mut self.stage);
        for (k, (share, time)) in [(0.5, t + 0.5 * h), (0.5, t + 0.5 * h), (1.0, t + h)].into_iter().enumerate() {
            for (i, stage) in stages.iter_mut().enumerate() {
                *stage = state.joints[i].step(share * h, &self.rates[k][i]);
            }
            self.put_currents(state, commands, k, &mut stages);
            // The two stages in the middle share a time, and with it the polynomial's answer.
            if k != 1 || source == Source::Engine {
                self.respond(source, time, &stages, &state.touching);
            } else {
                self.measure(&stages, &state.touching);
            }
            let Self { coupled, response, rates, .. } = self;
            power[k + 1] = coupled.derivative(time, &stages, &state.modes, commands, response, &mut rates[k + 1]);
        }
        self.stage = stages;
        let [k1, k2, k3, k4] = &self.rates;
        let sixth = h / 6.0;
        for (i, end) in self.end.iter_mut().enumerate() {
            let y = &state.joints[i];
            let sum = |f: fn(&Phase) -> f64| f(&k1[i]) + 2.0 * (f(&k2[i]) + f(&k3[i])) + f(&k4[i]);
            *end = Phase {
                theta: y.theta + sixth * sum(|p| p.theta),
                omega: y.omega + sixth * sum(|p| p.omega),
                q: y.q + sixth * sum(|p| p.q),
                v: y.v + sixth * sum(|p| p.v),
                current: y.current + sixth * sum(|p| p.current),
                memory: y.memory + sixth * sum(|p| p.memory),
            };
        }
        let mut end = std::mem::take(&mut self.end);
        self.put_currents(state, commands, 3, &mut end);
        self.end = end;
        let [p1, p2, p3, p4] = power;
        Power {
            work: sixth * (p1.work + 2.0 * (p2.work + p3.work) + p4.work),
            dissipated: sixth * (p1.dissipated + 2.0 * (p2.dissipated + p3.dissipated) + p4.dissipated),
        }
    }

    fn remember_transients(&mut self, h: f64) {
        if h != self.transients_of {
            self.transients_of = h;
            for (transient, law) in self.transients.iter_mut().zip(&self.coupled.laws) {
                *transient = Transient::new(&law.power, law.rotor_inertia, h);
            }
        }
    }

    /// Puts the known course of the currents that no voltage limits into a stage (0 to 2) or the end of a step (3).
    fn put_currents(&self, state: &State, commands: &[f64], stage: usize, phases: &mut [Phase]) {
        for (i, phase) in phases.iter_mut().enumerate() {
            let mode = &state.modes[i];
            if mode.saturation == 0 {
                let distance = state.joints[i].current - commands[i];
                let transient = &self.transients[i];
                phase.current = commands[i] + distance * transient.remainder[usize::from(stage > 1)];
                if mode.rotor != Slip::Stuck {
                    phase.theta += distance * transient.theta[stage];
                    phase.omega += distance * transient.omega[stage];
                }
            }
        }
    }

    /// Derivative and margins at the end of a step.
    fn end_derivative(&mut self, state: &State, time: f64, commands: &[f64], source: Source) {
        let end = std::mem::take(&mut self.end);
        self.respond(source, time, &end, &state.touching);
        let Self { coupled, response, end_rate, margins, barrier_margins, .. } = self;
        self.end_power = coupled.derivative(time, &end, &state.modes, commands, response, end_rate);
        coupled.margins(time, &end, &state.modes, commands, &mut margins[1]);
        barrier_margins[1].clear();
        barrier_margins[1].extend(coupled.barriers.margins(&state.touching));
        self.end = end;
    }

    fn accept(&mut self, state: &mut State, time: f64, work: Power, watch: &mut impl FnMut(&Step)) {
        watch(&Step { time: [state.time, time], joints: [&state.joints, &self.end] });
        state.joints.copy_from_slice(&self.end);
        state.time = time;
        state.done.work += work.work;
        state.done.dissipated += work.dissipated;
    }
}
