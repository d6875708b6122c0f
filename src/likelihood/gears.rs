//! The gears that explain recordings best, sought over their whole ranges.
//!
//! Gap, share of friction behind it, and stiffness have one narrow summit together. On a machine with two soft gears (tuning seed 71001), of what the right gears
//! gain over rigid ones, a share off by 0.07 costs 50 to 90 % with little noise (`λ = 0`), a stiffness off by a fifth 45 to 60 %, a gap off by 6 % 15 to 30 %, so
//! that no search along single lines finds it. With much noise the filter keeps the track beside the summit as well: at `λ = 3` a share off by 0.1 costs
//! 15 to 35 %, of a summit that is less than half as high. So the scan goes
//!
//! ```text
//!   λ = 2.5: all of the grid   →   λ = 2: half the steps around the best   →   λ = 1: a quarter   →   λ = 0.5: an eighth   →   …
//! ```
//! Here a reading is never anywhere, however wrong a gear: that wrong gears lose their whole track marks the summit. With a share of readings that may be anywhere a soft gear's
//! gap came out 12 % too small (seed 700004).
//! All joints move along the whole grid at once. Then the most probable places of each are compared, and refined, with the gears of the others at their best:
//! where an impact of one joint is missed, the others are shaken by something that is not in the model. A fit that still misses torque goes through the
//! finer grids again, with what it has found of friction and bodies meanwhile.

use rayon::prelude::*;

use super::recording::Recording;
use super::subject::Setup;
use super::{Settings, run};
use crate::error::Result;
use crate::gearhead::{Direction, Friction};
use crate::robot::{EffectEntry, JointModel, Model};

/// `λ` of the whole grid: the summit is as wide as its steps, and still 700 to 930 nats high (10 s of tuning seed 71001).
const COARSE_NOISE: f64 = 2.5;
/// `λ` of each finer grid, its steps relative to those of the whole grid, and the number of the best places that it surrounds: with one
/// place, joint 2 of seed 71000 was lost at the first (tuning seeds 71000 to 71003).
const FINER: [(f64, f64, usize); 5] =
    [(2.0, 0.5, 4), (1.0, 0.25, 3), (0.5, 0.125, 3), (0.0, 0.0625, 2), (-0.75, 0.03125, 1)];
/// Gaps that are tried beside that of a fit before its finer grids: in steps of 4 %, 0.3 to 1.3 times its own, and their `λ`. Where friction and share are right
/// already, the gap alone may still be on a lower summit.
const OTHER_GAP: f64 = 1.04;
const OTHER_GAPS: std::ops::RangeInclusive<i32> = -31..=7;
const OTHER_NOISE: f64 = 1.0;
/// Most probable places of the whole grid that are compared again.
const SECOND_LOOK: usize = 60;
/// Finer grids that a first search goes through: friction is not known better.
const OF_FIRST: usize = 3;
/// [1] Shares of the friction behind the gap, and their step in finer grids.
const SHARES: [f64; 6] = [0.05, 0.12, 0.2, 0.3, 0.42, 0.55];
const SHARE_STEP: f64 = 0.1;
/// Ratio of a gap to the next, and where they begin and how many there are: 1.1 to 0.36 times a gap that is known without the wind-up of the gear, which it
/// contains; 2 to 44 counts of the encoder where none is known, and none.
pub(super) const GAP_RATIO: f64 = 0.87;
const GAPS: usize = 9;
const LARGEST_GAP: f64 = 1.1;
const UNKNOWN_GAPS: usize = 23;
pub(super) const LARGEST_IN_COUNTS: f64 = 44.0;
/// Ratio of a stiffness to the next, and their number: from the nominal one to 1/28 of it.
const STIFFNESS_RATIO: f64 = 0.66;
const STIFFNESSES: usize = 9;

/// The effect of a gear that is softer than in the model, and its parameter.
pub const SOFT_GEAR: &str = "joint_compliance";
/// See [`SOFT_GEAR`].
pub const STIFFNESS: &str = "stiffness";

