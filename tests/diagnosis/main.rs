//! Diagnoses, predictions and identifications of simulated machines, and of recordings made for a purpose: one program, so that long tests
//! share the processor.

#[path = "../support/drawn/arm.rs"]
mod arm;
#[path = "../support/drawn/drawn.rs"]
mod drawn;
#[path = "../support/drawn/hidden.rs"]
mod hidden;
#[path = "../support/drawn/machine.rs"]
mod machine;
#[path = "../support/machines.rs"]
mod machines;
#[path = "../support/drawn/motion.rs"]
mod motion;
#[path = "../support/drawn/record.rs"]
mod record;
#[path = "../support/rigid_arm.rs"]
mod rigid_arm;
#[path = "../support/rough.rs"]
mod rough;
#[path = "../support/drawn/sampling.rs"]
mod sampling;
#[path = "../../benches/blind/share.rs"]
#[allow(dead_code, reason = "its text is the bench's")]
mod share;
#[path = "../support/sines.rs"]
mod sines;
#[path = "../support/six_joints.rs"]
mod six_joints;
#[path = "../support/drawn/strengths.rs"]
mod strengths;
#[path = "../support/told.rs"]
mod told;

mod arm_of_six;
mod counterbalance;
mod designed;
mod determinism;
mod diagnose;
mod drawn_sets;
mod drive_command;
mod gaps;
mod hidden_gaps;
mod judged;
mod listed_effects;
mod masked;
mod odd_recordings;
mod prediction;
mod regularised_friction;
mod rough_models;
mod scenario;
mod separability;
mod ties;
mod truth;
mod uneven_lines;
mod uneven_times;
mod unknown_values;
mod velocity_lag;
mod verdicts;
