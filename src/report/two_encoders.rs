//! Results of a second encoder behind the gear, for readers.

use super::display::shown;
use super::document::Section;
use super::number;
use super::table::Table;
use crate::diagnose::{Diagnosis, Measured};

/// Delay, gap and stiffness of each joint that has a second encoder; `None` if there is none.
pub fn section(diagnosis: &Diagnosis) -> Option<Section> {
    if diagnosis.two_encoders.is_empty() {
        return None;
    }
    let mut table = Table::new(
        "Motor against link, one joint at a time; ± is one standard error",
        &[
            "joint",
            "second encoder late",
            "a delay explains",
            "gap",
            "the gap without a delay",
            "lost motion",
            "stiffness",
        ],
    );
    for joint in &diagnosis.two_encoders {
        table.row([
            joint.joint.clone(),
            value(&joint.link_delay),
            format!("{:.1} %", joint.explained_by_delay_percent),
            joint.backlash.as_ref().map_or_else(|| "the load stays on one flank".to_owned(), value),
            joint.backlash_without_delay.as_ref().map_or_else(String::new, value),
            joint.lost_motion.as_ref().map_or_else(String::new, value),
            joint.stiffness.as_ref().map_or_else(|| "not resolved".to_owned(), value),
        ]);
    }
    Some(Section { tables: vec![table], ..Section::new("Two encoders") })
}

fn value(measured: &Measured) -> String {
    let (unit, factor) = shown(measured.unit);
    let (value, std_error) = number::with_error(measured.value * factor, measured.std_error * factor);
    format!("{value} ± {std_error} {unit}")
}
