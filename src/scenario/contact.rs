//! Contacts of links in a session, and expectations of a scenario about them.

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
    /// [N], of an end stop [N·m or N], one value per sample of the session; 0 without contact.
    pub force: Vec<f64>,
}

impl Contact {
    /// [s] of the first and the last sample with contact.
    pub fn time(&self, session: &TimeSeries) -> Option<[f64; 2]> {
        let touched = |force: &f64| *force > 0.0;
        let (first, last) = (self.force.iter().position(touched)?, self.force.iter().rposition(touched)?);
        Some([session.time[first], session.time[last]])
    }

    /// Largest force.
    pub fn peak(&self) -> f64 {
        self.force.iter().copied().fold(0.0, f64::max)
    }

    /// Number of contacts: samples with contact after a sample without.
    pub fn times_met(&self) -> usize {
        let before = std::iter::once(&0.0).chain(&self.force);
        before.zip(&self.force).filter(|&(&before, &now)| before == 0.0 && now > 0.0).count()
    }
}

/// Forces of a session while it is recorded.
#[derive(Debug, Clone, Default)]
pub(super) struct ContactRecorder {
    samples: usize,
    /// Body, obstacle, and force per sample; it ends at the last sample with contact.
    forces: Vec<(usize, Option<usize>, Vec<f64>)>,
}

impl ContactRecorder {
    /// Adds a sample.
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

    /// The contacts, in the order of their first samples.
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

/// Quantities that can be expected of an obstacle, with their units.
pub(super) const CONTACT_QUANTITIES: [(&str, &str); 3] =
    [("first_touch", "s"), ("peak_force", "N"), ("last_force", "N")];

/// A quantity of a contact and its required range, in the first session in which the obstacle is touched.
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
    /// The value found; `None` if nothing touched the obstacle.
    pub found: Option<f64>,
}

impl ContactExpectation {
    /// The part of it that is not met.
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
