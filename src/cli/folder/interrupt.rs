//! Ctrl-C: the folders that were made for a command that does not end are removed.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

use super::locked::clean;

/// The folders that are taken, with those that were made for each.
static TAKEN: Mutex<Vec<(PathBuf, Vec<PathBuf>)>> = Mutex::new(Vec::new());

/// Exit code of a process that a signal has ended, as shells have it for Ctrl-C.
const INTERRUPTED: i32 = 130;

fn taken() -> MutexGuard<'static, Vec<(PathBuf, Vec<PathBuf>)>> {
    TAKEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Notes that a folder is taken. An interrupted process removes `made`, if no result is in them.
pub fn note(folder: &Path, made: &[PathBuf]) {
    static HANDLER: Once = Once::new();
    HANDLER.call_once(|| {
        // Without a handler the folders stay, and the next run takes them.
        let _ = ctrlc::set_handler(|| {
            let taken = taken();
            taken.iter().for_each(|(folder, made)| clean(folder, made));
            std::process::exit(INTERRUPTED);
        });
    });
    taken().push((folder.to_owned(), made.to_vec()));
}

/// Forgets a folder.
pub fn forget(folder: &Path) {
    taken().retain(|(known, _)| known != folder);
}

/// Lets nothing interrupt what is done: a signal waits until it is.
pub fn uninterrupted<T>(what: impl FnOnce() -> T) -> T {
    let _held = taken();
    what()
}
