//! The velocity channel lags behind the motion: it is late, or it passed a filter that the model does not know.
//!
//! ```text
//!   v(t) → y,   τ ẏ + y = g v(t − T)
//! ```
//! `T` is a delay, `τ` the time constant of a first-order low-pass, beyond that of the model's velocity sensor; `g` is a gain.
//! Position, current and torque are not altered. A controller that uses the velocity reading gets the late one.
//! Left out: filters of higher order, whose lag is the sum of their time constants.
//! Reference: R. C. Kavanagh (2001), Performance analysis and compensation of M/T-type digital tachometers (lag of velocity readings).

use std::collections::{BTreeMap, VecDeque};

use super::parameters::need_joint;
use super::{About, Action, Claim, Effect, Kind, ParameterSpec, Parameters, Phenomenon, Reading, Scope, SensorAction};
use crate::error::Result;
use crate::robot::Model;

/// [s] Longest delay and time constant. A diagnosis calls a channel that is later a mistake in the data: it was recorded by another clock. A pure
/// delay of half of that already is one, because no drive delays a velocity so long and not the position beside it.
pub const LONGEST_LAG: f64 = 0.3;

static ABOUT: About = About {
    name: "velocity_lag",
    summary: "The velocity channel is recorded late, or after a low-pass filter.",
    equation: "τ ẏ + y = g v(t − T)",
    kind: Kind::Measurement,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("delay", "T", "s", "how late the velocity is recorded").between(0.0, LONGEST_LAG).or(0.0),
        ParameterSpec::new(
            "time_constant",
            "τ",
            "s",
            "time constant of its low-pass beyond that of the model's sensor",
        )
        .between(0.0, LONGEST_LAG)
        .or(0.0),
        ParameterSpec::new("gain", "g", "1", "reading of a constant velocity, relative to it")
            .between(0.5, 2.0)
            .or(1.0),
    ],
    signature: "the velocity channel follows the derivative of the position later than the model's sensor does",
    look_alikes: &["sensor_delay"],
    separate_by: "fast reversals: a delay leaves their shape, a low-pass rounds it",
    reference: "R. C. Kavanagh (2001), Performance analysis and compensation of M/T-type digital tachometers",
};

/// The velocity channel lags.
pub struct VelocityLag;

struct Lagging {
    delay: f64,
    time_constant: f64,
    gain: f64,
    /// Readings [s, rad/s or m/s] of the last `delay`.
    history: VecDeque<(f64, f64)>,
    /// Time [s], input and output [rad/s or m/s] of the filter at the last reading.
    last: Option<[f64; 3]>,
}

impl Lagging {
    /// The velocity at a time in the past, interpolated; the first reading before it.
    fn at(&self, time: f64) -> f64 {
        let next = self.history.partition_point(|(sampled, _)| *sampled <= time);
        let before = self.history.get(next.saturating_sub(1));
        match (before, self.history.get(next)) {
            (Some((t0, a)), Some((t1, b))) if next > 0 => a + (time - t0) / (t1 - t0) * (b - a),
            (Some((_, reading)), _) => *reading,
            (None, _) => 0.0,
        }
    }

    /// Output of the filter for an input that is linear between readings.
    fn filtered(&mut self, time: f64, input: f64) -> f64 {
        let output = match self.last {
            Some([before, earlier, output]) if self.time_constant > 0.0 && time > before => {
                let a = (time - before) / self.time_constant;
                let passed = -(-a).exp_m1();
                let of_latest = 1.0 - passed / a;
                output + (earlier - output) * passed + of_latest * (input - earlier)
            }
            _ => input,
        };
        self.last = Some([time, input, output]);
        output
    }
}

impl SensorAction for Lagging {
    fn alter(&mut self, time: f64, reading: &mut Reading) {
        self.history.push_back((time, reading.velocity));
        while self.history.len() > 2 && self.history[1].0 <= time - self.delay {
            self.history.pop_front();
        }
        let late = self.gain * self.at(time - self.delay);
        reading.velocity = self.filtered(time, late);
    }
}

impl Effect for VelocityLag {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let lagging = Lagging {
            delay: given.get("delay"),
            time_constant: given.get("time_constant"),
            gain: given.get("gain"),
            history: VecDeque::new(),
            last: None,
        };
        Ok(vec![Action::Sensor(need_joint(&ABOUT, model, joint)?, Box::new(lagging))])
    }

    fn claims(&self, phenomenon: &Phenomenon) -> Option<Claim> {
        match phenomenon {
            Phenomenon::VelocityLag { delay, time_constant, gain } => {
                let mut claim = vec![("gain", *gain)];
                claim.extend(delay.map(|delay| ("delay", delay)));
                claim.extend(time_constant.map(|time_constant| ("time_constant", time_constant)));
                Some(claim)
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn readings(delay: f64, time_constant: f64, input: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let (gain, history, last) = (1.0, VecDeque::new(), None);
        let mut lagging = Lagging { delay, time_constant, gain, history, last };
        let at = |k: i32| {
            let time = f64::from(k) * 2e-3;
            let mut reading = Reading { velocity: input(time), ..Reading::default() };
            lagging.alter(time, &mut reading);
            (time, reading.velocity)
        };
        (0..800).map(at).collect()
    }

    /// A ramp comes out late by `T + τ`, once the filter has settled.
    #[test]
    fn closed_form_a_ramp_is_late_by_delay_and_time_constant() {
        for (delay, time_constant) in [(0.0, 0.0), (0.0213, 0.0), (0.0, 0.08), (0.03, 0.05)] {
            let (time, velocity) = readings(delay, time_constant, |t| 2.0 * t)[799];
            // e^−(1.6 − 0.08)/0.08 = 6e-9 of the start is left.
            assert!(
                (velocity - 2.0 * (time - delay - time_constant)).abs() < 1e-8,
                "{delay} {time_constant}: {velocity}"
            );
        }
    }

    /// A step comes out as `1 − e^{−(t − T)/τ}`.
    #[test]
    fn closed_form_a_step_rises_exponentially() {
        for (time, velocity) in readings(0.01, 0.1, |t| if t > 0.1 { 1.0 } else { 0.0 }) {
            let expected = if time > 0.11 { 1.0 - (-(time - 0.111) / 0.1).exp() } else { 0.0 };
            // The step is a ramp of one sample; half of it on either side of its middle differs by 0.5 · 1 ms/τ.
            assert!((velocity - expected).abs() < 0.011, "{time}: {velocity} for {expected}");
        }
    }
}
