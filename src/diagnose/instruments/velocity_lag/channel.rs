//! Velocity of a joint twice: from its position and from its velocity channel, through the same kernel.

use crate::diagnose::rows::division::Division;
use crate::diagnose::rows::kernel::Kernel;
use crate::diagnose::rows::sampling::Sampling;
use crate::drive::VelocitySensor;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};

/// `w` [s] Half width of the kernel: with an encoder of 1 mrad at 200 Hz the noise of a velocity is 7 mrad/s.
const HALF_WIDTH: f64 = 0.03;
/// Least number of samples within `w`.
const SAMPLES: usize = 4;
/// Number of points within `w`: at a quarter of it, a cubic through the values and slopes of a kernel average has an error of
/// `(w/4)⁴/384` of its fourth derivative, 1e-5 of an oscillation of period `2 w`.
const POINTS: f64 = 4.0;
/// [s] Time at the start of a recording, and after a pause, that is not compared: a filter still responds to the motion before it. After
/// this time e^−2.5 of the velocity at the start is left for a time constant of 0.2 s; recordings begin at rest.
const SETTLING: f64 = 0.5;

/// Points of an uninterrupted part of a session.
pub struct Stretch {
    /// Index of the session.
    pub session: usize,
    /// [s]
    pub time: Vec<f64>,
    /// `v` [rad/s or m/s] from the position, after the low-pass of the model's sensor.
    pub expected: Vec<f64>,
    /// `v̇` [rad/s² or m/s²] of the same.
    pub slope: Vec<f64>,
    /// [rad/s or m/s] The velocity channel.
    pub read: Vec<f64>,
    /// First point that is compared.
    pub first: usize,
    /// First point that is held out.
    pub held_out: usize,
}

/// Velocities of a joint in all sessions.
pub struct Channels {
    /// Their parts.
    pub stretches: Vec<Stretch>,
    /// [s] Largest mean step of the sessions.
    pub step: f64,
}

impl Channels {
    /// `None` where no session has a velocity channel, or where its lag depends on the speed: pulses that are timed are half a count to
    /// one and a half counts old.
    pub fn new(model: &Model, joint: usize, sessions: &[&TimeSeries], division: Division) -> Option<Self> {
        let nominal = match model.joints[joint].velocity_sensor {
            Some(VelocitySensor::PulsePeriod) => return None,
            Some(VelocitySensor::LowPass(time_constant)) => time_constant,
            None => 0.0,
        };
        let mut channels = Self { stretches: Vec::new(), step: 0.0 };
        for (number, session) in sessions.iter().enumerate() {
            let series = session.joint(&model.joints[joint].name);
            let signal = |channel: Channel| series.and_then(|series| series.get(channel));
            let (Some(q), Some(v)) = (signal(Channel::Position), signal(Channel::Velocity)) else { continue };
            let sampling = Sampling::new(&session.time, session.sample_interval());
            if sampling.median.is_nan() || sampling.median <= 0.0 {
                continue;
            }
            channels.step = channels.step.max(sampling.mean());
            let held_out = |time: f64| division.holds_out(number, session, time);
            channels.stretches.extend(stretches(number, &session.time, &sampling, [q, v], nominal, held_out));
        }
        (!channels.stretches.is_empty()).then_some(channels)
    }
}

fn stretches(
    session: usize,
    time: &[f64],
    sampling: &Sampling,
    [q, v]: [&[f64]; 2],
    nominal: f64,
    held_out: impl Fn(f64) -> bool,
) -> Vec<Stretch> {
    let reach = ((HALF_WIDTH / sampling.median).round() as usize).max(SAMPLES);
    let kernel = Kernel::new(reach, sampling.median);
    let steps = ((reach as f64 / POINTS) as usize).max(1);
    let mut stretches: Vec<Stretch> = Vec::new();
    let mut before: Option<(usize, bool)> = None;
    for (centre, part) in sampling.centres(kernel.half_width, steps) {
        // A stretch is held out from some point on: after that point training data begin a new one.
        let now = (part, held_out(time[centre]));
        if before.is_none_or(|before| before.0 != now.0 || (before.1 && !now.1)) {
            stretches.push(Stretch::empty(session));
        }
        before = Some(now);
        let Some(stretch) = stretches.last_mut() else { continue };
        let window = sampling.window(&kernel, centre, part);
        let motion = window.averages(q);
        stretch.time.push(time[centre]);
        stretch.expected.push(motion.rate);
        stretch.slope.push(motion.curvature);
        stretch.read.push(window.averages(v).value);
    }
    for stretch in &mut stretches {
        let [expected, slope] = stretch.filtered(nominal);
        (stretch.expected, stretch.slope) = (expected, slope);
        let begin = stretch.time[0] + SETTLING;
        stretch.first = stretch.time.partition_point(|t| *t < begin);
        stretch.held_out = stretch.time.partition_point(|t| !held_out(*t)).max(stretch.first);
    }
    stretches.retain(|stretch| stretch.first < stretch.time.len());
    stretches
}