/// What the motion through a gap depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gear {
    /// `b` [rad or m] The total gap.
    pub gap: f64,
    /// `s` [1] The share of friction behind it.
    pub share: f64,
}

/// A gear that was sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoughtGear {
    /// Its gap.
    pub gear: Gear,
    /// [N·m/rad or N/m] Its stiffness, where that was sought too.
    pub stiffness: Option<f64>,
}

impl SoughtGear {
    /// The effect of its stiffness on a joint.
    pub fn entry(&self, joint: &str) -> Option<EffectEntry> {
        let parameters = [(STIFFNESS.to_owned(), self.stiffness?)].into();
        Some(EffectEntry { effect: SOFT_GEAR.to_owned(), joint: Some(joint.to_owned()), parameters })
    }
}

/// [N·m/rad or N/m] Stiffness of a gear that does not count as soft: the model's, or one that Coulomb friction winds up by a tenth of a count.
pub fn hardly_soft(joint: &JointModel) -> f64 {
    const WOUND_UP: f64 = 0.1;
    const UNKNOWN: f64 = 1e4;
    let wind_up = WOUND_UP * joint.encoder_step();
    let coulomb = |friction: Friction| friction.law.coulomb(Direction::Positive);
    let by_friction = joint.friction.filter(|_| wind_up > 0.0).map(|friction| coulomb(friction) / wind_up);
    joint.gear_stiffness.or(by_friction.filter(|k| *k > 0.0)).unwrap_or(UNKNOWN)
}

/// The gears that explain recordings best, one per joint; with `soft` they may be softer than in the model. A gear that cannot be simulated explains nothing.
pub fn seek_gears(model: &Model, recordings: &[Recording], soft: bool, settings: &Settings) -> Vec<SoughtGear> {
    let mut model = model.clone();
    let (grids, stiffness): (Vec<_>, Vec<_>) =
        model.joints.iter().map(|joint| (grid(joint, soft), soft.then(|| hardly_soft(joint)))).unzip();
    if soft {
        let softened = |joint: &JointModel| EffectEntry {
            effect: SOFT_GEAR.to_owned(),
            joint: Some(joint.name.clone()),
            parameters: [(STIFFNESS.to_owned(), hardly_soft(joint))].into(),
        };
        let entries: Vec<EffectEntry> = model.joints.iter().map(softened).collect();
        model.effects.extend(entries);
    }
    let base = Setup { weight: 0.0, offsets: vec![0.0; model.joints.len()], model };
    let settings = &strict(settings);
    let scan = Scan { base: &base, soft: stiffness.iter().map(Option::is_some).collect(), recordings, settings };
    let first = scan.rank(grids, COARSE_NOISE);
    let some = first.iter().map(|places| places[..places.len().min(SECOND_LOOK)].to_vec()).collect();
    let ranked = scan.rank_beside(some, &firsts(&first), COARSE_NOISE);
    scan.finer(ranked, &FINER[..OF_FIRST])
}

/// The gears around those of a setup, with its `λ` at present, that explain recordings better.
pub(super) fn around(setup: &Setup, lambda: &[f64], recordings: &[Recording], settings: &Settings) -> Vec<SoughtGear> {
    let noise = lambda.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // The third grid closes the steps between the gaps that are tried.
    let first = FINER.iter().position(|(lambda, ..)| *lambda <= noise).unwrap_or(FINER.len()).min(OF_FIRST - 1);
    let joints = &setup.model.joints;
    let stiffness: Vec<Option<f64>> = joints.iter().map(|joint| stiffness(&setup.model, &joint.name)).collect();
    let place = |(joint, stiffness): (&JointModel, &Option<f64>)| {
        let share = joint.friction.map_or(0.0, |friction| friction.link_share);
        Point { gap: joint.backlash.unwrap_or(0.0), share, stiffness: stiffness.unwrap_or(1.0) }
    };
    let line = |place: &Point| OTHER_GAPS.map(|k| Point { gap: place.gap * OTHER_GAP.powi(k), ..*place }).collect();
    let places: Vec<Point> = joints.iter().zip(&stiffness).map(place).collect();
    let settings = &strict(settings);
    let scan = Scan { base: setup, soft: stiffness.iter().map(Option::is_some).collect(), recordings, settings };
    let ranked = scan.rank_beside(places.iter().map(line).collect(), &places, noise.max(OTHER_NOISE));
    scan.finer(ranked, &FINER[first..])
}

