//! The machine carried from one sample of a recording to the next, under the currents that were measured: for a filter, which corrects
//! the state at every sample and needs to know how errors of it grow.
//!
//! ```text
//!   y(t + T) = f(y(t), i, t)        y = (θ, θ̇, q, q̇) of all joints, laws as in `joint` and `coupled`; i constant over T
//! ```
//! Against [`Plant`] it saves what a filter does not need: the power stage (the measured current flows), energies, and events located to
//! rounding. Steps have a fixed length, by Runge-Kutta 4. The links' response is that of the middle of the interval. A flank that touches is
//! decided at every stage; where a velocity passes zero, the step ends there, and friction decides anew what rests.
//! The derivative of `f` is carried beside it ([`Tangent`]).
//! Left out: slopes of end stops, and of what acts on joints that several axes move, in the derivative.

use super::build::moving_mode;
use super::joint::{JointLaws, Phase};
use super::machine::{Machine, Source};
use super::mode::Mode;
use super::sensors::Sensors;
use super::state::{Situation, State};
use super::tangent::{Slopes, Tangent};
use super::{Engine, FASTEST_STEPS, Options, Plant};
use crate::drive::Winding;
use crate::effects::Catalogue;
use crate::error::Result;
use crate::gearhead::Slip;
use crate::robot::{Model, Robot};

/// [s] Longest step: a velocity within it follows a parabola, and the flank that is met is met to `k v h²/12`, 6e-6 N·m·s at 0.1 rad/s of a stiff gear.
const LONGEST: f64 = 5e-4;
/// Most velocities that pass zero in one interval; then the others are brought to rest at the end of their step.
const MOST_TURNS: usize = 20;
/// [rad or m], [rad/s or m/s] Changes of the state by which slopes are taken: small against the bend of every law, large against rounding.
const CHANGES: [f64; 4] = [1e-8, 1e-7, 1e-8, 1e-7];

/// A velocity that has just passed zero: joint, whether it is the link's, and its acceleration [rad/s² or m/s²] before.
type Turn = (usize, bool, f64);

/// A machine at the state that a filter believes in.
pub struct Carrier {
    machine: Machine,
    sensors: Vec<Sensors>,
    robot: Robot,
    /// [1/s] Steps that the gears need.
    rate: f64,
    state: State,
    /// [rad/s² or m/s²] of the links at the last step.
    acceleration: Vec<f64>,
    rates: [Vec<Phase>; 4],
    stage: Vec<Phase>,
    end: Vec<Phase>,
    /// Modes at a stage: the flanks that touch there.
    modes: Vec<Mode>,
    turns: Vec<Turn>,
    slopes: Slopes,
}

impl Carrier {
    /// The machine of a model with its effects, at rest at zero. Its sensors are exact but for what effects do to them.
    ///
    /// # Errors
    /// As [`Plant::new`].
    pub fn new(model: &Model, catalogue: &Catalogue) -> Result<Self> {
        let options = Options {
            engine: Engine::Reduced,
            ideal_sensors: true,
            catalogue: catalogue.clone(),
            ..Options::default()
        };
        let Plant { integrator, sensors, robot, rate, state, .. } = Plant::new(model, &options)?;
        let mut machine = integrator.machine;
        for law in &mut machine.coupled.laws {
            law.power.winding = Winding::Ideal;
            (law.power.voltage_limit, law.power.current_limit) = (f64::INFINITY, f64::INFINITY);
        }
        let n = sensors.len();
        let phases = || vec![Phase::default(); n];
        Ok(Self {
            machine,
            sensors,
            robot,
            rate: rate.max(1.0 / LONGEST),
            modes: state.modes.clone(),
            state,
            acceleration: vec![0.0; n],
            rates: [phases(), phases(), phases(), phases()],
            stage: phases(),
            end: phases(),
            turns: Vec::new(),
            slopes: Slopes::new(n),
        })
    }

    /// Puts the machine into this motion at a time [s] since the start of the session.
    pub fn start(&mut self, time: f64, joints: &[Phase]) {
        self.state.time = time;
        self.state.joints.copy_from_slice(joints);
        self.acceleration.fill(0.0);
        let Machine { coupled, links, .. } = &mut self.machine;
        coupled.barriers.start(links.engine.as_mut(), joints, &mut self.state.touching);
    }

