//! Division of the recordings into training data and held-out data.
//!
//! Held-out data take no part in the choice of effects, delays, shapes or scales. They are read once, for the gain of the chosen effects; before
//! that, sessions that are held out whole are only checked for mistakes of the recording, which end a diagnosis.
//!
//! Where no session is held out, the end of each is. A recording that moves one joint after the other would lose its last joints to that: it is cut
//! into equal blocks, as few as leave every joint enough motion on both sides, and the end of each block is held out.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::effects::Motion;
use crate::timeseries::{Channel, TimeSeries};

/// [1] Least and most of a joint's motion that may be held out, as multiples of the share asked for.
const FAIR: [f64; 2] = [1.0 / 3.0, 5.0 / 3.0];
/// Most blocks of a session.
const MOST_BLOCKS: usize = 24;
/// [s] Shortest held-out end of a block: two steps of a staircase, or a few periods of fast motion.
const SHORTEST_END: f64 = 2.0;
/// [s] Time over which a joint is seen to move.
const GLANCE: f64 = 0.1;
/// [1] Share of the longest way in the time of a glance from which a joint moves; below it a joint that is held creeps or its encoder flickers.
const MOVES: f64 = 0.01;

/// Either separate sessions are held out, or the end of every block of every session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Division {
    /// Number of sessions for training; they come first.
    trained: usize,
    /// Number of all sessions.
    sessions: usize,
    /// [1] Part at the end of each block that is held out when no session is held out.
    share: f64,
    /// Number of blocks of each session.
    blocks: usize,
}

impl Division {
    /// The first `trained` of the sessions are for training; if these are all sessions, the last `share` (0 to 1) of each block is held out.
    pub fn of(sessions: &[&TimeSeries], trained: usize, share: f64) -> Self {
        let divided = |blocks: usize| Self { trained, sessions: sessions.len(), share, blocks };
        let one = divided(1);
        if one.by_session() || share <= 0.0 {
            return one;
        }
        let joints: BTreeSet<&str> =
            sessions.iter().flat_map(|session| &session.joints).map(|joint| &*joint.name).collect();
        let moving: Vec<Vec<f64>> = joints.into_iter().map(|joint| moving(joint, sessions)).collect();
        let shortest = sessions.iter().map(|session| span(session)[1]).fold(f64::INFINITY, f64::min);
        let most = ((share * shortest / SHORTEST_END) as usize).clamp(1, MOST_BLOCKS);
        // How unfair: the largest ratio of what is held out of a joint's motion and what should be, or the reverse.
        let unfair = |division: &Self| {
            let of_joint = |places: &Vec<f64>| {
                let held = places.iter().filter(|place| division.holds_out_place(**place)).count();
                let ratio = held as f64 / places.len() as f64 / share;
                if ratio < 1.0 { FAIR[0] / ratio.max(1e-9) } else { ratio / FAIR[1] }
            };
            moving.iter().filter(|places| !places.is_empty()).map(of_joint).fold(0.0, f64::max)
        };
        let (mut best, mut least) = (one, unfair(&one));
        for division in (2..=most).map(divided) {
            if least <= 1.0 {
                break;
            }
            let now = unfair(&division);
            if now < least {
                (best, least) = (division, now);
            }
        }
        best
    }

    /// The same blocks for the first `trained` of another list of sessions.
    #[must_use]
    pub fn for_sessions(self, trained: usize, sessions: usize) -> Self {
        Self { trained, sessions, ..self }
    }

    /// Whether separate sessions are held out.
    pub fn by_session(&self) -> bool {
        self.trained < self.sessions
    }

    /// Number of sessions for training, in full or without the ends of their blocks.
    pub fn trained(&self) -> usize {
        self.trained
    }

    /// Samples of the parts of a session, in their order, and whether each part is held out.
    pub fn parts(&self, number: usize, session: &TimeSeries) -> Vec<(Range<usize>, bool)> {
        if self.by_session() {
            return vec![(0..session.len(), number >= self.trained)];
        }
        let [first, duration] = span(session);
        let until = |place: f64| session.time.partition_point(|time| *time <= first + place * duration);
        let (mut parts, mut start) = (Vec::new(), 0);
        for block in 0..self.blocks {
            let [cut, end] = [1.0 - self.share, 1.0].map(|place| until((block as f64 + place) / self.blocks as f64));
            let end = if block + 1 == self.blocks { session.len() } else { end };
            parts.extend([(start..cut, false), (cut..end, true)]);
            start = end;
        }
        parts
    }

    /// Samples of the training parts of a session.
    pub fn training(&self, number: usize, session: &TimeSeries) -> Vec<Range<usize>> {
        self.parts(number, session).into_iter().filter_map(|(part, held_out)| (!held_out).then_some(part)).collect()
    }

    /// Samples of the held-out parts of a session.
    pub fn held_out(&self, number: usize, session: &TimeSeries) -> Vec<Range<usize>> {
        self.parts(number, session).into_iter().filter_map(|(part, held_out)| held_out.then_some(part)).collect()
    }

    /// Whether an instant [s] of a session is held out.
    pub fn holds_out(&self, number: usize, session: &TimeSeries, time: f64) -> bool {
        if self.by_session() {
            return number >= self.trained;
        }
        let [first, duration] = span(session);
        self.holds_out_place((time - first) / duration.max(f64::MIN_POSITIVE))
    }

