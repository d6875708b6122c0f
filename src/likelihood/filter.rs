//! The filter: the machine carried along a recording, corrected by every reading, and the probability that it gave to each beforehand.
//!
//! ```text
//!   m ← f(m, i),   P ← F P Fᵀ + Σ σ_j² g_j g_jᵀ                   from a sample to the next
//!   ℓ_jk = ln p(reading of joint j at sample k | all before)       the score [nat]
//!   m ← m + K (m* − m_θ),  P ← P − K Kᵀ (s² − V*)                  for each joint in turn
//!   σ_j = 1.3 K_j σ_i √(w² + (1 − w)²)                             noise of the motor's torque, by the current sensor's
//!   d_j ← ρ d_j + …,   ρ = e^{−T/T_d},   √⟨d_j²⟩ = e^{λ_j} σ_j     torque that the model misses, T_d = 30 ms
//! ```
//! One Gaussian holds the rotor and the link of all joints. `f` and its derivative `F` are the simulated machine's own
//! ([`Carrier`](crate::plant::carried::Carrier)): predicted deviations are some hundredths of a count, over which its laws are linear. Where a flank may be
//! met, or a velocity pass zero, within these deviations, the Gaussian is carried by `points` instead. The link gets a part of the rotor's noise, for what a model of rigid links leaves out. The missed torque `d` is a
//! state like the others: where a model lacks something that no parameter explains, the filter follows it, at the price of a score that is lower by
//! the freedom that this takes. `λ` is far below zero where the model is exact.
//! *Shadows* are machines whose parameters differ a little. They start every interval at the same state; what they then do else is the derivative of
//! the prediction, which the filter's own gains carry on:
//!
//! ```text
//!   ∂m/∂p ← F ∂m/∂p + ∂f/∂p,      ∂m/∂p ← ∂m/∂p − K (1 − V*/s²) ∂m_θ/∂p
//!   ∂ℓ/∂p = (m* − m_θ)/s² ∂m_θ/∂p,      information += (1 − V*/s²)/s² (∂m_θ/∂p)²
//! ```
//! Left out: the derivative of `P`, and errors of the friction's memory, which each machine carries for itself.
//! Reference: S. Särkkä, L. Svensson (2023), Bayesian filtering and smoothing, chapters 7 (filter) and 16 (likelihood and sensitivity equations).

use nalgebra::{DMatrix, DVector};

use super::Settings;
use super::count::Said;
use super::covariance::Covariance;
use super::points::Points;
use super::recording::Recording;
use super::subject::Subject;
use crate::plant::carried::Carrier;
use crate::plant::joint::Phase;
use crate::plant::tangent::Tangent;

/// Samples over which the speed at the start is taken.
const START: usize = 20;
/// [1] A speed beyond so many times the fastest that was recorded has lost its track: a wrong model may run away from an encoder of very small counts, and what
/// moves with the speed, a ripple, then needs more and more steps.
const LOST: f64 = 10.0;
/// [1] Deviation of the link's place in its gap where nothing is known: so that cubature points of two joints lie within the gap.
const LINK_IN_GAP: f64 = 1.0 / 6.0;
/// [1] The same without a gap, in counts: a wind-up.
const LINK: f64 = 0.1;
/// [1] Deviations, or ways from the mean to a point, within which a law must not bend for the derivative to be used. At one way accelerations within the
/// interval carry points over bends: eight exact machines lost 19 of 10,400 nats, at two ways 4.
const BENDS: f64 = 2.0;
/// `T_d` [s] Memory of the torque that a model misses: friction and impacts change within some hundredths of a second.
const MISSED: f64 = 0.03;
/// [1] Noise of the torque over that of the current sensor: what the current does between two samples.
const WHITE: f64 = 1.3;
/// [s] Time over which an outlier moves a joint by a count, at most: the velocity that it may have missed.
const JOLT: f64 = 0.01;

/// A machine whose parameter `p` differs by a step.
pub(super) struct Shadow {
    /// The machine.
    pub subject: Subject,
    /// Its step, in the unit of the parameter.
    pub step: f64,
}

/// What a reading said, for the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scored {
    /// The reading.
    pub said: Said,
    /// [N·m or N] Torque that the motor would have needed beside the model's, by the correction of its velocity.
    pub missing: f64,
}

