//! The paper's experiment recorded at even and at uneven times: the same machine in the same loop at 1 kHz, its logger late or early by up
//! to 0.3 of its interval, and silent for a while.

use std::path::Path;

use lostmotion::control::Target;
use lostmotion::dataset::Session;
use lostmotion::effects::Reading;
use lostmotion::identify::{Identification, JointIdentification, Options, identify};
use lostmotion::plant::{Options as PlantOptions, Plant};
use lostmotion::replay;
use lostmotion::robot::Model;
use lostmotion::scenario::{Regulator, Scenario};
use lostmotion::timeseries::{Channel, JointSeries, TimeSeries};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// [1] Largest deviation of a sample from its place, as a share of the interval.
const JITTER: f64 = 0.3;
/// [s] A pause of the logger in every session.
const PAUSE: std::ops::Range<f64> = 60.0..60.7;
/// Seeds that no constant was chosen on.
const SEEDS: std::ops::Range<u64> = 5001..5004;

fn scenario() -> Scenario {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/01_identify_scara/scenario.toml");
    Scenario::load(&file, &[]).expect("the paper's experiment")
}

/// The machine that the scenario simulates.
fn machine() -> Model {
    Model::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/scara/model.toml")).expect("the paper's machine")
}

/// The columns of a log.
struct Log {
    time: Vec<f64>,
    joints: Vec<JointSeries>,
}

impl Log {
    fn push(&mut self, time: f64, readings: &[Reading], targets: &[Target], commands: &[f64]) {
        self.time.push(time);
        for (i, joint) in self.joints.iter_mut().enumerate() {
            for (channel, value) in [
                (Channel::Position, readings[i].position),
                (Channel::Velocity, readings[i].velocity),
                (Channel::Current, readings[i].current),
                (Channel::ReferenceVelocity, targets[i].velocity),
                (Channel::CommandCurrent, commands[i]),
            ] {
                joint.channels.entry(channel).or_default().push(value);
            }
        }
    }
}

/// The sessions of the scenario; `uneven`: as a logger with jitter and a pause writes them, its times known.
fn recorded(scenario: &Scenario, seed: u64, uneven: bool) -> Vec<TimeSeries> {
    let period = scenario.control_period;
    let session = |(number, session): (usize, &lostmotion::scenario::Session)| {
        let seed = seed.wrapping_add((number as u64) << 32);
        let options = PlantOptions { seed, ..scenario.options.clone() };
        let mut plant = Plant::new(&machine(), &options).expect("a machine");
        plant.place(&session.profile.start());
        let mut regulator = Regulator::new(&scenario.model, &scenario.controller, period);
        let mut targets = vec![Target::default(); scenario.model.joints.len()];
        let names = scenario.model.joints.iter().map(|joint| joint.name.clone());
        let joints = names.map(|name| JointSeries { name, ..JointSeries::default() }).collect();
        let mut log = Log { time: Vec::new(), joints };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for tick in 0..(session.duration / period) as usize {
            let start = tick as f64 * period;
            session.profile.sample(start, &mut targets);
            let readings = plant.read().to_vec();
            let commands = regulator.command(&readings, &targets).to_vec();
            if uneven {
                // One sample in each period of control, 0.3 of it before or after its middle.
                let late = (0.5 + JITTER * rng.random_range(-1.0..1.0)) * period;
                plant.advance(&commands, late).expect("a motion");
                if !PAUSE.contains(&start) {
                    log.push(start + late, plant.read(), &targets, &commands);
                }
                plant.advance(&commands, period - late).expect("a motion");
            } else {
                log.push(start, &readings, &targets, &commands);
                plant.advance(&commands, period).expect("a motion");
            }
        }
        TimeSeries { name: session.name.clone(), time: log.time, joints: log.joints }
    };
    scenario.sessions.par_iter().enumerate().map(session).collect()
}

/// Largest error of a figure over all runs, joints and directions [%].
fn worst(runs: &[Identification], of: impl Fn(&JointIdentification) -> Vec<f64>) -> f64 {
    runs.iter().flat_map(|run| &run.joints).flat_map(of).fold(0.0, |worst: f64, error| worst.max(error.abs()))
}

#[test]
fn recover_friction_and_gap_at_uneven_times() {
    let scenario = scenario();
    let runs: Vec<Identification> = SEEDS
        .into_par_iter()
        .map(|seed| {
            let mut found = identify(&scenario.model, &recorded(&scenario, seed, true), &Options::default()).unwrap();
            scenario.truth.compare(&mut found);
            found
        })
        .collect();
    assert!(runs.iter().all(|run| run.joints.len() == 2));
    let law = |of: fn(&lostmotion::identify::ExponentialEstimate) -> f64| {
        worst(&runs, |joint| joint.friction.exponential.each().map(of).to_vec())
    };
    let figures = [
        law(|law| law.curve_error_percent.unwrap()),
        law(|law| law.coulomb.error_percent.unwrap()),
        law(|law| law.viscous.error_percent.unwrap()),
        law(|law| law.breakaway.error_percent.unwrap()),
        law(|law| law.stribeck_velocity.error_percent.unwrap()),
        worst(&runs, |joint| {
            vec![
                joint
                    .backlash
                    .as_ref()
                    .unwrap_or_else(|| panic!("{}: {:?}", joint.joint, joint.notes))
                    .best
                    .mean
                    .error_percent
                    .unwrap(),
            ]
        }),
    ];
    println!("worst [%]: curve, F_C, F_V, F_S, v_S, gap: {figures:.3?}");
    // What `accuracy` and `identify` ask of even recordings.
    for (figure, most) in figures.iter().zip([0.10, 1.0, 2.0, 0.6, 2.5, 6.0]) {
        assert!(*figure <= most, "{figures:?}");
    }
}

/// The true machine under the recorded commands: the errors are those of the recording.
#[test]
#[ignore = "long: .ci/long carries it out"]
fn property_a_replay_at_uneven_times_is_as_good() {
    /// [1] Runs of one machine with other noise differ by 3 % in these figures.
    const GROWTH: f64 = 1.1;
    let scenario = scenario();
    // Slow enough to be stable for a rotor alone in its gap, whatever the sampling: k_v T/J_r = 0.3.
    let options = replay::Options { bandwidth: 0.3, ..replay::Options::default() };
    let errors = |seed: u64, uneven: bool| {
        let series = recorded(&scenario, seed, uneven).remove(0);
        // Before the pause.
        let series = series.part(0..55_000);
        let controllers = vec![None; series.joints.len()];
        let session = Session { series, notes: Vec::new(), source: "recorded".into(), controllers };
        let found = replay::replay(&machine(), &session, &options).expect("a replay");
        found.errors.into_iter().filter(|error| error.joint == "joint1").collect::<Vec<_>>()
    };
    for seed in SEEDS {
        for (even, uneven) in errors(seed, false).iter().zip(&errors(seed, true)) {
            println!("{:?}: {:.3e} {}, uneven {:.3e}", even.quantity, even.rms, even.unit, uneven.rms);
            assert!(uneven.rms <= even.rms * GROWTH, "{even:?} {uneven:?}");
        }
    }
}
