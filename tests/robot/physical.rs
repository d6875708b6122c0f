//! The nearest inertia that a rigid body can have.

use lostmotion::robot::Inertia;
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;

use super::support::random;

/// `Σ = ½ tr(I) E − I`
fn second_moment(tensor: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * (0.5 * tensor.trace()) - tensor
}

/// A tensor of this second moment, `I = tr(Σ) E − Σ`.
fn tensor(sigma: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * sigma.trace() - sigma
}

fn symmetric(rng: &mut impl RngExt) -> Matrix3<f64> {
    let a = Matrix3::from_fn(|_, _| rng.random_range(-1.0..1.0));
    (a + a.transpose()) * 0.5
}

fn with(tensor: Matrix3<f64>) -> Inertia {
    Inertia { mass: 1.3, com: Vector3::new(0.1, -0.2, 0.3), tensor }
}

#[test]
fn property_a_body_that_can_exist_is_left_to_the_last_bit() {
    let mut rng = random(5);
    for _ in 0..200 {
        // Second moments of bodies: A Aᵀ, of full rank and of a flat body.
        let a = Matrix3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let flat = Matrix3::from_fn(|row, column| if row == 2 { 0.0 } else { a[(row, column)] });
        for a in [a, flat] {
            let body = with(tensor(&(a * a.transpose())));
            assert!(body.fault().is_none());
            assert_eq!(body.physical(), body);
        }
    }
    assert_eq!(Inertia::zero().physical(), Inertia::zero());
}

#[test]
fn property_any_tensor_becomes_one_that_a_body_can_have() {
    let mut rng = random(6);
    for _ in 0..500 {
        let given = with(symmetric(&mut rng));
        let found = given.physical();
        assert!(found.fault().is_none(), "{given:?} → {:?}", found.fault());
        assert_eq!((found.mass, found.com), (given.mass, given.com));
        // What is physical stays.
        let again = found.physical();
        assert!((again.tensor - found.tensor).amax() < 1e-14);
    }
}

#[test]
fn property_no_body_is_nearer_than_the_one_found() {
    let mut rng = random(7);
    for _ in 0..100 {
        let given = with(symmetric(&mut rng));
        let sigma = second_moment(&given.tensor);
        let distance = |other: &Matrix3<f64>| (second_moment(other) - sigma).norm();
        let found = given.physical().tensor;
        // As far away as the negative eigenvalues are large.
        let negative = sigma.symmetric_eigenvalues().map(|value| value.min(0.0)).norm();
        // Rounding of an eigenvalue decomposition of numbers of 1.
        assert!((distance(&found) - negative).abs() < 1e-13, "{} {negative}", distance(&found));
        for size in [0.3, 0.03, 0.003] {
            let root = second_moment(&found).symmetric_eigen();
            let values = root.eigenvalues.map(|value| value.max(0.0).sqrt());
            let a = root.eigenvectors * Matrix3::from_diagonal(&values) + symmetric(&mut rng) * size;
            assert!(distance(&tensor(&(a * a.transpose()))) > negative - 1e-13);
        }
    }
}

#[test]
fn analytic_a_moment_above_the_sum_of_the_others_raises_these_by_half_of_the_excess_each() {
    // Σ = diag(0.05, 0.05, -0.004): the axis along which the body would have a negative extent gets none.
    let given = with(Matrix3::from_diagonal(&Vector3::new(0.046, 0.046, 0.1)));
    let expected = Matrix3::from_diagonal(&Vector3::new(0.05, 0.05, 0.1));
    assert!((given.physical().tensor - expected).amax() < 1e-16);
}
