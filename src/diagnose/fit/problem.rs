//! The regression problem of a diagnosis: rows, zones, and parts of the data.

use super::baseline::JointBaseline;
use super::cause::Cause;
use super::inertial::{Inertial, Treated};
use super::regression::Solution;
use super::term::Term;
use crate::diagnose::rows::standstill::Standstill;
use crate::diagnose::rows::zones::Widest;
use crate::effects::{Catalogue, Diagnosable, LeftOut, Motion, Scope};
use crate::timeseries::root_mean_square;

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
/// Largest lag of the autocorrelation sum.
const MOST_LAGS: usize = 400;
/// [s] Length of the blocks of a fold; shorter where the data hold fewer than one for each fold.
const BLOCK: f64 = 5.0;

/// Rows of smooth motion, with everything that a fit needs.
#[derive(Clone)]
pub struct Problem<'m> {
    /// The motion.
    pub motion: Motion<'m>,
    /// `zones[joint][row]`: rows of the robust fit.
    pub zones: Vec<Vec<bool>>,
    /// `judged[joint][row]`: rows of the error figures, in which the links follow their rotors for certain.
    pub judged: Vec<Vec<bool>>,
    /// Joints of which too few such rows were found: they are judged on the rows of the fit, where a link may float in its gap.
    pub floating: Vec<bool>,
    /// How wide unknown gaps were taken to be.
    pub widest_gap: Widest,
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
    /// Causes of the whole machine that were withdrawn: they are not tried again.
    withdrawn: Vec<Cause>,
    /// Joints on which a name was withdrawn: its structure is still there, so that the next best name would be its substitute.
    closed: Vec<usize>,
    /// Causes that were withdrawn on a joint where others stay open: a simpler one explains as much.
    more_than_needed: Vec<(Cause, usize)>,
    /// Deviations of the nominal model within its stated accuracy; `None` where it is exact.
    pub inertial: Option<Inertial>,
    /// Fold of each row.
    pub(super) fold: Vec<usize>,
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
    /// How deviations of the nominal model were treated.
    pub inertial: Treated,
}

impl Fitted {
    /// [nats] What the prior of the deviations loses at the solution: `½ |z|²`.
    pub fn prior_loss(&self) -> f64 {
        0.5 * self.inertial.range().map(|at| self.solution.coefficients[at].powi(2)).sum::<f64>()
    }

