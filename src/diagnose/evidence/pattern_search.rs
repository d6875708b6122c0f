//! The pattern without physics that best describes the residual of a fit.

use nalgebra::Complex;
use rayon::prelude::*;

use super::oscillation;
use super::oscillation::Oscillation;
use super::patterns::{PERIODIC, Periodic, Smooth, orders, smooth};
use crate::diagnose::fit::cause::Cause;
use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::regression::Score;
use crate::diagnose::fit::term::Term;
use crate::effects::Motion;

/// Number of harmonics of a kind that are fitted in full after a scan of all orders.
const SHORTLIST: usize = 2;

/// A pattern that is tried.
pub struct TriedPattern {
    /// Its contribution to the torque.
    pub term: Term,
    /// Number of patterns of its kind that were tried: the evidence is reduced for the choice among them.
    pub tried: usize,
    /// The pattern in words.
    pub words: String,
}

/// The pattern with the largest gain on the training rows of a joint beside these terms and their loose fit, in the sessions `within`.
pub fn likeliest(
    problem: &Problem,
    terms: &[&Term],
    fitted: &Fitted,
    joint: usize,
    within: &(dyn Fn(usize) -> bool + Sync),
) -> Option<TriedPattern> {
    let mut trials = smooth_trials(problem, joint);
    trials.extend(periodic_trials(problem, terms, fitted, joint));
    trials.extend(oscillation_trial(problem, fitted, joint));
    let rows = problem.rows(joint, Part::Train);
    for columns in trials.iter_mut().flat_map(|trial| &mut trial.term.columns) {
        for column in columns.iter_mut() {
            let cells = column.iter_mut().zip(&problem.motion.session);
            cells.filter(|(_, session)| !within(**session)).for_each(|(value, _)| *value = 0.0);
        }
        columns.retain(|column| rows.iter().any(|row| column[*row] != 0.0));
    }
    trials.retain(|trial| trial.term.coefficients() > 0);
    let gain = |trial: TriedPattern| {
        let terms = with_term(terms, &trial.term);
        let fitted = problem.fit_near(&problem.coupled(&terms, &[joint]), &terms, Part::Train, fitted)?;
        let gain = fitted.solution.log_likelihood[joint] - (trial.tried as f64).ln();
        gain.is_finite().then_some((gain, trial))
    };
    let gained: Vec<(f64, TriedPattern)> = trials.into_par_iter().filter_map(gain).collect();
    gained.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, best)| best)
}

/// Terms with one more term at the end.
pub fn with_term<'t>(terms: &[&'t Term], further: &'t Term) -> Vec<&'t Term> {
    terms.iter().copied().chain([further]).collect()
}

fn smooth_trials(problem: &Problem, joint: usize) -> Vec<TriedPattern> {
    let columns = smooth(&problem.motion, joint);
    let tried = columns.len();
    let trial = |(index, (words, column))| TriedPattern {
        term: Term {
            effect: Cause::from(&Smooth),
            joints: vec![joint],
            shape: vec![index as f64],
            free_shapes: 1,
            columns: vec![vec![column]],
            near: Vec::new(),
        },
        tried,
        words,
    };
    columns.into_iter().enumerate().map(trial).collect()
}

/// The strongest oscillation in time.
fn oscillation_trial(problem: &Problem, fitted: &Fitted, joint: usize) -> Option<TriedPattern> {
    let (frequency, tried) = oscillation::strongest(problem, fitted, joint)?;
    Some(TriedPattern {
        term: Term::new(&problem.motion, &Oscillation, &[joint], vec![frequency]),
        tried,
        words: format!(
            "at {frequency:.2} Hz, whatever the motion, as a torque from outside or a control loop that oscillates"
        ),
    })
}

