//! The simulated machine: links in rapier's world, rotors, gears, drives and sensors in joint space.
//!
//! The only place that names rapier3d.
