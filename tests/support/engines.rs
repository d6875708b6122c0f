//! One machine on either engine, each evaluated on its own once an interval: neither carries the other.
#![allow(dead_code)]

use lostmotion::plant::{Engine, Evaluations, Options, Plant};
use lostmotion::robot::Model;

/// The machine on rapier and on the project's own algorithms, its sensors exact.
pub fn both_engines(model: &Model) -> [Plant; 2] {
    let on =
        |engine| Options { engine, evaluations: Evaluations::EveryInterval, ideal_sensors: true, ..Options::default() };
    [Engine::Rapier, Engine::Reduced].map(|engine| Plant::new(model, &on(engine)).unwrap())
}

/// Carries out a test on either.
pub fn on_both_engines(model: &Model, test: impl FnMut(Plant)) {
    both_engines(model).into_iter().for_each(test);
}

/// Requires a value to be where a formula says, within a tolerance; returns its error.
pub fn assert_near(what: &str, found: f64, expected: f64, tolerance: f64) -> f64 {
    let error = (found - expected).abs();
    println!("{what}: {found:.9} instead of {expected:.9}, off by {error:.1e}");
    assert!(error < tolerance, "{what}: {found:e} instead of {expected:e}, off by {error:e}");
    error
}
