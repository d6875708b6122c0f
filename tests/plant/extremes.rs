//! The simulated machine where it is driven beyond reason: it says so, or goes on at a bounded cost.

use crate::machines::*;
use lostmotion::effects::JointState;
use lostmotion::error::Error;
use lostmotion::gearhead::{Friction, FrictionLaw, Lines};
use lostmotion::plant::{Engine, FASTEST_MOTION, Options, Plant};
use lostmotion::robot::JointModel;

fn diverged(result: Result<(), Error>) -> (f64, String, &'static str, f64) {
    match result {
        Err(Error::Diverged { time, joint, quantity, value, .. }) => (time, joint, quantity, value),
        other => panic!("expected a divergence, not {other:?}"),
    }
}

#[test]
fn property_a_diverging_loop_ends_in_an_error_that_says_where() {
    for (robot, engine) in [planar_arm(), turntable(0.1)].into_iter().zip([Engine::Rapier, Engine::Reduced]) {
        let n = robot.dof();
        let mut plant = Plant::new(&plain(robot), &Options { engine, ..Options::default() }).unwrap();
        plant.launch(&vec![JointState { motor_velocity: 1e-3, ..JointState::default() }; n]);
        // Dampers with the wrong sign: on rotor and table, e^{4 t / 0.12} of 1e-3 rad/s passes 1e4 rad/s after half a second.
        let run = (0..1000).try_for_each(|_| {
            let command: Vec<f64> = plant.states().iter().map(|state| 4.0 * state.motor_velocity).collect();
            assert!(command.iter().all(|current| current.is_finite()), "a state that is no number was shown");
            plant.advance(&command, 1e-3)
        });
        let (time, joint, quantity, value) = diverged(run);
        println!("{engine:?}: {quantity} of {joint} {value:e} at {time}");
        assert!(joint.starts_with("joint") && quantity.ends_with("velocity"), "{joint} {quantity}");
        assert!((value.is_nan() || value.abs() > FASTEST_MOTION) && time < 0.7, "{value:e} at {time}");
        // Placed anew, the same machine works.
        plant.place(&vec![0.1; n]);
        plant.advance(&vec![0.1; n], 0.1).unwrap();
        assert!(plant.states().iter().all(|state| state.link_position.is_finite()));
    }
}

#[test]
fn property_a_command_that_is_no_number_is_refused() {
    let mut plant = Plant::new(&scara(), &Options::default()).unwrap();
    let (time, joint, quantity, value) = diverged(plant.advance(&[0.0, f64::NAN], 1e-3));
    assert_eq!((time, joint.as_str(), quantity), (0.0, "joint2", "command current"));
    assert!(value.is_nan());
}

/// A rotor alone under a constant torque through the kink of its law: `J ω̇ = τ − a − b ω` on each line,
/// `ω(t) = ω_∞ + (ω_0 − ω_∞) e^{−b t/J}` with `ω_∞ = (τ − a)/b`.
#[test]
fn analytic_kink_of_a_two_line_law_is_located() {
    let lines = Lines { a1: 0.46, b1: -6.0, a2: 0.27, b2: 0.6 };
    let kink = (lines.a1 - lines.a2) / (lines.b2 - lines.b1);
    let (inertia, torque, duration) = (0.02, 0.7, 0.0405);
    let mut joint = JointModel {
        friction: Some(Friction { law: FrictionLaw::TwoLines([lines, lines]), link_share: 0.0 }),
        ..plain_joint("joint1")
    };
    (joint.gear_stiffness, joint.gear_damping, joint.rotor_inertia) = (Some(1e-12), Some(0.0), Some(inertia));
    let options = Options { substeps: 10, ..Options::default() };
    for sign in [1.0, -1.0] {
        let mut plant = Plant::new(&model(turntable(1.0), vec![joint.clone()]), &options).unwrap();
        plant.advance(&[sign * torque], duration).unwrap();
        let limits = [(torque - lines.a1) / lines.b1, (torque - lines.a2) / lines.b2];
        let passes = -inertia / lines.b1 * ((kink - limits[0]) / -limits[0]).ln();
        let expected = limits[1] + (kink - limits[1]) * (-lines.b2 / inertia * (duration - passes)).exp();
        let found = sign * plant.states()[0].motor_velocity;
        println!("kink passed at {passes}, {found} of {expected}");
        // 1e-9: (b h/J)⁵/120 is 2e-10 in a step of 0.1 ms. Not located, the kink would leave Δb ω̇ h²/8J, 1e-5 of it.
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        // And back: slower than the kink again, and to rest.
        plant.advance(&[0.0], 0.5).unwrap();
        assert!(plant.sticks(0)[0]);
    }
}

