//! Friction of another simulator, smooth through zero velocity, in machines with their sensors and controllers: named first where it shows.

use crate::drawn::Drawn;
use crate::hidden::{Arm, Field, Order};
use crate::told;
use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::timeseries::TimeSeries;
use rayon::prelude::*;

fn diagnosed(drawn: &Drawn) -> Diagnosis {
    let sessions: Vec<TimeSeries> = drawn.sessions().collect();
    let (train, hold_out) = sessions.split_at(3);
    let found = diagnose(&drawn.nominal, train, hold_out, &Options::default(), &mut |_, _| {}).expect("a diagnosis");
    println!("hidden {:?}", drawn.entries);
    told::print(&found);
    found
}

/// Machines whose model file gives the friction, so that a free law does not take the lack of it for its own.
#[test]
#[ignore = "long: .ci/long carries it out"]
fn recover_the_velocity_of_regularised_friction() {
    let six = |rough: f64| Some(Field { arm: Arm::SixJoints, rough });
    [(None, 33_200), (None, 33_201), (six(1.0), 33_203)].into_par_iter().for_each(|(field, seed)| {
        let drawn = Drawn::new(&Order { field, ..Order::one("regularised_friction", 1.0, seed) });
        let found = diagnosed(&drawn);
        let first = found.effects.first().expect("something is found");
        assert_eq!(first.effect, "regularised_friction", "{seed}");
        let planted = drawn.entries.iter().find(|entry| entry.joint.as_deref() == Some(first.joints[0].as_str()));
        let velocity = planted.expect("on its joint").parameters["velocity"];
        let measured = &first.parameters["velocity"];
        // One in a hundred estimates lies outside 2.6 standard errors.
        assert!((measured.value - velocity).abs() < 2.6 * measured.std_error, "{seed}: {measured:?} of {velocity}");
    });
}
