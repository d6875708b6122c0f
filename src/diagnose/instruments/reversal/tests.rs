//! The simulated gear against closed forms: one reversal from `−u` to `u` without gravity. What is named of the results.

use super::TurnRules;
use super::gear::{Altered, Gear, lack};
use super::path::{Path, Span};
use super::search::{TurnCandidate, named};
use crate::effects::{Action, Effect, SymmetricFriction, find};
use crate::gearhead::Memory;
use crate::replay::Gain;

/// [s] Step of the grid.
const H: f64 = 1e-3;
/// [rad/s] Speed.
const U: f64 = 0.05;
/// [kg·m²] Inertia of the link.
const I: f64 = 0.1;
const DRY: SymmetricFriction = SymmetricFriction { coulomb: 0.4, breakaway: 0.4, stribeck_velocity: 1.0, viscous: 0.0 };

/// The rotor reverses abruptly in the middle of two seconds.
fn turn() -> Path {
    let n = 2000;
    let time: Vec<f64> = (0..n).map(|k| k as f64 * H).collect();
    let v: Vec<f64> = (0..n).map(|k| if k < n / 2 { -U } else { U }).collect();
    let theta = time.iter().map(|t| U * (t - 1.0).abs()).collect();
    let none = vec![0.0; n];
    let spans = vec![Span { session: 0, start: 0, end: n, from: 0.0, step: H }];
    let (load, inertial, inertia, dry) = (none.clone(), none, vec![I; n], vec![DRY.coulomb; n]);
    Path { joint: 0, step: H, spans, theta, v, load, inertial, inertia, friction: DRY, dry }
}

#[test]
fn analytic_link_rests_while_the_rotor_crosses_the_gap() {
    let (gap, share) = (0.0123, 0.25);
    let lack = lack(&turn(), &Gear { gap, share }, &Altered::default());
    // Without a load the link stays on its flank while the rotor brakes, and stands where it reverses.
    let touch = 1.0 + gap / U;
    let at = |t: f64| lack[(t / H) as usize];
    assert_eq!(at(0.9), 0.0);
    // In the gap the motor does not feel the link's friction, which a rigid fit includes.
    assert!((at(0.5 * (1.0 + touch)) + share * DRY.coulomb).abs() < 1e-12);
    // The flank gives the link the momentum I u, within the two steps between which an impulse is divided.
    let impulse: f64 = lack.iter().filter(|torque| **torque > 0.0).map(|torque| torque * H).sum();
    assert!((impulse - I * U).abs() < 2.0 * H * share * DRY.coulomb, "{impulse}");
    let last = lack.iter().rposition(|torque| *torque != 0.0).expect("an impulse");
    assert!((last as f64 * H - touch).abs() < 2.0 * H, "{last} {touch}");
}

#[test]
fn analytic_bristles_bend_before_they_slip() {
    let (stiffness, damping) = (100.0, 0.0);
    let actions = [Action::Friction(0, Memory::Bristles { stiffness, damping })];
    let gear = Gear { gap: 0.0, share: 0.0 };
    let lack = lack(&turn(), &gear, &Altered::by(&actions, 0));
    // z = z0 + (g/σ0 − z0)(1 − e^{−σ0 x/g}) over the travel x since the reversal, from z0 = −g/σ0: F − g = −2 g e^{−σ0 x/g}.
    for t in [1.05, 1.1, 1.3] {
        let expected = -2.0 * DRY.coulomb * (-stiffness * U * (t - 1.0) / DRY.coulomb).exp();
        // Half a step of travel: the torque of an instant applies for one step.
        let bound = 2.0 * DRY.coulomb * stiffness * U * H / DRY.coulomb;
        assert!((lack[(t / H) as usize] - expected).abs() < bound, "{t}: {} {expected}", lack[(t / H) as usize]);
    }
}

#[test]
fn property_a_gear_without_a_gap_lacks_nothing() {
    let lack = lack(&turn(), &Gear { gap: 0.0, share: 0.0 }, &Altered::default());
    // Except for the impulse that reverses the link, which a smooth motion spreads over its kernel.
    let away: f64 = lack.iter().enumerate().filter(|(k, _)| k.abs_diff(1000) > 2).map(|(_, torque)| torque.abs()).sum();
    assert_eq!(away, 0.0);
}

/// Stiction with this growth [N·m] and its standard error, with more evidence than any name needs.
fn grown(growth: [f64; 2]) -> TurnCandidate {
    let effect = find("dwell_stiction").and_then(Effect::at_turns).expect("an effect at reversals");
    let values = vec![growth, [0.08, 0.056], [1.4e-4, 6.7e-5]];
    TurnCandidate { effect, joint: 0, values, folds: 400.0, log_scale: 0.5, gain: Gain::default() }
}

#[test]
fn property_a_size_that_may_be_zero_has_no_name() {
    let rules = TurnRules::default();
    assert!(named(&[grown([0.008, 0.006])], &rules).is_empty());
    assert_eq!(named(&[grown([0.008, 0.003])], &rules).len(), 1);
}
