//! What the program does to files: it replaces those that it wrote and no others, whatever names its input bears, whatever stands at
//! `--out`, and at whatever moment it is killed. Links, devices and signals
//! are those of Unix.
#![cfg(unix)]

#[path = "../support/files/mod.rs"]
mod support;

mod fixture;
mod kills;
mod names;
mod owned;
mod places;
