//! Plots as SVG, for a page that can be printed.

use std::fmt::Write as _;

use super::markup::escape;
use super::plot::{Frame, Layer, Mark, Plot, ticks};

/// Width and height of a plot [px].
const SIZE: [f64; 2] = [680.0, 360.0];
/// The same for one of several small plots.
const SMALL: [f64; 2] = [440.0, 270.0];
/// Largest number of dots of a layer: more cannot be distinguished.
const MOST_DOTS: usize = 1200;
/// Mean width of a letter at the font size of the legend [px].
const LETTER: f64 = 6.6;

/// Width and height of a plot.
const fn size(plot: &Plot) -> [f64; 2] {
    if plot.small { SMALL } else { SIZE }
}

/// The frame of a plot.
pub fn frame(plot: &Plot) -> Frame {
    let top = 34.0 + 18.0 * count(legend_rows(plot).len());
    let [width, height] = size(plot);
    Frame::new(plot, [76.0, width - 14.0], [top, height - 46.0])
}

/// An SVG element of the plot.
pub fn draw(plot: &Plot) -> String {
    let rows = legend_rows(plot);
    let [width, height] = size(plot);
    let frame = frame(plot);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\">\n",
        width,
        height,
        escape(&plot.title)
    );
    let _ = writeln!(svg, "<rect width=\"{}\" height=\"{}\" fill=\"#fff\"/>", width, height);
    let _ = writeln!(
        svg,
        "<text x=\"{:.0}\" y=\"20\" font-size=\"14\" font-weight=\"600\">{}</text>",
        frame.horizontal[0],
        escape(&plot.title)
    );
    svg += &axes(plot, &frame);
    plot.layers.iter().for_each(|layer| svg += &draw_layer(layer, &frame));
    for (row, entries) in rows.iter().enumerate() {
        svg += &legend(entries, frame.horizontal[0], 40.0 + 18.0 * count(row));
    }
    svg + "</svg>\n"
}

#[expect(clippy::cast_precision_loss, reason = "a handful")]
fn count(items: usize) -> f64 {
    items as f64
}

/// Grid, ticks, numbers and names of the axes.
fn axes(plot: &Plot, frame: &Frame) -> String {
    let [left, right] = frame.horizontal;
    let [top, bottom] = frame.vertical;
    let mut svg = String::new();
    let (across, decimals) = ticks(frame.x, if plot.small { 5 } else { 8 });
    for value in across {
        let [x, _] = frame.place([value, frame.y[0]]);
        let colour = if value == 0.0 { "#999" } else { "#e4e4e4" };
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {top:.1}V{bottom:.1}\" stroke=\"{colour}\"/><text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#333\">{value:.decimals$}</text>",
            bottom + 17.0
        );
    }
    let (upwards, decimals) = ticks(frame.y, if plot.small { 4 } else { 6 });
    for value in upwards {
        let [_, y] = frame.place([frame.x[0], value]);
        let colour = if value == 0.0 { "#999" } else { "#e4e4e4" };
        let _ = writeln!(
            svg,
            "<path d=\"M{left:.1} {y:.1}H{right:.1}\" stroke=\"{colour}\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#333\">{value:.decimals$}</text>",
            left - 7.0,
            y + 4.0
        );
    }
    let _ = writeln!(svg, "<path d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\" fill=\"none\" stroke=\"#333\"/>");
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
        0.5 * (left + right),
        size(plot)[1] - 10.0,
        escape(&plot.x)
    );
    let middle = 0.5 * (top + bottom);
    let _ = writeln!(
        svg,
        "<text transform=\"translate(17 {middle:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        escape(&plot.y)
    );
    svg
}

/// The layer's colour as SVG writes it.
fn colour(layer: &Layer) -> String {
    let [red, green, blue] = layer.role.colour();
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn draw_layer(layer: &Layer, frame: &Frame) -> String {
    let colour = colour(layer);
    match layer.mark {
        Mark::Line | Mark::Dashed => {
            let dash = if layer.mark == Mark::Dashed { " stroke-dasharray=\"6 4\"" } else { "" };
            let path = frame.lines(&layer.points).iter().map(|run| path(run)).collect::<String>();
            format!(
                "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.4\" stroke-linejoin=\"round\"{dash}/>\n"
            )
        }
        Mark::Band => {
            let path = frame.lines(&layer.points).iter().map(|run| path(run) + "Z").collect::<String>();
            format!("<path d=\"{path}\" fill=\"{colour}\" fill-opacity=\"0.3\"/>\n")
        }
        Mark::Dots | Mark::Points => {
            // A path of zero-length strokes with round caps: a dot costs a few bytes.
            let (size, opacity) = if layer.mark == Mark::Dots { (2.2, 0.55) } else { (5.0, 0.9) };
            let path: String = frame.points(&layer.points, MOST_DOTS).iter().fold(String::new(), |mut path, [x, y]| {
                let _ = write!(path, "M{x:.1} {y:.1}h0");
                path
            });
            format!(
                "<path d=\"{path}\" stroke=\"{colour}\" stroke-width=\"{size}\" stroke-linecap=\"round\" stroke-opacity=\"{opacity}\"/>\n"
            )
        }
    }
}

/// The path of a run of pixels.
fn path(run: &[[f64; 2]]) -> String {
    let mut path = String::new();
    for (index, [x, y]) in run.iter().enumerate() {
        let _ = write!(path, "{}{x:.1} {y:.1}", if index == 0 { 'M' } else { 'L' });
    }
    path
}

/// The layers with a label, as many per row as fit.
fn legend_rows(plot: &Plot) -> Vec<Vec<&Layer>> {
    let mut rows: Vec<Vec<&Layer>> = Vec::new();
    let mut room = 0.0;
    for layer in plot.layers.iter().filter(|layer| !layer.label.is_empty()) {
        let needed = entry_width(layer);
        if rows.is_empty() || needed > room {
            rows.push(Vec::new());
            room = size(plot)[0] - 90.0;
        }
        room -= needed;
        if let Some(row) = rows.last_mut() {
            row.push(layer);
        }
    }
    rows
}

/// Width of an entry of the legend [px].
fn entry_width(layer: &Layer) -> f64 {
    46.0 + LETTER * count(layer.label.chars().count())
}

fn legend(entries: &[&Layer], left: f64, y: f64) -> String {
    let mut svg = String::new();
    let mut x = left;
    for layer in entries {
        let colour = colour(layer);
        let middle = y - 4.0;
        let _ = match layer.mark {
            Mark::Line => write!(svg, "<path d=\"M{x:.1} {middle:.1}h22\" stroke=\"{colour}\" stroke-width=\"2.4\"/>"),
            Mark::Dashed => write!(
                svg,
                "<path d=\"M{x:.1} {middle:.1}h22\" stroke=\"{colour}\" stroke-width=\"2.4\" stroke-dasharray=\"6 4\"/>"
            ),
            Mark::Band => {
                let upper = middle - 4.0;
                write!(svg, "<path d=\"M{x:.1} {upper:.1}h22v8h-22Z\" fill=\"{colour}\" fill-opacity=\"0.3\"/>")
            }
            Mark::Dots | Mark::Points => {
                write!(svg, "<circle cx=\"{:.1}\" cy=\"{middle:.1}\" r=\"3\" fill=\"{colour}\"/>", x + 11.0)
            }
        };
        let _ = writeln!(svg, "<text x=\"{:.1}\" y=\"{y:.1}\">{}</text>", x + 28.0, escape(&layer.label));
        x += entry_width(layer);
    }
    svg
}
