//! Gaps that vary with the angle, sought over all their harmonics by what other gaps score where.
//!
//! ```text
//!   b(θ) = b + a cos(n θ + φ)
//!   L(b, a, n, φ) ≈ Σ_k ℓ_k(b(θ_k)/c(θ_k)) = Σ_θ T(b(θ)/c(θ), θ),      T(f, θ) = Σ_{k: θ_k = θ} ℓ_k(f)
//! ```
//! `ℓ_k(f)` [nat]: score of reading `k` under the gap `f c(θ)`. A reading depends on the gap where the gear just is, and hardly on what it was elsewhere, since readings in between
//! have corrected the state: on tuning seeds 71000 and 71001 the table's score of the true gap is within 50 of 1500 to 1900 nats of that of a simulation. So a run for each of some
//! factors `f` says of all harmonics, amplitudes and phases what they would score. The best ones are then simulated.
//! First `c` is constant, and much noise leaves the track to wrong gaps. Then it is the best gap of each order so far, with smaller steps and less noise. Joints are sought in turn,
//! each beside what was found of the others.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::gears::{GAP_RATIO, LARGEST_IN_COUNTS};
use super::recording::Recording;
use super::subject::Setup;
use super::{Fitted, Settings, run};
use crate::robot::{EffectEntry, JointModel, Model};

/// The effect of a gap that varies.
pub const UNEVEN_GAP: &str = "position_dependent_backlash";
/// `n` that are sought: an eccentric gear has one period a turn, wear over a working range two or three.
pub const ORDERS: [f64; 3] = [1.0, 2.0, 3.0];
/// `λ` of the passes, and the steps of their gaps relative to those of the grid; the first pass goes along all of the grid. With them, and the numbers below, the
/// right orders came first on two of three tuning machines beside the first friction, and on all three in a judgement (seeds 71000 to 71002).
const PASSES: [(f64, Option<f64>); 3] = [(2.0, None), (1.0, Some(0.5)), (0.0, Some(FINEST))];
const FINEST: f64 = 0.25;
/// Largest gap over the larger one that regression and fit found, and the number of steps to the least, 0.26 times that: what was found constant may be the gap
/// of any angle.
const LARGEST: f64 = 1.6;
const STEPS: i32 = 13;
/// The same from [`LARGEST_IN_COUNTS`] where no gap is known, down to two counts.
const UNKNOWN_STEPS: i32 = 22;
/// Steps to both sides of a gap in a finer pass.
const AROUND: i32 = 6;
/// `a/b` [1] that are sought, their step, and the number of `φ`.
const AMPLITUDES: [f64; 5] = [0.15, 0.3, 0.45, 0.6, 0.75];
const AMPLITUDE_STEP: f64 = 0.15;
const PHASES: i32 = 16;
/// Parts of the way of a joint in a table: a thirtieth of a radian over a whole turn, small against a period.
const ANGLES: usize = 200;
/// Places of each order that are simulated, and how far they are from each other at least: two steps of the phase [rad], or more than one of the gap.
const SIMULATED: usize = 4;
const APART: f64 = 0.6;
/// [1] Shares of friction behind the gap around that of a fit: fits without a varying gap were off by 0.01 to 0.02 (seed 71002).
const SHARES_AROUND: [f64; 3] = [0.0, -0.01, 0.01];
/// Halvings of the steps in a table.
const HALVINGS: i32 = 4;

/// A gap that varies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnevenGap {
    /// `b` [rad or m] Its mean over a turn.
    pub gap: f64,
    /// `a` [rad or m].
    pub amplitude: f64,
    /// `n` [1] Periods per turn.
    pub order: f64,
    /// `φ` [rad] in (−π, π].
    pub phase: f64,
}

/// Whether an effect is the varying gap of a joint.
pub(super) fn is_of(entry: &EffectEntry, joint: &str) -> bool {
    entry.effect == UNEVEN_GAP && entry.joint.as_deref() == Some(joint)
}

