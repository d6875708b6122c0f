//! The tables `[reference]` and `[[session]]` of a scenario file: the motion of the joints.
//!
//! `kind = "torque"` imposes a wave of torque on a joint instead of a motion: `shape` (square, triangle), `amplitude` [N·m or N] at the
//! joint, `period` [s], `cycles`. The controller holds the other joints.
//!
//! Angles and what derives from them may be given in SI (`speed`) or, for turning joints, in degrees (`speed_deg`).

use super::{Session, ranges, read_added_mass, read_speeds};
use crate::control::{Excitation, Gentle, JointRange, Profile, Shape, Staircase, Steps, TooManyMoves, TorqueWave};
use crate::error::{Error, Place, Result};
use crate::robot::{Load, Model};
use crate::toml_input::{Range, Table};
use crate::units::{DEG, JointKind};

/// [s] Rest before the first motion if the file gives none; it shows drift at rest.
const REST: f64 = 0.5;

/// Largest number of speeds of a staircase.
pub(super) const MOST_STEPS: f64 = 10_000.0;

/// Largest number of positions of a joint.
const MOST_PLACES: usize = 100_000;

/// [s] Time recorded after the last motion if the file gives no duration.
const TAIL: f64 = 0.5;

#[derive(Clone, Copy)]
enum Kind {
    Staircase,
    Speeds,
    Fast,
    Waypoints,
    Rest,
    Torque,
}

/// Result of reading `[reference]` or one `[[session]]`, with the load of the machine in this session.
pub(super) fn read(table: &Table<'_>, model: &Model, default_name: &str) -> Result<(Session, Option<Load>)> {
    let kinds = [
        ("staircase", Kind::Staircase),
        ("speeds", Kind::Speeds),
        ("fast", Kind::Fast),
        ("waypoints", Kind::Waypoints),
        ("rest", Kind::Rest),
        ("torque", Kind::Torque),
    ];
    let kind = table
        .optional_choice("kind", &kinds)?
        .ok_or_else(|| table.error("kind", "staircase, speeds, fast, waypoints, rest or torque"))?;
    let name = table.optional_name("name")?.unwrap_or(default_name).to_owned();
    let rest = table.number_or("rest", &ranges::DURATION, REST)?;
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
        Kind::Speeds => {
            for (joint, table) in moving(table, model)? {
                read_speeds::read(&table, joint, model.joints[joint].kind)?.append(&mut profile);
            }
        }
        Kind::Waypoints => waypoints(table, model, &mut profile)?,
        Kind::Torque => torque(table, model, &mut profile)?,
        Kind::Fast | Kind::Rest => {}
    }
    let whole = profile.duration() + TAIL;
    if whole.is_nan() || whole > ranges::LONGEST_SESSION {
        let expected = format!(
            "a motion of at most {:e} s, not {whole:.3e} s: faster, shorter or fewer moves",
            ranges::LONGEST_SESSION
        );
        return Err(Error::input(table.file(), table.place("kind"), table.path(), "", expected));
    }
    let duration = match kind {
        Kind::Fast => whole,
        _ => table.number_or("duration", &ranges::LENGTH, whole)?,
    };
    let load = read_added_mass::read(table, &name)?;
    table.finish()?;
    Ok((Session { name, profile, duration, place: own_place(table) }, load))
}

/// Line and key of a session.
fn own_place(table: &Table<'_>) -> (Place, String) {
    (table.place(if table.has("name") { "name" } else { "kind" }), table.path().to_owned())
}

/// Positions at the start; zero if none is given.
fn start(table: &Table<'_>, model: &Model) -> Result<Vec<f64>> {
    let Some(table) = table.optional_table("start")? else { return Ok(vec![0.0; model.joints.len()]) };
    let position = |joint: &crate::robot::JointModel| {
        let range = ranges::position(joint.kind);
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
        let (speed, acceleration, way) = of_motion(kind);
        let first = required(&table, "first", kind, &speed)?;
        let last = required(&table, "last", kind, &speed)?;
        if last < first {
            return Err(table.error(if table.has("last") { "last" } else { "last_deg" }, "a speed not below `first`"));
        }
        let steps = Steps { first, last, increment: required(&table, "increment", kind, &speed)? };
        if steps.count() > MOST_STEPS {
            let key = if table.has("increment") { "increment" } else { "increment_deg" };
            return Err(
                table.error(key, format!("at most {MOST_STEPS} steps from first to last, not {:.3e}", steps.count()))
            );
        }
        let stairs = Staircase {
            joint,
            steps,
            acceleration: required(&table, "acceleration", kind, &acceleration)?,
            deceleration: required(&table, "deceleration", kind, &acceleration)?,
            gentle: gentle(&table, kind, &speed, &acceleration)?,
            steady_time: table.number_or("steady_time", &ranges::DURATION, 1.0)?,
            settling_way: angle(&table, "settling_way", kind, &way)?.unwrap_or(0.0),
            advance: angle(&table, "advance", kind, &way)?.unwrap_or(0.0),
            direction: table.optional_choice("direction", &[("positive", 1.0), ("negative", -1.0)])?.unwrap_or(1.0),
        };
        table.finish()?;
        stairs.append(profile);
    }
    Ok(())
}

