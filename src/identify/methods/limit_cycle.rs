//! The gap from the amplitude of an oscillation of the motor within it, driven by a square wave of torque, from motor-side data alone.
//!
//! The motor is at rest against one flank, its torque changes from `−D` to `+D`, it crosses the gap alone and comes to rest against the
//! other flank, whose link rests throughout:
//!
//! ```text
//!   J θ̈ = D − F_r(θ̇)                                 in the gap: it crosses b in √(2 b J/(D − F_r)) from rest          (a)
//!   θ = q ± (b/2 + T/k),  T = D − F_r,  |F_r| ≤ F_S,r    at rest against a flank, T ≥ 0                                  (b)
//!   b = |θ₊ − θ₋| − (T₊ + T₋)/k,   T = D/2 ± D/√12         the friction of a motor at rest is not known                  (c)
//! ```
//! The torque `D` has to exceed the motor's friction at rest, `F_S,r`, and the torque of the gear to stay below that of the link, or
//! the link is pushed on. An impact moves the link by about `b (J/H)² (D − F_r)/F_l` in the direction of the motor, which adds to (c).
//! Sign: `+D` rests the motor at the larger angle.
//!
//! After M. Ruderman, S. Yamada, H. Fujimoto (2019), Backlash identification in two-mass systems by delayed relay feedback, ASME Journal
//! of Dynamic Systems, Measurement, and Control 141, 061007: a limit cycle that a relay drives within the gap, seen by the motor's sensors.
//! Different here: the relay is switched by a clock instead of the delayed velocity, so that the motor rests against each flank.

use crate::identify::quantity::Quantity;
use crate::identify::signals::Signals;
use crate::identify::statistics::median;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// Fewest crossings of the gap.
const FEWEST: usize = 6;
/// [1] Least torque of the wave, as a part of the joint's friction at rest: with less a motor whose friction is half of the joint's does
/// not move.
pub(super) const LEAST: f64 = 0.5;
/// [1] Part of the samples of a half period, and the deviation from the wave's torque that they may have: a square wave after its edges. A half period
/// may be shorter than the longest by the second as well.
const SQUARE: (f64, f64) = (0.9, 0.25);
/// [1] Part of a half period, at its end, in which the motor has to rest.
const AT_REST: f64 = 0.2;
/// Counts by which a motor at rest may move, an edge of its encoder that it touches, and the part of its travel: an impact pushes the
/// link on for a while, and a motor that pushes it all the time moves by more than the gap.
const RESTS: (f64, f64) = (1.0, 0.05);
/// Fewest counts of the encoder in a gap that is reported: both ends are known to half a count, a quarter of such a gap.
const FEWEST_COUNTS: f64 = 4.0;

/// A half period.
struct Half {
    start: usize,
    end: usize,
    positive: bool,
}

/// Duration [s] of the sessions with such a wave, and the gap, or why there is none. `at_rest`: the joint's friction at rest [N·m or N],
/// the smaller of both directions. `None`: no session has such a wave.
pub(super) fn estimate(
    model: &Model,
    joint: usize,
    data: &[TimeSeries],
    at_rest: f64,
) -> Option<(f64, Result<Quantity, String>)> {
    let (mut duration, mut crossings, mut level, mut moves, mut count) = (0.0, Vec::new(), 0.0_f64, false, 0.0);
    for signals in data.iter().filter_map(|series| Signals::of(model, joint, series)) {
        if signals.rectified || signals.time.len() < 2 {
            continue;
        }
        let Some((torque, halves)) = wave(&signals, LEAST * at_rest) else { continue };
        duration += signals.clock.elapsed(0, signals.time.len() - 1);
        level = level.max(torque);
        count = signals.count;
        let rests: Vec<Option<f64>> = halves.iter().map(|half| rest(&signals, half)).collect();
        moves |= rests.contains(&None);
        for (pair, of) in halves.windows(2).zip(rests.windows(2)) {
            if let ([before, after], [Some(from), Some(to)]) = (pair, of)
                && before.end == after.start
            {
                crossings.push(if after.positive { to - from } else { from - to });
            }
        }
    }
    if level == 0.0 {
        return None;
    }
    let joint = &model.joints[joint];
    let wind_up = joint.gear_stiffness.map_or(0.0, |k| level / k);
    let found = gap(&crossings, Wave { level, wind_up, count, moves, part: level / at_rest });
    Some((duration, found.map(|(gap, std_error)| Quantity::new(gap, std_error, 1.96, joint.kind.position_unit()))))
}