impl UnevenGap {
    const fn constant(gap: f64) -> Self {
        Self { gap, amplitude: 0.0, order: 1.0, phase: 0.0 }
    }

    /// The last one of a joint in a model.
    fn of(model: &Model, joint: usize) -> Option<Self> {
        let JointModel { name, backlash, .. } = &model.joints[joint];
        let entry = model.effects.iter().rev().find(|entry| is_of(entry, name))?;
        let value = |parameter: &str| entry.parameters.get(parameter).copied().unwrap_or(0.0);
        let [amplitude, order, phase] = ["amplitude", "order", "phase"].map(value);
        Some(Self { gap: (*backlash)?, amplitude, order, phase })
    }

    fn at(&self, theta: f64) -> f64 {
        (self.gap + self.amplitude * (self.order * theta + self.phase).cos()).max(0.0)
    }

    /// The same shape, larger by a factor.
    fn scaled(&self, factor: f64) -> Self {
        Self { gap: factor * self.gap, amplitude: factor * self.amplitude, ..*self }
    }

    /// Another mean with the same shape, share of the amplitude, or phase.
    fn moved(&self, [gap, share, phase]: [f64; 3]) -> Self {
        let all = self.scaled(GAP_RATIO.powf(-gap));
        let share = (all.amplitude / all.gap + AMPLITUDE_STEP * share).clamp(0.0, 1.0);
        let turned = all.phase + TAU / f64::from(PHASES) * phase;
        Self { amplitude: share * all.gap, phase: turned.sin().atan2(turned.cos()), ..all }
    }

    /// Its effect on a joint.
    pub fn entry(&self, joint: &str) -> EffectEntry {
        let values = [("amplitude", self.amplitude), ("order", self.order), ("phase", self.phase)];
        EffectEntry {
            effect: UNEVEN_GAP.to_owned(),
            joint: Some(joint.to_owned()),
            parameters: values.map(|(name, value)| (name.to_owned(), value)).into(),
        }
    }

    fn is_near(&self, other: &Self) -> bool {
        let phase = (self.phase - other.phase).abs();
        phase.min(TAU - phase) < APART && (self.gap / other.gap).ln().abs() < -1.5 * GAP_RATIO.ln()
    }
}

/// Gaps of each joint of a fitted machine that explain recordings best, if they vary: one of each order, the most probable one first; `given`: the machine
/// before it was fitted.
pub fn seek_uneven_gaps(
    fitted: &Fitted,
    given: &Model,
    recordings: &[Recording],
    settings: &Settings,
) -> Vec<Vec<UnevenGap>> {
    let mut setup = fitted.setup();
    let joints = setup.model.joints.iter().zip(&given.joints);
    let largest: Vec<Option<f64>> = joints
        .map(|(fitted, given)| [fitted, given].into_iter().filter_map(|joint| joint.backlash).reduce(f64::max))
        .collect();
    let mut found: Vec<Vec<UnevenGap>> = vec![Vec::new(); setup.model.joints.len()];
    for (noise, size) in PASSES {
        for (joint, found) in found.iter_mut().enumerate() {
            let search = Search { setup: &setup, joint, recordings, noise, settings };
            let places = match size {
                None => search.on_the_grid(largest[joint]),
                Some(size) => found.iter().flat_map(|place| search.around(place, size)).collect(),
            };
            *found = search.best_of_each_order(places);
            if let Some(first) = found.first() {
                setup = search.with(first);
            }
        }
    }
    found
}

