//! The simulated machine against closed forms, an independent reference, and its own books.

#[path = "support/machines.rs"]
mod machines;
#[path = "support/reference.rs"]
mod reference;

use lostmotion::dynamics::Dynamics;
use lostmotion::effects::JointState;
use lostmotion::plant::{Engine, Options, Plant, RigidBody, World};
use machines::*;
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
    let mut plants =
        [Engine::Rapier, Engine::Reduced].map(|engine| Plant::new(&scara(), &Options { engine, ..ideal() }).unwrap());
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

/// The machine of [`scara`] as the reference wants it.
fn reference() -> reference::Run {
    let gears = [
        (5.375, 6.29e-4, 0.0103, 0.442, 0.509, 0.0603, 0.407),
        (10.0 / 3.0, 1.903e-3, 0.0064, 0.173, 0.187, 0.0408, 0.187),
    ]
    .map(|(ratio, rotor, gap, coulomb, breakaway, stribeck, viscous)| reference::Gearhead {
        rotor: ratio * ratio * rotor,
        k: 3000.0,
        d: 2.0,
        gap,
        coulomb,
        breakaway,
        stribeck,
        viscous,
        link_share: 0.4,
        kt: ratio * 0.023,
        r: 0.5,
        l: 0.0005,
        volts: 24.0,
        amperes: 18.0,
        loop_time: 4e-4,
    });
    let arm = reference::Arm { a: I1 + M1 * C1 * C1 + M2 * L1 * L1, b: I2 + M2 * C2 * C2, c: M2 * L1 * C2, gears };
    reference::Run::at_rest(arm, [0.0, 0.0])
}

/// A PI velocity controller a joint, sampled at 1 kHz.
#[derive(Default)]
struct Loop {
    integral: [f64; 2],
}

impl Loop {
    fn command(&mut self, reference: [f64; 2], velocity: [f64; 2]) -> [f64; 2] {
        let (kp, ki, kt) = ([5.0, 1.5], [50.0, 15.0], [5.375 * 0.023, 10.0 / 3.0 * 0.023]);
        let mut command = [0.0; 2];
        for j in 0..2 {
            let error = reference[j] - velocity[j];
            self.integral[j] += ki[j] * error * 1e-3;
            command[j] = (kp[j] * error + self.integral[j]) / kt[j];
        }
        command
    }
}

/// Largest difference of motor and link angles [rad] from the reference in closed loop.
fn error_against_reference(options: &Options, seconds: f64, motion: impl Fn(f64) -> [f64; 2]) -> f64 {
    let mut truth = reference();
    let mut plant = Plant::new(&scara(), options).unwrap();
    let (mut of_truth, mut of_plant) = (Loop::default(), Loop::default());
    let mut worst = 0.0_f64;
    for k in 0..(seconds * 1e3) as usize {
        let wanted = motion(k as f64 * 1e-3);
        truth.advance(&of_truth.command(wanted, [truth.y[1], truth.y[6]]), 1e-3);
        let states = plant.states();
        let command = of_plant.command(wanted, [states[0].motor_velocity, states[1].motor_velocity]);
        plant.advance(&command, 1e-3).unwrap();
        for (j, state) in plant.states().iter().enumerate() {
            worst = worst.max((state.motor_position - truth.y[5 * j]).abs());
            worst = worst.max((state.link_position - truth.y[5 * j + 2]).abs());
        }
    }
    worst
}

/// Up to 120 deg/s on both joints, with reversals.
fn fast(t: f64) -> [f64; 2] {
    [2.0 * (3.1 * t).sin() * (0.7 * t).cos(), 2.0 * (4.3 * t + 0.4).sin() * (0.5 * t + 0.3).sin()]
}

/// One joint at a time to and fro, at rest in between: it sticks, breaks away, crosses the gap.
fn slow(t: f64) -> [f64; 2] {
    let speed = [0.009, -0.009, 0.03, -0.03, 0.0, 0.1, -0.1, 0.0][(2.0 * t) as usize % 8];
    if t < 2.0 { [speed, 0.0] } else { [0.0, speed] }
}

#[test]
fn equivalent_closed_loop_with_dormand_prince() {
    for (name, motion) in [("fast", fast as fn(f64) -> [f64; 2]), ("slow", slow)] {
        for engine in [Engine::Rapier, Engine::Reduced] {
            let error = error_against_reference(&Options { engine, ..ideal() }, 4.0, motion).to_degrees();
            println!("{name} {engine:?}: {error:.2e} deg");
            // What is asked of the plant: a thirtieth of an encoder count is 1e-3 degrees.
            assert!(error < 1e-4, "{name} {engine:?}: {error:e} deg");
        }
    }
}

