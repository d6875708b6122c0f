//! Effects added to recorded currents or torques: the motion stays as it was recorded, as under a stiff controller, and the motor carries what the effect exerts.
//!
//! ```text
//!   i' = i − τ_e(t, q, v) / (N K_t)
//! ```
//! The machine, its sensors and the errors of its model are those of the recording; only what is added is known.

use std::f64::consts::TAU;

use lostmotion::robot::Model;
use lostmotion::timeseries::{Channel, TimeSeries, delayed};

/// What is added to one joint.
pub struct Added {
    /// A parameter of the effect, and its true value; `None` where that depends on the machine.
    pub truth: Option<(&'static str, f64)>,
    change: Change,
}

/// `τ_e` [N·m] of time since the start [s], position [rad] and velocity [rad/s].
type Law = Box<dyn Fn(f64, f64, f64) -> f64>;

enum Change {
    Torque(Law),
    /// Factor of the current or torque, by position [rad].
    Scale(Box<dyn Fn(f64) -> f64>),
    /// Currents, commands and torques of all joints are recorded late [s].
    Late(f64),
}

/// How a joint moves in all recordings.
#[derive(Debug, Clone, Copy)]
pub struct Moved {
    /// [rad] Positions between which it is 96 % of the time.
    pub range: [f64; 2],
    /// [rad/s] Speed that it exceeds in 2 % of the time.
    pub fast: f64,
}

/// [s] Time to either side over which velocities are taken.
const WIDTH: f64 = 0.06;

/// Velocities [rad/s], by the difference of the positions [`WIDTH`] before and after.
fn velocities(time: &[f64], position: &[f64]) -> Vec<f64> {
    let [after, before] = [-WIDTH, WIDTH].map(|lag| delayed(time, position, lag));
    after.iter().zip(before).map(|(after, before)| (after - before) / (2.0 * WIDTH)).collect()
}

impl Moved {
    /// Of a joint in some sessions.
    pub fn new(sessions: &[TimeSeries], joint: usize) -> Self {
        let [mut positions, mut speeds] = [Vec::new(), Vec::new()];
        for session in sessions {
            let position = session.joints[joint].get(Channel::Position).expect("positions");
            speeds.extend(velocities(&session.time, position).into_iter().map(f64::abs));
            positions.extend_from_slice(position);
        }
        let share = |values: &mut Vec<f64>, part: f64| {
            values.sort_by(f64::total_cmp);
            values[((values.len() - 1) as f64 * part) as usize]
        };
        Self { range: [share(&mut positions, 0.02), share(&mut positions, 0.98)], fast: share(&mut speeds, 0.98) }
    }
}

/// An effect that exerts at most about `torque` [N·m] on a joint that moves so. A ripple of the torque constant is 12 %, a delay 12 ms.
///
/// # Panics
/// There is no law for this name.
pub fn added(effect: &str, torque: f64, moved: Moved, model: &Model, joint: usize) -> Added {
    let (ratio, per_ampere) = (model.joints[joint].gear_ratio, model.joints[joint].torque_per_ampere());
    let Moved { range: [low, high], fast } = moved;
    let stroke = high - low;
    let of = |name, value, law: Law| Added { truth: Some((name, value)), change: Change::Torque(law) };
    match effect {
        "cogging" => of("amplitude", torque, Box::new(move |_, q, _| torque * (7.0 * ratio * q + 0.7).sin())),
        "cable_spring" => {
            let (k, rest) = (2.0 * torque / stroke, low + 0.3 * stroke);
            of("stiffness", k, Box::new(move |_, q, _| k * (rest - q)))
        }
        "external_contact" => {
            let (k, angle) = (6.0 * torque / stroke, low + 0.75 * stroke);
            of("angle", angle, Box::new(move |_, q, _| -k * (q - angle).max(0.0)))
        }
        "current_offset" => of("offset", torque / per_ampere, Box::new(move |_, _, _| -torque)),
        // What friction the machine has itself is not known.
        "viscous_asymmetry" => {
            Added { truth: None, ..of("", 0.0, Box::new(move |_, _, v| -torque * v.max(0.0) / fast)) }
        }
        "position_dependent_friction" => {
            let order = TAU / stroke;
            // Smooth over a hundredth of the fastest motion.
            let sign = move |v: f64| (v / (0.01 * fast)).tanh();
            of("order", order, Box::new(move |_, q, v| -torque * (order * q + 0.5).sin() * sign(v)))
        }
        "quadratic_drag" => {
            let drag = torque / fast.powi(2);
            of("coefficient", drag, Box::new(move |_, _, v| -drag * v * v.abs()))
        }
        "thermal_friction_drift" => {
            of("time_constant", 40.0, Box::new(move |t, _, v| -torque * v / fast * (-t / 40.0).exp()))
        }
        "torque_ripple" => {
            let scale = move |q: f64| 1.0 / (1.0 + 0.12 * (5.0 * ratio * q).sin());
            Added { truth: Some(("amplitude", 0.12)), change: Change::Scale(Box::new(scale)) }
        }
        "sensor_delay" => Added { truth: Some(("current_delay", 0.012)), change: Change::Late(0.012) },
        other => panic!("{other} is not added to recordings"),
    }
}

impl Added {
    /// A session with the effect on a joint.
    pub fn to(&self, session: &TimeSeries, model: &Model, joint: usize) -> TimeSeries {
        let mut with = session.clone();
        let position = session.joints[joint].get(Channel::Position).expect("positions");
        let recorded = &session.joints[joint].channels;
        let (channel, per_unit) = match recorded.contains_key(&Channel::Torque) {
            true => (Channel::Torque, 1.0),
            false => (Channel::Current, model.joints[joint].torque_per_ampere()),
        };
        let drive = |with: &mut TimeSeries, change: &dyn Fn(usize, f64) -> f64| {
            let drive = with.joints[joint].channels.get_mut(&channel).expect("currents or torques");
            drive.iter_mut().enumerate().for_each(|(k, i)| *i = change(k, *i));
        };
        match &self.change {
            Change::Torque(torque) => {
                let velocity = velocities(&session.time, position);
                let start = session.time[0];
                let own = |k: usize| torque(session.time[k] - start, position[k], velocity[k]);
                drive(&mut with, &|k, i| i - own(k) / per_unit);
            }
            Change::Scale(scale) => drive(&mut with, &|k, i| i * scale(position[k])),
            Change::Late(lag) => {
                for series in &mut with.joints {
                    for channel in [Channel::Current, Channel::CommandCurrent, Channel::Torque] {
                        if let Some(values) = series.channels.get_mut(&channel) {
                            *values = delayed(&session.time, values, *lag).into();
                        }
                    }
                }
            }
        }
        with
    }
}
