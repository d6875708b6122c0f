//! Recordings that nobody would make on purpose: short, coarse, frozen, empty of signal, out of scale. What reads them ends with a result or
//! an error, never with a panic; a session in which nothing moves changes nothing in what the others say.

use std::collections::BTreeMap;
use std::path::Path;

use lostmotion::diagnose::{Options, Verdict, compare, diagnose};
use lostmotion::identify;
use lostmotion::robot::Model;
use lostmotion::timeseries::{Channel, JointSeries, TimeSeries};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const URDF: &str = r#"<robot name="turntable">
  <link name="base"/>
  <link name="table"><inertial><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.03"/></inertial></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="table"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="5" velocity="4"/></joint>
</robot>"#;

/// A gap is known or not, and so is friction.
fn model(backlash: &str, friction: &str) -> Model {
    let text = format!(
        "schema = \"lostmotion/model/1\"\nname = \"turntable\"\nurdf = \"robot.urdf\"\n\
         [joints.turn]\ngear_ratio = 5.0\nrotor_inertia = 0.0008\ngear_stiffness = 3000.0\ngear_damping = 2.0\n{backlash}\
         [joints.turn.motor]\ntorque_constant = 0.023\n{friction}"
    );
    Model::from_texts(&text, URDF, Path::new("model.toml")).expect("a good model")
}

fn models() -> [Model; 3] {
    let friction = "[joints.turn.friction]\ncoulomb = 0.3\nviscous = 0.4\n";
    [model("", ""), model("backlash = 0.008\n", friction), model("backlash = 0.0\n", friction)]
}

fn session(name: &str, interval: f64, channels: [(Channel, Vec<f64>); 2]) -> TimeSeries {
    let time = (0..channels[0].1.len()).map(|k| k as f64 * interval).collect();
    let joint = JointSeries {
        name: "turn".to_owned(),
        channels: BTreeMap::from(channels.map(|(channel, values)| (channel, values.into()))),
    };
    TimeSeries { name: name.to_owned(), time, joints: vec![joint] }
}

/// A sine with the torque of 0.1 kg m² (the model has 0.05, to about 10 %), Coulomb and viscous friction, and noise.
fn ordinary(name: &str, rng: &mut ChaCha8Rng, samples: usize) -> TimeSeries {
    let (interval, omega) = (0.002, rng.random_range(1.0..3.0));
    let t = |k: usize| k as f64 * interval;
    let position = (0..samples).map(|k| (omega * t(k)).sin()).collect();
    let torque = (0..samples).map(|k| {
        let (v, a) = (omega * (omega * t(k)).cos(), -omega * omega * (omega * t(k)).sin());
        0.1 * a + 0.3 * v.signum() + 0.4 * v + 0.02 * rng.random_range(-1.0..1.0)
    });
    session(name, interval, [(Channel::Position, position), (Channel::Torque, torque.collect())])
}

fn odd(name: &str, rng: &mut ChaCha8Rng) -> TimeSeries {
    let samples = [2, 3, 5, 17, 60, 400, 3000][rng.random_range(0..7)];
    let interval = [1e-5, 0.001, 0.02, 0.1, 1.0, 3600.0][rng.random_range(0..6)];
    let signal = |kind: usize, scale: f64, rng: &mut ChaCha8Rng| -> Vec<f64> {
        let mut walk = 0.0;
        let value = |k: usize| match kind {
            0 => 0.0,
            1 => scale,
            2 => scale * k as f64 * interval,
            3 => scale * (0.05 * k as f64).sin(),
            4 => scale * f64::from(u8::from(k > samples / 2)),
            5 => scale * rng.random_range(-1.0..1.0),
            _ => {
                walk += scale * rng.random_range(-1.0..1.0);
                walk
            }
        };
        (0..samples).map(value).collect()
    };
    let (kinds, exponents) = ([rng.random_range(0..7), rng.random_range(0..7)], [-9..3, -9..9]);
    let scales = exponents.map(|range| 10_f64.powi(rng.random_range(range)));
    let torque_channel = if rng.random() { Channel::Torque } else { Channel::Current };
    let position = signal(kinds[0], scales[0], rng);
    let torque = signal(kinds[1], scales[1], rng);
    session(name, interval, [(Channel::Position, position), (torque_channel, torque)])
}

#[test]
#[ignore = "long: .ci/long carries it out"]
fn property_no_recording_makes_a_diagnosis_or_an_identification_panic() {
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    let (models, options) = (models(), Options::default());
    let (mut diagnosed, mut refused) = (0, 0);
    for round in 0..60 {
        let model = &models[round % 3];
        let strange = odd("odd", &mut rng);
        let company = [ordinary("one", &mut rng, 3000), ordinary("two", &mut rng, 3000)];
        let (good, bad) = (&company[..1], std::slice::from_ref(&strange));
        // Alone, beside good ones, held out, and as what a machine was or is.
        let outcomes = match round / 3 % 4 {
            0 => vec![diagnose(model, bad, &[], &options, &mut |_, _| {})],
            1 => {
                let both = [good, bad].concat();
                vec![diagnose(model, &both, &company[1..], &options, &mut |_, _| {})]
            }
            2 => vec![diagnose(model, &company, bad, &options, &mut |_, _| {})],
            _ => {
                let ways = [(good, bad), (bad, good)];
                ways.map(|(then, now)| compare(model, then, now, &[], &options, &mut |_, _| {})).into()
            }
        };
        for outcome in outcomes {
            match outcome {
                Ok(found) => {
                    diagnosed += 1;
                    let sane = |one: &lostmotion::diagnose::FoundEffect| (0.0..=1.0).contains(&one.probability);
                    assert!(found.effects.iter().all(sane), "round {round}: {:?}", found.effects);
                }
                Err(error) => {
                    refused += 1;
                    assert!(!error.to_string().is_empty(), "round {round}");
                }
            }
        }
        identify::identify(model, bad, &identify::Options::default()).ok();
    }
    // Both ways are taken: a test of errors alone, or of good data alone, would say little.
    assert!(diagnosed > 10 && refused > 10, "{diagnosed} diagnosed, {refused} refused");
}

#[test]
fn property_a_session_in_which_nothing_moves_changes_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(42);
    let train = [ordinary("one", &mut rng, 6000), ordinary("two", &mut rng, 6000)];
    let held_out = [ordinary("three", &mut rng, 6000)];
    let still = session("still", 0.002, [(Channel::Position, vec![0.3; 3000]), (Channel::Torque, vec![0.01; 3000])]);
    let [model, ..] = models();
    let with = [train[0].clone(), still, train[1].clone()];
    let diagnosed = |train: &[TimeSeries]| {
        diagnose(&model, train, &held_out, &Options::default(), &mut |_, _| {}).expect("a diagnosis")
    };
    let (without, with) = (diagnosed(&train), diagnosed(&with));
    assert_eq!(without.verdict, with.verdict);
    let names = |found: &lostmotion::diagnose::Diagnosis| -> Vec<String> {
        found.effects.iter().map(|one| one.effect.clone()).collect()
    };
    assert_eq!(names(&without), names(&with));
    // The inertia is larger than the file says: that there is something to be found is what makes the first two lines a test.
    assert_ne!(without.verdict, Verdict::NothingFound);
}
