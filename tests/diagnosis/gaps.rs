//! What a diagnosis says of gaps where something else was named: none is measured where that may hold the link on a flank. With a second
//! encoder a soft gear and a gap that varies are told, and a gap is not taken for either.
//! No figure was tuned to these seeds, but for 3006.

use crate::motion;
use crate::record;
use std::ops::Range;
use std::path::Path;

use crate::drawn::Drawn;
use crate::hidden::{Arm, Field, Order};
use crate::machine::{JOINTS, Machine};
use lostmotion::diagnose::{Diagnosis, Options, Verdict, diagnose};
use lostmotion::drive::{Encoder, LinkEncoder};
use lostmotion::identify::{Quantity, backlash};
use lostmotion::robot::{EffectEntry, JointModel, Model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// [rad] a second encoder of 65536 counts a turn.
const LINK_COUNT: f64 = 1e-4;

/// A machine drawn by seed, with an effect in it.
struct Case {
    machine: Machine,
    rng: ChaCha8Rng,
    effects: Vec<EffectEntry>,
    /// Whether the gears have no gap, and the model file says so.
    rigid: bool,
}

impl Case {
    fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut machine = Machine::draw(&mut rng);
        machine.friction_unknown = true;
        Self { machine, rng, effects: Vec::new(), rigid: false }
    }

    /// With an effect.
    fn with(mut self, effect: &str, joint: Option<&str>, parameters: &[(&str, f64)]) -> Self {
        let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        self.effects.push(EffectEntry { effect: effect.to_owned(), joint: joint.map(str::to_owned), parameters });
        self
    }

    /// Records a staircase and two fast runs, and diagnoses them; the last is held out.
    fn diagnosed(mut self, second_encoder: bool) -> Diagnosis {
        let model = |text: String| {
            let mut model = Model::from_texts(&text, &self.machine.urdf(), Path::new("model.toml")).expect("a model");
            let encoder = second_encoder.then_some(LinkEncoder { resolution: LINK_COUNT });
            model.joints.iter_mut().for_each(|joint| joint.link_encoder = encoder);
            if self.rigid {
                model.joints.iter_mut().for_each(|joint| joint.backlash = Some(0.0));
            }
            model
        };
        let (truth, nominal) = (model(self.machine.truth(&self.effects)), model(self.machine.nominal()));
        let motions = [motion::staircase(&mut self.rng), motion::fast(&mut self.rng), motion::fast(&mut self.rng)];
        let sessions: Vec<_> = motions
            .iter()
            .enumerate()
            .map(|(index, motion)| record::record(&format!("run_{index}"), &truth, motion, index as u64))
            .collect();
        let (train, hold_out) = sessions.split_at(2);
        // Where a second encoder is there, no gap is sought in the motor's motion.
        diagnose(&nominal, train, hold_out, &Options::default(), &mut |_, _| {}).expect("a diagnosis")
    }
}

/// Names of the effects found, with their first joint.
fn names(found: &Diagnosis) -> Vec<(&str, &str)> {
    found.effects.iter().map(|effect| (effect.effect.as_str(), effect.joints[0].as_str())).collect()
}

#[test]
fn property_a_tilt_that_holds_the_links_leaves_the_gap_out_and_says_why() {
    let mut found = Case::new(3002).with("base_tilt", None, &[("tilt", 0.1), ("azimuth", 0.3)]).diagnosed(false);
    assert_eq!(names(&found), [("base_tilt", "joint1")], "{:?}", found.effects);
    for (index, joint) in JOINTS.iter().enumerate() {
        let baseline = &found.baseline[*joint];
        assert!(baseline.backlash.is_none(), "{joint}: {baseline:?}");
        assert!(found.extended_model.joints[index].backlash.is_none(), "{joint}");
        let reason = baseline.backlash_left_out.as_deref().unwrap_or_default();
        assert!(reason.contains("base_tilt") && reason.contains("of Coulomb friction"), "{joint}: {reason}");
    }
    // The report tells a reason that joints share once.
    found.baseline.values_mut().for_each(|baseline| baseline.backlash_left_out = Some("too few reversals".to_owned()));
    let text = lostmotion::report::diagnosis::document("arm", &found).to_text();
    assert_eq!(text.matches("Gap of joint1, joint2: not determined, too few reversals.").count(), 1, "{text}");
    assert_eq!(text.matches("not determined").count(), 1, "{text}");
}

