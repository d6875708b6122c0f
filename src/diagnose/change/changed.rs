//! An effect that is there in some sessions only: its columns are zero in all others.
//!
//! Everything that an effect says of torque along the motion is passed on. The phenomena that it claims are not: a phenomenon of both
//! recordings is no change.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use crate::effects::{About, Action, Diagnosable, Effect, Harmonic, Motion};
use crate::error::Result;
use crate::robot::Model;

/// An effect within a range of sessions.
pub struct Changed {
    effect: &'static dyn Diagnosable,
    about: &'static About,
    sessions: Range<usize>,
}

/// What the name of an effect begins with where it is meant as a change.
const PREFIX: &str = "change of ";

/// Those that were ever asked for: an effect is known for as long as the program runs, and so is each of its restrictions.
static KNOWN: Mutex<Vec<&'static Changed>> = Mutex::new(Vec::new());

/// An effect in these sessions alone.
pub fn within(effect: &'static dyn Diagnosable, sessions: Range<usize>) -> &'static Changed {
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let same = |other: &&&Changed| {
        std::ptr::addr_eq(other.effect, effect) && other.effect.name() == effect.name() && other.sessions == sessions
    };
    if let Some(found) = known.iter().find(same) {
        return found;
    }
    let name = Box::leak(named_as_change(effect.name()).into_boxed_str());
    let about = Box::leak(Box::new(About { name, ..*effect.about() }));
    let made: &'static Changed = Box::leak(Box::new(Changed { effect, about, sessions }));
    known.push(made);
    made
}

/// The name of an effect that is meant as a change.
pub fn named_as_change(name: &str) -> String {
    format!("{PREFIX}{name}")
}

/// The name without what marks it as a change.
pub fn plain_name(name: &str) -> &str {
    name.strip_prefix(PREFIX).unwrap_or(name)
}

impl Changed {
    /// Columns that are zero in all other sessions.
    fn within(&self, motion: &Motion, mut columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        for column in &mut columns {
            let cells = column.iter_mut().zip(&motion.session);
            cells.filter(|(_, session)| !self.sessions.contains(*session)).for_each(|(value, _)| *value = 0.0);
        }
        columns
    }
}

impl Effect for Changed {
    fn about(&self) -> &'static About {
        self.about
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        self.effect.install(model, joint, given)
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for Changed {
    fn applies(&self, motion: &Motion, joint: usize) -> bool {
        self.effect.applies(motion, joint)
    }

    fn shapes(&self, motion: &Motion, joint: usize) -> Vec<Vec<f64>> {
        self.effect.shapes(motion, joint)
    }

    fn refines(&self) -> bool {
        self.effect.refines()
    }

    /// Changes are sought in wide rows.
    fn harmonic(&self) -> Option<Harmonic> {
        self.effect.harmonic().map(|harmonic| Harmonic { in_narrow_rows: None, ..harmonic })
    }

    fn loads_link(&self) -> bool {
        self.effect.loads_link()
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        self.within(motion, self.effect.columns(motion, joint, shape))
    }

    fn refined_shapes(&self, shape: &[f64]) -> usize {
        self.effect.refined_shapes(shape)
    }

    fn torque_factor(&self, parameters: &[f64]) -> f64 {
        self.effect.torque_factor(parameters)
    }

    fn angles_of_link(&self) -> &'static [&'static str] {
        self.effect.angles_of_link()
    }

    fn is_itself(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> bool {
        self.effect.is_itself(motion, joint, shape, coefficients)
    }

    fn reading_at_rest(&self, coefficients: &[f64]) -> f64 {
        self.effect.reading_at_rest(coefficients)
    }

    fn parameters(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        self.effect.parameters(motion, joint, shape, coefficients)
    }
}
