//! Data with an effect hidden by seed, or with none, made by a process of its own; the program sees only the data and the nominal model.
//!
//! Layout of a set: `<effect>_<seed>/{model.toml, robot.urdf, staircase.csv, fast_1.csv, fast_2.csv, fast_3.csv}`, and what was hidden in
//! `truth/<effect>_<seed>.json`. The seeds of this test belong to it alone: nothing may be tuned to them.
//! A set is judged right only where the hidden effect and no other is named. The bench `blind` draws and judges by the same modules, at length.

#[path = "../../tests/support/drawn/arm.rs"]
mod arm;
#[path = "../../tests/support/drawn/drawn.rs"]
mod drawn;
#[path = "../../tests/support/drawn/generate.rs"]
mod generate;
#[path = "../../tests/support/drawn/hidden.rs"]
mod hidden;
#[path = "../../tests/support/drawn/machine.rs"]
mod machine;
#[path = "../../tests/support/drawn/motion.rs"]
mod motion;
#[path = "../../tests/support/drawn/record.rs"]
mod record;
#[path = "../../tests/support/rough.rs"]
mod rough;
#[path = "../../tests/support/drawn/sampling.rs"]
mod sampling;
#[path = "../../tests/support/six_joints.rs"]
mod six_joints;
#[path = "../../tests/support/drawn/strengths.rs"]
mod strengths;
#[path = "../../tests/support/drawn/verdict.rs"]
mod verdict;

use std::collections::BTreeSet;

use generate::Set;
use hidden::Order;
use lostmotion::dataset;
use lostmotion::diagnose::Options;
use lostmotion::effects::CATALOGUE;
use lostmotion::robot::Model;
use rayon::prelude::*;
use verdict::Verdict;

/// One machine for each effect: `HIDING` and the following.
const HIDING: u64 = 500_000;
/// Effects with machines and tests of their own: steps and turns ask for other motions.
const ELSEWHERE: [&str; 4] = ["coupling_slip", "dwell_stiction", "position_dependent_backlash", "presliding"];
/// The negative control: machines that hide nothing.
const EMPTY: std::ops::Range<u64> = 510_000..510_010;
/// Most that may be named as something else, a twentieth: a program that is so wrong once in fifty draws passes with a probability of 93 %,
/// one that is wrong in a quarter with 2 %.
const MOST_WRONG: f64 = 0.05;
/// Most on which it may be silent. What is held out takes no part in naming, and three training sessions do not hold every effect: a stop
/// that is met in the held-out session alone, a weak line. On tuning machines (seeds from 60000) 2 of 21 stayed silent; such a program
/// passes with a probability of 98 %, one that is silent on half of all draws with 1 %.
const MOST_SILENT: f64 = 0.24;

/// Arguments by which this binary does nothing but [`generate_one`].
const GENERATE_ONE: [&str; 4] = ["--exact", "generate_one", "--ignored", "--test-threads=1"];

fn judged(orders: &[Order]) -> Vec<Verdict> {
    let judged = |order: &Order| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let set = generate::in_own_process(&GENERATE_ONE, folder.path(), order);
        verdict::verdict(&order.name(), &set, &Options::default())
    };
    let verdicts: Vec<Verdict> = orders.par_iter().map(judged).collect();
    verdicts.iter().for_each(|verdict| println!("{}", verdict.line()));
    verdicts
}

/// Fails where too many are wrong, or too many silent.
fn judge(orders: &[Order], most_wrong: usize, most_silent: usize) {
    let verdicts = judged(orders);
    let missed = verdicts.iter().filter(|one| !one.is_right());
    let (silent, wrong): (Vec<&Verdict>, Vec<&Verdict>) = missed.partition(|one| one.found.is_empty());
    let lines = |of: &[&Verdict]| of.iter().map(|one| one.line()).collect::<Vec<_>>().join("\n");
    assert!(wrong.len() <= most_wrong, "{} of {} wrong:\n{}", wrong.len(), verdicts.len(), lines(&wrong));
    assert!(silent.len() <= most_silent, "{} of {} silent:\n{}", silent.len(), verdicts.len(), lines(&silent));
}

/// The generating process: does nothing unless its variables are set, see [`generate`].
#[test]
#[ignore = "run by the other tests, in a process of its own"]
fn generate_one() {
    generate::as_told();
}

#[test]
fn property_every_effect_of_the_catalogue_can_be_hidden() {
    // The masses of the drawn nominal models are exact, so none of them can be found less accurate than stated.
    let names = CATALOGUE.iter().map(|effect| effect.name());
    let catalogue: BTreeSet<&str> = names.filter(|name| *name != "link_inertia").collect();
    assert_eq!(BTreeSet::from(strengths::EFFECTS), catalogue);
}

#[test]
fn property_a_set_can_be_read_and_is_the_same_again() {
    let folders = [tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder")];
    let order = Order::one("cogging", 1.0, HIDING);
    let [one, other] = [0, 1].map(|i| generate::in_own_process(&GENERATE_ONE, folders[i].path(), &order));
    let model = Model::load(&one.model).expect("the nominal model");
    assert!(model.effects.is_empty() && model.joints.iter().all(|joint| joint.backlash.is_none()));
    let joints = dataset::joints_of(&model);
    let files = |set: &Set| [set.data.as_slice(), std::slice::from_ref(&set.hold_out)].concat();
    for (one, other) in files(&one).iter().zip(&files(&other)) {
        let session = dataset::load(one, &joints).expect("a recording");
        assert!(session.notes.is_empty(), "{:?}", session.notes);
        assert_eq!(session.series.joints.len(), 2);
        assert_eq!(std::fs::read(one).expect("bytes"), std::fs::read(other).expect("bytes"));
    }
}

#[test]
fn recover_the_hidden_effect_by_name() {
    let here = strengths::EFFECTS.iter().filter(|name| !ELSEWHERE.contains(name));
    // These machines have no encoder behind the gear.
    let told = |name: &str| lostmotion::effects::find(name).is_some_and(|effect| !effect.needs_link_encoder());
    let known = here.zip(HIDING..).filter(|(name, _)| told(name));
    let orders: Vec<Order> = known.map(|(name, seed)| Order::one(name, 1.0, seed)).collect();
    let part = |share: f64| (share * orders.len() as f64) as usize;
    judge(&orders, part(MOST_WRONG), part(MOST_SILENT));
}

#[test]
fn property_nothing_is_found_where_nothing_is_hidden() {
    judge(&EMPTY.map(Order::nothing).collect::<Vec<_>>(), 0, 0);
}
