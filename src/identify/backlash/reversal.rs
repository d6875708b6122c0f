//! The reversals of a recorded motion, found from the motor's position alone.

use crate::error::{Error, Result};
use crate::identify::rigid_body::{RigidBody, range};
use crate::identify::signals::Signals;
use crate::robot::Model;
use crate::timeseries::{Channel, Clock, TimeSeries};

/// Fewest reversals from which a gap is estimated.
pub(super) const FEWEST: usize = 3;

/// Largest number of reversals of a session that are used.
const MOST: usize = 12;
/// Shortest stroke, as a part of the range of positions.
const SHORTEST_STROKE: f64 = 0.05;
/// Part of the steady speed below which a stroke counts as braking.
const BRAKING: f64 = 0.9;
/// [s] Stretch over which a speed is taken from the counts.
pub(super) const SPEED_SPAN: f64 = 0.060;

/// One recording of a joint with its reversals.
pub(in crate::identify) struct Session<'a> {
    /// Index of the joint.
    pub joint: usize,
    /// Unit of its position.
    pub unit: &'static str,
    /// Its signals.
    pub signals: Signals<'a>,
    /// The rigid bodies along the recording.
    pub rigid: RigidBody<'a>,
    /// Its reversals in the order of time.
    pub reversals: Vec<Reversal>,
}

impl<'a> Session<'a> {
    /// The signals of a joint and their reversals; `None` if the recording lacks them, or if the current's sign was not measured
    /// and its command, which gives the sign, was not recorded.
    pub fn of(model: &'a Model, joint: usize, series: &'a TimeSeries) -> Option<Self> {
        let mut signals = Signals::of(model, joint, series)?;
        if signals.rectified {
            let recorded = series.joint(&model.joints[joint].name)?;
            sign_by_command(&mut signals.torque, recorded.get(Channel::CommandCurrent)?);
            signals.rectified = false;
        }
        // Without a stroke of the reference the motor turns otherwise, as when it is rocked within its gap.
        let strokes = signals.reference_velocity.as_ref().is_none_or(|v| v.iter().any(|v| *v != 0.0));
        let turns = if strokes { find_reversals(signals.position, signals.count) } else { Vec::new() };
        let reversals = gentlest(turns, signals.position, &signals.clock);
        let unit = model.joints[joint].kind.position_unit();
        Some(Self { joint, unit, signals, rigid: RigidBody::new(model, joint, series), reversals })
    }
}

/// Gives a rectified torque the sign of the command before it, which the current has followed by the time it is read.
fn sign_by_command(torque: &mut [f64], command: &[f64]) {
    for (k, tau) in torque.iter_mut().enumerate() {
        *tau = tau.abs().copysign(command[k.saturating_sub(1)]);
    }
}

/// A turn of the motor between two strokes. Sample indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reversal {
    /// Middle of the stroke before it.
    pub start: usize,
    /// First sample at the extreme position.
    pub turn: usize,
    /// Middle of the stroke after it.
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

/// Keeps the sessions in which the joint was moved: elsewhere it gives way to the other joints, and turns as well, which fine encoders show.
/// The reference tells, where it was recorded; else the range of the positions.
pub(super) fn keep_moved(sessions: &mut Vec<Session>) {
    let longest = sessions.iter().map(|session| range(session.signals.position)).fold(0.0, f64::max);
    sessions.retain(|session| match &session.signals.reference_velocity {
        Some(reference) => reference.iter().any(|velocity| *velocity != 0.0),
        None => range(session.signals.position) >= SHORTEST_STROKE * longest,
    });
}

/// Turns between strokes that are longer than a twentieth of the whole range and ten encoder counts.
pub fn find_reversals(position: &[f64], count: f64) -> Vec<Reversal> {
    let stroke = (SHORTEST_STROKE * range(position)).max(10.0 * count);
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

/// Sample at which the stroke before a reversal begins to brake, less [`SPEED_SPAN`], and the steady speed before it [rad/s or m/s].
pub(in crate::identify) fn braking(position: &[f64], reversal: &Reversal, clock: &Clock) -> (usize, f64) {
    let speed = |from: usize, to: usize| (position[to] - position[from]).abs() / clock.elapsed(from, to);
    let quarter = ((reversal.turn - reversal.start) / 4).max(1);
    let steady = speed(reversal.start, reversal.start + quarter);
    let before = |k: usize| clock.before(k, SPEED_SPAN).min(k - 1);
    let first = clock.after(reversal.start, SPEED_SPAN).max(reversal.start + 1);
    let start = (first..reversal.turn).rev().find(|&k| speed(before(k), k) >= BRAKING * steady);
    (start.map_or(reversal.start, before), steady)
}

/// The reversals that braked most gently, in the order of time: where a motor brakes harder than the link's own friction, the link
/// leaves its flank, and where it is at the turn is not known.
fn gentlest(mut reversals: Vec<Reversal>, position: &[f64], clock: &Clock) -> Vec<Reversal> {
    reversals.sort_by_cached_key(|reversal| {
        let (start, steady) = braking(position, reversal, clock);
        // It is not negative, so its bits sort in the same order.
        (steady / clock.elapsed(start, reversal.turn.max(start + 1))).to_bits()
    });
    reversals.truncate(MOST);
    reversals.sort_by_key(|reversal| reversal.turn);
    reversals
}

/// Start, every extreme with a stroke of at least `stroke` on both sides, and the end of the last stroke.
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
