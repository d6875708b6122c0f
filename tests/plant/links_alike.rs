//! The simulated machine against closed forms of its links, its other engine, and its own books.

use crate::engines::both_engines;
use crate::machines::*;
use lostmotion::dynamics::Dynamics;
use lostmotion::plant::{Options, Plant, RigidBody, World};
use nalgebra::DMatrix;

fn ideal() -> Options {
    Options { ideal_sensors: true, ..Options::default() }
}

#[test]
fn analytic_planar_arm_mass_and_bias_of_rapier() {
    let mut world = World::new(&planar_arm());
    let (mut mass, mut h) = (DMatrix::zeros(2, 2), vec![0.0; 2]);
    let a = I1 + M1 * C1 * C1 + M2 * L1 * L1;
    let b = I2 + M2 * C2 * C2;
    let c = M2 * L1 * C2;
    for (q, v) in [([0.3, -1.2], [2.0, -3.0]), ([-2.0, 2.5], [0.5, 7.0]), ([0.0, 0.0], [0.0, 0.0])] {
        world.evaluate(&q, &v, &mut mass, &mut h);
        let (cos, sin) = (q[1].cos(), q[1].sin());
        let m = [[a + b + 2.0 * c * cos, b + c * cos], [b + c * cos, b]];
        let bias = [-c * sin * (2.0 * v[0] * v[1] + v[1] * v[1]), c * sin * v[0] * v[0]];
        for i in 0..2 {
            for j in 0..2 {
                // 1e-12: rounding of a dozen products of order one.
                assert!((mass[(i, j)] - m[i][j]).abs() < 1e-12, "M[{i}][{j}] = {}, {}", mass[(i, j)], m[i][j]);
            }
            // 1e-9: the oracle's step of 1e-12 s moves the machine by v dt, and divides rounding by nothing.
            assert!((h[i] - bias[i]).abs() < 1e-9, "h[{i}] = {}, {}", h[i], bias[i]);
        }
    }
}

#[test]
fn property_energy_closes_with_everything_on() {
    let mut plant = Plant::new(&scara(), &ideal()).unwrap();
    plant.place(&[0.3, -0.5]);
    let start = plant.energy();
    for k in 0..5000 {
        let t = f64::from(k) * 1e-3;
        plant.advance(&[6.0 * (3.0 * t).sin(), 4.0 * (5.0 * t + 1.0).sin()], 1e-3).unwrap();
    }
    let end = plant.energy();
    let gap = end.work - end.dissipated - (end.stored - start.stored);
    println!("{end:?} gap {gap:e}");
    assert!(gap.abs() < 1e-4 * end.work, "{gap:e} of {}", end.work);
}

#[test]
fn equivalent_engines_agree_on_random_trees() {
    let mut noise = lostmotion::drive::Noise::new(7, 0);
    for round in 0..40 {
        let robot = random_tree(|| noise.uniform(), 1 + round % 8);
        let n = robot.dof();
        let (mut world, mut own) = (World::new(&robot), Dynamics::new(&robot));
        let (mut mass, mut h) = ([DMatrix::zeros(n, n), DMatrix::zeros(n, n)], [vec![0.0; n], vec![0.0; n]]);
        for _ in 0..5 {
            let q: Vec<f64> = (0..n).map(|_| 6.0 * noise.uniform() - 3.0).collect();
            let v: Vec<f64> = (0..n).map(|_| 6.0 * noise.uniform() - 3.0).collect();
            world.evaluate(&q, &v, &mut mass[0], &mut h[0]);
            own.evaluate(&q, &v, &mut mass[1], &mut h[1]);
            let scale = 1.0 + mass[1].amax();
            assert!((&mass[0] - &mass[1]).amax() < 1e-12 * scale, "mass of {n} joints");
            // The oracle's step moves the machine by v dt = 3e-12: its bias is of that moment.
            for i in 0..n {
                assert!((h[0][i] - h[1][i]).abs() < 1e-9 * (1.0 + h[1][i].abs()), "h of {n}: {:?} {:?}", h[0], h[1]);
            }
        }
    }
}

