//! This program's side of the comparison in README.md: the reference, and the planar arm's error and speed.
//!
//! `peers reference FOLDER` writes `fast.txt` and `slow.txt`. `peers run FOLDER` prints a row for every setting: engine, steps a
//! millisecond, motion, largest error of an angle [rad] with ideal sensors, and the CPU time [s] of each run.
//! `peers batch FOLDER THREADS` prints the wall time [s] of a batch of runs on that many threads.

#[path = "../../tests/support/closed_loop.rs"]
mod closed_loop;
#[path = "../../tests/support/machines.rs"]
mod machines;
#[path = "../../tests/support/reference.rs"]
mod reference;

use std::error::Error;
use std::ffi::c_long;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use closed_loop::{Loop, Motion, fast, slow, truth};
use lostmotion::plant::{Engine, Evaluations, Options, Plant};
use machines::scara;
use rayon::prelude::*;

/// [s] Length of a motion.
const SECONDS: f64 = 4.0;
/// Runs of a motion that are timed, one after the other.
const TIMED: usize = 5;
/// Runs of a batch.
const BATCH: usize = 32;

unsafe extern "C" {
    /// CPU time of the process [µs], as POSIX has it. The other side uses it too: a busy machine disturbs it less than wall time.
    safe fn clock() -> c_long;
}

/// A line a millisecond: the velocities wanted during it [rad/s], and θ₁ q₁ θ₂ q₂ [rad] at its end.
fn write_reference(path: &Path, motion: Motion) -> Result<(), Box<dyn Error>> {
    let mut text = String::new();
    for (k, [theta1, q1, theta2, q2]) in truth(motion, SECONDS, 1e-12).into_iter().enumerate() {
        let [w1, w2] = motion(k as f64 * 1e-3);
        writeln!(text, "{w1:e} {w2:e} {theta1:e} {q1:e} {theta2:e} {q2:e}")?;
    }
    Ok(std::fs::write(path, text)?)
}

fn read_reference(path: &Path) -> Result<Vec<[f64; 6]>, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    text.lines()
        .map(|line| {
            let numbers = line.split(' ').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
            Ok(numbers.try_into().map_err(|_| "six numbers a line")?)
        })
        .collect()
}

/// A run of a machine from rest under control by what the sensors say: the largest error of an angle [rad].
fn run(plant: &mut Plant, truth: &[[f64; 6]]) -> Result<f64, Box<dyn Error>> {
    let mut control = Loop::default();
    let mut worst = 0.0_f64;
    for &[w1, w2, theta1, q1, theta2, q2] in truth {
        let readings = plant.read();
        let command = control.command([w1, w2], [readings[0].velocity, readings[1].velocity]);
        plant.advance(&command, 1e-3)?;
        for (state, [theta, q]) in plant.states().iter().zip([[theta1, q1], [theta2, q2]]) {
            worst = worst.max((state.motor_position - theta).abs()).max((state.link_position - q).abs());
        }
    }
    Ok(worst)
}

/// A row of the table.
fn measure(name: &str, options: &Options, truth: &[[f64; 6]], motion: &str) -> Result<(), Box<dyn Error>> {
    let error = run(&mut Plant::new(&scara(), &Options { ideal_sensors: true, ..options.clone() })?, truth)?;
    print!("lostmotion {name} {} {motion} {error:e}", options.substeps);
    for _ in 0..TIMED {
        // Neither side counts the reading and building of its model.
        let mut plant = Plant::new(&scara(), options)?;
        let start = clock();
        run(&mut plant, truth)?;
        print!(" {:.6}", (clock() - start) as f64 * 1e-6);
    }
    println!();
    Ok(())
}

fn measure_all(truth: &[[f64; 6]], motion: &str) -> Result<(), Box<dyn Error>> {
    let ways = [
        ("rapier", Engine::Rapier, Evaluations::AsNeeded),
        ("rapier-each-ms", Engine::Rapier, Evaluations::EveryInterval),
        ("reduced", Engine::Reduced, Evaluations::EveryInterval),
    ];
    for (name, engine, evaluations) in ways {
        for substeps in [2, 3, 5, 10] {
            let options = Options { engine, evaluations, substeps, ..Options::default() };
            measure(&format!("{name}/sensors"), &options, truth, motion)?;
            measure(&format!("{name}/ideal"), &Options { ideal_sensors: true, ..options }, truth, motion)?;
        }
    }
    let ways = [
        ("rapier-coarse", Engine::Rapier, Evaluations::AsNeeded),
        ("rapier-each-ms-coarse", Engine::Rapier, Evaluations::EveryInterval),
        ("reduced-coarse", Engine::Reduced, Evaluations::AsNeeded),
    ];
    for (name, engine, evaluations) in ways {
        let options = Options { engine, evaluations, ..Options::coarse() };
        measure(&format!("{name}/sensors"), &options, truth, motion)?;
        measure(&format!("{name}/ideal"), &Options { ideal_sensors: true, ..options }, truth, motion)?;
    }
    Ok(())
}

/// Wall time [s] of a batch of runs at the default settings, each with a seed of its own.
fn batch(threads: usize, truth: &[[f64; 6]]) -> Result<f64, Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let start = Instant::now();
    let errors: Vec<f64> = pool.install(|| {
        (0..BATCH)
            .into_par_iter()
            .map(|seed| {
                let plant = Plant::new(&scara(), &Options { seed: seed as u64, ..Options::default() });
                plant.map_err(Into::into).and_then(|mut plant| run(&mut plant, truth)).unwrap_or(f64::NAN)
            })
            .collect()
    });
    if errors.iter().any(|error| error.is_nan()) {
        Err("a run of the batch failed".into())
    } else {
        Ok(start.elapsed().as_secs_f64())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let path = |folder: &str, motion: &str| Path::new(folder).join(format!("{motion}.txt"));
    match words[..] {
        ["reference", folder] => {
            write_reference(&path(folder, "fast"), fast)?;
            write_reference(&path(folder, "slow"), slow)
        }
        ["run", folder] => {
            ["fast", "slow"].iter().try_for_each(|motion| measure_all(&read_reference(&path(folder, motion))?, motion))
        }
        ["batch", folder, threads] => {
            println!("{:.6}", batch(threads.parse()?, &read_reference(&path(folder, "fast"))?)?);
            Ok(())
        }
        _ => Err("usage: peers reference FOLDER | run FOLDER | batch FOLDER THREADS".into()),
    }
}
