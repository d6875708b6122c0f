//! One channel is recorded late relative to the others.
//!
//! A current that is late by `T` reads `i(t − T) ≈ i − T di/dt`; a position (and velocity) late by `T` is equivalent to a current early by `T`.
//! A link encoder that is late by `T` changes `motor − link` by `q(t) − q(t − T) ≈ T q̇`, which a fit without it takes for a gap.
//! `T` is the same on all joints: one recorder, one bus.
//! Left out: varying delays (jitter), and the controller's own delay.
//! Reference: seen on the KUKA KR300 data of J. Weigand et al. as 2.8 to 3.1 ms between encoder channels.

use std::collections::{BTreeMap, VecDeque};

use super::phenomenon::of_either_sign;
use super::{
    About, Action, Claim, Diagnosable, Effect, Kind, Motion, ParameterSpec, Parameters, Phenomenon, Reading, Scope,
    SensorAction,
};
use crate::error::Result;
use crate::robot::Model;

/// The name of this effect.
pub const SENSOR_DELAY: &str = "sensor_delay";

static ABOUT: About = About {
    name: SENSOR_DELAY,
    summary: "The current, position and velocity, or the link encoder, are recorded late.",
    equation: "x(t) → x(t − T) for one channel",
    kind: Kind::Measurement,
    scope: Scope::Machine,
    parameters: &[
        ParameterSpec::new("current_delay", "T_i", "s", "how late the current is recorded").between(0.0, 0.1).or(0.0),
        ParameterSpec::new("position_delay", "T_q", "s", "how late position and velocity are recorded")
            .between(0.0, 0.1)
            .or(0.0),
        ParameterSpec::new("link_delay", "T_l", "s", "how late the link encoder is recorded").between(0.0, 0.1).or(0.0),
    ],
    signature: "a residual proportional to the rate of the torque, with one delay for all joints",
    look_alikes: &["viscous_asymmetry", "payload", "load_dependent_friction"],
    separate_by: "fast motion of axes of different inertia and stiffness: a delay is the same on all of them",
    reference: "J. Weigand et al. (2022), KUKA KR300 data set: 2.8 to 3.1 ms between encoder channels",
};

/// One channel is recorded late.
pub struct SensorDelay;

/// Takes `T_i` [s] out of the effects of a model: how late its currents are recorded.
pub fn take_current_delay(model: &mut Model) -> f64 {
    take(model, "current_delay")
}

/// Takes `T_q` [s] out of the effects of a model: how late its positions and velocities are recorded.
pub fn take_position_delay(model: &mut Model) -> f64 {
    take(model, "position_delay")
}

fn take(model: &mut Model, delay: &str) -> f64 {
    let entries = model.effects.iter_mut().filter(|entry| entry.effect == ABOUT.name);
    entries.filter_map(|entry| entry.parameters.remove(delay)).sum()
}

/// Interpolated readings of a time in the past.
struct Late {
    current_delay: f64,
    position_delay: f64,
    link_delay: f64,
    history: VecDeque<(f64, Reading)>,
}

impl Late {
    fn at(&self, time: f64) -> Reading {
        let next = self.history.partition_point(|(sampled, _)| *sampled <= time);
        let after = self.history.get(next).or_else(|| self.history.back());
        let before = next.checked_sub(1).and_then(|index| self.history.get(index)).or(after);
        match (before, after) {
            (Some((t0, a)), Some((t1, b))) if t1 > t0 => {
                let part = ((time - t0) / (t1 - t0)).clamp(0.0, 1.0);
                let mix = |x: f64, y: f64| x + part * (y - x);
                Reading {
                    position: mix(a.position, b.position),
                    velocity: mix(a.velocity, b.velocity),
                    current: mix(a.current, b.current),
                    link_position: a.link_position.zip(b.link_position).map(|(a, b)| mix(a, b)),
                }
            }
            (Some((_, reading)), _) => *reading,
            _ => Reading::default(),
        }
    }
}

impl SensorAction for Late {
    fn alter(&mut self, time: f64, reading: &mut Reading) {
        self.history.push_back((time, *reading));
        let oldest = time - self.current_delay.max(self.position_delay).max(self.link_delay);
        while self.history.len() > 2 && self.history[1].0 <= oldest {
            self.history.pop_front();
        }
        let moved = self.at(time - self.position_delay);
        reading.position = moved.position;
        reading.velocity = moved.velocity;
        reading.current = self.at(time - self.current_delay).current;
        reading.link_position = self.at(time - self.link_delay).link_position;
    }
}

impl Effect for SensorDelay {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, _joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let late = |joint| {
            let history = VecDeque::new();
            let (current_delay, position_delay) = (given.get("current_delay"), given.get("position_delay"));
            let link_delay = given.get("link_delay");
            Action::Sensor(joint, Box::new(Late { current_delay, position_delay, link_delay, history }))
        };
        Ok((0..model.joints.len()).map(late).collect())
    }

    fn claims(&self, phenomenon: &Phenomenon) -> Option<Claim> {
        match phenomenon {
            Phenomenon::CurrentLag { lag } => Some(of_either_sign(*lag, "current_delay", "position_delay")),
            Phenomenon::LinkEncoderLag { lag } => Some(of_either_sign(*lag, "link_delay", "position_delay")),
            _ => None,
        }
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for SensorDelay {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        vec![motion.column(joint, |m, row| -m.torque_rate[row])]
    }

    /// Channels of one sample may have been read at its beginning or at its end: a delay shorter than half an interval cannot be told from that.
    fn is_itself(&self, motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> bool {
        coefficients[0].abs() > 0.5 * motion.interval
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0].max(0.0), (-coefficients[0]).max(0.0)]
    }
}
