//! The part of a recording around a reversal that shows the gap, with what is known of the machine there.

use super::ensemble::Window;
use super::reversal::{Reversal, SPEED_SPAN, Session, braking};
use super::transmission::{CONTACT_STEPS, Transmission};
use crate::gearhead::{DeadZone, Direction, Friction};
use crate::identify::rigid_body::range;
use crate::robot::JointModel;

/// [s] Longest lead before the turn.
const LONGEST_LEAD: f64 = 0.5;
/// [s] Longest stretch after the turn.
const LONGEST_TAIL: f64 = 6.0;
/// [s] Time that is evaluated after the rotor has moved farther than the gap.
const AFTER_CONTACT: f64 = 0.10;
/// Smallest count, as a part of the range of motion: an exact encoder is treated as one with this count.
const FINEST_COUNT: f64 = 1e-5;

/// How much harder than the link's friction a motor brakes that leaves the link: the mean deceleration contains the short stretch in which the
/// motor sticks. Of the scenario of the paper's arm at a link share of 0.1 and 0.15, gaps were up to a factor of 3 off; at 0.2 within 4 %.
const HARDER: f64 = 1.5;

/// [rad] Largest phase by which rotor and link, on the spring of a rigid gear, oscillate in a step: the symplectic steps keep its
/// energy within `x²/8`, 1 %.
const STEP_ANGLE: f64 = 0.3;

/// [s] Shortest step from reading to reading: a faster recording is read once in it, since what its samples say is not independent.
const SHORTEST_STEP: f64 = 1e-3;

/// A reversal with its window.
#[derive(Debug, Clone)]
pub(super) struct Site {
    /// Signals and machine.
    pub window: Window,
    /// [s] When the rotor turned.
    pub time: f64,
    /// [rad/s or m/s] Steady velocity after the turn, with its sign.
    pub velocity: f64,
    /// [rad/s² or m/s²] Mean deceleration before the turn.
    pub deceleration: f64,
}

impl Site {
    /// Whether the load rests on one flank throughout: gravity at the turn outweighs the link's friction at this share.
    pub fn carried(&self, share: f64) -> bool {
        let machine = &self.window.transmission;
        machine.gravity.abs() > share * machine.breakaway[0].min(machine.breakaway[1])
    }

    /// Whether the motor brakes harder than friction at this share, and gravity, can brake the link: then the link leaves its flank before the
    /// turn, and where it is there follows from small differences only.
    pub fn loose(&self, share: f64) -> bool {
        let machine = &self.window.transmission;
        let most = share * machine.breakaway[0].max(machine.breakaway[1]) + machine.gravity.abs();
        machine.link_inertia * self.deceleration > HARDER * most
    }
}

/// The windows of a session that end where the rotor has gone `travel` [rad or m] beyond its turn, with counts that are `coarser` times those of
/// the encoder.
pub(super) fn sites(
    session: &Session,
    joint: &JointModel,
    friction: &Friction,
    travel: f64,
    coarser: f64,
) -> Vec<Site> {
    let signals = &session.signals;
    let count = coarser * signals.count.max(FINEST_COUNT * range(signals.position));
    session.reversals.iter().map(|reversal| site(session, joint, friction, reversal, travel, count)).collect()
}

