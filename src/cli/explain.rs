//! `lostmotion explain EFFECT`.

use clap::Args;

use crate::error::{Error, Place, Result};

use super::Outcome;

/// Explain an effect: equation, signature, look-alikes, and the experiment that separates them
#[derive(Debug, Args)]
pub struct Explain {
    /// Name of the catalogue: `lostmotion list effects`
    effect: String,
}

impl Explain {
    /// Prints what the catalogue knows of the effect.
    pub fn run(self) -> Result<Outcome> {
        Err(Error::input(
            "command line".as_ref(),
            Place::File,
            "EFFECT",
            self.effect,
            "a name of the catalogue: `lostmotion list effects`",
        ))
    }
}
