//! Nominal models that are off, as a vendor's URDF is.

use lostmotion::robot::{Accuracy, Model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// [1] A stiffness never falls below this share of its nominal value, as no other value of a model does.
const LEAST_FACTOR: f64 = 0.1;

/// The model of a machine with every nominal value off by `factor` standard deviations of the default accuracy, all of them together. At 1:
/// masses by 10 %, centres by 5 mm, inertias by 15 %, rotors by 10 %, torque constants by 5 %, stiffness by 30 %. The model file states the
/// default accuracy whatever the factor, since a user does not know how good a model is; a model that is exact says so.
pub fn off(machine: &Model, seed: u64, factor: f64) -> Model {
    if factor == 0.0 {
        return Model { accuracy: Accuracy::EXACT, ..machine.clone() };
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || factor * Distribution::<f64>::sample(&StandardNormal, &mut rng);
    let count = 10 * machine.robot.bodies.len() + 2 * machine.joints.len();
    let deviations: Vec<f64> = (0..count).map(|_| normal()).collect();
    let mut off = Model { accuracy: Accuracy::default(), ..machine.clone() }.deviating(&deviations);
    let share = off.accuracy.stiffness;
    for joint in &mut off.joints {
        let factor = (1.0 + share * normal()).max(LEAST_FACTOR);
        joint.gear_stiffness = joint.gear_stiffness.map(|stiffness| stiffness * factor);
    }
    off
}
