//! The EMPS carriage, A. Janot, M. Gautier, M. Brunot (2019).

use std::path::PathBuf;

use lostmotion::dataset;
use lostmotion::diagnose::{self, Split, diagnose};
use lostmotion::gearhead::{Exponential, Friction, FrictionLaw};
use lostmotion::likelihood::{Recording, Settings, score};
use lostmotion::replay::{self, Loop, Observable, Options};
use lostmotion::robot::{EffectEntry, Model};
use lostmotion::timeseries::Channel;
use lostmotion::units::JointKind;

use super::{load, root};

fn datasets() -> PathBuf {
    root("robots/emps/datasets")
}

pub fn read_as_published() {
    let axis = [("carriage".to_owned(), JointKind::Prismatic)];
    for (name, force) in [("train", 2.53862809), ("pulses", 2.55322418)] {
        let session = dataset::load(&datasets().join(format!("{name}.toml")), &axis).expect("the recording");
        let (series, carriage) = (&session.series, &session.series.joints[0]);
        assert_eq!(series.len(), 24841);
        // 24.84 s at 1 kHz.
        assert!((series.time[24840] - 24.84).abs() < 1e-5);
        // Its steps scatter by 3.3e-8 s.
        assert!((series.sample_interval() - 1e-3).abs() < 4e-8);
        // First drive voltage of the file, printed with nine digits, times gtau.
        let first = carriage.get(Channel::Torque).expect("force")[0];
        assert!((first - 35.15065188 * force).abs() < 1e-6, "{first}");
        assert_eq!(carriage.channels.len(), 3);
        assert!(session.notes.is_empty(), "{:?}", session.notes);
    }
}

/// A. Janot, M. Gautier, M. Brunot (2019): relative force error on the training session 4.08 % for Coulomb and viscous friction,
/// 3.11 % where they differ by direction. The authors name the asymmetry.
pub fn has_asymmetric_friction_and_a_line_at_one_motor_turn() {
    let model = Model::load(&root("robots/emps/model.toml")).expect("the axis");
    let train = load(&model, &[datasets().join("train.toml")]);
    let held_out = load(&model, &[datasets().join("pulses.toml")]);
    let found =
        diagnose(&model, &train, &held_out, &diagnose::Options::default(), &mut |_, _| {}).expect("a diagnosis");
    let fit = |split| found.fit.iter().find(|fit| fit.split == split).expect("both parts are judged");
    let (train, held_out) = (fit(Split::Train), fit(Split::HeldOut));
    // 4.1 ± 0.2 %: the published figure, with room for another filter.
    assert!((train.before_percent - 4.1).abs() < 0.2, "{train:?}");
    assert!(train.after_percent < 3.0, "{train:?}");
    // On another day, with pulses that the training does not have, the gain has to be there as well: a tenth at least.
    assert!(held_out.after < 0.9 * held_out.before, "{held_out:?}");
    assert_eq!(found.effects[0].effect, "viscous_asymmetry", "{:?}", found.effects);
    let line = found.effects.iter().find(|effect| effect.effect == "cogging").expect("the line is named");
    assert_eq!(line.parameters["order"].value, 1.0, "one period in 2.5 mm, which is a turn of the motor");
    // Fitted by hand with free phases on this session: 1.03 ± 0.05 N.
    assert!((line.parameters["amplitude"].value - 1.0).abs() < 0.15, "{line:?}");
}

/// The EMPS axis with the published symmetric parameters: mass 95.1089 kg, viscous, Coulomb, offset.
fn emps() -> Model {
    let mut model = Model::load(&root("robots/emps/model.toml")).expect("model");
    let side = Exponential { coulomb: 20.3935, breakaway: 20.3935, stribeck_velocity: 1e-3, viscous: 203.5034 };
    model.joints[0].friction = Some(Friction { law: FrictionLaw::Exponential([side, side]), link_share: 0.1 });
    model.joints[0].backlash = Some(0.0);
    let parameters = [("offset".to_owned(), -3.1648 / model.joints[0].torque_per_ampere())].into();
    model.effects.push(EffectEntry { effect: "current_offset".into(), joint: Some("carriage".into()), parameters });
    model
}