/// What a run along a recording gives.
pub(super) struct Outcome {
    /// Sum of `ℓ` after the burn-in [nat], one per joint.
    pub nats: Vec<f64>,
    /// Readings that were scored, one per joint.
    pub readings: Vec<usize>,
    /// `∂ℓ/∂p`.
    pub gradient: DVector<f64>,
    /// Its information.
    pub information: DMatrix<f64>,
    /// `[joint][sample]`, where it was asked for.
    pub scored: Vec<Vec<Scored>>,
}

/// A run along a recording.
pub(super) struct Run<'a> {
    recording: &'a Recording,
    settings: &'a Settings,
    reference: Subject,
    shadows: Vec<Shadow>,
    /// The reference's machine once more, for points.
    other: Subject,
    points: Points,
    bends: Bends,
    mean: Vec<f64>,
    covariance: Covariance,
    tangent: Tangent,
    /// [N·m or N] Standard deviations of the torques on rotor and link.
    noise: Vec<[f64; 2]>,
    /// `√⟨d²⟩` and `d` [N·m or N].
    spread: Vec<f64>,
    missed: Vec<f64>,
    /// [rad/s or m/s] Speeds beyond which the track is lost.
    limits: Vec<f64>,
    /// `∂m/∂p`, and `∂f/∂p` of the last interval.
    sensitivities: Vec<Vec<f64>>,
    differences: Vec<Vec<f64>>,
    before: Vec<f64>,
    /// What the shadows' encoders read beside the reference's, per unit of the parameter.
    misread: Vec<f64>,
    currents: Vec<f64>,
    outcome: Outcome,
}

impl<'a> Run<'a> {
    /// Of a reference, of which there are two, with its shadows; `lambda`: `λ` of each joint.
    pub fn new(
        recording: &'a Recording,
        settings: &'a Settings,
        [reference, other]: [Subject; 2],
        shadows: Vec<Shadow>,
        lambda: &[f64],
    ) -> Self {
        let n = recording.joints.len();
        let noise = (0..n).map(|joint| {
            let recorded = &recording.joints[joint];
            let w = recorded.weight;
            let current = recorded.noise * (w * w + (1.0 - w) * (1.0 - w)).sqrt();
            let torque = WHITE * reference.carrier.torque_per_ampere(joint).abs() * current;
            [torque, settings.link_noise * torque]
        });
        let parameters = shadows.len();
        let noise: Vec<[f64; 2]> = noise.collect();
        Self {
            spread: noise.iter().zip(lambda).map(|([torque, _], lambda)| lambda.exp() * torque).collect(),
            missed: vec![0.0; n],
            limits: recording.joints.iter().map(|joint| LOST * joint.fastest(&recording.time)).collect(),
            noise,
            other,
            points: Points::new(5 * n),
            bends: Bends { interval: 0.0, distances: vec![[0.0; 3]; n] },
            mean: vec![0.0; 5 * n],
            covariance: Covariance::diagonal(&vec![0.0; 5 * n]),
            tangent: Tangent::new(n),
            sensitivities: vec![vec![0.0; 5 * n]; parameters],
            differences: vec![vec![0.0; 5 * n]; parameters],
            before: vec![0.0; 5 * n],
            misread: vec![0.0; parameters],
            currents: vec![0.0; n],
            outcome: Outcome {
                nats: vec![0.0; n],
                readings: vec![0; n],
                gradient: DVector::zeros(parameters),
                information: DMatrix::zeros(parameters, parameters),
                scored: vec![Vec::new(); n],
            },
            recording,
            settings,
            reference,
            shadows,
        }
    }

    /// Goes through the recording; with `keep` it records what each reading said.
    pub fn go(mut self, keep: bool) -> Outcome {
        if self.recording.len() < 2 {
            return self.outcome;
        }
        self.start(0);
        let from: Vec<usize> =
            (0..self.noise.len()).map(|joint| self.recording.first_scored(joint, self.settings.burn_in)).collect();
        for k in 0..self.recording.len() {
            if k > 0 {
                self.carry(k);
            }
            for (joint, from) in from.iter().enumerate() {
                self.take(joint, k, k >= *from, keep);
            }
            if self.is_lost() && k + 1 < self.recording.len() {
                self.start(k);
            }
        }
        self.outcome
    }

