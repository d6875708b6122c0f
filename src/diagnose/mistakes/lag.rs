//! A channel that is late against another: the lag at which the torque balance fits best.
//!
//! ```text
//!   u(L) = Σ residual² / Σ τ²,   τ(t + L) against the motion at t, or τ(t) against the motion of one joint at t + L
//! ```
//! No physical effect shifts a torque in time by more than `sensor_delay` does, so on correct data `u` is smallest near `L = 0`, whatever the
//! residual is. A slow motion under weight leaves little even where a channel is late, because the torque hardly changes meanwhile; therefore
//! the share `u` itself is no criterion here. A lag is named if `Π u` over the joints is smaller than at every short lag by the factor [`GAIN`], and
//! the share of one joint by [`FACTOR`] than as recorded.
//! If the motion of one joint is late, so are the columns of the joints that it couples with; if its torque is late, only its own balance suffers.

use rayon::prelude::*;

use super::balance;
use super::balance::Columns;
use super::change::{Change, Culprit, Evidence};
use super::rows::Rows;
use super::search::{EXPLAINED, FACTOR, NEARLY};
use crate::robot::{Masses, Model};

/// [s] Lags that a sensor or a filter may cause, see `sensor_delay`.
const SHORT: [f64; 5] = [0.0, -0.05, 0.05, -0.1, 0.1];
/// [s] Lags that only a mistake causes. At half of their spacing from the true lag, a residual that grows with the square of the lag is below a
/// sixteenth of that at 0.1 s.
const LONG: [f64; 8] = [0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5];
/// Factor by which `Π u` at a long lag has to be below that at every short one. Hundreds of rows give a share of squares within a tenth; on correct
/// recordings, whatever effect they hold, the factor is 1.2 at most.
const GAIN: f64 = 2.0;
/// [1] Share of the squared torque that counts as explained, 1 % in RMS: a torque sensor is not more accurate.
const FLOOR: f64 = 1e-4;

/// Residual share of each joint [1]; `None` without torque or motion.
type Shares = Vec<Option<f64>>;

/// Changes of one kind over the lag, with their residual shares.
struct Profile {
    tried: Vec<(f64, Change, Shares)>,
}

/// The channel that is late, if one is.
pub fn best(model: &Model, rows: &[Rows]) -> Option<Culprit> {
    if model.masses == Masses::Estimated {
        return None;
    }
    let dof = model.joints.len();
    let columns = Columns::new(model, rows);
    let of_torque = |which: Option<usize>, lag: f64| {
        let change = Change::TorqueLag(which, lag);
        let shares = shares(model, &columns, &change.undone(model, rows).1);
        (lag, change, shares)
    };
    let all: Vec<(f64, Change, Shares)> = every_lag().into_par_iter().map(|lag| of_torque(None, lag)).collect();
    let mut profiles = Vec::new();
    for joint in (0..dof).filter(|joint| shifted(&all, *joint)) {
        let alone = |(lag, _, shares): &(f64, Change, Shares)| {
            let own = (0..dof).map(|k| shares[k].filter(|_| k == joint)).collect();
            (*lag, Change::TorqueLag(Some(joint), *lag), own)
        };
        profiles.push(Profile { tried: all.iter().map(alone).collect() });
        let of_motion = |lag: f64| {
            let change = Change::MotionLag(joint, lag);
            let (_, late) = change.undone(model, rows);
            (lag, change, shares_of(model, &late))
        };
        if dof > 1 {
            profiles.push(Profile { tried: every_lag().into_par_iter().map(of_motion).collect() });
        }
    }
    if dof > 1 && !profiles.is_empty() {
        profiles.push(Profile { tried: all });
    }
    let mut found: Vec<(f64, Culprit)> = profiles.iter().filter_map(Profile::culprit).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let near = found.first()?.0 - NEARLY.ln();
    let alternatives = found[1..].iter().take_while(|other| other.0 > near).map(|other| other.1.change).collect();
    let first = found.swap_remove(0).1;
    Some(Culprit { alternatives, ..first })
}

/// [s] All lags that are tried, in both directions.
fn every_lag() -> Vec<f64> {
    SHORT.into_iter().chain(LONG).chain(LONG.map(|lag| -lag)).collect()
}

/// Whether the torque of a joint fits its motion best at another time.
fn shifted(all: &[(f64, Change, Shares)], joint: usize) -> bool {
    let share = |tried: &(f64, Change, Shares)| tried.2[joint].unwrap_or(f64::INFINITY);
    all.iter().min_by(|a, b| share(a).total_cmp(&share(b))).is_some_and(|best| best.0 != 0.0)
}

fn shares_of(model: &Model, rows: &[Rows]) -> Shares {
    shares(model, &Columns::new(model, rows), rows)
}

fn shares(model: &Model, columns: &Columns, rows: &[Rows]) -> Shares {
    let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
    let bounds = balance::bounds(model);
    columns.normals(rows, &moves).iter().map(|normal| Some(normal.solve(&bounds)?.left)).collect()
}

impl Profile {
    /// The lag that only a mistake causes, if the balance needs one, and its gain `ln Π u_short/u`.
    fn culprit(&self) -> Option<(f64, Culprit)> {
        let level = |shares: &Shares| -> f64 { shares.iter().flatten().map(|share| share.max(FLOOR).ln()).sum() };
        let least = |short: bool| {
            let of_kind = self.tried.iter().filter(|(lag, ..)| SHORT.contains(lag) == short);
            of_kind.min_by(|a, b| level(&a.2).total_cmp(&level(&b.2)))
        };
        let [(_, _, were), (_, change, are)] = [least(true)?, least(false)?];
        let gain = level(were) - level(are);
        let recorded = &self.tried.iter().find(|(lag, ..)| *lag == 0.0)?.2;
        let ratio = |joint: &usize| match (recorded[*joint], are[*joint]) {
            (Some(before), Some(after)) => before / after.max(FLOOR),
            _ => 0.0,
        };
        let joint = (0..are.len()).max_by(|a, b| ratio(a).total_cmp(&ratio(b)))?;
        let (before, after) = (recorded[joint]?, are[joint]?);
        let clear = gain > GAIN.ln() && before > FACTOR * after && after < EXPLAINED;
        let evidence = Evidence::Residual([before, after].map(|share| 100.0 * share.sqrt()));
        clear.then(|| (gain, Culprit { change: *change, alternatives: Vec::new(), joint, evidence }))
    }
}