/// Better gaps around those of a setup that vary, with the shares of friction behind them: joint by joint, each beside the others; `None` of a gap that does not vary.
pub(super) fn around(
    setup: &Setup,
    lambda: &[f64],
    recordings: &[Recording],
    settings: &Settings,
) -> Vec<Option<(f64, UnevenGap)>> {
    let noise = lambda.iter().copied().fold(0.0, f64::max);
    let mut setup = setup.clone();
    let better = |joint: usize| {
        let own = UnevenGap::of(&setup.model, joint)?;
        let share = setup.model.joints[joint].friction.map_or(0.0, |friction| friction.link_share);
        let mut best: Option<(f64, Setup, (f64, UnevenGap))> = None;
        for share in SHARES_AROUND.map(|step| (share + step).clamp(0.0, 1.0)) {
            let mut beside = setup.clone();
            beside.model.joints[joint].friction.iter_mut().for_each(|friction| friction.link_share = share);
            let search = Search { setup: &beside, joint, recordings, noise, settings };
            for place in search.around(&own, FINEST) {
                let score = search.score(&place);
                if best.as_ref().is_none_or(|best| score > best.0) {
                    best = Some((score, search.with(&place), (share, place)));
                }
            }
        }
        let (_, with, found) = best?;
        setup = with;
        Some(found)
    };
    (0..lambda.len()).map(better).collect()
}

/// What is sought of one joint.
struct Search<'a> {
    setup: &'a Setup,
    joint: usize,
    recordings: &'a [Recording],
    noise: f64,
    settings: &'a Settings,
}

impl Search<'_> {
    /// Some places of each order, from constant gaps over their whole range, beside a gap that was found constant; none where such a machine cannot be simulated.
    fn on_the_grid(&self, found: Option<f64>) -> Vec<UnevenGap> {
        let step = self.setup.model.joints[self.joint].encoder_step();
        let (largest, steps) = match found.filter(|gap| *gap > 0.0) {
            Some(gap) => (LARGEST * gap, STEPS),
            None => (LARGEST_IN_COUNTS * step, UNKNOWN_STEPS),
        };
        if largest <= 0.0 {
            return Vec::new();
        }
        let factors: Vec<f64> = (0..=steps).map(|k| GAP_RATIO.powi(k)).collect();
        let means: Vec<f64> = factors.iter().map(|factor| factor * largest).collect();
        let table = self.table(UnevenGap::constant(largest), factors);
        table.iter().flat_map(|table| ORDERS.iter().flat_map(|order| table.best(*order, &means))).collect()
    }

    /// A place, and a better one around it by what gaps of its shape score; `size`: of the steps.
    fn around(&self, place: &UnevenGap, size: f64) -> Vec<UnevenGap> {
        let factors = (-AROUND..=AROUND).map(|k| GAP_RATIO.powf(size * f64::from(k))).collect();
        let better = self.table(*place, factors).map(|table| table.climb(*place, size));
        [*place].into_iter().chain(better).collect()
    }

    /// The best place of each order, the most probable one first.
    fn best_of_each_order(&self, places: Vec<UnevenGap>) -> Vec<UnevenGap> {
        let scores: Vec<f64> = places.par_iter().map(|place| self.score(place)).collect();
        let mut ranked: Vec<(f64, UnevenGap)> = scores.into_iter().zip(places).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut best: Vec<UnevenGap> = Vec::new();
        for (_, place) in ranked {
            if best.iter().all(|other| other.order != place.order) {
                best.push(place);
            }
        }
        best
    }

    /// What gaps of the shape of `base` score, larger by these factors.
    fn table(&self, base: UnevenGap, factors: Vec<f64>) -> Option<Table> {
        let angles = Angles::of(self.recordings, self.joint);
        let row = |factor: &f64| self.by_angle(&self.with(&base.scaled(*factor)), &angles);
        let rows: Option<Vec<Vec<f64>>> = factors.par_iter().map(row).collect();
        Some(Table { angles, base, factors, rows: rows? })
    }

    /// [nat] by angle; `None` of a machine that cannot be simulated.
    fn by_angle(&self, setup: &Setup, angles: &Angles) -> Option<Vec<f64>> {
        let mut row = vec![0.0; ANGLES];
        for recording in self.recordings {
            let outcome = run(setup, recording, &self.lambda(), self.settings, true).ok()?;
            let from = recording.first_scored(self.joint, self.settings.burn_in);
            let readings = recording.joints[self.joint].position.iter().zip(&outcome.scored[self.joint]);
            readings.skip(from).for_each(|(theta, scored)| row[angles.part(*theta)] += scored.said.nats);
        }
        Some(row)
    }

    /// [nat] of all joints; −∞ of a machine that cannot be simulated.
    fn score(&self, place: &UnevenGap) -> f64 {
        let setup = self.with(place);
        let score = |recording: &Recording| {
            run(&setup, recording, &self.lambda(), self.settings, false)
                .map_or(f64::NEG_INFINITY, |outcome| outcome.nats.iter().sum())
        };
        self.recordings.iter().map(score).sum()
    }

    fn lambda(&self) -> Vec<f64> {
        vec![self.noise; self.setup.model.joints.len()]
    }

    /// The machine with this gap.
    fn with(&self, place: &UnevenGap) -> Setup {
        let mut setup = self.setup.clone();
        let joint = &mut setup.model.joints[self.joint];
        joint.backlash = Some(place.gap);
        setup.model.effects.retain(|entry| !is_of(entry, &joint.name));
        setup.model.effects.extend((place.amplitude > 0.0).then(|| place.entry(&joint.name)));
        setup
    }
}

