//! The command line: one verb, one file.
//!
//! A verb is an argument struct with `run(self) -> Result<Outcome>`. Results go to standard output, progress and warnings to standard error;
//! errors are returned and printed once, in `main`.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::error::Result;

pub mod catalogue;
pub mod console;
pub mod folder;

mod check;
mod data;
mod design;
mod diagnose;
mod explain;
mod identify;
mod identity;
mod input;
mod limits;
mod list;
mod measured;
mod new;
mod replay;
mod run;
mod trend;

/// Finds why a robot arm and its simulation disagree: friction and backlash identification, and a named cause for what the model lacks.
#[derive(Debug, Parser)]
#[command(name = "lostmotion", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Check(check::Check),
    Data(data::Data),
    List(list::List),
    Design(design::Design),
    Diagnose(diagnose::Diagnose),
    Explain(explain::Explain),
    Identify(identify::Identify),
    New(new::New),
    Replay(replay::Replay),
    Run(run::Run),
    Trend(trend::Trend),
    Demo(run::Demo),
}

/// How a command ended, unless it was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Done,
    /// Exit code 1: an expectation of a scenario failed, or a gap was found that `--fail-on-gap` forbids.
    Failed,
    /// Exit code 3: done, with warnings.
    Warned,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Done => Self::SUCCESS,
            Outcome::Failed => Self::from(1),
            Outcome::Warned => Self::from(3),
        }
    }
}

/// Parses the process's arguments and carries out the verb. Usage errors end the process with exit code 2.
///
/// # Errors
/// The reason why the verb cannot be carried out: bad input, a refused file, insufficient data.
pub fn run() -> Result<Outcome> {
    match Cli::parse().verb {
        Verb::Check(verb) => verb.run(),
        Verb::Data(verb) => verb.run(),
        Verb::List(verb) => verb.run(),
        Verb::Design(verb) => verb.run(),
        Verb::Diagnose(verb) => verb.run(),
        Verb::Explain(verb) => verb.run(),
        Verb::Identify(verb) => verb.run(),
        Verb::New(verb) => verb.run(),
        Verb::Replay(verb) => verb.run(),
        Verb::Run(verb) => verb.run(),
        Verb::Trend(verb) => verb.run(),
        Verb::Demo(verb) => verb.run(),
    }
}