fn site(
    session: &Session,
    joint: &JointModel,
    friction: &Friction,
    reversal: &Reversal,
    travel: f64,
    count: f64,
) -> Site {
    let signals = &session.signals;
    let (position, clock) = (signals.position, &signals.clock);
    let (brakes, steady) = braking(position, reversal, clock);
    let deceleration = steady / clock.elapsed(brakes, reversal.turn.max(brakes + 1));
    let start = brakes.max(clock.before(reversal.turn, LONGEST_LEAD));
    let gone = |k: usize| (position[k] - position[reversal.turn]) * reversal.sign();
    let far = (reversal.turn..reversal.end).find(|&k| gone(k) > travel).unwrap_or(reversal.end);
    let end = clock.after(far, AFTER_CONTACT).min(clock.after(reversal.turn, LONGEST_TAIL)).min(position.len());
    let early = clock.before(start, 2.0 * SPEED_SPAN);
    let late = clock.after(reversal.end, 2.0 * SPEED_SPAN).min(position.len() - 1);
    let speed = |from: usize, to: usize| {
        if from < to { (position[to] - position[from]) / clock.elapsed(from, to) } else { 0.0 }
    };
    let stride = ((SHORTEST_STEP / clock.interval) as usize).max(1);
    let intervals: Vec<f64> = (start + 1..end).map(|k| clock.elapsed(k - 1, k)).collect();
    let torque = torque_between(&signals.torque[start..end], &intervals, joint.amplifier.current_time_constant);
    let steps: Vec<f64> = intervals.chunks(stride).map(|intervals| intervals.iter().sum()).collect();
    let impulse: Vec<f64> = torque.iter().zip(&intervals).map(|(torque, interval)| torque * interval).collect();
    let impulse = impulse.chunks(stride).map(|part| part.iter().sum::<f64>());
    let window = Window {
        transmission: transmission(session, joint, friction, reversal),
        count,
        interval: clock.interval * stride as f64,
        position: (start..end - 1).step_by(stride).chain([end - 1]).map(|k| position[k]).collect(),
        torque: impulse.zip(&steps).map(|(impulse, step)| impulse / step).collect(),
        coupling: session.rigid.coupling_along(start..end).into_iter().step_by(stride).collect(),
        steps,
        velocity: speed(early, start),
        seed: reversal.turn as u64,
    };
    Site { window, time: signals.time[reversal.turn], velocity: speed(reversal.end, late), deceleration }
}

/// What is known of the machine at a reversal.
fn transmission(session: &Session, joint: &JointModel, friction: &Friction, reversal: &Reversal) -> Transmission {
    let posture = session.rigid.posture(reversal.turn);
    let index = session.joint;
    let probe = 1e-3;
    let mut gravity = session.rigid.gravity_of();
    let mut gravity_at = |step: f64| {
        let mut q = posture.clone();
        q[index] += step;
        gravity(&q)
    };
    let link_inertia = session.rigid.link_inertia_of()(&posture);
    let rotor_inertia = joint.rotor_beside(link_inertia);
    let mobility = 1.0 / rotor_inertia + 1.0 / link_inertia;
    let known = joint.flanks(0.0, rotor_inertia + link_inertia, mobility);
    // The stiffness of a rigid gear is limited to what the steps of a sample in contact can follow.
    let followed =
        (STEP_ANGLE * CONTACT_STEPS as f64 / session.signals.clock.interval.max(SHORTEST_STEP)).powi(2) / mobility;
    let softer = if joint.gear_stiffness.is_none() { (followed / known.stiffness).min(1.0) } else { 1.0 };
    Transmission {
        rotor_inertia,
        link_inertia,
        dead_zone: DeadZone { stiffness: known.stiffness * softer, damping: known.damping * softer, ..known },
        friction: friction.law,
        breakaway: [Direction::Positive, Direction::Negative].map(|direction| friction.law.magnitude(direction, 0.0)),
        gravity: gravity_at(0.0),
        gravity_slope: (gravity_at(probe) - gravity_at(-probe)) / (2.0 * probe),
        origin: posture[index],
    }
}

/// Mean torque between each sample and the next: the current starts from its reading and follows its new command with the time
/// constant `T_i`, so that with `a = Δt/T_i` the mean is `u i_k + (1 − u) i_{k+1}`, `u = 1/a − e^{−a}/(1 − e^{−a})`.
pub(in crate::identify) fn torque_between(torque: &[f64], steps: &[f64], time_constant: f64) -> Vec<f64> {
    let mean = |(pair, step): (&[f64], &f64)| {
        let a = step / time_constant;
        let weight = if a < 1e-3 { 0.5 } else { 1.0 / a - 1.0 / a.exp_m1() };
        weight * pair[0] + (1.0 - weight) * pair[1]
    };
    torque.windows(2).zip(steps).map(mean).collect()
}
