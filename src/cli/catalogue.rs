//! The robots and scenarios that the binary carries.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Place, Result};

/// Path in the project and content of every file under `robots/` and `scenarios/`.
pub static FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/catalogue.rs"));

/// Names of the folders of `kind` (`robots`, `scenarios`) that hold a file `file`, in alphabetical order.
pub fn names(kind: &str, file: &str) -> Vec<&'static str> {
    let entry = |path: &'static str| path.strip_prefix(kind)?.strip_prefix('/')?.strip_suffix(file)?.strip_suffix('/');
    FILES.iter().filter_map(|(path, _)| entry(path)).filter(|name| !name.contains('/')).collect()
}

/// The text of a file of the catalogue.
pub fn text(path: &str) -> Option<&'static str> {
    let (_, content) = FILES.iter().find(|(name, _)| *name == path)?;
    std::str::from_utf8(content).ok()
}

/// The catalogue on disk for as long as this value lives.
#[derive(Debug)]
pub struct Unpacked(PathBuf);

impl Unpacked {
    /// Writes the catalogue into a new folder among the temporary files.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn new() -> Result<Self> {
        let folder = std::env::temp_dir().join(format!("lostmotion-{}", std::process::id()));
        let unpacked = Self(folder);
        for (name, content) in FILES {
            let path = unpacked.0.join(name);
            let parent = path.parent().unwrap_or(&unpacked.0);
            fs::create_dir_all(parent).map_err(|source| Error::file(parent, "create folder", source))?;
            fs::write(&path, content).map_err(|source| Error::file(&path, "write", source))?;
        }
        Ok(unpacked)
    }

    /// The folder that holds `robots/` and `scenarios/`.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Unpacked {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A file that the user named, or the catalogue's file of that name, unpacked.
#[derive(Debug)]
pub struct Source {
    /// The file.
    pub path: PathBuf,
    /// Keeps the unpacked catalogue alive.
    _unpacked: Option<Unpacked>,
}

impl Source {
    /// `given` where it is a file or a folder that holds `file`; else `<kind>/<given>/<file>` of the catalogue.
    ///
    /// # Errors
    /// There is neither.
    pub fn find(given: &Path, kind: &str, file: &str) -> Result<Self> {
        if given.is_dir() && given.join(file).is_file() {
            return Ok(Self { path: given.join(file), _unpacked: None });
        }
        if given.exists() {
            return Ok(Self { path: given.to_owned(), _unpacked: None });
        }
        let known = names(kind, file);
        let Some(name) = known.iter().find(|name| Path::new(name) == given) else {
            let expected = format!("an existing file, or one of the {kind}: {}", known.join(", "));
            return Err(Error::input(given, Place::File, "", "", expected));
        };
        let unpacked = Unpacked::new()?;
        Ok(Self { path: unpacked.path().join(kind).join(name).join(file), _unpacked: Some(unpacked) })
    }
}