    /// Its motion, one per joint.
    pub fn joints(&self) -> &[Phase] {
        &self.state.joints
    }

    /// [s] since the start of the session.
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Changes the motion of one joint; the memory of its friction stays.
    pub fn correct(&mut self, joint: usize, [theta, omega, q, v]: [f64; 4]) {
        let y = &mut self.state.joints[joint];
        *y = Phase { theta, omega, q, v, ..*y };
    }

    /// Takes over the time and the motion of another machine, but not the memory of its friction.
    pub fn follow(&mut self, other: &Self) {
        self.state.time = other.state.time;
        for (own, y) in self.state.joints.iter_mut().zip(&other.state.joints) {
            *own = Phase { memory: own.memory, ..*y };
        }
        self.state.touching.copy_from_slice(&other.state.touching);
        self.acceleration.copy_from_slice(&other.acceleration);
    }

    /// Becomes the same as another machine of the same model, which is prepared for an interval; a small change of the state changes nothing in that.
    pub fn mirror(&mut self, other: &Self) {
        self.follow(other);
        self.state.joints.copy_from_slice(&other.state.joints);
        self.machine.response.copy_from(&other.machine.response);
        self.machine.coupled.barriers.clone_from(&other.machine.coupled.barriers);
    }

    /// [kg·m² or kg] Inertia of a joint's rotor at the joint.
    pub fn rotor_inertia(&self, joint: usize) -> f64 {
        self.machine.coupled.laws[joint].rotor_inertia
    }

    /// `b` [rad or m] Gap of a joint's gear, without what effects do to it.
    pub fn backlash(&self, joint: usize) -> f64 {
        self.machine.coupled.laws[joint].gearhead.dead_zone.backlash
    }

    /// [rad or m] Distance of a joint's gear from where its nearer flank is touched or left; infinite for a gear without a gap.
    pub fn slack(&self, joint: usize) -> f64 {
        let law = &self.machine.coupled.laws[joint];
        let (time, y) = (self.state.time, &self.state.joints[joint]);
        if has_gap(law) { law.overlap(time, y, 1.0).max(law.overlap(time, y, -1.0)) } else { f64::INFINITY }
    }

    /// [N·m/A] Torque of a joint's motor per ampere, at the joint.
    pub fn torque_per_ampere(&self, joint: usize) -> f64 {
        self.machine.coupled.laws[joint].power.torque_per_ampere
    }

    /// [rad or m] What a joint's encoder reads beside the rotor's position. Every call is a sampling instant.
    pub fn misread(&mut self, joint: usize) -> f64 {
        if !self.sensors[joint].is_altered() {
            return 0.0;
        }
        let State { time, joints, .. } = &self.state;
        let q = self.robot.joint_of_axes(joint, |axis| joints[axis].q);
        self.sensors[joint].read(*time, &joints[joint], q, 0.0).position - joints[joint].theta
    }

    /// What the current sensor of a joint reads [A] while these currents flow at these times [s]; `None`: what flows. Every call goes on from
    /// the last.
    pub fn read_currents(&mut self, joint: usize, time: &[f64], currents: &[f64]) -> Option<Vec<f64>> {
        let sensors = &mut self.sensors[joint];
        let y = Phase::default();
        let altered = sensors.is_altered();
        let read = |(time, current): (&f64, &f64)| sensors.read(*time, &y, 0.0, *current).current;
        altered.then(|| time.iter().zip(currents).map(read).collect())
    }

    /// Finds the links' response for the interval to a time [s], and what may be touched in it.
    pub fn prepare(&mut self, until: f64) {
        self.respond(until);
        self.machine.look(&self.state, until);
    }