/// What is known of the oscillation.
struct Wave {
    /// `D` [N·m or N].
    level: f64,
    /// `D/k` [rad or m].
    wind_up: f64,
    /// [rad or m]
    count: f64,
    /// Whether the motor does not come to rest in some half period.
    moves: bool,
    /// `D` as a part of the joint's friction at rest.
    part: f64,
}

/// (c) with its standard error [rad or m].
fn gap(crossings: &[f64], wave: Wave) -> Result<(f64, f64), String> {
    let Wave { level, wind_up, count, moves, part } = wave;
    if moves {
        return Err(format!(
            "the motor does not come to rest in every half period: less torque than {level:.3}, so that friction holds the link, or a longer period"
        ));
    }
    if crossings.len() < FEWEST {
        return Err(format!("{} crossings of the gap, at least {FEWEST} needed: more periods", crossings.len()));
    }
    let n = crossings.len() as f64;
    let mean = crossings.iter().sum::<f64>() / n;
    let travel = mean - wind_up;
    if travel < FEWEST_COUNTS * count || travel < wind_up {
        return Err(format!(
            "the motor travels {:.1} counts of its encoder, at least {FEWEST_COUNTS} are needed, and {:.1} times the wind-up of its gear. \\
             Either the gap is below that, or the torque, {:.0} % of the joint's friction at rest, does not exceed the motor's own friction; \\
             more torque or a finer encoder decides",
            if count > 0.0 { mean / count } else { 0.0 },
            if wind_up > 0.0 { mean / wind_up } else { 0.0 },
            100.0 * part
        ));
    }
    let scatter = crossings.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
    // The motor returns to the same two places, so that counts do not average out.
    let counts = count * count / 6.0;
    let pressed = wind_up * wind_up / 6.0;
    Ok((travel, (scatter + counts + pressed).sqrt()))
}

/// `D` and the half periods of a square wave of at least this torque; `None` where the torque is none.
fn wave(signals: &Signals, least: f64) -> Option<(f64, Vec<Half>)> {
    let level = median(signals.torque.iter().map(|tau| tau.abs()).filter(|tau| *tau > least).collect());
    let mut switches = Vec::new();
    let mut last = None;
    for (k, tau) in signals.torque.iter().enumerate() {
        if tau.abs() > 0.5 * level && last != Some(*tau > 0.0) {
            last = Some(*tau > 0.0);
            switches.push((k, *tau > 0.0));
        }
    }
    let interval = |pair: &[(usize, bool)]| Half { start: pair[0].0, end: pair[1].0, positive: pair[0].1 };
    let square = |half: &Half| {
        let part = &signals.torque[half.start..half.end];
        let near = part.iter().filter(|tau| (tau.abs() / level - 1.0).abs() < SQUARE.1).count();
        near as f64 >= SQUARE.0 * part.len() as f64
    };
    let halves: Vec<Half> = switches.windows(2).map(interval).filter(square).collect();
    let length = |half: &Half| half.end - half.start;
    // A controller that takes over after the wave may switch faster.
    let longest = halves.iter().map(length).max()?;
    let even = |half: &Half| length(half) as f64 > (1.0 - SQUARE.1) * longest as f64;
    let halves: Vec<Half> = halves.into_iter().filter(even).collect();
    let whole = 2 * halves.iter().map(length).sum::<usize>() >= signals.torque.len();
    (halves.len() >= FEWEST && whole).then_some((level, halves))
}

/// The half periods of a square wave of torque of a level within these [N·m or N], first sample and the one after the last.
pub(super) fn half_periods(signals: &Signals, levels: std::ops::Range<f64>) -> Option<Vec<[usize; 2]>> {
    let (level, halves) = wave(signals, levels.start)?;
    levels.contains(&level).then(|| halves.iter().map(|half| [half.start, half.end]).collect())
}

/// Where the motor rests at the end of a half period [rad or m]; `None` where it moves.
fn rest(signals: &Signals, half: &Half) -> Option<f64> {
    let from = half.end - ((half.end - half.start) as f64 * AT_REST) as usize;
    let part = signals.position.get(from..half.end).filter(|part| !part.is_empty())?;
    let ends = part.iter().fold([f64::MAX, f64::MIN], |[low, high], x| [low.min(*x), high.max(*x)]);
    let whole = &signals.position[half.start..half.end];
    let all = whole.iter().fold([f64::MAX, f64::MIN], |[low, high], x| [low.min(*x), high.max(*x)]);
    let allowed = (RESTS.0 * signals.count).max(RESTS.1 * (all[1] - all[0])) * (1.0 + 1e-9);
    (ends[1] - ends[0] <= allowed).then(|| part.iter().sum::<f64>() / part.len() as f64)
}
