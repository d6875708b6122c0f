//! Recordings that files name: beside them, or in a folder of their own.

use std::path::{Path, PathBuf};

use super::Table;
use crate::error::Result;
use crate::files;

/// Environment variable that names the folder of recordings.
const DATA_FOLDER: &str = "LOSTMOTION_DATA";

impl Table<'_> {
    /// The file that `key` names: beside this file, else in the folder of recordings.
    ///
    /// # Errors
    /// It is in neither place; the error says where it is from, if the key `source` does.
    pub fn recording(&self, key: &str, name: &str) -> Result<PathBuf> {
        let beside = self.file().parent().unwrap_or(Path::new("")).join(name);
        if files::is_file(&beside) {
            return Ok(beside);
        }
        let there = std::env::var_os(DATA_FOLDER).map(|folder| Path::new(&folder).join(name));
        let or = match there {
            Some(there) if there.is_file() => return Ok(there),
            Some(there) => there.display().to_string(),
            None => format!("the environment variable {DATA_FOLDER} set to the folder of recordings"),
        };
        let from = self.optional_text("source")?.map_or(String::new(), |source| format!("; it is from {source}"));
        Err(self.error(key, format!("a file {}, or {or}{from}", beside.display())))
    }
}
