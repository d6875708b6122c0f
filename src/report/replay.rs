//! A replay as a reader meets it: error figures, and both sides of each channel over time.

use super::display::shown;
use super::document::{Document, Section};
use super::number::significant;
use super::plot::{Layer, Mark, Plot, Role};
use super::recording::Trace;
use super::table::Table;
use crate::replay::{Loop, Quantity, Replay};
use crate::timeseries::{Channel, JointSeries};

const fn name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Position => "position",
        Quantity::Velocity => "velocity",
        Quantity::Torque => "torque",
    }
}

/// The document of replays of the machine of that name.
pub fn document(machine: &str, replays: &[Replay], control: Loop) -> Document {
    let worst = replays.iter().flat_map(|replay| &replay.errors).max_by(|a, b| a.relative.total_cmp(&b.relative));
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
            .flat_map(|replay| replay.notes.iter().map(|note| format!("{}: {note}", replay.recorded.name)))
            .collect(),
        sections: replays.iter().map(section).collect(),
    }
}

fn section(replay: &Replay) -> Section {
    let mut table = Table::new("", &["joint", "channel", "RMS error", "unit", "of the recorded RMS"]);
    let mut plots = Vec::new();
    for error in &replay.errors {
        let (unit, factor) = shown(error.unit);
        table.row([
            error.joint.clone(),
            name(error.quantity).to_owned(),
            significant(error.rms * factor, 3),
            unit.to_owned(),
            format!("{} %", significant(100.0 * error.relative, 3)),
        ]);
        let side = |joint: Option<&JointSeries>| -> Vec<[f64; 2]> {
            let values = joint.and_then(|joint| joint.get(error.quantity.channel())).unwrap_or_default();
            replay.recorded.time.iter().zip(values).map(|(time, value)| [*time, value * factor]).collect()
        };
        let title = format!("{}, {}: {}", error.joint, replay.recorded.name, name(error.quantity));
        let plot = Plot::new(title, "time [s]", format!("{} [{unit}]", name(error.quantity)))
            .with(Layer::new("recorded", Mark::Line, Role::Measured, side(replay.recorded.joint(&error.joint))))
            .with(Layer::new("simulated", Mark::Line, Role::Before, side(replay.simulated.joint(&error.joint))));
        plots.push(plot);
    }
    Section { title: replay.recorded.name.clone(), text: Vec::new(), tables: vec![table], plots, detail: false }
}

/// The recorded side and the position error, beside the simulated motion.
pub fn traces(replay: &Replay) -> Vec<Trace> {
    let mut traces = Vec::new();
    for joint in &replay.recorded.joints {
        let mut add = |panel, label, role, values: Vec<f64>| {
            let time = replay.recorded.time.clone();
            traces.push(Trace { joint: joint.name.clone(), panel, label, role, time, values });
        };
        if let Some(torque) = joint.get(Channel::Torque) {
            add("torque", "recorded", Role::Reference, torque.to_vec());
        }
        let Some(position) = joint.get(Channel::Position) else { continue };
        add("position", "recorded", Role::Reference, position.to_vec());
        let simulated = replay.simulated.joint(&joint.name).and_then(|joint| joint.get(Channel::Position));
        if let Some(simulated) = simulated {
            let error = simulated.iter().zip(position).map(|(model, measured)| model - measured).collect();
            add("position_error", "simulated_minus_recorded", Role::Before, error);
        }
    }
    traces
}
