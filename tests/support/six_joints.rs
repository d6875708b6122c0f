//! The six-joint arm of the catalogue, as tests move it.

use std::path::Path;

use lostmotion::gearhead::FrictionLaw;
use lostmotion::robot::Model;

/// Its folder.
pub const ROBOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/sixaxis");

/// How a joint moves: middle and half of its range [rad], speed [rad/s], acceleration [rad/s²], and the inertia that its controller is tuned
/// for [kg·m²]. Within limits, around a pose with the arm forwards.
pub const RANGES: [[f64; 5]; 6] = [
    [0.0, 1.2, 1.5, 4.0, 6.0],
    [0.3, 0.6, 1.0, 3.0, 7.0],
    [-0.5, 0.6, 1.2, 4.0, 2.5],
    [0.0, 1.2, 2.0, 8.0, 0.15],
    [0.2, 1.0, 2.0, 8.0, 0.15],
    [0.0, 1.5, 3.0, 12.0, 0.03],
];

/// The arm with friction that is alike in both directions.
pub fn symmetric() -> Model {
    let mut model = Model::load(&Path::new(ROBOT).join("model.toml")).expect("the arm");
    for joint in &mut model.joints {
        let friction = joint.friction.as_mut().expect("friction");
        if let FrictionLaw::Exponential([positive, negative]) = &mut friction.law {
            *negative = *positive;
        }
    }
    model
}
