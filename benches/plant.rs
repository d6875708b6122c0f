//! How fast the simulated machine is: times real time, sensors on, 1 kHz control, fast motion; and an evaluation of `M` and `h`.
//!
//! `cargo bench --no-default-features --bench plant`. The throughput of a run is in items a second, an item being a simulated
//! millisecond: 200 000 items a second are 200 times real time. Beside it stand the error against the independent reference, and
//! for chains of 1 to 12 joints what a millisecond takes and which part of it the engine's own answers are.

#[path = "../tests/support/closed_loop.rs"]
mod closed_loop;
#[path = "../tests/support/machines.rs"]
mod machines;
#[path = "../tests/support/reference.rs"]
mod reference;

use std::time::Instant;

use closed_loop::{Loop, Trace, fast, truth};
use divan::Bencher;
use divan::counter::ItemsCount;
use lostmotion::drive::Motor;
use lostmotion::dynamics::Dynamics;
use lostmotion::plant::{Engine, Evaluations, Options, Plant, RigidBody, World};
use lostmotion::robot::Model;
use machines::{chain, geared, scara};
use nalgebra::DMatrix;
use rayon::prelude::*;

fn main() {
    default_settings();
    growth();
    divan::main();
}

const MILLISECONDS: usize = 2000;

/// PI velocity control of every joint along fast reversals, on the sensors.
fn run(plant: &mut Plant, joints: usize, milliseconds: usize) {
    let mut integral = vec![0.0; joints];
    let mut command = vec![0.0; joints];
    let gains: Vec<f64> = (0..joints).map(|j| if j == 0 { 40.0 } else { 20.0 }).collect();
    for k in 0..milliseconds {
        let t = k as f64 * 1e-3;
        let readings = plant.read();
        for j in 0..joints {
            let phase = j as f64;
            let reference = 2.0 * ((3.1 + 0.4 * phase) * t + phase).sin() * (0.7 * t).cos();
            let error = reference - readings[j].velocity;
            integral[j] += 10.0 * gains[j] * error * 1e-3;
            command[j] = gains[j] * error + integral[j];
        }
        plant.advance(&command, 1e-3).unwrap();
    }
}

/// Times real time of one run, the best of five; with its counts of evaluations, the engine's answers, steps and events.
fn pace(model: &Model, options: &Options, milliseconds: usize) -> (f64, [f64; 4]) {
    let (mut best, mut counts) = (0.0_f64, [0.0; 4]);
    for _ in 0..5 {
        let mut plant = Plant::new(model, options).unwrap();
        let start = Instant::now();
        run(&mut plant, model.joints.len(), milliseconds);
        best = best.max(milliseconds as f64 * 1e-3 / start.elapsed().as_secs_f64());
        let of = plant.counts();
        counts =
            [of.evaluations, of.confirmations, of.steps, of.events].map(|count| count as f64 / milliseconds as f64);
    }
    (best, counts)
}

/// Who evaluates the links, and how often.
const WAYS: [(&str, Engine, Evaluations); 3] = [
    ("rapier", Engine::Rapier, Evaluations::AsNeeded),
    ("rapier asked every millisecond", Engine::Rapier, Evaluations::EveryInterval),
    ("reduced", Engine::Reduced, Evaluations::EveryInterval),
];

/// Largest error [rad] of motor and link angles of the SCARA in closed loop on ideal sensors.
fn error(options: &Options, truth: &Trace) -> f64 {
    let mut plant = Plant::new(&scara(), &Options { ideal_sensors: true, ..options.clone() }).unwrap();
    let mut control = Loop::default();
    let mut worst = 0.0_f64;
    for (k, row) in truth.iter().enumerate() {
        let velocity = [0, 1].map(|joint| plant.states()[joint].motor_velocity);
        plant.advance(&control.command(fast(k as f64 * 1e-3), velocity), 1e-3).unwrap();
        let angles = plant.states().iter().flat_map(|state| [state.motor_position, state.link_position]);
        worst = angles.zip(row).map(|(angle, truth)| (angle - truth).abs()).fold(worst, f64::max);
    }
    worst
}

/// Speed and error of the SCARA at default settings, up to 120 deg/s.
fn default_settings() {
    let truth = truth(fast, 4.0, 1e-12);
    for (name, engine, evaluations) in WAYS {
        let options = Options { engine, evaluations, ..Options::default() };
        let (times, [evaluations, answers, steps, events]) = pace(&scara(), &options, MILLISECONDS);
        println!(
            "SCARA, {name}: {times:.0} times real time, error {:.1e} deg; a millisecond: {evaluations:.2} evaluations, \
             {answers:.2} answers between them, {steps:.2} steps, {events:.3} events",
            error(&options, &truth).to_degrees()
        );
    }
}