    /// Whether a velocity has left what can be recorded.
    fn is_lost(&self) -> bool {
        self.reference.carrier.joints().iter().zip(&self.limits).enumerate().any(|(joint, (y, limit))| {
            let beyond = |velocity: f64, state: usize| {
                let within = velocity.abs().max(self.covariance.deviation(state)) <= *limit;
                !within
            };
            beyond(y.omega, 4 * joint + 1) || beyond(y.v, 4 * joint + 3)
        })
    }

    /// Rotor and link together at the reading of a sample, with the speed of the next samples; nothing is known of parameters that differ.
    fn start(&mut self, sample: usize) {
        let Recording { time, joints, .. } = self.recording;
        let last = (sample + START).min(time.len() - 1);
        let span = time[last] - time[sample];
        let phases = joints.iter().map(|joint| {
            let position = &joint.position;
            let (here, speed) = (position[sample], (position[last] - position[sample]) / span);
            Phase { theta: here, omega: speed, q: here, v: speed, ..Phase::default() }
        });
        let phases: Vec<Phase> = phases.collect();
        self.covariance = Covariance::diagonal(&vec![0.0; 5 * joints.len()]);
        for (joint, recorded) in joints.iter().enumerate() {
            let (state, step) = (4 * joint, recorded.step());
            self.covariance.widen(&[state, state + 2], step);
            self.covariance.widen(&[state + 1, state + 3], 2.0 * step / span);
            self.covariance.widen(&[state + 1], step / span);
            self.covariance.widen(&[4 * joints.len() + joint], self.spread[joint]);
            let gap = self.reference.carrier.backlash(joint);
            self.covariance.widen(&[state + 2], LINK_IN_GAP * gap + LINK * step);
        }
        self.missed.fill(0.0);
        self.sensitivities.iter_mut().for_each(|sensitivity| sensitivity.fill(0.0));
        self.reference.carrier.start(time[sample], &phases);
        self.shadows.iter_mut().for_each(|shadow| shadow.subject.carrier.start(time[sample], &phases));
    }

    /// Carries everything to a sample.
    fn carry(&mut self, sample: usize) {
        let until = self.recording.time[sample];
        self.carry_shadows(sample, until);
        let kept = (-(until - self.reference.carrier.time()) / MISSED).exp();
        self.reference.carrier.prepare(until);
        self.bends.look(&self.reference.carrier, until);
        let bends = self.bends.are_met(&self.covariance);
        if bends {
            self.carry_points(sample, until, kept);
        }
        let Self { reference, points, mean, covariance, tangent, missed, currents, .. } = self;
        tangent.restart();
        reference.currents(sample - 1, currents);
        push(currents, &reference.carrier, missed);
        reference.carrier.carry(currents, until, Some(tangent));
        missed.iter_mut().for_each(|missed| *missed *= kept);
        put(&reference.carrier, missed, mean);
        self.shadows.iter().zip(&mut self.differences).for_each(|(shadow, difference)| {
            put(&shadow.subject.carrier, missed, difference);
            difference.iter_mut().zip(mean.iter()).for_each(|(other, own)| *other = (*other - own) / shadow.step);
        });
        covariance.pass(tangent, kept);
        if bends {
            points.pass(mean, &covariance.transition);
            covariance.collect(points, mean);
            let (motion, torques) = mean.split_at(4 * missed.len());
            let motion = motion.chunks_exact(4).enumerate();
            motion.for_each(|(joint, m)| reference.carrier.correct(joint, [m[0], m[1], m[2], m[3]]));
            missed.copy_from_slice(torques);
        } else {
            covariance.carry();
        }
        covariance.add_noise(tangent, &self.noise);
        for (joint, spread) in self.spread.iter().enumerate() {
            covariance.widen(&[4 * missed.len() + joint], spread * (1.0 - kept * kept).sqrt());
        }
        self.carry_sensitivities();
    }