/// The steps with gentle braking: `gentle_up_to` and `gentle_deceleration`.
fn gentle(table: &Table<'_>, kind: JointKind, speed: &Range, acceleration: &Range) -> Result<Option<Gentle>> {
    let Some(up_to) = angle(table, "gentle_up_to", kind, speed)? else { return Ok(None) };
    let deceleration = required(table, "gentle_deceleration", kind, acceleration)?;
    Ok(Some(Gentle { up_to, deceleration }))
}

fn fast(table: &Table<'_>, model: &Model, start: &[f64]) -> Result<Profile> {
    let mut joints = vec![None; model.joints.len()];
    for (joint, table) in moving(table, model)? {
        let kind = model.joints[joint].kind;
        let (speed, acceleration, _) = of_motion(kind);
        let position = ranges::position(kind);
        let positions = [required(&table, "lowest", kind, &position)?, required(&table, "highest", kind, &position)?];
        if positions[0] >= positions[1] {
            let key = if table.has("highest") { "highest" } else { "highest_deg" };
            return Err(table.error(key, "a position above `lowest`"));
        }
        joints[joint] = Some(JointRange {
            positions,
            speed: required(&table, "speed", kind, &speed)?,
            acceleration: required(&table, "acceleration", kind, &acceleration)?,
        });
        table.finish()?;
    }
    let excitation = Excitation {
        joints,
        duration: table.number("duration", &ranges::LENGTH)?,
        longest_rest: table.number_or("longest_rest", &ranges::DURATION, 0.5)?,
        seed: table.optional_integer("seed", 0, i64::MAX)?.unwrap_or(1).unsigned_abs(),
    };
    excitation.profile(start).map_err(|TooManyMoves { joint, most }| {
        let name = &model.joints[joint].name;
        let expected = format!(
            "a duration of at most {most} moves of {name}; `lowest` and `highest` may be too close to each other"
        );
        table.error("duration", expected)
    })
}

fn waypoints(table: &Table<'_>, model: &Model, profile: &mut Profile) -> Result<()> {
    for (joint, table) in moving(table, model)? {
        let kind = model.joints[joint].kind;
        let (speed, acceleration, _) = of_motion(kind);
        let speed = required(&table, "speed", kind, &speed)?;
        let acceleration = required(&table, "acceleration", kind, &acceleration)?;
        let rest = table.number_or("rest", &ranges::DURATION, 0.0)?;
        let (positions, scale) = match kind {
            JointKind::Revolute if table.has("positions_deg") => {
                (table.optional_numbers("positions_deg", &ranges::DEGREES)?, DEG)
            }
            _ => (table.optional_numbers("positions", &ranges::position(kind))?, 1.0),
        };
        let positions = positions.ok_or_else(|| table.error("positions", "a list of positions to move to"))?;
        if positions.len() > MOST_PLACES {
            let key = if table.has("positions_deg") { "positions_deg" } else { "positions" };
            return Err(table.error(key, format!("at most {MOST_PLACES} positions, not {}", positions.len())));
        }
        table.finish()?;
        let track = &mut profile.tracks_mut()[joint];
        for position in positions {
            track.move_to(position * scale, speed, acceleration);
            track.coast(rest);
        }
    }
    Ok(())
}

/// A wave of torque of every joint of the table; the controller holds the others.
fn torque(table: &Table<'_>, model: &Model, profile: &mut Profile) -> Result<()> {
    for (joint, table) in moving(table, model)? {
        let shapes = [("square", Shape::Square), ("triangle", Shape::Triangle)];
        let shape =
            table.optional_choice("shape", &shapes)?.ok_or_else(|| table.error("shape", "square or triangle"))?;
        let wave = TorqueWave {
            shape,
            amplitude: table.number("amplitude", &ranges::torque(model.joints[joint].kind))?,
            period: table.number("period", &ranges::PERIOD)?,
            cycles: table.number("cycles", &Range::positive("").up_to(1e6))?,
            start: 0.0,
        };
        table.finish()?;
        profile.tracks_mut()[joint].impose(wave);
    }
    Ok(())
}

/// Ranges of a speed, an acceleration and a distance.
pub(super) fn of_motion(kind: JointKind) -> (Range, Range, Range) {
    (ranges::speed(kind), ranges::acceleration(kind), ranges::way(kind))
}

/// `key` in SI, or `key_deg` in degrees if the joint turns.
fn angle(table: &Table<'_>, key: &str, kind: JointKind, range: &Range) -> Result<Option<f64>> {
    let degrees = format!("{key}_deg");
    if kind == JointKind::Revolute && table.has(&degrees) {
        let value = table.number(&degrees, &Range::any("°"))? * DEG;
        return if range.holds(value) {
            Ok(Some(value))
        } else {
            Err(table.error(&degrees, format!("{range} after conversion from degrees")))
        };
    }
    table.optional_number(key, range)
}

pub(super) fn required(table: &Table<'_>, key: &str, kind: JointKind, range: &Range) -> Result<f64> {
    match angle(table, key, kind, range)? {
        Some(value) => Ok(value),
        None => table.number(key, range),
    }
}
