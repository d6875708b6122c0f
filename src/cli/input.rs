//! Input of a command: the model and the recordings.

use std::fs;
use std::path::{Path, PathBuf};

use crate::dataset::{self, Session};
use crate::diagnose;
use crate::error::Result;
use crate::robot::Model;
use crate::scenario::{Findings, reference_name};
use crate::timeseries::{Channel, Drawn, TimeSeries, side_by_side};

use super::console::{self, Progress};
use super::{catalogue, identity};

/// The model of a file, a folder with a `model.toml`, or a robot of the catalogue.
///
/// # Errors
/// There is no model of that name, or its file is refused.
pub fn model(given: &Path) -> Result<Model> {
    let model = Model::load(&catalogue::find(given, "robots", "model.toml")?)?;
    console::remark(&model.remarks);
    Ok(model)
}

/// The recordings of a command with held-out data, or of a comparison.
pub struct Recordings {
    /// The model as it is used with them ([`dataset::meet`]).
    pub model: Model,
    /// Recordings of `--data`.
    pub data: Vec<Session>,
    /// Recordings of `--hold-out`.
    pub hold_out: Vec<Session>,
    /// Recordings of `--reference`.
    pub reference: Vec<Session>,
    /// `--data` and `--hold-out`, reduced for display.
    pub drawn: Vec<Drawn>,
    /// `--reference`, reduced for display.
    pub drawn_before: Vec<Drawn>,
}

impl Recordings {
    /// Reads them for the joints of a model, and keeps the `wanted` channels.
    ///
    /// # Errors
    /// A file cannot be read or used, is given twice, or has the samples or the name of another one; or the model lacks a value
    /// that these recordings need.
    pub fn read(
        data: &[PathBuf],
        hold_out: &[PathBuf],
        reference: &[PathBuf],
        model: &Model,
        wanted: &[Channel],
    ) -> Result<Self> {
        let given = [("--data", data), ("--hold-out", hold_out), ("--reference", reference)];
        identity::of_files(given)?;
        // A whole table is in memory while it is read. The reference keeps the fewest channels, so it is read first.
        let (reference, drawn_before) = self::read(reference, model, &diagnose::compared_channels())?;
        let (data, mut drawn) = self::read(data, model, wanted)?;
        let (hold_out, drawn_too) = self::read(hold_out, model, wanted)?;
        drawn.extend(drawn_too);
        let all: Vec<&Session> = data.iter().chain(&hold_out).chain(&reference).collect();
        let model = dataset::meet(model, &all)?;
        let recordings = Self { model, data, hold_out, reference, drawn, drawn_before };
        let Self { data, hold_out, reference, .. } = &recordings;
        identity::of_names(&[("--data", data), ("--hold-out", hold_out)])?;
        identity::of_names(&[("--reference", reference)])?;
        identity::of_samples(&[("--data", data), ("--hold-out", hold_out), ("--reference", reference)])?;
        Ok(recordings)
    }

    /// All files that the command reads, see [`files`].
    pub fn files(&self, given: &[&[PathBuf]]) -> Vec<PathBuf> {
        files(&self.model, given, &[&self.data, &self.hold_out, &self.reference])
    }

    /// Notes on what was found or repaired while reading.
    pub fn notes(&self) -> Vec<String> {
        [&self.data, &self.hold_out, &self.reference].into_iter().flat_map(|sessions| notes(sessions)).collect()
    }

    /// What the nominal model lacks; with a reference, what has changed. And all recordings, reduced for display.
    ///
    /// # Errors
    /// As [`Findings::new`] and [`Findings::compared`].
    pub fn findings(self, quiet: bool) -> Result<(Findings, Vec<Drawn>)> {
        let Self { model, data, hold_out, reference, drawn, drawn_before } = self;
        let progress = Progress::start("diagnosing", quiet);
        let show = &mut |doing: &str, share: f64| progress.show(doing, share);
        if reference.is_empty() {
            return Ok((Findings::new(&model, data, hold_out, show)?, drawn));
        }
        let findings = Findings::compared(&model, reference, data, hold_out, show)?;
        let before = drawn_before.into_iter().map(|one| Drawn { name: reference_name(&one.name), ..one });
        Ok((findings, before.chain(drawn).collect()))
    }
}

/// Reads recordings, several at a time where they are short; keeps the `wanted` channels of each, and a reduced copy of all channels for display.
///
/// # Errors
/// A file cannot be read or used.
fn read(files: &[PathBuf], model: &Model, wanted: &[Channel]) -> Result<(Vec<Session>, Vec<Drawn>)> {
    let one = |file: &PathBuf| {
        let mut session = dataset::load_for(file, model)?;
        let drawn = Drawn::of(&session.series);
        session.series.keep(wanted);
        Ok((session, drawn))
    };
    // A number takes eight bytes, and about twice that as text; a compressed file may hold several times as much. What a manifest names is
    // not known here.
    let bytes = |file: &PathBuf| match dataset::is_manifest(file) {
        true => usize::MAX,
        false => fs::metadata(file).map_or(0, |about| about.len() as usize / 2),
    };
    let read = side_by_side(files, files.iter().map(bytes).max().unwrap_or(0), one);
    Ok(read.into_iter().collect::<Result<Vec<_>>>()?.into_iter().unzip())
}

/// All files that a command reads: those of the model, those that were given, and those that manifests name.
pub fn files(model: &Model, given: &[&[PathBuf]], sessions: &[&[Session]]) -> Vec<PathBuf> {
    let of_model = [&model.source, &model.urdf];
    let of_data = sessions.iter().copied().flatten().map(|session| &session.source);
    of_model.into_iter().chain(given.iter().copied().flatten()).chain(of_data).cloned().collect()
}

/// Notes on what was found or repaired while reading.
pub fn notes(sessions: &[Session]) -> Vec<String> {
    sessions.iter().flat_map(|session| session.notes.iter().map(ToString::to_string)).collect()
}

/// The signals alone.
pub fn series(sessions: Vec<Session>) -> Vec<TimeSeries> {
    sessions.into_iter().map(|session| session.series).collect()
}