/// The harmonics of each kind with the best scores.
fn periodic_trials(problem: &Problem, terms: &[&Term], fitted: &Fitted, joint: usize) -> Vec<TriedPattern> {
    let motion = &problem.motion;
    let rows = problem.rows(joint, Part::Train);
    let system = problem.system_of(&[joint], terms, Part::Train, true).system;
    let priors = system.priors_per_row(problem.independence[joint]);
    let solution = &fitted.solution;
    let score = Score::new(
        &system.blocks[joint],
        &solution.residual[joint],
        &solution.weights[joint],
        solution.scale[joint],
        &priors,
    );
    let orders = orders(motion, joint);
    let seen = motion.at_rows(&rows);
    // All kinds in one pass: they differ only in the amplitude of the harmonic.
    let scores = PERIODIC.each_ref().map(|kind| score.times(&seen.column(joint, |m, row| kind.amplitude(m, row))));
    let gains = |harmonic: [Vec<f64>; 2]| scores.each_ref().map(|score| score.gain(&harmonic));
    let of_part = |orders: &[f64]| harmonics(&seen, joint, orders).map(gains).collect::<Vec<_>>();
    let scored: Vec<[f64; PERIODIC.len()]> = orders.par_chunks(PART).flat_map_iter(of_part).collect();
    let (ratio, range) = (motion.model.joints[joint].gear_ratio, motion.range(joint));
    let of_kind = |(index, kind): (usize, &'static Periodic)| {
        let mut best: Vec<usize> = (0..orders.len()).collect();
        best.sort_by(|a, b| scored[*b][index].total_cmp(&scored[*a][index]));
        let trial = |order: f64| TriedPattern {
            term: Term::new(motion, kind, &[joint], vec![order]),
            tried: orders.len(),
            words: kind.words(order, ratio, range),
        };
        best.into_iter().take(SHORTLIST).map(|at| trial(orders[at])).collect::<Vec<_>>()
    };
    PERIODIC.iter().enumerate().flat_map(of_kind).collect()
}

/// Number of orders whose phases one thread turns on from one to the next: rounding grows by one digit.
const PART: usize = 32;

/// [`Motion::harmonic`] at equally spaced orders, by turning every row's phase on.
fn harmonics(motion: &Motion, joint: usize, orders: &[f64]) -> impl Iterator<Item = [Vec<f64>; 2]> {
    let first = orders.first().copied().unwrap_or(0.0);
    let step = orders.get(1).map_or(0.0, |second| second - first);
    let phasors = |order: f64| motion.joints[joint].q.iter().map(move |q| Complex::from_polar(1.0, order * q));
    let mut phases: Vec<Complex<f64>> = phasors(first - step).collect();
    let turns: Vec<Complex<f64>> = phasors(step).collect();
    orders.iter().map(move |order| {
        phases.iter_mut().zip(&turns).for_each(|(phase, turn)| *phase *= turn);
        let passed = phases.iter().enumerate().map(|(row, phase)| phase * motion.passed(joint, row, *order));
        passed.map(|x| (x.re, x.im)).collect::<(Vec<f64>, Vec<f64>)>().into()
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::effects::JointMotion;
    use crate::robot::Model;

    #[test]
    fn equivalent_phases_turned_on_and_computed_anew() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/elbow/model.toml");
        let model = Model::load(&file).expect("a robot of the catalogue");
        let rows = 50;
        let position: Vec<f64> = (0..rows).map(|row| 0.03 * f64::from(row)).collect();
        let joint = JointMotion { q: position.clone(), v: vec![0.4; position.len()], ..JointMotion::default() };
        let motion = Motion {
            model: &model,
            sessions: 1,
            session: vec![0; position.len()],
            part: vec![0; position.len()],
            start: vec![0.0],
            interval: 0.01,
            half_width: vec![0.01; position.len()],
            joints: vec![joint; model.joints.len()],
            time: position,
        };
        let orders: Vec<f64> = (0..PART).map(|k| 3.0 + 0.7 * k as f64).collect();
        for (order, turned) in orders.iter().zip(harmonics(&motion, 0, &orders)) {
            for (turned, anew) in turned.iter().zip(motion.harmonic(0, *order, |_, _| 1.0)) {
                // Rounding of 32 products of numbers of size one.
                assert!(turned.iter().zip(anew).all(|(a, b)| (a - b).abs() < 1e-13), "{order}");
            }
        }
    }
}
