//! Examples in a Markdown file: what a command prints, read, compared, and brought up to date.
//!
//! A block ```` ```console ```` holds commands behind `$ ` and what they print. `…` stands for lines that are left out.

use std::path::Path;
use std::process::Command;

use super::figures::{self, Table};

/// A command with the lines below it.
#[derive(Debug, PartialEq)]
pub struct Example {
    /// The command line.
    pub command: String,
    /// What it prints, as the file has it.
    pub printed: Vec<String>,
    /// Line of the file, counted from 0, at which the first of them stands.
    at: usize,
}

/// The examples of a file.
pub fn of(text: &str) -> Vec<Example> {
    let mut examples: Vec<Example> = Vec::new();
    let mut inside = false;
    for (number, line) in text.lines().enumerate() {
        if line.starts_with("```") {
            inside = line == "```console";
        } else if let (true, Some(command)) = (inside, line.strip_prefix("$ ")) {
            examples.push(Example { command: command.to_owned(), printed: Vec::new(), at: number + 1 });
        } else if let (true, Some(example)) = (inside, examples.last_mut()) {
            example.printed.push(line.to_owned());
        }
    }
    examples
}

/// A line as this build prints it: without the viewer's format there is no `trace.rrd`.
fn of_this_build(line: &str) -> String {
    if cfg!(feature = "rerun") { line.to_owned() } else { line.replace(", trace.rrd", "") }
}

/// A line as the build of the release prints it.
fn of_release(line: &str) -> String {
    let with = line.replace("report.html,", "report.html, trace.rrd,");
    if cfg!(feature = "rerun") || !line.starts_with("written to ") {
        line.to_owned()
    } else if with == line {
        line.replace("report.html", "report.html, trace.rrd")
    } else {
        with
    }
}

impl Example {
    /// Carries the command out in a folder; the lines that it prints.
    ///
    /// # Panics
    /// The command is none of this program, or fails.
    pub fn carry_out(&self, folder: &Path) -> Vec<String> {
        let mut words = self.command.split_whitespace();
        assert_eq!(words.next(), Some("lostmotion"), "{}", self.command);
        let output = Command::new(env!("CARGO_BIN_EXE_lostmotion")).args(words).current_dir(folder).output();
        let output = output.expect("the program starts");
        let stderr = String::from_utf8_lossy(&output.stderr);
        // 3: done, with warnings.
        assert!(matches!(output.status.code(), Some(0 | 3)), "{}: {} {stderr}", self.command, output.status);
        let stdout = String::from_utf8(output.stdout).expect("UTF-8");
        stdout.lines().filter(|line| !line.starts_with("no trace.rrd: ")).map(str::to_owned).collect()
    }

    /// For each printed line of the file the one that was found, `…` for what is left out; `Err` holds the first that is not found.
    fn matched<'f>(
        &self,
        found: &'f [String],
        same: impl Fn(&str, &str, &Table) -> bool,
    ) -> Result<Vec<&'f str>, String> {
        let (mut rest, mut skipping, mut table, mut lines) = (found, false, Table::default(), Vec::new());
        for line in &self.printed {
            let expected = of_this_build(line);
            table.read(&expected);
            if expected == "…" {
                skipping = true;
                lines.push("…");
                continue;
            }
            let at = rest.iter().position(|found| same(&expected, found, &table));
            let Some(at) = at.filter(|at| skipping || *at == 0) else { return Err(line.clone()) };
            lines.push(rest[at].as_str());
            (rest, skipping) = (&rest[at + 1..], false);
        }
        if rest.is_empty() || skipping {
            Ok(lines)
        } else {
            Err(format!("nothing after its last line, and not: {}", rest[0]))
        }
    }

    /// The first line that is not printed as the file has it.
    pub fn differs(&self, found: &[String]) -> Option<String> {
        self.matched(found, figures::agree).err()
    }

    /// The lines of the file with the figures that are printed now; `Err` holds a line whose words have changed, which takes a hand.
    pub fn refreshed(&self, found: &[String]) -> Result<Vec<String>, String> {
        let lines = self.matched(found, |expected, found, _| figures::same_words(expected, found))?;
        Ok(lines.into_iter().map(of_release).collect())
    }

    /// Puts lines in the place of those of the file.
    pub fn put(&self, text: &str, lines: Vec<String>) -> String {
        assert_eq!(lines.len(), self.printed.len());
        let mut all: Vec<String> = text.lines().map(str::to_owned).collect();
        all.splice(self.at..self.at + lines.len(), lines);
        all.join("\n") + "\n"
    }
}

/// Checks of reading, comparing and refreshing.
pub mod checks {
    use super::*;

    const FILE: &str =
        "# Title\n```console\n$ lostmotion run a\nfirst 1.00 ± 0.10 mm\n…\nlast 5\n```\ntext\n```sh\n$ no\n```\n";

    fn lines(text: &str) -> Vec<String> {
        text.lines().map(str::to_owned).collect()
    }

    pub fn examples_are_read_compared_and_refreshed() {
        let examples = of(FILE);
        assert_eq!(examples.len(), 1);
        let example = &examples[0];
        assert_eq!(example.command, "lostmotion run a");
        assert_eq!(example.printed, ["first 1.00 ± 0.10 mm", "…", "last 5"]);
        assert_eq!(example.differs(&lines("first 1.01 ± 0.10 mm\nmore\nlast 5")), None);
        let moved = lines("first 1.10 ± 0.10 mm\nmore\nlast 5");
        assert_eq!(example.differs(&moved).as_deref(), Some("first 1.00 ± 0.10 mm"));
        let refreshed = example.put(FILE, example.refreshed(&moved).expect("the same words"));
        assert_eq!(refreshed, FILE.replace("1.00 ±", "1.10 ±"));
        assert_eq!(of(&refreshed)[0].differs(&moved), None);
    }

    pub fn lines_that_are_missing_or_too_many_are_seen() {
        let example = &of(FILE)[0];
        assert_eq!(example.differs(&lines("first 1.00 ± 0.10 mm\nmore")).as_deref(), Some("last 5"));
        assert!(example.differs(&lines("more\nfirst 1.00 ± 0.10 mm\nlast 5")).is_some());
        assert!(example.differs(&lines("first 1.00 ± 0.10 mm\nlast 5\nmore")).is_some());
        assert!(example.refreshed(&lines("first 1.00 ± 0.10 m\nlast 5")).is_err(), "another unit takes a hand");
    }
}