    /// Carries the motion to the time [s] for which it is prepared, while these currents [A] flow, one per joint, and with it its derivative.
    pub fn carry(&mut self, currents: &[f64], until: f64, mut tangent: Option<&mut Tangent>) {
        let haste = self.machine.haste(&self.state, until);
        let start = self.state.time;
        let steps = ((until - start) * self.rate.max(haste).min(FASTEST_STEPS) - 1e-6).ceil().max(1.0);
        self.turns.clear();
        let mut turned = 0;
        for step in 1..=steps as usize {
            let target = if step as f64 == steps { until } else { start + (until - start) * step as f64 / steps };
            while self.state.time < target {
                let turns = self.step(currents, target, turned < MOST_TURNS, tangent.as_deref_mut());
                turned += turns;
            }
            self.touch();
        }
        self.acceleration.iter_mut().zip(&self.rates[3]).for_each(|(a, rate)| *a = rate.v);
    }

    /// Finds the links' response in the middle of the interval.
    fn respond(&mut self, until: f64) {
        let half = 0.5 * (until - self.state.time);
        for ((stage, y), a) in self.stage.iter_mut().zip(&self.state.joints).zip(&self.acceleration) {
            *stage = Phase { q: y.q + half * y.v, v: y.v + half * a, ..*y };
        }
        self.machine.respond(Source::Engine, self.state.time + half, &self.stage, &self.state.touching);
    }

    /// A step towards a time; returns the number of velocities that have passed zero at its end.
    fn step(&mut self, currents: &[f64], target: f64, turns: bool, tangent: Option<&mut Tangent>) -> usize {
        let h = target - self.state.time;
        self.settle(currents);
        if let Some(tangent) = tangent {
            self.slopes.take(&self.machine, &self.state, currents);
            self.turn_rows(tangent);
            self.advance(currents, h);
            let (share, turned) = self.cut(h, turns);
            tangent.advance(share * h, &self.slopes);
            self.accept(share, h, target);
            return turned;
        }
        self.advance(currents, h);
        let (share, turned) = self.cut(h, turns);
        self.accept(share, h, target);
        turned
    }

    /// Decides the modes at the start of a step, and takes the derivative there.
    fn settle(&mut self, currents: &[f64]) {
        let Self { machine: Machine { coupled, response, .. }, state, rates, .. } = self;
        for ((mode, law), y) in state.modes.iter_mut().zip(&coupled.laws).zip(&state.joints) {
            *mode = moving_mode(law, state.time, y);
        }
        coupled.settle(state, currents, response, &mut rates[0]);
    }

    /// Stages of Runge-Kutta 4, and the state at the end.
    fn advance(&mut self, currents: &[f64], h: f64) {
        let Self { machine, state, rates, stage, end, modes, .. } = self;
        modes.copy_from_slice(&state.modes);
        for (k, share) in [0.5, 0.5, 1.0].into_iter().enumerate() {
            let time = state.time + share * h;
            for (i, law) in machine.coupled.laws.iter().enumerate() {
                stage[i] = state.joints[i].step(share * h, &rates[k][i]);
                if has_gap(law) {
                    modes[i].contact = law.contact(time, &stage[i]);
                }
            }
            machine.measure(stage, &state.touching);
            let at = Situation { time, joints: stage, modes, commands: currents };
            machine.coupled.derivative(&at, &machine.response, &mut rates[k + 1]);
        }
        let [k1, k2, k3, k4] = &*rates;
        for (i, end) in end.iter_mut().enumerate() {
            let y = &state.joints[i];
            let sum = |f: fn(&Phase) -> f64| h / 6.0 * (f(&k1[i]) + 2.0 * (f(&k2[i]) + f(&k3[i])) + f(&k4[i]));
            *end = Phase {
                theta: y.theta + sum(|p| p.theta),
                omega: y.omega + sum(|p| p.omega),
                q: y.q + sum(|p| p.q),
                v: y.v + sum(|p| p.v),
                memory: y.memory + sum(|p| p.memory),
                ..*y
            };
        }
    }

    /// The share of the step before the first velocity that passes zero, and how many do so there; without `turns` all of the step.
    fn cut(&mut self, h: f64, turns: bool) -> (f64, usize) {
        self.turns.clear();
        let mut first = 1.0;
        for (i, (mode, (y, end))) in self.state.modes.iter().zip(self.state.joints.iter().zip(&self.end)).enumerate() {
            for (link, slip, from, to) in [(false, mode.rotor, y.omega, end.omega), (true, mode.link, y.v, end.v)] {
                if slip.sign() * to >= 0.0 {
                    continue;
                }
                // A velocity that begins at zero against its slip never left it.
                let share = if turns && from != 0.0 { from / (from - to) } else { 1.0 };
                if share < first {
                    self.turns.clear();
                    first = share;
                }
                if share == first {
                    self.turns.push((i, link, (to - from) / h));
                }
            }
        }
        (first, self.turns.len())
    }

