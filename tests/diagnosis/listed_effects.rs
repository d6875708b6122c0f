//! Effects that the model file already lists, as the corrected model of an earlier diagnosis does.

use crate::drawn::Drawn;
use crate::hidden::Order;
use lostmotion::diagnose::{Diagnosis, Options, Verdict, diagnose};
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;

/// A machine diagnosed with its nominal model, and with a model that follows from the result.
fn diagnosed(order: &Order, next: impl Fn(&Drawn, &Diagnosis) -> Model) -> [Diagnosis; 2] {
    let drawn = Drawn::new(order);
    let sessions: Vec<TimeSeries> = drawn.sessions().collect();
    let by = |model: &Model| {
        let found = diagnose(model, &sessions[..3], &sessions[3..], &Options::default(), &mut |_, _| {});
        found.expect("a diagnosis")
    };
    let first = by(&drawn.nominal);
    let second = by(&next(&drawn, &first));
    [first, second]
}

#[test]
fn property_a_listed_load_is_known_and_not_named_again() {
    let [nominal, listed] = diagnosed(&Order::one("payload", 1.0, 700_030), |drawn, _| Model {
        effects: drawn.entries.clone(),
        ..drawn.nominal.clone()
    });
    assert_eq!(nominal.effects[0].effect, "payload");
    assert_eq!(listed.verdict, Verdict::NothingFound, "{:?}", listed.effects);
    assert!(listed.extended_model.effects.is_empty() && listed.method.listed_effects.len() == 1);
    // The load is in the bodies of the corrected model.
    let masses = [&nominal.extended_model, &listed.extended_model].map(|model| model.robot.bodies[1].inertia.mass);
    assert!(masses[1] > masses[0] + 0.01, "{masses:?}");
}

#[test]
fn property_what_is_sought_anew_is_in_the_corrected_model_once() {
    let order = Order::one("coulomb_asymmetry", 1.0, 700_031);
    let [first, second] = diagnosed(&order, |_, found| found.extended_model.clone());
    assert!(!first.effects.is_empty());
    let names = |found: &Diagnosis| -> Vec<_> {
        found.extended_model.effects.iter().map(|entry| (entry.effect.clone(), entry.joint.clone())).collect()
    };
    assert_eq!(names(&second), names(&first));
    assert_eq!(second.method.listed_effects.len(), first.effects.len());
}
