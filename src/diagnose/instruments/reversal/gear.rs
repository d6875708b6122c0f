//! Simulation of one joint's gear along the measured motion of its rotor: the torque that the motor needs beyond that for a link that
//! follows.
//!
//! The rotor's motion `θ(t)` is given. The link follows a flank or floats between the flanks; flanks are hard and do not bounce:
//!
//! ```text
//!   on flank ±   q = θ + ε ∓ g        T = I q̈ + B + F_l(q̇)        until T changes its sign
//!   in the gap   I q̈ = −B − F_l(q̇)    T = 0                        until a flank is reached: then the impulse I Δq̇
//!   D = λ T + F_r − (L + F(θ̇))        L = I θ̈ + B: what the link needs if it follows;  F = F_r + F_l
//! ```
//! `D` is the torque that a rigid fit lacks. It is zero while the link follows a perfect gear with the friction of the law.
//! [`Mesh`] gives the position of the flanks, [`Memory`] the state of friction, [`JointAction`] its level: effects install them in a simulation.
//! Sign: a positive `D` is torque that the motor must add.
//! Left out: wind-up of the gear (30 µrad per 0.1 N·m at 3000 N·m/rad), and the effect of a floating link on other joints.
//! Reference: M. Nordin, P.-O. Gutman (2002), Controlling mechanical systems with backlash, a survey, the hard-contact model.

use super::path::{Path, Span};
use crate::effects::{Action, GearAction, JointAction, JointState};
use crate::gearhead::{Exponential, Flank, Memory, Mesh, slowed};

/// Known parameters of a joint's gear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gear {
    /// `b` [rad or m] Total gap.
    pub gap: f64,
    /// `s` [1] Part of the friction that acts on the link.
    pub share: f64,
}

/// Changes of a joint's gear by effects.
#[derive(Default)]
pub struct Altered<'a> {
    gears: Vec<&'a dyn GearAction>,
    memory: Option<Memory>,
    joints: Vec<&'a dyn JointAction>,
}

impl<'a> Altered<'a> {
    /// The actions on the flanks of a joint, on the memory of its friction or on its level.
    pub fn by(actions: &'a [Action], joint: usize) -> Self {
        let mut altered = Self::default();
        for action in actions {
            match action {
                Action::Gear(of, gear) if *of == joint => altered.gears.push(gear.as_ref()),
                Action::Friction(of, memory) if *of == joint => altered.memory = Some(*memory),
                Action::Joint(of, action) if *of == joint => altered.joints.push(action.as_ref()),
                _ => {}
            }
        }
        altered
    }
}

/// The link at an instant: its flank (0: between the flanks), position and velocity.
#[derive(Debug, Clone, Copy)]
struct Link {
    side: f64,
    q: f64,
    w: f64,
}

struct Run<'a> {
    path: &'a Path,
    gear: &'a Gear,
    altered: &'a Altered<'a>,
    /// `F`, the same in both directions.
    law: Exponential,
    /// Increase of dry friction at each instant, at the speed of the rotor.
    grown: Vec<f64>,
    lack: Vec<f64>,
}

/// `D` on the grid of the path.
pub fn lack(path: &Path, gear: &Gear, altered: &Altered) -> Vec<f64> {
    let law = path.friction.law();
    let mut run = Run { path, gear, altered, law, grown: Vec::new(), lack: vec![0.0; path.theta.len()] };
    run.remember();
    run.act();
    for span in &path.spans {
        run.span(*span);
    }
    run.lack
}