    /// Moves the state to a share of the step; velocities that pass zero there are zero.
    fn accept(&mut self, share: f64, h: f64, target: f64) {
        let State { time, joints, .. } = &mut self.state;
        *time = if share == 1.0 { target } else { *time + share * h };
        for (y, end) in joints.iter_mut().zip(&self.end) {
            *y = if share == 1.0 { *end } else { between(y, end, h, share) };
        }
        for (i, link, _) in &self.turns {
            *(if *link { &mut joints[*i].v } else { &mut joints[*i].omega }) = 0.0;
        }
    }

    /// After a turn an error of the velocity is `a⁺/a⁻` times what it was before, and none where the side rests.
    fn turn_rows(&mut self, tangent: &mut Tangent) {
        for (i, link, before) in &self.turns {
            let (slip, after) = match link {
                true => (self.state.modes[*i].link, self.rates[0][*i].v),
                false => (self.state.modes[*i].rotor, self.rates[0][*i].omega),
            };
            let kept = if slip == Slip::Stuck || *before == 0.0 { 0.0 } else { (after / before).clamp(0.0, 1.0) };
            tangent.scale_velocity(*i, *link, kept);
        }
        for (i, mode) in self.state.modes.iter().enumerate() {
            for (link, slip) in [(false, mode.rotor), (true, mode.link)] {
                if slip == Slip::Stuck {
                    tangent.scale_velocity(i, link, 0.0);
                }
            }
        }
    }

    /// End stops that have been touched or left.
    fn touch(&mut self) {
        let Self { machine, state, .. } = self;
        if machine.coupled.barriers.are_far() {
            return;
        }
        machine.measure(&state.joints, &state.touching);
        let changed: Vec<usize> = machine
            .coupled
            .barriers
            .margins(&state.touching)
            .filter_map(|(barrier, margin)| (margin < 0.0).then_some(barrier))
            .collect();
        for barrier in changed {
            machine.coupled.barriers.change(barrier, &mut state.touching);
        }
    }
}

fn has_gap(law: &JointLaws) -> bool {
    law.gearhead.dead_zone.backlash != 0.0
}

/// A state at a share of a step, over which accelerations are constant.
fn between(from: &Phase, to: &Phase, h: f64, share: f64) -> Phase {
    let mix = |a: f64, b: f64| a + share * (b - a);
    let way = |x: f64, from: f64, to: f64| x + share * h * (from + 0.5 * share * (to - from));
    Phase {
        theta: way(from.theta, from.omega, to.omega),
        omega: mix(from.omega, to.omega),
        q: way(from.q, from.v, to.v),
        v: mix(from.v, to.v),
        memory: mix(from.memory, to.memory),
        ..*from
    }
}

/// Slopes of a joint's laws within its mode: `∂(θ̈, load)/∂(θ, θ̇, q, q̇)`.
pub(super) fn slopes_of(machine: &Machine, state: &State, joint: usize, current: f64) -> [[f64; 4]; 2] {
    let (law, y, mode) = (&machine.coupled.laws[joint], &state.joints[joint], &state.modes[joint]);
    let at = |y: &Phase| {
        let flow = law.flow(state.time, y, mode, current);
        [flow.rotor_acceleration, flow.link_load]
    };
    let here = at(y);
    let mut slopes = [[0.0; 4]; 2];
    for (k, change) in CHANGES.into_iter().enumerate() {
        let mut moved = *y;
        *[&mut moved.theta, &mut moved.omega, &mut moved.q, &mut moved.v][k] += change;
        let there = at(&moved);
        for (row, slope) in slopes.iter_mut().enumerate() {
            slope[k] = (there[row] - here[row]) / change;
        }
    }
    slopes
}
