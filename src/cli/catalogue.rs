//! Resolves a name on the command line: a file, or an entry of the catalogue.

use std::path::{Path, PathBuf};

use crate::error::{Error, Place, Result};
use crate::files::catalogue;

/// `given` if it is a file, or the file `file` in a folder; otherwise `<kind>/<given>/<file>` of the catalogue.
///
/// # Errors
/// Neither exists.
pub fn find(given: &Path, kind: &str, file: &str) -> Result<PathBuf> {
    if given.is_dir() && given.join(file).is_file() {
        return Ok(given.join(file));
    }
    if given.exists() {
        return Ok(given.to_owned());
    }
    let known = catalogue::names(kind, file);
    let Some(name) = known.iter().find(|name| Path::new(name) == given) else {
        let expected = format!("an existing file, or one of the {kind}: {}", known.join(", "));
        return Err(Error::input(given, Place::File, "", "", expected));
    };
    Ok(catalogue::path(&format!("{kind}/{name}/{file}")))
}