/// The links of this machine have more of the friction: the tilt is put into the model, and the reversals show the gaps.
#[test]
fn recover_gaps_on_a_steeper_slope() {
    let case = Case::new(3001).with("base_tilt", None, &[("tilt", 0.1), ("azimuth", 0.3)]);
    let gaps = case.machine.backlash;
    let found = case.diagnosed(false);
    for (joint, gap) in JOINTS.iter().zip(gaps) {
        let measured = found.baseline[*joint].backlash.as_ref().expect("a gap");
        // Three standard errors, which are 3 to 4 % of these gaps.
        assert!((measured.value - gap).abs() < 3.0 * measured.std_error, "{joint}: {measured:?} of {gap}");
        assert!(measured.std_error < 0.05 * gap, "{joint}: {measured:?}");
    }
}

/// Gaps of both joints, beside the true ones [rad], of a machine of the field whose encoders have 2¹⁸ counts a turn: some thousand counts are a gap.
fn with_fine_encoders(seed: u64, gapless: bool) -> Vec<(Option<Quantity>, f64)> {
    let field = Some(Field { arm: Arm::Planar, rough: 0.0 });
    let mut drawn = Drawn::new(&Order { field, ..Order::nothing(seed) });
    let Drawn { machine, nominal, .. } = &mut drawn;
    for joint in machine.joints.iter_mut().chain(&mut nominal.joints) {
        joint.encoder = Some(Encoder { counts_per_turn: 262_144.0 });
    }
    if gapless {
        machine.joints.iter_mut().for_each(|joint| joint.backlash = Some(0.0));
    }
    let sessions: Vec<_> = drawn.sessions().take(2).collect();
    let data: Vec<_> = sessions.iter().collect();
    let measured = |(index, joint): (usize, &JointModel)| {
        let friction = joint.friction.expect("friction");
        let found = backlash::identify(&drawn.nominal, index, &data, &friction).ok();
        (found.map(|found| found.best.mean), joint.backlash.expect("a gap"))
    };
    drawn.machine.joints.iter().enumerate().map(measured).collect()
}

/// No model is exact to a count of such an encoder, and in the second session both joints move at once. Nothing was tuned to these seeds.
#[test]
#[ignore = "long: .ci/long carries it out"]
fn recover_gaps_by_fine_encoders_of_joints_that_move_together() {
    for (seed, gapless) in [(1_080_020, false), (1_080_021, true)] {
        for (measured, gap) in with_fine_encoders(seed, gapless) {
            let measured = measured.expect("a gap");
            // Three standard errors; these are at most 5 % of gaps of 7 and 10 mrad, and two counts (4.5 and 7.2 µrad) where there is none.
            assert!((measured.value - gap).abs() < 3.0 * measured.std_error, "{seed}: {measured:?} of {gap}");
            assert!(measured.std_error < if gapless { 15e-6 } else { 0.05 * gap }, "{seed}: {measured:?} of {gap}");
        }
    }
}

/// Diagnoses of machines on a base that leans by 0.02 rad, which loads the links with about their friction, each with its gaps [rad]; with 0 in place of all.
fn on_a_slope(seeds: Range<u64>, gapless: bool) -> Vec<(Diagnosis, [f64; 2])> {
    let on_a_slope = |seed: u64| {
        let mut case = Case::new(seed).with("base_tilt", None, &[("tilt", 0.02), ("azimuth", 0.9)]);
        if gapless {
            case.machine.backlash = [0.0; 2];
        }
        let gaps = case.machine.backlash;
        (case.diagnosed(false), gaps)
    };
    seeds.into_par_iter().map(on_a_slope).collect()
}

#[test]
#[ignore = "long: .ci/long carries it out"]
fn recover_gaps_that_a_tilt_loads_or_say_nothing() {
    let mut measured = 0;
    for (found, gaps) in on_a_slope(3061..3071, false) {
        for (joint, truth) in JOINTS.iter().zip(gaps) {
            let Some(gap) = &found.baseline[*joint].backlash else { continue };
            measured += 1;
            // Four standard errors: a gap is beyond them once in 16000 times.
            assert!((gap.value - truth).abs() < 4.0 * gap.std_error, "{joint}: {gap:?}, true {truth}");
        }
    }
    // Tuning seeds 3021 to 3032: 11 of 24.
    assert!(measured >= 5, "{measured}");
}

