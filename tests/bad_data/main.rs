//! Broken data of every kind: the program says what is wrong where, ends with exit code 2, writes nothing, and never hangs.
//!
//! A case is a file, a command that reads it, and what its one message has to say. The whole folder runs in seconds: a reader that
//! reads on without end fails by its time limit.

#[path = "../support/files/mod.rs"]
mod support;

mod csv;
#[cfg(feature = "db3")]
mod db3;
mod files;
mod identity;
mod manifests;
mod mat;
#[cfg(feature = "mcap")]
mod mcap;
#[cfg(feature = "parquet")]
mod parquet;
mod time;

use std::ops::Deref;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use support::refused;

/// Longest that a refusal may take: it comes within 0.1 s; the rest is room for a busy machine.
const LIMIT: Duration = Duration::from_secs(10);

/// A folder with a model.
struct Folder(support::Folder);

impl Deref for Folder {
    type Target = support::Folder;

    fn deref(&self) -> &support::Folder {
        &self.0
    }
}

impl Folder {
    fn new() -> Self {
        Self(support::Folder::plain())
    }

    /// Runs the program here, for at most [`LIMIT`].
    #[track_caller]
    fn run(&self, arguments: &[&str]) -> Output {
        let mut child = self
            .command(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program runs");
        let start = Instant::now();
        // Its messages are shorter than what a pipe holds, so that it never waits for this reader.
        while child.try_wait().expect("a state").is_none() {
            if start.elapsed() > LIMIT {
                child.kill().expect("ended");
                panic!("{arguments:?} takes longer than {LIMIT:?}");
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        child.wait_with_output().expect("its output")
    }

    #[track_caller]
    fn replay(&self, data: &str) -> Output {
        self.run(&["replay", "--quiet", "--out", "out", "--model", "model.toml", "--data", data])
    }

    /// Runs a command and asserts exit code 2, these parts in its one message, nothing printed and nothing written.
    #[track_caller]
    fn refuses(&self, arguments: &[&str], parts: &[&str]) {
        let before = self.names();
        let output = self.run(arguments);
        refused(&output, parts);
        assert!(output.stderr.len() < 3000, "a short message: {}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(self.names(), before, "nothing is written by {arguments:?}");
    }

    /// `replay` refuses the data.
    #[track_caller]
    fn refuses_data(&self, name: &str, parts: &[&str]) {
        self.refuses(&["replay", "--quiet", "--out", "out", "--model", "model.toml", "--data", name], parts);
    }

    /// `check` reads the file, and says this.
    #[track_caller]
    fn reads(&self, name: &str, parts: &[&str]) {
        let output = self.run(&["check", name]);
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        for part in parts {
            assert!(text.contains(part), "`{part}` not in: {text}");
        }
    }
}

/// Asserts that each content of a file of this name is refused with these parts in the message, the name among them.
#[track_caller]
fn each_is_refused<C: AsRef<[u8]>>(name: &str, cases: &[(C, &[&str])]) {
    let folder = Folder::new();
    for (content, parts) in cases {
        folder.put(name, content);
        folder.refuses_data(name, &[&[name], *parts].concat());
    }
}
