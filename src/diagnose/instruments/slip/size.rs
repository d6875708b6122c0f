//! Size and time of a slip, from the paths of the rotors around its throws.

use nalgebra::{DMatrix, DVector};

use super::Step;
use crate::linear::least_squares;
use crate::robot::Model;
use crate::timeseries::{Channel, Estimate, TimeSeries};

/// [s] Time before a throw from which its motion is extrapolated: with positions to a count, by about a count until the throw has ended.
const BEFORE: [f64; 2] = [0.12, 0.02];
/// [s] Time after a throw in which the rotor is furthest away.
const AFTER: f64 = 0.03;
/// Part of the distance of a throw at which its time is taken.
const QUARTER: f64 = 0.25;
/// [s] Time from the start of a slip to that point, and its error (tuning seeds 2800 to 2803, 2900, 2901: 6 to 10 ms).
const ONSET: [f64; 2] = [0.007, 0.004];
/// Throw of a rotor over the slip, mean and standard deviation between its ends: once, where it stays on the flank that pushes it, and twice, where it
/// rebounds with twice the speed of a far heavier link (tuning seeds 95900 to 95909: 1.0 to 2.1).
const REBOUND: [f64; 2] = [1.5, 0.29];

/// A slip that shows in these sessions, whose throws begin at a time [s]; `None` where they disagree about its direction. `link` is the inertia that the
/// joint moves, without its rotor.
pub fn measured(
    model: &Model,
    sessions: &[&TimeSeries],
    link: f64,
    joint: usize,
    shown: &[usize],
    begin: f64,
) -> Option<Step> {
    let rotor = model.joints[joint].reflected_inertia();
    let seen: Vec<[f64; 2]> =
        shown.iter().filter_map(|session| thrown(model, joint, sessions[*session], begin)).collect();
    let mut onsets: Vec<f64> = seen.iter().map(|[onset, _]| *onset).collect();
    onsets.sort_by(f64::total_cmp);
    let onset = *onsets.get(onsets.len() / 2)?;
    let of_throws = seen.iter().map(|[_, by]| -by * (link + rotor) / (link * REBOUND[0]));
    let sizes = DVector::from_iterator(seen.len(), of_throws);
    let (value, scatter) = (sizes.mean(), (sizes.variance() / (sizes.len() as f64 - 1.0).max(1.0)).sqrt());
    let count = model.joints[joint].encoder_step();
    sizes.iter().all(|size| size * value > 0.0).then(|| Step {
        joint,
        jump: Estimate { value, std_error: (value * REBOUND[1] / REBOUND[0]).hypot(scatter).max(count) },
        time: Estimate { value: (onset - ONSET[0]).max(0.0), std_error: ONSET[1] },
    })
}

/// Time at which a rotor leaves its path near a given time, and the distance that it moves [s, rad or m]. The path is a parabola through the positions
/// before.
fn thrown(model: &Model, joint: usize, session: &TimeSeries, near: f64) -> Option<[f64; 2]> {
    let q = session.joint(&model.joints[joint].name)?.get(Channel::Position)?;
    let start = *session.time.first()?;
    let at = |t: f64| session.time.partition_point(|time| time - start < t);
    let [a, b] = [at(near - BEFORE[0]), at(near - BEFORE[1])];
    let (first, last) = (b, at(near + AFTER).min(q.len()));
    if last <= first || near > session.time.last()? - start - AFTER {
        return None;
    }
    let powers = |k: usize| (0..3).map(move |power| ((session.time[k] - session.time[b]) / BEFORE[0]).powi(power));
    let before = DMatrix::from_row_iterator(b - a, 3, (a..b).flat_map(powers));
    let (path, _) = least_squares(&before, &DVector::from_column_slice(&q[a..b]))?;
    let away = |k: usize| q[k] - powers(k).zip(path.iter()).map(|(power, c)| power * c).sum::<f64>();
    let most = (first..last).map(away).max_by(|x, y| x.abs().total_cmp(&y.abs()))?;
    let onset = (first..last).find(|k| away(*k) / most > QUARTER)?;
    Some([session.time[onset] - start, most])
}
