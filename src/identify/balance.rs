//! Both laws fitted to the torque balance of the reconstructed motion: equation 11 averaged over the motion instead of at its average.
//!
//! One residual a window, the mean torque that the law lacks, over its standard error. That error is not known before the law is: it is
//! taken from the scatter of the parts of the window under the law found so far, and the fit is repeated with it.

use std::cell::RefCell;
use std::ops::Range;

use super::fit::LawFit;
use super::law::{self, CENTRIFUGAL, PER_DIRECTION};
use super::least_squares::{Search, levenberg_marquardt};
use super::motion::{PARTS, Track};
use super::points::Point;
use super::statistics::{mean, mean_with_error};
use crate::gearhead::Friction;

/// Repetitions with new standard errors.
const REWEIGHTINGS: usize = 3;
/// Deviations from the median, in robust standard deviations, beyond which a part is left out.
const OUTLIER: f64 = 6.0;
/// Parts that a window needs; with fewer in agreement all are taken, and their scatter tells how little they are worth.
const FEWEST_PARTS: usize = 6;
/// Differences are taken over this part of a coefficient: wide enough to average over the instants at which a rotor sticks or slips.
const DIFFERENCE: f64 = 0.01;

/// The windows of a joint and how its friction is shared between rotor and link.
pub struct Balance {
    sides: [Vec<Track>; 2],
    fastest: f64,
    link_share: f64,
    /// Smallest standard error that a window is given [N·m or N]: its torque noise alone.
    floors: [Vec<f64>; 2],
}

/// What was last computed for a direction: the coefficients and the lacking torques of its windows.
type Cache = RefCell<Option<(Vec<f64>, Vec<[f64; PARTS]>)>>;

impl Balance {
    /// The balance of these windows; `points` and `tracks` in the same order.
    pub fn new(points: &[Point], tracks: Vec<Track>, link_share: f64) -> Self {
        let mut sides = [Vec::new(), Vec::new()];
        let mut floors = [Vec::new(), Vec::new()];
        for (point, track) in points.iter().zip(tracks) {
            floors[point.direction().index()].push(track.mean_torque_error());
            sides[point.direction().index()].push(track);
        }
        let fastest = points.iter().fold(0.0_f64, |m, point| m.max(point.velocity.abs()));
        Self { sides, fastest, link_share, floors }
    }

    /// The fit continued from one to averages; `None` where it leads nowhere.
    pub fn refine(&self, start: &LawFit, free_centrifugal: bool) -> Option<LawFit> {
        let mut found = start.clone();
        let caches: [Cache; 2] = [RefCell::new(None), RefCell::new(None)];
        for _ in 0..REWEIGHTINGS {
            let judged = self.judge(&found, &caches)?;
            let mut steps = law::steps(found.kind, &found.fit.parameters, self.fastest);
            if !free_centrifugal {
                steps[CENTRIFUGAL] = 0.0;
                found.fit.parameters[CENTRIFUGAL] = 0.0;
            }
            let residuals = |theta: &[f64]| {
                let mut all = Vec::new();
                for (k, judged) in judged.iter().enumerate() {
                    let lacking = self.lacking(&found, theta, k, &caches[k])?;
                    all.extend(lacking.iter().zip(judged).map(|(parts, one)| one.residual(parts)));
                }
                Some(all)
            };
            let search = Search { step: &steps, part: DIFFERENCE, iterations: 6, tolerance: 1e-3 };
            let fit = levenberg_marquardt(&found.fit.parameters, search, residuals)?;
            found = LawFit { kind: found.kind, fit };
        }
        Some(found)
    }

    /// The usable parts of each window under a law, and the standard error of their mean.
    fn judge(&self, fit: &LawFit, caches: &[Cache; 2]) -> Option<[Vec<Judged>; 2]> {
        let of = |k: usize| -> Option<Vec<Judged>> {
            let lacking = self.lacking(fit, &fit.fit.parameters, k, &caches[k])?;
            Some(lacking.iter().zip(&self.floors[k]).map(|(parts, floor)| Judged::of(parts, *floor)).collect())
        };
        Some([of(0)?, of(1)?])
    }

    /// Lacking torques of the windows of a direction; recomputed only where its own coefficients changed.
    fn lacking(&self, fit: &LawFit, theta: &[f64], k: usize, cache: &Cache) -> Option<Vec<[f64; PARTS]>> {
        let mut own = theta[k * PER_DIRECTION..(k + 1) * PER_DIRECTION].to_vec();
        own.push(theta[CENTRIFUGAL]);
        if let Some((at, values)) = cache.borrow().as_ref()
            && *at == own
        {
            return Some(values.clone());
        }
        let friction = Friction { law: law::of(fit.kind, theta)?, link_share: self.link_share };
        let values: Vec<_> = self.sides[k].iter().map(|track| track.lacking(&friction, theta[CENTRIFUGAL])).collect();
        *cache.borrow_mut() = Some((own, values.clone()));
        Some(values)
    }
}
/// The parts of a window in which the reconstruction holds.
#[derive(Debug, Clone)]
struct Judged {
    parts: Range<usize>,
    std_error: f64,
}

impl Judged {
    /// The longest run of consecutive parts that agree with their median, and the standard error of its mean. Where a rotor has lost its
    /// link, at a reversal above all, the momentum that the link brings back is not known, and such parts stand out by far.
    fn of(lacking: &[f64; PARTS], floor: f64) -> Self {
        let middle = median(lacking.to_vec());
        let spread = 1.4826 * median(lacking.iter().map(|part| (part - middle).abs()).collect());
        let limit = OUTLIER * spread.max(floor * (PARTS as f64).sqrt());
        let agrees = |k: usize| (lacking[k] - middle).abs() <= limit;
        let mut best = 0..0;
        let mut start = 0;
        for k in 0..=PARTS {
            if k == PARTS || !agrees(k) {
                if k - start > best.len() {
                    best = start..k;
                }
                start = k + 1;
            }
        }
        let parts = if best.len() >= FEWEST_PARTS { best } else { 0..PARTS };
        let (_, error) = mean_with_error(&lacking[parts.clone()]);
        let floor = floor * (PARTS as f64 / parts.len() as f64).sqrt();
        Self { parts, std_error: error.max(floor) }
    }

    /// Mean lacking torque in standard errors.
    fn residual(&self, lacking: &[f64; PARTS]) -> f64 {
        mean(&lacking[self.parts.clone()]) / self.std_error
    }
}

/// Median; NaN of nothing.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { f64::NAN } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}