/// A stiff controller on the bare velocity throws a rotor from flank to flank of an undamped gear, and gaps down to nothing make
/// it strike thousands of times a second: no millisecond may cost more than the bound, and the books stay closed.
#[test]
fn property_a_hammering_rotor_costs_a_bounded_number_of_steps() {
    for gap in [0.1, 1e-3, 1e-5, 1e-7, 1e-12] {
        let mut machine = scara();
        for joint in &mut machine.joints {
            (joint.backlash, joint.gear_damping) = (Some(gap), Some(0.0));
        }
        let mut plant = Plant::new(&machine, &Options { ideal_sensors: true, ..Options::default() }).unwrap();
        let (start, mut most) = (plant.energy(), 0);
        for k in 0..3000 {
            let wanted = 3.0 * (f64::from(k) * 0.02).sin().signum();
            let command: Vec<f64> = plant.states().iter().map(|state| 60.0 * (wanted - state.motor_velocity)).collect();
            let before = plant.counts().steps;
            plant.advance(&command, 1e-3).unwrap();
            most = most.max(plant.counts().steps - before);
        }
        let (end, counts) = (plant.energy(), plant.counts());
        let gap_of_books = (end.work - end.dissipated - (end.stored - start.stored)) / end.work;
        println!("gap {gap:e}: at most {most} steps in a millisecond, {counts:?}, energy {gap_of_books:.1e}");
        // Two passages, each at most 100 events of two steps and as many steps as without.
        assert!(most < 450, "{most}");
        assert!(counts.steps < 3000 * 40, "{counts:?}");
        assert!(counts.events > 1000, "it is to hammer: {counts:?}");
        // Where events crowd, modes change at the ends of steps alone: first order, half a millisecond.
        assert!(gap_of_books.abs() < if counts.crowded == 0 { 1e-4 } else { 1e-3 }, "{gap_of_books:e}");
    }
}

/// Velocities of rotor and link after a constant torque on a damped link: `J ω̇ = τ − T`, `M v̇ = T − c v`, `T = k x + d (ω − v)`, `ẋ = ω − v`,
/// in steps of 1 µs; without `M` the link follows `T = c v`.
fn pushed(damper: f64, link: Option<f64>, torque: f64, duration: f64) -> [f64; 2] {
    let rate = |[omega, v, x]: [f64; 3]| {
        let v = if link.is_some() { v } else { (STIFFNESS * x + GEAR_DAMPING * omega) / (damper + GEAR_DAMPING) };
        let gear = STIFFNESS * x + GEAR_DAMPING * (omega - v);
        [(torque - gear) / ROTOR, link.map_or(0.0, |link| (gear - damper * v) / link), omega - v]
    };
    let moved = |y: [f64; 3], by: f64, r: [f64; 3]| [0, 1, 2].map(|i| y[i] + by * r[i]);
    let (mut y, h) = ([0.0; 3], 1e-6);
    for _ in 0..(duration / h).round() as usize {
        let a = rate(y);
        let b = rate(moved(y, 0.5 * h, a));
        let c = rate(moved(y, 0.5 * h, b));
        let d = rate(moved(y, h, c));
        y = [0, 1, 2].map(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    let v = if link.is_some() { y[1] } else { (STIFFNESS * y[2] + GEAR_DAMPING * y[0]) / (damper + GEAR_DAMPING) };
    [y[0], v]
}

/// [kg·m²], [N·m/rad], [N·m·s/rad] A wheel of a mobile robot on its gear.
const ROTOR: f64 = 0.36;
const STIFFNESS: f64 = 3200.0;
const GEAR_DAMPING: f64 = 1.0;

/// Dampers that bring light links to rest in 50 ns: their links move as if they had no inertia, and at last with `τ/c`. The negative control is a
/// damper that the steps follow: its link keeps its own inertia.
#[test]
fn analytic_a_damper_too_fast_for_any_step_leaves_all_slower_motion_right() {
    let (damper, torque) = (20.0, 7.0);
    for engine in [Engine::Rapier, Engine::Reduced] {
        for (link, of_reference, most) in [
            // The joint bears c/1e5 = 2e-4 kg·m² beside a rotor of 0.36: 5.6e-4 of its time constant. The link is late by 10 µs; after 10 ms,
            // while its velocity grows with t², this is 2e-3 of it.
            (1e-6, None, 2.6e-3),
            // c/M = 8e4 1/s: the inertia itself is 7e-4 of the rotor's, and the steps are right to 1e-9 of it.
            (2.5e-4, Some(2.5e-4), 1e-6),
        ] {
            let mut robot = turntable(link);
            robot.bodies[0].joint.damping = damper;
            let mut joint = plain_joint("joint1");
            (joint.gear_stiffness, joint.gear_damping, joint.rotor_inertia) =
                (Some(STIFFNESS), Some(GEAR_DAMPING), Some(ROTOR));
            let mut plant = Plant::new(&model(robot, vec![joint]), &Options { engine, ..Options::default() }).unwrap();
            for (more, passed) in [(0.01, 0.01), (0.04, 0.05), (0.95, 1.0)] {
                plant.advance(&[torque], more).unwrap();
                let [omega, v] = pushed(damper, of_reference, torque, passed);
                let state = plant.states()[0];
                let errors = [state.motor_velocity / omega - 1.0, state.link_velocity / v - 1.0];
                println!("{engine:?}, link {link:e}, {passed} s: {errors:?}");
                assert!(errors.iter().all(|error| error.abs() < most), "{errors:?} at {passed} s");
            }
            let last = plant.states()[0].link_velocity;
            assert!((last * damper / torque - 1.0).abs() < 1e-9, "{last} rad/s for τ/c");
        }
    }
}

/// Two light links in series, each with such a damper: they couple, and all joints are slowed together.
#[test]
fn property_dampers_too_fast_for_any_step_do_not_diverge_in_a_chain() {
    let mut robot = planar_arm();
    for body in &mut robot.bodies {
        body.joint.damping = 1e9;
    }
    let n = robot.dof();
    let mut plant = Plant::new(&plain(robot), &Options::default()).unwrap();
    plant.advance(&vec![0.1; n], 0.2).unwrap();
    assert!(plant.states().iter().all(|state| state.link_velocity.abs() < 1e-9), "{:?}", plant.states());
}
