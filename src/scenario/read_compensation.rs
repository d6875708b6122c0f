//! The table `[compensation]` of a scenario file.

use super::tracking::TAIL;
use super::{Procedure, Session, TrackingPlan, ranges, read_reference};
use crate::error::Result;
use crate::robot::{Load, Model};
use crate::toml_input::{Range, Table};

/// Name of the tracking session if the file gives none.
const NAME: &str = "tracking";

/// Reads `crossing_time` and `[compensation.motion]`, which the procedure `compensate` needs and no other takes.
pub(super) fn read(
    root: &Table<'_>,
    model: &Model,
    procedure: Procedure,
    sessions: &[Session],
) -> Result<Option<(TrackingPlan, Option<Load>)>> {
    let compensates = procedure == Procedure::Compensate;
    let Some(table) = root.optional_table("compensation")? else {
        let missing = || root.error("compensation", "the motion to be tracked, `[compensation.motion]` (missing)");
        return if compensates { Err(missing()) } else { Ok(None) };
    };
    if !compensates {
        return Err(root.error("compensation", "a scenario with procedure = \"compensate\""));
    }
    let crossing_time = table.number("crossing_time", &Range::positive("s").up_to(10.0))?;
    let motion = table.table("motion")?;
    let (session, load) = read_reference::read(&motion, model, NAME)?;
    if sessions.iter().any(|other| other.name.eq_ignore_ascii_case(&session.name)) {
        return Err(motion.error("name", format!("a name that no session has; `{}` is taken", session.name)));
    }
    let (needed, moving) = (session.profile.duration() + TAIL, session.profile.way() > 0.0);
    if !moving {
        return Err(motion.error("kind", "a motion that moves at least one joint"));
    }
    if session.duration < needed && motion.has("duration") {
        return Err(motion.error("duration", format!("at least {needed:.3} s: {TAIL} s of rest after the motion")));
    }
    let duration = session.duration.max(needed).min(ranges::LONGEST_SESSION);
    table.finish()?;
    Ok(Some((TrackingPlan { session: Session { duration, ..session }, crossing_time }, load)))
}
