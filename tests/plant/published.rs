//! The simulated machine against published results: examples of the Modelica Standard Library with their parameters, and the
//! results that its maintainers publish for them.
//!
//! Source of the models: `Modelica/Mechanics/{Rotational,Translational}/Examples/*.mo`, Modelica Association; of the results:
//! repository `modelica/MAP-LIB_ReferenceResults`, version 4.0.0, Dymola 2020x with DASSL at a tolerance of 1e-6. What can be
//! asked of a comparison is their accuracy: a hundredth of a per cent of the motion, named beside each number.

use std::f64::consts::PI;

use crate::engines::*;
use crate::exactness;
use crate::machines::*;
use lostmotion::effects::JointState;
use lostmotion::plant::Plant;
use lostmotion::robot::JointModel;
use lostmotion::units::JointKind;
use nalgebra::Vector3;

/// [s] Within which a sine is held: its samples in the middle are wrong by (ω h)²/24 of it at most, 1e-9 at 5 Hz.
const HOLD: f64 = 1e-5;

/// Advances to a time under a sine, `amplitude · sin(2π f t)`, that leaves alone what sticks until it reaches `lets_go`.
fn drive(plant: &mut Plant, amplitude: f64, frequency: f64, lets_go: f64, until: f64) {
    let start = plant.time();
    let steps = ((until - start) / HOLD).round().max(1.0);
    let hold = (until - start) / steps;
    for k in 0..steps as usize {
        let t = start + (k as f64 + 0.5) * hold;
        let push = amplitude * (2.0 * PI * frequency * t).sin();
        let push = if plant.sticks(0)[0] && push.abs() < lets_go { 0.0 } else { push };
        plant.advance(&[push], hold).unwrap();
    }
}

/// Rotational `Examples.Backlash`: 5 kg·m² at 90° on a spring of 20,000 N·m/rad with a damper of 50 N·m·s/rad to a wall; on a
/// second one with a gap of 45° in between. (Their damper of a gap is weaker than ours while it is pressed: the two agree until
/// the other flank is met.)
#[test]
fn published_modelica_backlash() {
    let joint = |gap| JointModel {
        gear_stiffness: Some(20e3),
        gear_damping: Some(50.0),
        backlash: Some(gap),
        // The wall: a rotor that friction holds.
        friction: Some(friction(1e9, 1e9, 1.0, 0.0, 0.0)),
        ..plain_joint("joint1")
    };
    let start = JointState { link_position: 0.5 * PI, ..JointState::default() };
    on_both_engines(&model(turntable(5.0), vec![joint(0.0)]), |mut plant| {
        plant.launch(&[start]);
        for (t, phi, w) in [(0.025, 0.102461229684008, -87.9463190529995), (0.05, -1.22431981421853, 0.83691895774552)]
        {
            plant.advance(&[0.0], t - plant.time()).unwrap();
            assert_near("springDamper.phi_rel", plant.states()[0].link_position, phi, 1e-4 * PI);
            assert_near("springDamper.w_rel", plant.states()[0].link_velocity, w, 1e-4 * 88.0);
        }
    });
    let mut error = 0.0_f64;
    on_both_engines(&model(turntable(5.0), vec![joint(0.25 * PI)]), |mut plant| {
        plant.launch(&[start]);
        let touching = |plant: &Plant| plant.contact(0);
        // The tooth is left at 0.0236592180 s with compression still there, and the other flank is met at 0.0380238663 s.
        let (left, met) = (0.0236592180214795, 0.0380238662895904);
        let phase = 1e-6;
        plant.advance(&[0.0], left - phase).unwrap();
        assert_eq!(touching(&plant), -1);
        plant.advance(&[0.0], 2.0 * phase).unwrap();
        assert_eq!(touching(&plant), 0);
        assert_near("phi_rel in the gap", plant.states()[0].link_position, 0.558190285218362 - 66.2 * phase, 1e-4 * PI);
        let w = -66.1964949763532;
        error = error.max(assert_near("w_rel in the gap", plant.states()[0].link_velocity, w, 1e-4 * 66.0) / 66.2);
        plant.advance(&[0.0], met - plant.time() - phase).unwrap();
        assert_eq!(touching(&plant), 0);
        plant.advance(&[0.0], 2.0 * phase).unwrap();
        assert_eq!(touching(&plant), 1);
    });
    // The times are asserted within `phase`.
    exactness::says("and the velocity in between | below 1e-6 s,", &[error]);
}

