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
use super::result::LawKind;
use super::statistics::median;
use crate::gearhead::FrictionLaw;

/// Fits in a row, each with the standard errors that the one before it leaves.
const ROUNDS: usize = 3;
/// Residuals, in robust standard deviations of all, beyond which a window's weight falls (P. J. Huber 1964).
const HUBER: f64 = 2.0;
/// Deviations from the median, in robust standard deviations, beyond which a part is left out.
const OUTLIER: f64 = 6.0;
/// Parts that a window needs; with fewer in agreement all are taken, and their scatter tells how little they are worth.
const FEWEST_PARTS: usize = 6;
/// Differences are taken over this part of a coefficient: wide enough to average over the instants at which a rotor sticks or slips.
const DIFFERENCE: f64 = 0.01;

/// The windows of a joint by direction.
pub struct Balance {
    sides: [Vec<Track>; 2],
    fastest: f64,
    /// Smallest standard error that a window is given [N·m or N]: its torque noise alone.
    floors: [Vec<f64>; 2],
}

/// What was last computed for a direction: the coefficients and the residuals of its windows.
type Cache = RefCell<Option<(Vec<f64>, Vec<f64>)>>;

impl Balance {
    /// The balance of these windows; `points` and `tracks` in the same order.
    pub fn new(points: &[Point], tracks: Vec<Track>) -> Self {
        let mut sides = [Vec::new(), Vec::new()];
        let mut floors = [Vec::new(), Vec::new()];
        for (point, track) in points.iter().zip(tracks) {
            floors[point.direction().index()].push(track.mean_torque_error());
            sides[point.direction().index()].push(track);
        }
        let fastest = points.iter().fold(0.0_f64, |m, point| m.max(point.velocity.abs()));
        Self { sides, fastest, floors }
    }

    /// The fit continued from one to averages, `C_ii` held at zero: the motion of a single joint of a chain of rigid bodies has none.
    /// `None` where it leads nowhere.
    pub fn refine(&self, start: &LawFit) -> Option<LawFit> {
        let mut found = start.clone();
        found.fit.parameters[CENTRIFUGAL] = 0.0;
        for round in 0..ROUNDS {
            // A law that is still far off makes good windows stand out: only a fit to all of them may say which do.
            let judged = self.judge(&found, if round == 0 { f64::INFINITY } else { HUBER })?;
            found = self.search(&found, &judged, false)?;
        }
        Some(found)
    }

    /// The fit repeated with `C_ii` among its unknowns, as in equation 12.
    pub fn with_centrifugal(&self, found: &LawFit) -> Option<LawFit> {
        let judged = self.judge(found, HUBER)?;
        self.search(found, &judged, true)
    }

    /// One fit with the windows' standard errors fixed.
    fn search(&self, from: &LawFit, judged: &[Vec<Judged>; 2], free_centrifugal: bool) -> Option<LawFit> {
        let mut step = law::steps(from.kind, &from.fit.parameters, self.fastest);
        if !free_centrifugal {
            step[CENTRIFUGAL] = 0.0;
        }
        let caches: [Cache; 2] = [RefCell::new(None), RefCell::new(None)];
        let residuals = |theta: &[f64]| {
            let mut all = self.residuals(from.kind, theta, 0, &judged[0], &caches[0])?;
            all.extend(self.residuals(from.kind, theta, 1, &judged[1], &caches[1])?);
            Some(all)
        };
        let search = Search { step: &step, part: DIFFERENCE, iterations: 6, tolerance: 1e-3 };
        let fit = levenberg_marquardt(&from.fit.parameters, search, residuals)?;
        Some(LawFit { kind: from.kind, fit })
    }

    /// The points with friction as the balance sees it: the law at the window's velocity less what it lacks there.
    pub fn correct(&self, found: &LawFit, points: &[Point]) -> Option<Vec<Point>> {
        let judged = self.judge(found, HUBER)?;
        let law = law::of(found.kind, &found.fit.parameters)?;
        let mut next = [0, 0];
        let mut corrected = points.to_vec();
        for point in &mut corrected {
            let k = point.direction().index();
            let one = &judged[k][next[k]];
            next[k] += 1;
            point.friction = law.kinetic(point.velocity) - one.lacking;
            point.std_error = one.std_error;
        }
        Some(corrected)
    }

    /// `Σ r²` of a fit, every window weighted by its sensor noise alone: what two laws can be compared by.
    pub fn misfit(&self, found: &LawFit) -> Option<f64> {
        let judged = self.judge(found, HUBER)?;
        let mut sum = 0.0;
        for (one, floor) in judged.iter().flatten().zip(self.floors.iter().flatten()) {
            sum += (one.lacking / floor).powi(2);
        }
        Some(sum)
    }

    /// The usable parts of each window under a law, and the standard error of what it lacks there.
    fn judge(&self, fit: &LawFit, huber: f64) -> Option<[Vec<Judged>; 2]> {
        let law = law::of(fit.kind, &fit.fit.parameters)?;
        let centrifugal = fit.fit.parameters[CENTRIFUGAL];
        let mut judged = [0, 1].map(|k| {
            let tracks = self.sides[k].iter().zip(&self.floors[k]);
            tracks.map(|(track, floor)| Judged::of(track, *floor, &law, centrifugal)).collect::<Vec<_>>()
        });
        let ratio = |one: &Judged| (one.lacking / one.std_error).abs();
        let scale = 1.4826 * median(judged.iter().flatten().map(ratio).collect());
        for one in judged.iter_mut().flatten() {
            one.std_error *= (ratio(one) / (huber * scale)).clamp(1.0, 1e3);
        }
        Some(judged)
    }

    /// Residuals of the windows of a direction; recomputed only where its own coefficients changed.
    fn residuals(&self, kind: LawKind, theta: &[f64], k: usize, judged: &[Judged], cache: &Cache) -> Option<Vec<f64>> {
        let mut own = theta[k * PER_DIRECTION..(k + 1) * PER_DIRECTION].to_vec();
        own.push(theta[CENTRIFUGAL]);
        if let Some((at, values)) = cache.borrow().as_ref()
            && *at == own
        {
            return Some(values.clone());
        }
        let law = law::of(kind, theta)?;
        let centrifugal = theta[CENTRIFUGAL];
        let of = |(track, one): (&Track, &Judged)| track.lacking_over(&one.parts, &law, centrifugal).0 / one.std_error;
        let values: Vec<f64> = self.sides[k].iter().zip(judged).map(of).collect();
        *cache.borrow_mut() = Some((own, values.clone()));
        Some(values)
    }
}

/// The parts of a window in which the reconstruction holds.
#[derive(Debug, Clone)]
struct Judged {
    parts: Range<usize>,
    /// [N·m or N] what the law lacks over these parts.
    lacking: f64,
    /// [N·m or N] its standard error; larger where the window stands out from all others.
    std_error: f64,
}

impl Judged {
    /// The longest run of consecutive parts that agree with their median, and the standard error of its mean. Where a rotor has lost its
    /// link, at a reversal above all, the momentum that the link brings back is not known, and such parts stand out by far.
    fn of(track: &Track, floor: f64, law: &FrictionLaw, centrifugal: f64) -> Self {
        let lacking = track.lacking(law, centrifugal);
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
        let (lacking, std_error) = track.lacking_over(&parts, law, centrifugal);
        Self { parts, lacking, std_error }
    }
}
