//! Lines at orders of the motor angle in slow errors: false alarms, and a planted line.

use std::path::Path;

use super::*;
use crate::effects::drawn::{LENGTH, Line, MODEL, ROBOT, drawn};
use crate::effects::{CATALOGUE, Catalogue};
use crate::robot::Model;

/// Cogging, torque ripple and friction that varies with the angle, judged on a drawn recording.
fn judged(model: &Model, seed: u64, line: Line) -> Vec<Candidate> {
    let motion = drawn(model, seed, line, LENGTH);
    let held_out = vec![false; motion.rows()];
    let mut problem = Problem::new(motion, held_out);
    let names = ["cogging", "torque_ripple", "position_dependent_friction"];
    let lines: Catalogue = CATALOGUE.iter().filter(|effect| names.contains(&effect.about().name)).copied().collect();
    problem.name_from(lines);
    let fitted = problem.settle(&[]).expect("a baseline");
    problem.count_independent(&fitted);
    candidates(&mut problem, &[], &Rules::default())
}

/// The order in periods per motor turn of a candidate.
fn order(candidate: &Candidate) -> f64 {
    let shape = candidate.terms[0].shape[0];
    if candidate.effect().name() == "position_dependent_friction" { shape / 45.0 } else { shape }
}

/// No line is named where there is none. A name needs evidence that chance reaches once in e¹² for each of three effects: once in 50,000
/// recordings. The slow errors are not exactly exponential around their level, so that one false alarm in the 240 draws is accepted: at a rate of
/// one in a thousand, two or more have a probability of 2 %. Waves too slow to be lines are shapes of the stroke, which the errors do contain.
#[test]
fn property_slow_errors_show_no_line() {
    let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
    let mut named = Vec::new();
    for seed in 0..240 {
        let found = judged(&model, seed, None);
        let is_line = |candidate: &&Candidate| candidate.is_accepted(&Rules::default()) && order(candidate) > 0.5;
        named.extend(found.iter().filter(is_line).map(|one| (seed, one.effect().name(), order(one), one.total())));
    }
    assert!(named.len() <= 1, "{} false alarms: {named:?}", named.len());
}

/// A line of 1.5 N·m beside slow errors of up to 1 N·m is found at its order and with the right law on 17 of these 20 recordings, and one
/// of 0.5 N·m on 10. Orders are scanned in rows that are not filtered: where slow errors weigh more than the line there, it is not among
/// the orders that are judged. No other line is named in its place.
#[test]
fn recover_a_line_in_slow_errors() {
    let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
    let first = |size: f64, seed: u64| {
        let found = judged(&model, seed, Some((3.0, size)));
        let mut lines = found.iter().filter(|one| one.is_accepted(&Rules::default()) && order(one) > 0.5);
        lines.next().map(|one| (one.effect().name(), order(one)))
    };
    let right =
        |named: &Option<(&str, f64)>| named.is_some_and(|(name, n)| name == "cogging" && (n - 3.0).abs() < 1e-9);
    for (size, least) in [(0.5, 8), (1.5, 14)] {
        let named: Vec<_> = (1000..1020).map(|seed| first(size, seed)).collect();
        // A rate of 0.5 or 0.85 gives fewer than that in 13 and 2 of a hundred sets of 20.
        assert!(named.iter().filter(|named| right(named)).count() >= least, "{size} N·m: {named:?}");
        assert!(named.iter().flatten().all(|(name, _)| *name == "cogging"), "{size} N·m: {named:?}");
    }
}
