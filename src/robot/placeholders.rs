//! Values of a first model that nobody has measured: placeholders, which the model file needs and marks in their lines, and guesses, which only a
//! simulation needs. The file has guesses as comments: a diagnosis estimates what a model leaves out, and would take a wrong value for the machine's.

use std::collections::BTreeSet;

use crate::toml_input::written_key;

/// The word in the comment that marks such a value in a model file.
const MARK: &str = "placeholder";

/// The words in the comment beside a guess.
const GUESS: &str = "guess; state it where it is known";

/// Keys of joints, and of `[accuracy]`, whose values are placeholders, and keys of joints whose values are guesses.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Placeholders {
    needed: BTreeSet<String>,
    guesses: BTreeSet<String>,
}

impl Placeholders {
    /// Marks a key of a joint, such as `gear_ratio` or `motor.torque_constant`.
    pub fn mark(&mut self, joint: &str, key: &str) {
        self.needed.insert(path(joint, key));
    }

    /// Marks a key of a joint as a guess.
    pub fn guess(&mut self, joint: &str, key: &str) {
        self.guesses.insert(path(joint, key));
    }

    /// Whether the value of a key of a joint is a guess.
    pub fn is_guess(&self, joint: &str, key: &str) -> bool {
        self.guesses.contains(&path(joint, key))
    }

    /// Marks a key of `[accuracy]`.
    pub fn mark_accuracy(&mut self, key: &str) {
        self.needed.insert(format!("accuracy.{key}"));
    }

    /// Takes a mark away.
    pub fn unmark(&mut self, joint: &str, key: &str) {
        self.needed.remove(&path(joint, key));
    }

    /// Whether a key of a joint is marked.
    pub fn marks(&self, joint: &str, key: &str) -> bool {
        self.needed.contains(&path(joint, key))
    }

    /// What stands before a key in the file, and the comment behind its value.
    pub(super) fn around(&self, section: &str, key: &str, comment: &str) -> (&'static str, String) {
        let path = format!("{section}.{key}");
        let (before, mark) = match (self.needed.contains(&path), self.guesses.contains(&path)) {
            (_, true) => ("# ", GUESS),
            (true, _) => ("", MARK),
            (false, false) => return ("", comment.to_owned()),
        };
        let comment = if comment.is_empty() { mark.to_owned() } else { format!("{mark}; {comment}") };
        (before, comment)
    }
}

/// The full key in the file.
fn path(joint: &str, key: &str) -> String {
    format!("joints.{}.{key}", written_key(joint))
}

/// Lines of a model file that still hold placeholders, counted from 1.
pub fn marked_lines(text: &str) -> Vec<usize> {
    let marked = |line: &str| line.rsplit_once('#').is_some_and(|(_, comment)| comment.trim_start().starts_with(MARK));
    (1..).zip(text.lines()).filter(|(_, line)| marked(line)).map(|(number, _)| number).collect()
}
