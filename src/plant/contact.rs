//! What stops a link: obstacles in its way, and the end stops of its joint.
//!
//! ```text
//!   f = max(0, k p + c ṗ),   p = −d(q),   ṗ = −(∂d/∂q) q̇          f
//!   load += (∂d/∂q)ᵀ f                                              |    /
//!                                                                   |___/____ p
//! ```
//! A barrier acts like a tooth flank: compliant, damped, and it never pulls. The distance `d` [m, rad] of an end stop is
//! `upper − q` or `q − lower`; that of a link and an obstacle comes from the engine, computed at every stage of every step while
//! they are close, so that the spring's energy `k p²/2` depends on the state alone. One point per pair acts, the deepest: where a face
//! lies flat on a face, the force acts at the deepest corner only.
//! Where axes are coupled, `q` denotes the positions of the axes; an end stop `side (q_j − place)` has the gradient `−side ∂q_j/∂θ`.
//! Left out: friction along the surface, and links that meet links of their own arm.
//! Reference: K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact,
//! J. Appl. Mech. 42 (1975), the linear (Kelvin-Voigt) case, without its pull at the end.

use super::joint::Phase;
use super::mobility::Response;
use super::rigid_body::RigidBody;
use crate::robot::{Coupling, Robot};

/// [m/s or rad/s] Bound of the speed at which a link approaches a barrier: this plus twice the speed of the fastest joint.
const FASTEST_APPROACH: f64 = 20.0;

/// [m/s or rad/s] Bound of the speed that an approaching link gains before the next look, a millisecond later: this plus its own speed.
const GAIN: f64 = 5.0;

/// [m] Greater distances are not computed; they count as this one.
const HORIZON: f64 = 0.5;

/// What stands in the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    /// An end stop of a joint: its index, the side (+1 upper, −1 lower) and where it stands [rad or m].
    EndStop(usize, f64, f64),
    /// A link and an obstacle: index of the pair in the engine's list, of the link's body, of the obstacle.
    Pair(usize, usize, usize),
}

/// A link that is pressed against something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Index of its body, and of the joint that moves it.
    pub body: usize,
    /// Index of the obstacle; `None`: an end stop of the joint.
    pub obstacle: Option<usize>,
    /// `f` [N], of an end stop [N·m or N], ≥ 0.
    pub force: f64,
}

/// A barrier, with the depth and speed of its link at the last measurement.
#[derive(Debug, Clone)]
pub struct Barrier {
    /// What stands in the way.
    pub cause: Cause,
    /// `k` [N/m, N·m/rad], > 0.
    stiffness: f64,
    /// `c` [N·s/m, N·m·s/rad], ≥ 0.
    damping: f64,
    /// `p` [m, rad].
    depth: f64,
    /// `ṗ` [m/s, rad/s].
    rate: f64,
    /// `∂d/∂q`, one per joint.
    gradient: Vec<f64>,
    /// [s] Before this time it cannot be touched, given the distance that was measured.
    clear_until: f64,
}

impl Barrier {
    /// A barrier for a machine.
    pub fn new(cause: Cause, stiffness: f64, damping: f64, robot: &Robot) -> Self {
        let gradient = match cause {
            Cause::EndStop(joint, side, _) => robot.joint_per_axis(joint).iter().map(|share| -side * share).collect(),
            Cause::Pair(..) => vec![0.0; robot.dof()],
        };
        Self {
            cause,
            stiffness,
            damping,
            depth: f64::NEG_INFINITY,
            rate: 0.0,
            gradient,
            clear_until: f64::NEG_INFINITY,
        }
    }

    /// Measures how far the link at `q` is from it.
    fn measure(&mut self, links: &mut dyn RigidBody, q: &[f64]) {
        match self.cause {
            // The gradient of an end stop is constant.
            Cause::EndStop(_, side, place) => {
                self.depth = -self.gradient.iter().zip(q).map(|(slope, q)| slope * q).sum::<f64>() - side * place;
            }
            Cause::Pair(pair, ..) => match links.distance(pair, q, HORIZON, &mut self.gradient) {
                Some(distance) => self.depth = -distance,
                // No answer means far away. For a pair that was just pressed together it means that the computation failed.
                None if self.depth > 0.0 => {}
                None => self.depth = f64::NEG_INFINITY,
            },
        }
    }

    fn approach(&mut self, y: &[Phase]) {
        self.rate = -self.gradient.iter().zip(y).map(|(slope, phase)| slope * phase.v).sum::<f64>();
    }

    /// Touching needs both: a surface that is pressed in, and a force that pushes. Negative where nothing touches.
    fn pressed(&self) -> f64 {
        self.depth.min(self.depth + self.rate * self.damping / self.stiffness)
    }

    /// `f` while it touches.
    fn force(&self) -> f64 {
        self.stiffness * self.depth + self.damping * self.rate
    }

    /// `k p²/2` [J].
    fn energy(&self) -> f64 {
        0.5 * self.stiffness * self.depth * self.depth
    }
}

/// All barriers of a machine, and their loads on its links at the state that was measured last.
#[derive(Debug, Clone)]
pub struct Barriers {
    all: Vec<Barrier>,
    /// Those that can be touched before the next look.
    near: Vec<usize>,
    /// Load on the links [N·m or N], one per joint.
    pub load: Vec<f64>,
    /// [W] that dampers turn into heat.
    pub heat: f64,
    q: Vec<f64>,
    /// [1] Most that a joint moves per motion of the fastest axis.
    spread: f64,
}

