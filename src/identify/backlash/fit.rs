//! The gap that explains the reversals best at one resolution: the likelihood of each over a range of gaps, its value, and the mean of all.
//!
//! Each reversal gives a value `b_i` with a variance; the mean weighs them with `1/(σ_i² + τ²)`, where `τ²` is the scatter that
//! the single variances do not explain (R. DerSimonian, N. Laird 1986), so that the standard error is that of the scatter seen.

use rayon::prelude::*;

use super::ensemble::{Draws, Run, Score, Spread};
use super::result::{EstimatorResult, LeftOut, NORMAL_95, Reason, ReversalGap, mean_deviation_percent};
use super::reversal::FEWEST;
use super::window::Site;
use crate::identify::quantity::Quantity;

/// A reversal one of whose samples is less likely than this is not explained: six standard deviations.
const UNLIKELY: f64 = -18.0;
/// What one reversal can cost a gap, in `ln L`.
const LARGEST_COST: f64 = 40.0;
/// Error of a single value that the ensemble cannot tell, in counts.
const FLOOR: f64 = 0.1;
/// Difference of `ln L` between the best and the worst gap of a range below which a reversal tells nothing.
const LEAST_PREFERENCE: f64 = 6.0;
/// Smallest link share counted on: where gravity outweighs that part of the friction the load may rest on one flank, and a gap
/// that is never crossed looks like none.
const SMALLEST_SHARE: f64 = 0.05;
/// Standard deviation of the error that all values share, in counts: machines without a gap show up to 0.3 of a count, and `0.3/√3` is that of
/// an error anywhere within.
const SHARED: f64 = 0.173;
/// Usual median deviation of single values, in counts.
const COMMON: f64 = 0.2;
/// Factor on that above which single values disagree. At link shares of 0.1 and 0.15 the values of reversals that the links had left deviated by
/// 0.35 to 1.4 counts, at 0.3 and at a quarter of the counts by 0.2 to 0.3.
const UNEVEN: f64 = 1.5;
/// Counts of error that all values share, for each count by which their median deviation is above the usual one. Of 222 levels of 50 drawn planar arms
/// (tuning seeds from 71000; `cargo bench --bench blind -- table --field-clean N` counts the intervals), the median error was 0.05 of a count at median deviations
/// up to 0.2, 0.2 at 0.35, 0.4 at 0.45, 0.6 at 0.6, and 0.9 above 0.8.
const SHARED_OF_EXCESS: f64 = 1.5;
/// Median deviation above which values have no gap in common, in counts: one such level, of those above, led the search to no gap where there was one.
const NOTHING_IN_COMMON: f64 = 1.0;
/// Median deviations beyond which a value is an outlier.
const OUTLIER: f64 = 5.0;

/// What is known beforehand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    /// [rad or m] about where the gap is.
    pub gap: Option<f64>,
    /// [1] the link share; otherwise it is found.
    pub share: Option<f64>,
    /// [1] least link share: reversals are left out at which gravity outweighs that part of the friction.
    pub least_share: f64,
}

impl Default for Known {
    fn default() -> Self {
        Self { gap: None, share: None, least_share: SMALLEST_SHARE }
    }
}

/// What the fit finds.
pub(super) struct Fit {
    /// The gap.
    pub gap: EstimatorResult,
    /// The link share.
    pub share: Quantity,
}

/// One reversal's likelihood over a range of gaps.
pub(super) struct Profile {
    best: Score,
    /// Whether the likeliest gap is the smallest, or the largest, of the range.
    at: [bool; 2],
    mean: f64,
    deviation: f64,
    scores: Vec<f64>,
}

/// Equidistant values from `low` to `high`.
pub(super) fn grid(low: f64, high: f64, step: f64) -> Vec<f64> {
    let n = ((high - low) / step).round().max(1.0) as usize;
    (0..=n).map(|k| low + step * k as f64).collect()
}

/// Every reversal's likelihood over the gaps.
pub(super) fn scan(sites: &[Site], gaps: &[f64], spread: &Spread) -> Vec<Profile> {
    sites.par_iter().map(|site| profile(site, gaps, spread)).collect()
}

