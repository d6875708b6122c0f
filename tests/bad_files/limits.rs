//! What a run takes: stated before it starts, refused above the limits.

use lostmotion::error::Error;
use lostmotion::plant::{Options, Plant};
use lostmotion::robot::Model;
use lostmotion::scenario::{Limits, Scenario, simulate};

use super::files::{Files, MODEL, SCENARIO};

#[track_caller]
fn loaded(files: &Files) -> Scenario {
    Scenario::load(&files.path("scenario.toml"), &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// A scenario of one session at rest for a time [s].
fn resting(duration: &str) -> String {
    let controller = SCENARIO.split_once("[controller]").expect("a controller").1;
    format!(
        "schema = \"lostmotion/scenario/1\"\nname = \"still\"\nrobot = \"model.toml\"\n[reference]\nkind = \"rest\"\n\
         duration = {duration}\n[controller]{}",
        controller.split("[[obstacles]]").next().expect("a table")
    )
}

#[test]
fn regress_a_run_states_its_samples_and_memory_before_it_starts() {
    let files = Files::new();
    let output = files.lostmotion(&["run", "scenario.toml", "--out", "out"]);
    let said = String::from_utf8_lossy(&output.stderr);
    let scenario = loaded(&files);
    let samples: usize = scenario.sessions.iter().map(|session| (session.duration / 1e-3 + 1e-9) as usize + 1).sum();
    let line = said.lines().find(|line| line.contains(" sessions, ")).unwrap_or_else(|| panic!("{said}"));
    let samples = format!("{},{:03}", samples / 1000, samples % 1000);
    assert!(
        line.starts_with("4 sessions, ") && line.contains(&format!(" s, {samples} samples, ")),
        "{line}: {samples}"
    );
    assert!(line.ends_with(" MB"), "{line}");
    let quiet = files.lostmotion(&["run", "scenario.toml", "--out", "out", "--quiet"]);
    assert!(quiet.status.success() && quiet.stderr.is_empty(), "{}", String::from_utf8_lossy(&quiet.stderr));
}

#[test]
fn regress_a_run_above_its_memory_is_refused_with_what_would_fit() {
    let files = Files::new();
    files.put("scenario.toml", resting("1e6"));
    let place = "scenario.toml:5: reference = 1 session, 1,000,000 s, 1,000,000,001 samples, 185 GB";
    let fits = ["at most 4.0 GB", "6 hours", "--max-memory"];
    for arguments in [&["run", "scenario.toml", "--out", "out"][..], &["check", "scenario.toml"]] {
        files.refused(arguments, place, &fits).unwrap_or_else(|fault| panic!("{fault}"));
    }
    // The advice is sound: what it says fits, fits.
    files.put("scenario.toml", resting("2.0"));
    let run =
        |memory: &str| files.lostmotion(&["run", "scenario.toml", "--quiet", "--out", "out", "--max-memory", memory]);
    assert_eq!(run("1MB").status.code(), Some(0));
    assert_eq!(run("100kB").status.code(), Some(2));
    for size in ["4", "0GB", "lots", "1e400GB", "nanGB"] {
        let output = run(size);
        assert_eq!(output.status.code(), Some(2), "{size}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("500MB or 16GB"), "{size}");
    }
}

#[test]
fn regress_a_run_above_its_time_is_refused_with_what_would_allow_it() {
    let files = Files::new();
    files.put("scenario.toml", resting("1e5"));
    let arguments = ["run", "scenario.toml", "--out", "out", "--max-memory", "1TB", "--set", "plant.step=1e-6"];
    let parts = ["at most 60 minutes of computing", "plant.step", "--max-time"];
    files.refused(&arguments, "scenario.toml:5: reference", &parts).unwrap_or_else(|fault| panic!("{fault}"));
    // A period that is long, and a session that is: few samples, but many looks at the plan and steps.
    files.put("scenario.toml", resting("1e7"));
    let arguments = ["run", "scenario.toml", "--out", "out", "--set", "control_period=1"];
    files.refused(&arguments, "scenario.toml:5: reference", &parts).unwrap_or_else(|fault| panic!("{fault}"));
}

/// What is estimated is not below what is recorded, and not far above.
#[test]
fn property_the_estimate_covers_what_is_recorded() {
    let files = Files::new();
    let scenario = loaded(&files);
    let cost = scenario.cost().expect("a cost");
    let run = simulate(&scenario, 1, &|_, _| {}).expect("a run");
    let samples: usize = run.sessions.iter().map(lostmotion::timeseries::TimeSeries::len).sum();
    assert_eq!(cost.samples, samples as f64);
    let words: usize = run
        .sessions
        .iter()
        .chain(&run.measured())
        .map(|session| {
            session.len()
                + session
                    .joints
                    .iter()
                    .flat_map(|joint| joint.channels.values())
                    .map(|samples| samples.len())
                    .sum::<usize>()
        })
        .sum();
    let recorded = 8.0 * words as f64;
    // Two channels more than recorded are counted for what reports hold of them.
    assert!(cost.memory >= recorded && cost.memory < 1.3 * recorded, "{} of {recorded}", cost.memory);
}

/// The library refuses as the program does: nothing is allocated for a session of months.
#[test]
fn regress_simulate_refuses_what_is_above_the_limits() {
    let files = Files::new();
    for duration in ["1e7", "1e5"] {
        files.put("scenario.toml", resting(duration));
        let Err(Error::Input(error)) = simulate(&loaded(&files), 1, &|_, _| {}) else {
            panic!("{duration} is not refused")
        };
        assert_eq!(error.key, "reference");
    }
}

/// Effects and contacts can ask for more steps than were foreseen: they are counted as they are taken.
#[test]
fn regress_steps_that_were_not_foreseen_are_counted() {
    let files = Files::new();
    let mut scenario = loaded(&files);
    let steps = scenario.cost().expect("a cost").steps;
    scenario.truth.alter(|machine| {
        machine.effects[0].parameters.insert("order".to_owned(), 10_000.0);
    });
    scenario.limits = Limits { steps: 1.01 * steps, ..Limits::default() };
    match simulate(&scenario, 1, &|_, _| {}) {
        Err(Error::TooManySteps { limit, steps: taken, .. }) => {
            assert!(taken > limit && taken < 2 * limit, "{taken} {limit}")
        }
        other => panic!("{:?}", other.map(|run| run.sessions.len())),
    }
}

/// Friction that changes by six orders of magnitude within a nanosecond asks for a hundred thousand steps in a millisecond: they are counted as
/// they are taken, not at its end.
#[test]
fn regress_no_interval_takes_more_steps_than_are_allowed() {
    let files = Files::new();
    files.put("model.toml", MODEL.replace("[0.3, 0.32]", "[0.3, 1e6]").replace("[0.4, 0.42]", "[1e3, 0.42]"));
    let model = Model::load(&files.path("model.toml")).expect("a model");
    for current in [-5.0, 5.0] {
        let options = Options { most_steps: 1000, ..Options::default() };
        let mut plant = Plant::new(&model, &options).expect("a plant");
        let end = (0..1000).find_map(|_| plant.advance(&[current], 0.001).err());
        assert!(end.is_some(), "{:?}", plant.counts());
        // Of a step that was begun, each of a joint's four margins may be looked for 53 times.
        let most = 1000 + 2 + 4 * 53 / 4;
        assert!(plant.counts().work(1) <= most, "{end:?}: {:?}", plant.counts());
    }
}
