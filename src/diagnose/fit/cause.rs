//! What a term is of: an effect, or the change of an effect between two recordings.

use std::ops::{Deref, Range};

use crate::effects::{Diagnosable, Motion};

/// An effect in all sessions, or its change: the same effect in some sessions only, its columns zero in all others.
///
/// The phenomena that an effect claims are no part of it: a phenomenon of both recordings is no change.
#[derive(Clone, Copy)]
pub struct Cause {
    effect: &'static dyn Diagnosable,
    /// First session of a change, and the one after its last.
    within: Option<[usize; 2]>,
}

impl Cause {
    /// The change of an effect, in these sessions alone.
    pub fn change(effect: impl Into<Self>, sessions: Range<usize>) -> Self {
        Self { within: Some([sessions.start, sessions.end]), ..effect.into() }
    }

    /// The effect itself, in all sessions.
    pub fn everywhere(self) -> Self {
        Self { within: None, ..self }
    }

    /// Its name in a report: that of the effect, marked where it is a change.
    pub fn label(&self) -> String {
        match self.within {
            None => self.effect.name().to_owned(),
            Some(_) => change_of(self.effect.name()),
        }
    }

    /// Torque on a joint [N·m or N] per unit of each coefficient, as [`Diagnosable::columns`].
    pub fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        let mut columns = self.effect.columns(motion, joint, shape);
        if let Some([first, end]) = self.within {
            for column in &mut columns {
                let cells = column.iter_mut().zip(&motion.session);
                cells.filter(|(_, session)| !(first..end).contains(*session)).for_each(|(value, _)| *value = 0.0);
            }
        }
        columns
    }
}

/// What the name of a change begins with.
const CHANGE: &str = "change of ";

/// The name of an effect that is meant as a change.
pub fn change_of(name: &str) -> String {
    format!("{CHANGE}{name}")
}

/// The name without the mark of a change, where it has one.
pub fn changed(name: &str) -> Option<&str> {
    name.strip_prefix(CHANGE)
}

/// By name, and by the sessions of a change.
impl PartialEq for Cause {
    fn eq(&self, other: &Self) -> bool {
        self.effect.name() == other.effect.name() && self.within == other.within
    }
}

impl Deref for Cause {
    type Target = dyn Diagnosable;

    fn deref(&self) -> &Self::Target {
        self.effect
    }
}

impl From<&'static dyn Diagnosable> for Cause {
    fn from(effect: &'static dyn Diagnosable) -> Self {
        Self { effect, within: None }
    }
}

impl<T: Diagnosable> From<&'static T> for Cause {
    fn from(effect: &'static T) -> Self {
        Self { effect, within: None }
    }
}
