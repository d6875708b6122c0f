//! All joints together: accelerations of the links under their loads, and the friction that holds those that stick.
//!
//! ```text
//!   v̇ = W (load + λ) − a₀,   λ_i = −F_i holds v̇_i = 0 on the set S of links that stick, λ = 0 elsewhere:
//!   W_SS λ_S = −(W load − a₀)_S
//! ```
//! Which links stick is decided all at once: among the links at rest, Murty's least-index rule exchanges one link that
//! violates its condition (`|F_i|` within its level while it sticks, acceleration along its slip while it slips) until none
//! does; `W` is positive definite, so it ends, and the answer is unique.
//!
//! Where motor axes are coupled, `v`, `W` and `a₀` are those of the axes' outputs, `C q̇`, and what acts on a joint loads the axes:
//!
//! ```text
//!   load = T − F_l + C⁻ᵀ (τ_l − c q̇)        τ_l, c: of the joint; T, F_l: of the axis
//! ```
//! The friction of a joint's own bearing counts as friction of the axis of its name, so that one law holds an axis at rest.

use super::contact::Barriers;
use super::joint::{Flow, JointLaws, Phase, Power};
use super::mobility::Response;
use super::mode::{Change, Margins};
use super::state::{Situation, State};
use crate::effects::JointState;
use crate::gearhead::Slip;
use crate::robot::{Coupling, Robot};

/// What acts on joints that several axes move, in addition to the gears.
struct Joints {
    coupling: Coupling,
    /// `c`: URDF `damping`, one per joint.
    damping: Vec<f64>,
}

impl Joints {
    /// Adds `C⁻ᵀ (τ_l − c q̇)` to the torques on the axes' outputs; returns its power.
    #[cold]
    fn load(&self, at: &Situation, laws: &[JointLaws], flows: &[Flow], torques: &mut [f64]) -> Power {
        let mut power = Power::default();
        for (j, (law, flow)) in laws.iter().zip(flows).enumerate() {
            let velocity = self.coupling.joint(j, |axis| at.joints[axis].v);
            let mut torque = -self.damping[j] * velocity;
            power.dissipated -= torque * velocity;
            if !law.actions.is_empty() {
                let state = JointState {
                    link_position: self.coupling.joint(j, |axis| at.joints[axis].q),
                    link_velocity: velocity,
                    ..law.observe(at.time, &at.joints[j], flow.gear_torque, flow.current)
                };
                let added: f64 = law.actions.iter().map(|action| action.link_torque(&state)).sum();
                power.work += added * velocity;
                torque += added;
            }
            for (axis, sum) in torques.iter_mut().enumerate() {
                *sum += self.coupling.joint_per_axis(j, axis) * torque;
            }
        }
        power
    }
}

/// The joints' laws, with working memory.
pub struct Coupled {
    /// One per joint.
    pub laws: Vec<JointLaws>,
    /// Results of the laws at the last evaluated state.
    pub flows: Vec<Flow>,
    /// `F_i` of the links that stick, at the last evaluated state.
    pub holds: Vec<f64>,
    /// Torque on every link, barriers and the friction that holds it included, at the last evaluated state.
    pub torques: Vec<f64>,
    /// What stands in the links' way.
    pub barriers: Barriers,
    /// What acts on joints that several axes move.
    joints: Option<Joints>,
    stuck: Vec<usize>,
    factor: Vec<f64>,
    hold: Vec<f64>,
}

impl Coupled {
    /// Joins the laws of all joints, and what stands in the links' way.
    pub fn new(laws: Vec<JointLaws>, barriers: Barriers, robot: &Robot) -> Self {
        let n = laws.len();
        Self {
            laws,
            flows: vec![Flow::default(); n],
            holds: vec![0.0; n],
            torques: vec![0.0; n],
            barriers,
            joints: robot.coupling.as_ref().map(|coupling| Joints {
                coupling: coupling.clone(),
                damping: robot.bodies.iter().map(|body| body.joint.damping).collect(),
            }),
            stuck: Vec::with_capacity(n),
            factor: vec![0.0; n * n],
            hold: vec![0.0; n],
        }
    }

    /// Writes the derivative of the state within a mode; returns the power that flows.
    #[inline]
    pub fn derivative(&mut self, at: &Situation, response: &Response, rate: &mut [Phase]) -> Power {
        let mut power = Power::default();
        self.stuck.clear();
        let Self { laws, flows, torques, stuck, barriers, joints, .. } = self;
        let sides = laws.iter().zip(at.joints).zip(at.modes).zip(at.commands);
        let found = flows.iter_mut().zip(torques.iter_mut()).zip(rate.iter_mut());
        for (i, ((((law, y), mode), command), ((flow, torque), rate))) in sides.zip(found).enumerate() {
            *flow = law.flow(at.time, y, mode, *command);
            power.work += flow.power.work;
            power.dissipated += flow.power.dissipated;
            *torque = flow.link_load;
            rate.theta = y.omega;
            rate.omega = flow.rotor_acceleration;
            rate.q = y.v;
            rate.current = flow.current_rate;
            rate.memory = flow.memory_rate;
            if mode.link == Slip::Stuck {
                stuck.push(i);
            }
        }
        if let Some(joints) = joints {
            let added = joints.load(at, laws, flows, torques);
            power.work += added.work;
            power.dissipated += added.dissipated;
        }
        if !barriers.are_far() {
            torques.iter_mut().zip(&barriers.load).for_each(|(torque, load)| *torque += load);
            power.dissipated += barriers.heat;
        }
        for (i, rate) in rate.iter_mut().enumerate() {
            rate.v = dot(response.row(i), torques) - response.free(i);
        }
        if !self.stuck.is_empty() {
            self.hold_links(response, rate);
        }
        power
    }

