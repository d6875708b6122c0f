//! Figures of a replay: RMS differences after the same low-pass on both sides.
//!
//! Velocity is the rate of the smooth position, on both sides: how a machine made its own velocity channel need not be known.

use super::inputs::Input;
use super::low_pass::low_pass;
use super::{ChannelError, Quantity};
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};
use crate::units::JointKind;

/// The differences of position, torque and velocity, joint by joint.
pub(super) fn compare(
    model: &Model,
    inputs: &[Input],
    recorded: &TimeSeries,
    simulated: &TimeSeries,
    cutoff: f64,
) -> Vec<ChannelError> {
    let interval = recorded.sample_interval();
    let mut errors = Vec::new();
    for (i, joint) in model.joints.iter().enumerate() {
        let smooth = |series: &TimeSeries, channel: Channel, magnitude: bool| -> Option<Vec<f64>> {
            let values = series.joints[i].get(channel)?;
            Some(match (channel, magnitude) {
                (Channel::Velocity, _) => values.to_vec(),
                (_, true) => low_pass(&values.iter().map(|value| value.abs()).collect::<Vec<_>>(), interval, cutoff),
                (_, false) => low_pass(values, interval, cutoff),
            })
        };
        for quantity in [Quantity::Position, Quantity::Torque, Quantity::Velocity] {
            let channel = quantity.channel();
            let magnitude = quantity == Quantity::Torque && inputs[i].magnitude;
            let (Some(measured), Some(model)) =
                (smooth(recorded, channel, false), smooth(simulated, channel, magnitude))
            else {
                continue;
            };
            let difference: Vec<f64> = measured.iter().zip(&model).map(|(a, b)| a - b).collect();
            let (rms, level) = (rms(&difference), self::rms(&measured));
            let relative = if level > 0.0 { rms / level } else { 0.0 };
            let unit = quantity.unit(joint.kind);
            errors.push(ChannelError { joint: joint.name.clone(), quantity, unit, rms, relative, difference });
        }
    }
    errors
}

/// Adds the rate of the smooth position as the velocity of each joint.
pub(super) fn add_velocity(series: &mut TimeSeries, interval: f64, cutoff: f64) {
    for joint in &mut series.joints {
        let Some(position) = joint.get(Channel::Position) else { continue };
        let smooth = low_pass(position, interval, cutoff);
        let last = smooth.len().saturating_sub(1);
        let rate = |k: usize| {
            let (from, to) = (k.saturating_sub(1), (k + 1).min(last));
            if to > from { (smooth[to] - smooth[from]) / ((to - from) as f64 * interval) } else { 0.0 }
        };
        let velocity = (0..smooth.len()).map(rate).collect();
        joint.channels.insert(Channel::Velocity, velocity);
    }
}

impl Quantity {
    /// The channel of a replay that holds it.
    pub const fn channel(self) -> Channel {
        match self {
            Self::Position => Channel::Position,
            Self::Velocity => Channel::Velocity,
            Self::Torque => Channel::Torque,
        }
    }

    /// Its unit on a joint that turns or slides.
    pub const fn unit(self, kind: JointKind) -> &'static str {
        match (self, kind) {
            (Self::Position, _) => kind.position_unit(),
            (Self::Velocity, JointKind::Revolute) => "rad/s",
            (Self::Velocity, JointKind::Prismatic) => "m/s",
            (Self::Torque, _) => kind.effort_unit(),
        }
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
