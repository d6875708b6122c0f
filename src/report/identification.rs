//! An identification for readers: tables of the identified values, friction curve, gap of each reversal.

use serde_json::{Value, json};

use super::Report;
use super::display::{self, shown};
use super::document::{Document, Section};
use super::files::envelope;
use super::number;
use super::paper_figures;
use super::plot::{Layer, Mark, Plot, Role};
use super::recording::Motion;
use super::table::Table;
use crate::gearhead::FrictionLaw;
use crate::identify::{
    Identification, JointIdentification, LawKind, LinesEstimate, PerDirection, PublishedFriction, Quantity,
};
use crate::robot::Model;
use crate::scenario::Truth;
use crate::timeseries::Drawn;

/// The report of an identification; `truth` holds what was injected, where that is known; `drawn` holds the recordings for display.
pub fn report<'a>(
    name: &str,
    found: &Identification,
    truth: Option<&Truth>,
    model: &'a Model,
    drawn: Vec<Drawn>,
) -> Report<'a> {
    let content = serde_json::to_value(found).unwrap_or(Value::Null);
    let document = document(name, found, truth, &drawn);
    let motions = drawn.into_iter().map(|session| Motion::new(&model.robot, session)).collect();
    Report {
        document,
        json: envelope(
            "lostmotion/identification/1",
            name,
            json!({ "joints": content["joints"], "left_out": content["left_out"] }),
        ),
        motions,
        model: Some(found.apply(model)),
        extra: Vec::new(),
    }
}

/// The document of an identification; `truth` holds what was injected, where that is known.
pub fn document(name: &str, identification: &Identification, truth: Option<&Truth>, drawn: &[Drawn]) -> Document {
    let joints = &identification.joints;
    Document {
        title: format!("{name}: identified friction and backlash"),
        verdict: joints.iter().map(verdict).collect::<Vec<_>>().join("\n"),
        warnings: joints
            .iter()
            .flat_map(|joint| joint.notes.iter().map(|note| format!("{}: {note}", joint.joint)))
            .chain(identification.left_out.iter().map(|one| format!("{}: not identified: {}", one.joint, one.reason)))
            .collect(),
        sections: joints
            .iter()
            .map(|joint| section(joint, truth.and_then(|truth| truth.friction(&joint.joint)), drawn))
            .collect(),
        ..Document::default()
    }
}

/// One line: Coulomb level, breakaway and gap.
fn verdict(joint: &JointIdentification) -> String {
    let friction = &joint.friction;
    let (slow, fast) = match friction.preferred {
        LawKind::Exponential => (
            friction.exponential.each().map(|one| one.breakaway.value),
            friction.exponential.each().map(|one| one.coulomb.value),
        ),
        LawKind::TwoLines => {
            (friction.lines.each().map(|one| one.a1.value), friction.lines.each().map(|one| one.a2.value))
        }
    };
    let unit = joint.kind.effort_unit();
    let pair = |[positive, negative]: [f64; 2]| {
        format!("{} / {} {unit}", number::significant(positive, 3), number::significant(negative, 3))
    };
    let gap = joint.backlash.as_ref().map_or_else(
        || "backlash not measurable in these data".to_owned(),
        |gap| {
            let found = &gap.best.mean;
            let figure = display::estimate(found.value, found.std_error, &found.unit);
            if gap.consistent_with_zero() {
                format!("no backlash that differs significantly from zero ({figure})")
            } else {
                format!("backlash {figure}")
            }
        },
    );
    format!(
        "{}: friction {} at rest, {} Coulomb (positive / negative direction); {gap}.",
        joint.joint,
        pair(slow),
        pair(fast)
    )
}