#[test]
fn equivalent_engines_give_the_same_traces() {
    let mut plants = both_engines(&scara());
    let mut worst = 0.0_f64;
    for k in 0..3000 {
        let t = f64::from(k) * 1e-3;
        let command = [6.0 * (3.0 * t).sin(), 4.0 * (5.0 * t + 1.0).sin()];
        plants.iter_mut().for_each(|plant| plant.advance(&command, 1e-3).unwrap());
        for (a, b) in plants[0].states().iter().zip(plants[1].states()) {
            worst = worst.max((a.link_position - b.link_position).abs());
            worst = worst.max((a.motor_position - b.motor_position).abs());
        }
    }
    // 1e-8 rad: the engines' biases differ by 1e-11, and friction does not amplify it much in three seconds.
    assert!(worst < 1e-8, "{worst:e}");
}

#[test]
fn property_reruns_are_bit_identical() {
    let trace = || {
        let mut plant = Plant::new(&scara(), &Options::default()).unwrap();
        let mut bits = Vec::new();
        for k in 0..500 {
            bits.extend(plant.read().iter().flat_map(|r| [r.position, r.velocity, r.current].map(f64::to_bits)));
            plant.advance(&[3.0 * (f64::from(k) * 0.02).sin(), 2.0], 1e-3).unwrap();
        }
        bits
    };
    let here = trace();
    assert_eq!(here, trace());
    assert_eq!(here, std::thread::spawn(trace).join().unwrap());
}

#[test]
fn property_uneven_periods_change_nothing() {
    // A constant command in pieces of all lengths, some of them nothing.
    let run = |lengths: &[f64]| {
        let mut plant = Plant::new(&scara(), &ideal()).unwrap();
        for _ in 0..100 {
            lengths.iter().for_each(|&length| plant.advance(&[4.0, -2.0], length).unwrap());
        }
        let states = plant.states();
        assert!((plant.time() - 1.0).abs() < 1e-9);
        [states[0].link_position, states[1].link_position]
    };
    let even = run(&[1e-3; 10]);
    let uneven = run(&[0.0, 1e-6, 2.5e-3, 0.0, 1e-4, -1.0, 4.9e-3, 2.499e-3]);
    for (a, b) in even.iter().zip(&uneven) {
        // Both within the plant's own error: 1e-4 degrees.
        assert!((a - b).abs() < 1.7e-6, "{even:?} {uneven:?}");
    }
}

/// The SCARA after some motion, under commands of an instant on.
fn driven(plant: &mut Plant, from: u32, to: u32) {
    for k in from..to {
        let t = f64::from(k) * 1e-3;
        plant.advance(&[6.0 * (3.0 * t).sin(), 4.0 * (5.0 * t + 1.0).sin()], 1e-3).unwrap();
    }
}

#[test]
fn property_a_machine_goes_on_from_its_state_as_if_it_had_come_there_itself() {
    let [mut plant, mut other] = [0, 1].map(|_| Plant::new(&scara(), &ideal()).unwrap());
    plant.place(&[0.3, -0.5]);
    driven(&mut plant, 0, 700);
    other.launch_at(plant.time(), plant.states());
    assert!((other.time() - 0.7).abs() < 1e-9);
    [&mut plant, &mut other].into_iter().for_each(|one| driven(one, 700, 1400));
    for (one, other) in plant.states().iter().zip(other.states()) {
        // The engine's answers are interpolated from other instants: the error of a simulation, 2e-5 degrees.
        assert!((one.link_position - other.link_position).abs() < 1e-6, "{one:?} {other:?}");
    }
}

#[test]
fn property_a_shifted_joint_moves_as_before_where_no_law_depends_on_its_position() {
    const WAY: f64 = 0.1;
    let [mut plant, mut shifted] = [0, 1].map(|_| Plant::new(&scara(), &ideal()).unwrap());
    [&mut plant, &mut shifted].into_iter().for_each(|one| {
        one.place(&[0.3, -0.5]);
        driven(one, 0, 700);
    });
    // The first axis is vertical: the arm moves in the same way wherever it points.
    shifted.shift(0, WAY, 0.0);
    assert_eq!(plant.states()[0].gear_torque, shifted.states()[0].gear_torque);
    [&mut plant, &mut shifted].into_iter().for_each(|one| driven(one, 700, 1400));
    for (joint, way) in [WAY, 0.0].into_iter().enumerate() {
        let [one, other] = [&plant, &shifted].map(|one| one.states()[joint]);
        assert!((other.motor_position - one.motor_position - way).abs() < 1e-6, "{one:?} {other:?}");
        assert!((other.link_position - one.link_position - way).abs() < 1e-6, "{one:?} {other:?}");
    }
}
