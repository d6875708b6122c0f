//! Effects of another crate: written here, simulated and named by the program as if they were its own. One shows in the torque along the
//! motion, the other as a phenomenon that an instrument measures.

#[path = "support/machines.rs"]
mod machines;

use std::collections::BTreeMap;

use lostmotion::diagnose::{self, Diagnosis, Unexplained, diagnose};
use lostmotion::drive::{CurrentSensor, Sensing};
use lostmotion::effects::{
    About, Action, Catalogue, Claim, Diagnosable, DriveAction, Effect, JointAction, JointState, Kind, Motion,
    ParameterSpec, Parameters, Phenomenon, Scope,
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

static CLAMP: About = About {
    name: "gate_clamp",
    summary: "A gate driver swallows short pulses.",
    equation: "i → 0 for |i_cmd| < w",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[ParameterSpec::new("threshold", "w", "A", "command below which no current flows").between(0.0, 10.0)],
    signature: "no current near zero, whatever is commanded",
    look_alikes: &[],
    separate_by: "hold small commands of either sign",
    reference: "J.-W. Choi, S.-K. Sul (1996), Inverter output voltage synthesis using novel dead time compensation",
};

/// It says nothing of torque: it claims what an instrument measures.
struct GateClamp;

struct Clamp(f64);

impl DriveAction for Clamp {
    fn command(&self, command: f64) -> f64 {
        if command.abs() < self.0 { 0.0 } else { command }
    }
}

impl Effect for GateClamp {
    fn about(&self) -> &'static About {
        &CLAMP
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let threshold = Parameters::check(&CLAMP, model, given)?.get("threshold");
        Ok(vec![Action::Drive(joint.unwrap_or(0), Box::new(Clamp(threshold)))])
    }

    fn claims(&self, phenomenon: &Phenomenon) -> Option<Claim> {
        match phenomenon {
            Phenomenon::DeadBand { width } => Some(vec![("threshold", *width)]),
            _ => None,
        }
    }
}

/// `M` [N·m] of the machine.
const MOST: f64 = 0.15;
/// `w` [A] of its drive.
const THRESHOLD: f64 = 0.12;

fn known() -> Catalogue {
    Catalogue::default().without("drive_dead_band").with(&EddyBrake).with(&GateClamp)
}

/// What is in a machine: an effect with its parameter, or nothing.
type Hidden = Option<(&'static About, f64)>;

/// One joint with friction and a noisy current sensor.
fn machine(hidden: Hidden) -> Model {
    let joint = JointModel {
        friction: Some(friction(0.3, 0.3, 1.0, 0.2, 0.0)),
        backlash: Some(0.0),
        current_sensor: Some(CurrentSensor { noise: 0.02, resolution: 0.0, sensing: Sensing::Signed }),
        ..plain_joint("joint1")
    };
    let mut model = model(turntable(0.05), vec![joint]);
    model.effects.extend(hidden.map(|(about, value)| EffectEntry {
        effect: about.name.to_owned(),
        joint: (about.scope == Scope::Joint).then(|| "joint1".to_owned()),
        parameters: BTreeMap::from([(about.parameters[0].name.to_owned(), value)]),
    }));
    model
}

/// Half a minute along a sum of sines, under a stiff controller.
fn record(hidden: Hidden, seed: u64) -> TimeSeries {
    let options = Options { seed, catalogue: known(), ..Options::default() };
    let mut plant = Plant::new(&machine(hidden), &options).expect("the catalogue knows the effect");
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
        let command = 60.0 * (q - reading.position) + 3.0 * (v - reading.velocity);
        let recorded = [
            (Channel::Position, reading.position),
            (Channel::Current, reading.current),
            (Channel::CommandCurrent, command),
        ];
        recorded.into_iter().for_each(|(channel, value)| channels.entry(channel).or_default().push(value));
        plant.advance(&[command], 1e-3).expect("it stays calm");
    }
    TimeSeries { name: format!("{seed}"), time, joints: vec![JointSeries { name: "joint1".to_owned(), channels }] }
}

/// The diagnosis of three sessions.
fn diagnosed(hidden: Hidden, catalogue: Catalogue) -> Diagnosis {
    let mut nominal = machine(None);
    nominal.joints[0].friction = None;
    let (train, held_out) = ([record(hidden, 1), record(hidden, 2)], [record(hidden, 3)]);
    let options = diagnose::Options { catalogue, backlash: false, ..diagnose::Options::default() };
    diagnose(&nominal, &train, &held_out, &options, &mut |_, _| {}).expect("a diagnosis")
}

fn names(found: &Diagnosis) -> Vec<&str> {
    found.effects.iter().map(|effect| effect.effect.as_str()).collect()
}

/// Holds a diagnosis to the one effect that is there, and its parameter.
fn check(found: &Diagnosis, (about, value): (&'static About, f64)) {
    assert_eq!(names(found), [about.name]);
    let text = lostmotion::report::diagnosis::document("turntable", found).to_text();
    assert!(text.contains(about.summary), "{text}");
    let estimate = &found.effects[0].parameters[about.parameters[0].name];
    println!("{estimate:?}");
    // Four standard errors are exceeded once in 16,000.
    assert!((estimate.value - value).abs() < 4.0 * estimate.std_error, "{estimate:?} instead of {value}");
}

#[test]
fn recover_an_effect_of_another_crate_by_its_torque() {
    let hidden = (&ABOUT, MOST);
    check(&diagnosed(Some(hidden), known()), hidden);
}

#[test]
fn recover_an_effect_of_another_crate_by_a_phenomenon() {
    let hidden = (&CLAMP, THRESHOLD);
    check(&diagnosed(Some(hidden), known()), hidden);
}

#[test]
fn property_nothing_is_named_where_nothing_is_hidden() {
    let none: [&str; 0] = [];
    assert_eq!(names(&diagnosed(None, known())), none);
}

#[test]
fn property_a_phenomenon_that_no_effect_claims_is_unexplained() {
    // The machine has the effect; the diagnosis does not know it.
    let found = diagnosed(Some((&CLAMP, THRESHOLD)), known().without("gate_clamp"));
    let none: [&str; 0] = [];
    assert_eq!(names(&found), none);
    let said = |one: &Unexplained| one.pattern.contains("make no current");
    assert!(found.unexplained.iter().any(said), "{:?}", found.unexplained);
}

#[test]
fn property_only_who_knows_an_effect_can_simulate_it() {
    let catalogue = known();
    assert_eq!(catalogue.iter().count(), Catalogue::default().iter().count() + 1, "two are new, one is left out");
    assert_ne!(catalogue, Catalogue::default());
    match Plant::new(&machine(Some((&ABOUT, MOST))), &Options::default()) {
        Err(Error::Input(error)) => assert_eq!(error.value, "eddy_brake"),
        _ => panic!("it was not told of that effect"),
    }
}
