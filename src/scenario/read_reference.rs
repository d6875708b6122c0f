//! The tables `[reference]` and `[[session]]` of a scenario file: what the joints are to do.
//!
//! Angles and what derives from them may be given in SI (`speed`) or, for turning joints, in degrees (`speed_deg`).

use super::Session;
use super::read::read_added_mass;
use super::read_controller::speed_unit;
use crate::control::{Excitation, Gentle, JointRange, Profile, Staircase, Steps};
use crate::error::Result;
use crate::robot::{Load, Model};
use crate::toml_input::{Range, Table};
use crate::units::{DEG, JointKind};

/// [s] Rest before the first motion where the file gives none: what drifts at rest can be seen in it.
const REST: f64 = 0.5;

/// [s] Recorded after the last motion where the file gives no duration.
const TAIL: f64 = 0.5;

#[derive(Clone, Copy)]
enum Kind {
    Staircase,
    Fast,
    Waypoints,
    Rest,
}

/// A reading of `[reference]` or one `[[session]]`, and what the machine carries in it alone.
pub(super) fn read(table: &Table<'_>, model: &Model, default_name: &str) -> Result<(Session, Option<Load>)> {
    let kinds =
        [("staircase", Kind::Staircase), ("fast", Kind::Fast), ("waypoints", Kind::Waypoints), ("rest", Kind::Rest)];
    let kind = table
        .optional_choice("kind", &kinds)?
        .ok_or_else(|| table.error("kind", "staircase, fast, waypoints or rest"))?;
    let name = table.optional_name("name")?.unwrap_or(default_name).to_owned();
    let rest = table.number_or("rest", &Range::non_negative("s"), REST)?;
    let start = start(table, model)?;
    let mut profile = match kind {
        Kind::Fast => fast(table, model, &start)?,
        _ => Profile::at_rest(&start),
    };
    if !matches!(kind, Kind::Fast) {
        profile.tracks_mut().iter_mut().for_each(|track| track.coast(rest));
    }
    match kind {
        Kind::Staircase => staircase(table, model, &mut profile)?,
        Kind::Waypoints => waypoints(table, model, &mut profile)?,
        Kind::Fast | Kind::Rest => {}
    }
    let whole = profile.duration() + TAIL;
    let duration = match kind {
        Kind::Fast => whole,
        _ => table.number_or("duration", &Range::positive("s"), whole)?,
    };
    let load = read_added_mass(table, &name)?;
    table.finish()?;
    Ok((Session { name, profile, duration }, load))
}

/// Positions at the start, zero where none is given.
fn start(table: &Table<'_>, model: &Model) -> Result<Vec<f64>> {
    let Some(table) = table.optional_table("start")? else { return Ok(vec![0.0; model.joints.len()]) };
    let position = |joint: &crate::robot::JointModel| {
        let range = Range::any(joint.kind.position_unit());
        Ok(angle(&table, &joint.name, joint.kind, &range)?.unwrap_or(0.0))
    };
    let positions = model.joints.iter().map(position).collect::<Result<_>>()?;
    table.finish()?;
    Ok(positions)
}

/// The moving joints, in the order of the file, each with its table.
fn moving<'a>(table: &Table<'a>, model: &Model) -> Result<Vec<(usize, Table<'a>)>> {
    let joints = table.table("joints")?;
    let index = |(name, table): (&str, Table<'a>)| {
        let names = || model.joints.iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>().join(", ");
        let index = model
            .robot
            .joint_index(name)
            .ok_or_else(|| joints.error(name, format!("a joint of the model: {}", names())))?;
        Ok((index, table))
    };
    let found = joints.named_tables()?.into_iter().map(index).collect::<Result<Vec<_>>>()?;
    if found.is_empty() { Err(table.error("joints", "at least one joint that moves")) } else { Ok(found) }
}

fn staircase(table: &Table<'_>, model: &Model, profile: &mut Profile) -> Result<()> {
    for (joint, table) in moving(table, model)? {
        let kind = model.joints[joint].kind;
        let (speed, acceleration, way) = ranges(kind);
        let first = required(&table, "first", kind, &speed)?;
        let last = required(&table, "last", kind, &speed)?;
        if last < first {
            return Err(table.error(if table.has("last") { "last" } else { "last_deg" }, "a speed not below `first`"));
        }
        let stairs = Staircase {
            joint,
            steps: Steps { first, last, increment: required(&table, "increment", kind, &speed)? },
            acceleration: required(&table, "acceleration", kind, &acceleration)?,
            deceleration: required(&table, "deceleration", kind, &acceleration)?,
            gentle: gentle(&table, kind, &speed, &acceleration)?,
            steady_time: table.number_or("steady_time", &Range::non_negative("s"), 1.0)?,
            settling_way: angle(&table, "settling_way", kind, &way)?.unwrap_or(0.0),
            advance: angle(&table, "advance", kind, &way)?.unwrap_or(0.0),
            direction: table.optional_choice("direction", &[("positive", 1.0), ("negative", -1.0)])?.unwrap_or(1.0),
        };
        table.finish()?;
        stairs.append(profile);
    }
    Ok(())
}

