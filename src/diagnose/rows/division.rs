//! Which part of the recordings is trained on, and which is held out.
//!
//! What is held out takes no part in the choice of effects, delays, shapes or scales. It is read once, for the gain of what was chosen.

use crate::effects::Motion;
use crate::timeseries::TimeSeries;

/// Sessions of their own are held out, or where there are none, the end of every session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Division {
    /// Sessions that are trained on; they come first.
    trained: usize,
    /// All sessions.
    sessions: usize,
    /// [1] Part at the end of each session that is held out where no session is.
    share: f64,
}

impl Division {
    /// The first `trained` of `sessions` are trained on; if these are all, each but its last `share` (0 to 1).
    pub fn new(trained: usize, sessions: usize, share: f64) -> Self {
        Self { trained, sessions, share }
    }

    /// Whether sessions of their own are held out.
    pub fn by_session(&self) -> bool {
        self.trained < self.sessions
    }

    /// Number of sessions that are trained on, wholly or but for their end.
    pub fn trained(&self) -> usize {
        self.trained
    }

    /// Parts of a session, each from 0 to 1 of its length, and whether it is held out.
    pub fn parts(&self, session: usize) -> Vec<([f64; 2], bool)> {
        if self.by_session() {
            return vec![([0.0, 1.0], session >= self.trained)];
        }
        let cut = 1.0 - self.share;
        vec![([0.0, cut], false), ([cut, 1.0], true)]
    }

    /// The part of a session that is trained on, from 0 to 1 of its length; `None` where there is none.
    pub fn training(&self, session: usize) -> Option<[f64; 2]> {
        self.parts(session).into_iter().find_map(|(part, held_out)| (!held_out).then_some(part))
    }

    /// [s] Time after which a session is held out: infinite where all of it is trained on, and minus infinity where none is.
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
