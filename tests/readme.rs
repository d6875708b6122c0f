//! The README's examples, carried out as printed.
//!
//! A block ```` ```console ```` holds commands behind `$ ` and what they print. `…` stands for lines that are left out.
//! Words have to agree; numbers within a tenth, because a processor with other rounding in its mathematical functions
//! shifts the last printed digits.
#![cfg(feature = "rerun")]

use std::fs;
use std::path::Path;
use std::process::Command;

/// Share by which a printed number may differ.
const TOLERANCE: f64 = 0.1;

/// Commands of the README with the lines that it prints below them.
fn examples(readme: &str) -> Vec<(String, Vec<String>)> {
    let mut examples: Vec<(String, Vec<String>)> = Vec::new();
    let mut inside = false;
    for line in readme.lines() {
        if line.starts_with("```") {
            inside = line == "```console";
        } else if let (true, Some(command)) = (inside, line.strip_prefix("$ ")) {
            examples.push((command.to_owned(), Vec::new()));
        } else if let (true, Some((_, printed))) = (inside, examples.last_mut()) {
            printed.push(line.to_owned());
        }
    }
    examples
}

/// Whether two printed words agree.
fn agree(printed: &str, found: &str) -> bool {
    let number = |word: &str| word.trim_matches(|edge: char| "()°%,;:".contains(edge)).parse::<f64>().ok();
    match (number(printed), number(found)) {
        (Some(printed), Some(found)) => {
            // Errors and standard errors are noise themselves: their size counts, not their digits.
            (printed - found).abs() <= (TOLERANCE * printed.abs()).max(0.6)
        }
        _ => printed == found,
    }
}

#[test]
fn scenario_readme_examples_print_what_the_readme_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let examples = examples(&readme);
    assert!(examples.len() >= 3, "the README shows three commands");
    for (command, printed) in examples {
        let mut words = command.split_whitespace();
        assert_eq!(words.next(), Some("lostmotion"), "{command}");
        let output =
            Command::new(env!("CARGO_BIN_EXE_lostmotion")).args(words).current_dir(folder.path()).output().unwrap();
        let stdout = String::from_utf8(output.stdout).unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{command}: {} {stderr}", output.status);
        let mut found = stdout.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
        let mut skipping = false;
        for line in printed {
            if line == "…" {
                skipping = true;
                continue;
            }
            let expected: Vec<&str> = line.split_whitespace().collect();
            let same = |found: &Vec<&str>| {
                found.len() == expected.len() && expected.iter().zip(found).all(|(a, b)| agree(a, b))
            };
            let met = if skipping { found.any(|found| same(&found)) } else { found.next().as_ref().is_some_and(same) };
            assert!(met, "{command}\nREADME: {line}\nprinted:\n{stdout}");
            skipping = false;
        }
    }
}
