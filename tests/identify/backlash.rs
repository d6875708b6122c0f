//! The gap from motor-side signals: the paper's procedure and the likelihood of the counts.

use std::path::Path;

use lostmotion::identify::backlash::EstimatorResult;
use lostmotion::identify::{self, BacklashIdentification, Options};
use lostmotion::robot::Model;
use lostmotion::scenario::{Scenario, simulate};
use lostmotion::timeseries::TimeSeries;

/// The gap of a joint.
fn gap(model: &Model, joint: usize, data: &[TimeSeries]) -> BacklashIdentification {
    let found = identify::identify_joint(model, joint, data, &Options::default()).expect("friction");
    found.backlash.unwrap_or_else(|| panic!("{}: {:?}", found.joint, found.notes))
}

/// A scenario of the repository with values changed.
fn scenario(name: &str, assignments: &[String]) -> Scenario {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name).join("scenario.toml");
    Scenario::load(&file, assignments).expect("a scenario of the repository")
}

/// What the sensors say in a run.
fn measured(scenario: &Scenario, seed: u64) -> Vec<TimeSeries> {
    simulate(scenario, seed, &|_, _| {}).expect("a run").measured()
}

/// Joints that some session moves by more than a degree or a centimetre.
fn moved(model: &Model, data: &[TimeSeries]) -> Vec<usize> {
    use lostmotion::timeseries::Channel::ReferenceVelocity;
    let moves = |name: &str| {
        data.iter()
            .filter_map(|series| series.joint(name)?.get(ReferenceVelocity))
            .any(|v| v.iter().any(|v| v.abs() > 1e-3))
    };
    (0..model.joints.len()).filter(|&joint| moves(&model.joints[joint].name)).collect()
}

fn error_percent(estimator: &EstimatorResult, truth: f64) -> f64 {
    100.0 * (estimator.mean.value / truth - 1.0)
}

#[test]
fn recover_gap_of_scara() {
    let scenario = scenario("01_identify_scara", &[]);
    let data = measured(&scenario, 11);
    // The published mean deviations of joints 1 and 2 [%].
    for (joint, published) in [(0, 6.3), (1, 11.9)] {
        let found = gap(&scenario.model, joint, &data);
        let truth = scenario.truth.backlash(&scenario.model.joints[joint].name).expect("a known gap");
        // Asked of every single run; the standard error is about 0.8 and 1.8 %.
        assert!(error_percent(&found.best, truth).abs() < 6.0, "{:?}", found.best.mean);
        assert!((found.best.mean.value - truth).abs() < 4.0 * found.best.mean.std_error, "{:?}", found.best.mean);
        assert!(found.best.mean_deviation_percent < published, "{}", found.best.mean_deviation_percent);
        assert!(!found.consistent_with_zero());
        // Most of the twelve gentlest reversals must be used: an estimate from a few that happen to fit would be worth little.
        assert!(found.best.values.len() >= 9, "{:?}", found.best.left_out);
        // Friction splits 70 : 30. A by-product: over eight seeds its RMS error is 0.035 on joint 2, 0.02 on joint 1; 2.3 times that.
        let share = found.link_share.expect("a share").value;
        assert!((share - 0.3).abs() < 0.08, "{share}");
        // What the literal rule is known for: noise makes a minimum at once.
        assert!(error_percent(&found.paper_literal, truth) < -70.0);
    }
}

#[test]
fn property_no_gap_is_reported_as_none() {
    let none = ["model.joints.joint1.backlash=0.0", "model.joints.joint2.backlash=0.0"].map(str::to_owned);
    let scenario = scenario("01_identify_scara", &none);
    let mut consistent = 0;
    for seed in 11..15 {
        let data = measured(&scenario, seed);
        for joint in 0..2 {
            let found = gap(&scenario.model, joint, &data);
            // Half an encoder count, a thirtieth of the real arm's gap: what a machine without a gap may show.
            let count = scenario.model.joints[joint].encoder_step();
            assert!(found.best.mean.value.abs() < 0.5 * count, "{:?}, a count is {count}", found.best.mean);
            consistent += usize::from(found.consistent_with_zero());
        }
    }
    // Of eight intervals of 95 %, fewer than six hold the truth in 0.6 % of all cases.
    assert!(consistent >= 6, "{consistent} of 8");
}

