//! Whether the joints of a recording turn or slide, if there is no model.

use std::collections::HashMap;

use super::columns::CHANNEL_COLUMNS;
use super::manifest::Manifest;
use super::table::Table;
use crate::units::{Dimension, JointKind, unit};

/// The joints of canonical columns: one with a `force` slides.
pub(super) fn joints_of_table(table: &Table) -> Vec<(String, JointKind)> {
    let mut joints: Vec<(String, JointKind)> = Vec::new();
    let mut places: HashMap<&str, usize> = HashMap::new();
    for column in &table.columns {
        let Some((name, channel)) = column.name.rsplit_once('.') else { continue };
        if !CHANNEL_COLUMNS.iter().any(|entry| entry.0 == channel) {
            continue;
        }
        let index = *places.entry(name).or_insert_with(|| {
            joints.push((name.to_owned(), JointKind::Revolute));
            joints.len() - 1
        });
        if channel == "force" {
            joints[index].1 = JointKind::Prismatic;
        }
    }
    joints
}

/// The joints of a manifest: one with a `force`, or with a unit of length, linear velocity or force, slides. Errors of
/// the manifest are left to its reader.
pub(super) fn joints_of_manifest(manifest: &Manifest) -> Vec<(String, JointKind)> {
    let root = manifest.document().root();
    let joints = root.table("joints").and_then(|joints| joints.named_tables()).unwrap_or_default();
    let slides = |table: &crate::toml_input::Table<'_>| {
        table.has("force")
            || table.keys().filter_map(|key| table.table(key).ok()).any(|channel| {
                let dimension = channel.optional_text("unit").ok().flatten().and_then(unit).map(|found| found.0);
                matches!(dimension, Some(Dimension::Length | Dimension::Velocity | Dimension::Force))
            })
    };
    let kind = |table| if slides(table) { JointKind::Prismatic } else { JointKind::Revolute };
    joints.iter().map(|(name, table)| ((*name).to_owned(), kind(table))).collect()
}
