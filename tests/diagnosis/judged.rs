//! The judgement by simulation: it refuses what it is not made for, finds what the regression cannot see, and names nothing on a healthy machine.

use crate::drawn::Drawn;
use crate::hidden::Order;
use crate::rough;
use lostmotion::diagnose::judge::{self, judge};
use lostmotion::diagnose::{
    Diagnosis, EffectGain, JudgedEffect, JudgedMachine, Judgement, Measured, Options, Verdict, diagnose,
};
use lostmotion::replay::Gain;
use lostmotion::timeseries::{Channel, TimeSeries};

/// A machine's sessions, the last of which is held out, and what the regression says of them with a nominal model that is off by `rough` deviations.
fn diagnosed(order: &Order, rough: f64) -> (Diagnosis, Vec<TimeSeries>) {
    let drawn = Drawn::new(order);
    let sessions: Vec<TimeSeries> = drawn.sessions().collect();
    let nominal = if rough > 0.0 { rough::off(&drawn.nominal, order.seed, rough) } else { drawn.nominal.clone() };
    let found = diagnose(&nominal, &sessions[..3], &sessions[3..], &Options::default(), &mut |_, _| {});
    (found.expect("a diagnosis"), sessions)
}

/// The judgement between these effects, besides what the regression names; all of them are tried for docs/gate.md.
fn judged(order: &Order, rough: f64, unseen: &[&'static str]) -> Judgement {
    let (found, sessions) = diagnosed(order, rough);
    let options = judge::Options { seconds: f64::INFINITY, unseen: unseen.to_vec(), ..judge::Options::default() };
    let judgement = judge(&found, &sessions[..3], &sessions[3..], &options, &mut |_, _| {}).expect("a judgement");
    println!("{judgement:#?}");
    judgement
}

#[test]
fn property_what_is_not_judged_by_simulation_is_said_in_a_sentence() {
    let (found, sessions) = diagnosed(&Order::nothing(700_020), 0.0);
    let reason = |found: &Diagnosis, sessions: &[TimeSeries]| {
        let options = judge::Options::default();
        let judgement = judge(found, sessions, &[], &options, &mut |_, _| {}).expect("a judgement");
        assert!(judgement.names.is_empty() && judgement.sets.is_empty());
        judgement.not_applied.expect("a reason")
    };
    let mut still = sessions.clone();
    still[0].joints[1].channels.remove(&Channel::Current).expect("a current");
    assert!(reason(&found, &still).contains("neither torque nor current"));
    let mut exact = found.clone();
    exact.baseline_model.joints[0].encoder = None;
    let mut smooth = sessions.clone();
    for session in &mut smooth {
        let TimeSeries { time, joints, .. } = session;
        let positions = joints[0].channels.get_mut(&Channel::Position).expect("positions");
        positions.iter_mut().zip(time).for_each(|(position, time)| *position = (1.3 * *time).sin());
    }
    assert!(reason(&exact, &smooth).contains("encoder counts of"));
    let mut without = found.clone();
    without.baseline.clear();
    assert!(reason(&without, &sessions).contains("not judged by its torque"));
    let short: Vec<TimeSeries> = sessions.iter().map(|session| session.part(0..5000)).collect();
    assert!(reason(&found, &short).contains("too short"));
}

/// Without time the baseline alone is fitted: nothing is named, and all sets are listed as not tried.
#[test]
#[ignore = "long: .ci/long carries it out"]
fn property_sets_without_time_are_listed_as_not_tried() {
    let (found, sessions) = diagnosed(&Order::nothing(700_020), 0.0);
    let options = judge::Options { seconds: 0.0, ..judge::Options::default() };
    let judgement = judge(&found, &sessions[..3], &sessions[3..], &options, &mut |_, _| {}).expect("a judgement");
    assert!(judgement.names.is_empty(), "{:?}", judgement.names);
    assert_eq!(judgement.sets.iter().map(|set| set.name.as_str()).collect::<Vec<_>>(), ["nothing"]);
    for effect in &options.unseen {
        assert!(judgement.not_tried.iter().any(|set| set.contains(effect)), "{effect}: {:?}", judgement.not_tried);
    }
    assert!(judgement.distance.is_some_and(|distance| distance.floor.is_some()), "the distance from the floor");
}

/// What every sample supports takes its place in the diagnosis with a gain on data held out, and without one it is listed as withdrawn and changes nothing.
#[test]
fn property_a_judged_machine_is_adopted_with_a_gain_only() {
    let (found, _) = diagnosed(&Order::nothing(700_020), 0.0);
    let joint = found.baseline_model.joints[1].name.clone();
    let stiffness = Measured { value: 200.0, std_error: 1.0, unit: "N·m/rad" };
    let mut extended = found.baseline_model.clone();
    extended.joints[1].backlash = Some(0.004);
    let machine = JudgedMachine {
        baseline: found.baseline_model.clone(),
        extended: extended.clone(),
        effects: vec![JudgedEffect {
            effect: "joint_compliance".to_owned(),
            joint: Some(joint.clone()),
            parameters: [("stiffness".to_owned(), stiffness.clone())].into(),
            probability: 0.97,
            gain_nats: 800.0,
            confusable_with: Vec::new(),
            without: found.baseline_model.clone(),
        }],
        estimates: [(joint.clone(), [("backlash", Measured { value: 0.004, std_error: 1e-5, unit: "rad" })].into())]
            .into(),
    };
    let gain = |interval_percent: [f64; 2]| {
        let gain = Gain { gain_percent: 30.0, interval_percent, shown: interval_percent[0] > 0.0 };
        EffectGain::of(gain, "position 0.1 s ahead")
    };
    let mut adopted = found.clone();
    judge::adopt(&mut adopted, machine.clone(), &[gain([20.0, 40.0])]);
    assert_eq!(adopted.verdict, Verdict::EffectsFound);
    assert_eq!((&*adopted.effects[0].effect, &adopted.effects[0].joints), ("joint_compliance", &vec![joint.clone()]));
    assert_eq!(adopted.effects[0].parameters["stiffness"], stiffness);
    assert_eq!(adopted.baseline[&joint].backlash.as_ref().map(|gap| gap.value), Some(0.004));
    assert_eq!(adopted.extended_model, extended);
    let without_effects = JudgedMachine { effects: Vec::new(), ..machine.clone() };
    let mut refined = found.clone();
    judge::adopt(&mut refined, without_effects, &[]);
    assert_eq!((refined.verdict, &refined.extended_model), (found.verdict, &extended));
    assert!(refined.effects.is_empty() && refined.baseline_model == found.baseline_model);
    let mut refused = found.clone();
    judge::adopt(&mut refused, machine, &[gain([-5.0, 40.0])]);
    assert_eq!(refused.withdrawn.last().map(|one| &*one.effect), Some("joint_compliance"));
    refused.withdrawn.pop();
    assert_eq!(format!("{refused:?}"), format!("{found:?}"));
}

// The machines of docs/gate.md.

#[test]
#[ignore = "long: .ci/long carries it out"]
fn recover_friction_that_grows_at_rest_by_judgement() {
    let judgement = judged(&Order::one("dwell_stiction", 1.0, 860_000), 0.0, &["dwell_stiction", "joint_compliance"]);
    assert!(judgement.supports("dwell_stiction") && judgement.names.len() == 1, "{:?}", judgement.names);
}

#[test]
#[ignore = "long: .ci/long carries it out"]
fn property_no_name_for_a_healthy_machine_with_an_inexact_model() {
    let judgement = judged(&Order::nothing(860_000), 1.0, &judge::Options::default().unseen);
    assert!(judgement.names.iter().all(|name| name.probability < 0.5), "{:?}", judgement.names);
    assert!(!judgement.unexplained, "{:?}", judgement.distance);
}
