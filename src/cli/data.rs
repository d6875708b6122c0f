//! `lostmotion data FILE...`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::dataset::{self, JointKinds, Readable, Table};
use crate::error::{Error, Place, Result};
use crate::files::is_file;
use crate::toml_input::write_atomically;

use super::{Outcome, console, input};

/// Show what data files hold and how their columns are read, with a first manifest where one is needed
#[derive(Debug, Args)]
pub struct Data {
    /// Recordings in any format that is read, or manifests
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Model whose joints a first manifest names: a file, or the name of a robot of the catalogue
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Write the first manifest of the file to this new file
    #[arg(long, value_name = "MANIFEST")]
    manifest: Option<PathBuf>,
}

impl Data {
    /// Prints a survey of each file; for a layout that is not canonical also a first manifest; for a manifest its session.
    pub fn run(self) -> Result<Outcome> {
        let joints = self.model.as_deref().map(input::model).transpose()?.map(|model| dataset::joints_of(&model));
        if let Some(manifest) = &self.manifest {
            check_target(manifest, &self.files)?;
        }
        for (index, file) in self.files.iter().enumerate() {
            if index > 0 {
                console::print("\n")?;
            }
            if dataset::is_manifest(file) {
                console::print(&dataset::survey_session(&dataset::load_alone(file)?))?;
                continue;
            }
            let table = dataset::read_table(file)?;
            console::print(&describe(table, joints.as_deref(), self.manifest.as_deref())?)?;
        }
        Ok(Outcome::Done)
    }
}

/// Refuses to write a manifest over a file, or one for many files.
fn check_target(manifest: &Path, files: &[PathBuf]) -> Result<()> {
    if files.len() > 1 {
        return Err(Error::input(manifest, Place::File, "--manifest", "", "one FILE, since it has one manifest"));
    }
    if is_file(manifest) {
        return Err(Error::input(manifest, Place::File, "--manifest", "", "a new file: this one exists"));
    }
    Ok(())
}

/// What a file of data holds, and how it is used.
fn describe(table: Table, joints: Option<&JointKinds>, target: Option<&Path>) -> Result<String> {
    let readable = dataset::readable(&table)?;
    let mut text = dataset::survey(&table);
    let manifest = dataset::first_manifest(&table, &named_from(&table.file, target), joints);
    text += match &readable {
        Readable::Canonical => "  canonical columns: no manifest needed\n",
        Readable::ByNames => "  its names are clear: no manifest needed\n",
        Readable::Manifest(_) => "",
    };
    if let Readable::Manifest(why) = &readable {
        text += &format!("  a manifest is needed: {why}\n");
    } else {
        text += "\n";
        text += &match dataset::session_of(table) {
            Ok(session) => dataset::survey_session(&session),
            Err(error) => format!("refused as data: {error}\n"),
        };
    }
    match target {
        Some(target) => {
            write_atomically(target, &manifest)?;
            text +=
                &format!("\nwritten: {}; check what is marked as a guess, then pass it to --data\n", target.display());
        }
        None if readable != Readable::Canonical => {
            text += "\nA manifest to begin with, to be saved beside the file and passed to --data:\n\n";
            text += &manifest;
        }
        None => {}
    }
    Ok(text)
}

/// How a manifest at `target` refers to a file: by its name if both are in one folder, else by its full path.
fn named_from(file: &Path, target: Option<&Path>) -> String {
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let folder = |path: &Path| {
        path.parent().map(|parent| if parent == Path::new("") { Path::new(".") } else { parent }.to_owned())
    };
    let whole = |path: Option<PathBuf>| path.and_then(|path| path.canonicalize().ok());
    match target {
        Some(target) if whole(folder(target)) != whole(folder(file)) => {
            whole(Some(file.to_owned())).map_or(name, |path| path.to_string_lossy().into_owned())
        }
        _ => name,
    }
}
