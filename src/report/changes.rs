//! The changes between two recordings, for readers.

use super::display;
use super::document::Section;
use super::table::Table;
use crate::diagnose::{Change, Measured};

fn shown(value: &Measured) -> String {
    display::estimate(value.value, value.std_error, value.unit)
}

/// One change in a sentence.
pub fn sentence(change: &Change) -> String {
    format!(
        "{} of {} has changed by {} (from {} to {}), {:.0} % sure.",
        change.quantity,
        change.joint,
        shown(&change.change_percent),
        shown(&change.reference),
        shown(&change.now),
        100.0 * change.probability
    )
}

/// The table of all changes.
pub fn section(changes: &[Change]) -> Section {
    let mut section = Section::new("What has changed");
    if changes.is_empty() {
        section
            .text
            .push("Friction, rotor inertia and gap have not changed, as far as the recordings show.".to_owned());
        return section;
    }
    let mut table = Table::new("", &["quantity", "joint", "reference", "now", "change", "probability"]);
    for change in changes {
        table.row([
            change.quantity.clone(),
            change.joint.clone(),
            shown(&change.reference),
            shown(&change.now),
            shown(&change.change_percent),
            format!("{:.2}", change.probability),
        ]);
    }
    section.tables.push(table);
    section
}