/// Number of reversals whose profile has a likelier gap than all of the same range under another spread.
pub(super) fn count_likelier(sites: &[Site], profiles: &[Profile], gaps: &[f64], other: &Spread) -> usize {
    let likelier = |(site, profile): (&Site, &Profile)| {
        let draws = Draws::new(&site.window, other.members);
        let mut runs = Run::before_contact(&site.window, &draws, gaps, other);
        // A run stops where it is no longer as likely.
        let least = profile.best.log_likelihood;
        !outwards(gaps.len()).into_iter().any(|k| runs[k].score(least).log_likelihood >= least)
    };
    sites.par_iter().zip(profiles).filter(|pair| likelier(*pair)).count()
}

/// Numbers below `count`, from the middle outwards.
fn outwards(count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&k| (2 * k).abs_diff(count));
    order
}

/// One reversal's likelihood over the gaps.
fn profile(site: &Site, gaps: &[f64], spread: &Spread) -> Profile {
    let draws = Draws::new(&site.window, spread.members);
    let mut runs = Run::before_contact(&site.window, &draws, gaps, spread);
    // From the middle outwards: where the gap is nearly known, the others are given up early.
    let mut found = vec![None; gaps.len()];
    let mut floor = f64::NEG_INFINITY;
    for k in outwards(gaps.len()) {
        let one = runs[k].score(floor);
        floor = floor.max(one.log_likelihood - LARGEST_COST);
        found[k] = Some(one);
    }
    let found: Vec<Score> = found.into_iter().flatten().collect();
    let scores: Vec<f64> = found.iter().map(|score| score.log_likelihood).collect();
    let top = argmax(&scores);
    let weights: Vec<f64> = scores.iter().map(|l| (spread.temper * (l - scores[top])).exp()).collect();
    let sum: f64 = weights.iter().sum();
    let average = |value: &dyn Fn(f64) -> f64| weights.iter().zip(gaps).map(|(w, &b)| w * value(b)).sum::<f64>() / sum;
    let mean = average(&|b| b);
    Profile {
        best: found[top],
        at: [top == 0, top + 1 == gaps.len()],
        mean,
        deviation: average(&|b| (b - mean).powi(2)).sqrt(),
        scores,
    }
}

impl Profile {
    /// Whether some gap of the range explains the reversal.
    pub fn explained(&self) -> bool {
        self.best.worst > UNLIKELY
    }

    /// Whether the reversal prefers some gaps of the range to others: no flank changes where the load carries the link.
    pub fn tells(&self) -> bool {
        let least = self.scores.iter().copied().fold(f64::INFINITY, f64::min);
        self.best.log_likelihood - least > LEAST_PREFERENCE
    }

    /// `ln L` of the likeliest gap.
    pub const fn highest(&self) -> f64 {
        self.best.log_likelihood
    }

    /// Whether its value can be used.
    fn usable(&self) -> bool {
        self.explained() && self.tells() && self.at == [false; 2]
    }
}

fn argmax(values: &[f64]) -> usize {
    (0..values.len()).max_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap_or(0)
}

/// The gap that all explained reversals agree on, none of them with more than its largest cost.
pub(super) fn pooled_best(profiles: &[Profile]) -> Option<usize> {
    let explained: Vec<&Profile> = profiles.iter().filter(|profile| profile.explained() && profile.tells()).collect();
    let gaps = explained.first()?.scores.len();
    let total = |k: usize| -> f64 {
        explained.iter().map(|one| (one.scores[k] - one.best.log_likelihood).max(-LARGEST_COST)).sum()
    };
    Some(argmax(&(0..gaps).map(total).collect::<Vec<f64>>()))
}

/// Profiles of a coarse scan, each score the best of a gap and its neighbours: a reversal may prefer a gap between two that are tried, and
/// its cost is at the largest already one step away, so that reversals with almost the same gap would not support each other.
pub(super) fn eased(profiles: &[Profile]) -> Vec<Profile> {
    let of_one = |one: &Profile| {
        let near = |k: usize| one.scores[k.saturating_sub(1)..(k + 2).min(one.scores.len())].iter().copied();
        let scores = (0..one.scores.len()).map(|k| near(k).fold(f64::NEG_INFINITY, f64::max)).collect();
        Profile { scores, ..*one }
    };
    profiles.iter().map(of_one).collect()
}

/// Mean and standard error of the link share over the explained reversals.
pub(super) fn share(profiles: &[Profile]) -> Option<(f64, f64)> {
    let values: Vec<(f64, f64)> = profiles
        .iter()
        .filter(|profile| profile.usable())
        .map(|profile| (profile.best.share[0], profile.best.share[1].powi(2)))
        .collect();
    weighted(&values)
}