    /// Carries the shadows from the state of the reference.
    fn carry_shadows(&mut self, sample: usize, until: f64) {
        let Self { reference, shadows, missed, currents, .. } = self;
        for shadow in shadows.iter_mut() {
            let carrier = &mut shadow.subject.carrier;
            carrier.follow(&reference.carrier);
            carrier.prepare(until);
            shadow.subject.currents(sample - 1, currents);
            push(currents, &reference.carrier, missed);
            shadow.subject.carrier.carry(currents, until, None);
        }
    }

    /// Carries the points of the Gaussian that meet a bend.
    fn carry_points(&mut self, sample: usize, until: f64, kept: f64) {
        let Self { reference, other, points, bends, covariance, missed, currents, .. } = self;
        let motion = 4 * missed.len();
        covariance.factor(points);
        let mut torques = missed.clone();
        for point in 0..points.count() {
            if !bends.are_met_by(points, point) {
                continue;
            }
            other.carrier.mirror(&reference.carrier);
            displace(&mut other.carrier, |state| points.distance(point, state));
            for (joint, (torque, missed)) in torques.iter_mut().zip(missed.iter()).enumerate() {
                *torque = missed + points.distance(point, motion + joint);
            }
            reference.currents(sample - 1, currents);
            push(currents, &reference.carrier, &torques);
            other.carrier.carry(currents, until, None);
            torques.iter_mut().for_each(|torque| *torque *= kept);
            put(&other.carrier, &torques, points.moved(point));
        }
    }

    /// Carries `∂m/∂p` by the transition of the last interval.
    fn carry_sensitivities(&mut self) {
        let size = self.mean.len();
        let before = &mut self.before;
        for (sensitivity, difference) in self.sensitivities.iter_mut().zip(&self.differences) {
            before.copy_from_slice(sensitivity);
            let rows = self.covariance.transition.chunks_exact(size);
            for ((s, row), g) in sensitivity.iter_mut().zip(rows).zip(difference) {
                *s = row.iter().zip(before.iter()).map(|(f, s)| f * s).sum::<f64>() + g;
            }
        }
    }

    /// Takes the reading of a joint into account.
    fn take(&mut self, joint: usize, sample: usize, counts: bool, keep: bool) {
        let state = 4 * joint;
        let misread = self.reference.carrier.misread(joint);
        for (shadow, other) in self.shadows.iter_mut().zip(&mut self.misread) {
            *other = (shadow.subject.carrier.misread(joint) - misread) / shadow.step;
        }
        let read = self.recording.joints[joint].read(sample);
        let theta = self.reference.carrier.joints()[joint].theta + misread;
        let settings = self.settings;
        let mut said = read.says(theta, self.covariance.variance(state), settings);
        if counts {
            self.outcome.nats[joint] += said.nats;
            self.outcome.readings[joint] += 1;
            self.learn(state, &said);
        }
        let first = said;
        if said.regular < 0.5 {
            self.widen(joint, if settings.anywhere > 0.0 { said.shift } else { 0.0 });
            said = read.says(theta, self.covariance.variance(state), settings);
        }
        self.covariance.update(state, said.variance, said.share);
        self.correct(&said);
        for (sensitivity, misread) in self.sensitivities.iter_mut().zip(&self.misread) {
            let fall = (1.0 - said.share) * (sensitivity[state] + misread);
            sensitivity.iter_mut().zip(&self.covariance.gain).for_each(|(s, gain)| *s -= gain * fall);
        }
        if keep {
            let interval = self.recording.time[sample] - self.recording.time[sample.saturating_sub(1)];
            let push = self.covariance.gain[state + 1] * said.shift / interval.max(f64::MIN_POSITIVE);
            let missing = self.missed[joint] + self.reference.carrier.rotor_inertia(joint) * push;
            self.outcome.scored[joint].push(Scored { said: first, missing });
        }
    }

    /// Moves the mean by the gain of the last update.
    fn correct(&mut self, said: &Said) {
        if said.shift == 0.0 {
            return;
        }
        let gain = &self.covariance.gain;
        displace(&mut self.reference.carrier, |state| gain[state] * said.shift);
        let torques = &gain[4 * self.missed.len()..];
        self.missed.iter_mut().zip(torques).for_each(|(missed, gain)| *missed += gain * said.shift);
    }

