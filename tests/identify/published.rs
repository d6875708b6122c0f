//! The paper's own estimators: closed forms on points without noise, ideal sensors, and their place in the report.

use std::path::Path;

use lostmotion::gearhead::{Direction, FrictionLaw, Lines};
use lostmotion::identify::published::{AveragePoint, PublishedFriction, friction};
use lostmotion::identify::{Identification, Options, Quantity, identify};
use lostmotion::plant::Engine;
use lostmotion::report::identification::report;
use lostmotion::scenario::{Scenario, simulate};
use lostmotion::units::{DEG, JointKind};

/// The published lines of joints 1 and 2, with the second line of joint 2 rising (the paper's minus sign is a misprint).
fn published_lines() -> [FrictionLaw; 2] {
    let lines = |a1: f64, b1: f64, a2: f64, b2: f64| Lines { a1, b1: b1 / DEG, a2, b2: b2 / DEG };
    [
        FrictionLaw::TwoLines([lines(0.4645, -0.119, 0.2718, 0.0106), lines(0.4493, -0.1085, 0.2847, 0.0072)]),
        FrictionLaw::TwoLines([lines(0.3013, -0.0562, 0.1334, 0.0312), lines(0.3141, -0.0594, 0.1623, 0.0359)]),
    ]
}

/// Points of the paper's staircase under a law, with a centrifugal term.
fn points(law: &FrictionLaw, centrifugal: f64) -> Vec<AveragePoint> {
    let speeds = (1..=20).flat_map(|k| [0.5 * DEG * f64::from(k), -0.5 * DEG * f64::from(k)]);
    speeds.map(|v| AveragePoint { velocity: v, friction: law.kinetic(v) + centrifugal * v * v }).collect()
}

fn coefficients(found: &PublishedFriction) -> Vec<&Quantity> {
    found.lines.each().into_iter().flat_map(|law| [&law.a1, &law.b1, &law.a2, &law.b2]).collect()
}

#[test]
fn analytic_points_on_four_lines_give_back_their_coefficients_and_the_centrifugal_term() {
    for law in published_lines() {
        let FrictionLaw::TwoLines(truth) = law else { unreachable!("lines") };
        for centrifugal in [0.0, 0.8, -0.8] {
            let found = friction(JointKind::Revolute, &points(&law, centrifugal)).expect("four lines");
            let expected: Vec<f64> = truth.iter().flat_map(|one| [one.a1, one.b1, one.a2, one.b2]).collect();
            for (one, expected) in coefficients(&found).into_iter().zip(expected) {
                // Nine unknowns, columns of a condition number below 1e4: eleven digits are left.
                assert!((one.value / expected - 1.0).abs() < 1e-10, "{} for {expected}", one.value);
            }
            assert!((found.centrifugal.value - centrifugal).abs() < 1e-9, "{}", found.centrifugal.value);
            for (one, truth) in found.lines.each().into_iter().zip(truth) {
                assert!((one.switch_velocity.value / truth.switch_velocity() - 1.0).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn property_a_direction_with_three_points_has_no_two_lines() {
    let law = &published_lines()[0];
    let few: Vec<AveragePoint> = points(law, 0.0)
        .into_iter()
        .filter(|point| Direction::of(point.velocity) == Direction::Positive || point.velocity > -1.6 * DEG)
        .collect();
    assert!(friction(JointKind::Revolute, &few).is_none());
    assert!(friction(JointKind::Revolute, &[]).is_none());
}

/// Ideal sensors and steps of 12 s leave what averages cannot do: a rest of the transient, `H ⟨q̈⟩`, in the mean torque, and friction
/// that is not linear in a velocity that fluctuates.
#[test]
fn recover_lines_from_long_steps_with_ideal_sensors() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/05_identify_scara_two_lines/scenario.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let text =
        text.replace("steady_time = 1.2", "steady_time = 12.0").replace("steady_time = 0.8", "steady_time = 12.0");
    let (_, found) = run(Scenario::from_text(&text, &path, &["sensors=ideal".to_owned()]).expect("a scenario"), 1);
    for joint in &found.joints {
        let published = joint.published.friction.as_ref().expect("two lines");
        for law in published.lines.each() {
            // A window begins with a velocity within 10 % of the final one, 0.017 rad/s at 10 deg/s. Over 12 s this is a mean acceleration
            // of 1.5e-3 rad/s², with 2.1 kg·m² about joint 1 a torque of 3 mN·m or 1 % of its friction. A line's ends get twice that.
            let curve = law.curve_error_percent.expect("a known law");
            assert!(curve < 2.0, "{}: {curve} %", joint.joint);
        }
    }
}

#[test]
fn property_the_published_estimates_stand_beside_ours_in_the_report() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/05_identify_scara_two_lines/scenario.toml");
    let (scenario, found) = run(Scenario::load(&path, &[]).expect("a scenario"), 6001);
    let report = report("scara", &found, Some(&scenario.truth), &scenario.model, Vec::new());
    for (k, joint) in found.joints.iter().enumerate() {
        let published = &report.json["joints"][k]["published"];
        let friction = joint.published.friction.as_ref().expect("two lines");
        assert_eq!(published["friction"]["lines"]["positive"]["a1"]["value"], friction.lines.positive.a1.value);
        assert_eq!(published["friction"]["centrifugal"]["true"], 0.0);
        let gap = joint.published.backlash.as_ref().expect("reversals");
        assert_eq!(published["backlash"]["mean"]["value"], gap.mean.value);
        assert_eq!(gap.values.len() + gap.left_out.len(), 10, "the last ten steps");
        // The last ten of twenty steps: 5.5 to 10 deg/s, all into the second direction of the step.
        let second = if k == 0 { -1.0 } else { 1.0 };
        let speeds = gap.values.iter().map(|one| one.velocity * second / DEG);
        // A pulse-period reading of a steady speed may be off by a few per cent.
        speeds.clone().for_each(|speed| assert!((4.5..11.0).contains(&speed), "{speed} deg/s"));
        // The short steps of the scenario are made for the balance over the motion; plain averages miss by several per cent.
        let worse = |curves: [Option<f64>; 2]| curves.into_iter().flatten().fold(0.0, f64::max);
        let ours = worse(joint.friction.lines.each().map(|law| law.curve_error_percent));
        assert!(worse(friction.lines.each().map(|law| law.curve_error_percent)) > 10.0 * ours);
        // Noise makes a local minimum at once.
        assert!(gap.mean.error_percent.expect("a known gap") < -90.0, "{:?}", gap.mean);
    }
    let text = report.document.to_text();
    assert_eq!(text.matches("As published").count(), found.joints.len(), "{text}");
    assert_eq!(text.matches("gap, filtered").count(), found.joints.len());
}

/// The scenario on the built-in engine, identified and compared with the truth.
fn run(mut scenario: Scenario, seed: u64) -> (Scenario, Identification) {
    scenario.options.engine = Engine::Reduced;
    let data = simulate(&scenario, seed, &|_, _| {}).expect("a run").measured();
    let mut found = identify(&scenario.model, &data, &Options::default()).expect("friction");
    scenario.truth.compare(&mut found);
    (scenario, found)
}
