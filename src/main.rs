//! `lostmotion`: parse, run, print the error chain, exit.

use std::error::Error as _;
use std::process::ExitCode;

fn main() -> ExitCode {
    match lostmotion::cli::run() {
        Ok(outcome) => outcome.into(),
        Err(error) => {
            eprint!("error: {error}");
            let mut source = error.source();
            while let Some(cause) = source {
                eprint!(": {cause}");
                source = cause.source();
            }
            eprintln!();
            ExitCode::from(2)
        }
    }
}