/// Equal parts of the way of a joint.
struct Angles {
    first: f64,
    step: f64,
}

impl Angles {
    fn of(recordings: &[Recording], joint: usize) -> Self {
        let all = recordings.iter().flat_map(|recording| &recording.joints[joint].position).copied();
        let (first, last) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (x.min(a), x.max(b)));
        Self { first, step: ((last - first) / ANGLES as f64).max(f64::MIN_POSITIVE) }
    }

    fn part(&self, theta: f64) -> usize {
        (((theta - self.first) / self.step) as usize).min(ANGLES - 1)
    }

    fn middles(&self) -> impl Iterator<Item = f64> {
        (0..ANGLES).map(|part| self.first + (part as f64 + 0.5) * self.step)
    }
}

/// `T`: a row for each factor, in falling order with equal ratios.
struct Table {
    angles: Angles,
    /// `c`.
    base: UnevenGap,
    factors: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    /// `L` of a gap; between factors `T` is interpolated by their logarithms, beyond them it stays.
    fn score(&self, place: &UnevenGap) -> f64 {
        let step = (self.factors[1] / self.factors[0]).ln();
        let last = self.factors.len() - 1;
        let parts = self.angles.middles().enumerate().map(|(part, theta)| {
            let factor = place.at(theta) / self.base.at(theta).max(f64::MIN_POSITIVE);
            let row = ((factor / self.factors[0]).ln() / step).clamp(0.0, last as f64);
            let above = (row as usize).min(last - 1);
            let share = row - above as f64;
            (1.0 - share) * self.rows[above][part] + share * self.rows[above + 1][part]
        });
        parts.sum()
    }

    /// The best places of an order that are not near each other, with these means.
    fn best(&self, order: f64, means: &[f64]) -> Vec<UnevenGap> {
        let phases = (0..PHASES).map(|k| TAU * f64::from(k + 1) / f64::from(PHASES) - PI);
        let shapes: Vec<(f64, f64)> = phases.flat_map(|phase| AMPLITUDES.map(|share| (phase, share))).collect();
        let place = |gap: &f64| {
            let gap = *gap;
            shapes.iter().map(move |(phase, share)| UnevenGap { gap, amplitude: share * gap, order, phase: *phase })
        };
        let places: Vec<UnevenGap> = means.iter().flat_map(place).collect();
        let mut ranked: Vec<(f64, UnevenGap)> =
            places.into_par_iter().map(|place| (self.score(&place), place)).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut best: Vec<UnevenGap> = Vec::new();
        for (_, place) in ranked {
            if best.len() < SIMULATED && !best.iter().any(|other| other.is_near(&place)) {
                best.push(place);
            }
        }
        best.into_iter().map(|place| self.climb(place, 0.5)).collect()
    }

