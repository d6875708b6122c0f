//! The folder of results: everything is written into a hidden sibling and moved into place at once, or not at all.

use std::fs;
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

use crate::error::{Error, Place, Result};
use crate::report::files::{Content, File};

/// Where the results of a command will stand. Nothing is on the disk before [`Folder::write`].
#[derive(Debug, Clone, PartialEq)]
pub struct Folder(PathBuf);

impl Folder {
    /// Settles on `out`, or on `out/<name>` where none is given, and refuses a place that holds something else than earlier results.
    /// Called before the work starts, so that no long run ends in a refusal.
    ///
    /// # Errors
    /// The place is a file, or a folder with files but without a `report.json`.
    pub fn reserve(out: Option<&Path>, name: &str) -> Result<Self> {
        let path = out.map_or_else(|| Path::new("out").join(name), Path::to_owned);
        let refuse = |found: &str| {
            Err(Error::input(
                &path,
                Place::File,
                "--out",
                found,
                "a new or empty folder, or one that holds earlier results",
            ))
        };
        if path.is_file() {
            return refuse("a file");
        }
        let occupied = fs::read_dir(&path).is_ok_and(|mut entries| entries.next().is_some());
        if occupied && !path.join("report.json").is_file() {
            return refuse("a folder with other files");
        }
        Ok(Self(path))
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Writes `files` (name, content) and puts them into place together; earlier results there are replaced.
    ///
    /// # Errors
    /// The operating system refuses; then the folder is as it was before.
    pub fn write<'a>(&self, files: impl IntoIterator<Item = &'a File<'a>>) -> Result<()> {
        let partial = self.sibling("partial");
        let done = fill(&partial, files).and_then(|()| self.replace_by(&partial));
        if done.is_err() {
            let _ = fs::remove_dir_all(&partial);
        }
        done
    }

    /// `.<name>.<what>-<process>` beside the folder.
    fn sibling(&self, what: &str) -> PathBuf {
        let name = self.0.file_name().unwrap_or_default().to_string_lossy();
        self.0.with_file_name(format!(".{name}.{what}-{}", std::process::id()))
    }

    /// Moves earlier results aside, the new ones into place, and then removes the earlier ones.
    fn replace_by(&self, partial: &Path) -> Result<()> {
        let earlier = self.sibling("earlier");
        let had_earlier = self.0.exists();
        if had_earlier {
            fs::rename(&self.0, &earlier).map_err(|source| Error::file(&self.0, "replace", source))?;
        }
        if let Err(source) = fs::rename(partial, &self.0) {
            if had_earlier {
                let _ = fs::rename(&earlier, &self.0);
            }
            return Err(Error::file(&self.0, "write", source));
        }
        if had_earlier {
            fs::remove_dir_all(&earlier).map_err(|source| Error::file(&earlier, "remove", source))?;
        }
        Ok(())
    }
}

/// Creates `folder` and writes the files into it.
fn fill<'a>(folder: &Path, files: impl IntoIterator<Item = &'a File<'a>>) -> Result<()> {
    fs::create_dir_all(folder).map_err(|source| Error::file(folder, "create folder", source))?;
    for (name, content) in files {
        let path = folder.join(name);
        write(&path, content).map_err(|source| Error::file(&path, "write", source))?;
    }
    Ok(())
}

/// Writes a file piece by piece.
fn write(path: &Path, content: &Content<'_>) -> io::Result<()> {
    let mut out = BufWriter::new(fs::File::create(path)?);
    content.write(&mut out)?;
    out.flush()
}
