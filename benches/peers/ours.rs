//! This program's side of the comparison in README.md: the reference, and the planar arm's error and speed.
//!
//! `peers reference FOLDER` writes `fast.txt` and `slow.txt`. `peers run FOLDER` prints a row for every setting: engine, steps a
//! millisecond, motion, largest error of an angle [rad] with ideal sensors, and the CPU time [s] of each run.
//! `peers batch FOLDER THREADS` prints the wall time [s] of a batch of runs on that many threads.

#[path = "../../tests/support/machines.rs"]
mod machines;
#[path = "../../tests/support/reference.rs"]
mod reference;

use std::error::Error;
use std::ffi::c_long;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use lostmotion::plant::{Engine, Options, Plant};
use machines::*;
use rayon::prelude::*;
use reference::{Arm, Gearhead};

/// Milliseconds of a motion.
const LENGTH: usize = 4000;
/// Runs of a motion that are timed, one after the other.
const TIMED: usize = 5;
/// Runs of a batch.
const BATCH: usize = 32;

unsafe extern "C" {
    /// CPU time of the process [µs], as POSIX has it. The other side uses it too: a busy machine disturbs it less than wall time.
    safe fn clock() -> c_long;
}

/// Up to 120 deg/s on both joints, with reversals: the references of their velocities [rad/s].
fn fast(t: f64) -> [f64; 2] {
    [2.0 * (3.1 * t).sin() * (0.7 * t).cos(), 2.0 * (4.3 * t + 0.4).sin() * (0.5 * t + 0.3).sin()]
}

/// One joint at a time to and fro, at rest in between: it sticks, breaks away, crosses the gap.
fn slow(t: f64) -> [f64; 2] {
    let speed = [0.009, -0.009, 0.03, -0.03, 0.0, 0.1, -0.1, 0.0][(2.0 * t) as usize % 8];
    if t < 2.0 { [speed, 0.0] } else { [0.0, speed] }
}

/// PI control of the motors' velocities, at 1 kHz.
#[derive(Default)]
struct Loop {
    integral: [f64; 2],
}

impl Loop {
    /// Currents [A] for these velocities [rad/s].
    fn command(&mut self, wanted: [f64; 2], velocity: [f64; 2]) -> [f64; 2] {
        let (kp, ki, kt) = ([5.0, 1.5], [50.0, 15.0], [5.375 * 0.023, 10.0 / 3.0 * 0.023]);
        std::array::from_fn(|j| {
            let error = wanted[j] - velocity[j];
            self.integral[j] += ki[j] * error * 1e-3;
            (kp[j] * error + self.integral[j]) / kt[j]
        })
    }
}

/// The arm as the reference wants it.
fn arm() -> Arm {
    let [first, second] = [0, 1].map(|i| {
        let joint = &scara().joints[i];
        let friction = joint.friction.expect("the arm has friction");
        let lostmotion::gearhead::FrictionLaw::Exponential([law, _]) = friction.law else { unreachable!() };
        Gearhead {
            rotor: joint.reflected_inertia(),
            k: joint.gear_stiffness,
            d: joint.gear_damping,
            gap: joint.backlash.unwrap_or(0.0),
            coulomb: law.coulomb,
            breakaway: law.breakaway,
            stribeck: law.stribeck_velocity,
            viscous: law.viscous,
            link_share: friction.link_share,
            kt: joint.torque_per_ampere(),
            r: joint.motor.resistance.unwrap_or(0.0),
            l: joint.motor.inductance.unwrap_or(0.0),
            volts: joint.amplifier.voltage_limit,
            amperes: joint.amplifier.current_limit,
            loop_time: joint.amplifier.current_time_constant,
        }
    });
    Arm { a: I1 + M1 * C1 * C1 + M2 * L1 * L1, b: I2 + M2 * C2 * C2, c: M2 * L1 * C2, gears: [first, second] }
}

/// A line a millisecond: the velocities wanted during it [rad/s], and θ₁ q₁ θ₂ q₂ [rad] at its end.
fn write_reference(path: &Path, motion: fn(f64) -> [f64; 2]) -> Result<(), Box<dyn Error>> {
    let mut truth = reference::Run::at_rest(arm(), [0.0, 0.0]);
    let mut control = Loop::default();
    let mut text = String::new();
    for k in 0..LENGTH {
        let wanted = motion(k as f64 * 1e-3);
        truth.advance(&control.command(wanted, [truth.y[1], truth.y[6]]), 1e-3);
        let y = &truth.y;
        writeln!(text, "{:e} {:e} {:e} {:e} {:e} {:e}", wanted[0], wanted[1], y[0], y[2], y[5], y[7])?;
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

/// A run under control by what the sensors say: the largest error of an angle [rad].
fn run(options: &Options, truth: &[[f64; 6]]) -> Result<f64, Box<dyn Error>> {
    let mut plant = Plant::new(&scara(), options)?;
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
    let error = run(&Options { ideal_sensors: true, ..options.clone() }, truth)?;
    print!("lostmotion {name} {} {motion} {error:e}", options.substeps);
    for _ in 0..TIMED {
        let start = clock();
        run(options, truth)?;
        print!(" {:.6}", (clock() - start) as f64 * 1e-6);
    }
    println!();
    Ok(())
}

fn measure_all(truth: &[[f64; 6]], motion: &str) -> Result<(), Box<dyn Error>> {
    for (name, engine) in [("rapier", Engine::Rapier), ("reduced", Engine::Reduced)] {
        for substeps in [3, 5, 10] {
            let options = Options { engine, substeps, ..Options::default() };
            measure(&format!("{name}/sensors"), &options, truth, motion)?;
            measure(&format!("{name}/ideal"), &Options { ideal_sensors: true, ..options }, truth, motion)?;
        }
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
            .map(|seed| run(&Options { seed: seed as u64, ..Options::default() }, truth).unwrap_or(f64::NAN))
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