/// Mean of values with their variances, and its standard error; the scatter between them is part of it.
pub(super) fn weighted(values: &[(f64, f64)]) -> Option<(f64, f64)> {
    if values.is_empty() {
        return None;
    }
    let sums = |extra: f64| {
        values.iter().fold((0.0, 0.0, 0.0), |(s0, s1, s2), (x, var)| {
            let w = 1.0 / (var + extra);
            (s0 + w, s1 + w * x, s2 + w * w)
        })
    };
    let (s0, s1, s2) = sums(0.0);
    let mean = s1 / s0;
    let q: f64 = values.iter().map(|(x, var)| (x - mean).powi(2) / var).sum();
    let between = ((q - (values.len() as f64 - 1.0)) / (s0 - s2 / s0)).max(0.0);
    let (s0, s1, _) = sums(if between.is_finite() { between } else { 0.0 });
    Some((s1 / s0, (1.0 / s0).sqrt()))
}

/// The values of all reversals, and their mean; `others` were left out before, and `asked` reversals tell of the gap. `None` where they do not agree.
pub(super) fn pool(
    sites: &[Site],
    profiles: &[Profile],
    others: Vec<LeftOut>,
    asked: usize,
    unit: &'static str,
) -> Option<Fit> {
    let count = sites.first()?.window.count;
    let share = share(profiles)?;
    let means = || profiles.iter().filter(|one| one.usable()).map(|one| one.mean);
    let middle = median(means())?;
    let scatter = median(means().map(|mean| (mean - middle).abs()))?.max(COMMON * count);
    let (mut values, mut left_out, mut held) = (Vec::new(), others, 0);
    for (site, profile) in sites.iter().zip(profiles) {
        if profile.usable() && (profile.mean - middle).abs() <= OUTLIER * scatter {
            held += usize::from(!site.loose(share.0));
            let std_error = profile.deviation.hypot(FLOOR * count);
            values.push(ReversalGap { time: site.time, velocity: site.velocity, gap: profile.mean, std_error });
        } else {
            let reason = if profile.tells() { Reason::Unexplained } else { Reason::CarriedByLoad };
            left_out.push(LeftOut { time: site.time, reason });
        }
    }
    // A gap that most reversals contradict, or that few show, is not sure to be that of the machine.
    if values.len() < FEWEST || 2 * values.len() < asked || scatter > NOTHING_IN_COMMON * count {
        return None;
    }
    let pairs: Vec<(f64, f64)> = values.iter().map(|one| (one.gap, one.std_error.powi(2))).collect();
    let (mean, scatter_error) = weighted(&pairs)?;
    let shared = SHARED * count + SHARED_OF_EXCESS * (scatter - COMMON * count);
    let std_error = scatter_error.hypot(shared);
    // Nor is one from links that had left their flanks: the values then disagree. Without a gap they cannot leave, and the link share is arbitrary.
    if held < FEWEST && scatter > UNEVEN * COMMON * count && mean > NORMAL_95 * std_error {
        return None;
    }
    let gap = EstimatorResult {
        name: "likelihood_of_reversals",
        mean: Quantity::new(mean, std_error, NORMAL_95, unit),
        mean_deviation_percent: mean_deviation_percent(&values, mean),
        values,
        left_out,
    };
    Some(Fit { gap, share: Quantity::new(share.0, share.1, NORMAL_95, "1") })
}

pub(super) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reversal that prefers one of ten gaps and is at its largest cost with all others.
    fn prefers(gap: usize) -> Profile {
        let scores: Vec<f64> = (0..10).map(|k| if k == gap { 0.0 } else { -2.0 * LARGEST_COST }).collect();
        let best = Score { log_likelihood: 0.0, worst: 0.0, share: [0.3, 0.01] };
        Profile { best, at: [false; 2], mean: 0.0, deviation: 0.0, scores }
    }

    /// Two reversals one step apart agree; two others, three steps apart, do not. Without the neighbours all four gaps are as good.
    #[test]
    fn recover_gap_between_two_that_a_coarse_scan_tries() {
        let profiles = [2, 3, 6, 9].map(prefers);
        let best = pooled_best(&eased(&profiles)).expect("a gap");
        assert!((2..=3).contains(&best), "{best}");
        assert_eq!(pooled_best(&profiles), Some(9));
    }
}