#[test]
#[ignore = "long: .ci/long carries it out"]
fn property_a_tilt_shows_no_gap_where_there_is_none() {
    for (found, _) in on_a_slope(3071..3077, true) {
        for joint in JOINTS {
            let Some(gap) = &found.baseline[joint].backlash else { continue };
            assert!(gap.value < 4.0 * gap.std_error, "{joint}: {gap:?}");
        }
    }
}

#[test]
fn recover_the_gaps_of_a_machine_whose_friction_is_asymmetric() {
    let case = Case::new(3002).with("viscous_asymmetry", Some("joint1"), &[("positive", 0.6), ("negative", 0.3)]);
    let gaps = case.machine.backlash;
    let found = case.diagnosed(false);
    assert_eq!(names(&found), [("viscous_asymmetry", "joint1")], "{:?}", found.effects);
    for (joint, truth) in JOINTS.iter().zip(gaps) {
        let baseline = &found.baseline[*joint];
        assert_eq!(baseline.backlash_left_out, None, "{joint}");
        let gap = baseline.backlash.as_ref().expect("a gap");
        // A count of the motor's encoder is a tenth of the gap.
        assert!((gap.value / truth - 1.0).abs() < 0.1, "{joint}: {gap:?}, true {truth}");
    }
}

#[test]
fn property_rests_of_a_gear_without_a_gap_are_no_error_of_its_model() {
    // A staircase rests between its steps, and friction then holds the joint with any torque below breakaway.
    let found = Case { rigid: true, ..Case::new(3008) }.diagnosed(false);
    assert_eq!(found.verdict, Verdict::NothingFound, "{:?} {:?}", found.effects, found.unexplained);
    for error in &found.fit {
        // What is left at low speed, where a kernel rounds the friction law off, is below 3 % of the torque. With the rests it is 13 to 19 %.
        assert!(error.before_percent < 5.0, "{error:?}");
    }
}

#[test]
fn recover_a_soft_gear_by_two_encoders() {
    let found = Case::new(3006).with("joint_compliance", Some("joint1"), &[("stiffness", 200.0)]).diagnosed(true);
    assert_eq!(names(&found), [("joint_compliance", "joint1")], "{:?}", found.effects);
    let k = &found.effects[0].parameters["stiffness"];
    assert!((k.value - 200.0).abs() < 3.0 * k.std_error && k.std_error < 20.0, "{k:?}");
}

#[test]
fn recover_a_gap_that_varies_by_two_encoders() {
    let case = Case::new(3007);
    let planted = [("amplitude", 0.3 * case.machine.backlash[0]), ("order", 2.0), ("phase", 0.7)];
    let found = case.with("position_dependent_backlash", Some("joint1"), &planted).diagnosed(true);
    assert_eq!(names(&found), [("position_dependent_backlash", "joint1")], "{:?}", found.effects);
    for (name, truth) in planted {
        let measured = &found.effects[0].parameters[name];
        assert!((measured.value - truth).abs() < 3.0 * measured.std_error, "{name}: {measured:?}, true {truth}");
        // Known well enough to say something.
        assert!(measured.std_error < 0.1 * truth, "{name}: {measured:?}");
    }
}

#[test]
#[ignore = "long: .ci/long carries it out"]
fn property_a_gap_is_not_taken_for_a_soft_gear_or_one_that_varies() {
    let hidden: [(&str, &[(&str, f64)]); 2] = [
        ("transmission_error", &[("amplitude", 4e-4), ("teeth", 50.0), ("phase", 1.0)]),
        ("position_dependent_friction", &[("amplitude", 0.4), ("order", 2.0), ("phase", 1.0)]),
    ];
    let others =
        (3011..).zip(hidden).map(|(seed, (effect, given))| Case::new(seed).with(effect, Some("joint1"), given));
    for case in std::iter::once(Case::new(3010)).chain(others) {
        let hidden = format!("{:?}", case.effects);
        let found = case.diagnosed(true);
        let names = names(&found);
        let of_gears = ["joint_compliance", "position_dependent_backlash"];
        assert!(names.iter().all(|(name, _)| !of_gears.contains(name)), "{hidden}: {names:?}");
    }
}
