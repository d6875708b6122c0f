//! Figures of a replay: RMS differences after the same low-pass on both sides.

use super::inputs::Input;
use super::low_pass::low_pass;
use super::{ChannelError, Quantity};
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};

/// The differences of position and torque, joint by joint.
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
        let pairs = [
            (Quantity::Position, Channel::Position, joint.kind.position_unit()),
            (Quantity::Torque, Channel::Torque, joint.kind.effort_unit()),
        ];
        for (quantity, channel, unit) in pairs {
            let (Some(measured), Some(model)) = (recorded.joints[i].get(channel), simulated.joints[i].get(channel))
            else {
                continue;
            };
            let magnitude = quantity == Quantity::Torque && inputs[i].magnitude;
            let model: Vec<f64> = model.iter().map(|value| if magnitude { value.abs() } else { *value }).collect();
            let (measured, model) = (low_pass(measured, interval, cutoff), low_pass(&model, interval, cutoff));
            let rms = rms(measured.iter().zip(&model).map(|(a, b)| a - b));
            let level = self::rms(measured.iter().copied());
            let relative = if level > 0.0 { rms / level } else { 0.0 };
            errors.push(ChannelError { joint: joint.name.clone(), quantity, unit, rms, relative });
        }
    }
    errors
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1);
    (values.map(|value| value * value).sum::<f64>() / count as f64).sqrt()
}
