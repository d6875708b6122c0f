//! The parts of a step: what is held during it, its two ends, and a state inside it.

use super::coupled::Coupled;
use super::joint::{Phase, Power};
use super::machine::{Machine, Source};
use super::mode::Margins;
use super::state::{Situation, State};

/// What is held during an interval between two evaluations.
#[derive(Debug, Clone, Copy)]
pub struct Held<'a> {
    /// [A] one per joint.
    pub commands: &'a [f64],
    /// Where the links' response comes from.
    pub source: Source,
}

/// A step or the part of it up to an event.
pub struct Step<'a> {
    /// [s] start and end.
    pub time: [f64; 2],
    /// State at start and end, one per joint.
    pub joints: [&'a [Phase]; 2],
}

/// Derivative and margins at the start or the end of a step.
pub(super) struct Endpoint {
    /// Derivative of the state, one per joint.
    pub rate: Vec<Phase>,
    /// Power that flows.
    pub power: Power,
    /// One per joint.
    pub margins: Vec<Margins>,
    /// Those of the near barriers, each with its index.
    pub barrier_margins: Vec<(usize, f64)>,
}

impl Endpoint {
    /// For so many joints and barriers.
    pub fn new(joints: usize, barriers: usize) -> Self {
        Self {
            rate: vec![Phase::default(); joints],
            power: Power::default(),
            margins: vec![Margins([f64::INFINITY; 4]); joints],
            barrier_margins: Vec::with_capacity(barriers),
        }
    }

    /// Derivative and margins under the response found last.
    pub fn take(&mut self, machine: &mut Machine, at: &Situation, touching: &[bool]) {
        self.power = machine.derivative(at, &mut self.rate);
        self.take_margins(&machine.coupled, at, touching);
    }

    /// Margins at the last derivative.
    pub fn take_margins(&mut self, coupled: &Coupled, at: &Situation, touching: &[bool]) {
        coupled.margins(at, &mut self.margins);
        self.barrier_margins.clear();
        self.barrier_margins.extend(coupled.barriers.margins(touching));
    }
}

/// A step that was tried: what it starts from, and its length.
#[derive(Clone, Copy)]
pub(super) struct Tried<'a> {
    /// At the start.
    pub state: &'a State,
    /// What is held.
    pub held: &'a Held<'a>,
    /// `h` [s].
    pub h: f64,
}

/// Working memory to evaluate a state inside a step.
pub(super) struct Probe {
    /// The state, one per joint.
    pub joints: Vec<Phase>,
    /// Its derivative.
    pub rate: Vec<Phase>,
    /// One per joint.
    pub margins: Vec<Margins>,
}

impl Probe {
    /// For so many joints.
    pub fn new(joints: usize) -> Self {
        let phases = || vec![Phase::default(); joints];
        Self { joints: phases(), rate: phases(), margins: vec![Margins([f64::INFINITY; 4]); joints] }
    }
}
