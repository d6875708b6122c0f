//! Whether an effect that repeats with an angle is a line at its order, or part of a broad structure.
//!
//! Consider the gain `g(n)` of likelihood by a cosine and a sine of order `n`. Without a line it is exponential around the level of
//! its neighbourhood, whatever causes that level: `P(g > r ḡ) = e^{−r}`. A joint that covers the range `R` resolves orders at a distance of
//! `2π/R`; `ḡ` is the median over orders beyond that distance, divided by `ln 2`. Of `N` orders the largest gain exceeds `r = ln(N/p)`
//! by chance with the probability `p`. A delay, or friction of another shape, raises all orders together and does not exceed it.
//! The level is that of the rows without the line: a line of 2000 nats leaves 20 nats in its own side lobes.
//! Left out: a second line among the neighbours; the median tolerates lines in up to half of them.
//! Reference: H. Rohling (1983), Radar CFAR thresholding in clutter and multiple target situations.

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::diagnose::evidence::pattern_search::with_term;
use crate::diagnose::fit::pose::needs_narrow_rows;
use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::scanned::Scanned;
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
    rows: Scanned<'m>,
    /// Scale of the error.
    scale: f64,
    /// `2π/R`.
    resolution: f64,
}

impl<'m> Scan<'m> {
    fn new(problem: &Problem<'m>, terms: &[&Term], fitted: &Fitted, joint: usize) -> Self {
        let system = problem.system_of(&[joint], terms, Part::Train, false).system;
        Self {
            joint,
            rows: Scanned::new(problem, &system, &fitted.solution, joint, SCANNED_ROWS),
            scale: fitted.solution.scale[joint],
            resolution: TAU / problem.motion.range(joint).max(1e-9),
        }
    }

    /// [nats of rows] Mean gain of the neighbours of an order; infinite where it has none.
    fn level(&self, columns: Columns, order: f64) -> f64 {
        let [nearest, farthest, step] = NEIGHBOURS;
        let count = ((farthest - nearest) / step) as usize;
        let away = (0..=count).map(|k| (nearest + k as f64 * step) * self.resolution);
        let mut level: Vec<f64> = away
            .flat_map(|away| [order - away, order + away])
            .filter(|order| *order > self.resolution)
            .map(|order| self.rows.score.gain(&columns(&self.rows.motion, self.joint, order)))
            .collect();
        if level.is_empty() {
            return f64::INFINITY;
        }
        let middle = level.len() / 2;
        *level.select_nth_unstable_by(middle, f64::total_cmp).1 / std::f64::consts::LN_2
    }

    /// Whether a term exceeds its neighbours as a line does; it is the largest of `tried` orders. `beside`: the rows with the line fitted.
    fn stands_out(&self, beside: &Self, term: &Term, problem: &Problem, tried: usize) -> bool {
        let Some((order, columns)) = line_of(&*term.effect, &problem.motion, self.joint, &term.shape) else {
            return false;
        };
        // With less than one and a half periods in the range of the joint it is a slow curve, which a spring or a load draws as well.
        if order < NEIGHBOURS[0] * self.resolution {
            return false;
        }
        let level = beside.level(columns, order);
        // Gains are relative to the error that is left.
        let gain = self.rows.score.gain(&term.effect.columns(&self.rows.motion, self.joint, &term.shape));
        let gain = gain * (self.scale / beside.scale).powi(2);
        self.rows.independence * level < MOST_LEVEL && gain > level * (tried as f64 / CHANCE).ln()
    }

    /// The effect's best shape, and the number of all, where its gain is worth a look.
    fn best(&self, effect: &dyn Diagnosable, motion: &Motion) -> Option<(Vec<f64>, usize)> {
        let mut shapes = effect.shapes(motion, self.joint);
        let gains: Vec<f64> = shapes
            .iter()
            .map(|shape| self.rows.score.gain(&effect.columns(&self.rows.motion, self.joint, shape)))
            .collect();
        let raised = gains.iter().filter(|gain| self.rows.independence * **gain > LEAST_GAIN).count();
        if raised == 0 || (raised > 1 && raised as f64 > MOST_RAISED * gains.len() as f64) {
            return None;
        }
        let best = (0..gains.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]))?;
        Some((shapes.swap_remove(best), gains.len()))
    }
}

/// Whether the rows show a line of any effect that needs narrow rows, beside the baseline and these terms.
pub fn any(problem: &Problem, terms: &[&Term], fitted: &Fitted) -> bool {
    let shown_on = |joint: usize| {
        let scan = Scan::new(problem, terms, fitted, joint);
        let is_shown = |effect: &'static dyn Diagnosable| {
            let (shape, tried) = scan.best(effect, &problem.motion)?;
            let term = Term::new(&problem.motion, effect, &[joint], shape);
            let terms = with_term(terms, &term);
            let with = problem.fit_near(&[joint], &terms, Part::Train, fitted)?;
            Some(scan.stands_out(&Scan::new(problem, &terms, &with, joint), &term, problem, tried))
        };
        let narrow = problem.catalogue.diagnosable().filter(|effect| needs_narrow_rows(*effect));
        narrow.filter(|effect| effect.applies(&problem.motion, joint)).any(|effect| is_shown(effect) == Some(true))
    };
    problem.joints().into_par_iter().any(shown_on)
}

/// Whether one of the terms is a line beside the others; a term that does not repeat with an angle is not.
pub fn is_line(problem: &Problem, terms: &[&Term], index: usize) -> bool {
    let others: Vec<&Term> =
        terms.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, term)| *term).collect();
    let fit = |terms: &[&Term]| problem.fit(terms, Part::Train, crate::diagnose::fit::regression::NU);
    let (Some(without), Some(with)) = (fit(&others), fit(terms)) else { return false };
    let term = terms[index];
    term.joints.iter().all(|joint| {
        let [without, with] =
            [(&others[..], &without), (terms, &with)].map(|(terms, fitted)| Scan::new(problem, terms, fitted, *joint));
        without.stands_out(&with, term, problem, term.effect.shapes(&problem.motion, *joint).len())
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::effects::drawn::{LENGTH, MODEL, NOISE, ROBOT, drawn};
    use crate::robot::Model;

    /// A ripple of thousands of nats leaves dozens in its own side lobes, which are no broad structure: it stays a line. Its torque is up to 100 times the
    /// noise.
    #[test]
    fn recover_a_ripple_however_strong() {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
        let effect = crate::effects::find("transmission_error")
            .and_then(|effect| effect.diagnosable())
            .expect("an effect of torque");
        for seed in 0..6 {
            for times_noise in [3.0, 10.0, 30.0, 100.0] {
                let mut motion = drawn(&model, seed, None, 6.0 * LENGTH);
                let term = Term::new(&motion, effect, &[0], vec![90.0]);
                let column = &term.columns[0][0];
                let size = times_noise * NOISE / crate::timeseries::root_mean_square(column);
                motion.joints[0].torque.iter_mut().zip(column).for_each(|(torque, x)| *torque += size * x);
                let held_out = vec![false; motion.rows()];
                let mut problem = Problem::new(motion, held_out);
                let fitted = problem.settle(&[]).expect("a baseline");
                problem.count_independent(&fitted);
                assert!(is_line(&problem, &[&term], 0), "seed {seed}, {times_noise} times the noise");
            }
        }
    }
}
