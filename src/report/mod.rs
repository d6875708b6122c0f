//! Results to JSON, HTML and Rerun recordings.

/// What has changed, for readers.
pub mod changes;
/// What was touched, for readers.
pub mod contacts;
/// A diagnosis for readers.
pub mod diagnosis;
/// Units for readers.
pub mod display;
/// One content for terminal, page and recording.
pub mod document;
/// What a command leaves behind.
pub mod files;
mod headline;
/// Documents as a page.
pub mod html;
/// An identification for readers.
pub mod identification;
/// How numbers are written.
pub mod number;
/// What plots show.
pub mod plot;
/// Recordings for the Rerun viewer.
pub mod recording;
/// A replay for readers.
pub mod replay;
/// A carried out scenario for readers.
pub mod run;
/// What a simulation gets wrong, for readers.
pub mod shortfall;
/// Plots as SVG.
pub mod svg;
/// Tables.
pub mod table;
mod two_encoders;

pub use document::{Document, Section};
pub use files::{Content, Report};
pub use plot::{Layer, Mark, Plot, Role};
pub use table::Table;