/// Gaps of four and two counts, with a current without sign: four of twelve reversals of joint 2 agreed on a gap five times too large, at which the others
/// had no preference. A gap is that of the machine or none.
#[test]
fn regress_a_few_reversals_against_most_give_no_gap() {
    let coarse = ["joint1", "joint2"].map(|joint| {
        let at = format!("model.joints.{joint}");
        [format!("{at}.encoder.counts_per_turn=500"), format!("{at}.current_sensor.sensing=absolute")]
    });
    let scenario = scenario("01_identify_scara", coarse.as_flattened());
    let data = measured(&scenario, 6006);
    for joint in 0..2 {
        let model = &scenario.model;
        let found = identify::identify_joint(model, joint, &data, &Options::default()).expect("friction");
        let truth = scenario.truth.backlash(&model.joints[joint].name).expect("a known gap");
        let mean = found.backlash.as_ref().map(|gap| &gap.best.mean);
        // The gap of joint 1, of four counts, is measured.
        assert!(joint == 1 || mean.is_some(), "{:?}", found.notes);
        // As asked of every single run: the wrong gap was 21 standard errors off.
        assert!(mean.is_none_or(|mean| (mean.value - truth).abs() < 4.0 * mean.std_error), "{mean:?}");
    }
}

/// A soft gear winds up at a reversal by nearly the gap, and what of that is wind-up follows from the link's share of friction, which a noisy current shows badly:
/// its error is part of the gap's. Where that share of 0.6 was found as 0.49 ± 0.015, the gap was 4.2 standard errors off.
#[test]
fn recover_gap_of_a_soft_gear_by_a_noisy_current() {
    let soft = [
        "gear_stiffness=150",
        "friction.link_share=0.6",
        "backlash=0.004",
        "current_sensor.noise=1.2",
        "encoder.counts_per_turn=50000",
    ]
    .map(|assignment| format!("model.joints.joint1.{assignment}"));
    let scenario = scenario("01_identify_scara", &soft);
    let found = gap(&scenario.model, 0, &measured(&scenario, 11));
    let mean = &found.best.mean;
    // One interval of 95 % in twenty misses by more than two; three are asked of a single run.
    assert!((mean.value - 0.004).abs() < 3.0 * mean.std_error, "{mean:?}, {:?}", found.link_share);
    // It stays a measurement: the error is 4 %.
    assert!(mean.std_error < 0.06 * mean.value, "{mean:?}");
}

/// `LOSTMOTION_GAP_TABLE="SCENARIO FIRST_SEED SEEDS [KEY=VALUE...]"` prints a table of the gaps found.
#[test]
#[ignore = "prints a table of the runs that LOSTMOTION_GAP_TABLE asks for"]
fn scenario_gap_table() {
    let order = std::env::var("LOSTMOTION_GAP_TABLE").expect("SCENARIO FIRST_SEED SEEDS [KEY=VALUE...]");
    let mut words = order.split_whitespace();
    let name = words.next().expect("a scenario");
    let mut number = || words.next().and_then(|word| word.parse::<u64>().ok()).expect("a number");
    let (first, seeds) = (number(), number());
    let assignments: Vec<String> = words.map(str::to_owned).collect();
    let scenario = scenario(name, &assignments);
    for seed in first..first + seeds {
        let data = measured(&scenario, seed);
        for joint in moved(&scenario.model, &data) {
            let machine = &scenario.model.joints[joint];
            let found = match identify::identify_joint(&scenario.model, joint, &data, &Options::default()) {
                Ok(found) => found,
                Err(error) => {
                    println!("{seed} {} {error}", machine.name);
                    continue;
                }
            };
            let Some(backlash) = &found.backlash else {
                println!("{seed} {} {:?}", machine.name, found.notes);
                continue;
            };
            let truth = scenario.truth.backlash(&machine.name).unwrap_or(0.0);
            for estimator in [&backlash.paper_literal, &backlash.paper, &backlash.best] {
                let mut reasons: Vec<String> =
                    estimator.left_out.iter().map(|one| format!("{:?}", one.reason)).collect();
                reasons.sort();
                reasons.dedup();
                println!(
                    "{seed} {} {} {:.4} deg, error {:+.2} %, std error {:.2} %, mean deviation {:.1} %, {} used, {} left out {reasons:?}",
                    machine.name,
                    estimator.name,
                    estimator.mean.value.to_degrees(),
                    error_percent(estimator, truth),
                    100.0 * estimator.mean.std_error / truth,
                    estimator.mean_deviation_percent,
                    estimator.values.len(),
                    estimator.left_out.len(),
                );
            }
            if let Some(share) = &backlash.link_share {
                println!("{seed} {} link share {:.3} ± {:.3}", machine.name, share.value, share.std_error);
            }
        }
    }
}
