//! Results to JSON, HTML and Rerun recordings.

/// Changes between two recordings, for readers.
pub mod changes;
/// Contacts, for readers.
pub mod contacts;
/// A diagnosis for readers.
pub mod diagnosis;
/// Units for readers.
pub mod display;
/// One content for terminal, page and recording.
pub mod document;
/// The files of a report.
pub mod files;
mod headline;
/// Documents as a page.
pub mod html;
/// An identification for readers.
pub mod identification;
mod judgement;
mod markup;
/// Formats of numbers.
pub mod number;
mod paper_figures;
/// Content of plots.
pub mod plot;
mod prediction;
/// Recordings for the Rerun viewer.
pub mod recording;
/// A replay for readers.
pub mod replay;
/// Identifications read back.
pub mod results;
/// A scenario that was run, for readers.
pub mod run;
/// What a simulation gets wrong, for readers.
pub mod shortfall;
/// Plots as SVG.
pub mod svg;
/// Tables.
pub mod table;
/// Tracking with and without compensation, for readers.
pub mod tracking;
/// Trends over repeated identifications, for readers.
pub mod trend;
mod two_encoders;

pub use document::{Document, Section};
pub use files::{Content, Report};
pub use plot::{Layer, Mark, Plot, Role};
pub use table::Table;
