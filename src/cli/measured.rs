//! A planned measurement for readers.

use crate::report::{Document, Section, Table};
use crate::robot::{JointModel, Model};
use crate::scenario::{ExpectedErrors, Measurands, Measurement, PlannedJoint};
use crate::units::{DEG, JointKind};

/// Verdict, the speeds of every joint, and the expected errors beside those of a uniform staircase.
pub fn document(model: &Model, asked: &Measurands, found: &Measurement) -> Document {
    let joint = |one: &PlannedJoint| model.joints.iter().find(|joint| joint.name == one.joint);
    let both = || found.joints.iter().filter_map(|one| joint(one).map(|joint| (one, joint)));
    let mut motion = Table::new("Motion", &["joint", "speeds", "each for", "sweeps", "reversals for the gap", "time"]);
    for (one, joint) in both() {
        let (scale, unit) = of_speed(joint.kind);
        let list = |values: &[f64], scale: f64| {
            values.iter().map(|value| format!("{:.3}", value / scale)).collect::<Vec<String>>().join(" ")
        };
        motion.row([
            one.joint.clone(),
            format!("{} {unit}", list(&one.speeds, scale)),
            format!("{} s", list(&one.durations, 1.0)),
            format!("{} there and back", one.sweeps),
            one.reversals.to_string(),
            format!("{:.0} s", one.seconds),
        ]);
    }
    let mut errors = Table::new(
        "Expected errors, one standard deviation",
        &["joint", "experiment", "F_C", "F_S", "v_S", "F_V", "gap"],
    );
    for (one, joint) in both() {
        errors.row(row(joint, "planned", Some(&one.expected)));
        errors.row(row(joint, "uniform staircase of the same length", one.uniform.as_ref()));
    }
    let mut section = Section::new("What was planned");
    section.text.push(
        "Each joint passes its speeds in one direction, slowest first, and comes back in the other; the other joints rest. Errors \
         follow from the noise of the sensors and the model's friction, see `lostmotion::scenario::Measurement`; what \
         windows have in common, such as friction that depends on position, is not in them."
            .to_owned(),
    );
    section.text.push(
        "`lostmotion run scenario.toml` rehearses it. The CSV files have the references of every recording for the machine's own \
         controller: record each as one file, and pass all of them to `lostmotion identify --data`."
            .to_owned(),
    );
    section.tables.extend([motion, errors]);
    let guessed: Vec<&str> =
        found.joints.iter().filter(|one| !one.friction_known).map(|one| one.joint.as_str()).collect();
    let mut warnings = Vec::new();
    if !guessed.is_empty() {
        warnings.push(format!(
            "the model has no friction of {}: the plan is conservative and its errors are guesses; identify, and design again",
            guessed.join(", ")
        ));
    }
    Document {
        title: format!("{}: an experiment for {}", model.name, asked.words()),
        verdict: format!(
            "{:.0} s of motion measure {} of {} joints.",
            found.seconds,
            asked.words(),
            found.joints.len()
        ),
        warnings,
        sections: vec![section],
        ..Document::default()
    }
}

/// Size of the unit in which speeds are shown, and the unit.
const fn of_speed(kind: JointKind) -> (f64, &'static str) {
    match kind {
        JointKind::Revolute => (DEG, "deg/s"),
        JointKind::Prismatic => (1e-3, "mm/s"),
    }
}

/// A row of expected errors.
fn row(joint: &JointModel, name: &str, errors: Option<&ExpectedErrors>) -> Vec<String> {
    let mut cells = vec![joint.name.clone(), name.to_owned()];
    let Some(errors) = errors else {
        cells.push("too short for one".to_owned());
        return cells;
    };
    cells.extend(errors.friction.iter().map(|error| format!("{:.2} %", 100.0 * error)));
    cells.push(errors.gap.map_or_else(String::new, |gap| match joint.kind {
        JointKind::Revolute => format!("{:.4}°", gap / DEG),
        JointKind::Prismatic => format!("{:.4} mm", 1e3 * gap),
    }));
    cells
}
