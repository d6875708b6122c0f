//! What is decided for one joint: its sweeps, and how many reversals.

use super::information::{Possible, Sensing};
use super::posture::{Posture, postures, room};
use super::question::Measurands;
use super::regulation::Regulation;
use super::strokes::{Reversing, Strokes, recordings};
use super::sweep::{self, Bounds, Sweep};
use super::uniform;
use super::{ExpectedErrors, PlannedJoint};
use nalgebra::DMatrix;

use crate::dynamics::Dynamics;
use crate::gearhead::{Exponential, FrictionLaw};
use crate::robot::Model;
use crate::scenario::reach::Reach;
use crate::scenario::rehearsal::{CONTROL_PERIOD, SPEED_SHARE, top_speed};
use crate::scenario::trial::gains;

/// [s] Rest of a recording, before the motion and after it.
pub const REST: f64 = 0.5;
/// Most reversals of a joint: eight recordings.
const MOST_REVERSALS: usize = 96;
/// Numbers of reversals up to here are tried all, beyond it multiples of six.
const EVERY: usize = 36;
/// Fewest reversals of a joint: the gap needs three, and one may be lost.
const FEWEST_REVERSALS: usize = 4;
/// [1/s] Acceleration per fastest speed: that of scenario 01.
const ACCELERATION: f64 = 1.2;
/// [rad/s or m/s] Slowest top speed: a joint that has no room for it cannot be measured.
const SLOWEST: f64 = 1e-4;
/// Factor from a top speed that needs too much room to the next one that is tried.
const SLOWER: f64 = 0.8;

/// A joint with everything that its plan depends on.
pub struct Setup {
    index: usize,
    /// The laws that are possible.
    pub possible: Possible,
    sensing: Sensing,
    /// Bounds of its sweeps.
    pub bounds: Bounds,
    /// Its strokes.
    pub strokes: Strokes,
    /// The controller of the rehearsal.
    pub regulation: Regulation,
    known: bool,
}

/// Sweeps and reversals of a joint.
#[derive(Debug, Clone)]
pub struct Course {
    /// For friction.
    pub sweep: Sweep,
    /// For the gap.
    pub reversals: usize,
}

impl Setup {
    /// Of the joint of this index; `machine` is the model with friction at every joint.
    pub fn of(model: &Model, machine: &Model, reaches: &[Reach], index: usize) -> Self {
        let (joint, reach) = (&machine.joints[index], &reaches[index]);
        let known = model.joints[index].friction.is_some();
        let flat = Exponential { coulomb: 1.0, breakaway: 1.0, stribeck_velocity: 1.0, viscous: 0.0 };
        let law = joint.friction.map_or(FrictionLaw::Exponential([flat; 2]), |friction| friction.law);
        let possible = Possible::about(&law, known);
        let limit = model.robot.bodies[index].joint.limits.velocity;
        let mut fastest = top_speed(joint.kind).min(SPEED_SHARE * limit);
        let link = inertia_at_best(model, reaches, index, possible.smallest_coulomb());
        let inertia = link + joint.reflected_inertia();
        // The tuned controller is written if the friction of every joint is known.
        let tuned = model.joints.iter().all(|joint| joint.friction.is_some());
        let regulation = if tuned {
            Regulation::tuned(&possible, inertia, fastest)
        } else {
            Regulation::with(gains(machine, reaches, index, CONTROL_PERIOD), &possible)
        };
        let lag = regulation.lag;
        let sensing = Sensing::of(joint, inertia, CONTROL_PERIOD);
        let [_, room] = room(model, reach, index);
        let bounds = |fastest: f64| {
            let acceleration = (ACCELERATION * fastest).min(reach.acceleration);
            Bounds { fastest, acceleration, room, lag }
        };
        while fastest >= SLOWEST && !sweep::fits(&sensing, &bounds(fastest)) {
            fastest *= SLOWER;
        }
        let bounds = bounds(fastest);
        let motion = Reversing { lag, inertia, acceleration: bounds.acceleration, fastest };
        Self { index, sensing, bounds, strokes: Strokes::of(joint, &possible, &motion), possible, regulation, known }
    }

