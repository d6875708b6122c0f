//! Output of a command: results on standard output, progress and warnings on standard error.

use std::error::Error as _;
use std::io::{self, Write as _};
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};

use crate::error::{Error, Result};
use crate::robot::Remark;

use super::Outcome;
use super::folder::Folder;
use crate::report::Report;

/// Options that every command that computes shares.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct OutputOptions {
    /// Folder for the results; only files that lostmotion wrote are replaced there [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<std::path::PathBuf>,
    /// No progress and no result on the terminal; errors and warnings only
    #[arg(long)]
    pub quiet: bool,
    /// Print report.json on standard output instead of the tables
    #[arg(long)]
    pub json: bool,
}

/// Writes a result to standard output. A closed pipe is not an error.
///
/// # Errors
/// Standard output refuses for another reason.
pub fn print(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::file(Path::new("standard output"), "write", error))
        }
        _ => Ok(()),
    }
}

/// Prints to standard error which values of a model's files are not taken as written.
pub fn remark(remarks: &[Remark]) {
    remarks.iter().for_each(|remark| eprintln!("note: {remark}"));
}

/// Prints warnings to standard error, one per line, and returns the outcome of the command.
pub fn warn(warnings: &[String]) -> Outcome {
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
    if warnings.is_empty() { Outcome::Done } else { Outcome::Warned }
}

/// Writes the report's files, prints the report, and prints its folder. If files cannot be written, the report is
/// printed even so.
///
/// # Errors
/// No folder accepts the files, or standard output refuses.
pub fn finish(report: &Report<'_>, folder: &Folder, options: &OutputOptions) -> Result<Outcome> {
    let files = report.files()?;
    let written = folder.write(&files);
    if options.json {
        print(&format!("{:#}\n", report.json))?;
    } else if !options.quiet {
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        print(&format!("{}\n", report.document.to_text()))?;
        if let Ok(results) = &written {
            print(&format!("written to {}: {}\n", results.folder.display(), names.join(", ")))?;
        }
        if !cfg!(feature = "rerun") {
            print("no trace.rrd: this build lacks the feature `rerun`\n")?;
        }
    }
    let results = written?;
    let moved = results.moved.map(|why| {
        let reason = why.source().map_or_else(String::new, |source| format!(": {source}"));
        format!("the results are in {}, because of {why}{reason}", results.folder.display())
    });
    let warnings: Vec<String> = report.document.warnings.iter().cloned().chain(moved).collect();
    Ok(warn(&warnings))
}

/// A progress line on standard error: hidden if quiet or if standard error is not a terminal, and removed when dropped.
#[derive(Debug)]
pub struct Progress(ProgressBar);

impl Progress {
    /// Starts a line with the name of the present step.
    pub fn start(doing: &str, quiet: bool) -> Self {
        const STEPS: u64 = 1000;
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(STEPS) };
        if let Ok(style) = ProgressStyle::with_template("{msg:<36} {bar:32} {percent:>3} %  {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(doing.to_owned());
        Self(bar)
    }

    /// Shows the next step, with the bar at its beginning.
    pub fn next(&self, doing: &str) {
        self.0.set_message(doing.to_owned());
        self.0.set_position(0);
        self.0.tick();
    }

    /// Shows the present step, and the share of it that is done.
    pub fn show(&self, doing: &str, share: f64) {
        if self.0.message() != doing {
            self.0.set_message(doing.to_owned());
        }
        self.set(share);
    }

    /// Moves the bar to `share` (0 to 1) of the work.
    pub fn set(&self, share: f64) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 1000")]
        self.0.set_position((1000.0 * share.clamp(0.0, 1.0)) as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
