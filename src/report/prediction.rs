//! How far ahead the nominal and the extended model predict, for readers.

use super::diagnosis::by_concern;
use super::display::shown;
use super::headline;
use super::number::significant;
use super::plot::{Layer, Mark, Plot, Role};
use super::recording::Trace;
use super::table::Table;
use crate::diagnose::{Diagnosis, PredictionSeries};

/// Errors of predicted positions, by joint and horizon.
pub fn table(diagnosis: &Diagnosis) -> Table {
    let mut table = Table::new(
        "RMS error of the position that the simulation predicts on data held out, driven by the recorded torque alone",
        &["joint", "ahead", "nominal", "extended", "sensors alone", "unit", "gain"],
    );
    for error in &diagnosis.replay {
        let Some(horizon) = error.horizon else { continue };
        let (unit, factor) = shown(error.unit);
        table.row([
            error.joint.clone(),
            format!("{} s", significant(horizon, 1)),
            significant(error.before * factor, 3),
            significant(error.after * factor, 3),
            significant(error.floor.unwrap_or(f64::NAN) * factor, 2),
            unit.to_owned(),
            headline::gain(error.gain),
        ]);
    }
    table
}

/// The predictions over the longest horizon.
fn furthest(diagnosis: &Diagnosis) -> impl Iterator<Item = &PredictionSeries> {
    let longest = diagnosis.predictions.iter().map(|one| one.horizon).fold(0.0, f64::max);
    diagnosis.predictions.iter().filter(move |one| one.horizon == longest)
}

/// Errors over the longest horizon over time, for each joint and session, those first of the joints that the result is about.
pub fn plots(diagnosis: &Diagnosis) -> Vec<Plot> {
    let plot = |series: &PredictionSeries| {
        let (unit, factor) = shown(series.unit);
        let points = |values: &[f64]| -> Vec<[f64; 2]> {
            series.time.iter().zip(values).map(|(time, value)| [*time, value * factor]).collect()
        };
        let ahead = significant(series.horizon, 1);
        Plot::new(
            format!("{}, {}: position predicted {ahead} s ahead", series.joint, series.session),
            "time [s]",
            format!("measured − predicted [{unit}]"),
        )
        .with(Layer::new("nominal", Mark::Line, Role::Before, points(&series.before)))
        .with(Layer::new("extended", Mark::Line, Role::After, points(&series.after)))
    };
    let mut series: Vec<&PredictionSeries> = furthest(diagnosis).collect();
    by_concern(diagnosis, &mut series, |one| &one.joint);
    series.into_iter().map(plot).collect()
}

/// The same for the recording.
pub fn traces(diagnosis: &Diagnosis, session: &str) -> Vec<Trace> {
    let sides = |series: &PredictionSeries| {
        let side = |label, role, values: &[f64]| Trace {
            joint: series.joint.clone(),
            panel: "prediction_error",
            label,
            role,
            time: series.time.clone(),
            values: values.to_vec(),
        };
        [side("nominal", Role::Before, &series.before), side("extended", Role::After, &series.after)]
    };
    furthest(diagnosis).filter(|series| series.session == session).flat_map(sides).collect()
}
