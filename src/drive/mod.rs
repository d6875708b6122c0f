//! Command to torque, and state to reading: motor, amplifier, encoder, velocity and current sensor.

mod current;
mod data;
pub mod encoder;
pub mod noise;
pub mod power;

pub use data::{Amplifier, CurrentSensor, Encoder, LinkEncoder, Motor, Sensing, VelocitySensor};
pub use encoder::{Counter, Stretch, VelocityMeter};
pub use noise::Noise;
pub use power::{PowerStage, Winding};
