//! A folder with one good file of every kind, to be broken.

use std::fs;
use std::ops::Deref;
use std::time::{Duration, Instant};

pub use super::support::turntable::{MODEL, SCENARIO, URDF};
use super::support::{Folder, fault_of_refusal};

/// What is replaced, by what, the place that the message begins with (empty: only the file), and parts of it.
pub type Case = (&'static str, &'static str, &'static str, &'static [&'static str]);

pub struct Files(Folder);

impl Deref for Files {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Files {
    pub fn new() -> Self {
        Self(Folder::with(&[("robot.urdf", URDF), ("model.toml", MODEL), ("scenario.toml", SCENARIO)]))
    }

    #[track_caller]
    pub fn change(&self, name: &str, (from, to, ..): &Case) {
        let text = fs::read_to_string(self.path(name)).expect("text");
        let broken = text.replacen(from, to, 1);
        assert_ne!(text, broken, "{from} is not in {name}");
        self.put(name, broken);
    }

    /// Runs a command that must end with exit code 2 and one message that begins with `place` and holds these parts, in good time, with
    /// nothing on standard output and nothing written.
    pub fn refused(&self, arguments: &[&str], place: &str, parts: &[&str]) -> Result<(), String> {
        let before = self.names();
        let start = Instant::now();
        let output = self.lostmotion(arguments);
        let taken = start.elapsed();
        let message = String::from_utf8_lossy(&output.stderr);
        let fault = |what: String| Err(format!("  {what}: {message}"));
        fault_of_refusal(&output, parts)?;
        if !message.starts_with(&format!("error: {place}")) {
            return fault(format!("not at {place}"));
        }
        if self.names() != before {
            return fault(format!("left behind {:?}", self.names()));
        }
        // A second is promised; ten are granted to a machine that does other things besides.
        if taken > Duration::from_secs(10) {
            return fault(format!("{taken:?}"));
        }
        Ok(())
    }
}