impl Run<'_> {
    /// Computes friction with memory on the rotor, and the increase of dry friction.
    fn remember(&mut self) {
        let Some(memory) = self.altered.memory else { return };
        let (h, rotor) = (self.path.step, 1.0 - self.gear.share);
        if matches!(memory, Memory::Rest { .. }) {
            self.grown = vec![0.0; self.path.theta.len()];
        }
        for span in &self.path.spans {
            let mut state = 0.0;
            for k in span.start..span.end {
                let v = self.path.v[k];
                let dry = (rotor * self.path.dry[k]).max(1e-12);
                let (before, change) = (state, memory.change(state, v, dry, h));
                state += change;
                match memory {
                    Memory::Bristles { .. } => {
                        let force = memory.force(before + 0.5 * change, change, h);
                        self.lack[k] += force - rotor * self.path.dry[k] * sign(v);
                    }
                    Memory::Rest { .. } => {
                        self.grown[k] = memory.level(before + 0.5 * change);
                        self.lack[k] += rotor * self.grown[k] * sign(v);
                    }
                }
            }
        }
    }

    /// Computes what actions add to the level of dry friction.
    fn act(&mut self) {
        if self.altered.joints.is_empty() {
            return;
        }
        let rotor = 1.0 - self.gear.share;
        self.grown.resize(self.path.theta.len(), 0.0);
        for span in &self.path.spans {
            for k in span.start..span.end {
                let (v, level) = (self.path.v[k], self.path.dry[k] + self.grown[k]);
                let added = self.acted(k, v, level) - level;
                self.grown[k] += added;
                self.lack[k] += rotor * added * sign(v);
            }
        }
    }

    /// A level of dry friction at a velocity, after the actions.
    fn acted(&self, k: usize, velocity: f64, level: f64) -> f64 {
        let (motor_velocity, link_velocity) = (velocity, velocity);
        let state = JointState {
            motor_position: self.path.theta[k],
            motor_velocity,
            link_position: self.path.theta[k],
            link_velocity,
            ..JointState::default()
        };
        self.altered.joints.iter().fold(level, |level, action| action.dry_friction(&state, level))
    }

    fn grown(&self, k: usize) -> f64 {
        self.grown.get(k).copied().unwrap_or(0.0)
    }

    /// Friction of the link [N·m or N], at least zero.
    fn friction(&self, k: usize, w: f64) -> f64 {
        // On a flank of a perfect gear the link moves like the rotor, whose friction is known.
        let dry = if w == self.path.v[k] {
            self.path.dry[k] + self.grown(k)
        } else if self.altered.joints.is_empty() {
            self.law.dry(w.abs()) + self.grown(k)
        } else {
            self.acted(k, w, self.law.dry(w.abs()))
        };
        self.gear.share * (dry + self.law.viscous * w.abs())
    }

    /// Torque of the motor if the link follows the rotor [N·m or N], without the rotor's friction.
    fn usual(&self, k: usize) -> f64 {
        let v = self.path.v[k];
        self.path.load[k] + self.gear.share * sign(v) * (self.path.dry[k] + self.law.viscous * v.abs())
    }

    /// What the link's friction has more than usual, if it follows the rotor [N·m or N].
    fn more_friction(&self, k: usize) -> f64 {
        self.gear.share * sign(self.path.v[k]) * self.grown(k)
    }

    /// Torque that a link on a flank of a perfect gear needs, which moves like the rotor [N·m or N].
    fn carried(&self, k: usize) -> f64 {
        self.usual(k) + self.more_friction(k)
    }

    fn mesh(&self, span: Span, k: usize) -> Mesh {
        let mut mesh = Mesh::with_gap(self.gear.gap);
        self.altered.gears.iter().for_each(|gear| gear.alter(span.time(k), self.path.theta[k], &mut mesh));
        mesh
    }

    /// Position and velocity of a flank.
    fn flank(&self, k: usize, mesh: &Mesh, side: f64) -> (f64, f64) {
        let Flank { p, p_dot, .. } = mesh.flank([self.path.theta[k], self.path.v[k]], [0.0; 2], side);
        (p, p_dot)
    }

    /// Torque that a link on a flank needs at an instant, while the flank gains `gain` [rad/s or m/s] of speed relative to the rotor in a step.
    fn on_flank(&self, k: usize, w: f64, gain: f64) -> f64 {
        let w = if w == 0.0 { 0.0 } else { sign(w) * self.friction(k, w) };
        self.path.load[k] + self.path.inertia[k] * gain / self.path.step + w
    }

    fn span(&mut self, span: Span) {
        let v = self.path.v[span.start];
        let side = sign(self.on_flank(span.start, v, 0.0));
        let mut mesh = self.mesh(span, span.start);
        let (q, w) = self.flank(span.start, &mesh, side);
        let mut link = Link { side, q, w };
        let perfect = self.altered.gears.is_empty();
        for k in span.start..span.end.saturating_sub(1) {
            if perfect && link.side != 0.0 && link.side * self.carried(k + 1) >= 0.0 {
                self.lack[k] += self.more_friction(k);
                continue;
            }
            let next = if perfect { mesh } else { self.mesh(span, k + 1) };
            self.step(&mut link, k, &mesh, &next);
            mesh = next;
        }
    }

    /// One step from an instant to the next.
    fn step(&mut self, link: &mut Link, k: usize, mesh: &Mesh, next: &Mesh) {
        let mut begin = 0.0;
        if link.side != 0.0 {
            let side = link.side;
            let ((q0, w0), (q1, w1)) = (self.flank(k, mesh, side), self.flank(k + 1, next, side));
            let gain = (w1 - w0) - (self.path.v[k + 1] - self.path.v[k]);
            let to = self.on_flank(k + 1, w1, gain);
            if side * to >= 0.0 {
                (link.q, link.w) = (q1, w1);
                self.lack[k] += self.follows(k, w0, mesh.lever(side), gain);
                return;
            }
            let from = self.on_flank(k, w0, gain);
            // The link leaves where the rotor reverses, or where the torque becomes zero.
            begin = if w0 * w1 < 0.0 && side * from > 0.0 { w0 / (w0 - w1) } else { part(side * from, side * to) };
            *link = Link { side: 0.0, q: q0 + begin * (q1 - q0), w: w0 + begin * (w1 - w0) };
            self.lack[k] += begin * self.follows(k, w0, mesh.lever(side), gain);
        }
        self.float(link, k, begin, mesh, next);
    }

    /// Torque that the motor lacks while the link is on a flank.
    fn follows(&self, k: usize, w: f64, lever: f64, gain: f64) -> f64 {
        if self.altered.gears.is_empty() {
            return self.more_friction(k);
        }
        lever * self.on_flank(k, w, gain) - self.usual(k)
    }

    /// The rest of a step, starting at its part `begin`, with the link between the flanks.
    fn float(&mut self, link: &mut Link, k: usize, begin: f64, mesh: &Mesh, next: &Mesh) {
        let path = self.path;
        let (h, inertia) = ((1.0 - begin) * path.step, path.inertia[k]);
        let held = path.load[k] - path.inertial[k];
        let w = slowed(link.w - h * held / inertia, [h * self.friction(k, link.w) / inertia; 2]);
        let q = link.q + 0.5 * h * (link.w + w);
        let mut end = 1.0;
        for side in [1.0, -1.0] {
            let ((q0, w0), (q1, w1)) = (self.flank(k, mesh, side), self.flank(k + 1, next, side));
            let (before, after) = (side * (q0 + begin * (q1 - q0) - link.q), side * (q1 - q));
            let touch = part(before, after);
            let reached = begin + touch * (1.0 - begin);
            let closing = w0 + reached * (w1 - w0) - (link.w + touch * (w - link.w));
            // Encoder edges and smooth velocities differ slightly: a flank that moves away is not touched.
            if after > 0.0 && side * closing > 0.0 {
                end = reached;
                self.strike(k, end, inertia * closing);
                *link = Link { side, q: q1, w: w1 };
                break;
            }
        }
        if end == 1.0 && link.side == 0.0 {
            (link.q, link.w) = (q, w);
        }
        self.lack[k] -= (end - begin) * self.usual(k);
    }

    /// An impulse [N·m·s or N·s] at a part of a step: divided between two instants, so that it moves continuously with its time.
    fn strike(&mut self, k: usize, at: f64, impulse: f64) {
        let (other, near) = if at < 0.5 { (k.saturating_sub(1), 0.5 + at) } else { (k + 1, 1.5 - at) };
        self.lack[k] += near * impulse / self.path.step;
        if let Some(lack) = self.lack.get_mut(other) {
            *lack += (1.0 - near) * impulse / self.path.step;
        }
    }
}

fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// Zero crossing of a straight line from `a` to `b`, 0 to 1.
fn part(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a / (a - b)).clamp(0.0, 1.0) }
}
