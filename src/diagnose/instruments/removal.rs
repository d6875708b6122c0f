//! Recordings without the torque of named effects, so that later stages do not see it.

use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::term::Term;
use crate::diagnose::select::selection::Selection;
use crate::drive::Sensing;
use crate::effects::Motion;
use crate::timeseries::{Channel, TimeSeries};

/// Samples in one block: the motion of all joints at each sample of half an hour would need more memory than the recording.
const BLOCK: usize = 1 << 16;

/// The first sessions of the problem, as many as are given, minus the torque of the terms that `taken_off` selects, sample by sample.
pub fn without(
    problem: &Problem,
    selection: &Selection,
    sessions: &[&TimeSeries],
    taken_off: &dyn Fn(&Term) -> bool,
) -> Vec<TimeSeries> {
    let terms: Vec<_> = selection.terms().into_iter().zip(&selection.fitted.term_at).collect();
    let terms: Vec<_> = terms.into_iter().filter(|(term, _)| taken_off(term)).collect();
    let of_session = |(number, session): (usize, &&TimeSeries)| {
        let mut corrected = (*session).clone();
        if terms.is_empty() {
            return corrected;
        }
        for (block, time) in session.time.chunks(BLOCK).enumerate() {
            let Some(motion) = at_samples(&problem.motion, number, time) else { return corrected };
            for (term, at) in &terms {
                let coefficients = &selection.fitted.solution.coefficients.as_slice()[**at..];
                let first = block * BLOCK;
                for place in 0..term.joints.len() {
                    take_off(&mut corrected, first, &motion, place, term, coefficients);
                }
            }
        }
        corrected
    };
    sessions.iter().enumerate().map(of_session).collect()
}

/// Subtracts the torque of a term on one of its joints from a recording, from sample `first` on, over the length of the motion.
fn take_off(recorded: &mut TimeSeries, first: usize, motion: &Motion, place: usize, term: &Term, coefficients: &[f64]) {
    let joint = term.joints[place];
    let model = &motion.model.joints[joint];
    let Some(series) = recorded.joints.iter_mut().find(|series| series.name == model.name) else { return };
    let absolute = model.current_sensor.is_some_and(|sensor| sensor.sensing == Sensing::Absolute);
    for (column, c) in term.effect.columns_at(motion, &term.joints, place, &term.shape).iter().zip(coefficients) {
        for (channel, scale) in [(Channel::Torque, 1.0), (Channel::Current, model.torque_per_ampere())] {
            let samples = series.channels.get_mut(&channel).into_iter().flatten();
            for (row, sample) in samples.skip(first).take(column.len()).enumerate() {
                let sign = if absolute { motion.joints[joint].v[row].signum() } else { 1.0 };
                *sample -= sign * c * column[row] / scale;
            }
        }
    }
}

/// The motion of one session at other times, by linear interpolation between its rows and without a kernel. `None` where it has fewer than two
/// rows, as in a session in which hardly anything moves.
fn at_samples<'m>(motion: &Motion<'m>, number: usize, time: &[f64]) -> Option<Motion<'m>> {
    let first = motion.session.partition_point(|session| *session < number);
    let last = motion.session.partition_point(|session| *session <= number);
    let known = &motion.time[first..last];
    if known.len() < 2 {
        return None;
    }
    let place = |t: &f64| {
        let next = known.partition_point(|row| row <= t).clamp(1, known.len() - 1);
        let part = ((t - known[next - 1]) / (known[next] - known[next - 1])).clamp(0.0, 1.0);
        // Across a pause the nearest row counts: nothing is known between.
        let paused = motion.part[first + next - 1] != motion.part[first + next];
        (first + next - 1, if paused { part.round() } else { part })
    };
    let places: Vec<(usize, f64)> = time.iter().map(place).collect();
    let between = |values: &[f64]| -> Vec<f64> {
        places.iter().map(|(row, part)| values[*row] + part * (values[row + 1] - values[*row])).collect()
    };
    Some(Motion {
        model: motion.model,
        sessions: motion.sessions,
        session: vec![number; time.len()],
        part: vec![number; time.len()],
        time: time.to_vec(),
        start: motion.start.clone(),
        interval: motion.interval,
        half_width: vec![0.0; time.len()],
        joints: motion.joints.iter().map(|joint| joint.each(&between)).collect(),
    })
}
