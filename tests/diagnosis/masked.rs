//! Two effects at once in simulated machines with their sensors and controllers: those that mask each other, and one of two joints beside another.

use std::collections::BTreeSet;

use crate::drawn::Drawn;
use crate::hidden::Order;
use crate::told;
use lostmotion::diagnose::{Options, diagnose};
use lostmotion::robot::EffectEntry;
use lostmotion::timeseries::TimeSeries;
use rayon::prelude::*;

fn entry(effect: &str, joint: &str, parameters: &[(&str, f64)]) -> EffectEntry {
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    EffectEntry { effect: effect.to_owned(), joint: Some(joint.to_owned()), parameters }
}

/// A machine with these effects.
fn machine(entries: &[EffectEntry], seed: u64) -> Drawn {
    let mut drawn = Drawn::new(&Order::nothing(seed));
    drawn.entries = entries.to_vec();
    drawn
}

/// Names and joints that a diagnosis of a machine gives.
fn named(drawn: &Drawn) -> BTreeSet<(String, String)> {
    let sessions: Vec<TimeSeries> = drawn.sessions().collect();
    let (train, hold_out) = sessions.split_at(sessions.len() - 1);
    let options = Options { backlash: false, ..Options::default() };
    let found = diagnose(&drawn.nominal, train, hold_out, &options, &mut |_, _| {}).expect("a diagnosis");
    told::print(&found);
    found.effects.iter().flat_map(|one| one.joints.iter().map(|joint| (one.effect.clone(), joint.clone()))).collect()
}

fn planted(entries: &[EffectEntry]) -> BTreeSet<(String, String)> {
    entries.iter().filter_map(|one| Some((one.effect.clone(), one.joint.clone()?))).collect()
}

/// Friction that is smooth through zero leaves an error in every slow row, a spring one over the whole stroke: beside either the other had less than two nats.
#[test]
fn recover_two_effects_of_a_joint_that_mask_each_other() {
    let both = [
        entry("cable_spring", "joint1", &[("stiffness", 0.14), ("rest_position", 0.6)]),
        entry("regularised_friction", "joint1", &[("velocity", 0.02)]),
    ];
    [33_120, 33_121].into_par_iter().for_each(|seed| {
        assert_eq!(named(&machine(&both, seed)), planted(&both), "{seed}");
    });
}

/// An error of the torque constant has as much evidence on one joint, but friction under load acts on both.
#[test]
fn recover_friction_of_two_joints_beside_a_ripple() {
    let of_load = |joint| entry("load_dependent_friction", joint, &[("coefficient", 0.155)]);
    let ripple = entry("cogging", "joint1", &[("amplitude", 0.07), ("order", 4.0), ("phase", -2.3)]);
    let all = [ripple, of_load("joint1"), of_load("joint2")];
    [33_122, 33_123].into_par_iter().for_each(|seed| {
        assert_eq!(named(&machine(&all, seed)), planted(&all), "{seed}");
    });
}

/// Both velocity channels are 20 ms late, and the loops oscillate. Friction turns the phase of the torque as a current would that is 7.6 ms late.
#[test]
fn property_loops_that_oscillate_show_no_late_current() {
    let drawn = Drawn::new(&Order::one("velocity_lag", 1.0, 99_002));
    assert_eq!(named(&drawn), planted(&drawn.entries));
}

/// What a balancer leaves over the whole stroke raises all orders together, so that no line stands out before curves over the stroke are fitted.
#[test]
fn recover_an_error_of_the_teeth_beside_a_balancer() {
    let both = [
        entry("counterbalance", "joint1", &[("amplitude", 0.25), ("angle", 0.7)]),
        entry("transmission_error", "joint1", &[("amplitude", 2.5e-4), ("phase", 2.1), ("teeth", 85.0)]),
    ];
    (33_124..33_127).into_par_iter().for_each(|seed| {
        assert_eq!(named(&machine(&both, seed)), planted(&both), "{seed}");
    });
}
