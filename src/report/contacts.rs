//! The contacts of a simulated run, for readers.

use serde_json::{Value, json};

use super::document::Section;
use super::recording::{Motion, Trace};
use super::{Role, Table};
use crate::scenario::{Contact, Run};
use crate::timeseries::Envelope;

/// A table of the contacts; `None` if there were none.
pub fn section(run: &Run) -> Option<Section> {
    let heads = ["session", "link", "against", "first [s]", "last [s]", "met", "peak force"];
    let mut table = Table::new("", &heads);
    for (session, contact) in touched(run) {
        let [first, last] = contact.time(session).unwrap_or_default().map(|time| format!("{time:.3}"));
        let unit = if contact.obstacle.is_some() { "N" } else { "N·m or N" };
        let (met, peak) = (contact.times_met().to_string(), format!("{:.1} {unit}", contact.peak()));
        table.row([session.name.clone(), contact.link.clone(), against(contact), first, last, met, peak]);
    }
    let title = "What was touched".to_owned();
    (!table.rows.is_empty()).then(|| Section { title, tables: vec![table], ..Section::default() })
}

/// The same for programs.
pub fn json(run: &Run) -> Vec<Value> {
    let entry = |(session, contact): (&crate::timeseries::TimeSeries, &Contact)| {
        json!({ "session": session.name, "link": contact.link, "joint": contact.joint, "obstacle": contact.obstacle,
            "time": contact.time(session), "times_met": contact.times_met(), "peak_force": contact.peak() })
    };
    touched(run).map(entry).collect()
}

/// Adds the contact forces to the motion of a session with those sample times: each force is shown at every joint that
/// carries it.
pub fn trace(motion: &mut Motion<'_>, time: &[f64], contacts: &[Contact]) {
    for contact in contacts {
        let force = Envelope::of(time, contact.force.iter().copied());
        let bodies = &motion.robot.bodies;
        let moved = motion.robot.joint_index(&contact.joint);
        let (panel, label, above) = match contact.obstacle {
            Some(_) => ("force", "obstacle", usize::MAX),
            None => ("torque", "end_stop", 1),
        };
        for body in std::iter::successors(moved, |&body| bodies[body].parent).take(above) {
            motion.traces.push(Trace {
                joint: bodies[body].joint.name.clone(),
                panel,
                label,
                role: Role::Before,
                time: force.time.clone(),
                values: force.values.clone(),
            });
        }
    }
}

fn touched(run: &Run) -> impl Iterator<Item = (&crate::timeseries::TimeSeries, &Contact)> {
    let of_session = |(session, contacts): (_, _)| std::iter::repeat(session).zip::<&Vec<Contact>>(contacts);
    run.sessions.iter().zip(&run.contacts).flat_map(of_session)
}

fn against(contact: &Contact) -> String {
    contact.obstacle.clone().unwrap_or_else(|| format!("end stop of {}", contact.joint))
}
