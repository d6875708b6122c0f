//! The link's share of friction, which divides the travel of a motor between its flanks into gap and wind-up.
//!
//! After a reversal friction holds the link until the other flank pushes it with more. Until then the gear unwinds, and winds up again:
//!
//! ```text
//!   x = b + s (F₊ + F₋)/k           x: travel of the motor, b: gap, s: link share, F: breakaway, k: stiffness
//!   σ_b = σ_s (F₊ + F₋)/k           error of the gap by that of the share, which all reversals have in common
//! ```
//! The positions tell `x`, the torque while the rotor turns alone tells `s`. The guesses of an ensemble do not: they are corrected by more readings than
//! there are guesses, each correction takes some of the spread of every state by a covariance that is there by chance, and in the end all guesses have about
//! the share that they began with. So shares are held, and each reversal's likelihoods with them are compared.
//! Reference: R. Furrer, T. Bengtsson (2007), Estimation of high-dimensional prior and posterior covariance matrices in Kalman filter variants.

use super::fit::weighted;

/// [1] From one share to the next that is tried.
const STEP: f64 = 0.1;
/// Number of steps to the largest share, one.
const LARGEST: usize = 10;
/// Shares that are tried to either side of the likeliest one.
const AROUND: usize = 2;
/// Fewest reversals that tell a share: the scatter of fewer says nothing.
const FEWEST: usize = 3;

/// `ln L` of each reversal at its likeliest gap, if the share is so many steps.
struct Tried {
    steps: usize,
    likelihoods: Vec<f64>,
}

impl Tried {
    fn total(&self) -> f64 {
        self.likelihoods.iter().sum()
    }
}

/// The share and its standard error. `likelihoods` gives `ln L` of each reversal at its likeliest gap with a share that is held; the search begins near one.
/// `temper` is the weight of `ln L` within one reversal. `None` where too few reversals tell it.
pub(super) fn settle(near: f64, temper: f64, mut likelihoods: impl FnMut(f64) -> Vec<f64>) -> Option<(f64, f64)> {
    let mut likeliest = ((near / STEP).round().max(0.0) as usize).min(LARGEST);
    let mut tried: Vec<Tried> = Vec::new();
    loop {
        for steps in likeliest.saturating_sub(AROUND)..=(likeliest + AROUND).min(LARGEST) {
            if tried.iter().all(|one| one.steps != steps) {
                tried.push(Tried { steps, likelihoods: likelihoods(STEP * steps as f64) });
            }
        }
        let best = tried.iter().max_by(|a, b| a.total().total_cmp(&b.total()))?.steps;
        if best == likeliest {
            break;
        }
        likeliest = best;
    }
    tried.sort_by_key(|one| one.steps);
    let reversals = 0..tried[0].likelihoods.len();
    let told: Vec<(f64, f64)> = reversals.filter_map(|reversal| summit(&tried, reversal, temper)).collect();
    if told.len() < FEWEST { None } else { weighted(&told) }
}

/// The share that a reversal prefers, and its variance, from the parabola through its likeliest share and both neighbours; `None` where it has no summit.
fn summit(tried: &[Tried], reversal: usize, temper: f64) -> Option<(f64, f64)> {
    let at = |k: usize| tried[k].likelihoods[reversal];
    let top = (0..tried.len()).max_by(|&i, &j| at(i).total_cmp(&at(j)))?.clamp(1, tried.len() - 2);
    let [before, here, after] = [at(top - 1), at(top), at(top + 1)];
    let slope = (after - before) / (2.0 * STEP);
    let curvature = (2.0 * here - before - after) / (STEP * STEP);
    let share = STEP * tried[top].steps as f64 + slope / curvature;
    (curvature > 0.0).then(|| (share.clamp(0.0, 1.0), (temper * curvature).recip()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three reversals whose `ln L` are parabolas with summits at 0.25, 0.31 and 0.37, and one that tells nothing; the search begins four steps off.
    /// With a curvature of 1000 and a temper of a quarter each has the variance 0.004, more than the 0.0036 of their scatter: the error is √(0.004/3).
    #[test]
    fn closed_form_share_of_parabolas() {
        let mut asked = 0;
        let likelihoods = |share: f64| {
            asked += 1;
            let of = |summit: f64| -500.0 * (share - summit).powi(2);
            vec![of(0.25), of(0.31), of(0.37), -20.0]
        };
        let (share, error) = settle(0.7, 0.25, likelihoods).expect("a share");
        assert!((share - 0.31).abs() < 1e-9, "{share}");
        assert!((error - (0.004_f64 / 3.0).sqrt()).abs() < 1e-9, "{error}");
        assert!(asked <= 9, "each share once: {asked}");
    }

    /// Reversals that contradict each other have the error of their scatter: summits at 0.1, 0.3 and 0.5 that are sharp to 0.01 give 0.2/√3.
    #[test]
    fn closed_form_error_of_shares_that_scatter() {
        let likelihoods = |share: f64| [0.1, 0.3, 0.5].map(|summit: f64| -5000.0 * (share - summit).powi(2)).to_vec();
        let (share, error) = settle(0.3, 1.0, likelihoods).expect("a share");
        assert!((share - 0.3).abs() < 1e-9, "{share}");
        assert!((error - 0.2 / 3.0_f64.sqrt()).abs() < 1e-3, "{error}");
    }

    /// Where the likelihood has no summit, nothing is told.
    #[test]
    fn property_no_share_without_a_summit() {
        assert!(settle(0.3, 0.15, |_| vec![-7.0; 5]).is_none());
    }
}
