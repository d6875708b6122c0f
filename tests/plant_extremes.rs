//! The simulated machine where it is driven beyond reason: it says so, or goes on at a bounded cost.

#[path = "support/machines.rs"]
mod machines;

use lostmotion::effects::JointState;
use lostmotion::error::Error;
use lostmotion::gearhead::{Friction, FrictionLaw, Lines};
use lostmotion::plant::{Engine, FASTEST_MOTION, Options, Plant};
use lostmotion::robot::JointModel;
use machines::*;

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
