//! The paper's uniform staircase of a given length: that of scenario 01 with fewer or longer steps.

use std::path::{Path, PathBuf};

use lostmotion::plant::Engine;
use lostmotion::scenario::Scenario;

/// Numbers of speeds that are tried, from 0.5 to 10 deg/s: the paper's first.
const SPEEDS: [u32; 5] = [20, 15, 10, 7, 5];
/// [s] Least steady time of a step: that of joint 2 in scenario 01.
const STEADY: f64 = 0.8;
/// Keys and values of both joints in the scenario file.
const INCREMENT: &str = "increment_deg = 0.5";
const STEADY_TIMES: [&str; 2] = ["steady_time = 1.2 ", "steady_time = 0.8\n"];

/// A staircase of both joints; not every user prints its length and number of speeds.
#[allow(dead_code)]
pub struct Staircase {
    /// Scenario 01 with it.
    pub scenario: Scenario,
    /// [s]
    pub seconds: f64,
    /// Number of its speeds.
    pub speeds: u32,
}

fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/01_identify_scara/scenario.toml")
}

/// Scenario 01 as it is.
pub fn scenario_01() -> Result<Scenario, String> {
    Scenario::load(&file(), &[]).map_err(|why| why.to_string())
}

/// The staircase with as many speeds as can be steady for 0.8 s; both joints have half of `seconds`.
pub fn staircase(seconds: f64) -> Result<Staircase, String> {
    let text = std::fs::read_to_string(file()).map_err(|why| why.to_string())?;
    for speeds in SPEEDS {
        let scenario = |steady: [f64; 2]| {
            let mut text = text.replace(INCREMENT, &format!("increment_deg = {}", 9.5 / f64::from(speeds - 1)));
            for (old, new) in STEADY_TIMES.iter().zip(steady) {
                text = text.replace(old, &format!("steady_time = {new}\n"));
            }
            Scenario::from_text(&text, &file(), &[]).map_err(|why| why.to_string())
        };
        // Lengths grow by two steps per speed.
        let shortest = scenario([0.0; 2])?;
        let steady: Vec<f64> = shortest
            .sessions
            .iter()
            .map(|session| (0.5 * seconds - session.duration) / f64::from(2 * speeds))
            .collect();
        if steady.iter().all(|steady| *steady >= STEADY) || speeds == SPEEDS[SPEEDS.len() - 1] {
            let mut scenario = scenario([steady[0].max(0.0), steady[1].max(0.0)])?;
            scenario.options.engine = Engine::Reduced;
            let seconds = scenario.sessions.iter().map(|session| session.duration).sum();
            return Ok(Staircase { scenario, seconds, speeds });
        }
    }
    Err("no number of speeds".to_owned())
}
