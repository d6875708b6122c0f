//! What a command says: results on standard output, progress and warnings on standard error.

use std::io::{self, Write as _};
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};

use crate::error::{Error, Result};

use super::Outcome;
use super::folder::Folder;
use crate::report::Report;

/// Options that every command that computes shares.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct OutputOptions {
    /// Folder for the results [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<std::path::PathBuf>,
    /// No progress and no result on the terminal; errors and warnings only
    #[arg(long)]
    pub quiet: bool,
    /// Print report.json on standard output instead of the tables
    #[arg(long)]
    pub json: bool,
}

/// Writes a result to standard output. A reader that stopped reading is no error.
///
/// # Errors
/// Standard output refuses for any other reason.
pub fn print(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::file(Path::new("standard output"), "write", error))
        }
        _ => Ok(()),
    }
}

/// Prints warnings to standard error, one a line, and says how the command ended.
pub fn warn(warnings: &[String]) -> Outcome {
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
    if warnings.is_empty() { Outcome::Done } else { Outcome::Warned }
}

/// Writes the report's files into place, prints it, and says where it stands.
///
/// # Errors
/// A file or standard output is refused; then nothing is left behind.
pub fn finish(report: &Report<'_>, folder: &Folder, options: &OutputOptions) -> Result<Outcome> {
    let files = report.files()?;
    folder.write(&files)?;
    if options.json {
        print(&format!("{:#}\n", report.json))?;
    } else if !options.quiet {
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        print(&format!(
            "{}\nwritten to {}: {}\n",
            report.document.to_text(),
            folder.path().display(),
            names.join(", ")
        ))?;
        if !cfg!(feature = "rerun") {
            print("no trace.rrd: this build lacks the feature `rerun`\n")?;
        }
    }
    Ok(warn(&report.document.warnings))
}

/// A progress line on standard error: hidden when quiet or when standard error is no terminal, and wiped when dropped.
#[derive(Debug)]
pub struct Progress(ProgressBar);

impl Progress {
    /// Starts a line that says what is being done.
    pub fn start(doing: &str, quiet: bool) -> Self {
        const STEPS: u64 = 1000;
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(STEPS) };
        if let Ok(style) = ProgressStyle::with_template("{msg:<36} {bar:32} {percent:>3} %  {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(doing.to_owned());
        Self(bar)
    }

    /// Says what is being done now, from the beginning of the bar.
    pub fn next(&self, doing: &str) {
        self.0.set_message(doing.to_owned());
        self.0.set_position(0);
        self.0.tick();
    }

    /// Says what is being done, and how much of it.
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
