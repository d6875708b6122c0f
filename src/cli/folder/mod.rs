//! The folder of results: which files a command may replace there, and how they are written.
//!
//! `.lostmotion/files.json` in the folder lists the files that lostmotion wrote, with the SHA-256 of their content. A file that is not
//! listed, or whose content has changed, belongs to the user: it is neither replaced nor removed, and a command that would have to is
//! refused before its work. So is one that would replace a file that it reads.
//!
//! New files are written and synced in `.lostmotion/new`, listed beside the earlier ones, and then renamed one by one. Wherever a
//! process is killed, every file is as it was or as it is to be, never half and never missing, and the next run removes what is left in
//! `.lostmotion/new`. A lock keeps a second process out of the folder from before the work until after it. A process that is
//! interrupted by Ctrl-C writes to the end what it has begun to write, and removes the folders that it made for nothing.

mod interrupt;
mod locked;
mod written;

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Place, Result};
use crate::files::{FIT_NAME, is_fit_name};
use crate::report::files::File;

use interrupt::uninterrupted;
use locked::LockedFolder;
use written::{Written, sha256_of};

/// What a command is about to write, and what it reads.
#[derive(Debug, Default)]
pub struct Request<'a> {
    /// The verb of the command, `replay`.
    pub verb: &'static str,
    /// Name of the folder below `out` where none is given.
    pub name: &'a str,
    /// Names of the files that it may write.
    pub files: Vec<String>,
    /// The files that it reads.
    pub inputs: Vec<PathBuf>,
}

/// A folder in which a command may write its results. It exists and is locked for as long as this value lives; one that was made for a
/// command that fails is removed with the value.
#[derive(Debug)]
pub struct Folder {
    place: LockedFolder,
    verb: &'static str,
    /// The files that the command reads, without links.
    inputs: Vec<PathBuf>,
}

/// Where results stand.
#[derive(Debug)]
pub struct Results {
    /// Their folder.
    pub folder: PathBuf,
    /// Why it is not the folder that was asked for.
    pub moved: Option<Error>,
}

impl Folder {
    /// Makes and locks `out`, or `out/<name>` where none is given (`out/<name>_<verb>` where that one holds a file that the command
    /// reads), and refuses a place where the planned files cannot be written. Called before the work starts, so that no long run
    /// ends in a refusal.
    ///
    /// # Errors
    /// The place is no folder, cannot be made or written, or another process writes there; a planned file stands there that
    /// lostmotion did not write, that was changed since, or that the command reads.
    pub fn reserve(out: Option<&Path>, request: Request<'_>) -> Result<Self> {
        let inputs: Vec<PathBuf> = request.inputs.iter().filter_map(|file| file.canonicalize().ok()).collect();
        let folder = out.map_or_else(|| usual(&request, &inputs), Path::to_owned);
        let folder = Self { place: LockedFolder::take(&folder)?, verb: request.verb, inputs };
        folder.check(&request.files)?;
        folder.place.probe()?;
        Ok(folder)
    }

    /// Writes the files and removes those of an earlier result of the same verb that the new one lacks. Where that cannot be done,
    /// because the folder has changed while the command worked, they go into a new folder beside it: `<folder>-2` or the next that
    /// is free.
    ///
    /// # Errors
    /// No folder takes the files.
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

    /// What lostmotion wrote here, if these files are among it or not there at all.
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

    /// Writes the files over what may be replaced.
    fn replace(&self, written: &Written, files: &[File<'_>]) -> Result<()> {
        let sums = self.place.stage(files)?;
        let new = Written::of(self.verb, &sums);
        // From here to the end both contents are listed as written by lostmotion.
        written.with(&new).save(&self.place)?;
        self.place.swap(&sums)?;
        let kept = written.except(&new);
        let stale = kept.names_by(self.verb).filter(|name| self.may_remove(&kept, name));
        let gone: Vec<String> = stale.map(str::to_owned).collect();
        self.place.remove(&gone)?;
        kept.without(&gone).with(&new).save(&self.place)
    }

    /// Whether a file of an earlier result is still as it was written, and not read by this command.
    fn may_remove(&self, written: &Written, name: &str) -> bool {
        let path = self.place.folder().join(name);
        let unchanged = || sha256_of(&path).is_ok_and(|sum| written.holds(name, &sum));
        path.symlink_metadata().is_ok_and(|found| found.is_file()) && !self.inputs.contains(&path) && unchanged()
    }
}

/// `out/<name>`, or `out/<name>_<verb>` where that folder holds a file that the command reads.
fn usual(request: &Request<'_>, inputs: &[PathBuf]) -> PathBuf {
    let folder = Path::new("out").join(request.name);
    let read_here = |folder: PathBuf| inputs.iter().any(|file| file.parent() == Some(&folder));
    if fs::canonicalize(&folder).is_ok_and(read_here) {
        return Path::new("out").join(format!("{}_{}", request.name, request.verb));
    }
    folder
}

/// Refuses names that lead out of the folder, and two that some file systems take for one.
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