    /// Coefficients of a term that was fitted as the last one; `None` if none was.
    pub fn last_of(&self, term: &Term) -> Option<&[f64]> {
        let at = *self.term_at.last()?;
        self.solution.coefficients.as_slice().get(at..at + term.coefficients())
    }
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
        let block = BLOCK.min(motion.duration() / FOLDS as f64).max(1e-9);
        let fold = motion.session.iter().zip(&motion.time).map(|(s, t)| ((t / block) as usize + s) % FOLDS).collect();
        let zones = vec![vec![true; motion.rows()]; motion.joints.len()];
        let judged = zones.clone();
        let floating = vec![false; motion.joints.len()];
        let independence = vec![1.0; motion.joints.len()];
        let standstill = vec![None; motion.joints.len()];
        Self {
            motion,
            zones,
            judged,
            floating,
            widest_gap: Widest::Any,
            held_out,
            baseline,
            independence,
            standstill,
            catalogue: Catalogue::empty(),
            causes: Vec::new(),
            taken_out: Vec::new(),
            withdrawn: Vec::new(),
            closed: Vec::new(),
            more_than_needed: Vec::new(),
            inertial: None,
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

    /// [N·m or N] RMS torque of a joint in its training rows.
    pub fn rms_torque(&self, joint: usize) -> f64 {
        let torque = &self.motion.joints[joint].torque;
        root_mean_square(&self.rows(joint, Part::Train).iter().map(|row| torque[*row]).collect::<Vec<_>>())
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

    /// Whether a cause may still be tried on a joint; one of the machine acts on all joints, also on those that are closed.
    pub fn is_open(&self, cause: Cause, joint: usize) -> bool {
        match cause.about().scope {
            Scope::Machine => {
                self.closed.is_empty() && self.more_than_needed.is_empty() && !self.withdrawn.contains(&cause)
            }
            Scope::Joint => !self.closed.contains(&joint) && !self.more_than_needed.contains(&(cause, joint)),
        }
    }

    /// Bars a term that was withdrawn: its joint to all causes, or its cause on all joints if that is one of the machine.
    pub fn bar(&mut self, term: &Term) {
        match term.is_machine() {
            true => self.withdrawn.push(term.effect),
            false => self.closed.push(term.joints[0]),
        }
    }

    /// Bars the cause of a term of one joint there, but leaves the joint open: the term is no more than a simpler one, whose structure it is.
    pub fn bar_for_simpler(&mut self, term: &Term) {
        match term.is_machine() {
            true => self.bar(term),
            false => self.more_than_needed.push((term.effect, term.joints[0])),
        }
    }

    /// Bars another cause of the machine, which explains as much as a withdrawn one: between the two nothing is decided.
    pub fn bar_rival(&mut self, term: &Term, rival: &str) {
        let rival = self.catalogue.find(rival).and_then(|effect| effect.diagnosable());
        if let Some(rival) = rival.filter(|rival| term.is_machine() && rival.about().scope == Scope::Machine) {
            self.withdrawn.push(term.effect.by(rival));
        }
    }

    /// The joints whose torque is judged.
    pub fn joints(&self) -> Vec<usize> {
        (0..self.baseline.len()).filter(|joint| self.motion.joints[*joint].left_out.is_none()).collect()
    }

    /// Leaves the torque of a joint out of everything. Its motion still moves the others.
    pub fn leave_out(&mut self, joint: usize, why: LeftOut) {
        self.motion.joints[joint].left_out = Some(why);
        self.clear(joint);
    }

    /// Takes all rows of a joint that is left out from its zones.
    pub fn clear(&mut self, joint: usize) {
        self.zones[joint].fill(false);
        self.judged[joint].fill(false);
    }

    /// Joints whose fit changes with a term on some joints: these joints, and those that share coefficients with them.
    pub fn coupled(&self, terms: &[&Term], joints: &[usize]) -> Vec<usize> {
        if self.stands_alone(joints, terms) {
            return joints.to_vec();
        }
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
        self.within(coupled)
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
        if let Some(torque) = self.deviating_torque(terms, fitted, joint) {
            residual.iter_mut().zip(torque).for_each(|(e, x)| *e -= x);
        }
        let rows = self.rows(joint, Part::HeldOut);
        let mut held_out: Vec<f64> = rows.iter().map(|row| residual[*row]).collect();
        self.free_new_sessions(joint, terms, c, &fitted.term_at, &mut held_out);
        rows.iter().zip(held_out).for_each(|(row, e)| residual[*row] = e);
        residual
    }

    /// Inertia [kg·m²] of each rotor at the motor shaft, where the model file gives none and the fit gives one above zero.
    pub fn rotors(&self, fitted: &Fitted) -> Vec<Option<f64>> {
        let of_joint = |(joint, baseline): (usize, &JointBaseline)| {
            let at = fitted.baseline_at[joint] + baseline.rotor_at()?;
            let inertia = fitted.solution.coefficients[at] / self.motion.model.joints[joint].gear_ratio.powi(2);
            (inertia > 0.0).then_some(inertia)
        };
        self.baseline.iter().enumerate().map(of_joint).collect()
    }

    /// Writes the fitted friction into the motion, for the columns of effects that depend on it.
    pub fn adopt(&mut self, fitted: &Fitted) {
        self.adopt_on(0..self.baseline.len(), fitted);
    }

    /// Does so on some joints.
    pub fn adopt_on(&mut self, joints: impl IntoIterator<Item = usize>, fitted: &Fitted) {
        for joint in joints {
            let (baseline, at) = (&self.baseline[joint], fitted.baseline_at[joint]);
            let coefficients: Vec<f64> = (0..baseline.len()).map(|k| fitted.solution.coefficients[at + k]).collect();
            self.motion.joints[joint].friction = baseline.friction(&coefficients);
        }
    }
}
