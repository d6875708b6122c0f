//! The simulated machine: against closed forms, an independent reference and published results, and beyond reason.

#[path = "../support/closed_loop.rs"]
mod closed_loop;
#[path = "../support/engines.rs"]
mod engines;
#[path = "../support/exactness.rs"]
mod exactness;
#[path = "../support/machines.rs"]
mod machines;
#[path = "../support/reference.rs"]
mod reference;

mod classics;
mod exact;
mod extremes;
mod last_word;
mod links_alike;
mod published;
mod robots;