    /// Whether a place of a divided session, from 0 to 1 of its length, is held out.
    fn holds_out_place(&self, place: f64) -> bool {
        let blocks = self.blocks as f64;
        let block = (place * blocks).floor().clamp(0.0, blocks - 1.0);
        place > (block + 1.0 - self.share) / blocks
    }

    /// In words, which parts of each session are held out.
    pub fn in_words(&self) -> String {
        let end = format!("the last {:.0} % of", 100.0 * self.share);
        match self.blocks {
            1 => format!("{end} each session"),
            blocks => {
                format!("{end} each of {blocks} equal blocks of a session, so that every joint moves in both parts")
            }
        }
    }
}

/// [s] Start and duration of a session.
fn span(session: &TimeSeries) -> [f64; 2] {
    let [first, last] = [session.time.first(), session.time.last()].map(|time| time.copied().unwrap_or(0.0));
    [first, last - first]
}

/// Places where a joint moves, from 0 to 1 of the length of its session.
fn moving(joint: &str, sessions: &[&TimeSeries]) -> Vec<f64> {
    let mut ways = Vec::new();
    for session in sessions {
        let position = session.joint(joint).and_then(|series| series.get(Channel::Position)).unwrap_or(&[]);
        let [first, duration] = span(session);
        let mut last = 0;
        for (k, (time, q)) in session.time.iter().zip(position).enumerate() {
            if time - session.time[last] >= GLANCE {
                ways.push(((time - first) / duration, (q - position[last]).abs()));
                last = k;
            }
        }
    }
    let longest = ways.iter().map(|(_, way)| *way).fold(0.0, f64::max);
    ways.into_iter().filter_map(|(place, way)| (way > MOVES * longest).then_some(place)).collect()
}

/// Whether each row is held out.
pub fn held_out_rows(motion: &Motion, sessions: &[&TimeSeries], division: Division) -> Vec<bool> {
    let rows = motion.session.iter().zip(&motion.time);
    rows.map(|(session, time)| division.holds_out(*session, sessions[*session], *time)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timeseries::JointSeries;

    const SHARE: f64 = 0.3;

    /// A session of 100 s in which each joint swings between two times [s].
    fn session(moving: &[[f64; 2]]) -> TimeSeries {
        let time: Vec<f64> = (0..1000).map(|k| 0.1 * f64::from(k)).collect();
        let joint = |(number, [from, to]): (usize, &[f64; 2])| {
            let position = time.iter().map(|t| t.clamp(*from, *to).sin()).collect::<Vec<f64>>();
            JointSeries { name: format!("joint_{number}"), channels: [(Channel::Position, position.into())].into() }
        };
        TimeSeries {
            joints: moving.iter().enumerate().map(joint).collect(),
            time: time.clone(),
            ..TimeSeries::default()
        }
    }

    /// Share of the times between two [s] that is held out.
    fn held_out(division: Division, session: &TimeSeries, [from, to]: [f64; 2]) -> f64 {
        let times: Vec<f64> = session.time.iter().copied().filter(|time| (from..to).contains(time)).collect();
        times.iter().filter(|time| division.holds_out(0, session, **time)).count() as f64 / times.len() as f64
    }

    #[test]
    fn sessions_of_their_own_are_held_out_whole() {
        let one = session(&[[0.0, 10.0]]);
        let division = Division::of(&[&one, &one, &one], 2, SHARE);
        assert_eq!(
            [0, 1, 2].map(|number| division.parts(number, &one)),
            [[(0..1000, false)], [(0..1000, false)], [(0..1000, true)]]
        );
        assert!(!division.holds_out(1, &one, 99.0) && division.holds_out(2, &one, 0.0));
    }

    #[test]
    fn the_end_of_each_session_is_held_out_where_no_session_is() {
        let one = session(&[[0.0, 100.0], [0.0, 100.0]]);
        let division = Division::of(&[&one, &one], 2, SHARE);
        assert_eq!(division.parts(1, &one), [(0..700, false), (700..1000, true)]);
        assert!(!division.holds_out(1, &one, 69.0) && division.holds_out(1, &one, 70.5));
    }

    #[test]
    fn joints_that_move_one_after_the_other_move_in_both_parts() {
        let ranges = [[0.0, 25.0], [25.0, 50.0], [50.0, 75.0], [75.0, 100.0]];
        let one = session(&ranges);
        let division = Division::of(&[&one], 1, SHARE);
        for range in ranges {
            let share = held_out(division, &one, range);
            assert!((FAIR[0] * SHARE..FAIR[1] * SHARE).contains(&share), "{range:?}: {share}");
        }
        // Samples and instants are divided alike, and no sample is lost.
        let parts = division.parts(0, &one);
        assert!(parts.windows(2).all(|pair| pair[0].0.end == pair[1].0.start) && parts[parts.len() - 1].0.end == 1000);
        for (part, held) in parts {
            assert!(part.into_iter().all(|k| division.holds_out(0, &one, one.time[k]) == held));
        }
    }

    #[test]
    fn a_joint_that_never_moves_asks_for_nothing() {
        let one = session(&[[0.0, 100.0], [0.0, 0.0]]);
        assert_eq!(Division::of(&[&one], 1, SHARE).parts(0, &one).len(), 2);
    }
}
