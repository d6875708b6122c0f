//! The regression problem of a diagnosis: rows, zones, splits, and the terms of the model.

use super::cause::Cause;
use nalgebra::DVector;
use rayon::prelude::*;

use super::baseline::{FALLING, Falling, JointBaseline, stribeck_grid};
use super::golden::golden_section;
use super::regression::{Block, NU, Solution, System, profile_likelihood};
use crate::diagnose::rows::standstill::Standstill;
use crate::effects::{Catalogue, Diagnosable, Motion, Scope, falling};

/// An effect on certain joints, which share its coefficients.
#[derive(Clone)]
pub struct Term {
    /// The effect.
    pub effect: Cause,
    /// One joint, or all of them for an effect of the machine.
    pub joints: Vec<usize>,
    /// Its shape.
    pub shape: Vec<f64>,
    /// `columns[position in joints][coefficient][row]`.
    pub columns: Vec<Vec<Vec<f64>>>,
}

impl Term {
    /// Evaluates an effect along the motion.
    pub fn new(motion: &Motion, effect: impl Into<Cause>, joints: &[usize], shape: Vec<f64>) -> Self {
        let effect = effect.into();
        let columns = joints.iter().map(|joint| effect.columns(motion, *joint, &shape)).collect();
        Self { effect, joints: joints.to_vec(), shape, columns }
    }

    /// Number of linear coefficients.
    pub fn coefficients(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Whether one set of parameters applies to the whole machine.
    pub fn is_machine(&self) -> bool {
        self.effect.about().scope == Scope::Machine
    }
}

/// A part of the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All training rows.
    Train,
    /// The training rows without one fold.
    Without(usize),
    /// One fold of the training rows.
    Fold(usize),
    /// The held-out rows.
    HeldOut,
}

/// Number of folds for cross-validation within the training data.
pub const FOLDS: usize = 4;
/// Least amount of the falling part of friction in the data, in equivalent independent rows, for which the Stribeck velocity is fitted.
const LEAST_PRESENCE: f64 = 1.0;
/// Ratio of the ends of the search interval at which a Stribeck velocity counts as found.
const STRIBECK_RATIO: f64 = 1.01;
/// Largest lag of the autocorrelation sum.
const MOST_LAGS: usize = 400;
/// [s] Length of the blocks of a fold.
const BLOCK: f64 = 5.0;

/// Rows of smooth motion, with everything that a fit needs.
pub struct Problem<'m> {
    /// The motion.
    pub motion: Motion<'m>,
    /// `zones[joint][row]`: rows of the robust fit.
    pub zones: Vec<Vec<bool>>,
    /// `judged[joint][row]`: rows of the error figures, in which the links follow their rotors for certain.
    pub judged: Vec<Vec<bool>>,
    /// Whether a row is held out.
    pub held_out: Vec<bool>,
    /// One baseline per joint.
    pub baseline: Vec<JointBaseline>,
    /// Independent samples per row, one value per joint.
    pub independence: Vec<f64>,
    /// Currents before the first motion, one entry per joint.
    pub standstill: Vec<Option<Standstill>>,
    /// Effects that may be named.
    pub catalogue: Catalogue,
    /// Causes that are tried as terms: the effects of the catalogue that show in torque, or their changes.
    pub causes: Vec<Cause>,
    /// Joint and order [1/turn or 1/m] of lines that were removed: their remainder is not a further effect.
    pub taken_out: Vec<(usize, f64)>,
    fold: Vec<usize>,
}

/// A fit of the baseline with terms.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Joints that were fitted; the solution has no rows of other joints.
    pub joints: Vec<usize>,
    /// The solution over the training rows.
    pub solution: Solution,
    /// First coefficient of each joint's baseline.
    pub baseline_at: Vec<usize>,
    /// First coefficient of each term.
    pub term_at: Vec<usize>,
}

