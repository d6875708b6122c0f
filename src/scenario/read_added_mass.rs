//! The table `[added_mass]` of a scenario file, or of one of its sessions.

use crate::error::Result;
use crate::robot::Load;
use crate::toml_input::Table;

/// `[added_mass]`: a known mass at a point of the last body, in the machine and in its nominal model.
pub(super) fn read(parent: &Table<'_>, session: &str) -> Result<Option<Load>> {
    let Some(table) = parent.optional_table("added_mass")? else { return Ok(None) };
    let load = Load::read(&table, session)?;
    table.finish()?;
    Ok(Some(load))
}