/// A chain whose gears fit their links, so that all lengths of it take equal steps: stiffness, damping, friction, rotor and
/// motor of every joint in proportion to the links that it carries.
fn fitted(joints: usize) -> Model {
    let mut model = geared(chain(joints));
    for (i, joint) in model.joints.iter_mut().enumerate() {
        let scale = 0.75_f64.powi(i as i32);
        for value in [&mut joint.gear_stiffness, &mut joint.gear_damping, &mut joint.rotor_inertia] {
            *value = value.map(|value| value * scale);
        }
        joint.motor = joint.motor.map(|motor| Motor { torque_constant: motor.torque_constant * scale, ..motor });
        if let Some(lostmotion::gearhead::FrictionLaw::Exponential(sides)) = joint.friction.as_mut().map(|f| &mut f.law)
        {
            for side in sides {
                (side.coulomb, side.breakaway, side.viscous) =
                    (side.coulomb * scale, side.breakaway * scale, side.viscous * scale);
            }
        }
    }
    model
}

/// What a millisecond of a chain costs: the project's own part, the engine's part, and what happens in it.
fn growth() {
    println!("joints | own [µs/ms] | own [µs/step] | rapier's part [µs/ms] | evaluations, steps, events a ms");
    for joints in [1, 2, 3, 6, 9, 12] {
        let model = fitted(joints);
        let cost = |engine| {
            let evaluations = Evaluations::EveryInterval;
            let (times, counts) = pace(&model, &Options { engine, evaluations, ..Options::default() }, 500);
            (1e3 / times, counts)
        };
        let (rapier, _) = cost(Engine::Rapier);
        let (own, [evaluations, _, steps, events]) = cost(Engine::Reduced);
        println!(
            "{joints:6} | {own:11.2} | {:13.3} | {:21.2} | {evaluations:.2}, {steps:.2}, {events:.3}",
            own / steps,
            rapier - own
        );
    }
}

fn scara_run(bencher: Bencher, engine: Engine, substeps: usize) {
    bencher
        .counter(ItemsCount::new(MILLISECONDS))
        .with_inputs(|| Plant::new(&scara(), &Options { engine, substeps, ..Options::default() }))
        .bench_local_values(|plant| plant.map(|mut plant| run(&mut plant, 2, MILLISECONDS)));
}

#[divan::bench(args = [2, 3, 5, 10], sample_count = 20)]
fn scara_on_rapier(bencher: Bencher, substeps: usize) {
    scara_run(bencher, Engine::Rapier, substeps);
}

#[divan::bench(args = [2, 3, 5, 10], sample_count = 20)]
fn scara_on_reduced(bencher: Bencher, substeps: usize) {
    scara_run(bencher, Engine::Reduced, substeps);
}

/// Eight runs that know nothing of each other, side by side on so many threads.
#[divan::bench(args = [1, 2], sample_count = 20)]
fn batch_on_rapier(bencher: Bencher, threads: usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    bencher.counter(ItemsCount::new(8 * MILLISECONDS)).bench_local(|| {
        pool.install(|| {
            (0..8).into_par_iter().for_each(|seed| {
                let mut plant = Plant::new(&scara(), &Options { seed, ..Options::default() }).unwrap();
                run(&mut plant, 2, MILLISECONDS);
            });
        });
    });
}

fn evaluation(bencher: Bencher, links: &mut dyn RigidBody, joints: usize) {
    let (mut mass, mut h) = (DMatrix::zeros(joints, joints), vec![0.0; joints]);
    let (mut q, v) = (vec![0.3; joints], vec![-1.0; joints]);
    bencher.bench_local(|| {
        q[0] += 1e-4;
        links.evaluate(&q, &v, &mut mass, &mut h);
    });
}

#[divan::bench(args = [2, 6, 12])]
fn evaluation_by_rapier(bencher: Bencher, joints: usize) {
    evaluation(bencher, &mut World::new(&chain(joints)), joints);
}

#[divan::bench(args = [2, 6, 12])]
fn evaluation_by_reduced(bencher: Bencher, joints: usize) {
    evaluation(bencher, &mut Dynamics::new(&chain(joints)), joints);
}