#[test]
fn equivalent_order_of_convergence_is_four() {
    let error = |substeps| {
        let options = Options { substeps, every_stage: true, engine: Engine::Reduced, ..ideal() };
        error_against_reference(&options, 1.0, fast)
    };
    let (coarse, middle, fine) = (error(4), error(8), error(16));
    println!("{coarse:e} {middle:e} {fine:e}");
    // Halving the step divides the error by 16; events within a step make it uneven, so 10 is what is asked.
    assert!(coarse / middle > 10.0 && coarse > 1e-9, "{coarse:e} {middle:e} {fine:e}");
}

/// Gears that do nothing: the links alone.
fn links_alone() -> Plant {
    let mut model = plain(planar_arm());
    for joint in &mut model.joints {
        (joint.gear_stiffness, joint.gear_damping) = (1e-12, 0.0);
    }
    Plant::new(&model, &ideal()).unwrap()
}

#[test]
fn property_free_arm_keeps_its_energy_for_a_minute() {
    let mut plant = links_alone();
    let moving = |link_velocity| JointState { link_velocity, ..JointState::default() };
    plant.launch(&[moving(2.0), moving(-3.0)]);
    let start = plant.energy().stored;
    let mut worst = 0.0_f64;
    for _ in 0..60_000 {
        plant.advance(&[0.0, 0.0], 1e-3).unwrap();
        worst = worst.max((plant.energy().stored / start - 1.0).abs());
    }
    println!("energy drift in 60 s: {worst:.1e}");
    // What the issue of exactness asks of links alone.
    assert!(worst < 1e-8, "{worst:e}");
}

/// Links and gears of the planar arm without friction, gap and damping, integrated by classical Runge-Kutta 4 at 10 µs.
fn smooth_reference(torque: impl Fn(f64) -> [f64; 2], seconds: f64) -> [f64; 4] {
    let (a, b, c, j, k) = (I1 + M1 * C1 * C1 + M2 * L1 * L1, I2 + M2 * C2 * C2, M2 * L1 * C2, 0.02, 3000.0);
    let rate = |t: f64, y: &[f64; 8]| {
        let [theta1, theta2, q1, q2, w1, w2, v1, v2] = *y;
        let gear = [k * (theta1 - q1) + 2.0 * (w1 - v1), k * (theta2 - q2) + 2.0 * (w2 - v2)];
        let (m11, m12, m22) = (a + b + 2.0 * c * q2.cos(), b + c * q2.cos(), b);
        let r1 = gear[0] + c * q2.sin() * (2.0 * v1 * v2 + v2 * v2);
        let r2 = gear[1] - c * q2.sin() * v1 * v1;
        let det = m11 * m22 - m12 * m12;
        let motor = torque(t);
        [
            w1,
            w2,
            v1,
            v2,
            (motor[0] - gear[0]) / j,
            (motor[1] - gear[1]) / j,
            (m22 * r1 - m12 * r2) / det,
            (m11 * r2 - m12 * r1) / det,
        ]
    };
    let h = 1e-5;
    let mut y = [0.0; 8];
    for step in 0..(seconds / h).round() as usize {
        // The command holds for a millisecond: a stage at the end of a step belongs to the millisecond of its start.
        let t = (step / 100) as f64 * 1e-3;
        let along = |k: &[f64; 8], s: f64| std::array::from_fn(|i| y[i] + s * k[i]);
        let k1 = rate(t, &y);
        let k2 = rate(t, &along(&k1, 0.5 * h));
        let k3 = rate(t, &along(&k2, 0.5 * h));
        let k4 = rate(t, &along(&k3, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
    }
    [y[0], y[1], y[2], y[3]]
}

#[test]
fn equivalent_smooth_motion_at_default_settings() {
    let torque = |t: f64| [0.9 * (5.0 * t).sin(), 0.25 * (7.0 * t).cos() - 0.1];
    let expected = smooth_reference(torque, 2.0);
    for engine in [Engine::Rapier, Engine::Reduced] {
        let mut plant = Plant::new(&plain(planar_arm()), &Options { engine, ..ideal() }).unwrap();
        let mut fastest = 0.0_f64;
        for k in 0..2000 {
            plant.advance(&torque(f64::from(k) * 1e-3), 1e-3).unwrap();
            fastest = plant.states().iter().map(|s| s.link_velocity.abs()).fold(fastest, f64::max);
        }
        let states = plant.states();
        let found =
            [states[0].motor_position, states[1].motor_position, states[0].link_position, states[1].link_position];
        let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{engine:?}: {worst:.1e} rad at up to {:.0} deg/s", fastest.to_degrees());
        assert!(worst < 1e-6, "{engine:?} {worst:e}");
        assert!(fastest > 1.5, "the motion is to be fast: {fastest}");
    }
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
