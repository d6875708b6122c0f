//! Robot files of a folder, by package: which are read, what a first model of each gives, and whether it simulates a second.
//!
//! ```text
//! cargo bench --bench robots -- FOLDER [FOLDER...] [--files]
//! ```
//! A package is a folder directly below a FOLDER. A robot file is a `.urdf`, or an `.xml` whose outermost element is `<mujoco>`, with a joint that turns
//! or slides. Files of one package with the same text, or of several packages, count once. `--files` lists every file that is refused or does not
//! simulate, with the reason, on standard error. The table goes to standard output: `docs/refresh --robots FOLDER...` puts it into docs/robots.md.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use lostmotion::plant::first_model;
use lostmotion::scenario::trial;
use rayon::prelude::*;

/// [bytes] Longest file that is looked at.
const LONGEST: u64 = 64 << 20;

/// Words of a file with a joint that moves.
const MOVING: [&str; 7] = [
    "type=\"revolute\"",
    "type=\"continuous\"",
    "type=\"prismatic\"",
    "type='revolute'",
    "type='continuous'",
    "type='prismatic'",
    "<joint",
];

/// What became of a file.
enum Outcome {
    Simulates,
    /// Read, but the trial of its first model fails.
    Fails(String),
    Refused(String),
    /// An MJCF file without a joint that turns or slides: defaults and assets of others.
    NoRobot,
}

/// Begins the reason of a trial that fails.
const FAILS: &str = "does not simulate";

/// How the reader says that a file has no joint.
const NO_JOINT: &str = "expected at least one joint that turns or slides";

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let (options, folders): (Vec<&String>, Vec<&String>) = arguments.iter().partition(|word| word.starts_with("--"));
    if folders.is_empty() {
        eprintln!("robots: no folder given, nothing to do");
        return;
    }
    let files = robots(&folders);
    let mut table: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
    let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
    let outcomes: Vec<Outcome> = files.par_iter().map(|(_, file)| outcome(file)).collect();
    for ((package, file), outcome) in files.iter().zip(outcomes) {
        if matches!(outcome, Outcome::NoRobot) {
            continue;
        }
        let row = table.entry(package).or_default();
        row[0] += 1;
        let reason = match &outcome {
            Outcome::Simulates => {
                row[1] += 1;
                row[2] += 1;
                continue;
            }
            Outcome::Fails(reason) => {
                row[1] += 1;
                format!("{FAILS}: {reason}")
            }
            Outcome::Refused(reason) => format!("refused: {reason}"),
            Outcome::NoRobot => continue,
        };
        if options.iter().any(|option| *option == "--files") {
            eprintln!("{}: {reason}", file.display());
        }
        *reasons.entry(kind(&reason)).or_default() += 1;
    }
    print(&table, &reasons);
}

fn print(table: &BTreeMap<&str, [usize; 3]>, reasons: &BTreeMap<String, usize>) {
    println!("| package | files | read | first model simulates a second |\n|---|---|---|---|");
    let mut sum = [0; 3];
    for (package, row) in table {
        println!("| {package} | {} | {} | {} |", row[0], row[1], row[2]);
        sum.iter_mut().zip(row).for_each(|(sum, one)| *sum += one);
    }
    println!("| **all** | {} | {} | {} |", sum[0], sum[1], sum[2]);
    if !reasons.is_empty() {
        println!("\n| files | what is wrong |\n|---|---|");
        reasons.iter().for_each(|(reason, count)| println!("| {count} | {reason} |"));
    }
}

/// Words of faults of a trial, and what they have in common.
const FAULTS: [(&str, &str); 3] = [
    ("effort limit", "an effort limit does not hold the weight"),
    ("diverged", "the simulation diverges"),
    ("off after a move", "a joint is not where it should be"),
];

/// A reason without the names and numbers of one file.
fn kind(reason: &str) -> String {
    let (head, text) = reason.split_once(": ").unwrap_or(("", reason));
    if let Some((_, fault)) = FAULTS.iter().find(|(words, _)| head == FAILS && text.contains(words)) {
        return format!("{head}: {fault}");
    }
    let expected = text.find("expected ").map_or(text, |at| &text[at..]);
    let expected = if expected.contains("or an <inertial> of its body") {
        "expected meshes that the masses follow from"
    } else {
        expected
    };
    format!("{head}: {}", expected.replace('|', "\\|"))
}

fn outcome(file: &Path) -> Outcome {
    let first = match first_model(file) {
        Ok(first) => first,
        Err(error) if error.to_string().ends_with(NO_JOINT) => return Outcome::NoRobot,
        Err(error) => return Outcome::Refused(error.to_string()),
    };
    match trial(&first.model) {
        Ok(trial) if trial.faults.is_empty() => Outcome::Simulates,
        Ok(trial) => Outcome::Fails(trial.faults.join("; ")),
        Err(error) => Outcome::Fails(error.to_string()),
    }
}

/// Robot files below the folders, each with its package, every text once.
fn robots(folders: &[&String]) -> Vec<(String, PathBuf)> {
    let (mut seen, mut found) = (BTreeSet::new(), Vec::new());
    for folder in folders {
        let mut files = Vec::new();
        collect(Path::new(folder), &mut files);
        files.sort();
        for file in files {
            let below = file.strip_prefix(folder).ok().and_then(|path| path.iter().next());
            let package = below.map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            if let Some(text) = robot(&file).filter(|text| seen.insert(text.clone())) {
                drop(text);
                found.push((package, file));
            }
        }
    }
    found
}

/// The text of a robot file with a joint that moves.
fn robot(file: &Path) -> Option<String> {
    let ending = file.extension()?.to_str()?.to_lowercase();
    if !["urdf", "xml"].contains(&ending.as_str()) || fs::metadata(file).ok()?.len() > LONGEST {
        return None;
    }
    let text = String::from_utf8_lossy(&fs::read(file).ok()?).into_owned();
    let (roots, moving) = if ending == "urdf" {
        (["<robot ", "<robot>"], &MOVING[..6])
    } else {
        (["<mujoco ", "<mujoco>"], &MOVING[6..])
    };
    (roots.iter().any(|root| text.contains(root)) && moving.iter().any(|word| text.contains(word))).then_some(text)
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        if path.is_dir() {
            collect(&path, files);
        } else {
            files.push(path);
        }
    }
}
