//! The feedback that keeps a replayed machine close to its recording.
//!
//! ```text
//!   τ(k) = τ_rec(k) + c(q_sim, k) − c(q_rec, k)          c(q, k) = −k_v (k_p q(k) + (q(k) − q(k−n))/(n T))
//! ```
//! At uneven times, `n T` is the time from sample `k−n` to sample `k`.
//!
//! If `c` is the machine's own controller (given in the manifest), this is exactly its closed loop: `τ_rec − c(q_rec)`
//! contains reference, pulses and feedforward, and the noise of the recorded position cancels. Otherwise `c` is a
//! tracking controller of a given bandwidth `ω` on the inertia `J` that the joint moves, with both poles at `ω`:
//! `k_v = 2 ω J`, `k_p = ω/2`, along the recorded motion after a low-pass. In open loop `c = 0`.
//! While the rotor crosses its gap, it moves alone with the inertia `J_r`, and a correction every `T` is stable below `k_v T/J_r = 1`.
//! So where the rotor is light and the sampling is slower than a drive's own loop, a tracking controller corrects several times per
//! sample, along a straight line between the samples.

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::inputs::Input;
use super::low_pass::low_pass;
use super::{Loop, Options};
use crate::dataset::{Controller, Session};
use crate::dynamics::Dynamics;
use crate::effects::JointState;
use crate::robot::Model;
use crate::timeseries::{Clock, Samples};

/// One feedback per joint: the machine's own if the session gives it; in open loop none for recorded joints.
pub(super) fn of_joints(model: &Model, session: &Session, inputs: &[Input], options: &Options) -> Vec<Feedback> {
    let clock = &Clock::new(&session.series.time);
    let start: Vec<f64> = inputs.iter().map(|input| input.position[0]).collect();
    let mut mass = DMatrix::zeros(model.robot.dof(), model.robot.dof());
    Dynamics::new(&model.robot).mass_matrix(&start, &mut mass);
    let own = |name: &str| {
        let index = session.series.joints.iter().position(|joint| joint.name == name)?;
        session.controllers.get(index).copied().flatten()
    };
    let rotors: Vec<f64> = model.joints.iter().enumerate().map(|(i, joint)| joint.rotor_beside(mass[(i, i)])).collect();
    let tracking = |i: usize| Tracking::new(options.bandwidth, rotors[i] + mass[(i, i)]);
    let steps = (0..rotors.len()).map(|i| tracking(i).steps(clock.longest_step(), rotors[i])).max().unwrap_or(1);
    let joints = model.joints.iter().zip(inputs).enumerate();
    let feedback = joints.map(|(i, (joint, input))| match own(&joint.name) {
        _ if options.control == Loop::Open && input.recorded => Feedback::none(&input.position, clock),
        Some(controller) => Feedback::machine(controller, &input.position, clock, 1),
        None => tracking(i).along(&input.position, clock, steps),
    });
    feedback.collect()
}

/// The controller of a machine whose own is not known.
struct Tracking {
    /// [Hz]
    bandwidth: f64,
    controller: Controller,
}

impl Tracking {
    /// For an inertia [kg·m² or kg].
    fn new(bandwidth: f64, inertia: f64) -> Self {
        let omega = 2.0 * std::f64::consts::PI * bandwidth;
        let controller =
            Controller { position_gain: omega / 2.0, velocity_gain: 2.0 * omega * inertia, velocity_samples: 1 };
        Self { bandwidth, controller }
    }

    /// Corrections per sample that are stable for the rotor alone; `interval` [s]: the longest between two samples.
    fn steps(&self, interval: f64, rotor: f64) -> usize {
        /// `k_v T/J_r` [1]: half of what is stable.
        const STABLE: f64 = 0.5;
        /// A rotor that is even lighter is stopped by its flanks within microseconds.
        const MOST: usize = 200;
        /// [s] A recording this fast has the rate of a drive's own loop, which is stable with the same rotor.
        const RATE_OF_A_DRIVE: f64 = 1.001e-3;
        if interval <= RATE_OF_A_DRIVE {
            return 1;
        }
        let steps = self.controller.velocity_gain * interval / (STABLE * rotor.max(1e-300));
        (steps.ceil() as usize).clamp(1, MOST)
    }

