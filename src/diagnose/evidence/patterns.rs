//! Patterns: shapes without physics that a residual may have when no effect of the catalogue explains it.
//!
//! A *smooth* pattern is one column: a Legendre polynomial `P_k` of the joint's angle (scaled to its range), a ramp at one end of the range, a
//! power of speed, acceleration, load, friction at low speed, time within a session, or the motion of another joint; each either equal in
//! both directions of motion or with the sign `s` of the direction. A *periodic* pattern is a harmonic of the motor angle, equal in both
//! directions, times `s`, or proportional to the torque. Patterns are fitted and judged like effects, on rows that were not used for their
//! fit. They are in no catalogue: they describe a shape, not a cause.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use crate::diagnose::fit::term::Term;
use crate::effects::{About, Action, Diagnosable, Effect, Harmonic, JointMotion, Kind, Motion, Scope};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "pattern",
    summary: "A shape that the residual has.",
    equation: "τ = Σ c column",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[],
    signature: "",
    look_alikes: &[],
    separate_by: "",
    reference: "",
};

/// Highest power of the joint's angle.
const DEGREE: usize = 3;
/// Highest order of the motor angle that is tried, in periods per turn.
const HIGHEST_ORDER: f64 = 12.0;
/// Number of periods that a joint has to cover for a wave to differ from a curve: one period, which any curve fits, and half a period more.
pub const COVERED: f64 = 1.5;
/// Largest number of orders that are tried.
const MOST_ORDERS: usize = 1500;

/// One column; its number is the first entry of the shape.
pub struct Smooth;
/// A harmonic; its order is the first entry of the shape [1/rad or 1/m of joint motion].
pub enum Periodic {
    /// Equal in both directions.
    Alike,
    /// With the sign of the direction of motion.
    WithDirection,
    /// Proportional to the torque.
    WithTorque,
}

/// Every kind of harmonic.
pub static PERIODIC: [Periodic; 3] = [Periodic::Alike, Periodic::WithDirection, Periodic::WithTorque];

/// Orders to try on a joint, starting with one period in its range.
pub fn orders(motion: &Motion, joint: usize) -> Vec<f64> {
    let range = motion.range(joint).max(1e-9);
    let (lowest, step) = (TAU / range, PI / (3.0 * range));
    let highest = HIGHEST_ORDER * motion.model.joints[joint].gear_ratio;
    let count = (((highest - lowest) / step).max(0.0) as usize).min(MOST_ORDERS);
    (0..count).map(|index| lowest + step * index as f64).collect()
}

/// All smooth columns of a joint, with descriptions.
pub fn smooth(motion: &Motion, joint: usize) -> Vec<(String, Vec<f64>)> {
    let m = &motion.joints[joint];
    let of = |value: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..motion.rows()).map(value).collect() };
    let x = scaled(&m.q);
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    let mut both = |words: &str, column: Vec<f64>| {
        let directed = column.iter().zip(&m.direction).map(|(x, s)| x * s).collect();
        columns.push((format!("{words}, turning with the direction"), directed));
        columns.push((format!("{words}, both directions alike"), column));
    };
    for degree in 1..=DEGREE {
        both(&format!("a curve of degree {degree} in the joint's angle"), of(&|row| legendre(degree, x[row])));
    }
    for (power, words) in [(2, "growing with the square of speed"), (3, "growing with the cube of speed")] {
        both(words, of(&|row| m.v[row].abs().powi(power)));
    }
    let fastest = m.v.iter().fold(1e-12_f64, |most, v| most.max(v.abs()));
    for part in [200.0, 60.0, 20.0] {
        let speed = fastest / part;
        both("only at low speed", of(&|row| (-m.v[row].abs() / speed).exp()));
    }
    both("growing with the load", of(&|row| m.link_torque[row].abs()));
    both("drifting with time within a session", of(&|row| motion.since_start(row)));
    let fades = of(&|row| m.v[row].abs() * (-motion.since_start(row) / FADES).exp());
    both("in proportion to speed, fading within a session", fades);
    for place in [0.4, 0.6, 0.8] {
        for (words, sign) in [("above", 1.0), ("below", -1.0)] {
            let beyond = of(&|row| (sign * x[row] - place).max(0.0));
            columns
                .push((format!("growing {words} {:.0} % of the joint's range", 50.0 * (1.0 + sign * place)), beyond));
        }
    }
    // With the sign of the direction these two are Coulomb and viscous friction, which the baseline contains.
    columns.push(("constant, both directions alike".to_owned(), vec![1.0; motion.rows()]));
    columns.push(("in proportion to speed, both directions alike".to_owned(), of(&|row| m.v[row].abs())));
    columns.push(("in proportion to the joint's own acceleration".to_owned(), m.a.clone()));
    columns.push(("in proportion to the load".to_owned(), m.link_torque.clone()));
    for other in motion.joints.iter().enumerate().filter(|(other, _)| *other != joint).map(|(_, other)| other) {
        let y = scaled(&other.q);
        let mut add = |words: &str, column: Vec<f64>| columns.push((format!("{words} of another joint"), column));
        add("in proportion to the angle", y.clone());
        add("in proportion to the product with the angle", of(&|row| x[row] * y[row]));
        add("in proportion to the acceleration", other.a.clone());
        add("in proportion to the square of the speed", of(&|row| other.v[row].powi(2)));
    }
    columns
}

