//! Joints without a usable torque, or that stand still: they are left out, and what the others show is named.

use lostmotion::diagnose::Verdict;
use lostmotion::timeseries::Channel;

use super::*;

const TOOL: [(&str, f64); 3] = [("mass", 1.0), ("x", 0.09), ("z", 0.022)];

/// Joint 4 without a current, and joint 5 with one of noise in three steps of 10 mA.
fn spoiled(mut recorded: Vec<TimeSeries>) -> Vec<TimeSeries> {
    for session in &mut recorded {
        session.joints[3].channels.remove(&Channel::Current);
        let noise = session.joints[4].channels.get_mut(&Channel::Current).expect("a current");
        // An order that repeats after 9973 samples.
        noise.iter_mut().enumerate().for_each(|(k, value)| *value = 0.01 * ((k * k % 9973 % 3) as f64 - 1.0));
    }
    recorded
}

fn assert_left_out(found: &Diagnosis, joints: &[&str]) {
    assert!(found.mistakes.is_empty(), "{:?}", found.mistakes);
    for joint in &symmetric().joints {
        let is_out = joints.contains(&joint.name.as_str());
        let words = found.method.left_out.iter().any(|text| text.starts_with(&format!("{} is not judged", joint.name)));
        assert_eq!(words, is_out, "{}: {:?}", joint.name, found.method.left_out);
        assert_eq!(found.baseline.contains_key(&joint.name), !is_out, "{}", joint.name);
        assert_eq!(found.fit.iter().any(|one| one.joint == joint.name), !is_out, "{}", joint.name);
        let friction =
            found.extended_model.joints.iter().find(|one| one.name == joint.name).and_then(|one| one.friction);
        assert_eq!(friction.is_some(), !is_out, "the written model says nothing of {}'s friction", joint.name);
    }
}

#[test]
fn recover_a_heavier_tool_without_two_currents() {
    let found = diagnosed_from(symmetric(), &spoiled(recorded(&[effect("payload", None, &TOOL)], 81)));
    assert_eq!(first(&found).0, "payload");
    assert_left_out(&found, &["joint4", "joint5"]);
    let [dead] = found.dead_channels.as_slice() else { panic!("{:?}", found.dead_channels) };
    assert_eq!((dead.mistake, dead.joints.as_slice()), ("dead_channel", &["joint5".to_owned()][..]));
    assert!(dead.evidence.contains("joint5.current has only 3 values"), "{}", dead.evidence);
}

#[test]
fn property_nothing_is_found_in_a_sound_arm_without_two_currents() {
    let found = diagnosed_from(symmetric(), &spoiled(recorded(&[], 82)));
    assert_eq!(found.verdict, Verdict::NothingFound, "{:?}", found.effects);
    assert_left_out(&found, &["joint4", "joint5"]);
}

#[test]
fn recover_a_heavier_tool_with_two_joints_at_rest() {
    let run = simulated_but_for(&[3, 5], &symmetric(), &[effect("payload", None, &TOOL)], 83);
    let found = diagnosed_from(symmetric(), &run.measured());
    assert_eq!(first(&found).0, "payload");
    assert_left_out(&found, &["joint4", "joint6"]);
}

/// Without a torque of any joint nothing can be judged.
#[test]
fn property_a_recording_without_any_torque_is_refused() {
    let mut recorded = recorded(&[], 84);
    for joint in recorded.iter_mut().flat_map(|session| &mut session.joints) {
        joint.channels.remove(&Channel::Current);
    }
    let refused = diagnose(&symmetric(), &recorded[..2], &recorded[2..], &Options::default(), &mut |_, _| {});
    let message = refused.expect_err("nothing to judge").to_string();
    assert!(message.contains("current or torque"), "{message}");
}
