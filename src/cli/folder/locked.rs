//! A folder on disk: created, locked, written file by file.

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

use super::checksum::Summed;
use super::interrupt;
use super::own_folder::{LIST, LOCK, NEW, OWN, clean, remove_empty};
use crate::error::{Error, Place, Result};
use crate::report::files::{self as report, Content};

/// Number of attempts to lock, if another process removes the lock at the same time.
const ATTEMPTS: usize = 100;

/// A folder that exists and is locked.
#[derive(Debug)]
pub struct LockedFolder {
    /// The path as the user gave it; used in messages.
    shown: PathBuf,
    /// The path without links.
    folder: PathBuf,
    /// The folders that were created for it, the outermost first.
    made: Vec<PathBuf>,
    /// The lock; open as long as the folder is locked.
    lock: Option<File>,
}

impl LockedFolder {
    /// Creates and locks a folder, and removes what a killed process left there.
    ///
    /// # Errors
    /// The path is not a folder, the folder cannot be created, or another process has locked it.
    pub fn take(shown: &Path) -> Result<Self> {
        check_kind(shown)?;
        let mut place = Self { shown: shown.to_owned(), folder: PathBuf::new(), made: Vec::new(), lock: None };
        make(shown, &mut place.made).map_err(|source| Error::file(shown, "create folder", source))?;
        place.folder = shown.canonicalize().map_err(|source| Error::file(shown, "read", source))?;
        place.lock()?;
        let new = place.new_files();
        match fs::remove_dir_all(&new) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => Err(Error::file(&new, "remove", source)),
            _ => Ok(place),
        }
    }

    /// A new folder beside this one, `<folder>-2` or the next free name; `None` if none can be created.
    pub fn beside(&self) -> Option<Self> {
        // `.` and `..` have no name of their own.
        let named = if self.shown.file_name().is_some() { &self.shown } else { &self.folder };
        let (parent, name) = (named.parent()?, named.file_name()?.to_string_lossy());
        let free = |number: &usize| parent.join(format!("{name}-{number}")).symlink_metadata().is_err();
        Self::take(&parent.join(format!("{name}-{}", (2..1000).find(free)?))).ok()
    }

    /// The path as the user gave it.
    pub fn shown(&self) -> &Path {
        &self.shown
    }

    /// The path without links.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The list of the files that lostmotion wrote.
    pub fn list(&self) -> PathBuf {
        self.own().join(LIST)
    }

    /// Refuses a folder in which no file can be created.
    ///
    /// # Errors
    /// The operating system's reason.
    pub fn probe(&self) -> Result<()> {
        // A file without a name, if the system supports it: a process that is killed here leaves nothing behind.
        let mut file =
            tempfile::tempfile_in(&self.folder).map_err(|source| Error::file(&self.shown, "write", source))?;
        file.write_all(&[0; 4096]).map_err(|source| Error::file(&self.shown, "write", source))
    }

    /// Writes files beside the earlier ones and syncs them to disk; returns names and SHA-256.
    ///
    /// # Errors
    /// The operating system refuses; the earlier files are unchanged.
    pub fn stage(&self, files: &[report::File<'_>]) -> Result<Vec<(String, String)>> {
        let new = self.new_files();
        fs::create_dir_all(&new).map_err(|source| Error::file(&new, "create folder", source))?;
        let write = |(name, content): &report::File<'_>| {
            let sum = write(&new.join(name), content);
            Ok((name.clone(), sum.map_err(|source| Error::file(&self.shown.join(name), "write", source))?))
        };
        files.iter().map(write).collect()
    }

    /// Replaces the list of the files that lostmotion wrote.
    ///
    /// # Errors
    /// The operating system refuses; the earlier list is unchanged.
    pub fn save_list(&self, content: &[u8]) -> Result<()> {
        let (file, part) = (self.list(), self.own().join("files.json.part"));
        let done = write(&part, &Content::Bytes(content.to_vec())).and_then(|_| fs::rename(&part, &file));
        done.map_err(|source| Error::file(&file, "write", source))?;
        sync(&self.own());
        Ok(())
    }

    /// Moves staged files into place one by one, `report.json` last: if it is new, all others are.
    ///
    /// # Errors
    /// The operating system refuses; every file is then either old or new.
    pub fn swap(&self, staged: &[(String, String)]) -> Result<()> {
        let last = |name: &str| name == "report.json";
        let (report, others): (Vec<_>, Vec<_>) = staged.iter().partition(|(name, _)| last(name));
        for (name, _) in others.into_iter().chain(report) {
            fs::rename(self.new_files().join(name), self.folder.join(name))
                .map_err(|source| Error::file(&self.shown.join(name), "write", source))?;
        }
        sync(&self.folder);
        // The folder is empty now; if it cannot be removed, the next run removes it.
        let _ = fs::remove_dir(self.new_files());
        Ok(())
    }

    /// Removes files of the folder.
    ///
    /// # Errors
    /// The operating system refuses one.
    pub fn remove(&self, names: &[String]) -> Result<()> {
        names.iter().try_for_each(|name| {
            fs::remove_file(self.folder.join(name))
                .map_err(|source| Error::file(&self.shown.join(name), "remove", source))
        })
    }

    fn own(&self) -> PathBuf {
        self.folder.join(OWN)
    }

    fn new_files(&self) -> PathBuf {
        self.own().join(NEW)
    }

    /// Locks the folder for this process.
    fn lock(&mut self) -> Result<()> {
        let own = self.own();
        let path = own.join(LOCK);
        let failed = |source| Error::file(&self.shown, "write", source);
        for _ in 0..ATTEMPTS {
            match fs::create_dir(&own) {
                Err(source) if source.kind() != io::ErrorKind::AlreadyExists => return Err(failed(source)),
                _ if own.symlink_metadata().is_ok_and(|found| !found.is_dir()) => {
                    let expected = "a folder that lostmotion itself makes, not a file or a link: move it away";
                    return Err(Error::input(&self.shown.join(OWN), Place::File, "", "", expected));
                }
                _ => {}
            }
            let file = match File::options().create(true).append(true).open(&path) {
                // Removed in the meantime by a process that failed.
                Err(source) if source.kind() == io::ErrorKind::NotFound => continue,
                file => file.map_err(failed)?,
            };
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => {
                    let expected = "a folder to which no other lostmotion is writing: wait until that one has ended, or name \
                                    another folder with --out";
                    return Err(Error::input(&self.shown, Place::File, "", "", expected));
                }
                // The file system does not support locks.
                Err(TryLockError::Error(source)) if source.kind() == io::ErrorKind::Unsupported => {}
                Err(TryLockError::Error(source)) => return Err(failed(source)),
                Ok(()) if !is_still(&file, &path) => continue,
                Ok(()) => {}
            }
            self.lock = Some(file);
            interrupt::note(&self.folder, &self.made);
            return Ok(());
        }
        Err(failed(io::ErrorKind::ResourceBusy.into()))
    }
}

