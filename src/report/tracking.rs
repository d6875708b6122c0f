//! Tracking with and without compensation, for readers: the paper's Table I and Figure 8.

use serde_json::{Value, json};

use super::display::{self, shown};
use super::document::Section;
use super::number;
use super::plot::{Layer, Mark, Plot, Role};
use super::table::Table;
use crate::scenario::{JointTracking, Known, Tracking, TrackingRun};

/// The runs of a joint, with their names for readers and for programs.
fn runs(joint: &JointTracking) -> [(&'static str, &'static str, &TrackingRun); 3] {
    [
        ("without", "without", &joint.without),
        ("with, as identified", "with", &joint.with),
        ("with, true values", "with_true_parameters", &joint.exact),
    ]
}

/// One line per joint.
pub fn verdict(tracking: &Tracking) -> String {
    let line = |joint: &JointTracking| {
        let (unit, factor) = shown(joint.kind.position_unit());
        let error = |run: &TrackingRun| display::join(&number::significant(run.figures.mean_error * factor, 2), unit);
        format!(
            "{}: mean absolute tracking error of the link {} without compensation, {} with ({:.0} % less).",
            joint.joint,
            error(&joint.without),
            error(&joint.with),
            joint.reduction_percent()
        )
    };
    tracking.joints.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Table I, and the error of each joint over time.
pub fn section(tracking: &Tracking) -> Section {
    let text = "The same motion three times: without compensation, with friction and gap as identified here, and with their true values. \
                Errors are those of the link, currents without the noise of the sensor. Rest: largest movement of motor or link in the last second.";
    let note = |joint: &JointTracking| match joint.known {
        Known::FrictionAndGap => None,
        Known::Friction => Some(format!("{}: the gap was not identified; friction alone is compensated.", joint.joint)),
        Known::Nothing => Some(format!("{}: nothing was identified; nothing is compensated.", joint.joint)),
    };
    let mut section = Section::new("Tracking with and without compensation");
    section.text.push(text.to_owned());
    section.text.extend(tracking.joints.iter().filter_map(note));
    section.tables = vec![table(tracking), summary(tracking)];
    section.plots = tracking.joints.iter().map(plot).collect();
    section
}

/// Figures of every run.
fn table(tracking: &Tracking) -> Table {
    let heads = ["", "compensation", "mean error", "largest", "unit", "variation of current [A]", "rest"];
    let mut table = Table::new("Tracking error of the link, Table I of the paper", &heads);
    for joint in &tracking.joints {
        let (unit, factor) = shown(joint.kind.position_unit());
        for (name, _, run) in runs(joint) {
            let figures = &run.figures;
            let position = |value: f64| number::significant(value * factor, 3);
            table.row([
                joint.joint.clone(),
                name.to_owned(),
                position(figures.mean_error),
                position(figures.largest_error),
                unit.to_owned(),
                format!("{:.0}", figures.current_variation),
                position(figures.rest_amplitude),
            ]);
        }
    }
    table
}

/// What compensation changes.
fn summary(tracking: &Tracking) -> Table {
    let heads = ["", "mean error", "share of what true values reach", "variation of current"];
    let mut table = Table::new("Change by compensation", &heads);
    for joint in &tracking.joints {
        table.row([
            joint.joint.clone(),
            number::percent(-joint.reduction_percent()),
            format!("{:.0} %", joint.share_percent()),
            number::percent(joint.variation_percent()),
        ]);
    }
    table
}

/// Name of the file of a joint's figure.
pub fn file(joint: &str) -> String {
    format!("tracking_{joint}")
}

/// Figure 8: the error of the link over time.
fn plot(joint: &JointTracking) -> Plot {
    let (unit, factor) = shown(joint.kind.position_unit());
    let points = |run: &TrackingRun| -> Vec<[f64; 2]> {
        run.error.time.iter().zip(&run.error.values).map(|(time, error)| [*time, error * factor]).collect()
    };
    let line = |name: &str, role: Role, run: &TrackingRun| Layer::new(name, Mark::Line, role, points(run));
    Plot::new(
        format!("{}: tracking error (Figure 8)", joint.joint),
        "time [s]",
        format!("link minus reference [{unit}]"),
    )
    .with(line("without compensation", Role::Before, &joint.without))
    .with(line("with compensation", Role::After, &joint.with))
    .in_file(file(&joint.joint))
}

/// The figures for programs, SI.
pub fn json(tracking: &Tracking) -> Value {
    let joint = |joint: &JointTracking| {
        let unit = joint.kind.position_unit();
        let position = |value: f64| json!({ "value": value, "unit": unit });
        let mut content = json!({
            "joint": joint.joint,
            "compensated": match joint.known {
                Known::Nothing => "nothing",
                Known::Friction => "friction",
                Known::FrictionAndGap => "friction_and_gap",
            },
            "reduction_percent": joint.reduction_percent(),
            "share_of_true_percent": joint.share_percent(),
            "current_variation_growth_percent": joint.variation_percent(),
        });
        for (_, key, run) in runs(joint) {
            let figures = &run.figures;
            content[key] = json!({
                "mean_absolute_error": position(figures.mean_error),
                "largest_error": position(figures.largest_error),
                "current_variation": { "value": figures.current_variation, "unit": "A" },
                "rest_amplitude": position(figures.rest_amplitude),
            });
        }
        content
    };
    tracking.joints.iter().map(joint).collect()
}