    /// Finds `λ` of the links that stick and adds its effect.
    fn hold_links(&mut self, response: &Response, rate: &mut [Phase]) {
        if let [only] = self.stuck[..] {
            self.hold_link(only, response, rate);
        } else {
            self.hold_several(response, rate);
        }
    }

    /// The same for one link, `λ = −v̇/W`, rounded as by the factorisation of several.
    #[inline]
    fn hold_link(&mut self, s: usize, response: &Response, rate: &mut [Phase]) {
        let root = response.w(s, s).max(f64::MIN_POSITIVE).sqrt();
        let lambda = -rate[s].v / root / root;
        for (i, rate) in rate.iter_mut().enumerate() {
            rate.v += response.w(i, s) * lambda;
        }
        rate[s].v = 0.0;
        self.holds[s] = -lambda;
        self.torques[s] += lambda;
    }

    fn hold_several(&mut self, response: &Response, rate: &mut [Phase]) {
        let Self { stuck, factor, hold, holds, torques, .. } = self;
        let m = stuck.len();
        for a in 0..m {
            for b in 0..=a {
                let dot: f64 = (0..b).map(|k| factor[a * m + k] * factor[b * m + k]).sum();
                let rest = response.w(stuck[a], stuck[b]) - dot;
                factor[a * m + b] = if a == b { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / factor[b * m + b] };
            }
            let dot: f64 = (0..a).map(|k| factor[a * m + k] * hold[k]).sum();
            hold[a] = (-rate[stuck[a]].v - dot) / factor[a * m + a];
        }
        for a in (0..m).rev() {
            let dot: f64 = (a + 1..m).map(|k| factor[k * m + a] * hold[k]).sum();
            hold[a] = (hold[a] - dot) / factor[a * m + a];
        }
        for (i, rate) in rate.iter_mut().enumerate() {
            let row = response.row(i);
            rate.v += stuck.iter().zip(&hold[..m]).map(|(&s, lambda)| row[s] * lambda).sum::<f64>();
        }
        for (&s, lambda) in stuck.iter().zip(&hold[..m]) {
            rate[s].v = 0.0;
            holds[s] = -lambda;
            torques[s] += lambda;
        }
    }

    /// Distances from the ends of the modes, at the state of the last call of [`Coupled::derivative`].
    pub fn margins(&self, at: &Situation, margins: &mut [Margins]) {
        for (i, margins) in margins.iter_mut().enumerate() {
            *margins = self.margins_of(i, at);
        }
    }

    /// Margins of one joint.
    fn margins_of(&self, i: usize, at: &Situation) -> Margins {
        let Situation { time, joints, modes, commands } = at;
        self.laws[i].margins(*time, &joints[i], &modes[i], commands[i], &self.flows[i], self.holds[i])
    }

    /// Decides saturation and friction of everything that rests, at a state where the command may have jumped; leaves the
    /// derivative of the state as [`Coupled::derivative`] does.
    pub fn settle(&mut self, state: &mut State, commands: &[f64], response: &Response, rate: &mut [Phase]) -> Power {
        let State { time, joints, modes, .. } = state;
        for (i, law) in self.laws.iter().enumerate() {
            let (y, mode, command) = (&joints[i], &mut modes[i], commands[i]);
            mode.saturation = law.power.saturation(law.power.demand(command, y.current, y.omega));
            if y.omega == 0.0 && mode.rotor != Slip::Free {
                mode.rotor = law.resting_rotor(*time, y, mode, command);
            }
        }
        self.settle_links(state, commands, response, rate)
    }

    /// Decides which of the links at rest stick; leaves the derivative of the state as [`Coupled::derivative`] does.
    pub fn settle_links(
        &mut self,
        state: &mut State,
        commands: &[f64],
        response: &Response,
        rate: &mut [Phase],
    ) -> Power {
        let n = self.laws.len();
        let mut power = Power::default();
        // Least-index exchange visits no set twice, so 3ⁿ bounds the exchanges; in practice a few are enough.
        for _ in 0..3_usize.saturating_pow(n as u32).min(1000) {
            let at = state.under(commands);
            power = self.derivative(&at, response, rate);
            let Some(i) = (0..n).find(|&i| self.violates(i, &at, rate)) else { break };
            let link = &mut state.modes[i].link;
            *link = if *link == Slip::Stuck { Slip::towards(self.holds[i]) } else { Slip::Stuck };
        }
        power
    }

    /// Whether a link at rest violates the condition of its mode: friction beyond its level while it sticks, acceleration against its
    /// slip while it slips.
    fn violates(&self, i: usize, at: &Situation, rate: &[Phase]) -> bool {
        at.joints[i].v == 0.0
            && match at.modes[i].link {
                Slip::Free => false,
                Slip::Stuck => self.margins_of(i, at).0[Change::Link as usize] < 0.0,
                slips => slips.sign() * rate[i].v < 0.0,
            }
    }
}

#[inline(always)]
fn dot(row: &[f64], column: &[f64]) -> f64 {
    row.iter().zip(column).map(|(a, b)| a * b).sum()
}
