//! Independent samples per row for a line, from the level of the residual around the order of the line.
//!
//! Errors of a law of friction or of a nominal mass are slow. Their autocorrelation counts thousands of rows as a few independent samples. A
//! wave of order `n` in the joint's angle is not slow: only the part of the error that looks like waves of nearly the same order disturbs
//! it.
//! `g(n)` is the gain of likelihood by a cosine and a sine of order `n` in [prewhitened](super::prewhitened) rows, taken as independent. Without a line it is exponential around the
//! level of its neighbourhood, whatever causes that level. A joint that covers the range `R` resolves orders at the distance `c = 2π/R`, so that
//! the gains at `n ± (1.5 + k) c` are independent samples of that level. Let `X` be the `m`-th smallest of `K` of them. Then by chance
//!
//! ```text
//!   P(g > α X) = Π_{i<m} (K − i)/(K − i + α)
//! ```
//! with any level: the `2K` degrees of freedom of the neighbours are part of the formula. The independent samples per row are `ι = T/(α_T X)`,
//! with the `α_T` at which `−ln P = T`. `T` is the evidence that a name needs before the reduction for the choice among `N` tried orders,
//! `T = 12 + ln N`. So `ι g − ln N` reaches 12 nats exactly where one of `N` orders exceeds its neighbours by chance once in `e¹²`.
//! Neighbours are taken in pairs, one on either side, since a level that falls with the order is at most the mean of such a pair.
//! Of `K` neighbours a quarter may contain other lines. Left out: lines whose order is too low for enough neighbours below it;
//! they are shapes of the whole stroke, and count as such.
//! Reference: H. Rohling (1983), Radar CFAR thresholding in clutter and multiple target situations, eq. 16 and 17.

use std::f64::consts::TAU;

use super::prediction::Evidence;
use super::prewhitened::Prewhitened;
use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::term::Term;

/// [2π/R] Distance of the nearest neighbour: further than the side lobe of a line in the same place.
const NEAREST: f64 = 1.5;
/// Largest and smallest number of pairs of neighbours.
const PAIRS: [usize; 2] = [10, 4];
/// `m/K`: a quarter of the neighbours may be larger because they contain other lines.
const RANK: f64 = 0.75;
/// [nats] Evidence that a name needs after the reduction for the choice among orders.
const NEEDED: f64 = 12.0;

/// Replaces the evidence of lines by the evidence against the level of their neighbours: where slow errors leave a line too little for a
/// name, and where its neighbours leave it less. Otherwise the evidence stays as it is, comparable with that of other effects.
///
/// `fitted` is the loose fit of all terms, `lines` are the places of the terms in question, `evidence` is that of each joint.
pub fn count_lines(
    problem: &Problem,
    terms: &[&Term],
    fitted: &Fitted,
    lines: impl Iterator<Item = usize>,
    evidence: &mut [Evidence],
) {
    for index in lines {
        let [joint] = terms[index].joints[..] else { continue };
        if let Some(nats) = of_line(problem, terms, fitted, index, joint) {
            let counted = &mut evidence[joint].nats;
            *counted = if *counted > NEEDED { counted.min(nats) } else { nats };
        }
    }
}

/// `ι g` [nats] of one term on its joint: 0 where a neighbour shows in no more rows than there are columns, which then tell nothing from one
/// another. `None` if the term does not repeat with an angle, or too slowly.
fn of_line(problem: &Problem, terms: &[&Term], fitted: &Fitted, index: usize, joint: usize) -> Option<f64> {
    let term = terms[index];
    let order = (term.effect.harmonic()?.order)(&problem.motion, joint, &term.shape);
    let away = neighbours(order, TAU / problem.motion.range(joint).max(1e-9))?;
    let white = Prewhitened::new(problem, terms, fitted, (index, joint))?;
    let motion = problem.motion.at_rows(&problem.rows(joint, Part::Train));
    let orders = away.iter().flat_map(|away| [order - away, order + away]);
    let beside: Vec<_> = orders.map(|order| columns_at(term, &motion, joint, order)).collect::<Option<_>>()?;
    let rows = |columns: &Vec<Vec<f64>>| columns.iter().flatten().filter(|x| **x != 0.0).count() / columns.len().max(1);
    let columns = (beside.len() + 1) * term.coefficients();
    if beside.iter().any(|neighbour| rows(neighbour) <= columns) {
        return Some(0.0);
    }
    let tried = term.effect.shapes(&problem.motion, joint).len();
    let independence = independence(white.gains_of(&beside), NEEDED + (tried.max(1) as f64).ln());
    Some(independence * white.gain()?)
}

/// Distances of the neighbours of an order at this resolution.
fn neighbours(order: f64, resolution: f64) -> Option<Vec<f64>> {
    let [most, fewest] = PAIRS;
    let away = (0..most).map(|k| (NEAREST + k as f64) * resolution);
    let away: Vec<f64> = away.take_while(|away| order - away > NEAREST * resolution).collect();
    (away.len() >= fewest).then_some(away)
}

/// Columns of the effect of a term at another order.
fn columns_at(term: &Term, motion: &crate::effects::Motion, joint: usize, order: f64) -> Option<Vec<Vec<f64>>> {
    let harmonic = term.effect.harmonic()?;
    if let Some(columns) = harmonic.in_narrow_rows {
        return Some(columns(motion, joint, order));
    }
    // The order is proportional to the first entry of the shape.
    let own = (harmonic.order)(motion, joint, &term.shape);
    let mut shape = term.shape.clone();
    *shape.first_mut()? *= order / own;
    Some(term.effect.columns(motion, joint, &shape))
}

/// `ι` from the gains of the neighbours, exact at the evidence `needed`. Above 1 where the errors around the order are smaller than those of all rows.
fn independence(mut gains: Vec<f64>, needed: f64) -> f64 {
    let count = gains.len();
    let rank = ((RANK * count as f64) as usize).clamp(1, count);
    let level = *gains.select_nth_unstable_by(rank - 1, f64::total_cmp).1;
    needed / (factor(count, rank, needed) * level.max(1e-300))
}

/// `α` at which the `rank`-th smallest of `count` neighbours is exceeded by chance with the probability `e^{−nats}`.
fn factor(count: usize, rank: usize, nats: f64) -> f64 {
    let surprise = |alpha: f64| (0..rank).map(|i| (alpha / (count - i) as f64).ln_1p()).sum::<f64>();
    let (mut low, mut high) = (0.0, 1.0);
    while surprise(high) < nats {
        high *= 2.0;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if surprise(middle) < nats { low = middle } else { high = middle }
    }
    high
}
