//! Results to JSON, HTML and Rerun recordings.