/// Rotational `Examples.First`: a motor of 0.1 kg·m² under 10 N·m at 5 Hz, a gear of ratio 10, 2 kg·m² on a damper of
/// 10 N·m·s/rad to the housing, a spring of 10,000 N·m/rad, and a load of 2 kg·m².
#[test]
fn published_modelica_first() {
    let joint = JointModel {
        gear_ratio: 10.0,
        // At the motor: its own inertia, and that behind the gear seen through the ratio squared.
        rotor_inertia: Some(0.1 + 2.0 / 100.0),
        gear_stiffness: Some(1e4),
        gear_damping: Some(0.0),
        friction: Some(friction(0.0, 0.0, 1.0, 10.0, 0.0)),
        ..plain_joint("joint1")
    };
    let mut error = 0.0_f64;
    on_both_engines(&model(turntable(2.0), vec![joint]), |mut plant| {
        for (t, w2, phi3, w3) in [
            (0.05, 0.230015711532042, 0.00226042453239301, 0.189486493280578),
            (0.09, 0.417096433259123, 0.0178252252698198, 0.513153580366155),
        ] {
            drive(&mut plant, 10.0, 5.0, 0.0, t);
            let state = plant.states()[0];
            let w2 = assert_near("inertia2.w", state.motor_velocity, w2, 1e-4 * w2) / w2;
            let phi3 = assert_near("inertia3.phi", state.link_position, phi3, 1e-4 * phi3) / phi3;
            let w3 = assert_near("inertia3.w", state.link_velocity, w3, 1e-4 * w3) / w3;
            error = error.max(w2).max(phi3).max(w3);
        }
    });
    exactness::says("| motor, gear, damper, spring, load at 5 Hz |", &[error]);
}

/// Translational `Examples.Friction`, `stop1`: 1 kg under 25 N at 0.25 Hz with the Stribeck friction
/// `5 N + 10 N e^{−2 |v|} + 1 N·s/m |v|`, which is equation 6. It sticks, breaks away, comes to rest, breaks away backwards.
#[test]
fn published_modelica_stribeck_friction() {
    let joint = JointModel {
        kind: JointKind::Prismatic,
        rotor_inertia: Some(1.0),
        // The mass is the rotor: nothing hangs on it.
        gear_stiffness: Some(1e-12),
        gear_damping: Some(0.0),
        friction: Some(friction(5.0, 15.0, 0.5, 1.0, 0.0)),
        ..plain_joint("joint1")
    };
    let mut error = 0.0_f64;
    on_both_engines(&model(slide(1.0, Vector3::x()), vec![joint]), |mut plant| {
        for (t, s, v) in [
            (1.1, 2.47188321002587, 8.16244482830137),
            (2.3, 13.2216532237969, 3.10320391260355),
            (5.0, 1.76846282132044, 6.86485858981257),
        ] {
            // Their block lets go at 1.001 of its breakaway force.
            drive(&mut plant, 25.0, 0.25, 1.001 * 15.0, t);
            let state = plant.states()[0];
            // Ways of 13 m at up to 13 m/s.
            error = error.max(assert_near("stop1.s", state.motor_position, s, 1e-4 * 13.0));
            assert_near("stop1.v", state.motor_velocity, v, 1e-4 * 13.0);
        }
    });
    exactness::says("| stick, breakaway and rest with Stribeck friction in 5 s |", &[error]);
}
