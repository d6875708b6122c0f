//! One step of Runge-Kutta 4 within the modes that hold at its start.
//!
//! ```text
//!   y₁ = y + h/6 (k₁ + 2 (k₂ + k₃) + k₄)        k₁ at y, k₂ and k₃ at h/2, k₄ at h
//! ```
//! The current is the fastest state. While it is not limited by the voltage, its course under a constant command is known, and the
//! exact course is used (`transient`).

use super::joint::{JointLaws, Phase, Power};
use super::machine::{Machine, Source};
use super::state::State;
use super::step::{Endpoint, Held};
use super::transient::Transient;
use crate::gearhead::Slip;

/// Working memory of a step.
pub(super) struct RungeKutta {
    /// State at the end of the last step.
    pub end: Vec<Phase>,
    stage: Vec<Phase>,
    /// `k₂` to `k₄`; `k₁` is the rate at the start.
    rates: [Vec<Phase>; 3],
    currents: Currents,
}

/// The known course of the currents in a step.
struct Currents {
    /// [s] Step that the transients belong to.
    step: f64,
    /// One per joint.
    transients: Vec<Transient>,
}

impl RungeKutta {
    /// For so many joints.
    pub fn new(joints: usize) -> Self {
        let phases = || vec![Phase::default(); joints];
        Self {
            end: phases(),
            stage: phases(),
            rates: [phases(), phases(), phases()],
            currents: Currents { step: 0.0, transients: vec![Transient::default(); joints] },
        }
    }

    /// A step of length `h` [s] from a state, into [`end`](Self::end); returns work and heat.
    pub fn step(&mut self, machine: &mut Machine, state: &State, held: &Held, h: f64, start: &Endpoint) -> Power {
        self.currents.renew(h, &machine.coupled.laws);
        let mut power = [start.power; 4];
        for (k, share) in [0.5, 0.5, 1.0].into_iter().enumerate() {
            let rate = if k == 0 { &start.rate } else { &self.rates[k - 1] };
            for (i, stage) in self.stage.iter_mut().enumerate() {
                *stage = state.joints[i].step(share * h, &rate[i]);
            }
            self.currents.put(state, held.commands, k, &mut self.stage);
            let time = state.time + share * h;
            // The two stages in the middle share a time, and with it the polynomial's answer.
            if k != 1 || held.source == Source::Engine {
                machine.respond(held.source, time, &self.stage, &state.touching);
            } else {
                machine.measure(&self.stage, &state.touching);
            }
            let at = state.moved_to(time, &self.stage, held.commands);
            power[k + 1] = machine.derivative(&at, &mut self.rates[k]);
        }
        self.finish(state, h, &start.rate);
        self.currents.put(state, held.commands, 3, &mut self.end);
        let [p1, p2, p3, p4] = power;
        let sixth = h / 6.0;
        Power {
            work: sixth * (p1.work + 2.0 * (p2.work + p3.work) + p4.work),
            dissipated: sixth * (p1.dissipated + 2.0 * (p2.dissipated + p3.dissipated) + p4.dissipated),
        }
    }

    /// Sums up the rates of all stages.
    fn finish(&mut self, state: &State, h: f64, k1: &[Phase]) {
        let [k2, k3, k4] = &self.rates;
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
    }
}

impl Currents {
    /// Computes the transients anew if the length of the step has changed.
    fn renew(&mut self, h: f64, laws: &[JointLaws]) {
        if h != self.step {
            self.step = h;
            for (transient, law) in self.transients.iter_mut().zip(laws) {
                *transient = Transient::new(&law.power, law.rotor_inertia, h);
            }
        }
    }

    /// Writes the known course of the currents, where the voltage does not limit them, into a stage (0 to 2) or the end of a step (3).
    fn put(&self, state: &State, commands: &[f64], stage: usize, phases: &mut [Phase]) {
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
}
