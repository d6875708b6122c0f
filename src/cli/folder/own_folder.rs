//! lostmotion's own folder in a results folder: the names in it, and how it is cleared.

use std::fs;
use std::path::{Path, PathBuf};

/// Name of the folder.
pub const OWN: &str = ".lostmotion";
/// The list of the files that lostmotion wrote.
pub const LIST: &str = "files.json";
/// The file that is locked while a command uses the results folder.
pub const LOCK: &str = "lock";
/// The folder of new files until they are moved into place.
pub const NEW: &str = "new";

/// Removes the staged files of a folder that were not moved into place; if no result was ever written, also the folders
/// that were created. What cannot be removed is left to the next run.
pub fn clean(folder: &Path, made: &[PathBuf]) {
    let own = folder.join(OWN);
    let _ = fs::remove_dir_all(own.join(NEW));
    if !own.join(LIST).exists() {
        let _ = fs::remove_file(own.join(LOCK));
        let _ = fs::remove_dir(&own);
    }
    remove_empty(made);
}

/// Removes empty folders, the innermost first.
pub fn remove_empty(folders: &[PathBuf]) {
    for folder in folders.iter().rev() {
        let _ = fs::remove_dir(folder);
    }
}
