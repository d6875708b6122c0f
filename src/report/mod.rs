//! Results to JSON, HTML and Rerun recordings.

/// One content for terminal, page and recording.
pub mod document;
/// Documents as a page.
pub mod html;
/// How numbers are written.
pub mod number;
/// What plots show.
pub mod plot;
/// Recordings for the Rerun viewer.
pub mod recording;
/// Plots as SVG.
pub mod svg;
/// Tables.
pub mod table;

pub use document::{Document, Section};
pub use plot::{Layer, Mark, Plot, Role};
pub use table::Table;
