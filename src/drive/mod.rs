//! Command to torque, and state to reading: motor, amplifier, encoder, velocity and current sensor.

mod data;

pub use data::{Amplifier, CurrentSensor, Encoder, Motor, Sensing, VelocitySensor};
