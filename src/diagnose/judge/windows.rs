//! Windows of recordings in which every joint reverses, rests and travels: some to fit, others to judge.
//!
//! A recording is cut into windows of equal length, which go to the two parts in turn; what the diagnosis holds out is for judging alone. In each part
//! windows are taken one by one, always the one that adds most to
//!
//! ```text
//!   Σ w ∛(share of its events that the chosen windows have)     over reversals in each third of its way, starts from rest, path and slow motion of each joint
//! ```
//! so that what few windows have, the rests of one joint in a staircase, is not left out for more of the same. The thirds count as one kind of event: any gap
//! looks constant to windows that reverse at one angle.

use crate::diagnose::rows::division::Division;
use crate::likelihood::Recording;
use crate::robot::{JointModel, Model};
use crate::timeseries::{Channel, TimeSeries};

/// [s] Length of a window, its burn-in included: a few reversals of fast motion, or two speeds of a staircase.
const LENGTH: f64 = 5.0;
/// [s] Time over which a joint is seen to move or to rest.
const GLANCE: f64 = 0.05;
/// Counts of the encoder in that time up to which a joint rests: friction lets a held joint creep by one or two.
const RESTS: f64 = 3.0;
/// [1] Slow motion: up to this share of the fastest of a joint, where friction falls with speed.
const SLOW: f64 = 0.1;
/// Parts of the way of a joint whose reversals are counted by themselves: three points tell a gap that varies from a constant one.
const PARTS: usize = 3;
/// Kinds of events of a joint: reversals in each part, starts from rest, path and slow motion; and what each is worth.
const KINDS: usize = 6;
const WORTH: [f64; KINDS] = [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 1.0, 1.0, 1.0];

/// A window of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Index of the session.
    pub session: usize,
    /// [s] since its start.
    pub from: f64,
    /// [s]
    pub to: f64,
    /// Of each joint.
    events: Vec<[f64; KINDS]>,
}

/// Windows to fit and windows to judge, so many of each.
pub fn choose(
    model: &Model,
    sessions: &[&TimeSeries],
    recordings: &[Recording],
    division: Division,
    count: usize,
) -> [Vec<Window>; 2] {
    let joints: Vec<Motion> = model.joints.iter().map(|joint| Motion::of(joint, sessions)).collect();
    let mut parts: [Vec<Window>; 2] = [Vec::new(), Vec::new()];
    for (session, (series, recording)) in sessions.iter().zip(recordings).enumerate() {
        let (Some(first), Some(last)) = (recording.time.first(), recording.time.last()) else { continue };
        let most = ((last - first) / LENGTH + 1e-9).floor() as usize;
        for k in 0..most {
            let from = first + LENGTH * k as f64;
            let to = from + LENGTH;
            let own = samples(series, [from, to]);
            let judges = k % 2 == 1 || holds_out(division, session, series, own);
            let events = joints.iter().map(|joint| joint.events(series, own)).collect();
            parts[usize::from(judges)].push(Window { session, from, to, events });
        }
    }
    parts.map(|windows| best(windows, count))
}

/// Samples of a session between two times [s] since its start.
fn samples(series: &TimeSeries, [from, to]: [f64; 2]) -> [usize; 2] {
    let start = series.time.first().copied().unwrap_or(0.0);
    [from, to].map(|time| series.time.partition_point(|one| one - start < time))
}

/// Whether a part of these samples is held out.
fn holds_out(division: Division, number: usize, series: &TimeSeries, [first, last]: [usize; 2]) -> bool {
    division.held_out(number, series).iter().any(|part| part.start < last && first < part.end)
}

/// The windows that together have most of the events.
fn best(windows: Vec<Window>, count: usize) -> Vec<Window> {
    let joints = windows.iter().map(|window| window.events.len()).max().unwrap_or(0);
    let mut total = vec![[0.0; KINDS]; joints];
    windows.iter().for_each(|window| add(&mut total, &window.events));
    let mut chosen: Vec<Window> = Vec::new();
    let mut had = vec![[0.0; KINDS]; joints];
    let worth = |had: &[[f64; KINDS]]| -> f64 {
        let pairs = had.iter().flatten().zip(total.iter().flatten()).zip(WORTH.iter().cycle());
        pairs.filter(|((_, all), _)| **all > 0.0).map(|((own, all), worth)| worth * (own / all).cbrt()).sum()
    };
    let mut left = windows;
    while chosen.len() < count && !left.is_empty() {
        let with = |window: &Window| {
            let mut sum = had.clone();
            add(&mut sum, &window.events);
            worth(&sum)
        };
        let worths: Vec<f64> = left.iter().map(with).collect();
        let first = (0..left.len()).fold(0, |best, k| if worths[k] > worths[best] { k } else { best });
        let window = left.remove(first);
        add(&mut had, &window.events);
        chosen.push(window);
    }
    chosen
}

fn add(sum: &mut [[f64; KINDS]], events: &[[f64; KINDS]]) {
    for (sum, events) in sum.iter_mut().zip(events) {
        sum.iter_mut().zip(events).for_each(|(sum, one)| *sum += one);
    }
}

