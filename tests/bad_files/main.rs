//! Bad scenario, model and URDF files: each is refused with its place, its key and what was expected, exit code 2, and nothing written.

#[path = "../support/files/mod.rs"]
mod support;

mod files;
mod limits;
mod models;
mod said;
mod scenarios;
mod text;
mod urdfs;

use files::{Case, Files};

/// Carries out every case in a folder of its own and shows all that differ: `arguments` are those of the command, `file` is changed.
#[track_caller]
fn all_refused(file: &str, arguments: &[&str], cases: &[Case]) {
    let mut wrong = Vec::new();
    for case in cases {
        let files = Files::new();
        files.change(file, case);
        if let Err(fault) = files.refused(arguments, case.2, case.3) {
            wrong.push(format!("{} → {}\n{fault}", case.0, case.1));
        }
    }
    assert!(wrong.is_empty(), "{} of {} cases:\n{}", wrong.len(), cases.len(), wrong.join("\n"));
}