    /// Feedback along a recorded motion, with `steps` corrections per sample.
    fn along(&self, recorded: &[f64], clock: &Clock, steps: usize) -> Feedback {
        /// Cut-off of the recorded motion divided by the bandwidth of the loop.
        const MARGIN: f64 = 5.0;
        let smooth = low_pass(recorded, clock, MARGIN * self.bandwidth);
        let between = |pair: &[f64]| {
            let (from, way) = (pair[0], pair[1] - pair[0]);
            (0..steps).map(move |step| from + way * step as f64 / steps as f64)
        };
        let fine: Vec<f64> = smooth.windows(2).flat_map(between).chain(smooth.last().copied()).collect();
        Feedback::machine(self.controller, &fine.into(), clock, steps)
    }
}

/// The correction of one joint.
#[derive(Debug)]
pub(super) struct Feedback {
    controller: Controller,
    start: [f64; 2],
    /// [s] Median time between two corrections, and whether all times are the same.
    interval: f64,
    even: bool,
    recorded: Samples,
    /// The last simulated positions and their times, as many as the difference quotient spans, in a ring buffer.
    simulated: Vec<f64>,
    times: Vec<f64>,
    /// Number of samples so far.
    seen: usize,
    /// Corrections per sample.
    pub(super) steps: usize,
}

impl Feedback {
    /// The machine's own controller, on recorded positions with `steps` of them per sample.
    pub(super) fn machine(controller: Controller, recorded: &Samples, clock: &Clock, steps: usize) -> Self {
        let last = controller.velocity_samples.min(recorded.len() - 1);
        let samples = last.div_ceil(steps);
        let span = clock.elapsed(0, samples) * (last as f64 / (samples * steps).max(1) as f64);
        let velocity = if last == 0 { 0.0 } else { (recorded[last] - recorded[0]) / span };
        Self {
            controller,
            start: [recorded[0], velocity],
            interval: clock.interval / steps as f64,
            even: clock.even,
            recorded: recorded.clone(),
            simulated: vec![0.0; controller.velocity_samples + 1],
            times: vec![0.0; controller.velocity_samples + 1],
            seen: 0,
            steps,
        }
    }

    /// No correction. A wrong start would never be corrected, so the start is taken from a parabola through the first
    /// samples.
    fn none(recorded: &Samples, clock: &Clock) -> Self {
        /// [s] Length of the parabola: some tens of samples, in which the acceleration of a joint hardly changes.
        const SPAN: f64 = 0.02;
        let samples = clock.after(0, SPAN).clamp(3, recorded.len().max(3)).min(recorded.len());
        let controller = Controller { position_gain: 0.0, velocity_gain: 0.0, velocity_samples: 1 };
        let plain = Self::machine(controller, recorded, clock, 1);
        let start = parabola(&recorded[..samples], clock).unwrap_or(plain.start);
        Self { start, ..plain }
    }

    /// The initial motion of the recording, with the link in the middle of the gap.
    pub(super) fn start(&self) -> JointState {
        let [position, velocity] = self.start;
        JointState {
            motor_position: position,
            motor_velocity: velocity,
            link_position: position,
            link_velocity: velocity,
            ..JointState::default()
        }
    }

    /// `c(q_sim, k) − c(q_rec, k)` [N·m or N] at the next correction `k`, with `position` as the simulated position at the time `now` [s].
    pub(super) fn correction(&mut self, position: f64, now: f64) -> f64 {
        let Controller { position_gain, velocity_gain, velocity_samples } = self.controller;
        let k = self.seen;
        let places = self.simulated.len();
        self.simulated[k % places] = position;
        self.times[k % places] = now;
        self.seen += 1;
        let before = k.saturating_sub(velocity_samples);
        let behind = |at: usize| self.recorded[at] - self.simulated[at % places];
        // Before the first sample the machine did not move against its recording.
        let earlier = velocity_samples - (k - before);
        let span = if self.even || k == before {
            velocity_samples as f64 * self.interval
        } else {
            now - self.times[before % places] + earlier as f64 * self.interval
        };
        let rate = (behind(k) - behind(before)) / span;
        velocity_gain * (position_gain * behind(k) + rate)
    }
}

/// Value and derivative at the first sample of the least-squares parabola; `None` if there are too few samples.
fn parabola(samples: &[f64], clock: &Clock) -> Option<[f64; 2]> {
    let first = *samples.first()?;
    let (mut a, mut b) = (Matrix3::zeros(), Vector3::zeros());
    for (k, sample) in samples.iter().enumerate() {
        let t = clock.elapsed(0, k) / clock.interval;
        let row = Vector3::new(1.0, t, t * t);
        a += row * row.transpose();
        b += row * (sample - first);
    }
    let c = a.try_inverse()? * b;
    Some([first + c[0], c[1] / clock.interval])
}