fn section(joint: &JointIdentification, truth: Option<FrictionLaw>, drawn: &[Drawn]) -> Section {
    let unit = display::shown(joint.kind.velocity_unit()).0;
    let [slowest, fastest] = joint.friction.speeds.map(|speed| display::value(speed, joint.kind.velocity_unit()));
    let preferred = match joint.friction.preferred {
        LawKind::Exponential => "the exponential law (equation 6)",
        LawKind::TwoLines => "the two lines (equation 9)",
    };
    let text = format!(
        "{} steady windows from {slowest} to {fastest}; the data prefer {preferred}. Velocities in {unit}.",
        joint.points.len()
    );
    let mut section = Section { text: vec![text], ..Section::new(&joint.joint) };
    section.tables.push(exponential(joint));
    section.tables.push(lines(joint));
    section.tables.extend(gap_table(joint));
    section.tables.extend(published_table(joint));
    section.tables.extend(methods_table(joint));
    let mut figures = paper_figures::of_joint(joint, drawn, truth).into_iter();
    section.plots.extend(figures.next());
    section.plots.push(residual_plot(joint));
    section.plots.extend(gap_plot(joint));
    section.plots.extend(figures);
    section
}

fn head(title: &str) -> Table {
    Table::new(title, &["", "injected", "recovered", "std. error", "error", "95 % interval", "unit"])
}

/// One row: injected, recovered, standard error, error, interval.
fn row(table: &mut Table, name: &str, quantity: &Quantity) {
    let (unit, factor) = shown(&quantity.unit);
    let (value, std_error) = number::with_error(quantity.value * factor, quantity.std_error * factor);
    let injected = quantity.truth.map_or_else(String::new, |truth| number::significant(truth * factor, 4));
    let error = quantity.error_percent.map_or_else(String::new, number::percent);
    let interval = number::interval(quantity.interval.map(|end| end * factor));
    table.row([name.to_owned(), injected, value, std_error, error, interval, unit.to_owned()]);
}

/// Rows of both directions.
fn rows<T>(table: &mut Table, name: &str, law: &PerDirection<T>, quantity: impl Fn(&T) -> &Quantity) {
    row(table, &format!("{name} +"), quantity(&law.positive));
    row(table, &format!("{name} −"), quantity(&law.negative));
}

fn with_curve_error(title: &str, errors: [Option<f64>; 2]) -> String {
    match errors {
        [Some(positive), Some(negative)] => {
            format!("{title}; curve within {positive:.2} % / {negative:.2} % RMS of the injected one")
        }
        _ => title.to_owned(),
    }
}

fn exponential(joint: &JointIdentification) -> Table {
    let law = &joint.friction.exponential;
    let errors = law.each().map(|one| one.curve_error_percent);
    let mut table = head(&with_curve_error("Exponential law, equation 6", errors));
    rows(&mut table, "F_C", law, |one| &one.coulomb);
    rows(&mut table, "F_S", law, |one| &one.breakaway);
    rows(&mut table, "v_S", law, |one| &one.stribeck_velocity);
    rows(&mut table, "F_V", law, |one| &one.viscous);
    table.trimmed()
}

fn lines(joint: &JointIdentification) -> Table {
    let law = &joint.friction.lines;
    let errors = law.each().map(|one| one.curve_error_percent);
    let mut table = head(&with_curve_error("Two lines, equations 7 to 9", errors));
    line_rows(&mut table, law, &joint.centrifugal);
    table.trimmed()
}

/// Rows of equations 7 to 9 and of `C_ii`.
fn line_rows(table: &mut Table, law: &PerDirection<LinesEstimate>, centrifugal: &Quantity) {
    rows(table, "a1", law, |one| &one.a1);
    rows(table, "b1", law, |one| &one.b1);
    rows(table, "a2", law, |one| &one.a2);
    rows(table, "b2", law, |one| &one.b2);
    rows(table, "switch", law, |one| &one.switch_velocity);
    row(table, "C_ii", centrifugal);
}