/// Independent samples per row: the inverse of the correlation time of the weighted residual, in rows, with at most `most_lags` lags.
/// `rows` are the row numbers of the residuals.
pub fn independence(residual: &[f64], weights: &[f64], rows: &[usize], most_lags: usize) -> f64 {
    let z: Vec<f64> = residual.iter().zip(weights).map(|(e, w)| e * w.sqrt()).collect();
    let power: f64 = z.iter().map(|z| z * z).sum::<f64>() / z.len().max(1) as f64;
    let mut sum = 1.0;
    for lag in 1..most_lags {
        let pairs = (lag..rows.len()).filter(|i| rows[*i] - rows[i - lag] == lag);
        let (total, count) = pairs.fold((0.0, 0_usize), |(t, n), i| (t + z[i] * z[i - lag], n + 1));
        let correlation = total / (count.max(1) as f64 * power.max(1e-300));
        // Once the correlation is within the noise of its own estimate, take the rest as zero.
        if count < 50 || correlation < 2.0 / (count as f64).sqrt() {
            break;
        }
        sum += 2.0 * correlation;
    }
    1.0 / sum
}

impl<'m> Problem<'m> {
    /// Builds the problem from rows; `zones` as [`rigid_zone`](crate::diagnose::rows::zones::rigid_zone) gives them.
    pub fn new(motion: Motion<'m>, held_out: Vec<bool>) -> Self {
        let sessions: Vec<usize> = (0..motion.sessions)
            .filter(|s| motion.session.iter().zip(&held_out).any(|(session, held)| session == s && !held))
            .collect();
        let baseline = (0..motion.joints.len()).map(|joint| JointBaseline::new(&motion, joint, &sessions)).collect();
        let fold = motion.session.iter().zip(&motion.time).map(|(s, t)| ((t / BLOCK) as usize + s) % FOLDS).collect();
        let zones = vec![vec![true; motion.rows()]; motion.joints.len()];
        let judged = zones.clone();
        let independence = vec![1.0; motion.joints.len()];
        let standstill = vec![None; motion.joints.len()];
        Self {
            motion,
            zones,
            judged,
            held_out,
            baseline,
            independence,
            standstill,
            catalogue: Catalogue::empty(),
            causes: Vec::new(),
            taken_out: Vec::new(),
            fold,
        }
    }

    /// Sets the effects that may be named.
    pub fn name_from(&mut self, catalogue: Catalogue) {
        self.causes = catalogue.diagnosable().map(Cause::from).collect();
        self.catalogue = catalogue;
    }

    /// Rows of a joint in its zone and in a part.
    pub fn rows(&self, joint: usize, part: Part) -> Vec<usize> {
        (0..self.motion.rows()).filter(|row| self.zones[joint][*row] && self.is_in(*row, part)).collect()
    }

    /// Rows of a joint for the error figures.
    pub fn judged_rows(&self, joint: usize, part: Part) -> Vec<usize> {
        (0..self.motion.rows()).filter(|row| self.judged[joint][*row] && self.is_in(*row, part)).collect()
    }

    /// Whether an effect of this shape has the order of a line that was removed, within the resolution that the joint's range allows.
    pub fn is_taken_out(&self, effect: &dyn Diagnosable, joint: usize, shape: &[f64]) -> bool {
        let mut lines = self.taken_out.iter().filter(|(of, _)| *of == joint).peekable();
        if lines.peek().is_none() {
            return false;
        }
        let resolution = std::f64::consts::TAU / self.motion.range(joint).max(1e-9);
        let order = effect.harmonic().map(|harmonic| (harmonic.order)(&self.motion, joint, shape));
        order.is_some_and(|order| lines.any(|(_, line)| (line - order).abs() < resolution))
    }

    /// Whether a row belongs to a part, in any zone.
    pub fn is_in(&self, row: usize, part: Part) -> bool {
        match part {
            Part::Train => !self.held_out[row],
            Part::Without(fold) => !self.held_out[row] && self.fold[row] != fold,
            Part::Fold(fold) => !self.held_out[row] && self.fold[row] == fold,
            Part::HeldOut => self.held_out[row],
        }
    }

    /// All joints.
    pub fn joints(&self) -> Vec<usize> {
        (0..self.baseline.len()).collect()
    }

    /// Joints whose fit changes with a term on some joints: these joints, and those that share coefficients with them.
    pub fn coupled(&self, terms: &[&Term], joints: &[usize]) -> Vec<usize> {
        let mut coupled = joints.to_vec();
        let shares = |term: &Term, with: &[usize]| {
            let within = term.joints.iter().filter(|joint| with.contains(joint)).count();
            within > 0 && within < term.joints.len()
        };
        while let Some(term) = terms.iter().find(|term| shares(term, &coupled)) {
            coupled.extend(&term.joints);
            coupled.sort_unstable();
            coupled.dedup();
        }
        coupled
    }

