//! Data with an effect hidden by seed, or with none, made by a process of its own; the program sees only the data and the nominal model.
//!
//! Layout of a set: `data/set_<seed>/{model.toml, robot.urdf, staircase.csv, fast_1.csv, fast_2.csv, fast_3.csv}`, and what was hidden in
//! `truth/set_<seed>.json`. Seeds 1 to 999 are for tuning by hand, seeds from 1000 on are for the tests: nothing may be tuned to them.

mod generate;
mod hidden;
mod machine;
mod motion;
mod record;

/// The generating process: does nothing unless its variables are set, see [`generate`].
#[test]
#[ignore = "run by the other tests, in a process of its own"]
fn generate_one() {
    generate::as_told();
}

#[test]
fn property_a_set_can_be_read_and_is_the_same_again() {
    let folders = [tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder")];
    let sets = [0, 1].map(|i| generate::in_own_process(folders[i].path(), 1000, true));
    let model = lostmotion::robot::Model::load(&sets[0].model).expect("the nominal model");
    assert!(model.effects.is_empty() && model.joints.iter().all(|joint| joint.backlash.is_none()));
    let joints = lostmotion::dataset::joints_of(&model);
    for (one, other) in
        sets[0].data.iter().chain([&sets[0].hold_out]).zip(sets[1].data.iter().chain([&sets[1].hold_out]))
    {
        let session = lostmotion::dataset::load(one, &joints).expect("a recording");
        assert!(session.notes.is_empty(), "{:?}", session.notes);
        assert_eq!(session.series.joints.len(), 2);
        assert_eq!(std::fs::read(one).expect("bytes"), std::fs::read(other).expect("bytes"));
    }
}
