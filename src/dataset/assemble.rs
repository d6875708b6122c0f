//! From the columns of a plan to the signals of a session: units, time, checks.

use std::collections::HashMap;
use std::path::Path;

use super::bounds;
use super::plan::{Plan, PlannedJoint, Source};
use super::table::Table;
use super::time_base::TimeUnit;
use super::{JointLimits, Session, checks};
use crate::error::{Error, Place, Result};
use crate::timeseries::{JointSeries, Samples, TimeSeries};

/// [s] Time that begins later than this, or earlier than its negative, is counted from the first sample: it is likely a
/// time since 1970. Above this value, an `f64` resolves time no better than 1e-10 s.
const FAR: f64 = 1e6;

/// Takes the planned columns from a table and checks them.
///
/// # Errors
/// A column is missing, or its content cannot be used.
pub(super) fn assemble(mut table: Table, mut plan: Plan, limits: &JointLimits) -> Result<Session> {
    let mut notes = std::mem::take(&mut table.notes);
    notes.append(&mut plan.notes);
    plan.find_names(&table)?;
    let (time, unit) = time(&table, &plan)?;
    let sources = || plan.joints.iter().flat_map(|joint| joint.channels.iter().map(|(_, source)| source));
    // A column is copied only if another channel uses it too.
    let mut uses: HashMap<&str, usize> = HashMap::new();
    sources().for_each(|source| *uses.entry(&source.column).or_default() += 1);
    let mut signals = vec![(plan.time.column.clone(), time)];
    for source in sources() {
        let left = uses.entry(&source.column).or_default();
        *left -= 1;
        signals.push((source.column.clone(), values(&mut table, source, *left == 0)?));
    }
    table.columns.clear();
    checks::lengths(&table.file, &signals)?;
    checks::finite(&table.file, &signals)?;
    let mut columns = signals[1..].iter();
    for joint in &plan.joints {
        for ((channel, _), (name, values)) in joint.channels.iter().zip(columns.by_ref()) {
            bounds::physical(&table.file, name, *channel, joint.kind, values)?;
            notes.extend(bounds::outside_limits(&table.file, name, *channel, joint, values, limits));
        }
    }
    checks::check(&table.file, &mut signals, &unit, &mut notes)?;
    let (time, columns) = (&signals[0].1, &signals[1..]);
    let channels =
        plan.joints.iter().flat_map(|joint| joint.channels.iter().map(|(channel, _)| (*channel, joint.kind)));
    for (channel, (name, values)) in channels.zip(columns) {
        bounds::continuous(&table.file, name, channel, time, values)?;
    }
    Ok(session(table.file.as_path(), plan.name, plan.joints, signals, notes))
}

fn session(
    source: &Path,
    name: String,
    planned: Vec<PlannedJoint>,
    signals: Vec<(String, Vec<f64>)>,
    notes: Vec<super::Note>,
) -> Session {
    let mut signals = signals.into_iter().map(|(_, values)| values);
    let time = signals.next().unwrap_or_default();
    let mut signals = signals.map(Samples::from);
    let mut controllers = Vec::new();
    let mut joints = Vec::new();
    for PlannedJoint { name, channels, controller, .. } in planned {
        let channels = channels.into_iter().map(|(channel, _)| channel).zip(signals.by_ref()).collect();
        joints.push(JointSeries { name, channels });
        controllers.push(controller);
    }
    Session { series: TimeSeries { name, time, joints }, notes, source: source.to_owned(), controllers }
}

/// [s] The time, and the source of its unit.
fn time(table: &Table, plan: &Plan) -> Result<(Vec<f64>, TimeUnit)> {
    let source = &plan.time;
    let column = table.wanted(&source.column, source.named_at.as_ref())?;
    if let Some(rest) = &plan.nanoseconds {
        let seconds = column.values.iter().map(|value| value - column.values[0]);
        let rest = table.wanted(&rest.column, rest.named_at.as_ref())?;
        let time = seconds.zip(&rest.values).map(|(seconds, rest_)| seconds + (rest_ - rest.values[0]) * 1e-9);
        return Ok((time.collect(), TimeUnit::Typed));
    }
    let (factor, unit) = match (column.seconds, plan.time_unit.clone()) {
        (Some(seconds), None) => (seconds, TimeUnit::Typed),
        (Some(seconds), Some(unit)) if unit == "s" => (seconds, TimeUnit::Typed),
        (Some(_), Some(unit)) => {
            let expected = "no unit: the column holds time stamps, whose unit the file itself defines";
            let (file, place) =
                source.named_at.as_ref().map_or((&table.file, Place::File), |(file, place, _)| (file, *place));
            return Err(Error::input(file, place, "time.unit", unit, expected));
        }
        (None, Some(unit)) => (source.factor, TimeUnit::Given(unit)),
        (None, None) if source.named_at.is_some() => (source.factor, TimeUnit::Manifest),
        (None, None) => (source.factor, TimeUnit::Canonical),
    };
    let first = column.values.first().copied().unwrap_or(0.0);
    let far = column.origin != 0 || (first * factor).abs() > FAR;
    let begin = if far { first } else { 0.0 };
    Ok((column.values.iter().map(|value| (value - begin) * factor).collect(), unit))
}

/// The values of a channel. The `last` channel that uses a column takes the values out of the table.
fn values(table: &mut Table, source: &Source, last: bool) -> Result<Vec<f64>> {
    let column = table.wanted(&source.column, source.named_at.as_ref())?;
    let (origin, factor) = (column.origin as f64, source.factor * column.seconds.unwrap_or(1.0));
    let mut values = if last { table.take_values(&source.column) } else { column.values.clone() };
    if origin != 0.0 {
        values.iter_mut().for_each(|value| *value += origin);
    }
    if factor != 1.0 {
        values.iter_mut().for_each(|value| *value *= factor);
    }
    Ok(values)
}