    /// The blocks of a part with these terms, and the positions of their coefficients.
    pub fn system(&self, terms: &[&Term], part: Part, with_derivative: bool) -> (System, Vec<usize>, Vec<usize>) {
        self.system_of(&self.joints(), terms, part, with_derivative)
    }

    /// As [`system`](Self::system), with empty blocks for other joints.
    pub fn system_of(
        &self,
        joints: &[usize],
        terms: &[&Term],
        part: Part,
        with_derivative: bool,
    ) -> (System, Vec<usize>, Vec<usize>) {
        let mut unknowns = 0;
        let mut baseline_at = Vec::new();
        for baseline in &self.baseline {
            baseline_at.push(unknowns);
            unknowns += baseline.len() + usize::from(with_derivative && baseline.stribeck_derivative().is_some());
        }
        let mut term_at = Vec::new();
        for term in terms {
            term_at.push(unknowns);
            unknowns += term.coefficients();
        }
        let mut blocks = vec![Block::default(); self.baseline.len()];
        for joint in joints {
            blocks[*joint] = self.block(*joint, part, terms, baseline_at[*joint], &term_at, with_derivative);
        }
        (System { blocks, unknowns, priors: Vec::new() }, baseline_at, term_at)
    }

    fn block(
        &self,
        joint: usize,
        part: Part,
        terms: &[&Term],
        first: usize,
        term_at: &[usize],
        with_derivative: bool,
    ) -> Block {
        let rows = self.rows(joint, part);
        let pick = |column: &[f64]| -> Vec<f64> { rows.iter().map(|row| column[*row]).collect() };
        let baseline = &self.baseline[joint];
        let derivative = baseline.stribeck_derivative().filter(|_| with_derivative);
        let own = baseline.columns().iter().chain(derivative);
        let mut columns: Vec<_> = own.enumerate().map(|(index, column)| (first + index, pick(column))).collect();
        for (term, at) in terms.iter().zip(term_at) {
            if let Some(place) = term.joints.iter().position(|j| *j == joint) {
                columns.extend(term.columns[place].iter().enumerate().map(|(k, column)| (at + k, pick(column))));
            }
        }
        Block { y: pick(baseline.target()), columns }
    }

    /// Fits baseline and terms to a part of the training data.
    pub fn fit(&self, terms: &[&Term], part: Part, nu: f64) -> Option<Fitted> {
        let (system, baseline_at, term_at) = self.system(terms, part, false);
        let solution = system.solve(nu)?;
        Some(Fitted { joints: self.joints(), solution, baseline_at, term_at })
    }

    /// As [`fit`](Self::fit), and the Stribeck velocities may change a little: for the comparison of candidates.
    pub fn fit_loosely(&self, terms: &[&Term], part: Part) -> Option<Fitted> {
        let (system, baseline_at, term_at) = self.system(terms, part, true);
        let solution = system.solve(NU)?;
        Some(Fitted { joints: self.joints(), solution, baseline_at, term_at })
    }

    /// As [`fit_loosely`](Self::fit_loosely), for some joints only. It starts with the weights of a similar fit of all training rows, which takes
    /// a few iterations instead of dozens.
    pub fn fit_near(&self, joints: &[usize], terms: &[&Term], part: Part, near: &Fitted) -> Option<Fitted> {
        let (system, baseline_at, term_at) = self.system_of(joints, terms, part, true);
        let weights = |joint: usize| -> Vec<f64> {
            if !joints.contains(&joint) {
                return Vec::new();
            }
            let all = self.rows(joint, Part::Train).into_iter().zip(&near.solution.weights[joint]);
            all.filter(|(row, _)| !matches!(part, Part::Without(fold) if self.fold[*row] == fold))
                .map(|(_, w)| *w)
                .collect()
        };
        let weights = (0..self.baseline.len()).map(weights).collect();
        let solution = system.solve_from(NU, weights, near.solution.scale.clone())?;
        Some(Fitted { joints: joints.to_vec(), solution, baseline_at, term_at })
    }

    /// Log-likelihood of each joint on another part of the training data with a loose fit, as if rows were independent; 0 for joints not fitted.
    pub fn likelihood_elsewhere(&self, terms: &[&Term], fitted: &Fitted, part: Part) -> Vec<f64> {
        let (system, _, _) = self.system_of(&fitted.joints, terms, part, true);
        let of_joint =
            |joint: &usize| profile_likelihood(&system.blocks[*joint].residual(&fitted.solution.coefficients), NU);
        let mut likelihood = vec![0.0; self.baseline.len()];
        fitted.joints.iter().for_each(|joint| likelihood[*joint] = of_joint(joint));
        likelihood
    }

