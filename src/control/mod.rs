//! Reference and state to command.
