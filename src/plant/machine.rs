//! The right-hand side of a machine's equations of motion: the joints' laws, the links, and what stands in their way.
//!
//! ```text
//!   q̈ = W τ − a₀        W, a₀ from the engine, or from the polynomial through its answers (`mobility`)
//! ```

use nalgebra::DMatrix;

use super::coupled::Coupled;
use super::joint::{Phase, Power};
use super::links::Links;
use super::mobility::{Mobility, Response};
use super::mode::Mode;
use super::state::{Situation, State};

/// Where `W` and `a₀` come from during a stretch of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// From the engine, at every stage.
    Engine,
    /// From the polynomial through evaluations.
    Polynomial,
}

/// Laws and links of a machine.
pub struct Machine {
    /// The joints' laws.
    pub coupled: Coupled,
    /// The links.
    pub links: Links,
    /// Their response between evaluations.
    pub mobility: Mobility,
    /// Their response at the last time for which it was requested.
    pub response: Response,
    /// Evaluations of `M` and `h`.
    pub evaluations: usize,
    /// Evaluations of the engine that confirmed those of the built-in algorithms.
    pub confirmations: usize,
    /// [kg·m² or kg] Inertia that joints bear beside their links, because their dampers are too fast ([`Machine::slow_dampers`]).
    pub(super) borne: Vec<f64>,
    asked: Asked,
}

/// Arguments and results of an evaluation of the links.
struct Asked {
    q: Vec<f64>,
    v: Vec<f64>,
    /// `M(q)`.
    mass: DMatrix<f64>,
    /// `h(q, q̇)`.
    bias: Vec<f64>,
}

impl Asked {
    fn at(&mut self, joints: &[Phase]) {
        for (i, phase) in joints.iter().enumerate() {
            self.q[i] = phase.q;
            self.v[i] = phase.v;
        }
    }
}

impl Machine {
    /// A machine of these laws and links.
    pub fn new(coupled: Coupled, links: Links) -> Self {
        let n = coupled.laws.len();
        Self {
            coupled,
            links,
            mobility: Mobility::new(n),
            response: Response::new(n),
            evaluations: 0,
            confirmations: 0,
            borne: vec![0.0; n],
            asked: Asked { q: vec![0.0; n], v: vec![0.0; n], mass: DMatrix::zeros(n, n), bias: vec![0.0; n] },
        }
    }

    /// Evaluates the links at a state.
    fn evaluate(&mut self, time: f64, joints: &[Phase]) {
        self.evaluations += 1;
        self.asked.at(joints);
        let Asked { q, v, mass, bias } = &mut self.asked;
        self.links.evaluate(time, q, v, mass, bias);
        for (i, borne) in self.borne.iter().enumerate() {
            mass[(i, i)] += borne;
        }
    }

    /// Forgets the past and starts from a state.
    pub fn start(&mut self, time: f64, joints: &[Phase]) {
        self.mobility.clear();
        self.asked.at(joints);
        self.links.start(time, &self.asked.q, &self.asked.v);
        self.push_node(time, joints);
    }

    /// Asks the engine at a state that the motion has reached, if that is due.
    pub fn confirm(&mut self, time: f64, joints: &[Phase]) {
        if self.links.is_due(time) {
            self.confirmations += 1;
            self.asked.at(joints);
            self.links.ask(time, &self.asked.q, &self.asked.v);
        }
    }

    /// Evaluates the links at a state and adds that to the polynomial's nodes.
    pub fn push_node(&mut self, time: f64, joints: &[Phase]) {
        self.evaluate(time, joints);
        self.mobility.push(time, &self.asked.mass, &self.asked.bias);
    }

    /// Evaluates the links at a state that was reached just now, and compares the answer with what the polynomial says there: the
    /// *surprise* [rad/s² or m/s²], the largest error of an acceleration under the torques that act.
    ///
    /// ```text
    ///   max_i |Σ_j δW_ij τ_j − δa₀_i| / (1 + J_i W_ii)
    /// ```
    /// The divisor, for a joint whose flanks touch, is what its rotor adds to its inertia. NaN counts as infinite.
    pub fn offer_node(&mut self, time: f64, joints: &[Phase], modes: &[Mode]) -> f64 {
        if joints.iter().any(|phase| !(phase.q.is_finite() && phase.v.is_finite())) {
            return f64::INFINITY;
        }
        self.evaluate(time, joints);
        self.mobility.offer(time, &self.asked.mass, &self.asked.bias, &mut self.response);
        let mut surprise = 0.0_f64;
        for (i, law) in self.coupled.laws.iter().enumerate() {
            let miss = self.mobility.miss(i, &self.coupled.torques, &self.response).abs();
            let carried = if modes[i].contact == 0 { 0.0 } else { law.rotor_inertia * self.response.w(i, i) };
            surprise = surprise.max(if miss.is_nan() { f64::INFINITY } else { miss / (1.0 + carried) });
        }
        surprise
    }

    /// Finds everything that the derivative at a time and a state needs of links and barriers.
    pub fn respond(&mut self, source: Source, time: f64, joints: &[Phase], touching: &[bool]) {
        self.measure(joints, touching);
        match source {
            Source::Polynomial => self.mobility.at(time, &mut self.response),
            Source::Engine => {
                self.evaluate(time, joints);
                self.mobility.exact(&self.asked.mass, &self.asked.bias, &mut self.response);
            }
        }
    }

    /// Measures the distances of the links from the near barriers.
    #[inline]
    pub fn measure(&mut self, joints: &[Phase], touching: &[bool]) {
        let Self { coupled, links, .. } = self;
        if !coupled.barriers.are_far() {
            coupled.barriers.measure(links.engine.as_mut(), joints, touching);
        }
    }

    /// Writes the derivative under the response found last; returns the power that flows.
    #[inline]
    pub fn derivative(&mut self, at: &Situation, rate: &mut [Phase]) -> Power {
        self.coupled.derivative(at, &self.response, rate)
    }

    /// Determines which barriers can be touched until a time; returns a bound [1/s] of the fastest motion against them, 0 for none.
    pub fn look(&mut self, state: &State, until: f64) -> f64 {
        let Self { coupled, links, mobility, response, .. } = self;
        coupled.barriers.look(links.engine.as_mut(), &state.joints, &state.touching, [state.time, until]);
        if coupled.barriers.are_far() {
            return 0.0;
        }
        mobility.newest(response);
        coupled.barriers.fastest(response)
    }

    /// [1/s] Fastest rate that effects cause until a time, 0 without effects.
    pub fn haste(&self, state: &State, until: f64) -> f64 {
        let Coupled { laws, flows, .. } = &self.coupled;
        let joints = laws.iter().zip(flows).zip(&state.joints);
        joints.fold(0.0, |most, ((law, flow), y)| most.max(law.haste(y, flow.rotor_acceleration, until - state.time)))
    }
}
