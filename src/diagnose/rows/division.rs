//! Division of the recordings into training data and held-out data.
//!
//! Held-out data take no part in the choice of effects, delays, shapes or scales. They are read once, for the gain of the chosen effects; before
//! that, sessions that are held out whole are only checked for mistakes of the recording, which end a diagnosis.

use crate::effects::Motion;
use crate::timeseries::TimeSeries;

/// Either separate sessions are held out, or the end of every session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Division {
    /// Number of sessions for training; they come first.
    trained: usize,
    /// Number of all sessions.
    sessions: usize,
    /// [1] Part at the end of each session that is held out when no session is held out.
    share: f64,
}

impl Division {
    /// The first `trained` of `sessions` are for training; if these are all sessions, the last `share` (0 to 1) of each is held out.
    pub fn new(trained: usize, sessions: usize, share: f64) -> Self {
        Self { trained, sessions, share }
    }

    /// Whether separate sessions are held out.
    pub fn by_session(&self) -> bool {
        self.trained < self.sessions
    }

    /// Number of sessions for training, in full or without their end.
    pub fn trained(&self) -> usize {
        self.trained
    }

    /// Parts of a session, each as a range from 0 to 1 of its length, and whether the part is held out.
    pub fn parts(&self, session: usize) -> Vec<([f64; 2], bool)> {
        if self.by_session() {
            return vec![([0.0, 1.0], session >= self.trained)];
        }
        let cut = 1.0 - self.share;
        vec![([0.0, cut], false), ([cut, 1.0], true)]
    }

    /// The training part of a session, as a range from 0 to 1 of its length; `None` if all of it is held out.
    pub fn training(&self, session: usize) -> Option<[f64; 2]> {
        self.parts(session).into_iter().find_map(|(part, held_out)| (!held_out).then_some(part))
    }

    /// [s] Time after which a session is held out: infinite if all of it is for training, minus infinity if all of it is held out.
    pub fn held_out_after(&self, number: usize, session: &TimeSeries) -> f64 {
        match self.training(number) {
            None => f64::NEG_INFINITY,
            Some(_) if self.by_session() => f64::INFINITY,
            Some([_, cut]) => match (session.time.first(), session.time.last()) {
                (Some(first), Some(last)) => first + cut * (last - first),
                _ => f64::INFINITY,
            },
        }
    }
}

/// Whether each row is held out.
pub fn held_out_rows(motion: &Motion, sessions: &[&TimeSeries], division: Division) -> Vec<bool> {
    let after: Vec<f64> = (0..sessions.len()).map(|number| division.held_out_after(number, sessions[number])).collect();
    motion.session.iter().zip(&motion.time).map(|(session, time)| *time > after[*session]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn session() -> TimeSeries {
        TimeSeries { time: (0..=100).map(f64::from).collect(), ..TimeSeries::default() }
    }

    #[test]
    fn sessions_of_their_own_are_held_out_whole() {
        let division = Division::new(2, 3, 0.3);
        assert_eq!([0, 1, 2].map(|number| division.training(number)), [Some([0.0, 1.0]), Some([0.0, 1.0]), None]);
        assert_eq!(division.held_out_after(0, &session()), f64::INFINITY);
        assert_eq!(division.held_out_after(2, &session()), f64::NEG_INFINITY);
    }

    #[test]
    fn the_end_of_each_session_is_held_out_where_no_session_is() {
        let division = Division::new(2, 2, 0.3);
        assert_eq!(division.parts(1), [([0.0, 0.7], false), ([0.7, 1.0], true)]);
        assert!((division.held_out_after(1, &session()) - 70.0).abs() < 1e-9);
    }
}
