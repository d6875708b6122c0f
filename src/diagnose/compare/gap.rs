//! The gap on both sides, and whether they differ: `|b_now − b_ref|` against the errors of both.
//!
//! Both sides are measured with one estimator and one nominal machine, so that its bias is on both and cancels.

use rayon::prelude::*;

use crate::effects::SymmetricFriction;
use crate::gearhead::{Exponential, Friction, FrictionLaw};
use crate::identify::backlash;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};

/// [s] Stretch before a turn over which the deceleration is taken.
const BRAKING: f64 = 0.1;
/// Reversals that a session is judged by: as many as its gap is taken from.
const GENTLEST: usize = 12;
/// Factor on the deceleration of the gentlest session up to which another counts as gentle too.
const AS_GENTLE: f64 = 2.0;

/// The gap of a joint on one side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// [rad or m]
    pub value: f64,
    /// [rad or m]
    pub std_error: f64,
    /// [1] part of the friction on the link.
    pub link_share: Option<f64>,
    /// [1] part of its reversals that agree on it.
    pub agreement: f64,
}

/// [1] Part of the reversals that has to agree on a gap before it is compared: where they scatter, some cross it by themselves.
const LEAST_AGREEMENT: f64 = 0.75;
/// [1] How far the link shares of both sides may be apart: it is one machine, and what a fit puts into the share it takes from the gap.
const SAME_SHARE: f64 = 0.1;

impl Gap {
    /// Whether two gaps may be compared.
    pub fn compares(&self, other: &Self) -> bool {
        let same_share = match (self.link_share, other.link_share) {
            (Some(own), Some(other)) => (own - other).abs() < SAME_SHARE,
            _ => false,
        };
        same_share && self.agreement.min(other.agreement) >= LEAST_AGREEMENT
    }
}

/// A gap with the reversals that agree on it.
struct Candidate {
    gap: Gap,
    agreeing: usize,
}

/// `gaps[side][joint]`; `None` where the data do not tell. Each side is sought anywhere and near what the other side shows, and what
/// more reversals agree on is taken: a search of one side alone now and then ends at a gap that few of them share.
pub fn both_sides(
    model: &Model,
    sessions: [&[&TimeSeries]; 2],
    friction: &[Vec<SymmetricFriction>; 2],
) -> [Vec<Option<Gap>>; 2] {
    let dof = model.joints.len();
    let places: Vec<(usize, usize)> = (0..2).flat_map(|side| (0..dof).map(move |joint| (side, joint))).collect();
    let measure = |side: usize, joint: usize, near: Option<f64>| {
        measured(model, joint, &gentlest(model, joint, sessions[side]), friction[side][joint], near)
    };
    let first: Vec<Option<Candidate>> = places.par_iter().map(|(side, joint)| measure(*side, *joint, None)).collect();
    let second = |(side, joint): &(usize, usize)| {
        let own = first[side * dof + joint].as_ref();
        let other = first[(1 - side) * dof + joint].as_ref();
        let again = other.and_then(|other| measure(*side, *joint, Some(other.gap.value)));
        match (own, again) {
            (Some(own), Some(again)) if again.agreeing > own.agreeing => Some(again.gap),
            (Some(own), _) => Some(own.gap),
            (None, again) => again.map(|again| again.gap),
        }
    };
    let mut found: Vec<Option<Gap>> = places.par_iter().map(second).collect();
    let now = found.split_off(dof);
    [found, now]
}

fn measured(
    model: &Model,
    joint: usize,
    sessions: &[&TimeSeries],
    law: SymmetricFriction,
    near: Option<f64>,
) -> Option<Candidate> {
    let side = Exponential {
        coulomb: law.coulomb,
        breakaway: law.breakaway,
        stribeck_velocity: law.stribeck_velocity,
        viscous: law.viscous,
    };
    let friction = Friction { law: FrictionLaw::Exponential([side; 2]), link_share: 0.0 };
    let found = match near {
        None => backlash::identify(model, joint, sessions, &friction).ok()?,
        Some(near) => backlash::identify_near(model, joint, sessions, &friction, near).ok()?,
    };
    let mean = &found.best.mean;
    let link_share = found.link_share.as_ref().map(|share| share.value.clamp(0.0, 1.0));
    let (agreeing, left_out) = (found.best.values.len(), found.best.left_out.len());
    let agreement = agreeing as f64 / (agreeing + left_out).max(1) as f64;
    let gap = Gap { value: mean.value.max(0.0), std_error: mean.std_error, link_share, agreement };
    let known = mean.std_error.is_finite() && mean.value.is_finite();
    known.then_some(Candidate { gap, agreeing })
}

/// The sessions in which a joint turns around most gently. Where a motor brakes harder than the link's own friction does, the link
/// leaves its flank and crosses the gap by itself: such turns agree well with a gap that is none, or twice as wide.
pub fn gentlest<'s>(model: &Model, joint: usize, sessions: &[&'s TimeSeries]) -> Vec<&'s TimeSeries> {
    let braking: Vec<f64> = sessions.iter().map(|session| braking(model, joint, session)).collect();
    let least = braking.iter().copied().fold(f64::INFINITY, f64::min);
    let gentle = sessions.iter().zip(braking).filter(|(_, braking)| *braking <= AS_GENTLE * least);
    gentle.map(|(session, _)| *session).collect()
}

/// [rad/s² or m/s²] Median deceleration of a session's gentlest turns; infinite where there are too few.
fn braking(model: &Model, joint: usize, session: &TimeSeries) -> f64 {
    let model = &model.joints[joint];
    let position = session.joint(&model.name).and_then(|series| series.get(Channel::Position));
    let (Some(position), dt) = (position, session.sample_interval()) else { return f64::INFINITY };
    let span = (BRAKING / dt).round().max(1.0) as usize;
    // From q(t − T) = q − a T²/2.
    let deceleration = |turn: usize| {
        let before = position[turn.saturating_sub(span)];
        2.0 * (position[turn] - before).abs() / (span as f64 * dt).powi(2)
    };
    let turns = backlash::find_reversals(position, model.encoder_step());
    let mut found: Vec<f64> = turns.iter().map(|reversal| deceleration(reversal.turn)).collect();
    found.sort_by(f64::total_cmp);
    found.truncate(GENTLEST);
    if found.len() < 3 { f64::INFINITY } else { found[found.len() / 2] }
}
