//! Friction that remembers: bristles that bend before they slip, and breakaway that grows at rest.

#[path = "support/machines.rs"]
mod machines;

use lostmotion::effects::{JointState, find};
use lostmotion::error::Error;
use lostmotion::gearhead::{Friction, Memory};
use lostmotion::plant::{Engine, Options, Plant};
use lostmotion::robot::{EffectEntry, JointModel, Model};
use machines::*;

/// `J` [kg·m²] of the rotor.
const J: f64 = 0.02;

/// A rotor in a gap so wide that it never meets its link.
fn rotor_alone(friction: Friction) -> Model {
    model(turntable(0.05), vec![JointModel { backlash: Some(1e6), friction: Some(friction), ..plain_joint("joint1") }])
}

fn with(mut model: Model, effect: &str, parameters: &[(&str, f64)]) -> Model {
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    model.effects.push(EffectEntry { effect: effect.to_owned(), joint: Some("joint1".to_owned()), parameters });
    model
}

fn ideal(model: &Model) -> Plant {
    let options = Options { engine: Engine::Reduced, ideal_sensors: true, ..Options::default() };
    Plant::new(model, &options).unwrap()
}

fn near(what: &str, found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    println!("{what}: {found:.9}, off by {error:.1e}");
    assert!(error <= tolerance, "{what}: {found:e} instead of {expected:e}, off by {error:e}");
}

/// `σ0` [N·m/rad] of the tests, `σ1` at which a rotor on its bristles does not swing, and the level `g` of its friction.
const SIGMA_0: f64 = 1000.0;
const SIGMA_1: f64 = 20.0;
const G: f64 = 0.4;

fn bristles(friction: Friction) -> Plant {
    ideal(&with(rotor_alone(friction), "presliding", &[("stiffness", SIGMA_0), ("damping", SIGMA_1)]))
}

/// Moves the command to a torque at 2 N·m/s and waits for fifty times `σ1/σ0`; returns where the rotor stands.
fn load(plant: &mut Plant, from: f64, to: f64) -> f64 {
    let steps = (f64::abs(to - from) / 2e-3).ceil() as usize;
    for step in 1..=steps {
        plant.advance(&[from + (to - from) * step as f64 / steps as f64], 1e-3).unwrap();
    }
    plant.advance(&[to], 1.0).unwrap();
    plant.states()[0].motor_position
}

/// A rotor on its bristles under a small torque: a spring, `τ = σ0 θ`, with `J ω̇ + σ1 ω + σ0 θ = τ` swinging in.
#[test]
fn analytic_bristles_are_a_spring_for_tiny_torque() {
    let torque = 1e-5 * G;
    let mut plant = bristles(friction(G, G, 1.0, 0.0, 0.0));
    plant.advance(&[torque], 1.0).unwrap();
    // The bend of the hysteresis: τ/2g of the displacement.
    near("deflection [rad]", plant.states()[0].motor_position, torque / SIGMA_0, 1e-5 * torque / SIGMA_0);
    assert!(!plant.sticks(0)[0], "bristles yield before they slip");
}

/// Quasi-static loading: `dz/dθ = 1 ∓ σ0 z/g` and `τ = σ0 z`, so `θ = (g/σ0) ln(1/(1 − τ/g))` at first, and between `∓τ` and `±τ`
/// `Δθ = (g/σ0) ln((1 + r)/(1 − r))`, `r = τ/g`, on both branches: the hysteresis closes.
#[test]
fn analytic_the_hysteresis_of_bristles_closes() {
    let r: f64 = 0.6;
    let torque = r * G;
    let mut plant = bristles(friction(G, G, 1.0, 0.0, 0.0));
    let unit = G / SIGMA_0;
    let first = load(&mut plant, 0.0, torque);
    // 1e-6: motion in one direction follows the curve at any speed; the steps of the command do not make it swing.
    near("virgin curve [rad]", first, -unit * (1.0 - r).ln(), 1e-6 * unit);
    let back = load(&mut plant, torque, -torque);
    near("width [rad]", first - back, unit * ((1.0 + r) / (1.0 - r)).ln(), 1e-6 * unit);
    let again = load(&mut plant, -torque, torque);
    near("closed [rad]", again, first, 1e-6 * unit);
}

/// Under a constant torque below `g` the rotor stays for good; above it, it slides away.
#[test]
fn property_bristles_break_away_at_the_level_of_friction() {
    let mut plant = bristles(friction(G, G, 1.0, 0.0, 0.0));
    load(&mut plant, 0.0, 0.95 * G);
    plant.advance(&[0.95 * G], 5.0).unwrap();
    let here = plant.states()[0].motor_position;
    plant.advance(&[0.95 * G], 20.0).unwrap();
    near("no creep in 20 s [rad]", plant.states()[0].motor_position, here, 1e-9);
    plant.advance(&[1.05 * G], 1.0).unwrap();
    // Beyond it, nearly the excess alone accelerates: half of ½ · 0.05 g/J · 1 s² at least.
    assert!(plant.states()[0].motor_position > here + 0.25 * 0.05 * G / J);
}

