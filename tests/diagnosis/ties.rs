//! Candidates that explain a change equally well: the names decide, not the order in which they were given.

use std::collections::BTreeMap;

use crate::rigid_arm::{arm, record};
use lostmotion::diagnose::{Diagnosis, Options, compare};
use lostmotion::effects::{
    About, Action, Catalogue, Diagnosable, Effect, JointAction, JointState, Kind, Motion, ParameterSpec, Parameters,
    Scope,
};
use lostmotion::error::Result;
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;

/// A law of torque against velocity [N·m of N·m, rad/s].
type Law = fn(f64) -> f64;

/// An effect with a law that another effect has too.
struct Twin {
    about: &'static About,
    law: Law,
}

const PARAMETERS: &[ParameterSpec] = &[ParameterSpec::new("most", "M", "N·m", "factor of the torque").at_least(0.0)];

const fn about(name: &'static str) -> About {
    About {
        name,
        summary: "Brakes as its twin does.",
        equation: "τ = −M f(v)",
        kind: Kind::Physics,
        scope: Scope::Joint,
        parameters: PARAMETERS,
        signature: "the same as that of its twin",
        look_alikes: &[],
        separate_by: "nothing",
        reference: "none",
    }
}

/// Torque that rises up to 0.5 rad/s, and falls beyond it.
fn hump(velocity: f64) -> f64 {
    let x = velocity / 0.5;
    2.0 * x / (1.0 + x * x)
}

/// Viscous friction, as the quantity `viscous` of the baseline has it.
fn viscous(velocity: f64) -> f64 {
    velocity
}

static FIRST: Twin = Twin { about: &about("brake_a"), law: hump };
static SECOND: Twin = Twin { about: &about("brake_b"), law: hump };
static BEFORE_VISCOUS: Twin = Twin { about: &about("damper"), law: viscous };
static BEHIND_VISCOUS: Twin = Twin { about: &about("water"), law: viscous };

struct Brake(f64, Law);

impl JointAction for Brake {
    fn motor_torque(&self, state: &JointState) -> f64 {
        -self.0 * (self.1)(state.motor_velocity)
    }
}

impl Effect for Twin {
    fn about(&self) -> &'static About {
        self.about
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let most = Parameters::check(self.about, model, given)?.get("most");
        Ok(vec![Action::Joint(joint.unwrap_or(0), Box::new(Brake(most, self.law)))])
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for Twin {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        vec![motion.column(joint, |m, row| (self.law)(m.v[row]))]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0]]
    }
}

/// Compares a healthy arm with one whose joint 2 brakes by `most` times a law.
fn compared(most: f64, law: Law, catalogue: Catalogue) -> Diagnosis {
    let now = |joint: usize, _: f64, v: f64| if joint == 1 { -most * law(v) } else { 0.0 };
    let sessions = |name: &str, seed: u64, extra: &dyn Fn(usize, f64, f64) -> f64| -> Vec<TimeSeries> {
        (0..2).map(|k| record(&format!("{name}_{k}"), &arm(true), seed + k, extra)).collect()
    };
    let (healthy, now) = (sessions("then", 4700, &|_, _, _| 0.0), sessions("now", 4750, &now));
    let options = Options { catalogue, backlash: false, ..Options::default() };
    compare(&arm(true), &healthy, &now, &[], &options, &mut |_, _| {}).expect("a comparison")
}

/// Names of the effects and quantities that have changed on joint 2.
fn named(found: &Diagnosis) -> Vec<String> {
    let on_it = |joints: &[String]| joints == ["joint2".to_owned()];
    let effects = found.effects.iter().filter(|one| on_it(&one.joints)).map(|one| one.effect.clone());
    let changes = found.changes.iter().flatten().filter(|one| one.joint == "joint2").map(|one| one.quantity.clone());
    effects.chain(changes).collect()
}

#[test]
fn property_of_two_effects_that_tie_the_name_decides_whatever_their_order() {
    let orders = [[&FIRST, &SECOND], [&SECOND, &FIRST]];
    let [one, other] = orders.map(|order| {
        let catalogue = order.into_iter().fold(Catalogue::empty(), |known, twin| known.with(twin));
        compared(0.1, hump, catalogue)
    });
    assert_eq!(named(&one)[0], "brake_a", "{:?} {:?}", one.effects, one.changes);
    assert_eq!(named(&one), named(&other));
    let total = |found: &Diagnosis| found.effects[0].evidence_nats.to_bits();
    assert_eq!(total(&one), total(&other), "the same effect with the same evidence");
}

#[test]
fn property_of_an_effect_and_a_quantity_that_tie_the_name_decides() {
    // The quantities of friction are listed before the effects of the catalogue.
    for (twin, expected) in [(&BEFORE_VISCOUS, "damper"), (&BEHIND_VISCOUS, "viscous")] {
        let found = compared(0.08, viscous, Catalogue::empty().with(twin));
        assert_eq!(named(&found), [expected], "{:?} {:?}", found.effects, found.changes);
    }
}
