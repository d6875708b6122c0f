//! Error figures of a replay: RMS differences after the same low-pass on both sides.
//!
//! On both sides, velocity is the derivative of the smoothed position, so the machine's own velocity measurement need
//! not be known.

use super::inputs::Input;
use super::low_pass::low_pass;
use super::{ChannelError, Observable, Simulated};
use crate::robot::JointModel;
use crate::timeseries::{Channel, Clock, root_mean_square};
use crate::units::JointKind;

/// One signal of a joint, as recorded and as simulated. Joint side, SI.
#[derive(Debug)]
pub struct Side<'a> {
    /// The joint.
    pub joint: &'a str,
    /// The signals.
    pub quantity: Observable,
    /// Their unit.
    pub unit: &'static str,
    /// [s] sample times of both.
    pub time: &'a [f64],
    /// As recorded.
    pub recorded: &'a [f64],
    /// As simulated.
    pub simulated: &'a [f64],
}

/// The differences of position, torque and velocity of one joint. `see` gets both sides of each, and returns whether
/// their difference is kept.
pub(super) fn compare(
    joint: &JointModel,
    input: &Input,
    simulated: Simulated,
    clock: &Clock,
    cutoff: f64,
    see: &mut dyn FnMut(&Side<'_>) -> bool,
) -> Vec<ChannelError> {
    let smooth = |values: &[f64]| low_pass(values, clock, cutoff);
    let mut see = |quantity: Observable, recorded: &[f64], simulated: &[f64]| {
        let unit = quantity.unit(joint.kind);
        see(&Side { joint: &joint.name, quantity, unit, time: clock.time(), recorded, simulated })
    };
    let error = |quantity: Observable, recorded: &[f64], simulated: &[f64], kept: bool| {
        let difference: Vec<f64> = recorded.iter().zip(simulated).map(|(a, b)| a - b).collect();
        let (rms, level) = (root_mean_square(&difference), root_mean_square(recorded));
        let relative = if level > 0.0 { rms / level } else { 0.0 };
        let unit = quantity.unit(joint.kind);
        let difference = if kept { difference } else { Vec::new() };
        ChannelError { joint: joint.name.clone(), quantity, unit, rms, relative, difference }
    };
    let Simulated { position, torque } = simulated;
    let kept = see(Observable::Position, &input.position, &position);
    let positions = [smooth(&input.position), smooth(&position)];
    drop(position);
    let of_position = error(Observable::Position, &positions[0], &positions[1], kept);
    let recorded = input.torque.values();
    let kept = see(Observable::Torque, &recorded, &torque);
    let recorded = smooth(&recorded);
    let torque = if input.magnitude { torque.iter().map(|torque| torque.abs()).collect() } else { torque };
    let of_torque = error(Observable::Torque, &recorded, &smooth(&torque), kept);
    drop((recorded, torque));

    let velocities = positions.map(|position| rate(&position, clock));
    let kept = see(Observable::Velocity, &velocities[0], &velocities[1]);
    let of_velocity = error(Observable::Velocity, &velocities[0], &velocities[1], kept);
    vec![of_position, of_torque, of_velocity]
}

/// Derivative of a smooth position: that of the parabola through a sample and its neighbours.
fn rate(smooth: &[f64], clock: &Clock) -> Vec<f64> {
    let last = smooth.len().saturating_sub(1);
    let at = |k: usize| {
        let (from, to) = (k.saturating_sub(1), (k + 1).min(last));
        let slope = |from: usize, to: usize| (smooth[to] - smooth[from]) / clock.elapsed(from, to);
        if to <= from {
            0.0
        } else if clock.even || to - from == 1 {
            slope(from, to)
        } else {
            let [before, after] = [clock.elapsed(from, k), clock.elapsed(k, to)];
            (slope(from, k) * after + slope(k, to) * before) / (before + after)
        }
    };
    (0..smooth.len()).map(at).collect()
}

impl Observable {
    /// The channel that holds it.
    pub const fn channel(self) -> Channel {
        match self {
            Self::Position => Channel::Position,
            Self::Velocity => Channel::Velocity,
            Self::Torque => Channel::Torque,
        }
    }

    /// Its unit on a joint that turns or slides.
    pub const fn unit(self, kind: JointKind) -> &'static str {
        match self {
            Self::Position => kind.position_unit(),
            Self::Velocity => kind.velocity_unit(),
            Self::Torque => kind.effort_unit(),
        }
    }
}
