//! Two effects at once in simulated machines with their sensors and controllers: those that mask each other, and one of two joints beside another.

use std::collections::BTreeSet;

use crate::drawn::Drawn;
use crate::hidden::Order;
use crate::told;
use lostmotion::diagnose::{Options, diagnose};
use lostmotion::robot::EffectEntry;
use lostmotion::timeseries::{Channel, TimeSeries};
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
    named_in(drawn, &drawn.sessions().collect::<Vec<TimeSeries>>())
}

/// The same for these sessions of it.
fn named_in(drawn: &Drawn, sessions: &[TimeSeries]) -> BTreeSet<(String, String)> {
    let (train, hold_out) = sessions.split_at(sessions.len() - 1);
    let options = Options { backlash: false, ..Options::default() };
    let found = diagnose(&drawn.nominal, train, hold_out, &options, &mut |_, _| {}).expect("a diagnosis");
    told::print(&found);
    found.effects.iter().flat_map(|one| one.joints.iter().map(|joint| (one.effect.clone(), joint.clone()))).collect()
}

fn planted(entries: &[EffectEntry]) -> BTreeSet<(String, String)> {
    entries.iter().filter_map(|one| Some((one.effect.clone(), one.joint.clone()?))).collect()
}

/// The drawn machine with two effects of this seed.
fn drawn(effects: [&str; 2], seed: u64) -> Drawn {
    Drawn::new(&Order { field: None, effects: effects.map(str::to_owned).into(), strength: 1.0, seed })
}

/// Friction that is smooth through zero leaves an error in every slow row, a spring one over the whole stroke: on this machine either had less than two nats beside
/// the other, and both together have more than a hundred each. On most machines one of them has evidence alone.
#[test]
fn recover_two_effects_of_a_joint_that_mask_each_other() {
    let drawn = drawn(["cable_spring", "regularised_friction"], 95_411);
    assert_eq!(named(&drawn), planted(&drawn.entries));
}

/// An error of the torque constant has more evidence than friction under load has on one joint, and less than it has on both.
#[test]
fn recover_friction_of_two_joints_beside_a_ripple() {
    let drawn = drawn(["cogging", "load_dependent_friction"], 94_414);
    assert_eq!(named(&drawn), planted(&drawn.entries));
}

/// Both velocity channels are late, by 20 and 10 ms, and the loops oscillate: the controllers answer every stroke of the teeth so late, as if the current were.
#[test]
fn property_controllers_that_read_a_late_velocity_show_no_late_current() {
    [(1.0, 99_002), (0.5, 99_102)].into_par_iter().for_each(|(strength, seed)| {
        let drawn = Drawn::new(&Order::one("velocity_lag", strength, seed));
        assert_eq!(named(&drawn), planted(&drawn.entries), "{seed}");
    });
}

/// The same loop, recorded without its velocity: the transients show a current that is 7.6 ms late, and the rows ask the delay back.
#[test]
fn property_a_late_current_that_the_rows_refute_is_not_named() {
    let drawn = Drawn::new(&Order::one("velocity_lag", 1.0, 99_002));
    let mut sessions: Vec<TimeSeries> = drawn.sessions().collect();
    for series in sessions.iter_mut().flat_map(|session| &mut session.joints) {
        series.channels.remove(&Channel::Velocity).expect("a velocity");
    }
    assert_eq!(named_in(&drawn, &sessions), BTreeSet::new());
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
