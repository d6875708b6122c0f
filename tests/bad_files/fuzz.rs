//! Thousands of broken scenario, model and URDF files: no panic, and an answer in bounded time and memory.
//!
//! `LOSTMOTION_FUZZ=20000` makes as many cases; `LOSTMOTION_FUZZ_SEED` begins elsewhere.

use std::time::{Duration, Instant};

use lostmotion::robot::Model;
use lostmotion::scenario::{Limits, Scenario, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::files::{Files, MODEL, SCENARIO, URDF};

/// Numbers that a slip of the keyboard, a script or malice can write.
const NUMBERS: [&str; 26] = [
    "0",
    "-0.0",
    "-1",
    "1",
    "1e-3",
    "1e3",
    "1e-6",
    "1e6",
    "1e-9",
    "1e9",
    "1e-12",
    "1e12",
    "1e-15",
    "1e18",
    "1e-300",
    "1e300",
    "-1e300",
    "5e-324",
    "1.7976931348623157e308",
    "1e400",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "99999999999999999999",
    "0.1",
];

/// Values of other types.
const OTHERS: [&str; 8] = ["true", "\"\"", "\"text\"", "[]", "[1, 2]", "{}", "1979-05-27", "[[1], [2]]"];

/// A case may take so long, ten of them at once on two cores that others use as well. It is to take a hundredth of that.
const LONGEST: Duration = Duration::from_secs(20);

fn pick<'a>(rng: &mut ChaCha8Rng, of: &[&'a str]) -> &'a str {
    of[rng.random_range(0..of.len())]
}

/// Positions of the numbers in a text.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let bytes = text.as_bytes();
    let is_part = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'e' | b'+');
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let starts =
            bytes[at].is_ascii_digit() || (bytes[at] == b'-' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit));
        let free = at == 0 || matches!(bytes[at - 1], b' ' | b'=' | b'[' | b',' | b'"');
        if starts && free {
            let end = at + bytes[at..].iter().take_while(|&&byte| is_part(byte)).count();
            found.push((at, end));
            at = end;
        } else {
            at += 1;
        }
    }
    found
}

/// One to three changes: a number made extreme, a value of another type, a line dropped, doubled or moved, a few bytes cut.
fn broken(rng: &mut ChaCha8Rng, good: &str) -> String {
    let mut text = good.to_owned();
    for _ in 0..rng.random_range(1..4) {
        match rng.random_range(0..10) {
            0..6 => {
                let places = numbers(&text);
                if !places.is_empty() {
                    let (start, end) = places[rng.random_range(0..places.len())];
                    text.replace_range(start..end, pick(rng, &NUMBERS));
                }
            }
            6 => {
                let lines: Vec<&str> = text.lines().collect();
                let at = rng.random_range(0..lines.len().max(1));
                let Some((key, _)) = lines.get(at).and_then(|line| line.split_once(" = ")) else { continue };
                let changed = format!("{key} = {}", pick(rng, &OTHERS));
                text = [&lines[..at], &[changed.as_str()], &lines[at + 1..]].concat().join("\n");
            }
            kind => {
                let mut lines: Vec<&str> = text.lines().collect();
                if lines.is_empty() {
                    continue;
                }
                let (from, to) = (rng.random_range(0..lines.len()), rng.random_range(0..lines.len()));
                match kind {
                    7 => drop(lines.remove(from)),
                    8 => lines.insert(to, lines[from]),
                    _ => lines.swap(from, to),
                }
                text = lines.join("\n");
            }
        }
    }
    text
}

/// Reads the files as they are, and moves what they describe for a moment. Returns how far it came: 0 refused while reading, 1 refused
/// before it simulates, 2 simulated or given up underway.
fn carry_out(files: &Files) -> usize {
    if let Ok(model) = Model::load(&files.path("model.toml")) {
        model.notes();
    }
    let Ok(mut scenario) = Scenario::load(&files.path("scenario.toml"), &[]) else { return 0 };
    let Ok(cost) = scenario.cost() else { return 1 };
    assert!(cost.memory.is_finite() && cost.steps.is_finite(), "{cost:?}");
    // No more than a scenario of a few seconds takes; the limits of a user are wider and work alike.
    scenario.limits = Limits { memory: 2e8, steps: 3e4 };
    if scenario.check().is_err() {
        return 1;
    }
    simulate(&scenario, 1, &|_, _| {}).ok();
    2
}

/// Meshes of points that span nothing, lie on each other or far apart: a hull, or an error.
#[test]
fn property_no_mesh_of_odd_points_panics() {
    let files = Files::new();
    files.put("robot.urdf", URDF.replace("<box size=\"0.2 0.1 0.1\"/>", "<mesh filename=\"part.obj\"/>"));
    let mut rng = ChaCha8Rng::seed_from_u64(77);
    let mut read = 0;
    for _ in 0..200 {
        let count = rng.random_range(0..40);
        let sizes = [0, 1, 2].map(|_| [0.0, 1e-300, 1e-12, 1e-6, 0.1, 1e4][rng.random_range(0..6)]);
        let steps = [2.0, 3.0, 1e9][rng.random_range(0..3)];
        let mut text = String::new();
        for _ in 0..count {
            let [x, y, z] = sizes.map(|size| size * (rng.random::<f64>() * steps).floor() / steps);
            text += &format!("v {x} {y} {z}\n");
        }
        files.put("part.obj", text);
        // Refused where the mesh was not read: then the arm has nothing that the obstacle could be touched with.
        let scenario = Scenario::load(&files.path("scenario.toml"), &[]);
        read += usize::from(scenario.is_ok_and(|scenario| scenario.check().is_ok()));
    }
    assert!(read > 5, "{read}");
}

#[test]
fn property_no_broken_scenario_model_or_urdf_panics_hangs_or_swells() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let (cases, first) = (number("LOSTMOTION_FUZZ").unwrap_or(1200), number("LOSTMOTION_FUZZ_SEED").unwrap_or(0));
    let files = Files::new();
    let mut reached = [0_usize; 3];
    let mut slowest = (Duration::ZERO, 0);
    for seed in first..first + cases {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (name, good) =
            [("scenario.toml", SCENARIO), ("model.toml", MODEL), ("robot.urdf", URDF)][seed as usize % 3];
        files.put(name, broken(&mut rng, good));
        let start = Instant::now();
        reached[carry_out(&files)] += 1;
        let taken = start.elapsed();
        slowest = slowest.max((taken, seed));
        assert!(
            taken < LONGEST,
            "seed {seed}: {taken:?}\n{}",
            std::fs::read_to_string(files.path(name)).expect("text")
        );
        files.put(name, good);
    }
    println!("{reached:?} of {cases}, slowest {slowest:?}");
    // That nearly none is refused, or nearly none runs, would mean that the changes are none, or too many.
    assert!(reached.iter().all(|count| *count > cases as usize / 100), "{reached:?}");
}
