//! Time in another unit: a sample interval that no controller has, and motion that is correct after scaling the time.

use super::balance;
use super::balance::UNSOUND;
use super::kinematics;
use super::rows;
use super::velocity;
use super::words;
use crate::diagnose::result::Mistake;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};

/// [s] Sample intervals that recordings of a drive have.
const INTERVALS: [f64; 2] = [1e-5, 0.1];
/// Units that time may be in.
const UNITS: [(f64, &str); 3] = [(1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns")];

/// Time in ms, µs or ns that was read as seconds.
pub fn found(model: &Model, sessions: &[&TimeSeries]) -> Option<Mistake> {
    let mut intervals: Vec<f64> = sessions.iter().map(|session| session.sample_interval()).collect();
    intervals.sort_by(f64::total_cmp);
    let interval = *intervals.get(intervals.len() / 2)?;
    if interval <= INTERVALS[1] {
        return None;
    }
    let (factor, unit) =
        UNITS.into_iter().find(|(factor, _)| (INTERVALS[0]..=INTERVALS[1]).contains(&(interval * factor)))?;
    let scaled: Vec<TimeSeries> = sessions.iter().map(|session| in_seconds(session, factor)).collect();
    let scaled: Vec<&TimeSeries> = scaled.iter().collect();
    // A velocity channel decides; without one, the torque balance has to fit in the other unit.
    let ratios = (0..model.joints.len()).filter_map(|joint| velocity::of(model, joint, &scaled));
    let agree: Vec<bool> = ratios.map(|(_, ratio): (Channel, kinematics::Ratio)| ratio.agrees()).collect();
    let right = if agree.is_empty() {
        let rows = rows::rows(model, &scaled);
        let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
        let balances = balance::balances(model, &rows, &moves);
        balances.iter().any(Option::is_some) && balances.iter().flatten().all(|one| one.left < UNSOUND)
    } else {
        agree.iter().all(|agrees| *agrees)
    };
    right.then(|| words::time_unit(model, interval, factor, unit))
}

fn in_seconds(session: &TimeSeries, factor: f64) -> TimeSeries {
    let mut session = session.clone();
    session.time.iter_mut().for_each(|time| *time *= factor);
    session
}