/// With no reading anywhere.
fn strict(settings: &Settings) -> Settings {
    Settings { anywhere: 0.0, ..settings.clone() }
}

/// The stiffness of a soft gear's effect.
fn stiffness(model: &Model, joint: &str) -> Option<f64> {
    let own = model.effects.iter().find(|entry| is_soft(entry, joint))?;
    own.parameters.get(STIFFNESS).copied()
}

fn is_soft(entry: &EffectEntry, joint: &str) -> bool {
    entry.effect == SOFT_GEAR && entry.joint.as_deref() == Some(joint)
}

/// A place in the grid of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    gap: f64,
    share: f64,
    stiffness: f64,
}

/// All places of a joint.
fn grid(joint: &JointModel, soft: bool) -> Vec<Point> {
    let steps = |first: f64, ratio: f64, count: usize| (0..count).map(move |k| first * ratio.powi(k as i32));
    let gaps: Vec<f64> = match joint.backlash.filter(|gap| *gap > 0.0) {
        Some(gap) => steps(LARGEST_GAP * gap, GAP_RATIO, GAPS).collect(),
        None => steps(LARGEST_IN_COUNTS * joint.encoder_step(), GAP_RATIO, UNKNOWN_GAPS).chain([0.0]).collect(),
    };
    let shares = if joint.friction.is_some() { &SHARES[..] } else { &[0.0] };
    let stiffnesses: Vec<f64> =
        steps(hardly_soft(joint), STIFFNESS_RATIO, if soft { STIFFNESSES } else { 1 }).collect();
    let pairs = gaps.iter().flat_map(|gap| shares.iter().map(move |share| (*gap, *share)));
    pairs
        .flat_map(|(gap, share)| stiffnesses.iter().map(move |stiffness| Point { gap, share, stiffness: *stiffness }))
        .collect()
}

/// Places around others, each once.
fn surroundings(places: &[Point], size: f64, soft: bool) -> Vec<Point> {
    const AROUND: [f64; 3] = [-1.0, 0.0, 1.0];
    let of_stiffness = if soft { &AROUND[..] } else { &[0.0] };
    let mut all: Vec<Point> = Vec::new();
    for place in places {
        for (gap, share) in AROUND.iter().flat_map(|gap| AROUND.map(|share| (*gap, share))) {
            for stiffness in of_stiffness {
                let point = Point {
                    gap: place.gap * GAP_RATIO.powf(size * gap),
                    share: (place.share + SHARE_STEP * size * share).clamp(0.0, 1.0),
                    stiffness: place.stiffness * STIFFNESS_RATIO.powf(size * stiffness),
                };
                if !all.iter().any(|other| other.is_near(&point)) {
                    all.push(point);
                }
            }
        }
    }
    all
}

impl Point {
    fn is_near(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs());
        near(self.gap, other.gap) && near(self.share, other.share) && near(self.stiffness, other.stiffness)
    }
}

/// The first place of each joint.
fn firsts(ranked: &[Vec<Point>]) -> Vec<Point> {
    ranked.iter().map(|places| places[0]).collect()
}

/// Places in falling order of their scores.
fn sorted(places: Vec<Point>, score: impl Fn(usize) -> f64) -> Vec<Point> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|a, b| score(*b).total_cmp(&score(*a)));
    order.into_iter().map(|k| places[k]).collect()
}

/// What is scanned.
struct Scan<'a> {
    base: &'a Setup,
    /// Whether the stiffness of a joint is sought.
    soft: Vec<bool>,
    recordings: &'a [Recording],
    settings: &'a Settings,
}

