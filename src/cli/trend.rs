//! `lostmotion trend RESULTS...`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::error::{Error, Place, Result};
use crate::identify::trend::{FEWEST_REPEATS, trends};
use crate::report::files::planned;
use crate::report::results::{file_of, histories};
use crate::report::trend::{Source, report};

use super::console::OutputOptions;
use super::folder::{Folder, Request};
use super::{Outcome, console, identity};

/// Find what drifts over repeated identifications of one machine: a control chart and a trend of every parameter
#[derive(Debug, Args)]
pub struct Trend {
    /// Results of `identify`, or of `run` with an identification: report.json files or their folders, in the order of time
    #[arg(value_name = "RESULTS", required = true, num_args = 1..)]
    results: Vec<PathBuf>,
    /// Times of the results [d], one for each, not falling; by default results are counted: 0, 1, 2, ...
    #[arg(long, value_name = "DAYS", value_delimiter = ',')]
    days: Vec<f64>,
    /// Probability that any change is named although no parameter drifts
    #[arg(long, value_name = "LEVEL", default_value_t = 0.01)]
    level: f64,
    /// End with exit code 1 if a change is named
    #[arg(long)]
    fail_on_change: bool,
    #[command(flatten)]
    output: OutputOptions,
}

impl Trend {
    /// Reads, fits, reports.
    pub fn run(self) -> Result<Outcome> {
        let results: Vec<PathBuf> = self.results.iter().map(|given| file_of(given)).collect();
        identity::of_files([("RESULTS", &results), ("RESULTS", &[]), ("RESULTS", &[])])?;
        let (times, unit_of_time) = self.times()?;
        if !(self.level > 0.0 && self.level < 1.0) {
            return Err(refusal("--level", &self.level.to_string(), "a probability between 0 and 1"));
        }
        let (name, found) = histories(&results, &times)?;
        let found = trends(&found, unit_of_time, self.level);
        if found.is_empty() {
            return Err(Error::TooLittleData {
                quantity: "trend",
                joint: name,
                found: self.results.len(),
                unit: "results of one joint at different times",
                needed: FEWEST_REPEATS,
                advice: "repeat the identification; seven or more results show much smaller changes",
            });
        }
        let files: Vec<String> = results.iter().map(|file| file.display().to_string()).collect();
        let request = Request { verb: "trend", name: &name, files: planned(None, []), inputs: results };
        let folder = Folder::reserve(self.output.out.as_deref(), request)?;
        let source = Source { name: &name, files: &files, times: &times, unit_of_time, level: self.level };
        let outcome = console::finish(&report(&source, &found), &folder, &self.output)?;
        let failed = self.fail_on_change && found.iter().any(|trend| trend.changed);
        Ok(if failed { Outcome::Failed } else { outcome })
    }

    /// The times of the results, and their unit.
    fn times(&self) -> Result<(Vec<f64>, &'static str)> {
        if self.days.is_empty() {
            return Ok(((0..self.results.len()).map(|k| k as f64).collect(), "result"));
        }
        let rising = self.days.windows(2).all(|pair| pair[0] <= pair[1]) && self.days.iter().all(|day| day.is_finite());
        if self.days.len() != self.results.len() || !rising {
            let given: Vec<String> = self.days.iter().map(f64::to_string).collect();
            let expected = format!("{} numbers, one for each result, not falling", self.results.len());
            return Err(refusal("--days", &given.join(","), &expected));
        }
        Ok((self.days.clone(), "d"))
    }
}

/// The error of an option's value.
fn refusal(option: &str, value: &str, expected: &str) -> Error {
    Error::input(Path::new(option), Place::File, "", value, expected)
}