/// The curves over the stroke of a joint, in either direction of its motion: the first of the [smooth] columns.
pub fn curves(motion: &Motion, joint: usize) -> Vec<Term> {
    (0..2 * DEGREE).map(|index| Term::new(motion, &Smooth, &[joint], vec![index as f64])).collect()
}

/// [s] Time constant of falling friction.
const FADES: f64 = 40.0;

/// Scales values to the range −1 to 1.
fn scaled(values: &[f64]) -> Vec<f64> {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    let half = (0.5 * (high - low)).max(1e-12);
    values.iter().map(|x| (x - 0.5 * (low + high)) / half).collect()
}

fn legendre(degree: usize, x: f64) -> f64 {
    match degree {
        0 => 1.0,
        1 => x,
        2 => 1.5 * x * x - 0.5,
        _ => 2.5 * x.powi(3) - 1.5 * x,
    }
}

impl Effect for Smooth {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, _: &mut Model, _: Option<usize>, _: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        Ok(Vec::new())
    }
}

impl Diagnosable for Smooth {
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        vec![smooth(motion, joint).swap_remove(shape[0] as usize).1]
    }

    fn parameters(&self, _: &Motion, _: usize, _: &[f64], _: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}

impl Periodic {
    /// Amplitude of the harmonic in a row.
    pub fn amplitude(&self, m: &JointMotion, row: usize) -> f64 {
        match self {
            Self::Alike => 1.0,
            Self::WithDirection => m.direction[row],
            Self::WithTorque => m.torque[row],
        }
    }

    /// The description at an order of the angle of a joint that moves through `range` [rad or m]. A period that the joint does not cover
    /// [`COVERED`] times is not identified as a period: it is a shape of the whole stroke.
    pub fn words(&self, order: f64, gear_ratio: f64, range: f64) -> String {
        let period = TAU * gear_ratio / order / crate::units::DEG;
        let kind = match self {
            Self::Alike => "both directions alike",
            Self::WithDirection => "turning with the direction",
            Self::WithTorque => "in proportion to the torque",
        };
        if order * range < COVERED * TAU {
            return format!("a slow curve over the whole stroke of the joint, {kind}");
        }
        format!("period of {period:.1}° of motor angle, {kind}")
    }
}

impl Effect for Periodic {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, _: &mut Model, _: Option<usize>, _: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        Ok(Vec::new())
    }
}

impl Diagnosable for Periodic {
    fn harmonic(&self) -> Option<Harmonic> {
        Some(Harmonic { order: |_, _, shape| shape[0], several: false, in_narrow_rows: None })
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        motion.harmonic(joint, shape[0], |m, row| self.amplitude(m, row)).into()
    }

    fn parameters(&self, _: &Motion, _: usize, _: &[f64], _: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}
