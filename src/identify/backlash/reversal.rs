//! The reversals of a recorded motion, found from the motor's position alone.

use crate::error::{Error, Result};
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};

/// Reversals below which no gap is estimated.
const FEWEST: usize = 3;

/// The motor-side signals of one joint.
pub(super) struct Signals<'a> {
    /// Name of the joint.
    pub joint: &'a str,
    /// Unit of its position.
    pub unit: &'static str,
    /// [s]
    pub time: &'a [f64],
    /// [rad or m]
    pub position: &'a [f64],
    /// [rad/s or m/s]
    pub velocity: &'a [f64],
    /// [A]
    pub current: &'a [f64],
    /// [rad or m] size of an encoder count at the joint.
    pub count: f64,
}

impl<'a> Signals<'a> {
    /// The channels of a joint.
    pub fn of(model: &'a Model, joint: usize, series: &'a TimeSeries) -> Result<Self> {
        let name = model.joints[joint].name.as_str();
        let channel = |channel: Channel, advice: &'static str| {
            series.joint(name).and_then(|one| one.get(channel)).ok_or(Error::TooLittleData {
                quantity: "backlash",
                joint: name.to_owned(),
                found: 0,
                unit: "samples",
                needed: 1,
                advice,
            })
        };
        Ok(Self {
            joint: name,
            unit: model.joints[joint].kind.position_unit(),
            time: &series.time,
            position: channel(Channel::Position, "record the motor's position")?,
            velocity: channel(Channel::Velocity, "record the motor's velocity")?,
            current: channel(Channel::Current, "record the motor's current")?,
            count: model.joints[joint].encoder_step(),
        })
    }

    /// [s] Mean sample interval.
    pub fn interval(&self) -> f64 {
        match self.time {
            [first, .., last] => (last - first) / (self.time.len() - 1) as f64,
            _ => 1.0,
        }
    }
}

/// One recording of a joint with its reversals.
pub(super) struct Session<'a> {
    /// Its signals.
    pub signals: Signals<'a>,
    /// Its reversals in the order of time.
    pub reversals: Vec<Reversal>,
}

impl<'a> Session<'a> {
    /// The signals of a joint and their reversals.
    pub fn of(model: &'a Model, joint: usize, series: &'a TimeSeries) -> Result<Self> {
        let signals = Signals::of(model, joint, series)?;
        let reversals = find_reversals(signals.position, signals.count);
        Ok(Self { signals, reversals })
    }
}

/// A turn of the motor between two strokes. Sample indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reversal {
    /// Where the stroke before it is half done.
    pub start: usize,
    /// First sample at the extreme position.
    pub turn: usize,
    /// Where the stroke after it is half done.
    pub end: usize,
    /// Direction after it: +1 or −1.
    pub direction: i8,
}

impl Reversal {
    /// Direction after the turn, as a factor.
    pub fn sign(&self) -> f64 {
        f64::from(self.direction)
    }
}

/// Turns between strokes that are longer than a twentieth of the whole range and ten encoder counts.
pub fn find_reversals(position: &[f64], count: f64) -> Vec<Reversal> {
    let (low, high) = position.iter().fold((f64::MAX, f64::MIN), |(low, high), &x| (low.min(x), high.max(x)));
    let stroke = (0.05 * (high - low)).max(10.0 * count);
    let turns = extremes(position, stroke);
    turns
        .windows(3)
        .map(|three| {
            let [before, turn, after] = [three[0], three[1], three[2]];
            let half = |from: usize, to: usize| {
                let middle = 0.5 * (position[from] + position[to]);
                let side = position[from] < middle;
                (from..to).find(|&k| (position[k] < middle) != side).unwrap_or(to)
            };
            Reversal {
                start: half(before, turn),
                turn,
                end: half(turn, after),
                direction: if position[after] > position[turn] { 1 } else { -1 },
            }
        })
        .collect()
}

/// Start, every extreme that is left by at least `stroke` on both sides, and the end of the last stroke.
fn extremes(position: &[f64], stroke: f64) -> Vec<usize> {
    let mut found = Vec::new();
    let (mut low, mut high, mut direction) = (0, 0, 0i8);
    for (k, &x) in position.iter().enumerate() {
        if x < position[low] {
            low = k;
        }
        if x > position[high] {
            high = k;
        }
        if direction <= 0 && x - position[low] > stroke {
            found.push(low);
            (direction, high) = (1, k);
        } else if direction >= 0 && position[high] - x > stroke {
            found.push(high);
            (direction, low) = (-1, k);
        }
    }
    if direction != 0 {
        found.push(if direction > 0 { high } else { low });
    }
    found
}

/// # Errors
/// Fewer than three reversals.
pub(super) fn enough(sessions: &[Session], joint: &str) -> Result<()> {
    let found = sessions.iter().map(|session| session.reversals.len()).sum();
    if found < FEWEST {
        return Err(Error::TooLittleData {
            quantity: "backlash",
            joint: joint.to_owned(),
            found,
            unit: "reversals",
            needed: FEWEST,
            advice: "move the joint to and fro, as the staircase does",
        });
    }
    Ok(())
}