pub fn replays_at_least_as_well_as_published() {
    let model = emps();
    let folder = datasets();
    // Relative errors in percent of the published simulation, unfiltered: position, force.
    for (name, published) in [("train", [0.0138, 5.85]), ("pulses", [0.0080, 8.94])] {
        let session = dataset::load(&folder.join(format!("{name}.toml")), &dataset::joints_of(&model)).expect("data");
        let options = Options { cutoff: 1e6, ..Options::default() };
        let replay = replay::replay(&model, &session, &options).expect("replay");
        let relative: Vec<f64> = replay.errors.iter().map(|error| 100.0 * error.relative).collect();
        println!("{name}: position {:.4} %, force {:.2} %; published {published:?}", relative[0], relative[1]);
        assert!(relative[0] < published[0] && relative[1] < published[1], "{relative:?}");
        // Far below the published figure would mean that the force is not simulated but handed through.
        assert!(relative[1] > 2.0, "{relative:?}");
    }
}

pub fn errs_in_open_loop_as_much_as_published() {
    let model = emps();
    // Both sides as they are.
    let options = Options { control: Loop::Open, cutoff: 1e6, ..Options::default() };
    let session = dataset::load(&datasets().join("pulses.toml"), &dataset::joints_of(&model)).expect("data");
    let replay = replay::replay(&model, &session, &options).expect("replay");
    let position = replay.errors.iter().find(|error| error.quantity == Observable::Position).expect("a position").rms;
    println!("pulses in open loop: {:.2} mm; published 9.22 mm", 1e3 * position);
    // The same parameters: the figure is theirs, up to how the last sample's force is held, what the current loop delays, and the gear
    // that they leave out. A tenth of it covers that; a controller left in would make it a thousandth.
    assert!((0.85..1.0).contains(&(position / 9.22e-3)), "{position}");
}

/// Every reading of encoders with counts of 50 nm has a score, by models that miss 40 times the noise of the drive signal, and by one that runs away from the recording.
/// What the regression names raises the score.
pub fn is_scored_reading_by_reading() {
    /// `ln 40`.
    const MISSED: f64 = 3.7;
    let series = load(&emps(), &[datasets().join("train.toml")]).remove(0);
    let mean = |model: &Model, lambda: f64| {
        let window = Recording::new(model, &series).expect("a recording").window(5.0, 10.0);
        let settings = Settings { burn_in: 1.0, ..Settings::default() };
        let score = score(model, &[window], &[lambda], &settings).expect("a score").remove(0);
        assert_eq!(score.readings, [4000]);
        assert!(score.mean().is_finite(), "{}", score.mean());
        score.mean()
    };
    let named = |effect: &str, joint: Option<&str>, parameters: &[(&str, f64)]| EffectEntry {
        effect: effect.to_owned(),
        joint: joint.map(str::to_owned),
        parameters: parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
    };
    let mut late = emps();
    late.effects.push(named("sensor_delay", None, &[("position_delay", 8e-4)]));
    let mut line = late.clone();
    let cogging = [("amplitude", 1.0), ("order", 1.0), ("phase", 2.68)];
    line.effects.push(named("cogging", Some("carriage"), &cogging));
    let means = [&emps(), &late, &line].map(|model| mean(model, MISSED));
    println!("published model, with the delay, and with the screw's line: {means:.3?} nats a reading");
    assert!(means[1] > means[0] && means[2] > means[1], "{means:?}");
    // A motor that is stronger by five orders of magnitude leaves every recorded speed at once: the filter begins anew, and scores to the end.
    let mut runaway = line.clone();
    runaway.joints[0].motor.iter_mut().for_each(|motor| motor.torque_constant *= 1e5);
    assert!(mean(&runaway, -1.5) < 2.0 * means[0]);
}
