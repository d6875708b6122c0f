//! Plots of one quantity against another, drawn in a two-dimensional view, because the viewer has only time axes.

use rerun::RecordingStream;

use super::canvas_frame;
use super::entities::{colour, log_static};
use crate::error::Result;
use crate::report::plot::{Frame, Layer, Mark, Plot, ticks};

/// Largest number of points of a layer.
const MOST_POINTS: usize = 1500;
const GRID: [u8; 3] = [62, 64, 68];
const AXIS: [u8; 3] = [150, 150, 150];
const TEXT: [u8; 3] = [205, 205, 205];

/// Axes and layers of the plot below `path`.
pub fn log(stream: &RecordingStream, path: &str, plot: &Plot) -> Result<()> {
    let frame = canvas_frame(plot);
    log_axes(stream, path, plot, &frame)?;
    for (index, layer) in layers(plot).enumerate() {
        log_layer(stream, &format!("{path}/layers/{index}"), layer, &frame)?;
    }
    log_legend(stream, path, plot, &frame)
}

#[expect(clippy::cast_possible_truncation, reason = "the viewer works in single precision")]
const fn single([x, y]: [f64; 2]) -> [f32; 2] {
    [x as f32, y as f32]
}

/// A text centred at `place`.
fn log_text(stream: &RecordingStream, path: &str, texts: Vec<(String, [f64; 2])>, colour: [u8; 3]) -> Result<()> {
    let places: Vec<[f32; 2]> = texts.iter().map(|(_, place)| single(*place)).collect();
    let points = rerun_types::archetypes::Points2D::new(places)
        .with_labels(texts.into_iter().map(|(text, _)| text))
        .with_show_labels(true)
        .with_colors([colour])
        .with_radii([0.0]);
    log_static(stream, path, &points)
}

fn log_axes(stream: &RecordingStream, path: &str, plot: &Plot, frame: &Frame) -> Result<()> {
    let [left, right] = frame.horizontal;
    let [top, bottom] = frame.vertical;
    let (across, decimals_across) = ticks(frame.x, 6);
    let (upwards, decimals_upwards) = ticks(frame.y, 5);
    let column = |value: f64| frame.place([value, frame.y[0]])[0];
    let row = |value: f64| frame.place([frame.x[0], value])[1];
    let mut grid: Vec<[[f32; 2]; 2]> = Vec::new();
    grid.extend(across.iter().map(|&x| [single([column(x), top]), single([column(x), bottom])]));
    grid.extend(upwards.iter().map(|&y| [single([left, row(y)]), single([right, row(y)])]));
    log_static(stream, &format!("{path}/axes/grid"), &strips(grid.iter().map(|line| line.to_vec()), GRID, 0.4, 0.0))?;
    let edge = [[left, top], [left, bottom], [right, bottom]].map(single).to_vec();
    log_static(stream, &format!("{path}/axes/edge"), &strips([edge], AXIS, 0.7, 1.0))?;
    let mut numbers: Vec<(String, [f64; 2])> = Vec::new();
    numbers.extend(across.iter().map(|&x| (format!("{x:.decimals_across$}"), [column(x), bottom + 8.0])));
    numbers.extend(upwards.iter().map(|&y| (format!("{y:.decimals_upwards$}"), [left - 28.0, row(y) - 8.0])));
    log_text(stream, &format!("{path}/axes/numbers"), numbers, TEXT)?;
    let names =
        vec![(plot.x.clone(), [0.5 * (left + right), bottom + 30.0]), (plot.y.clone(), [left + 60.0, top - 20.0])];
    log_text(stream, &format!("{path}/axes/names"), names, TEXT)
}

fn strips(
    lines: impl IntoIterator<Item = Vec<[f32; 2]>>,
    colour: [u8; 3],
    radius: f32,
    order: f32,
) -> rerun_types::archetypes::LineStrips2D {
    rerun_types::archetypes::LineStrips2D::new(lines).with_colors([colour]).with_radii([radius]).with_draw_order(order)
}

fn log_layer(stream: &RecordingStream, path: &str, layer: &Layer, frame: &Frame) -> Result<()> {
    let colour = colour(layer.role);
    if is_line(layer.mark) {
        let lines = frame.lines(&layer.points);
        let lines = lines.into_iter().map(|line| line.into_iter().map(single).collect());
        return log_static(stream, path, &strips(lines, colour, 1.0, 3.0));
    }
    let places = frame.points(&layer.points, MOST_POINTS).into_iter().map(single);
    let radius = if layer.mark == Mark::Dots { 1.2 } else { 2.6 };
    let points =
        rerun_types::archetypes::Points2D::new(places).with_colors([colour]).with_radii([radius]).with_draw_order(2.0);
    log_static(stream, path, &points)
}

/// Label of each layer in its colour, two per row.
fn log_legend(stream: &RecordingStream, path: &str, plot: &Plot, frame: &Frame) -> Result<()> {
    let labelled = layers(plot).filter(|layer| !layer.label.is_empty());
    for (index, layer) in labelled.enumerate() {
        #[expect(clippy::cast_precision_loss, reason = "a handful")]
        let place = [
            frame.horizontal[0] + 240.0 + 200.0 * (index % 2) as f64,
            frame.vertical[0] - 20.0 - 22.0 * (index / 2) as f64,
        ];
        let texts = vec![(layer.label.clone(), place)];
        log_text(stream, &format!("{path}/legend/{index}"), texts, colour(layer.role))?;
    }
    Ok(())
}

/// Whether a plot's layer is a line.
const fn is_line(mark: Mark) -> bool {
    matches!(mark, Mark::Line | Mark::Dashed | Mark::Band)
}

/// Unused layers are not logged.
fn layers(plot: &Plot) -> impl Iterator<Item = &Layer> {
    plot.layers.iter().filter(|layer| !layer.points.is_empty())
}
