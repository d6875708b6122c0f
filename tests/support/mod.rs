//! What several test files share: random robots.
#![allow(dead_code, reason = "every test file is its own crate and uses its own part")]

use lostmotion::robot::{Body, Inertia, Joint, Limits, Robot, STANDARD_GRAVITY};
use lostmotion::units::JointKind;
use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A generator that gives the same numbers on every machine.
pub fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// `n` numbers from −size to size.
pub fn numbers(rng: &mut ChaCha8Rng, n: usize, size: f64) -> Vec<f64> {
    (0..n).map(|_| rng.random_range(-size..size)).collect()
}

fn vector(rng: &mut ChaCha8Rng, size: f64) -> Vector3<f64> {
    Vector3::from_vec(numbers(rng, 3, size))
}

fn direction(rng: &mut ChaCha8Rng) -> Unit<Vector3<f64>> {
    loop {
        let v = vector(rng, 1.0);
        if (0.2..1.0).contains(&v.norm()) {
            return Unit::new_normalize(v);
        }
    }
}

/// An inertia that a body can have, because a body of eight point masses has it.
fn inertia(rng: &mut ChaCha8Rng) -> Inertia {
    let none = Inertia { mass: 0.0, com: Vector3::zeros(), tensor: Matrix3::zeros() };
    (0..8).fold(none, |body, _| {
        let point = Inertia { mass: rng.random_range(0.05..0.5), com: vector(rng, 0.2), tensor: Matrix3::zeros() };
        body.joined(&point)
    })
}

fn body(rng: &mut ChaCha8Rng, index: usize, parent: Option<usize>) -> Body {
    let kind = if rng.random_bool(0.7) { JointKind::Revolute } else { JointKind::Prismatic };
    let rotation = UnitQuaternion::from_axis_angle(&direction(rng), rng.random_range(-3.0..3.0));
    Body {
        name: format!("link{index}"),
        parent,
        joint: Joint {
            name: format!("joint{index}"),
            kind,
            origin: Isometry3::from_parts(Translation3::from(vector(rng, 0.4)), rotation),
            axis: direction(rng),
            limits: Limits {
                lower: f64::NEG_INFINITY,
                upper: f64::INFINITY,
                effort: f64::INFINITY,
                velocity: f64::INFINITY,
            },
            damping: 0.0,
            friction: 0.0,
        },
        inertia: inertia(rng),
        shapes: Vec::new(),
    }
}

fn robot(name: &str, bodies: Vec<Body>) -> Robot {
    let (base_shapes, unread_shapes) = (Vec::new(), Vec::new());
    Robot {
        name: name.to_owned(),
        gravity: STANDARD_GRAVITY,
        base_shapes,
        unread_shapes,
        drawn: Vec::new(),
        bodies,
        coupling: None,
    }
}

/// A chain of `n` joints, turning and sliding, with axes, frames and inertias in all directions.
pub fn random_chain(rng: &mut ChaCha8Rng, n: usize) -> Robot {
    let bodies = (0..n).map(|i| body(rng, i, i.checked_sub(1))).collect();
    robot("chain", bodies)
}

/// A tree of `n` joints: the parent of each is any earlier body or the base.
pub fn random_tree(rng: &mut ChaCha8Rng, n: usize) -> Robot {
    let mut bodies: Vec<Body> = Vec::new();
    for i in 0..n {
        let parent = rng.random_range(0..=i).checked_sub(1);
        bodies.push(body(rng, i, parent));
    }
    robot("tree", bodies)
}
