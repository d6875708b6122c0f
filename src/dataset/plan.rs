//! Which columns of a file make up a session. A manifest and canonical columns both lead to such a plan.

use std::path::PathBuf;

use super::Note;
use super::table::Table;
use crate::error::{Error, Place, Result};
use crate::timeseries::Channel;
use crate::units::JointKind;

/// The machine's own controller: position and velocity loop in cascade, each sample `k` of interval `T`,
/// `τ = k_v (k_p (q_ref − q(k)) − (q(k) − q(k−n))/(n T))`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// `k_p` [1/s] velocity asked for per position error, > 0.
    pub position_gain: f64,
    /// `k_v` [N·m·s/rad or N·s/m] torque on the joint side per velocity error, > 0.
    pub velocity_gain: f64,
    /// `n` samples over which it takes the difference quotient of the position, ≥ 1; 1 where the manifest does not say.
    pub velocity_samples: usize,
}

/// A column, and what one unit of it is in SI.
#[derive(Debug, Clone)]
pub(super) struct Source {
    /// Name in the file.
    pub(super) column: String,
    /// Place in the file, from 1, if a manifest gives it instead of the name.
    pub(super) number: Option<usize>,
    /// SI per unit of the file.
    pub(super) factor: f64,
    /// Where a manifest names it: file, place, key.
    pub(super) named_at: Option<(PathBuf, Place, String)>,
}

/// Which columns make up a session.
#[derive(Debug)]
pub(super) struct Plan {
    /// Name of the session.
    pub(super) name: String,
    /// The time.
    pub(super) time: Source,
    /// Its nanoseconds, if [`Self::time`] holds whole seconds.
    pub(super) nanoseconds: Option<Source>,
    /// The unit of the time, where a manifest gives it.
    pub(super) time_unit: Option<String>,
    /// The joints that were recorded.
    pub(super) joints: Vec<PlannedJoint>,
    /// What was noticed while planning.
    pub(super) notes: Vec<Note>,
}

/// Where the channels of a joint come from.
#[derive(Debug)]
pub(super) struct PlannedJoint {
    /// Name of the joint in the model.
    pub(super) name: String,
    /// Whether it turns or slides.
    pub(super) kind: JointKind,
    /// Its channels.
    pub(super) channels: Vec<(Channel, Source)>,
    /// The machine's own controller of this joint.
    pub(super) controller: Option<Controller>,
}

impl Source {
    /// A column by its name, in SI.
    pub(super) fn named(column: &str) -> Self {
        Self { column: column.to_owned(), number: None, factor: 1.0, named_at: None }
    }

    /// Takes the name of a column that is given by its number.
    ///
    /// # Errors
    /// The file has fewer columns.
    fn find_name(&mut self, table: &Table) -> Result<()> {
        let Some(number) = self.number else { return Ok(()) };
        match table.columns.get(number - 1) {
            Some(column) => self.column.clone_from(&column.name),
            None => {
                let expected =
                    format!("a number from 1 to {}, the columns of {}", table.columns.len(), table.file.display());
                let (file, place, key) =
                    self.named_at.clone().unwrap_or((table.file.clone(), Place::File, String::new()));
                return Err(Error::input(&file, place, key, number, expected));
            }
        }
        Ok(())
    }
}

impl Plan {
    /// Takes the names of columns that are given by their numbers.
    ///
    /// # Errors
    /// The file has fewer columns.
    pub(super) fn find_names(&mut self, table: &Table) -> Result<()> {
        let channels = self.joints.iter_mut().flat_map(|joint| joint.channels.iter_mut().map(|channel| &mut channel.1));
        std::iter::once(&mut self.time)
            .chain(&mut self.nanoseconds)
            .chain(channels)
            .try_for_each(|source| source.find_name(table))
    }
}

impl PlannedJoint {
    /// Whether it has a channel.
    pub(super) fn has(&self, channel: Channel) -> bool {
        self.channels.iter().any(|(known, _)| *known == channel)
    }
}
