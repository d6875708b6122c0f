//! Whether an effect that repeats with an angle is a line at its order, or part of a broad structure.
//!
//! Consider the gain `g(n)` of likelihood by a cosine and a sine of order `n`. Without a line it is exponential around the level of
//! its neighbourhood, whatever causes that level: `P(g > r ḡ) = e^{−r}`. A joint that covers the range `R` resolves orders at a distance of
//! `2π/R`; `ḡ` is the median over orders beyond that distance, divided by `ln 2`. Of `N` orders the largest gain exceeds `r = ln(N/p)`
//! by chance with the probability `p`. A delay, or friction of another shape, raises all orders together and does not exceed it.
//! Left out: a second line among the neighbours; the median tolerates lines in up to half of them.
//! Reference: H. Rohling (1983), Radar CFAR thresholding in clutter and multiple target situations.

use std::f64::consts::TAU;

use crate::diagnose::fit::pose::needs_narrow_rows;
use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::regression::{Block, Score};
use crate::diagnose::fit::term::Term;
use crate::effects::{Columns, Diagnosable, Motion};

/// Probability by chance of a line for a joint and an effect.
const CHANCE: f64 = 0.005;
/// [2π/R] Distances of the nearest and the farthest neighbour, and between neighbours.
const NEIGHBOURS: [f64; 3] = [1.5, 6.0, 0.5];
/// Approximate number of rows for a scan.
const SCANNED_ROWS: usize = 2000;
/// Largest share of the orders with a gain above [`LEAST_GAIN`]: with more, the structure is no line. A line with its side lobes takes
/// about 1 %.
const MOST_RAISED: f64 = 0.15;
/// [nats, independent rows] Mean gain of the neighbours (1 if the errors are noise) above which a broad structure has to be explained
/// before any line is judged: 0.4 to 2.5 on tuning machines without a delay (seeds 1000 to 1007, 2403, 3600 to 3701, 6800 to 6901),
/// 10 on one with a delay (5802).
const MOST_LEVEL: f64 = 4.0;
/// [nats, independent rows] Gain on the training rows below which no line is sought: half of the total that a named effect needs.
const LEAST_GAIN: f64 = 6.0;

/// Order of an effect that is sought in narrow rows, and its columns at any order.
fn line_of(effect: &dyn Diagnosable, motion: &Motion, joint: usize, shape: &[f64]) -> Option<(f64, Columns)> {
    let harmonic = effect.harmonic()?;
    Some(((harmonic.order)(motion, joint, shape), harmonic.in_narrow_rows?))
}

/// The residual of one joint, for which the gain of an order is evaluated.
struct Scan<'m> {
    joint: usize,
    motion: Motion<'m>,
    score: Score,
    /// Independent rows per row of the scan.
    weight: f64,
    /// `2π/R`.
    resolution: f64,
}

impl<'m> Scan<'m> {
    fn new(problem: &Problem<'m>, terms: &[&Term], fitted: &Fitted, joint: usize) -> Self {
        let rows = problem.rows(joint, Part::Train);
        let system = problem.system_of(&[joint], terms, Part::Train, false).system;
        let stride = rows.len().div_ceil(SCANNED_ROWS).max(1);
        let thin = |values: &[f64]| -> Vec<f64> { values.iter().step_by(stride).copied().collect() };
        let block = &system.blocks[joint];
        let columns = block.columns.iter().map(|(index, column)| (*index, thin(column))).collect();
        let block = Block { y: thin(&block.y), columns };
        let solution = &fitted.solution;
        let (residual, weights) = (thin(&solution.residual[joint]), thin(&solution.weights[joint]));
        let priors = system.priors_per_row(problem.independence[joint] * stride as f64);
        let score = Score::new(&block, &residual, &weights, solution.scale[joint], &priors);
        let picked: Vec<usize> = rows.iter().step_by(stride).copied().collect();
        Self {
            joint,
            motion: problem.motion.at_rows(&picked),
            score,
            weight: stride as f64 * problem.independence[joint],
            resolution: TAU / problem.motion.range(joint).max(1e-9),
        }
    }

    /// Whether a gain at an order exceeds its neighbours as a line does; it is the largest of `tried` orders.
    fn stands_out(&self, columns: Columns, order: f64, gain: f64, tried: usize) -> bool {
        let [nearest, farthest, step] = NEIGHBOURS;
        let count = ((farthest - nearest) / step) as usize;
        let away = (0..=count).map(|k| (nearest + k as f64 * step) * self.resolution);
        let mut level: Vec<f64> = away
            .flat_map(|away| [order - away, order + away])
            .filter(|order| *order > self.resolution)
            .map(|order| self.score.gain(&columns(&self.motion, self.joint, order)))
            .collect();
        let middle = level.len() / 2;
        let median = *level.select_nth_unstable_by(middle, f64::total_cmp).1;
        let mean = median / std::f64::consts::LN_2;
        self.weight * mean < MOST_LEVEL && gain > mean * (tried as f64 / CHANCE).ln()
    }

    /// Whether the best shape of an effect is a line.
    fn has(&self, effect: &dyn Diagnosable, motion: &Motion) -> bool {
        let shapes = effect.shapes(motion, self.joint);
        let gains: Vec<f64> =
            shapes.iter().map(|shape| self.score.gain(&effect.columns(&self.motion, self.joint, shape))).collect();
        let raised = gains.iter().filter(|gain| self.weight * **gain > LEAST_GAIN).count();
        if raised > 1 && raised as f64 > MOST_RAISED * gains.len() as f64 {
            return false;
        }
        let best = gains.into_iter().zip(&shapes).max_by(|a, b| a.0.total_cmp(&b.0));
        best.is_some_and(|(gain, shape)| {
            let line = |(order, columns)| self.stands_out(columns, order, gain, shapes.len());
            self.weight * gain > LEAST_GAIN && line_of(effect, motion, self.joint, shape).is_some_and(line)
        })
    }
}

/// Whether the rows show a line of any effect that needs narrow rows, beside the baseline.
pub fn any(problem: &Problem, fitted: &Fitted) -> bool {
    problem.joints().into_iter().any(|joint| {
        let scan = Scan::new(problem, &[], fitted, joint);
        let narrow = problem.catalogue.diagnosable().filter(|effect| needs_narrow_rows(*effect));
        narrow.filter(|effect| effect.applies(&problem.motion, joint)).any(|effect| scan.has(effect, &problem.motion))
    })
}

/// Whether one of the terms is a line beside the others; a term that does not repeat with an angle is not.
pub fn is_line(problem: &Problem, terms: &[&Term], index: usize) -> bool {
    let others: Vec<&Term> =
        terms.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, term)| *term).collect();
    let (term, motion) = (terms[index], &problem.motion);
    let Some(fitted) = problem.fit(&others, Part::Train, crate::diagnose::fit::regression::NU) else { return false };
    term.joints.iter().all(|joint| {
        let scan = Scan::new(problem, &others, &fitted, *joint);
        let gain = scan.score.gain(&term.effect.columns(&scan.motion, *joint, &term.shape));
        let tried = term.effect.shapes(motion, *joint).len();
        let line = line_of(&*term.effect, motion, *joint, &term.shape);
        line.is_some_and(|(order, columns)| scan.stands_out(columns, order, gain, tried))
    })
}
