//! The delay of currents, from currents that are shifted into step.
//!
//! ```text
//!   τ_rec(t) = τ(t − T) ≈ τ(t) − T τ̇(t),      T ← T + δ(T)
//! ```
//! with the delay `δ` that a fit to currents shifted by `T` still finds. The line holds where the torque changes little within `T`; elsewhere the first
//! fit is too small: of 12 to 40 ms on a six-joint arm it found 84 %. Shifted currents leave a small delay, for which it holds.
//! Channels of one sample may have been read at its beginning or at its end: the error contains that of a uniform distribution over an interval.
//! Reference: T. Söderström, P. Stoica (1989), System Identification, ch. 7 (Gauss-Newton search).

use super::Data;
use crate::diagnose::fit::pose::pose;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::term::Term;
use crate::diagnose::fit::uncertainty::Uncertainty;
use crate::diagnose::instruments::current_lag::shifted;
use crate::diagnose::options::Options;
use crate::diagnose::result::{FoundEffect, Measured};
use crate::diagnose::select::selection::Selection;
use crate::effects::SENSOR_DELAY;
use crate::timeseries::{Estimate, TimeSeries};

/// Largest number of steps.
const STEPS: usize = 4;
/// [1] Step at which the search ends, in standard errors: the next one is less than half as large.
const SMALL: f64 = 0.3;
/// [1] Part of a delay which the rows ask back above which it is refuted: half-way between a delay that is right, none of it, and that of a controller's answers, all of
/// it. Of four late currents (drawn seeds 1094802 to 1094806) 0 to 0.15 were asked back, of three answers (94407, 95421, 99002) 0.9 to 1.
const ASKED_BACK: f64 = 0.5;

/// Replaces the delay of a fit by that of shifted currents, where the search converges: every step is less than half the one before.
pub fn refine(data: &Data, problem: &Problem, selection: &Selection, effects: &mut [FoundEffect], options: &Options) {
    let terms = selection.terms();
    let Some((place, mut delay)) = taken(selection) else { return };
    let mut last = delay;
    for _ in 0..STEPS {
        let Some(rest) = remaining(data, problem, &terms, place, delay, options) else { return };
        if rest.value.abs() < SMALL * rest.std_error {
            let std_error = rest.std_error.hypot(problem.motion.interval / 12.0_f64.sqrt());
            return write(effects, &Estimate { value: delay + rest.value, std_error });
        }
        if rest.value.abs() > 0.5 * last.abs() {
            return;
        }
        (delay, last) = (delay + rest.value, rest.value);
    }
}

/// Whether a selection asks for so much of a delay [s] back by which the currents were shifted before it. Where a loop oscillates, transients may show its controller's
/// late answers; rows tell a late current from those.
pub fn is_undone(selection: &Selection, delay: f64) -> bool {
    delay > 0.0 && taken(selection).is_some_and(|(_, rest)| rest < -ASKED_BACK * delay)
}

/// Place of the delay among the terms of a selection, and its value [s]: of the current, or below zero of the position.
fn taken(selection: &Selection) -> Option<(usize, f64)> {
    let place = selection.terms().iter().position(|term| term.effect.label() == SENSOR_DELAY)?;
    Some((place, selection.fitted.solution.coefficients[selection.fitted.term_at[place]]))
}

/// What a fit of the same terms finds in currents shifted by a delay [s].
fn remaining(
    data: &Data,
    problem: &Problem,
    terms: &[&Term],
    place: usize,
    delay: f64,
    options: &Options,
) -> Option<Estimate> {
    let shifted: Vec<TimeSeries> = data.sessions.iter().map(|session| shifted(session, delay)).collect();
    let mut aligned = pose(data.model, &shifted.iter().collect::<Vec<_>>(), data.division, options).ok()?;
    aligned.taken_out.clone_from(&problem.taken_out);
    let along = |aligned: &Problem| -> Vec<Term> {
        terms.iter().map(|term| Term::new(&aligned.motion, term.effect, &term.joints, term.shape.clone())).collect()
    };
    // Columns may depend on the friction, which a first fit writes into the motion.
    let first = along(&aligned);
    aligned.settle(&first.iter().collect::<Vec<_>>())?;
    let terms = along(&aligned);
    let terms: Vec<&Term> = terms.iter().collect();
    let fitted = aligned.settle(&terms)?;
    let uncertainty = Uncertainty::new(&aligned, &terms, &fitted)?;
    let at = [(fitted.term_at[place], 1.0)];
    let std_error = uncertainty.std_error(&at).hypot(uncertainty.systematic(place, &at));
    Some(Estimate { value: fitted.solution.coefficients[at[0].0], std_error })
}

/// Writes a delay into its effect: that of the current, or below zero that of the position.
fn write(effects: &mut [FoundEffect], delay: &Estimate) {
    for found in effects.iter_mut().filter(|found| found.effect == SENSOR_DELAY) {
        for (name, value) in [("current_delay", delay.value), ("position_delay", -delay.value)] {
            if let Some(measured) = found.parameters.get_mut(name) {
                *measured = Measured { value, std_error: delay.std_error, unit: measured.unit };
            }
        }
    }
}