impl Drop for LockedFolder {
    /// Removes staged files that were not moved into place; if no result was ever written, also the folders that were
    /// created.
    fn drop(&mut self) {
        if self.lock.is_some() {
            interrupt::forget(&self.folder);
            clean(&self.folder, &self.made);
        } else {
            remove_empty(&self.made);
        }
    }
}

/// Refuses a path that exists and is not a folder.
fn check_kind(path: &Path) -> Result<()> {
    let refuse = |found: &str| {
        Err(Error::input(path, Place::File, "--out", found, "a folder, or a place where one can be made"))
    };
    match path.metadata() {
        Ok(found) if found.is_dir() => Ok(()),
        Ok(found) => refuse(kind(found.file_type())),
        Err(_) if path.symlink_metadata().is_ok() => refuse("a link that leads to nothing"),
        // The reason why it cannot be created is reported by the attempt.
        Err(_) => Ok(()),
    }
}

fn kind(found: fs::FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        if found.is_fifo() {
            return "a FIFO";
        }
        if found.is_socket() {
            return "a socket";
        }
        if found.is_block_device() || found.is_char_device() {
            return "a device";
        }
    }
    if found.is_file() { "a file" } else { "no folder" }
}

/// Creates a folder and its parents, and notes which ones were created.
fn make(folder: &Path, made: &mut Vec<PathBuf>) -> io::Result<()> {
    let missing: Vec<&Path> =
        folder.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()).collect();
    for folder in missing.into_iter().rev() {
        match fs::create_dir(folder) {
            Ok(()) => made.push(folder.to_owned()),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && folder.is_dir() => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Writes a file and syncs it to disk; returns its SHA-256.
fn write(path: &Path, content: &Content<'_>) -> io::Result<String> {
    let mut file = BufWriter::new(Summed::new(File::create(path)?));
    content.write(&mut file)?;
    let (file, sum) = file.into_inner()?.finish();
    file.sync_all()?;
    Ok(sum)
}

/// Syncs the entries of a folder to disk, if the system supports it.
fn sync(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Whether a path still refers to an open file.
#[cfg(unix)]
fn is_still(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let of = |found: &fs::Metadata| (found.dev(), found.ino());
    matches!((&file.metadata(), &path.metadata()), (Ok(open), Ok(there)) if of(open) == of(there))
}

#[cfg(not(unix))]
fn is_still(_file: &File, path: &Path) -> bool {
    path.exists()
}
