//! Remarks of a reader: values of a file that it accepts but does not take as written.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::error::{Place, shown};

/// [characters] Longest text of a remark. Two tensors of six numbers each take 250.
const LONGEST: usize = 1200;

/// A value of a file that is accepted but not taken as written, with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// The file.
    pub file: PathBuf,
    /// Place in the file.
    pub place: Place,
    /// What the remark is about, such as `link forearm`.
    pub about: String,
    /// Which value is not taken as written, and what is used instead.
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
