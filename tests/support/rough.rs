//! Nominal models that are off, as a vendor's URDF is.

use lostmotion::robot::{Accuracy, Model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The model of a machine with every nominal value off by one standard deviation of the default accuracy: masses by 10 %, centres by
/// 5 mm, inertias by 15 %, rotors by 10 %, torque constants by 5 %.
pub fn rough(machine: &Model, seed: u64) -> Model {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let count = 10 * machine.robot.bodies.len() + 2 * machine.joints.len();
    let deviations: Vec<f64> = (0..count).map(|_| StandardNormal.sample(&mut rng)).collect();
    let rough = Model { accuracy: Accuracy::default(), ..machine.clone() }.deviating(&deviations);
    for (new, old) in rough.robot.bodies.iter().zip(&machine.robot.bodies) {
        println!("{}: {:.3} kg in the model, {:.3} kg in the machine", new.name, new.inertia.mass, old.inertia.mass);
    }
    rough
}