impl Barriers {
    /// The barriers of a machine.
    pub fn new(all: Vec<Barrier>, robot: &Robot) -> Self {
        let near = Vec::with_capacity(all.len());
        let joints = robot.dof();
        let spread = robot.coupling.as_ref().map_or(1.0, Coupling::spread);
        Self { all, near, load: vec![0.0; joints], heat: 0.0, q: vec![0.0; joints], spread }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// Whether none can be touched before the next look.
    #[inline]
    pub fn are_far(&self) -> bool {
        self.near.is_empty()
    }

    /// Those that can be touched before the next look.
    pub fn near(&self) -> impl Iterator<Item = (usize, &Barrier)> {
        self.near.iter().map(|&k| (k, &self.all[k]))
    }

    /// Determines which of them can be touched from a state at `now` until a later time [s]; the others are ignored until then.
    pub fn look(&mut self, links: &mut dyn RigidBody, y: &[Phase], touching: &[bool], [now, until]: [f64; 2]) {
        self.near.clear();
        self.load.fill(0.0);
        self.heat = 0.0;
        if self.all.is_empty() {
            return;
        }
        let fastest = self.spread * y.iter().fold(0.0, |fastest: f64, phase| fastest.max(phase.v.abs()));
        self.take(y);
        for (k, barrier) in self.all.iter_mut().enumerate() {
            if touching[k] || barrier.clear_until < until {
                barrier.measure(links, &self.q);
                barrier.approach(y);
                let distance = HORIZON.min(-barrier.depth);
                barrier.clear_until = now + distance / (FASTEST_APPROACH + 2.0 * fastest);
                if touching[k] || distance <= (GAIN + 2.0 * barrier.rate.max(0.0)) * (until - now) {
                    self.near.push(k);
                }
            }
        }
    }

    /// Measures those that are near, and computes the loads of those that touch.
    pub fn measure(&mut self, links: &mut dyn RigidBody, y: &[Phase], touching: &[bool]) {
        self.load.fill(0.0);
        self.heat = 0.0;
        // Where nothing has moved, distances are unchanged.
        let moved = self.take(y);
        for &k in &self.near {
            let barrier = &mut self.all[k];
            if moved {
                barrier.measure(links, &self.q);
            }
            barrier.approach(y);
            if touching[k] {
                let force = barrier.force();
                self.load.iter_mut().zip(&barrier.gradient).for_each(|(load, slope)| *load += slope * force);
                self.heat += barrier.damping * barrier.rate * barrier.rate;
            }
        }
    }

    /// Stores the positions of the links; returns whether they have changed.
    fn take(&mut self, y: &[Phase]) -> bool {
        let moved = self.q.iter().zip(y).any(|(q, phase)| *q != phase.q);
        self.q.iter_mut().zip(y).for_each(|(q, phase)| *q = phase.q);
        moved
    }

    /// The near ones, each with its distance from the next change (touched or left); negative beyond it.
    pub fn margins<'a>(&'a self, touching: &'a [bool]) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.near.iter().map(|&k| (k, self.margin(k, touching)))
    }

    /// Distance from the next change (touched or left); negative beyond it.
    pub fn margin(&self, k: usize, touching: &[bool]) -> f64 {
        let pressed = self.all[k].pressed();
        if touching[k] { pressed } else { -pressed }
    }

    /// Touches or leaves; returns the heat [J]: compression that remains when a link leaves relaxes in the barrier's own damper.
    pub fn change(&self, k: usize, touching: &mut [bool]) -> f64 {
        touching[k] = !touching[k];
        if touching[k] { -self.all[k].energy() } else { self.all[k].energy() }
    }

    /// Determines from a state alone what touches.
    pub fn start(&mut self, links: &mut dyn RigidBody, y: &[Phase], touching: &mut [bool]) {
        touching.fill(false);
        for barrier in &mut self.all {
            (barrier.clear_until, barrier.depth) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        }
        self.look(links, y, touching, [0.0, 0.0]);
        for &k in &self.near {
            touching[k] = self.all[k].pressed() > 0.0;
        }
    }

    /// [J] Elastic energy of the barriers that are touched.
    pub fn energy(&self, touching: &[bool]) -> f64 {
        self.near().filter(|(k, _)| touching[*k]).map(|(_, barrier)| barrier.energy()).sum()
    }

    /// Those that touch.
    pub fn touches<'a>(&'a self, touching: &'a [bool]) -> impl Iterator<Item = Touch> + 'a {
        self.near().filter(|(k, _)| touching[*k]).map(|(_, barrier)| {
            let (body, obstacle) = match barrier.cause {
                Cause::EndStop(joint, ..) => (joint, None),
                Cause::Pair(_, body, obstacle) => (body, Some(obstacle)),
            };
            Touch { body, obstacle, force: barrier.force() }
        })
    }

    /// [1/s] A bound of the fastest motion of links against the near barriers: `√(Σ k g W gᵀ) + Σ c g W gᵀ`, `g = ∂d/∂q`.
    pub fn fastest(&self, response: &Response) -> f64 {
        let (mut squares, mut rate) = (0.0, 0.0);
        for (_, Barrier { gradient, stiffness, damping, .. }) in self.near() {
            let along = |i: usize| gradient.iter().zip(response.row(i)).map(|(g, w)| g * w).sum::<f64>();
            let mobility: f64 = gradient.iter().enumerate().map(|(i, slope)| slope * along(i)).sum();
            squares += stiffness * mobility;
            rate += damping * mobility;
        }
        squares.sqrt() + rate
    }
}