impl Stretch {
    fn empty(session: usize) -> Self {
        let [time, expected, slope, read] = [(); 4].map(|()| Vec::new());
        Self { session, time, expected, slope, read, first: 0, held_out: 0 }
    }

    /// The expected velocity and its slope after a first-order low-pass.
    ///
    /// ```text
    ///   y(t + h) = e^{−a} y(t) + Σ c_n J_n,   a = h/τ,   J_0 = 1 − e^{−a},   J_n = 1 − (n/a) J_{n−1},   ẏ = (v − y)/τ
    /// ```
    /// is exact for the cubic `v = Σ c_n s^n`, `s` from 0 to 1, with the values and slopes of both points.
    pub fn filtered(&self, time_constant: f64) -> [Vec<f64>; 2] {
        let shortest = self.time.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        // A filter that forgets within a step passes everything.
        if time_constant < 1e-3 * shortest {
            return [self.expected.clone(), self.slope.clone()];
        }
        let mut output = Vec::with_capacity(self.time.len());
        let mut y = self.expected[0];
        output.push(y);
        for k in 1..self.time.len() {
            let h = self.time[k] - self.time[k - 1];
            let c = cubic([self.expected[k - 1], self.expected[k]], [h * self.slope[k - 1], h * self.slope[k]]);
            let a = h / time_constant;
            let mut moment = -(-a).exp_m1();
            y += moment * (c[0] - y);
            for (n, c) in c.iter().enumerate().skip(1) {
                moment = 1.0 - n as f64 / a * moment;
                y += c * moment;
            }
            output.push(y);
        }
        let slope = self.expected.iter().zip(&output).map(|(v, y)| (v - y) / time_constant).collect();
        [output, slope]
    }

    /// The compared points of a signal with slopes, read `delay` [s] earlier; constant before the first.
    pub fn delayed(&self, [value, slope]: &[Vec<f64>; 2], delay: f64) -> Vec<f64> {
        let mut next = 1;
        let at = |k: usize| {
            let t = self.time[k] - delay;
            while next + 1 < self.time.len() && self.time[next] < t {
                next += 1;
            }
            let h = self.time[next] - self.time[next - 1];
            let s = ((t - self.time[next - 1]) / h).clamp(0.0, 1.0);
            let c = cubic([value[next - 1], value[next]], [h * slope[next - 1], h * slope[next]]);
            c[0] + s * (c[1] + s * (c[2] + s * c[3]))
        };
        if self.time.len() < 2 { value.clone() } else { (self.first..self.time.len()).map(at).collect() }
    }
}

/// Coefficients of a cubic from 0 to 1 with these values and slopes at its ends.
fn cubic([a, b]: [f64; 2], [u, v]: [f64; 2]) -> [f64; 4] {
    [a, u, 3.0 * (b - a) - 2.0 * u - v, 2.0 * (a - b) + u + v]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `sin ω t` after a delay and a low-pass, at uneven times.
    #[test]
    fn closed_form_a_sine_is_delayed_and_filtered() {
        let (omega, delay) = (12.0_f64, 0.033);
        let mut stretch = Stretch::empty(0);
        let mut t = 0.0;
        for k in 0..1200 {
            t += [0.006, 0.008, 0.007][k % 3];
            stretch.time.push(t);
            stretch.expected.push((omega * t).sin());
            stretch.slope.push(omega * (omega * t).cos());
        }
        stretch.first = 900;
        for time_constant in [1e-9, 1e-3, 0.02, 0.3] {
            let late = stretch.delayed(&stretch.filtered(time_constant), delay);
            for (t, y) in stretch.time[900..].iter().zip(late) {
                let phase = (omega * time_constant).atan();
                let expected = phase.cos() * (omega * (t - delay) - phase).sin();
                // A cubic through values and slopes is off by h⁴ ω⁴/384 = 2e-7; the filter has forgotten its start by e^−20.
                assert!((y - expected).abs() < 1e-6, "{time_constant}, {t}: {y} for {expected}");
            }
        }
    }
}
