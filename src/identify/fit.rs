//! Both friction laws fitted to the measurement points of a joint.

use super::law;
use super::least_squares::{Fit, Search, levenberg_marquardt};
use super::lines::{self, SpeedPoint};
use super::points::Point;
use super::result::LawKind;
use crate::gearhead::{Direction, FrictionLaw, Lines};

/// A law with its coefficients and what their errors are made of.
#[derive(Debug, Clone)]
pub struct LawFit {
    /// Which law.
    pub kind: LawKind,
    /// The coefficients in the order of [`law`].
    pub fit: Fit,
}

/// Factors on the Stribeck velocity that the exponential fit is started from: its sum of squares can have more than one valley.
const STARTS: [f64; 4] = [1.0, 0.5, 2.0, 4.0];

/// The two lines of each direction by equations 12 to 14, the start of everything else: every pairing of the best splits.
pub fn first_lines(points: &[Point]) -> Vec<[Lines; 2]> {
    let of = |direction: Direction| {
        let side: Vec<SpeedPoint> =
            points.iter().filter(|point| point.direction() == direction).map(Point::of_speed).collect();
        let found = lines::fit(&side);
        if found.is_empty() { lines::without_fall(&side).into_iter().collect() } else { found }
    };
    let (forward, backward) = (of(Direction::Positive), of(Direction::Negative));
    forward.iter().flat_map(|&one| backward.iter().map(move |&other| [one, other])).collect()
}

/// The starts of a law's fit.
fn starts(kind: LawKind, lines: &[[Lines; 2]]) -> Vec<Vec<f64>> {
    match kind {
        LawKind::TwoLines => {
            lines.iter().map(|lines| law::coefficients(&FrictionLaw::TwoLines(*lines)).1.to_vec()).collect()
        }
        LawKind::Exponential => lines
            .first()
            .into_iter()
            .flat_map(|lines| STARTS.iter().map(|factor| exponential_start(lines, *factor)))
            .collect(),
    }
}

/// Equation 6 with the lines as tangents, its Stribeck velocity changed by a factor.
fn exponential_start(lines: &[Lines; 2], factor: f64) -> Vec<f64> {
    let start = lines.map(|one| {
        let mut one = law::exponential_of_lines(&one);
        one.stribeck_velocity *= factor;
        one.breakaway = one.breakaway.max(0.1 * one.coulomb.abs());
        one.coulomb = one.coulomb.max(0.1 * one.breakaway);
        one
    });
    law::coefficients(&FrictionLaw::Exponential(start)).1.to_vec()
}

/// Best fit of a law to the points, equation 11 on averages.
pub fn to_points(kind: LawKind, points: &[Point], lines: &[[Lines; 2]]) -> Option<LawFit> {
    let fastest = points.iter().fold(0.0_f64, |m, point| m.max(point.velocity.abs()));
    let residuals = |theta: &[f64]| {
        let law = law::of(kind, theta)?;
        Some(points.iter().map(|point| residual(&law, theta[law::CENTRIFUGAL], point)).collect())
    };
    starts(kind, lines)
        .iter()
        .filter_map(|start| {
            let step = law::steps(kind, start, fastest);
            let search = Search { step: &step, part: 1e-3, iterations: 60, tolerance: 1e-9 };
            levenberg_marquardt(start, search, residuals)
        })
        .min_by(|a, b| a.chi_squared.total_cmp(&b.chi_squared))
        .map(|fit| LawFit { kind, fit })
}

/// Residual of equation 11 at a point in standard errors.
fn residual(law: &FrictionLaw, centrifugal: f64, point: &Point) -> f64 {
    (law.kinetic(point.velocity) + centrifugal * point.velocity * point.velocity - point.friction) / point.std_error
}
