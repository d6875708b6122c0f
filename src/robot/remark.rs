//! Remarks of a reader: what it takes otherwise than it stands in the file.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::error::{Place, shown};

/// [characters] Longest text of a remark. Two tensors of six numbers each have 250.
const LONGEST: usize = 1200;

/// A value of a file that is accepted, but taken otherwise than it stands there, with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// The file.
    pub file: PathBuf,
    /// Where in it.
    pub place: Place,
    /// What it is about: `link forearm`.
    pub about: String,
    /// What is taken otherwise, and how.
    pub text: String,
}

impl Remark {
    /// A remark about a place in a file. Names and values of the file are shortened and escaped as in an error.
    pub fn new(file: &Path, place: Place, about: &str, text: &str) -> Self {
        Self { file: file.to_owned(), place, about: shown(about, LONGEST), text: shown(text, LONGEST) }
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}: {}: {}", self.file.display(), self.place, self.about, self.text)
    }
}
