//! Files by their paths: those on the disk, and those of the catalogue that the binary carries.
//!
//! What reads a model, a scenario, a manifest or a URDF reads it here, so that the catalogue needs no place on the disk.

pub mod catalogue;
mod name;

use std::path::Path;
use std::{fs, io};

pub use name::{FIT_NAME, is_fit_name};

/// The content of a file.
///
/// # Errors
/// The operating system refuses, or the catalogue has no such file.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    match catalogue::path_in(path) {
        Some(name) => {
            catalogue::content(&name).map(<[u8]>::to_vec).ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))
        }
        None => fs::read(path),
    }
}

/// Whether a path leads to a file.
pub fn is_file(path: &Path) -> bool {
    match catalogue::path_in(path) {
        Some(name) => catalogue::content(&name).is_some(),
        None => path.is_file(),
    }
}