impl Scan<'_> {
    /// The best places of finer and finer grids around the first ones of each joint.
    fn finer(&self, mut ranked: Vec<Vec<Point>>, grids: &[(f64, f64, usize)]) -> Vec<SoughtGear> {
        for (lambda, size, best) in grids {
            let around = ranked.iter().zip(&self.soft);
            let around = around.map(|(places, soft)| surroundings(&places[..places.len().min(*best)], *size, *soft));
            ranked = self.rank_beside(around.collect(), &firsts(&ranked), *lambda);
        }
        let sought = |(joint, places): (usize, &Vec<Point>)| SoughtGear {
            gear: Gear { gap: places[0].gap, share: places[0].share },
            stiffness: self.soft[joint].then_some(places[0].stiffness),
        };
        ranked.iter().enumerate().map(sought).collect()
    }

    /// The places of each joint, the most probable one first; all joints are moved at once.
    fn rank(&self, places: Vec<Vec<Point>>, lambda: f64) -> Vec<Vec<Point>> {
        let most = places.iter().map(Vec::len).max().unwrap_or(0);
        let at = |k: usize| -> Vec<Point> { places.iter().map(|places| places[k % places.len()]).collect() };
        let scores: Vec<Vec<f64>> = (0..most).into_par_iter().map(|k| self.score(&at(k), lambda)).collect();
        places.into_iter().enumerate().map(|(joint, places)| sorted(places, |k| scores[k][joint])).collect()
    }

    /// The same, while the gears of the other joints stay.
    fn rank_beside(&self, places: Vec<Vec<Point>>, gears: &[Point], lambda: f64) -> Vec<Vec<Point>> {
        let beside = |(joint, places): (usize, Vec<Point>)| {
            let with = |place: &Point| -> Vec<Point> {
                gears.iter().enumerate().map(|(other, gear)| if other == joint { *place } else { *gear }).collect()
            };
            let scores: Vec<f64> =
                places.par_iter().map(|place| self.score(&with(place), lambda).iter().sum()).collect();
            sorted(places, |k| scores[k])
        };
        places.into_iter().enumerate().map(beside).collect()
    }

    /// [nat] of each joint; −∞ where these gears cannot be simulated.
    fn score(&self, places: &[Point], lambda: f64) -> Vec<f64> {
        self.nats(places, lambda).unwrap_or_else(|_| vec![f64::NEG_INFINITY; places.len()])
    }

    fn nats(&self, places: &[Point], lambda: f64) -> Result<Vec<f64>> {
        let setup = self.setup(places);
        let lambda = vec![lambda; places.len()];
        let mut sum = vec![0.0; places.len()];
        for recording in self.recordings {
            let outcome = run(&setup, recording, &lambda, self.settings, false)?;
            sum.iter_mut().zip(&outcome.nats).for_each(|(sum, nats)| *sum += nats);
        }
        Ok(sum)
    }

    fn setup(&self, places: &[Point]) -> Setup {
        let mut setup = self.base.clone();
        let Model { joints, effects, .. } = &mut setup.model;
        for ((joint, point), soft) in joints.iter_mut().zip(places).zip(&self.soft) {
            joint.backlash = Some(point.gap);
            joint.friction.iter_mut().for_each(|friction| friction.link_share = point.share);
            for entry in effects.iter_mut().filter(|entry| *soft && is_soft(entry, &joint.name)) {
                entry.parameters.insert(STIFFNESS.to_owned(), point.stiffness);
            }
        }
        setup
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_no_place_is_tried_twice() {
        let place = |share: f64| Point { gap: 0.01, share, stiffness: 300.0 };
        // The second place is in the surroundings of the first.
        assert_eq!(surroundings(&[place(0.3), place(0.35)], 0.5, false).len(), 12);
        assert_eq!(surroundings(&[place(0.3)], 0.5, false).len(), 9);
    }
}
