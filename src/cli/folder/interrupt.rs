//! Ctrl-C: removes the folders that were created for an interrupted command.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

use super::own_folder::clean;

/// The folders in use, with the folders that were created for each.
static TAKEN: Mutex<Vec<(PathBuf, Vec<PathBuf>)>> = Mutex::new(Vec::new());

/// Exit code of a process that was ended by a signal, as shells use it for Ctrl-C.
const INTERRUPTED: i32 = 130;

fn taken() -> MutexGuard<'static, Vec<(PathBuf, Vec<PathBuf>)>> {
    TAKEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Registers a folder in use. If the process is interrupted, `made` is removed unless it contains a result.
pub fn note(folder: &Path, made: &[PathBuf]) {
    static HANDLER: Once = Once::new();
    HANDLER.call_once(|| {
        // Without a handler the folders stay, and the next run uses them.
        let _ = ctrlc::set_handler(|| {
            let taken = taken();
            taken.iter().for_each(|(folder, made)| clean(folder, made));
            std::process::exit(INTERRUPTED);
        });
    });
    taken().push((folder.to_owned(), made.to_vec()));
}

/// Removes a folder from the register.
pub fn forget(folder: &Path) {
    taken().retain(|(known, _)| known != folder);
}

/// Runs work that must not be interrupted: a signal waits until it is done.
pub fn uninterrupted<T>(what: impl FnOnce() -> T) -> T {
    let _held = taken();
    what()
}
