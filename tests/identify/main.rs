//! Friction and gap from signals of the motor's side: planted values recovered, by this project's methods and by those of the literature.

#[path = "../generator/mod.rs"]
mod generator;

mod backlash;
mod friction;
mod methods;
mod published;
