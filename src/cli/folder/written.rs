//! The list of files that lostmotion wrote in a folder.

use std::collections::BTreeMap;
use std::io;

use serde::{Deserialize, Serialize};

use super::locked::LockedFolder;
use crate::error::{Error, Place, Result};
use crate::files::is_fit_name;

/// Schema of the list.
const SCHEMA: &str = "lostmotion/files/1";

/// Explanation at the head of the list.
const ABOUT: &str = "Files in the folder above that lostmotion wrote, with the SHA-256 of their content. Only these files are replaced, \
                     and only if they have not changed since.";

/// The list, by name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Written {
    schema: String,
    about: String,
    files: BTreeMap<String, Entry>,
}

/// One file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Entry {
    /// The verb that wrote it.
    by: String,
    /// Accepted contents: two while the file is being replaced.
    sha256: Vec<String>,
}

impl Default for Written {
    fn default() -> Self {
        Self { schema: SCHEMA.to_owned(), about: ABOUT.to_owned(), files: BTreeMap::new() }
    }
}

impl Written {
    /// The list of a folder; empty where there is none.
    ///
    /// # Errors
    /// The file cannot be read, or is not such a list.
    pub fn read(place: &LockedFolder) -> Result<Self> {
        let file = place.list();
        let bytes = match std::fs::read(&file) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            bytes => bytes.map_err(|source| Error::file(&file, "read", source))?,
        };
        let list = serde_json::from_slice::<Self>(&bytes).ok().filter(|list| list.schema == SCHEMA);
        list.filter(|list| list.files.keys().all(|name| is_fit_name(name))).ok_or_else(|| {
            let expected = format!(
                "a list of files as lostmotion writes it ({SCHEMA}): delete it to keep every file of the folder, or name another \
                 folder with --out"
            );
            Error::input(&file, Place::File, "", "", expected)
        })
    }

    /// The list of files that a verb has just written, each with its SHA-256.
    pub fn of(verb: &str, sums: &[(String, String)]) -> Self {
        let entry = |sum: &String| Entry { by: verb.to_owned(), sha256: vec![sum.clone()] };
        let files = sums.iter().map(|(name, sum)| (name.clone(), entry(sum))).collect();
        Self { files, ..Self::default() }
    }

    /// Replaces the list of a folder.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn save(&self, place: &LockedFolder) -> Result<()> {
        let mut text = serde_json::to_vec_pretty(self).unwrap_or_default();
        text.push(b'\n');
        place.save_list(&text)
    }

    /// Whether a file of this name was written.
    pub fn lists(&self, name: &str) -> bool {
        self.files.contains_key(name)
    }

    /// Whether a file of this name was written with this content.
    pub fn holds(&self, name: &str, sum: &str) -> bool {
        self.files.get(name).is_some_and(|entry| entry.sha256.iter().any(|known| known == sum))
    }

    /// Names of the files that a verb wrote.
    pub fn names_by<'a>(&'a self, verb: &'a str) -> impl Iterator<Item = &'a str> {
        self.files.iter().filter(move |(_, entry)| entry.by == verb).map(|(name, _)| name.as_str())
    }

    /// The union of both lists; a file in both keeps both contents.
    pub fn with(&self, new: &Self) -> Self {
        let mut all = self.clone();
        for (name, entry) in &new.files {
            let known =
                all.files.entry(name.clone()).or_insert_with(|| Entry { by: String::new(), sha256: Vec::new() });
            known.by.clone_from(&entry.by);
            for sum in &entry.sha256 {
                if !known.sha256.contains(sum) {
                    known.sha256.push(sum.clone());
                }
            }
        }
        all
    }

    /// The files that another list lacks.
    pub fn except(&self, other: &Self) -> Self {
        let mut rest = self.clone();
        rest.files.retain(|name, _| !other.lists(name));
        rest
    }

    /// The list without these files.
    pub fn without(&self, names: &[String]) -> Self {
        let mut rest = self.clone();
        rest.files.retain(|name, _| !names.contains(name));
        rest
    }
}