fn gap_table(joint: &JointIdentification) -> Option<Table> {
    let gap = joint.backlash.as_ref()?;
    let mut table = head(&format!(
        "Backlash, total gap at the joint; paper's mean deviation {:.1} % ({} reversals)",
        gap.paper.mean_deviation_percent,
        gap.paper.values.len()
    ));
    row(&mut table, &format!("best: {}", gap.best.name), &gap.best.mean);
    row(&mut table, gap.paper.name, &gap.paper.mean);
    row(&mut table, gap.paper_literal.name, &gap.paper_literal.mean);
    if let Some(share) = &gap.link_share {
        row(&mut table, "share of friction on the link", share);
    }
    Some(table.trimmed())
}

/// The paper's own estimators.
fn published_table(joint: &JointIdentification) -> Option<Table> {
    let found = &joint.published;
    if found.friction.is_none() && found.backlash.is_none() {
        return None;
    }
    let errors = found.friction.as_ref().map_or([None; 2], |one| one.lines.each().map(|one| one.curve_error_percent));
    let title = "As published: plain least squares on window averages, equation 15 on the last ten steps";
    let mut table = head(&with_curve_error(title, errors));
    if let Some(PublishedFriction { lines, centrifugal }) = &found.friction {
        line_rows(&mut table, lines, centrifugal);
    }
    for (name, gap) in [("gap", &found.backlash), ("gap, filtered", &found.backlash_filtered)] {
        if let Some(gap) = gap {
            row(&mut table, name, &gap.mean);
        }
    }
    Some(table.trimmed())
}

/// Other methods of the literature, and why one of them gives nothing.
fn methods_table(joint: &JointIdentification) -> Option<Table> {
    if joint.methods.is_empty() {
        return None;
    }
    let mut table = Table::new(
        "Other methods of the literature on the same recordings",
        &["", "injected", "recovered", "std. error", "error", "95 % interval", "unit", "remark"],
    );
    for method in &joint.methods {
        let name = method.method.replace('_', " ");
        for (quantity, found) in method.quantities() {
            row(&mut table, &format!("{name}: {quantity}"), found);
            if let Some(cell) = table.rows.last_mut().and_then(|row| row.last_mut()) {
                method.reference.clone_into(cell);
            }
        }
        if let Some(why) = &method.refused {
            table.row([&name, "", "", "", "", "", "", why.as_str()]);
        }
    }
    Some(table.trimmed())
}

fn residual_plot(joint: &JointIdentification) -> Plot {
    let (unit, factor) = shown(joint.kind.velocity_unit());
    let left = joint.points.iter().map(|point| [point.velocity * factor, joint.residual(point)]).collect();
    Plot::new(
        format!("{}: friction minus fit", joint.joint),
        format!("velocity [{unit}]"),
        format!("residual [{}]", joint.kind.effort_unit()),
    )
    .with(Layer::new("", Mark::Points, Role::Fit, left))
}

fn gap_plot(joint: &JointIdentification) -> Option<Plot> {
    let gap = joint.backlash.as_ref()?;
    let (speed_unit, speed) = shown(joint.kind.velocity_unit());
    let (unit, factor) = shown(joint.kind.position_unit());
    let values = |values: &[crate::identify::backlash::ReversalGap]| -> Vec<[f64; 2]> {
        values.iter().map(|one| [one.velocity.abs() * speed, one.gap * factor]).collect()
    };
    let level = |value: f64| {
        let fastest = joint.friction.speeds[1] * speed;
        vec![[0.0, value * factor], [fastest, value * factor]]
    };
    let mut plot = Plot::new(
        format!("{}: gap of each reversal", joint.joint),
        format!("speed after the reversal [{speed_unit}]"),
        format!("gap [{unit}]"),
    )
    .with(Layer::new("equation 15", Mark::Points, Role::Before, values(&gap.paper.values)))
    .with(Layer::new("best, each", Mark::Points, Role::Measured, values(&gap.best.values)))
    .with(Layer::new("best", Mark::Line, Role::Fit, level(gap.best.mean.value)));
    if let Some(truth) = gap.best.mean.truth {
        plot = plot.with(Layer::new("injected", Mark::Dashed, Role::Truth, level(truth)));
    }
    Some(plot)
}
