//! The judgement by simulation: it refuses what it is not made for, finds what the regression cannot see, and names nothing on a healthy machine.

use crate::drawn::Drawn;
use crate::hidden::Order;
use lostmotion::diagnose::judge::{self, judge};
use lostmotion::diagnose::{Diagnosis, Judgement, Options, diagnose};
use lostmotion::timeseries::{Channel, TimeSeries};

/// A machine's sessions, the last of which is held out, and what the regression says of them.
fn diagnosed(order: &Order) -> (Diagnosis, Vec<TimeSeries>) {
    let drawn = Drawn::new(order);
    let sessions: Vec<TimeSeries> = drawn.sessions().collect();
    let found = diagnose(&drawn.nominal, &sessions[..3], &sessions[3..], &Options::default(), &mut |_, _| {});
    (found.expect("a diagnosis"), sessions)
}

/// With these effects beside what the regression named.
fn judged(order: &Order, unseen: &[&'static str]) -> Judgement {
    let (found, sessions) = diagnosed(order);
    let options = judge::Options { seconds: f64::INFINITY, unseen: unseen.to_vec(), ..judge::Options::default() };
    let judgement = judge(&found, &sessions[..3], &sessions[3..], &options, &mut |_, _| {}).expect("a judgement");
    println!("{judgement:#?}");
    judgement
}

#[test]
fn property_what_is_not_judged_by_simulation_is_said_in_a_sentence() {
    let (found, sessions) = diagnosed(&Order::nothing(700_020));
    let reason = |found: &Diagnosis, sessions: &[TimeSeries]| {
        let options = judge::Options::default();
        let judgement = judge(found, sessions, &[], &options, &mut |_, _| {}).expect("a judgement");
        assert!(judgement.names.is_empty() && judgement.sets.is_empty());
        judgement.not_applied.expect("a reason")
    };
    let mut uneven = sessions.clone();
    uneven[1].time.iter_mut().step_by(2).for_each(|time| *time += 3e-4);
    assert!(reason(&found, &uneven).contains("not sampled evenly"));
    let mut torques = sessions.clone();
    let current = torques[0].joints[1].channels.remove(&Channel::Current).expect("a current");
    torques[0].joints[1].channels.insert(Channel::Torque, current);
    assert!(reason(&found, &torques).contains("no motor current"));
    let mut exact = found.clone();
    exact.baseline_model.joints[0].encoder = None;
    assert!(reason(&exact, &sessions).contains("no encoder counts"));
    let mut without = found.clone();
    without.baseline.clear();
    assert!(reason(&without, &sessions).contains("not judged by its torque"));
    let short: Vec<TimeSeries> = sessions.iter().map(|session| session.part(0..5000)).collect();
    assert!(reason(&found, &short).contains("too short"));
}

#[test]
#[ignore = "long: .ci/run carries it out"]
fn recover_a_compliance_that_the_regression_cannot_see() {
    let judgement = judged(&Order::one("joint_compliance", 1.0, 700_021), &["joint_compliance", "dwell_stiction"]);
    let best = judgement.sets.first().expect("a set");
    assert!(best.effects.contains(&"joint_compliance".to_owned()), "{}", best.name);
    assert!(judgement.unexplained || judgement.supports("joint_compliance"), "{judgement:?}");
}

#[test]
#[ignore = "long: .ci/run carries it out"]
fn property_nothing_is_named_on_a_healthy_machine() {
    let judgement = judged(&Order::nothing(700_022), &["joint_compliance", "dwell_stiction"]);
    assert!(judgement.names.iter().all(|name| name.probability < 0.5), "{:?}", judgement.names);
    assert!(!judgement.unexplained, "{:?}", judgement.distance);
}
