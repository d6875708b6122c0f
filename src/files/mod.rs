//! Files by their paths: those on the disk, and those of the catalogue that the binary carries.
//!
//! What reads a model, a scenario, a manifest or a URDF reads it here, so that the catalogue needs no place on the disk.

pub mod catalogue;
mod name;
pub mod regular;

use std::io;
use std::path::Path;

pub use name::{FIT_NAME, is_fit_name};

/// The content of a file of the catalogue; `None` for a path of the disk.
///
/// # Errors
/// The catalogue has no such file.
pub fn embedded(path: &Path) -> Option<io::Result<Vec<u8>>> {
    let name = catalogue::path_in(path)?;
    Some(catalogue::content(&name).map(<[u8]>::to_vec).ok_or_else(|| io::ErrorKind::NotFound.into()))
}

/// Whether a path leads to anything: what is no regular file is refused where it is read, by what it is.
pub fn exists(path: &Path) -> bool {
    is_file(path) || path.exists()
}

/// Whether a path leads to a file.
pub fn is_file(path: &Path) -> bool {
    match catalogue::path_in(path) {
        Some(name) => catalogue::content(&name).is_some(),
        None => path.is_file(),
    }
}