/// Positions of a joint between two samples, one for each glance.
fn glances(joint: &JointModel, series: &TimeSeries, [first, last]: [usize; 2]) -> Vec<f64> {
    let stride = ((GLANCE / series.sample_interval()) as usize).max(1);
    let position = series.joint(&joint.name).and_then(|joint| joint.get(Channel::Position)).unwrap_or(&[]);
    position.get(first..last).unwrap_or(&[]).iter().step_by(stride).copied().collect()
}

/// How a joint moves in all sessions.
struct Motion<'a> {
    joint: &'a JointModel,
    /// [rad or m] Longest way of slow motion in the time of a glance.
    slow: f64,
    /// [rad or m] Ends of its way.
    ends: [f64; 2],
}

impl<'a> Motion<'a> {
    fn of(joint: &'a JointModel, sessions: &[&TimeSeries]) -> Self {
        let seen: Vec<Vec<f64>> =
            sessions.iter().map(|series| glances(joint, series, [0, series.time.len()])).collect();
        let steps = seen.iter().flat_map(|seen| seen.windows(2)).map(|pair| (pair[1] - pair[0]).abs());
        let ends = |ends: [f64; 2], position: &f64| [ends[0].min(*position), ends[1].max(*position)];
        Self {
            joint,
            slow: SLOW * steps.fold(0.0, f64::max),
            ends: seen.iter().flatten().fold([f64::INFINITY, f64::NEG_INFINITY], ends),
        }
    }

    /// Part of its way at a position.
    fn part(&self, position: f64) -> usize {
        let [low, high] = self.ends;
        (((position - low) / (high - low) * PARTS as f64) as usize).min(PARTS - 1)
    }

    /// Its events in a part of a session.
    fn events(&self, series: &TimeSeries, part: [usize; 2]) -> [f64; KINDS] {
        let (mut way, mut rested, mut found) = (0.0, false, [0.0; KINDS]);
        for pair in glances(self.joint, series, part).windows(2) {
            let moved = pair[1] - pair[0];
            found[PARTS + 1] += moved.abs();
            if moved.abs() <= RESTS * self.joint.encoder_step() {
                rested = true;
                continue;
            }
            found[self.part(pair[0])] += f64::from(u8::from(way * moved < 0.0));
            found[PARTS] += f64::from(u8::from(rested));
            found[PARTS + 2] += f64::from(u8::from(moved.abs() < self.slow));
            (way, rested) = (moved.signum(), false);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(session: usize, events: [f64; KINDS]) -> Window {
        Window { session, from: 0.0, to: LENGTH, events: vec![events] }
    }

    /// Two windows with all of one kind are worth less than one of each kind.
    #[test]
    fn property_rare_events_are_chosen_beside_frequent_ones() {
        let frequent = [10.0, 0.0, 0.0, 0.0, 5.0, 0.0];
        let windows = vec![window(0, frequent), window(1, frequent), window(2, [0.0, 0.0, 0.0, 1.0, 0.1, 0.0])];
        let chosen: Vec<usize> = best(windows, 2).iter().map(|one| one.session).collect();
        assert!(chosen.contains(&2), "{chosen:?}");
    }

    /// Many reversals at one end are worth less than some at each.
    #[test]
    fn property_reversals_are_chosen_along_the_whole_way() {
        let at = |part: usize, count: f64| {
            let mut events = [0.0; KINDS];
            events[part] = count;
            events
        };
        let windows =
            vec![window(0, at(0, 10.0)), window(1, at(0, 10.0)), window(2, at(1, 4.0)), window(3, at(2, 4.0))];
        let chosen: Vec<usize> = best(windows, 3).iter().map(|one| one.session).collect();
        assert!(chosen.contains(&2) && chosen.contains(&3), "{chosen:?}");
        // A joint from −1 to 2 rad.
        let model = Model::load(std::path::Path::new("robots/scara/model.toml")).expect("a model");
        let motion = Motion { joint: &model.joints[0], slow: 0.1, ends: [-1.0, 2.0] };
        assert_eq!([-1.0, -0.1, 0.1, 1.1, 2.0].map(|position| motion.part(position)), [0, 0, 1, 2, 2]);
    }

    #[test]
    fn property_what_is_held_out_is_fitted_to_by_no_window() {
        let series = TimeSeries { time: (0..1000).map(|k| 0.05 * f64::from(k)).collect(), ..TimeSeries::default() };
        let division = Division::of(&[&series], 1, 0.3);
        let held = |from: f64| holds_out(division, 0, &series, samples(&series, [from, from + LENGTH]));
        // The last 30 % of 50 s begin at 35 s.
        assert_eq!([25.0, 29.0, 31.0, 40.0].map(held), [false, false, true, true]);
    }

    #[test]
    fn property_no_window_is_chosen_twice_and_too_few_are_all() {
        assert_eq!(best(vec![window(0, [0.0; KINDS]), window(1, [0.0; KINDS])], 5).len(), 2);
    }
}
