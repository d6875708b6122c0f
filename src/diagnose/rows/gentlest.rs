//! The sessions in which a joint reverses most gently: their reversals show the gap best.

use crate::identify::backlash;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};

/// [s] Time before a reversal over which the deceleration is computed.
const BRAKING: f64 = 0.1;

/// Number of reversals by which a session is judged: as many as the estimate of its gap uses.
const GENTLEST: usize = 12;

/// Factor on the deceleration of the gentlest session up to which other sessions count as gentle too.
const AS_GENTLE: f64 = 2.0;

/// The sessions in which a joint reverses most gently. If the motor brakes harder than the link's own friction does, the link leaves its
/// flank and crosses the gap before the reversal. Such reversals fit a gap of zero, or a gap of twice the true width.
pub fn gentlest<'s>(model: &Model, joint: usize, sessions: &[&'s TimeSeries]) -> Vec<&'s TimeSeries> {
    let braking: Vec<f64> = sessions.iter().map(|session| braking(model, joint, session)).collect();
    let least = braking.iter().copied().fold(f64::INFINITY, f64::min);
    let gentle = sessions.iter().zip(braking).filter(|(_, braking)| *braking <= AS_GENTLE * least);
    gentle.map(|(session, _)| *session).collect()
}

/// [rad/s² or m/s²] Median deceleration of the gentlest reversals of a session; infinite if there are too few.
fn braking(model: &Model, joint: usize, session: &TimeSeries) -> f64 {
    let model = &model.joints[joint];
    let position = session.joint(&model.name).and_then(|series| series.get(Channel::Position));
    let (Some(position), dt) = (position, session.sample_interval()) else { return f64::INFINITY };
    let span = (BRAKING / dt).round().max(1.0) as usize;
    // From q(t − T) = q − a T²/2.
    let deceleration = |turn: usize| {
        let before = turn.saturating_sub(span);
        let time = if before + span == turn { session.time[turn] - session.time[before] } else { span as f64 * dt };
        2.0 * (position[turn] - position[before]).abs() / time.powi(2)
    };
    let turns = backlash::find_reversals(position, model.encoder_step());
    let mut found: Vec<f64> = turns.iter().map(|reversal| deceleration(reversal.turn)).collect();
    found.sort_by(f64::total_cmp);
    found.truncate(GENTLEST);
    if found.len() < 3 { f64::INFINITY } else { found[found.len() / 2] }
}
