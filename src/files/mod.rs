//! Files by their paths: files on disk, and files of the catalogue that is embedded in the binary.
//!
//! All readers of models, scenarios, manifests and URDFs read through this module, so the catalogue needs no place on
//! the disk.

pub mod catalogue;
mod name;
pub mod regular;

use std::io;
use std::path::Path;

pub use name::{FIT_NAME, PLAIN_NAME, is_control, is_fit_name, is_plain_name};

/// The content of a file of the catalogue; `None` for a path on disk.
///
/// # Errors
/// The catalogue has no such file.
pub fn embedded(path: &Path) -> Option<io::Result<Vec<u8>>> {
    let name = catalogue::path_in(path)?;
    Some(catalogue::content(&name).map(<[u8]>::to_vec).ok_or_else(|| io::ErrorKind::NotFound.into()))
}

/// Whether a path exists. A path that is not a regular file is refused by its reader, with the reason.
pub fn exists(path: &Path) -> bool {
    is_file(path) || path.exists()
}

/// Whether a path is a file.
pub fn is_file(path: &Path) -> bool {
    match catalogue::path_in(path) {
        Some(name) => catalogue::content(&name).is_some(),
        None => path.is_file(),
    }
}