/// The steps that brake gently: `gentle_up_to` and `gentle_deceleration`.
fn gentle(table: &Table<'_>, kind: JointKind, speed: &Range, acceleration: &Range) -> Result<Option<Gentle>> {
    let Some(up_to) = angle(table, "gentle_up_to", kind, speed)? else { return Ok(None) };
    let deceleration = required(table, "gentle_deceleration", kind, acceleration)?;
    Ok(Some(Gentle { up_to, deceleration }))
}

fn fast(table: &Table<'_>, model: &Model, start: &[f64]) -> Result<Profile> {
    let mut joints = vec![None; model.joints.len()];
    for (joint, table) in moving(table, model)? {
        let kind = model.joints[joint].kind;
        let (speed, acceleration, _) = ranges(kind);
        let position = Range::any(kind.position_unit());
        joints[joint] = Some(JointRange {
            positions: [required(&table, "lowest", kind, &position)?, required(&table, "highest", kind, &position)?],
            speed: required(&table, "speed", kind, &speed)?,
            acceleration: required(&table, "acceleration", kind, &acceleration)?,
        });
        table.finish()?;
    }
    let excitation = Excitation {
        joints,
        duration: table.number("duration", &Range::positive("s"))?,
        longest_rest: table.number_or("longest_rest", &Range::non_negative("s"), 0.5)?,
        seed: table.optional_integer("seed", 0, i64::MAX)?.unwrap_or(1).unsigned_abs(),
    };
    Ok(excitation.profile(start))
}

fn waypoints(table: &Table<'_>, model: &Model, profile: &mut Profile) -> Result<()> {
    for (joint, table) in moving(table, model)? {
        let kind = model.joints[joint].kind;
        let (speed, acceleration, _) = ranges(kind);
        let speed = required(&table, "speed", kind, &speed)?;
        let acceleration = required(&table, "acceleration", kind, &acceleration)?;
        let rest = table.number_or("rest", &Range::non_negative("s"), 0.0)?;
        let (positions, scale) = match kind {
            JointKind::Revolute if table.has("positions_deg") => {
                (table.optional_numbers("positions_deg", &Range::any("°"))?, DEG)
            }
            _ => (table.optional_numbers("positions", &Range::any(kind.position_unit()))?, 1.0),
        };
        let positions = positions.ok_or_else(|| table.error("positions", "a list of places to go to"))?;
        table.finish()?;
        let track = &mut profile.tracks_mut()[joint];
        for position in positions {
            track.move_to(position * scale, speed, acceleration);
            track.coast(rest);
        }
    }
    Ok(())
}

/// Ranges of a speed, an acceleration and a way.
fn ranges(kind: JointKind) -> (Range, Range, Range) {
    let acceleration = match kind {
        JointKind::Revolute => "rad/s²",
        JointKind::Prismatic => "m/s²",
    };
    (Range::positive(speed_unit(kind)), Range::positive(acceleration), Range::non_negative(kind.position_unit()))
}

/// `key` in SI, or `key_deg` in degrees where the joint turns.
fn angle(table: &Table<'_>, key: &str, kind: JointKind, range: &Range) -> Result<Option<f64>> {
    let degrees = format!("{key}_deg");
    if kind == JointKind::Revolute && table.has(&degrees) {
        // The range of the SI value says nothing of units here; its sign does.
        let value = table.number(&degrees, &Range::any("°"))? * DEG;
        return if range.holds(value) {
            Ok(Some(value))
        } else {
            Err(table.error(&degrees, format!("{range}, given in degrees")))
        };
    }
    table.optional_number(key, range)
}

fn required(table: &Table<'_>, key: &str, kind: JointKind, range: &Range) -> Result<f64> {
    match angle(table, key, kind, range)? {
        Some(value) => Ok(value),
        None => table.number(key, range),
    }
}
