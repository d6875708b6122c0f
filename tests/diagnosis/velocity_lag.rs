//! Uneven sampling, pauses, and a velocity channel that lags: simulated recordings with and without, even and uneven.

use crate::sines::{nominal, recorded, thinned, uneven, with};
use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::effects::Kind;
use lostmotion::timeseries::TimeSeries;

/// Standard errors within which a planted value has to be recovered: 1 in 80 estimates lies outside.
const WITHIN: f64 = 2.5;

fn diagnosed(sessions: &[TimeSeries]) -> Diagnosis {
    let options = Options { backlash: false, ..Options::default() };
    let (train, hold_out) = sessions.split_at(2);
    diagnose(&nominal(), train, hold_out, &options, &mut |_, _| {}).expect("a diagnosis")
}

fn sessions(parameters: &[(&str, f64)], change: fn(&TimeSeries) -> TimeSeries) -> Vec<TimeSeries> {
    (1..=3).map(|number| change(&recorded(&with("velocity_lag", parameters), number))).collect()
}

fn recovers(planted: (&str, f64), other: &str, change: fn(&TimeSeries) -> TimeSeries) {
    let found = diagnosed(&sessions(&[planted], change));
    let lag = found.effects.iter().find(|one| one.effect == "velocity_lag").expect("the lag is named");
    println!("{planted:?}: {:?}, gain {:.0} %", lag.parameters, lag.gain.gain_percent);
    assert_eq!((lag.kind, lag.joints.as_slice()), (Kind::Measurement, ["joint1".to_owned()].as_slice()));
    let measured = &lag.parameters[planted.0];
    assert!((measured.value - planted.1).abs() < WITHIN * measured.std_error, "{measured:?}");
    assert!(!lag.parameters.contains_key(other), "the other lag is ruled out: {:?}", lag.parameters);
    // The lag is nearly all that the channel's error consists of.
    assert!(lag.gain.gain_interval_percent[0] > 50.0, "{:?}", lag.gain);
}

#[test]
fn recover_a_late_velocity_channel() {
    recovers(("delay", 0.02), "time_constant", TimeSeries::clone);
}

#[test]
fn recover_a_late_velocity_channel_at_uneven_times() {
    recovers(("delay", 0.02), "time_constant", uneven);
}

#[test]
fn recover_a_filtered_velocity_channel() {
    recovers(("time_constant", 0.05), "delay", TimeSeries::clone);
}

#[test]
fn recover_a_filtered_velocity_channel_at_uneven_times() {
    recovers(("time_constant", 0.2), "delay", uneven);
}

/// The negative control: the low-pass of the model file, even and uneven samples, and a pause.
#[test]
fn property_nothing_is_found_without_a_lag() {
    let paused = |session: &TimeSeries| thinned(session, |k| !(5000..7000).contains(&k));
    let coarse = |session: &TimeSeries| thinned(session, |k| k % 4 == 0);
    for change in [TimeSeries::clone as fn(&TimeSeries) -> TimeSeries, coarse, uneven, paused] {
        let found = diagnosed(&sessions(&[], change));
        assert!(found.effects.is_empty() && found.mistakes.is_empty(), "{:?} {:?}", found.effects, found.mistakes);
        // 0.442 N·m of Coulomb friction in the simulated machine.
        let coulomb = &found.baseline["joint1"].friction["coulomb"];
        assert!((coulomb.value - 0.442).abs() < 0.02, "{coulomb:?}");
    }
}

#[test]
fn property_a_pause_gets_no_rows_and_ends_no_session() {
    let paused = |session: &TimeSeries| thinned(session, |k| !(5000..7000).contains(&k));
    let found = diagnosed(&sessions(&[], paused));
    assert_eq!(found.series.len(), 3, "one series a session");
    for series in &found.series {
        assert!(series.time.iter().any(|t| *t < 4.9) && series.time.iter().any(|t| *t > 7.1));
        // The widest kernel keeps away from both sides; the narrowest is 6 ms.
        assert!(series.time.iter().all(|t| *t < 4.994 || *t > 7.005), "{:?}", series.time);
    }
}
