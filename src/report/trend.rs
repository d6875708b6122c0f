//! Trends over repeated identifications, for readers: a table and a control chart of every parameter.

use serde_json::json;

use super::display;
use super::document::{Document, Section};
use super::files::{Report, envelope};
use super::number;
use super::plot::{Layer, Mark, Plot, Role};
use super::results::symbol;
use super::table::Table;
use crate::identify::trend::{Repeat, Trend};

/// What the trends were computed from.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// Name of the machine or scenario.
    pub name: &'a str,
    /// The files, in the order of time.
    pub files: &'a [String],
    /// Their times.
    pub times: &'a [f64],
    /// Unit of the times: `d`, or `result` if they are counted.
    pub unit_of_time: &'a str,
    /// Probability that any change is named although there is none.
    pub level: f64,
}

/// The report of the trends.
pub fn report<'a>(source: &Source<'_>, trends: &[Trend]) -> Report<'a> {
    let Source { name, files, unit_of_time, level, .. } = *source;
    let changes: Vec<_> = trends
        .iter()
        .filter(|trend| trend.changed)
        .map(|trend| json!({ "joint": trend.history.joint, "parameter": trend.history.parameter }))
        .collect();
    let content = json!({
        "results": files, "unit_of_time": unit_of_time, "level": level, "changes": changes, "parameters": trends,
    });
    Report {
        document: document(source, trends),
        json: envelope("lostmotion/trend/1", name, content),
        motions: Vec::new(),
        model: None,
        extra: Vec::new(),
    }
}

/// The document of the trends.
fn document(source: &Source<'_>, trends: &[Trend]) -> Document {
    let changed: Vec<String> = trends.iter().filter(|trend| trend.changed).map(sentence).collect();
    let verdict = if changed.is_empty() {
        "No parameter has a trend, as far as these results show.".to_owned()
    } else {
        changed.join("\n")
    };
    let text = format!(
        "A change is named where the p-value of its trend is at most its limit. The limits follow from the {} parameters tested: \
         the probability that any change is named although there is none is at most {}.",
        trends.len(),
        number::significant(source.level, 2)
    );
    let mut section = Section { text: vec![text], ..Section::new("Trends") };
    section.tables.push(table(trends));
    section.plots = trends.iter().map(|trend| chart(trend, source.unit_of_time)).collect();
    Document {
        title: format!("{}: trend over {} results", source.name, source.files.len()),
        verdict,
        warnings: trends.iter().flat_map(|trend| apart(source, trend)).collect(),
        sections: vec![section],
        ..Document::default()
    }
}

/// The results of a parameter that were left out.
fn apart(source: &Source<'_>, trend: &Trend) -> Vec<String> {
    let name = symbol(&trend.history.parameter);
    let sentence = |one: &Repeat| {
        let file = source.times.iter().position(|time| *time == one.time).map_or("", |k| source.files[k].as_str());
        let unit = &trend.history.unit;
        let others = trend.at(one.time);
        format!(
            "{file}: {name} of {} is {}, where the other results give {}; it was left out",
            trend.history.joint,
            display::estimate(one.value, one.std_error, unit),
            display::estimate(others.value, others.std_error, unit),
        )
    };
    trend.left_out.iter().map(sentence).collect()
}

/// One change in a sentence.
fn sentence(trend: &Trend) -> String {
    let start = &trend.start;
    format!(
        "{} of {} has changed by {:+.1} %: {} from {} (p = {:.1e}).",
        symbol(&trend.history.parameter),
        trend.history.joint,
        trend.change_percent,
        display::estimate(trend.change.value, trend.change.std_error, &start.unit),
        display::estimate(start.value, start.std_error, &start.unit),
        trend.p_value
    )
}

fn table(trends: &[Trend]) -> Table {
    let heads = [
        "joint",
        "parameter",
        "at the start",
        "change",
        "95 % interval",
        "unit",
        "change",
        "excess scatter",
        "p",
        "limit",
        "",
    ];
    let mut table = Table::new("Change from the first result to the last", &heads);
    for trend in trends {
        let (unit, factor) = display::shown(&trend.history.unit);
        let of = |value: f64, std_error: f64| number::with_error(value * factor, std_error * factor).0;
        let change = &trend.change;
        table.row([
            trend.history.joint.clone(),
            symbol(&trend.history.parameter),
            of(trend.start.value, trend.start.std_error),
            of(change.value, change.std_error),
            number::interval(change.interval.map(|end| end * factor)),
            unit.to_owned(),
            number::percent(trend.change_percent),
            number::significant(trend.excess_scatter * factor, 2),
            number::significant(trend.p_value, 2),
            number::significant(trend.p_limit, 2),
            if trend.changed { "changed".to_owned() } else { String::new() },
        ]);
    }
    table
}

/// The control chart of a parameter: results with their standard errors, mean and 95 % limits of a single result without a trend, and
/// the line with its 95 % interval.
fn chart(trend: &Trend, unit_of_time: &str) -> Plot {
    let (unit, factor) = display::shown(&trend.history.unit);
    let repeats = &trend.history.repeats;
    let at_each = |of: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
        repeats.iter().enumerate().map(|(k, one)| [one.time, of(k) * factor]).collect()
    };
    let limit = |side: usize| at_each(&|k| trend.limits(&repeats[k])[side]);
    let end = |side: usize| at_each(&|k| trend.at(repeats[k].time).interval[side]);
    let outline = end(0).into_iter().chain(end(1).into_iter().rev()).collect();
    let apart: Vec<[f64; 2]> = trend.left_out.iter().map(|one| [one.time, one.value * factor]).collect();
    let bars = repeats.iter().flat_map(|one| {
        let ends = [one.value - one.std_error, one.value + one.std_error];
        [[one.time, ends[0] * factor], [one.time, ends[1] * factor], [f64::NAN, f64::NAN]]
    });
    let bars = bars.collect();
    Plot::new(
        format!("{}: {}", trend.history.joint, symbol(&trend.history.parameter)),
        if unit_of_time == "d" { "time [d]".to_owned() } else { "result".to_owned() },
        format!("{} [{unit}]", symbol(&trend.history.parameter)),
    )
    .with(Layer::new("95 % of the trend", Mark::Band, Role::Fit, outline))
    .with(Layer::new("mean", Mark::Line, Role::Reference, at_each(&|_| trend.mean.value)))
    .with(Layer::new("95 % limits without a trend", Mark::Dashed, Role::Reference, limit(0)))
    .with(Layer::new("", Mark::Dashed, Role::Reference, limit(1)))
    .with(Layer::new("trend", Mark::Line, Role::Fit, at_each(&|k| trend.at(repeats[k].time).value)))
    .with(Layer::new("", Mark::Line, Role::Measured, bars))
    .with(Layer::new("results", Mark::Points, Role::Measured, at_each(&|k| repeats[k].value)))
    .with(Layer::new(if apart.is_empty() { "" } else { "left out" }, Mark::Points, Role::Before, apart))
}
