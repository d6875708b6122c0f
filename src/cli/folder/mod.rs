//! The results folder: which files a command may replace there, and how they are written.
//!
//! `.lostmotion/files.json` in the folder lists the files that lostmotion wrote, with the SHA-256 of their content. A
//! file that is not listed, or whose content has changed, belongs to the user: it is neither replaced nor removed, and
//! a command that would have to replace it is refused before its work. The same applies to a command that would replace
//! one of its own input files.
//!
//! New files are written and synced in `.lostmotion/new`, added to the list, and then renamed one by one. Whenever a
//! process is killed, every file is either old or new, never incomplete and never missing, and the next run removes the
//! rest of `.lostmotion/new`. A lock keeps other processes out of the folder from before the work until after it. A
//! process that is interrupted by Ctrl-C finishes a write that has begun, and removes the folders that it created
//! without a result.

mod checksum;
mod interrupt;
mod locked;
mod own_folder;
mod written;

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Place, Result};
use crate::files::{FIT_NAME, is_fit_name};
use crate::report::files::File;

use checksum::sha256_of;
use interrupt::uninterrupted;
use locked::LockedFolder;
use written::Written;

/// Files that a command is going to write, and files that it reads.
#[derive(Debug, Default)]
pub struct Request<'a> {
    /// The verb of the command, `replay`.
    pub verb: &'static str,
    /// Name of the folder below `out` if none is given.
    pub name: &'a str,
    /// Names of the files that it may write.
    pub files: Vec<String>,
    /// The files that it reads.
    pub inputs: Vec<PathBuf>,
}

/// A folder in which a command may write its results. It exists and is locked as long as this value lives. If it was
/// created for a command that fails, it is removed with the value.
#[derive(Debug)]
pub struct Folder {
    place: LockedFolder,
    verb: &'static str,
    /// The files that the command reads, with links resolved.
    inputs: Vec<PathBuf>,
}

/// Place of the written results.
#[derive(Debug)]
pub struct Results {
    /// Their folder.
    pub folder: PathBuf,
    /// Why it is not the requested folder.
    pub moved: Option<Error>,
}

impl Folder {
    /// Creates and locks `out`; or `out/<name>` if none is given; or `out/<name>_<verb>` if `out/<name>` contains a
    /// file that the command reads. Refuses a folder in which the planned files cannot be written. It is called before
    /// the work starts, so that no long run ends with a refusal.
    ///
    /// # Errors
    /// The path is not a folder, cannot be created or written, or another process writes there; or a planned file
    /// exists there that lostmotion did not write, that has changed since, or that the command reads.
    pub fn reserve(out: Option<&Path>, request: Request<'_>) -> Result<Self> {
        let inputs: Vec<PathBuf> = request.inputs.iter().filter_map(|file| file.canonicalize().ok()).collect();
        let folder = out.map_or_else(|| usual(&request, &inputs), Path::to_owned);
        let folder = Self { place: LockedFolder::take(&folder)?, verb: request.verb, inputs };
        folder.check(&request.files)?;
        folder.place.probe()?;
        Ok(folder)
    }

    /// Writes the files, and removes those of an earlier result of the same verb that the new one lacks. If this is not
    /// possible because the folder has changed during the work, they are written to a new folder beside it:
    /// `<folder>-2` or the next free name.
    ///
    /// # Errors
    /// No folder accepts the files.
    pub fn write(&self, files: &[File<'_>]) -> Result<Results> {
        let names: Vec<String> = files.iter().map(|(name, _)| name.clone()).collect();
        check_names(&names)?;
        let Err(refused) = self.check(&names).and_then(|written| uninterrupted(|| self.replace(&written, files)))
        else {
            return Ok(Results { folder: self.place.shown().to_owned(), moved: None });
        };
        let Some(place) = self.place.beside() else { return Err(refused) };
        let folder = place.shown().to_owned();
        let other = Self { place, verb: self.verb, inputs: Vec::new() };
        match uninterrupted(|| other.replace(&Written::default(), files)) {
            Ok(()) => Ok(Results { folder, moved: Some(refused) }),
            Err(_) => Err(refused),
        }
    }

    /// The list of files that lostmotion wrote here, if these files are on it or do not exist.
    fn check(&self, names: &[String]) -> Result<Written> {
        let written = Written::read(&self.place)?;
        for name in names {
            let shown = self.place.shown().join(name);
            let path = self.place.folder().join(name);
            let refuse = |expected: &str| Err(Error::input(&shown, Place::File, "", "", expected));
            let found = match path.symlink_metadata() {
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
                found => found.map_err(|source| Error::file(&shown, "read", source))?,
            };
            if self.inputs.contains(&path) {
                return refuse("another folder (--out): this command reads that file and would write over it");
            }
            if !found.is_file() || !written.lists(name) {
                return refuse(
                    "no file of that name: lostmotion wrote none there (.lostmotion/files.json lists what it wrote), so this one \
                     is not replaced. Move it away, or name another folder with --out",
                );
            }
            let sum = sha256_of(&path).map_err(|source| Error::file(&shown, "read", source))?;
            if !written.holds(name, &sum) {
                return refuse(
                    "the file as lostmotion wrote it: it was changed since, so it is not replaced. Rename it to keep it, delete \
                     it, or name another folder with --out",
                );
            }
        }
        Ok(written)
    }

    /// Writes the files over the earlier ones.
    fn replace(&self, written: &Written, files: &[File<'_>]) -> Result<()> {
        let sums = self.place.stage(files)?;
        let new = Written::of(self.verb, &sums);
        // From here to the end, both the old and the new content are listed as written by lostmotion.
        written.with(&new).save(&self.place)?;
        self.place.swap(&sums)?;
        let kept = written.except(&new);
        let stale = kept.names_by(self.verb).filter(|name| self.may_remove(&kept, name));
        let gone: Vec<String> = stale.map(str::to_owned).collect();
        self.place.remove(&gone)?;
        kept.without(&gone).with(&new).save(&self.place)
    }

    /// Whether a file of an earlier result is unchanged, and not read by this command.
    fn may_remove(&self, written: &Written, name: &str) -> bool {
        let path = self.place.folder().join(name);
        let unchanged = || sha256_of(&path).is_ok_and(|sum| written.holds(name, &sum));
        path.symlink_metadata().is_ok_and(|found| found.is_file()) && !self.inputs.contains(&path) && unchanged()
    }
}

/// `out/<name>`, or `out/<name>_<verb>` if that folder contains a file that the command reads.
fn usual(request: &Request<'_>, inputs: &[PathBuf]) -> PathBuf {
    let folder = Path::new("out").join(request.name);
    let read_here = |folder: PathBuf| inputs.iter().any(|file| file.parent() == Some(&folder));
    if fs::canonicalize(&folder).is_ok_and(read_here) {
        return Path::new("out").join(format!("{}_{}", request.name, request.verb));
    }
    folder
}

/// Refuses names that lead out of the folder, and names that are equal on some file systems.
fn check_names(names: &[String]) -> Result<()> {
    let mut seen = std::collections::BTreeSet::new();
    for name in names {
        if !is_fit_name(name) || !seen.insert(name.to_lowercase()) {
            let expected = format!("{FIT_NAME}, different from those of all other files of the results");
            return Err(Error::input("results".as_ref(), Place::File, "name", format!("{name:?}"), expected));
        }
    }
    Ok(())
}
