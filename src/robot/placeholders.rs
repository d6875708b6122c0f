//! Placeholders: values of a first model that nobody has measured but a simulation needs. The model file marks each in its line.

use std::collections::BTreeSet;

use crate::toml_input::written_key;

/// The word in the comment that marks such a value in a model file.
const MARK: &str = "placeholder";

/// Keys of joints, and of `[accuracy]`, whose values are placeholders.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Placeholders(BTreeSet<String>);

impl Placeholders {
    /// Marks a key of a joint, such as `gear_ratio` or `motor.torque_constant`.
    pub fn mark(&mut self, joint: &str, key: &str) {
        self.0.insert(path(joint, key));
    }

    /// Marks a key of `[accuracy]`.
    pub fn mark_accuracy(&mut self, key: &str) {
        self.0.insert(format!("accuracy.{key}"));
    }

    /// Takes a mark away.
    pub fn unmark(&mut self, joint: &str, key: &str) {
        self.0.remove(&path(joint, key));
    }

    /// Whether a key of a joint is marked.
    pub fn marks(&self, joint: &str, key: &str) -> bool {
        self.0.contains(&path(joint, key))
    }

    /// The comment of a key in the file, with the mark if its value is a placeholder.
    pub(super) fn comment(&self, section: &str, key: &str, comment: &str) -> String {
        match (self.0.contains(&format!("{section}.{key}")), comment) {
            (false, _) => comment.to_owned(),
            (true, "") => MARK.to_owned(),
            (true, _) => format!("{MARK}; {comment}"),
        }
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
