//! What shows only where joints turn around, planted in simulated machines and found again in their recordings.
//!
//! Seeds below 900 served for tuning; those here did not.

#[path = "../hidden_effects/machine.rs"]
mod machine;
#[path = "../hidden_effects/motion.rs"]
mod motion;
#[path = "../hidden_effects/record.rs"]
mod record;

mod planted;

use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::timeseries::TimeSeries;
use planted::Set;

/// Diagnoses a set with its last run held out, the gap left to the turns.
fn diagnosed(set: &Set) -> Diagnosis {
    let (hold_out, train): (&TimeSeries, &[TimeSeries]) = set.sessions.split_last().expect("four sessions");
    let options = Options { backlash: false, ..Options::default() };
    diagnose(&set.nominal, train, std::slice::from_ref(hold_out), &options, &mut |_, _| {}).expect("a diagnosis")
}

/// Names of the effects found, with their joints.
fn names(diagnosis: &Diagnosis) -> Vec<(String, Vec<String>)> {
    diagnosis.effects.iter().map(|found| (found.effect.clone(), found.joints.clone())).collect()
}

/// The planted effect is the only one named, on its joint; returns its parameters as `(found, standard error, true)`.
fn recovered(effect: &str, seed: u64, parameters: &[&str]) -> Vec<[f64; 3]> {
    let set = planted::set(effect, seed);
    let found = diagnosed(&set);
    let planted = &set.entries[0];
    let joints: Vec<String> = planted.joint.iter().cloned().collect();
    assert_eq!(names(&found), [(effect.to_owned(), joints)], "{:?}", set.entries);
    let measured = &found.effects[0].parameters;
    parameters
        .iter()
        .map(|name| [measured[*name].value, measured[*name].std_error, planted.parameters[*name]])
        .collect()
}

#[test]
fn recover_presliding() {
    for [found, std_error, truth] in recovered("presliding", 1201, &["stiffness"]) {
        // Three standard errors; and at least a quarter right, so that the interval cannot swallow everything.
        assert!((found - truth).abs() < 3.0 * std_error, "{found} ± {std_error}, true {truth}");
        assert!((found / truth - 1.0).abs() < 0.25, "{found}, true {truth}");
    }
}

#[test]
fn recover_dwell_stiction() {
    for [found, std_error, truth] in recovered("dwell_stiction", 1301, &["growth"]) {
        assert!((found - truth).abs() < 3.0 * std_error, "{found} ± {std_error}, true {truth}");
        // Rests between moves last 0.05 to 0.5 s, about the time constant: growth and time constant share what is seen.
        assert!((found / truth - 1.0).abs() < 0.5, "{found}, true {truth}");
    }
}

#[test]
fn recover_coupling_slip() {
    let found = recovered("coupling_slip", 1601, &["time", "jump"]);
    let [time, jump] = [found[0], found[1]];
    // The rotor leaves its course when the ramp of 10 ms has taken up some counts; a controller's interval more or less.
    assert!((time[0] - time[2]).abs() < 3.0 * time[1] && time[1] < 0.01, "{time:?}");
    // Where in its gap the link stands is not known: a step of 1.5 gaps is known to one.
    assert!((jump[0] - jump[2]).abs() < 3.0 * jump[1] && jump[0] * jump[2] > 0.0, "{jump:?}");
    assert!((jump[0] / jump[2] - 1.0).abs() < 1.0, "{jump:?}");
}

#[test]
fn property_clean_machines_name_nothing() {
    for seed in 1001..1004 {
        let found = diagnosed(&planted::set("none", seed));
        assert!(names(&found).is_empty(), "seed {seed}: {:?}", found.effects);
    }
}

#[test]
fn property_other_effects_are_not_taken_for_those_of_turns() {
    for (effect, seed) in [("joint_compliance", 1501), ("position_dependent_friction", 1502), ("cogging", 1503)] {
        let found = names(&diagnosed(&planted::set(effect, seed)));
        let turns = ["coupling_slip", "dwell_stiction", "presliding"];
        assert!(found.iter().all(|(name, _)| !turns.contains(&name.as_str())), "{effect}, seed {seed}: {found:?}");
    }
}
