//! Errors, with the numbers, positions and names that a user needs to correct them.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::files::is_control;

/// Result of everything in this crate that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a command could not be carried out. Every variant ends the process with exit code 2.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file contains a value that cannot be used.
    #[error(transparent)]
    Input(Box<InputError>),
    /// The operating system refused a file.
    #[error("{}: cannot {action}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// The operation: "read", "write", "create folder".
        action: &'static str,
        /// The reason given by the operating system.
        source: std::io::Error,
    },
    /// A planned motion would leave the joint limits or collide.
    #[error(transparent)]
    Motion(Box<MotionError>),
    /// The data are not sufficient for the estimate.
    #[error("{quantity} of {joint}: {found} {unit}, at least {needed} needed: {advice}")]
    TooLittleData {
        /// The quantity to be estimated.
        quantity: &'static str,
        /// Its joint.
        joint: String,
        /// Number found.
        found: usize,
        /// What is counted, for example "steady windows".
        unit: &'static str,
        /// Number needed.
        needed: usize,
        /// What to record or change instead.
        advice: &'static str,
    },
    /// The data do not determine a quantity, although there are enough of them.
    #[error("{quantity} of {joint}: {reason}")]
    Undetermined {
        /// The quantity to be estimated.
        quantity: &'static str,
        /// Its joint.
        joint: String,
        /// Why, and what to record or state.
        reason: String,
    },
    /// A simulated machine has left the range in which its laws are valid.
    #[error(
        "simulation diverged: at t = {time:.6} s {quantity} of {joint} is {value:e}, beyond the limit of {limit:e}; \
             a controller that is too stiff for the machine or too slow for its gears may be the cause"
    )]
    Diverged {
        /// [s] at the end of the interval in which it happened.
        time: f64,
        /// The joint.
        joint: String,
        /// The quantity that is out of bounds, for example "motor velocity".
        quantity: &'static str,
        /// Its value, SI; may be NaN.
        value: f64,
        /// Its bound.
        limit: f64,
    },
    /// A simulation takes more steps than allowed.
    #[error(
        "simulation stopped at t = {time:.6} s: it has taken {steps} steps, and at most {limit} are allowed; \
             contacts or effects that are very fast may be the cause, or --max-time allows more"
    )]
    TooManySteps {
        /// [s] Time that was reached.
        time: f64,
        /// Steps taken so far.
        steps: usize,
        /// Allowed steps.
        limit: usize,
    },
    /// A recording for the viewer could not be written.
    #[error("recording: {entity} was refused")]
    Recording {
        /// Path of the entity in the recording.
        entity: String,
        /// The reason given by the recorder.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// No friction law fits the measured friction of a joint.
    #[error(
        "friction of {joint}: no law fits the {windows} steady windows, where friction may even seem to drive the joint; \
             compare gravity, base tilt, torque constant and signs with the model, and let every speed be held for longer than the way \
             through the gap"
    )]
    NoFrictionLaw {
        /// Name of the joint.
        joint: String,
        /// Steady windows that were found.
        windows: usize,
    },
}

/// One invalid value: its place, the value, and what was expected.
#[derive(Debug, Clone, PartialEq)]
pub struct InputError {
    /// The file.
    pub file: PathBuf,
    /// Position in the file.
    pub place: Place,
    /// Key, column or attribute: `joints.joint1.gear_ratio`.
    pub key: String,
    /// The value as written in the file; empty if something is missing.
    pub value: String,
    /// What was expected, with range and unit.
    pub expected: String,
}

/// A position in a file, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// Line of a text.
    Line(usize),
    /// Row of a table, the header not counted.
    Row(usize),
}

/// What follows the name of the file: `:7`, `: row 7`, nothing.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Row(row) => write!(f, ": row {row}"),
        }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.file.display(), self.place)?;
        if !self.key.is_empty() {
            write!(f, ": {}", self.key)?;
        }
        if !self.value.is_empty() {
            write!(f, " = {}", self.value)?;
        }
        write!(f, ": expected {}", self.expected)
    }
}

impl std::error::Error for InputError {}

/// Why a planned motion is refused before it runs.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("planned motion refused at t = {time:.3} s: {cause}")]
pub struct MotionError {
    /// [s] First time at which it happens.
    pub time: f64,
    /// The fault.
    pub cause: MotionFault,
}

/// What is wrong with a planned motion.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MotionFault {
    /// A joint leaves its range.
    #[error("{joint} at {position:.4} leaves its range [{lower:.4}, {upper:.4}] (rad or m)")]
    Limit {
        /// The joint.
        joint: String,
        /// [rad or m] planned position.
        position: f64,
        /// [rad or m] lower limit.
        lower: f64,
        /// [rad or m] upper limit.
        upper: f64,
    },
    /// Two links meet.
    #[error("links {first} and {second} collide")]
    Collision {
        /// One link.
        first: String,
        /// The other.
        second: String,
    },
}

impl From<MotionError> for Error {
    fn from(error: MotionError) -> Self {
        Self::Motion(Box::new(error))
    }
}

/// Longest key or value, and longest expectation, that an error shows [characters]: values in files may have any
/// length.
const SHOWN: usize = 240;
const SHOWN_EXPECTED: usize = 1200;

/// Text of a file for a message: at most `most` characters, with [control characters](is_control) escaped, so that a terminal does
/// not interpret them or break the line.
pub fn shown(text: &str, most: usize) -> String {
    // A number of hundreds of digits also has a short form with the same value.
    if let Some(number) = text.parse::<f64>().ok().filter(|_| text.len() > most) {
        return format!("{number:e}");
    }
    let mut shown = String::new();
    for (count, c) in text.chars().enumerate() {
        if count == most {
            shown += " ...";
            break;
        }
        if is_control(c) { shown.extend(c.escape_default()) } else { shown.push(c) }
    }
    shown
}

impl Error {
    /// An invalid value at a place in a file.
    pub fn input(
        file: &Path,
        place: Place,
        key: impl Into<String>,
        value: impl fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self::Input(Box::new(InputError {
            file: file.to_owned(),
            place,
            key: shown(&key.into(), SHOWN),
            value: shown(&value.to_string(), SHOWN),
            expected: shown(&expected.into(), SHOWN_EXPECTED),
        }))
    }

    /// A refusal by the operating system.
    pub fn file(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        Self::File { path: path.to_owned(), action, source }
    }
}
