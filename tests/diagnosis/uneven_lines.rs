//! A torque at a fixed frequency in recordings at even and at uneven times. Left out: at steps of 3 to 6 ms the line is not found.

use crate::sines::{nominal, recorded, uneven, with};
use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::timeseries::TimeSeries;

/// The planted line: amplitude [N·m], frequency [Hz], phase [rad].
const LINE: [(&str, f64); 3] = [("amplitude", 0.3), ("frequency", 37.3), ("phase", 0.4)];

fn diagnosed(parameters: &[(&str, f64)], change: fn(&TimeSeries) -> TimeSeries) -> Diagnosis {
    let sessions: Vec<TimeSeries> =
        (1..=3).map(|number| change(&recorded(&with("periodic_disturbance", parameters), number))).collect();
    let options = Options { backlash: false, ..Options::default() };
    let (train, hold_out) = sessions.split_at(2);
    diagnose(&nominal(), train, hold_out, &options, &mut |_, _| {}).expect("a diagnosis")
}

#[test]
fn recover_a_line_at_even_times() {
    let found = diagnosed(&LINE, TimeSeries::clone);
    let line = found.effects.iter().find(|one| one.effect == "periodic_disturbance").expect("the line is named");
    println!("{:?}, gain {:.0} %", line.parameters, line.gain.gain_percent);
    for (name, planted) in LINE {
        let measured = &line.parameters[name];
        // One in a hundred estimates lies outside 2.6 standard errors.
        assert!((measured.value - planted).abs() < 2.6 * measured.std_error, "{name}: {measured:?}");
    }
}

/// The negative control: the same recordings without the line.
#[test]
fn property_no_line_is_found_where_there_is_none() {
    for change in [uneven as fn(&TimeSeries) -> TimeSeries, TimeSeries::clone] {
        let found = diagnosed(&[], change);
        let named = found.effects.iter().any(|one| one.effect == "periodic_disturbance");
        assert!(!named, "{:?}", found.effects);
    }
}