    /// The best course within `seconds`; `None` if the time is too short.
    pub fn best(&self, asked: &Measurands, seconds: f64) -> Option<Course> {
        let sweeps = |time: f64| sweep::plan(&self.possible, &self.sensing, &self.bounds, time - 2.0 * REST);
        if !asked.backlash {
            return Some(Course { sweep: sweeps(seconds)?, reversals: 0 });
        }
        if !asked.friction {
            let least = sweep::shortest(&self.sensing, &self.bounds) + 2.0 * REST;
            let reversals = self.most_reversals(seconds - least)?;
            return Some(Course { sweep: sweeps(seconds - self.reversing(reversals))?, reversals });
        }
        let most = self.most_reversals(seconds)?;
        let course = |reversals: usize| {
            let sweep = sweeps(seconds - self.reversing(reversals))?;
            // ln var of the gap, but for what does not depend on the number.
            let sum = sweep.criterion - (reversals as f64).ln();
            Some((Course { sweep, reversals }, sum))
        };
        let numbers = (FEWEST_REVERSALS..=most).filter(|number| *number <= EVERY || number.is_multiple_of(6));
        let all = numbers.filter_map(course);
        all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(course, _)| course)
    }

    /// [s] The shortest course.
    pub fn shortest(&self, asked: &Measurands) -> f64 {
        let sweeps = sweep::shortest(&self.sensing, &self.bounds) + 2.0 * REST;
        if asked.backlash { sweeps + self.reversing(FEWEST_REVERSALS) } else { sweeps }
    }

    /// Whether the shortest sweeps have room.
    pub fn has_room(&self) -> bool {
        self.bounds.fastest >= SLOWEST && sweep::fits(&self.sensing, &self.bounds)
    }

    /// [s] Of the recordings with so many reversals.
    fn reversing(&self, reversals: usize) -> f64 {
        recordings(reversals).into_iter().map(|one| 2.0 * REST + self.strokes.time(one)).sum()
    }

    /// The largest number of reversals within `seconds`; `None` if there are too few.
    fn most_reversals(&self, seconds: f64) -> Option<usize> {
        (FEWEST_REVERSALS..=MOST_REVERSALS).rev().find(|&reversals| self.reversing(reversals) <= seconds)
    }

    /// The plan for the report.
    pub fn planned(&self, model: &Model, course: &Course, posture: Posture) -> PlannedJoint {
        let Course { sweep, reversals } = course;
        let strokes = if *reversals > 0 { self.reversing(*reversals) } else { 0.0 };
        let seconds = 2.0 * REST + sweep.time(&self.bounds) + strokes;
        let errors = |windows: &[_], repeats: f64, reversals: usize| {
            let [positive, negative] = self.possible.errors(&self.sensing, windows, repeats);
            let gap = self.sensing.gap_error(reversals.max(1));
            ExpectedErrors {
                friction: std::array::from_fn(|k| (0.5 * (positive[k].powi(2) + negative[k].powi(2))).sqrt()),
                gap: (reversals > 0 && gap > 0.0).then_some(gap),
            }
        };
        let uniform = uniform::of(&self.bounds, &self.sensing, &self.strokes, seconds - 2.0 * REST);
        PlannedJoint {
            joint: model.joints[self.index].name.clone(),
            friction_known: self.known,
            speeds: sweep.windows.iter().map(|window| window.speed).collect(),
            durations: sweep.durations.clone(),
            sweeps: sweep.repeats,
            reversals: *reversals,
            posture: posture.positions,
            seconds,
            expected: errors(&sweep.windows, sweep.repeats as f64, *reversals),
            uniform: uniform.map(|one| errors(&one.windows, 1.0, one.reversals)),
        }
    }
}

/// [kg·m² or kg] Inertia of a joint's link in the middle of a sweep over half of its room, in the best posture for it.
fn inertia_at_best(model: &Model, reaches: &[Reach], index: usize, friction: f64) -> f64 {
    let n = model.joints.len();
    let [_, room] = room(model, &reaches[index], index);
    let mut mass = DMatrix::zeros(n, n);
    if let Some(best) = postures(model, reaches, index, [0.5 * room, 0.0], friction).into_iter().next() {
        let mut middle = best.positions;
        middle[index] += 0.25 * room;
        Dynamics::new(&model.robot).mass_matrix(&middle, &mut mass);
    }
    mass[(index, index)]
}