    /// Adds what a reading says to gradient and information.
    fn learn(&mut self, state: usize, said: &Said) {
        let slope = |p: usize| self.sensitivities[p][state] + self.misread[p];
        let (pull, weight) = (said.regular * said.shift, said.regular * (1.0 - said.share));
        if self.shadows.is_empty() || (pull == 0.0 && weight == 0.0) {
            return;
        }
        for row in 0..self.shadows.len() {
            let own = slope(row) / said.variance;
            self.outcome.gradient[row] += pull * own;
            for column in 0..=row {
                self.outcome.information[(row, column)] += weight * own * slope(column);
            }
        }
    }

    /// After an outlier by this way [rad or m]: the joint may be elsewhere, rotor and link together, and go at another speed.
    fn widen(&mut self, joint: usize, way: f64) {
        let (state, step) = (4 * joint, self.recording.joints[joint].step().max(way.abs()));
        self.covariance.widen(&[state, state + 2], step);
        self.covariance.widen(&[state + 1, state + 3], step / JOLT);
        self.covariance.widen(&[state + 1], step / JOLT);
        self.covariance.widen(&[state + 2], 0.1 * step);
    }
}

/// Where laws bend beside a state.
struct Bends {
    interval: f64,
    /// Distances from a flank that may be met in the interval [rad or m], and from the rest of rotor and link [rad/s or m/s], one per joint.
    distances: Vec<[f64; 3]>,
}

impl Bends {
    /// Looks around the state of a machine, for the interval to a time [s].
    fn look(&mut self, carrier: &Carrier, until: f64) {
        self.interval = until - carrier.time();
        for (joint, (y, distances)) in carrier.joints().iter().zip(&mut self.distances).enumerate() {
            let flank = carrier.slack(joint).abs() - self.interval * (y.omega - y.v).abs();
            *distances = [flank, y.omega.abs(), y.v.abs()];
        }
    }

    /// Whether a law may bend within the deviations of the state.
    fn are_met(&self, covariance: &Covariance) -> bool {
        self.meet(|joint| {
            let state = 4 * joint;
            let apart = covariance.deviation_between(state, state + 2);
            [apart, covariance.deviation(state + 1), covariance.deviation(state + 3)]
        })
    }

    /// Whether a law may bend between the mean and a point.
    fn are_met_by(&self, points: &Points, point: usize) -> bool {
        self.meet(|joint| {
            let [theta, omega, q, v] = [0, 1, 2, 3].map(|k| points.distance(point, 4 * joint + k));
            [(theta - q).abs() + self.interval * (omega - v).abs(), omega.abs(), v.abs()]
        })
    }

    /// Whether a bend lies within these ways, each one of those of `distances`.
    fn meet(&self, ways: impl Fn(usize) -> [f64; 3]) -> bool {
        let meets = |(distance, way): (&f64, f64)| way > 0.0 && *distance < BENDS * way;
        self.distances.iter().enumerate().any(|(joint, distances)| distances.iter().zip(ways(joint)).any(meets))
    }
}

/// Moves the state of a machine.
fn displace(carrier: &mut Carrier, by: impl Fn(usize) -> f64) {
    for joint in 0..carrier.joints().len() {
        let (y, at) = (carrier.joints()[joint], 4 * joint);
        carrier.correct(joint, [y.theta + by(at), y.omega + by(at + 1), y.q + by(at + 2), y.v + by(at + 3)]);
    }
}

/// Adds torques [N·m or N] on the rotors to currents [A].
fn push(currents: &mut [f64], carrier: &Carrier, torques: &[f64]) {
    for (joint, (current, torque)) in currents.iter_mut().zip(torques).enumerate() {
        *current += torque / carrier.torque_per_ampere(joint);
    }
}

/// Writes the state of a machine, and the torques that it misses.
fn put(carrier: &Carrier, missed: &[f64], out: &mut [f64]) {
    let (motion, torques) = out.split_at_mut(4 * missed.len());
    for (y, out) in carrier.joints().iter().zip(motion.chunks_exact_mut(4)) {
        out.copy_from_slice(&[y.theta, y.omega, y.q, y.v]);
    }
    torques.copy_from_slice(missed);
}
