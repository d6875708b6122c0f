//! Structure that remains when no effect of the catalogue helps any more: named by its shape, not by a cause.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::problem::{Fitted, Part, Problem, Term};
use super::regression::{NU, Score};
use super::result::Unexplained;
use super::selection::Rules;
use super::views::Residual;

/// Part of the RMS torque that a pattern has to have: less is what the law of an effect or of friction does not get right.
const LEAST_AMPLITUDE: f64 = 0.01;

/// Highest order of the motor angle that is looked for, in periods a turn.
const HIGHEST_ORDER: f64 = 12.0;

/// A shape that a residual can have.
struct Probe {
    columns: Vec<Vec<f64>>,
    /// How many of its kind are tried: the price of choosing among them.
    tried: usize,
    words: String,
}

/// The strongest remaining pattern of each joint, where there is one that a clean machine would not show.
pub fn unexplained(problem: &Problem, terms: &[&Term], rules: &Rules) -> Vec<Unexplained> {
    let Some(fitted) = problem.fit_loosely(terms, Part::Train) else { return Vec::new() };
    let (system, _, _) = problem.system(terms, Part::Train, true);
    let solution = &fitted.solution;
    let mut found = Vec::new();
    for joint in 0..problem.baseline.len() {
        let rows = problem.rows(joint, Part::Train);
        let block = &system.blocks[joint];
        let score = Score::new(block, &solution.residual[joint], &solution.weights[joint], solution.scale[joint]);
        let gained: Vec<(f64, Probe)> = probes(problem, joint)
            .into_par_iter()
            .map(|probe| {
                let picked: Vec<Vec<f64>> =
                    probe.columns.iter().map(|column| rows.iter().map(|row| column[*row]).collect()).collect();
                (score.gain(&picked), probe)
            })
            .collect();
        let best = gained.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((gain, probe)) = best else { continue };
        // Rows are as independent as the errors beside the pattern are.
        let mut with = system.clone();
        for column in &probe.columns {
            with.blocks[joint].columns.push((with.unknowns, rows.iter().map(|row| column[*row]).collect()));
            with.unknowns += 1;
        }
        let Some(beside) = with.solve(NU) else { continue };
        let beside = Fitted { solution: beside, ..fitted.clone() };
        let nats = problem.independence_of(&beside)[joint] * gain - (probe.tried as f64).ln();
        // A score gain of g nats over n rows lowers the scale of the error by about g/n.
        if nats > rules.nats && *gain / rows.len().max(1) as f64 > rules.log_scale {
            let amplitude = amplitude(probe, &rows, &solution.residual[joint]);
            let model = &problem.motion.model.joints[joint];
            let torque = &problem.motion.joints[joint].torque;
            let power: f64 = rows.iter().map(|row| torque[*row].powi(2)).sum();
            if amplitude < LEAST_AMPLITUDE * (power / rows.len().max(1) as f64).sqrt() {
                continue;
            }
            let pattern = format!("{}, {amplitude:.3} {}", probe.words, model.kind.effort_unit());
            found.push(Unexplained { joint: model.name.clone(), pattern });
        }
    }
    found
}

/// What a model whose masses are a guess leaves of the torque: no cause is sought in it.
pub fn unjudged(problem: &Problem, residuals: &[Residual]) -> Vec<Unexplained> {
    let of_joint = |(joint, residual): (usize, &Residual)| {
        let m = &problem.motion.joints[joint];
        let power =
            |values: &[f64]| problem.rows(joint, Part::Train).iter().map(|row| values[*row].powi(2)).sum::<f64>();
        let share = 100.0 * (power(&residual.after) / power(&m.torque).max(1e-300)).sqrt();
        let model = &problem.motion.model.joints[joint];
        let pattern =
            format!("{share:.0} % of the torque; the model's masses are estimated, so no cause is sought in it");
        Unexplained { joint: model.name.clone(), pattern }
    };
    residuals.iter().enumerate().map(of_joint).collect()
}

/// RMS of the pattern's part in the residual times √2: the amplitude of a harmonic.
fn amplitude(probe: &Probe, rows: &[usize], residual: &[f64]) -> f64 {
    let mut columns: Vec<(usize, Vec<f64>)> = Vec::new();
    for column in &probe.columns {
        columns.push((columns.len(), rows.iter().map(|row| column[*row]).collect()));
    }
    let unknowns = columns.len();
    let fitted = super::regression::Block { y: residual.to_vec(), columns };
    let system = super::regression::System { blocks: vec![fitted], unknowns, priors: Vec::new() };
    system.solve(super::regression::NU).map_or(0.0, |solution| {
        let power: f64 =
            residual.iter().zip(&solution.residual[0]).map(|(before, after)| (before - after).powi(2)).sum();
        (2.0 * power / rows.len().max(1) as f64).sqrt()
    })
}

fn probes(problem: &Problem, joint: usize) -> Vec<Probe> {
    let motion = &problem.motion;
    let model = &motion.model.joints[joint];
    let mut probes = Vec::new();
    let single = |words: &str, column: Vec<f64>| Probe { columns: vec![column], tried: 4, words: words.to_owned() };
    probes.push(single("in proportion to the joint's own acceleration", motion.joints[joint].a.clone()));
    probes.push(single("growing with the cube of velocity", motion.column(joint, |m, row| m.v[row].powi(3))));
    probes.push(single(
        "friction that drifts with time within a session",
        motion.column(joint, |m, row| m.direction[row] * motion.time[row]),
    ));
    probes.push(single("drifting with time within a session", motion.time.clone()));
    let range = motion.range(joint).max(1e-9);
    let (lowest, step) = (TAU / range, PI / (3.0 * range));
    let count = (((HIGHEST_ORDER * model.gear_ratio - lowest) / step) as usize).min(1500);
    for index in 0..count {
        let order = lowest + step * index as f64;
        let period = TAU * model.gear_ratio / order / crate::units::DEG;
        let words = format!("period of {period:.1}° of motor angle, both directions alike");
        probes.push(Probe { columns: motion.harmonic(joint, order, |_, _| 1.0).into(), tried: count, words });
    }
    probes
}