    /// The summit above a place, by steps of mean, amplitude and phase, alone and together: on their ridge none of them gains alone. `size`: of the first
    /// steps, relative to those of the grid.
    fn climb(&self, mut place: UnevenGap, size: f64) -> UnevenGap {
        let mut here = self.score(&place);
        for halving in 0..HALVINGS {
            let step = size * 0.5_f64.powi(halving);
            loop {
                // −1, 0 or 1 step of each.
                let ways =
                    (0..27).map(|way| place.moved([way, way / 3, way / 9].map(|way| step * f64::from(way % 3 - 1))));
                let scored = ways.map(|place| (self.score(&place), place));
                match scored.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|best| best.0 > here + 1e-6) {
                    Some(better) => (here, place) = better,
                    None => break,
                }
            }
        }
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A table with a parabola in the logarithm around the true gap of each angle.
    fn table(truth: &UnevenGap, base: UnevenGap, factors: Vec<f64>) -> Table {
        let angles = Angles { first: -1.2, step: 2.5 / ANGLES as f64 };
        let row = |factor: &f64| {
            angles.middles().map(|theta| -((factor * base.at(theta) / truth.at(theta)).ln()).powi(2)).collect()
        };
        let rows = factors.iter().map(row).collect();
        Table { angles, base, factors, rows }
    }

    fn assert_near(found: &UnevenGap, truth: &UnevenGap, steps: f64) {
        assert!((found.gap / truth.gap).ln().abs() <= -steps * GAP_RATIO.ln(), "{found:?}");
        assert!((found.phase - truth.phase).abs() <= steps * TAU / f64::from(PHASES), "{found:?}");
        assert!(
            (found.amplitude / found.gap - truth.amplitude / truth.gap).abs() < steps * AMPLITUDE_STEP,
            "{found:?}"
        );
    }

    #[test]
    fn recover_a_gap_that_varies_from_the_scores_of_others() {
        let truth = UnevenGap { gap: 0.006, amplitude: 0.0027, order: 2.0, phase: -0.8 };
        let factors: Vec<f64> = (0..=STEPS).map(|k| GAP_RATIO.powi(k)).collect();
        let means: Vec<f64> = factors.iter().map(|factor| 0.0105 * factor).collect();
        let coarse = table(&truth, UnevenGap::constant(0.0105), factors);
        let best = coarse.best(2.0, &means);
        assert_eq!(best.len(), SIMULATED);
        // Interpolated between gaps of 13 %, a parabola is cut off by (0.14/2)² at most: half a step of each.
        assert_near(&best[0], &truth, 0.5);
        let other = coarse.best(3.0, &means)[0];
        assert!(coarse.score(&best[0]) > coarse.score(&other), "{best:?} {other:?}");
        let factors = (-AROUND..=AROUND).map(|k| GAP_RATIO.powf(0.25 * f64::from(k))).collect();
        // Steps of a quarter: half of that.
        assert_near(&table(&truth, best[0], factors).climb(best[0], 0.25), &truth, 0.125);
    }

    #[test]
    fn analytic_score_of_a_factor_is_its_row() {
        let base = UnevenGap { gap: 0.006, amplitude: 0.0027, order: 2.0, phase: -0.8 };
        let factors: Vec<f64> = (-1..=1).map(|k| GAP_RATIO.powi(k)).collect();
        let mut table = table(&base, base, factors.clone());
        table.rows = (0..3).map(|k| vec![-f64::from(k + 1); ANGLES]).collect();
        for (row, factor) in factors.into_iter().enumerate() {
            // Rounding of logarithms, times the number of parts.
            assert!((table.score(&base.scaled(factor)) + (row + 1) as f64 * ANGLES as f64).abs() < 1e-9);
        }
    }
}