    /// On held-out rows, frees what may differ in sessions without training rows: the Coulomb level (with a prior of 5 %), the offset of a torque,
    /// and the phase of torques that repeat with the motor angle.
    pub fn free_new_sessions(
        &self,
        joint: usize,
        terms: &[&Term],
        coefficients: &DVector<f64>,
        term_at: &[usize],
        residual: &mut [f64],
    ) {
        let rows = self.rows(joint, Part::HeldOut);
        for session in 0..self.motion.sessions {
            let trained = self.motion.session.iter().zip(&self.held_out).any(|(s, held)| *s == session && !held);
            let picked: Vec<usize> =
                (0..rows.len()).filter(|index| self.motion.session[rows[*index]] == session).collect();
            if trained || picked.is_empty() {
                continue;
            }
            let own_rows: Vec<usize> = picked.iter().map(|index| rows[*index]).collect();
            let mut e: Vec<f64> = picked.iter().map(|index| residual[*index]).collect();
            for (term, at) in terms.iter().zip(term_at).filter(|(term, _)| term.effect.harmonic().is_some()) {
                if let Some(place) = term.joints.iter().position(|j| *j == joint) {
                    let trained = [coefficients[*at], coefficients[*at + 1]];
                    e = self.free_phase(joint, &own_rows, e, &term.columns[place], trained);
                }
            }
            let (e, _) = self.free_level(joint, &own_rows, e, Vec::new());
            picked.iter().zip(e).for_each(|(index, e)| residual[*index] = e);
        }
    }

    /// Rotates the phase of a harmonic at constant amplitude, where that fits better.
    fn free_phase(
        &self,
        joint: usize,
        rows: &[usize],
        e: Vec<f64>,
        columns: &[Vec<f64>],
        trained: [f64; 2],
    ) -> Vec<f64> {
        let pick = |column: &[f64]| -> Vec<f64> { rows.iter().map(|row| column[*row]).collect() };
        let [cos, sin] = [pick(&columns[0]), pick(&columns[1])];
        let bare: Vec<f64> = (0..rows.len()).map(|i| e[i] + trained[0] * cos[i] + trained[1] * sin[i]).collect();
        let (_, found) = self.free_level(joint, rows, bare.clone(), vec![cos.clone(), sin.clone()]);
        let size = found[0].hypot(found[1]);
        if size <= 0.0 {
            return e;
        }
        let scale = trained[0].hypot(trained[1]) / size;
        let turned: Vec<f64> =
            (0..rows.len()).map(|i| bare[i] - scale * (found[0] * cos[i] + found[1] * sin[i])).collect();
        let power = |values: Vec<f64>| -> f64 {
            let (left, _) = self.free_level(joint, rows, values, Vec::new());
            left.iter().map(|e| e * e).sum()
        };
        if power(turned.clone()) < power(e.clone()) { turned } else { e }
    }

    /// The residual after a fit of the session's Coulomb level, its offset and the coefficients of further columns.
    fn free_level(&self, joint: usize, rows: &[usize], y: Vec<f64>, further: Vec<Vec<f64>>) -> (Vec<f64>, Vec<f64>) {
        let m = &self.motion.joints[joint];
        let count = further.len();
        let mut all = further;
        all.push(rows.iter().map(|row| m.direction[*row]).collect());
        if !m.has_current {
            all.push(vec![1.0; rows.len()]);
        }
        let unknowns = all.len();
        let columns = all.into_iter().enumerate().collect();
        let level = 0.05 * m.friction.coulomb.abs().max(1e-9);
        let priors = vec![(count, 1.0 / (self.independence[joint] * level * level))];
        let system = System { blocks: vec![Block { y, columns }], unknowns, priors };
        match system.solve(NU) {
            Some(mut solution) => {
                (solution.residual.swap_remove(0), solution.coefficients.iter().take(count).copied().collect())
            }
            None => (system.blocks[0].y.clone(), vec![0.0; count]),
        }
    }

