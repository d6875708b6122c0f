//! The gaps of both sides, and whether they differ: `|b_now − b_ref|` against the errors of both.
//!
//! Both sides are measured with the same estimator and nominal machine, so its bias is on both sides and cancels.

use crate::diagnose::rows::gentlest::gentlest;
use crate::effects::SymmetricFriction;
use crate::identify::backlash;
use crate::robot::Model;
use crate::timeseries::TimeSeries;
use crate::timeseries::side_by_side;

/// [1] Least scatter of single reversals, in counts of the encoder.
const LEAST_SCATTER: f64 = 0.2;
/// [1] Error common to all reversals of a recording but not to those of another, in counts of the encoder.
const SHARED: f64 = 0.1;

/// The gap of a joint on one side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideGap {
    /// [rad or m]
    pub value: f64,
    /// [rad or m]
    pub std_error: f64,
    /// [rad or m] Standard error relative to the same measurement of another recording.
    pub repeatability: f64,
    /// [1] Part of the friction on the link.
    pub link_share: Option<f64>,
    /// [1] Part of its reversals that agree on the gap.
    pub agreement: f64,
}

/// [1] Part of the reversals that have to agree on a gap before it is compared: if they scatter, the link sometimes crosses the gap before
/// the reversal.
const LEAST_AGREEMENT: f64 = 0.75;
impl SideGap {
    /// Whether two gaps may be compared.
    pub fn compares(&self, other: &Self) -> bool {
        self.agreement.min(other.agreement) >= LEAST_AGREEMENT
    }
}

/// `gaps[side][joint]`; `None` where the data do not determine the gap. Each side is first measured without a given starting point. An
/// error of the link share changes the gap, and few reversals agree if the search on one side has failed. Both sides are therefore measured
/// again with the mean of their shares, starting from the gap on which more reversals agree; an error of either is then common to both
/// sides.
pub fn both_sides(
    model: &Model,
    sessions: [&[&TimeSeries]; 2],
    friction: &[Vec<SymmetricFriction>; 2],
) -> [Vec<Option<SideGap>>; 2] {
    let dof = model.joints.len();
    let places: Vec<(usize, usize)> = (0..2).flat_map(|side| (0..dof).map(move |joint| (side, joint))).collect();
    let measure = |side: usize, joint: usize, at: Option<Start>| {
        measured(model, joint, &gentlest(model, joint, sessions[side]), friction[side][joint], at)
    };
    // Memory for the torque, its mean, the reference, and the intervals of a session.
    let samples =
        sessions.iter().map(|side| side.iter().map(|session| session.len()).sum::<usize>()).max().unwrap_or(0);
    let first = side_by_side(&places, 48 * samples, |(side, joint)| measure(*side, *joint, None));
    let start = |joint: usize| Start::of(first[joint].into_iter().chain(first[dof + joint]));
    let again = |(side, joint): &(usize, usize)| measure(*side, *joint, Some(start(*joint)?));
    let mut found = side_by_side(&places, 48 * samples, again);
    let now = found.split_off(dof);
    [found, now]
}

/// Starting point of the measurement of both sides.
#[derive(Debug, Clone, Copy)]
struct Start {
    gap: f64,
    share: f64,
}

impl Start {
    /// The gap on which most reversals agree, and the mean of the shares.
    fn of(found: impl Iterator<Item = SideGap>) -> Option<Self> {
        let found: Vec<SideGap> = found.collect();
        let best = found.iter().max_by(|a, b| a.agreement.total_cmp(&b.agreement))?;
        let shares = found.iter().filter_map(|one| one.link_share);
        let share = shares.sum::<f64>() / found.len() as f64;
        Some(Self { gap: best.value, share })
    }
}

fn measured(
    model: &Model,
    joint: usize,
    sessions: &[&TimeSeries],
    law: SymmetricFriction,
    at: Option<Start>,
) -> Option<SideGap> {
    let friction = law.on_motor();
    let known = at.map(|Start { gap, share }| (gap, share));
    let found = backlash::identify_to_compare(model, joint, sessions, &friction, known).ok()?;
    let mean = &found.best.mean;
    let link_share = found.link_share.as_ref().map(|share| share.value.clamp(0.0, 1.0));
    let values: Vec<f64> = found.best.values.iter().map(|one| one.gap).collect();
    let agreement = values.len() as f64 / (values.len() + found.best.left_out.len()).max(1) as f64;
    let gap = SideGap {
        value: mean.value.max(0.0),
        std_error: mean.std_error,
        repeatability: repeatability(&values, model.joints[joint].encoder_step()),
        link_share,
        agreement,
    };
    let known = mean.std_error.is_finite() && mean.value.is_finite();
    known.then_some(gap)
}

/// Standard error of a mean from the scatter of the values, with the least scatter of reversals as a lower bound.
fn repeatability(values: &[f64], count: f64) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n.max(1.0);
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    (variance.sqrt().max(LEAST_SCATTER * count) / n.max(1.0).sqrt()).hypot(SHARED * count)
}
