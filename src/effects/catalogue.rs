//! The effects that a program knows: those of this crate, and those that other crates add.

use std::fmt;

use super::{AtTurns, CATALOGUE, Diagnosable, Effect};

/// Effects by name, in alphabetical order. By default those of this crate.
#[derive(Clone)]
pub struct Catalogue(Vec<&'static dyn Effect>);

impl Default for Catalogue {
    fn default() -> Self {
        Self(CATALOGUE.to_vec())
    }
}

impl Catalogue {
    /// An empty catalogue.
    pub const fn empty() -> Self {
        Self(Vec::new())
    }

    /// With one more effect; it replaces one of the same name.
    #[must_use]
    pub fn with(mut self, effect: &'static dyn Effect) -> Self {
        self.0.retain(|known| known.name() != effect.name());
        self.0.push(effect);
        self.0.sort_by_key(|effect| effect.name());
        self
    }

    /// Without the effect of a given name.
    #[must_use]
    pub fn without(mut self, name: &str) -> Self {
        self.0.retain(|known| known.name() != name);
        self
    }

    /// All effects.
    pub fn iter(&self) -> impl Iterator<Item = &'static dyn Effect> + '_ {
        self.0.iter().copied()
    }

    /// The effect of a given name.
    pub fn find(&self, name: &str) -> Option<&'static dyn Effect> {
        self.iter().find(|effect| effect.name() == name)
    }

    /// Effects that a diagnosis can identify by torque.
    pub fn diagnosable(&self) -> impl Iterator<Item = &'static dyn Diagnosable> + '_ {
        self.iter().filter_map(|effect| effect.diagnosable())
    }

    /// Effects that a diagnosis can identify at the reversals of a joint.
    pub fn at_turns(&self) -> impl Iterator<Item = &'static dyn AtTurns> + '_ {
        self.iter().filter_map(|effect| effect.at_turns())
    }
}

impl fmt::Debug for Catalogue {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_list().entries(self.iter().map(|effect| effect.name())).finish()
    }
}

/// A catalogue of these effects only; of several effects of one name, the last is kept.
impl FromIterator<&'static dyn Effect> for Catalogue {
    fn from_iter<I: IntoIterator<Item = &'static dyn Effect>>(effects: I) -> Self {
        effects.into_iter().fold(Self(Vec::new()), Self::with)
    }
}

/// Equal names.
impl PartialEq for Catalogue {
    fn eq(&self, other: &Self) -> bool {
        self.iter().map(|effect| effect.name()).eq(other.iter().map(|effect| effect.name()))
    }
}