    /// Finds the best Stribeck velocities for the terms, and writes the fitted friction into the motion.
    pub fn settle(&mut self, terms: &[&Term]) -> Option<Fitted> {
        let of_joint = |(joint, baseline): (usize, &JointBaseline)| match baseline.falling() {
            Falling::Given(_) => Some(baseline.clone()),
            Falling::Free(_) => {
                let v_s = self.stribeck_velocity(terms, joint)?;
                Some(baseline.at_stribeck_velocity(&self.motion, joint, v_s))
            }
        };
        self.baseline = self.baseline.par_iter().enumerate().map(of_joint).collect::<Option<_>>()?;
        let fitted = self.fit(terms, Part::Train, NU)?;
        self.adopt(&fitted);
        Some(fitted)
    }

    /// The best Stribeck velocity of a joint for the terms; shared coefficients are fitted to this joint alone.
    fn stribeck_velocity(&self, terms: &[&Term], joint: usize) -> Option<f64> {
        let (system, _, _) = self.system_of(&[joint], terms, Part::Train, false);
        let motion = self.motion.at_rows(&self.rows(joint, Part::Train));
        let likelihood = |v_s: f64| {
            let column = falling(&motion, joint, v_s);
            let presence: f64 = column.iter().map(|x| x * x).sum();
            if presence * self.independence[joint] < LEAST_PRESENCE {
                return f64::NEG_INFINITY;
            }
            let mut system = system.clone();
            system.blocks[joint].columns[FALLING].1 = column;
            system.solve(NU).map_or(f64::NEG_INFINITY, |solution| solution.log_likelihood[joint])
        };
        let grid = stribeck_grid(&self.motion, joint);
        let tried: Vec<f64> = grid.par_iter().map(|v_s| likelihood(*v_s)).collect();
        let best = (0..grid.len()).max_by(|a, b| tried[*a].total_cmp(&tried[*b]))?;
        let (low, high) = (grid[best.saturating_sub(1)], grid[(best + 1).min(grid.len() - 1)]);
        let (low, high) = golden_section([low, high], |low, high| high / low <= STRIBECK_RATIO, likelihood);
        Some(0.5 * (low + high))
    }

    /// [`independence`] of the training rows of each joint; unchanged for joints that were not fitted.
    pub fn independence_of(&self, fitted: &Fitted) -> Vec<f64> {
        let of_joint = |joint: usize| {
            let rows = self.rows(joint, Part::Train);
            let (e, w) = (&fitted.solution.residual[joint], &fitted.solution.weights[joint]);
            independence(e, w, &rows, MOST_LAGS)
        };
        let mut all = self.independence.clone();
        fitted.joints.iter().for_each(|joint| all[*joint] = of_joint(*joint));
        all
    }

    /// Sets the number of independent samples from this fit.
    pub fn count_independent(&mut self, fitted: &Fitted) {
        self.independence = self.independence_of(fitted);
    }

    /// Residual torque of a fit in all rows; sessions without training rows get a level and offset of their own.
    pub fn residual(&self, terms: &[&Term], fitted: &Fitted, joint: usize) -> Vec<f64> {
        let baseline = &self.baseline[joint];
        let c = &fitted.solution.coefficients;
        let mut residual = baseline.target().to_vec();
        for (k, column) in baseline.columns().iter().enumerate() {
            let c = c[fitted.baseline_at[joint] + k];
            residual.iter_mut().zip(column).for_each(|(e, x)| *e -= c * x);
        }
        for (term, at) in terms.iter().zip(&fitted.term_at) {
            let Some(place) = term.joints.iter().position(|j| *j == joint) else { continue };
            for (k, column) in term.columns[place].iter().enumerate() {
                residual.iter_mut().zip(column).for_each(|(e, x)| *e -= c[at + k] * x);
            }
        }
        let rows = self.rows(joint, Part::HeldOut);
        let mut held_out: Vec<f64> = rows.iter().map(|row| residual[*row]).collect();
        self.free_new_sessions(joint, terms, c, &fitted.term_at, &mut held_out);
        rows.iter().zip(held_out).for_each(|(row, e)| residual[*row] = e);
        residual
    }

    /// Writes the fitted friction into the motion, for the columns of effects that depend on it.
    pub fn adopt(&mut self, fitted: &Fitted) {
        for (joint, baseline) in self.baseline.iter().enumerate() {
            let at = fitted.baseline_at[joint];
            let coefficients: Vec<f64> = (0..baseline.len()).map(|k| fitted.solution.coefficients[at + k]).collect();
            self.motion.joints[joint].friction = baseline.friction(&coefficients);
        }
    }
}
