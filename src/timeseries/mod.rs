//! Sampled signals of a machine; measured and simulated data have the same type.

mod clock;
mod delayed;
mod drawn;
mod memory;
mod noise;
mod pauses;
mod samples;
mod side_by_side;

use std::collections::BTreeMap;

pub use clock::{Clock, is_uneven_step};
pub use delayed::delayed;
pub use drawn::{Drawn, DrawnJoint, Envelope, pose_step};
pub use memory::give_back_memory;
pub use noise::{root_mean_square, white_noise};
pub use pauses::{pauses, uninterrupted};
pub use samples::Samples;
pub use side_by_side::side_by_side;

/// The quantity of a sampled signal of one joint. All are on the joint side, SI.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// [rad or m] motor encoder divided by the gear ratio, quantised as the encoder is.
    Position,
    /// [rad/s or m/s] velocity as the machine measured it.
    Velocity,
    /// [A] motor current as measured; its magnitude where sensing is absolute.
    Current,
    /// [N·m or N] motor torque on the joint side, if it was recorded instead of a current.
    Torque,
    /// [rad or m] reference.
    ReferencePosition,
    /// [rad/s or m/s] reference.
    ReferenceVelocity,
    /// [A] commanded current of the drive.
    CommandCurrent,
    /// [rad or m] second encoder, on the link.
    LinkPosition,
    /// [N·m or N] torque on the link, measured behind the gear: a joint torque sensor. Neither rotor inertia nor motor-side friction is in it.
    LinkTorque,
    /// [°C] gear or motor temperature.
    Temperature,
    /// [rad or m] true rotor position; simulation only.
    TrueMotorPosition,
    /// [rad/s or m/s] true rotor velocity; simulation only.
    TrueMotorVelocity,
    /// [rad or m] true position of the gear's output: that of the link, or `C q` where axes are coupled; simulation only.
    TrueLinkPosition,
    /// [rad/s or m/s] its velocity; simulation only.
    TrueLinkVelocity,
    /// [A] true motor current; simulation only.
    TrueCurrent,
    /// [N·m or N] torque through the gear, positive drives the link positively; simulation only.
    GearTorque,
    /// [1] contact of the gear: +1 positive flank, 0 in the gap, −1 negative flank; simulation only.
    Contact,
}

/// The channels of one joint, each as long as the time vector it belongs to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointSeries {
    /// Name of the joint in the URDF.
    pub name: String,
    /// The recorded signals.
    pub channels: BTreeMap<Channel, Samples>,
}

impl JointSeries {
    /// The samples of a channel, or `None` if it was not recorded.
    pub fn get(&self, channel: Channel) -> Option<&[f64]> {
        self.channels.get(&channel).map(|samples| samples.as_slice())
    }
}

/// One session: signals with common sample times.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TimeSeries {
    /// Name of the session; for recorded data, the file's stem.
    pub name: String,
    /// [s] Strictly increasing sample times.
    pub time: Vec<f64>,
    /// The joints that were recorded.
    pub joints: Vec<JointSeries>,
}

impl TimeSeries {
    /// The joint of that name.
    pub fn joint(&self, name: &str) -> Option<&JointSeries> {
        self.joints.iter().find(|joint| joint.name == name)
    }

    /// Drops the channels that are not in the list.
    pub fn keep(&mut self, wanted: &[Channel]) {
        for joint in &mut self.joints {
            joint.channels.retain(|channel, _| wanted.contains(channel));
        }
    }

    /// The session with samples of its own, so that what it was a part of can be freed.
    #[must_use]
    pub fn on_its_own(mut self) -> Self {
        for samples in self.joints.iter_mut().flat_map(|joint| joint.channels.values_mut()) {
            *samples = samples.to_vec().into();
        }
        self
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// [s] Median sample interval; 0 with fewer than two samples.
    pub fn sample_interval(&self) -> f64 {
        pauses::median_step(&self.time)
    }
}

/// An estimated quantity with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// Estimated value, SI.
    pub value: f64,
    /// Standard error, same unit.
    pub std_error: f64,
}
