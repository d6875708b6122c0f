//! An effect of another crate: written here, simulated and named by the program as if it were one of its own.

#[path = "support/machines.rs"]
mod machines;

use std::collections::BTreeMap;

use lostmotion::diagnose::{self, diagnose};
use lostmotion::drive::{CurrentSensor, Sensing};
use lostmotion::effects::{
    About, Action, Catalogue, Diagnosable, Effect, JointAction, JointState, Kind, Motion, ParameterSpec, Parameters,
    Scope,
};
use lostmotion::error::{Error, Result};
use lostmotion::plant::{Options, Plant};
use lostmotion::robot::{EffectEntry, JointModel, Model};
use lostmotion::timeseries::{Channel, JointSeries, Samples, TimeSeries};
use machines::*;

static ABOUT: About = About {
    name: "eddy_brake",
    summary: "A disc between magnets brakes up to a speed, and less beyond it.",
    equation: "τ = −2 M x/(1 + x²), x = v/v_c, v_c = 0.5 rad/s",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[ParameterSpec::new("most", "M", "N·m", "largest torque").at_least(0.0)],
    signature: "friction that has a hump at a speed",
    look_alikes: &["stribeck"],
    separate_by: "several speeds around the hump",
    reference: "W. R. Smythe (1942), On eddy currents in a rotating disk",
};

struct EddyBrake;

struct Brake(f64);

/// Torque against velocity, 1 at the speed at which it brakes most.
fn hump(velocity: f64) -> f64 {
    let x = velocity / 0.5;
    2.0 * x / (1.0 + x * x)
}

impl JointAction for Brake {
    fn motor_torque(&self, state: &JointState) -> f64 {
        -self.0 * hump(state.motor_velocity)
    }
}

impl Effect for EddyBrake {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let most = Parameters::check(&ABOUT, model, given)?.get("most");
        Ok(vec![Action::Joint(joint.unwrap_or(0), Box::new(Brake(most)))])
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for EddyBrake {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        vec![motion.column(joint, |m, row| hump(m.v[row]))]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0]]
    }
}

/// `M` [N·m] of the machine.
const MOST: f64 = 0.15;

fn known() -> Catalogue {
    Catalogue::default().with(&EddyBrake)
}

/// One joint with friction and a noisy current sensor; with the brake or without.
fn machine(brake: bool) -> Model {
    let joint = JointModel {
        friction: Some(friction(0.3, 0.3, 1.0, 0.2, 0.0)),
        backlash: Some(0.0),
        current_sensor: Some(CurrentSensor { noise: 0.02, resolution: 0.0, sensing: Sensing::Signed }),
        ..plain_joint("joint1")
    };
    let mut model = model(turntable(0.05), vec![joint]);
    if brake {
        let parameters = BTreeMap::from([("most".to_owned(), MOST)]);
        model.effects.push(EffectEntry {
            effect: "eddy_brake".to_owned(),
            joint: Some("joint1".to_owned()),
            parameters,
        });
    }
    model
}

/// Half a minute along a sum of sines, under a stiff controller.
fn record(brake: bool, seed: u64) -> TimeSeries {
    let options = Options { seed, catalogue: known(), ..Options::default() };
    let mut plant = Plant::new(&machine(brake), &options).expect("the catalogue knows the effect");
    let mut channels: BTreeMap<Channel, Samples> = BTreeMap::new();
    let time: Vec<f64> = (0..30_000).map(|k| f64::from(k) * 1e-3).collect();
    for &t in &time {
        let [mut q, mut v] = [0.0; 2];
        for (f, size) in [(0.11, 0.7), (0.23, 0.4), (0.57, 0.2)] {
            let (sin, cos) = (std::f64::consts::TAU * f * t + seed as f64).sin_cos();
            q += size * sin;
            v += size * std::f64::consts::TAU * f * cos;
        }
        let reading = plant.read()[0];
        for (channel, value) in [(Channel::Position, reading.position), (Channel::Current, reading.current)] {
            channels.entry(channel).or_default().push(value);
        }
        plant.advance(&[60.0 * (q - reading.position) + 3.0 * (v - reading.velocity)], 1e-3).expect("it stays calm");
    }
    TimeSeries { name: format!("{seed}"), time, joints: vec![JointSeries { name: "joint1".to_owned(), channels }] }
}

#[test]
fn recover_an_effect_of_another_crate() {
    let mut nominal = machine(false);
    nominal.joints[0].friction = None;
    for brake in [true, false] {
        let (train, held_out) = ([record(brake, 1), record(brake, 2)], [record(brake, 3)]);
        let options = diagnose::Options { catalogue: known(), backlash: false, ..diagnose::Options::default() };
        let found = diagnose(&nominal, &train, &held_out, &options, &mut |_, _| {}).expect("a diagnosis");
        let names: Vec<&str> = found.effects.iter().map(|effect| effect.effect.as_str()).collect();
        assert_eq!(names, if brake { vec!["eddy_brake"] } else { vec![] });
        let text = lostmotion::report::diagnosis::document("turntable", &found).to_text();
        assert_eq!(text.contains(ABOUT.summary), brake, "{text}");
        if brake {
            let estimate = &found.effects[0].parameters["most"];
            println!("{estimate:?}");
            // Four standard errors are exceeded once in 16,000.
            assert!((estimate.value - MOST).abs() < 4.0 * estimate.std_error, "{estimate:?} instead of {MOST}");
        }
    }
}

#[test]
fn property_only_who_knows_an_effect_can_simulate_it() {
    let catalogue = known();
    assert_eq!(catalogue.iter().count(), Catalogue::default().iter().count() + 1);
    assert_ne!(catalogue, Catalogue::default());
    match Plant::new(&machine(true), &Options::default()) {
        Err(Error::Input(error)) => assert_eq!(error.value, "eddy_brake"),
        _ => panic!("it was not told of that effect"),
    }
}
