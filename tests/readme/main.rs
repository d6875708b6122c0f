//! The examples of the README and of every scenario's README, carried out as printed.
//!
//! Words have to agree, and figures within what [`figures`] allows. With `LOSTMOTION_REFRESH=1` the figures of the files are replaced by those
//! that are printed now instead (`docs/refresh` does that); where words have changed, the file has to be edited by hand.
//! A scenario on recordings that are missing is reported as ignored; so is `note_what_the_picture_shows`, which is for `docs/refresh`.

mod examples;
mod figures;
mod picture;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use libtest_mimic::{Arguments, Failed, Trial};
use lostmotion::dataset;
use lostmotion::scenario::Recorded;

/// Replaces the figures of the files rather than comparing them.
const REFRESH: &str = "LOSTMOTION_REFRESH";

type Check = (&'static str, fn());

/// Checks of the comparison.
const CHECKS: [Check; 7] = [
    (
        "property_a_line_agrees_with_itself_and_with_other_last_digits",
        figures::checks::a_line_agrees_with_itself_and_with_other_last_digits,
    ),
    (
        "property_a_figure_that_moved_by_its_standard_error_does_not_agree",
        figures::checks::a_figure_that_moved_by_its_standard_error_does_not_agree,
    ),
    ("property_other_words_units_and_signs_do_not_agree", figures::checks::other_words_units_and_signs_do_not_agree),
    ("property_a_row_is_judged_by_its_own_table_only", figures::checks::a_row_is_judged_by_its_own_table_only),
    ("property_examples_are_read_compared_and_refreshed", examples::checks::examples_are_read_compared_and_refreshed),
    (
        "property_a_picture_of_other_figures_or_another_picture_is_seen",
        picture::checks::a_picture_of_other_figures_or_another_picture_is_seen,
    ),
    (
        "property_lines_that_are_missing_or_too_many_are_seen",
        examples::checks::lines_that_are_missing_or_too_many_are_seen,
    ),
];

fn main() -> ExitCode {
    let mut trials: Vec<Trial> = CHECKS
        .map(|(name, check)| {
            Trial::test(name, move || {
                check();
                Ok(())
            })
        })
        .into();
    let readme = root().join("README.md");
    trials.push(Trial::test("scenario_readme_examples_print_what_the_readme_says", move || carry_out(&readme, 3)));
    for folder in scenarios() {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let missing = missing(&folder);
        if let Some(missing) = &missing {
            eprintln!("ignored for want of {missing}: {name}");
        }
        let trial = Trial::test(format!("scenario_{name}_prints_what_its_readme_says"), move || {
            carry_out(&folder.join("README.md"), 1)
        });
        trials.push(trial.with_ignored_flag(missing.is_some()));
    }
    let picture = Trial::test("property_the_picture_shows_the_demonstration_of_the_readme", || picture::check(&root()));
    trials.push(picture);
    // The picture is made where there is a viewer: `docs/refresh` notes what it shows.
    let noted = Trial::test("note_what_the_picture_shows", || picture::note(&root()));
    trials.push(noted.with_ignored_flag(true));
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn scenarios() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("scenarios")).expect("scenarios");
    let mut folders: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.join("scenario.toml").is_file())
        .collect();
    folders.sort();
    folders
}

/// The recording that a scenario needs and that is not there: what reading the scenario says. Recordings behind a manifest are read only where no
/// folder of recordings is given: where there is one, what cannot be read fails the test.
fn missing(folder: &Path) -> Option<String> {
    let scenario = Recorded::load(&folder.join("scenario.toml"), &[]);
    let recorded = match scenario {
        Err(error) => return Some(error.to_string()),
        Ok(None) => return None,
        Ok(Some(_)) if std::env::var_os("LOSTMOTION_DATA").is_some() => return None,
        Ok(Some(recorded)) => recorded,
    };
    let files = recorded.data.iter().chain(&recorded.hold_out).chain(&recorded.reference);
    let joints = recorded.model().map(|model| dataset::joints_of(&model));
    joints
        .and_then(|joints| files.map(|file| dataset::load(file, &joints)).collect::<Result<Vec<_>, _>>())
        .err()
        .map(|error| error.to_string())
}

/// Carries out the examples of a file, at least so many; compares what they print, or writes it into the file.
fn carry_out(file: &Path, least: usize) -> Result<(), Failed> {
    let mut text = fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let count = examples::of(&text).len();
    if count < least {
        return Err(format!("{} shows {count} commands, at least {least} are expected", file.display()).into());
    }
    let folder = tempfile::tempdir()?;
    let refresh = std::env::var_os(REFRESH).is_some_and(|value| !value.is_empty() && value != "0");
    for index in 0..count {
        let example = &examples::of(&text)[index];
        let found = example.carry_out(folder.path());
        if refresh {
            let lines = example.refreshed(&found).map_err(|line| {
                format!(
                    "{}: `{}` has other words now; edit by hand: {line}\nprinted:\n{}",
                    file.display(),
                    example.command,
                    found.join("\n")
                )
            })?;
            text = example.put(&text, lines);
        } else if let Some(line) = example.differs(&found) {
            let shown =
                format!("{}: {}\nfile:    {line}\nprinted:\n{}", file.display(), example.command, found.join("\n"));
            return Err(format!("{shown}\n`docs/refresh` brings the figures up to date").into());
        }
    }
    if refresh {
        fs::write(file, text)?;
    }
    Ok(())
}
