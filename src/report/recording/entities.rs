//! What all entities of a recording share: application, time line, colours, precision, and the error of an entity.

use rerun::RecordingStream;
use rerun::log::TimeColumn;

use crate::error::{Error, Result};
use crate::report::plot::Role;

/// Name by which the viewer groups recordings and layouts.
pub const APPLICATION: &str = "lostmotion";
/// Name of the time line.
const TIME: &str = "time";

/// A value without a time.
pub fn log_static(stream: &RecordingStream, path: &str, value: &impl rerun::AsComponents) -> Result<()> {
    stream.log_static(path, value).map_err(|source| failed(path, source))
}

/// The time line's column, shifted by `start` [s].
pub fn times(times: impl IntoIterator<Item = f64>, start: f64) -> TimeColumn {
    TimeColumn::new_duration_secs(TIME, times.into_iter().map(|time| start + time))
}

/// Colours on the viewer's dark background.
pub const fn colour(role: Role) -> [u8; 3] {
    match role {
        Role::Truth => [235, 235, 235],
        Role::Fit => [90, 160, 255],
        Role::Before => [240, 120, 40],
        Role::After => [40, 200, 150],
        other => other.colour(),
    }
}

/// A number as the viewer stores it.
#[expect(clippy::cast_possible_truncation, reason = "the viewer works in single precision")]
pub const fn single(value: f64) -> f32 {
    value as f32
}

/// The error for an entity that the recorder refuses.
pub fn failed(entity: &str, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Error {
    Error::Recording { entity: entity.to_owned(), source: source.into() }
}