/// At constant speed friction is the law: `τ = (F_C + (F_S − F_C) e^{−ω/v_S}) + F_V ω`, at any speed, however stiff the bristles.
#[test]
fn analytic_sliding_bristles_are_the_law() {
    let (coulomb, breakaway, v_s, viscous) = (0.3, 0.5, 0.4, 0.3);
    for stiffness in [200.0, 3e4] {
        let nominal = rotor_alone(friction(coulomb, breakaway, v_s, viscous, 0.0));
        let mut plant = ideal(&with(nominal, "presliding", &[("stiffness", stiffness), ("damping", 2.0)]));
        for torque in [0.6, 1.2] {
            plant.launch(&[JointState { motor_velocity: 1.0, ..JointState::default() }]);
            // Ends where the law balances the torque: J/F_V = 70 ms forgets the start.
            plant.advance(&[torque], 3.0).unwrap();
            let omega = plant.states()[0].motor_velocity;
            let law = coulomb + (breakaway - coulomb) * (-omega / v_s).exp() + viscous * omega;
            // What is left of the start, where the falling part softens the slope: e⁻³⁸.
            near("friction of sliding [N·m]", law, torque, 1e-9);
        }
    }
}

#[test]
fn property_bristles_that_cannot_be_integrated_are_refused() {
    let refused = |model: Model, stiffness: f64| {
        let entry = with(model, "presliding", &[("stiffness", stiffness), ("damping", 1.0)]);
        match Plant::new(&entry, &Options::default()) {
            Err(Error::Input(error)) => error.key,
            _ => panic!("{stiffness} was taken"),
        }
    };
    let stiffness = "effects[1].stiffness";
    assert_eq!(refused(rotor_alone(friction(G, G, 1.0, 0.0, 0.0)), 1e12), stiffness);
    assert_eq!(refused(rotor_alone(friction(G, G, 1.0, 0.0, 1.0)), 1000.0), stiffness);
    assert_eq!(refused(rotor_alone(friction(0.0, 0.5, 1.0, 0.1, 0.0)), 1000.0), stiffness);
    let mut fast = rotor_alone(friction(G, G, 1.0, 0.0, 0.0));
    fast.robot.bodies[0].joint.limits.velocity = 100.0;
    assert_eq!(refused(fast, 1e5), stiffness);
}

const GROWTH: f64 = 0.3;
const T: f64 = 1.5;

fn resting() -> Model {
    let parameters = [("growth", GROWTH), ("time_constant", T), ("slip_distance", 0.01)];
    with(rotor_alone(friction(G, G, 1.0, 0.0, 0.0)), "dwell_stiction", &parameters)
}

/// After a rest of `t` it breaks away at `F_S + ΔF (1 − e^{−t/T})`: a torque just below holds, one just above moves.
#[test]
fn analytic_breakaway_grows_with_the_rest_before_it() {
    for rest in [0.0, 0.3, 1.0, 4.0] {
        let level = G + GROWTH * (1.0 - f64::exp(-rest / T));
        for (torque, holds) in [(level - 1e-9, true), (level + 1e-9, false)] {
            let mut plant = ideal(&resting());
            plant.advance(&[0.0], rest).unwrap();
            // Long enough to slip, too short to grow by 1e-9.
            plant.advance(&[torque], 1e-9).unwrap();
            assert_eq!(plant.sticks(0)[0], holds, "{torque} after {rest} s");
        }
    }
}

/// Once it slips the growth wears off over the distance, and the next rest begins anew.
#[test]
fn analytic_sliding_takes_the_growth_away_and_the_next_rest_begins_anew() {
    let mut plant = ideal(&resting());
    plant.advance(&[0.0], 5.0).unwrap();
    let grown = 1.0 - f64::exp(-5.0 / T);
    near("grown [1]", plant.states()[0].memory, grown, 1e-12);
    plant.advance(&[1.0], 0.1).unwrap();
    // It has slid some 0.1 rad: ten times the distance. What is left grows while it slides: D/(T v).
    assert!(plant.states()[0].motor_position > 0.09);
    assert!(plant.states()[0].memory < 0.01, "{}", plant.states()[0].memory);
    // Friction at constant speed is the law again: it stops within v J/F.
    plant.advance(&[0.0], 1.0).unwrap();
    assert!(plant.sticks(0)[0]);
    let before = plant.states()[0].memory;
    plant.advance(&[0.0], 0.7).unwrap();
    let expected = 1.0 - (1.0 - before) * f64::exp(-0.7 / T);
    near("grown again [1]", plant.states()[0].memory, expected, 1e-9);
    let level = G + GROWTH * expected;
    plant.advance(&[level - 1e-8], 1e-9).unwrap();
    assert!(plant.sticks(0)[0], "below the level");
    plant.advance(&[level + 1e-8], 1e-9).unwrap();
    assert!(!plant.sticks(0)[0], "above the level");
}

/// `φ̇ = (1 − φ)/T − |v| φ/D` at constant velocity ends at `D/(D + T |v|)`.
#[test]
fn analytic_what_remains_of_the_growth_at_constant_speed() {
    let memory = Memory::Rest { growth: GROWTH, time_constant: T, slip_distance: 0.01 };
    for v in [-0.2, 0.01, 3.0] {
        let state = 0.01 / (0.01 + T * f64::abs(v));
        assert!(memory.rate(state, v, G).abs() < 1e-12 / T);
        near("level [N·m]", memory.level(state), GROWTH * state, 0.0);
    }
}

#[test]
fn property_a_joint_has_one_memory() {
    let both = with(resting(), "presliding", &[("stiffness", 1000.0), ("damping", 1.0)]);
    match Plant::new(&both, &Options::default()) {
        Err(Error::Input(error)) => {
            assert_eq!((error.key.as_str(), error.value.as_str()), ("effects[2].effect", "presliding"))
        }
        _ => panic!("two memories were taken"),
    }
    assert!(find("presliding").is_some_and(|effect| effect.can_be_told()));
}
