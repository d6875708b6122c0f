#![doc = include_str!("../README.md")]
#![allow(rustdoc::broken_intra_doc_links, reason = "units stand in brackets: [rad], [s]")]

/// The command line.
pub mod cli;
/// References and controllers.
pub mod control;
/// Measured data.
pub mod dataset;
/// What the simulation gets wrong, and why.
pub mod diagnose;
/// The normal and Student's t distribution.
pub mod distributions;
/// Motors, power stages and sensors.
pub mod drive;
/// Inverse dynamics, mass matrix, bias and gravity.
pub mod dynamics;
/// The catalogue of effects that a nominal model can lack.
pub mod effects;
/// Errors, with positions and numbers.
pub mod error;
/// Files on disk and in the catalogue, and valid file names.
pub mod files;
/// Fourier transforms at even and uneven times.
pub mod fourier;
/// Friction and dead zone between rotor and link.
pub mod gearhead;
/// Friction and backlash from data.
pub mod identify;
/// How probable recordings are under a model.
pub mod likelihood;
/// Linear algebra of least squares.
pub mod linear;
/// The simulated machine on rapier.
pub mod plant;
/// Simulates a model under recorded inputs, for comparison with the recording.
pub mod replay;
/// JSON, HTML and Rerun.
pub mod report;
/// URDF tree, inertias, model file.
pub mod robot;
/// Runs composed from the above.
pub mod scenario;
/// Sampled signals, measured or simulated.
pub mod timeseries;
/// TOML files with lines, ranges and nearest keys in their errors.
pub mod toml_input;
/// Units of everything in memory and in files.
pub mod units;
