//! What links were pressed against in a session, and what a scenario expects of it.

use std::fmt;

use super::Run;
use crate::plant::Touch;
use crate::timeseries::TimeSeries;

/// A link pressed against an obstacle, or a joint against its end stop.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// Name of the link.
    pub link: String,
    /// The joint that moves it.
    pub joint: String,
    /// Name of the obstacle; `None`: the joint's own end stop.
    pub obstacle: Option<String>,
    /// [N], of an end stop [N·m or N], one a sample of the session; 0 where they do not touch.
    pub force: Vec<f64>,
}

impl Contact {
    /// [s] of the first and the last sample at which they touch.
    pub fn time(&self, session: &TimeSeries) -> Option<[f64; 2]> {
        let touched = |force: &f64| *force > 0.0;
        let (first, last) = (self.force.iter().position(touched)?, self.force.iter().rposition(touched)?);
        Some([session.time[first], session.time[last]])
    }

    /// Largest force of the samples.
    pub fn peak(&self) -> f64 {
        self.force.iter().copied().fold(0.0, f64::max)
    }

    /// How often they met: samples at which they touch after one at which they did not.
    pub fn times_met(&self) -> usize {
        let before = std::iter::once(&0.0).chain(&self.force);
        before.zip(&self.force).filter(|&(&before, &now)| before == 0.0 && now > 0.0).count()
    }
}

/// Forces of a session as they are recorded.
#[derive(Debug, Clone, Default)]
pub(super) struct ContactRecorder {
    samples: usize,
    /// Body, obstacle, and force a sample; short of the samples since it was last touched.
    forces: Vec<(usize, Option<usize>, Vec<f64>)>,
}

impl ContactRecorder {
    /// Takes a sample.
    pub fn sample(&mut self, touches: impl Iterator<Item = Touch>) {
        for Touch { body, obstacle, force } in touches {
            let known = self.forces.iter().position(|(link, other, _)| (*link, *other) == (body, obstacle));
            let index = known.unwrap_or_else(|| {
                self.forces.push((body, obstacle, Vec::new()));
                self.forces.len() - 1
            });
            let forces = &mut self.forces[index].2;
            forces.resize(self.samples + 1, 0.0);
            forces[self.samples] += force;
        }
        self.samples += 1;
    }

    /// The contacts, in the order in which they were first met.
    pub fn finish(self, model: &crate::robot::Model, obstacles: &[crate::plant::Obstacle]) -> Vec<Contact> {
        let contact = |(body, obstacle, mut force): (usize, Option<usize>, Vec<f64>)| {
            force.resize(self.samples, 0.0);
            let moved = &model.robot.bodies[body];
            let obstacle = obstacle.map(|index| obstacles[index].shape.link.clone());
            Contact { link: moved.name.clone(), joint: moved.joint.name.clone(), obstacle, force }
        };
        self.forces.into_iter().map(contact).collect()
    }
}

/// What can be expected of an obstacle, and its unit.
pub(super) const CONTACT_QUANTITIES: [(&str, &str); 3] =
    [("first_touch", "s"), ("peak_force", "N"), ("last_force", "N")];

/// A quantity of a contact that must come out within a range, in the first session in which the obstacle is touched.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactExpectation {
    /// The obstacle.
    pub obstacle: String,
    /// `first_touch` [s], `peak_force` [N], `last_force` [N]: at the last sample.
    pub quantity: &'static str,
    /// Least and greatest value.
    pub range: [f64; 2],
}

/// A [`ContactExpectation`] that failed.
#[derive(Debug, Clone, PartialEq)]
pub struct UnmetContact {
    /// What was expected.
    pub expectation: ContactExpectation,
    /// What came out; `None` where nothing touched the obstacle.
    pub found: Option<f64>,
}

impl ContactExpectation {
    /// What fails of it.
    pub fn check(&self, run: &Run) -> Option<UnmetContact> {
        let touched = |contact: &&Contact| contact.obstacle.as_deref() == Some(self.obstacle.as_str());
        let found = run.sessions.iter().zip(&run.contacts).find_map(|(session, contacts)| {
            let contact = contacts.iter().find(touched)?;
            match self.quantity {
                "first_touch" => contact.time(session).map(|[first, _]| first),
                "peak_force" => Some(contact.peak()),
                _ => contact.force.last().copied(),
            }
        });
        let met = found.is_some_and(|found| (self.range[0]..=self.range[1]).contains(&found));
        (!met).then(|| UnmetContact { expectation: self.clone(), found })
    }
}

impl fmt::Display for UnmetContact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ContactExpectation { obstacle, quantity, range: [least, greatest] } = &self.expectation;
        match self.found {
            Some(found) => write!(f, "{obstacle}: {quantity} is {found:.4}, expected {least} to {greatest}"),
            None => write!(f, "{obstacle}: nothing touched it, expected {quantity} of {least} to {greatest}"),
        }
    }
}
