//! Fits both laws to the torque balance of the reconstructed motion: equation 11 is averaged over the motion, not evaluated at its average.
//!
//! The motion of every window is reconstructed under the law found so far. This gives the constant torque that the law lacks there.
//! On the same motion the mean friction of any other law is known without a new reconstruction. So the next law is fitted to this
//! motion, and the motion is then reconstructed again:
//!
//! ```text
//!   F_w = ⟨F(v)⟩ − lacking_w          next law: min Σ ((⟨F'(v)⟩ − F_w)/σ_w)²          v: velocity along the motion
//! ```
//! The encoder's edges determine the motion except between them, so a few rounds lead to a law that lacks nothing.
//! The standard error of a window is the filter's own, enlarged if the window is an outlier among all windows.

use std::ops::Range;

use rayon::prelude::*;

use super::fit::{self, LawFit, Observation};
use super::law::{self, CENTRIFUGAL};
use super::motion::{Lack, PARTS, Track};
use super::points::Point;
use super::result::LawKind;
use super::statistics::{median, typical};
use crate::gearhead::{Direction, FrictionLaw};

/// Number of consecutive fits, each to the motion under the law before it.
const ROUNDS: usize = 6;
/// Residual, in robust standard deviations of all residuals, beyond which a window's weight falls (P. J. Huber 1964).
const HUBER: f64 = 2.0;
/// Deviations from the median, in robust standard deviations, beyond which a part is left out.
const OUTLIER: f64 = 6.0;
/// Fewest parts that are used of a window. If fewer agree, all parts are used, and their scatter enlarges the standard error.
const FEWEST_PARTS: usize = 6;

/// The windows of a joint.
pub struct Balance {
    windows: Vec<Window>,
}

/// One window.
struct Window {
    track: Track,
    direction: Direction,
    /// Lower bound of its standard error [N·m or N]: the torque noise alone.
    floor: f64,
}

/// A law and the motion under it.
#[derive(Debug, Clone)]
pub struct Balanced {
    /// The law.
    pub law: LawFit,
    /// `Σ |r|`, every window weighted by its sensor noise alone: two laws are compared by this figure, whatever a single window does.
    pub misfit: f64,
    /// The friction of every window.
    friction: Vec<Observation>,
}

impl Balance {
    /// The balance of these windows; `points` and `tracks` in the same order.
    pub fn new(points: &[Point], tracks: Vec<Track>) -> Self {
        let window = |(point, track): (&Point, Track)| Window {
            direction: point.direction(),
            floor: track.mean_torque_error(),
            track,
        };
        Self { windows: points.iter().zip(tracks).map(window).collect() }
    }

    /// The law that balances, from a first guess at friction. `C_ii` is held at zero: the motion of a single joint of a chain of rigid
    /// bodies has none. `None` if a fit fails.
    pub fn refine(&self, kind: LawKind, guess: &FrictionLaw) -> Option<Balanced> {
        // Under a law that is still far off, good windows look like outliers. So the first fit gives full weight to all windows.
        let mut law = fit::to(kind, &self.motion_under(guess, 0.0, f64::INFINITY).friction, false)?;
        for _ in 1..ROUNDS {
            law = fit::to(kind, &self.under(law)?.friction, false)?;
        }
        self.under(law)
    }

    /// The same law fitted with `C_ii` among its unknowns, as in equation 12.
    pub fn with_centrifugal(&self, found: &Balanced) -> Option<LawFit> {
        fit::to(found.law.kind, &found.friction, true)
    }

    /// The motion under a law that was fitted.
    pub fn under(&self, law: LawFit) -> Option<Balanced> {
        let friction = law::of(law.kind, &law.fit.parameters)?;
        let Motion { friction, misfit } = self.motion_under(&friction, law.fit.parameters[CENTRIFUGAL], HUBER);
        Some(Balanced { law, misfit, friction })
    }

    /// The motion under a law; windows that stand out by more than `huber` lose weight.
    fn motion_under(&self, law: &FrictionLaw, centrifugal: f64, huber: f64) -> Motion {
        let lacks: Vec<Lack> = self.windows.par_iter().map(|window| window.lack(law, centrifugal)).collect();
        let ratios: Vec<f64> = lacks.iter().map(|lack| (lack.torque / lack.std_error).abs()).collect();
        let scale = typical(ratios.iter().copied());
        let misfit = lacks.iter().zip(&self.windows).map(|(lack, window)| (lack.torque / window.floor).abs()).sum();
        let observation = |((lack, window), ratio): ((Lack, &Window), f64)| {
            let std_error = lack.std_error * (ratio / (huber * scale)).clamp(1.0, 1e3);
            let mut one =
                Observation { direction: window.direction, velocities: lack.velocities, friction: 0.0, std_error };
            one.friction = one.average(|v| law.kinetic(v) + centrifugal * v * v) - lack.torque;
            one
        };
        let friction = lacks.into_iter().zip(&self.windows).zip(ratios).map(observation).collect();
        Motion { friction, misfit }
    }
}

/// Result of reconstructing the motion under a law.
struct Motion {
    friction: Vec<Observation>,
    misfit: f64,
}

impl Balanced {
    /// Sets the friction of the points to that of the balance: the law at the window's velocity minus what it lacks there.
    pub fn correct(&self, points: &mut [Point]) {
        let Some(law) = law::of(self.law.kind, &self.law.fit.parameters) else { return };
        for (point, one) in points.iter_mut().zip(&self.friction) {
            let lacking = one.average(|v| law.kinetic(v)) - one.friction;
            point.friction = law.kinetic(point.velocity) - lacking;
            point.std_error = one.std_error;
        }
    }
}

impl Window {
    /// What a law lacks over the parts in which the reconstruction is valid: the longest run of consecutive parts that agree with their
    /// median. Where a rotor has lost contact with its link, above all at a reversal, the momentum that the link brings back is not
    /// known, and such parts are clear outliers. The error reaches beyond the part's border, so its neighbour is left out as well.
    fn lack(&self, law: &FrictionLaw, centrifugal: f64) -> Lack {
        let lacking = self.track.lacking(law, centrifugal);
        let middle = median(lacking.to_vec());
        let spread = typical(lacking.iter().map(|part| part - middle));
        let limit = OUTLIER * spread.max(self.floor * (PARTS as f64).sqrt());
        let run = longest_run(|part| (lacking[part] - middle).abs() <= limit);
        let parts = run.start + usize::from(run.start > 0)..run.end.saturating_sub(usize::from(run.end < PARTS));
        let parts = if parts.len() >= FEWEST_PARTS { parts } else { 0..PARTS };
        self.track.lacking_over(&parts, law, centrifugal)
    }
}

/// The longest run of parts that agree.
fn longest_run(agrees: impl Fn(usize) -> bool) -> Range<usize> {
    let mut best = 0..0;
    let mut start = 0;
    for part in 0..=PARTS {
        if part == PARTS || !agrees(part) {
            if part - start > best.len() {
                best = start..part;
            }
            start = part + 1;
        }
    }
    best
}
