//! The tail of ordinary throws, and rotors that are thrown at the same time.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::throws::Ordinary;
use super::*;
use crate::effects::drawn::{MODEL, ROBOT};
use crate::timeseries::JointSeries;

/// [s] Length of a session.
const LENGTH: f64 = 40.0;
/// [s] Time at which rotors are thrown.
const SLIP: f64 = 23.4;

/// The share that lies beyond a throw by the tail of 650 others is that of a new one: of 20,000 new throws 200 ± 14 lie beyond a share of 1 %,
/// and 20 ± 4.5 beyond one of 0.1 %; four times these errors are allowed. With a tail that is shared by 100 throws the estimates themselves scatter by
/// 1/√20, so that 200 tails are drawn.
#[test]
fn property_shares_in_the_tail_are_those_of_new_throws() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut exponential = || -rng.random_range(1e-12..1.0_f64).ln();
    let (mut beyond, mut far_beyond) = (0, 0);
    for _ in 0..200 {
        let ordinary = Ordinary::of((0..650).map(|_| exponential()).collect(), 1e-6);
        for _ in 0..100 {
            let share = ordinary.share_beyond(exponential());
            beyond += i32::from(share < 0.01);
            far_beyond += i32::from(share < 0.001);
        }
    }
    assert!((beyond - 200).abs() < 57, "{beyond}");
    assert!((far_beyond - 20).abs() < 18, "{far_beyond}");
}

/// Whole counts have steps in place of a tail: a share that is said is never too small by more than the errors of the count.
#[test]
fn property_shares_of_whole_counts_are_not_too_small() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    // A count more in one of twenty windows, two in one of four hundred, and so on.
    let mut counts = || (-rng.random_range(1e-12..1.0_f64).ln() / 20.0_f64.ln()).floor();
    let mut beyond = 0;
    for _ in 0..200 {
        let ordinary = Ordinary::of((0..650).map(|_| counts()).collect(), 1.0);
        beyond += (0..100).filter(|_| ordinary.share_beyond(counts()) < 0.001).count();
    }
    // 20 ± 4.5 of 20,000, and four times the error.
    assert!(beyond < 38, "{beyond}");
}

/// A session of a rotor whose encoder has 2000 counts a turn, on the joint side of a gear of 45, with waves of some draw. It is thrown by some
/// counts.
fn session(draw: u64, thrown: f64) -> TimeSeries {
    session_of(draw, thrown, SLIP, &|t| t)
}

/// The same, thrown at a time [s], and the phase of its waves at each time.
fn session_of(draw: u64, thrown: f64, at: f64, phase: &dyn Fn(f64) -> f64) -> TimeSeries {
    let mut rng = ChaCha8Rng::seed_from_u64(draw);
    let waves: Vec<[f64; 3]> = (0..3)
        .map(|_| [rng.random_range(0.2..0.7), TAU * rng.random_range(0.15..0.8), rng.random_range(0.0..TAU)])
        .collect();
    let count = TAU / (2000.0 * 45.0);
    let time: Vec<f64> = (0..(LENGTH / 1e-3) as usize).map(|k| k as f64 * 1e-3).collect();
    let of =
        |t: f64, f: &dyn Fn(f64, f64, f64) -> f64| waves.iter().map(|[a, w, phi]| f(*a, *w, w * t + phi)).sum::<f64>();
    let position = |t: &f64| {
        let by = thrown * count * ((t - at) / 0.01).clamp(0.0, 1.0);
        ((of(phase(*t), &|a, _, x| a * x.sin()) + by) / count).round() * count
    };
    // J_r = 2e-5 · 45² kg·m², 0.02 N·m/A · 45 N·m per A; the rotor alone.
    let current = |t: &f64| of(phase(*t), &|a, w, x| -a * w * w * x.sin()) * 2e-5 * 45.0 / 0.02;
    let channels = BTreeMap::from([
        (Channel::Position, time.iter().map(position).collect::<Vec<f64>>().into()),
        (Channel::Current, time.iter().map(current).collect::<Vec<f64>>().into()),
    ]);
    let series = JointSeries { name: "joint1".to_owned(), channels };
    TimeSeries { name: format!("session_{draw}"), time, joints: vec![series] }
}

/// Coincidences in these sessions of a rotor.
fn found(sessions: &[TimeSeries]) -> Vec<Coincidence> {
    let model = format!("{MODEL}[joints.joint1.encoder]\ncounts_per_turn = 2000.0\n");
    let model = Model::from_texts(&model, ROBOT, Path::new("model.toml")).expect("a good model");
    let sessions: Vec<&TimeSeries> = sessions.iter().collect();
    Searched::new(&model, &sessions, |_, session| std::iter::once(0..session.len()).collect()).coincidences()
}

#[test]
fn recover_throws_at_the_same_time_of_different_motions() {
    let coincidences = found(&[session(1, 8.0), session(2, 6.0), session(3, 0.0)]);
    let [one] = coincidences.as_slice() else { panic!("{coincidences:?}") };
    // The throw lasts 10 ms, the second difference spans 16 ms.
    assert!((one.time - SLIP).abs() < 0.02, "{one:?}");
    assert_eq!(one.sessions().len(), 2, "the third is not thrown: {one:?}");
}

#[test]
fn property_a_throw_of_one_session_or_of_one_motion_is_no_slip() {
    assert_eq!(found(&[session(1, 8.0), session(2, 0.0), session(3, 0.0)]), [], "a knock");
    assert_eq!(found(&[session(1, 8.0), session(1, 8.0), session(1, 6.0)]), [], "the same motion three times");
    let switched_on = [1, 2, 3].map(|draw| session_of(draw, 8.0, 0.02, &|t| t));
    assert_eq!(found(&switched_on), [], "when drives are switched on");
    let stopped = [1, 2, 3].map(|draw| session_of(draw, 8.0, LENGTH - 0.02, &|t| t));
    assert_eq!(found(&stopped), [], "when drives are stopped");
    // All begin to move where they are thrown, after a rest, and are as fast as their waves a second later.
    let begins = |t: f64| SLIP + (t - SLIP).max(0.0).powi(2) / (t - SLIP + 1.0).max(1.0);
    let begun = [1, 2, 3].map(|draw| session_of(draw, 8.0, SLIP, &begins));
    assert_eq!(found(&begun), [], "when a programme begins");
    // 3e-4 each: one in a hundred runs of this test would have one by chance.
    let sound = (0..30).filter(|draw| !found(&[0, 1, 2].map(|k| session(10 + 3 * draw + k, 0.0))).is_empty()).count();
    assert_eq!(sound, 0, "of 30 machines that do not slip");
}
