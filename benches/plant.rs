//! How fast the simulated machine is: times real time, sensors on, 1 kHz control, fast motion; and an evaluation of `M` and `h`.
//!
//! `cargo bench --no-default-features --bench plant`. The throughput of a run is in items a second, an item being a simulated
//! millisecond: 200 000 items a second are 200 times real time.

#[path = "../tests/support/machines.rs"]
mod machines;

use divan::Bencher;
use divan::counter::ItemsCount;
use lostmotion::dynamics::Dynamics;
use lostmotion::plant::{Engine, Options, Plant, RigidBody, World};
use machines::{chain, geared, scara};
use nalgebra::DMatrix;

fn main() {
    divan::main();
}

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

fn scara_run(bencher: Bencher, engine: Engine, substeps: usize) {
    const MILLISECONDS: usize = 2000;
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

fn chain_run(bencher: Bencher, engine: Engine, joints: usize) {
    const MILLISECONDS: usize = 500;
    bencher
        .counter(ItemsCount::new(MILLISECONDS))
        .with_inputs(|| Plant::new(&geared(chain(joints)), &Options { engine, ..Options::default() }))
        .bench_local_values(|plant| plant.map(|mut plant| run(&mut plant, joints, MILLISECONDS)));
}

#[divan::bench(args = [1, 2, 6, 12], sample_count = 20)]
fn chain_on_rapier(bencher: Bencher, joints: usize) {
    chain_run(bencher, Engine::Rapier, joints);
}

#[divan::bench(args = [1, 2, 6, 12], sample_count = 20)]
fn chain_on_reduced(bencher: Bencher, joints: usize) {
    chain_run(bencher, Engine::Reduced, joints);
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
