//! A replay for readers: error figures, and both sides of each channel over time.

use serde::Serialize;

use super::display::shown;
use super::document::{Document, Section};
use super::number::significant;
use super::plot::{Layer, Mark, Plot, Role};
use super::recording::{Trace, canvas_frame};
use super::svg;
use super::table::Table;
use crate::replay::prediction::Predicted;
use crate::replay::{Loop, Observable, Replay, Side};
use crate::timeseries::Envelope;

const fn name(quantity: Observable) -> &'static str {
    match quantity {
        Observable::Position => "position",
        Observable::Velocity => "velocity",
        Observable::Torque => "torque",
    }
}

/// The displayed curves of one replay.
#[derive(Debug, Default)]
pub struct Shown {
    /// Both sides of each signal.
    plots: Vec<(Observable, Plot)>,
    /// The recorded side and the position error, beside the simulated motion.
    pub traces: Vec<Trace>,
    /// Predictions without a controller.
    pub predicted: Vec<Predicted>,
}

/// A prediction in `report.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prediction<'a> {
    /// The joint.
    joint: &'a str,
    /// [s] How far ahead was predicted.
    horizon: f64,
    /// Unit of the errors.
    unit: &'static str,
    /// RMS error of the predicted position.
    rms: f64,
    /// RMS error that the sensors alone would leave.
    floor: f64,
}

impl Shown {
    /// The predictions for `report.json`.
    pub fn predictions<'s>(&'s self) -> Vec<Prediction<'s>> {
        let of = |one: &'s Predicted| Prediction {
            joint: &one.joint,
            horizon: one.horizon,
            unit: one.unit,
            rms: one.rms(),
            floor: one.floor,
        };
        self.predicted.iter().map(of).collect()
    }

    /// Adds both sides of a signal of that session, reduced to what is visible.
    pub fn add(&mut self, session: &str, side: &Side<'_>) {
        let (unit, factor) = shown(side.unit);
        let points = |values: &[f64]| -> Vec<[f64; 2]> {
            side.time.iter().zip(values).map(|(time, value)| [*time, value * factor]).collect()
        };
        let quantity = side.quantity;
        let title = format!("{}, {session}: {}", side.joint, name(quantity));
        let plot = Plot::new(title, "time [s]", format!("{} [{unit}]", name(quantity)))
            .with(Layer::new("recorded", Mark::Line, Role::Measured, points(side.recorded)))
            .with(Layer::new("simulated", Mark::Line, Role::Before, points(side.simulated)));
        self.plots.push((quantity, plot.thinned(&[svg::frame, canvas_frame])));

        let mut add = |panel, label, role, Envelope { time, values, .. }: Envelope| {
            self.traces.push(Trace { joint: side.joint.to_owned(), panel, label, role, time, values });
        };
        let recorded = || Envelope::of(side.time, side.recorded.iter().copied());
        match quantity {
            Observable::Position => {
                add("position", "recorded", Role::Reference, recorded());
                let error = side.simulated.iter().zip(side.recorded).map(|(model, measured)| model - measured);
                add("position_error", "simulated_minus_recorded", Role::Before, Envelope::of(side.time, error));
            }
            Observable::Torque => add("torque", "recorded", Role::Reference, recorded()),
            Observable::Velocity => {}
        }
    }
}

/// The document of replays of the machine of that name.
pub fn document(machine: &str, replays: &[(Replay, Shown)], control: Loop) -> Document {
    let errors = replays.iter().flat_map(|(replay, _)| &replay.errors);
    let worst = errors.max_by(|a, b| a.relative.total_cmp(&b.relative));
    let verdict = worst.map_or_else(String::new, |worst| {
        let percent = significant(100.0 * worst.relative, 3);
        format!("Largest error: {} of {}, {percent} % of the recorded RMS.", name(worst.quantity), worst.joint)
    });
    let how = match control {
        Loop::Closed => "",
        Loop::Open => ", in open loop",
    };
    Document {
        title: format!("{machine}: simulated under recorded inputs{how}"),
        verdict,
        warnings: replays
            .iter()
            .flat_map(|(replay, _)| replay.notes.iter().map(|note| format!("{}: {note}", replay.session)))
            .collect(),
        sections: replays.iter().map(|(replay, shown)| section(replay, shown)).collect(),
        ..Document::default()
    }
}

fn section(replay: &Replay, drawn: &Shown) -> Section {
    let mut table = Table::new("", &["joint", "channel", "RMS error", "unit", "of the recorded RMS"]);
    for error in &replay.errors {
        let (unit, factor) = shown(error.unit);
        table.row([
            error.joint.clone(),
            name(error.quantity).to_owned(),
            significant(error.rms * factor, 3),
            unit.to_owned(),
            format!("{} %", significant(100.0 * error.relative, 3)),
        ]);
    }
    let mut ahead = Table::new(
        "RMS error of the position that is predicted, driven by the recorded torque alone",
        &["joint", "ahead", "RMS error", "sensors alone", "unit"],
    );
    for one in &drawn.predicted {
        let (unit, factor) = shown(one.unit);
        ahead.row([
            one.joint.clone(),
            format!("{} s", significant(one.horizon, 1)),
            significant(one.rms() * factor, 3),
            significant(one.floor * factor, 2),
            unit.to_owned(),
        ]);
    }
    // A torque that is an input has no error, and no plot.
    let judged = |quantity: Observable| replay.errors.iter().any(|error| error.quantity == quantity);
    let plots = drawn.plots.iter().filter(|(quantity, _)| judged(*quantity)).map(|(_, plot)| plot.clone());
    Section {
        title: replay.session.clone(),
        text: Vec::new(),
        tables: [table, ahead].into_iter().filter(|table| !table.rows.is_empty()).collect(),
        plots: plots.collect(),
        detail: false,
    }
}
