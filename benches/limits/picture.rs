//! Draws the table of `docs/limits.md` as two maps: errors, and how many times the Cramér-Rao bound they are.
//!
//! A row for every setting and a column for every quantity of either joint. A cell has the colour of its value on a logarithmic scale; it
//! is grey where nothing was identified, or where there is no bound.

use std::fmt::Write as _;

/// Quantities of a joint, in the order of the table.
const FRICTION: [&str; 4] = ["F_C", "F_S", "v_S", "F_V"];
/// [px] Size of a cell, width of the names of rows, and height above the first row.
const CELL: [f64; 2] = [62.0, 22.0];
const NAMES: f64 = 250.0;
const HEAD: f64 = 90.0;
/// [px] Between the joints.
const GAP: f64 = 16.0;
/// Colours from good to bad, at equal distances.
const COLOURS: [[f64; 3]; 4] =
    [[44.0, 123.0, 182.0], [171.0, 217.0, 233.0], [253.0, 224.0, 144.0], [215.0, 48.0, 39.0]];

/// A row of the table: a setting, with the cells of both joints.
pub struct Row {
    name: String,
    /// [%] RMS error of the friction's coefficients.
    errors: [[Option<f64>; 4]; 2],
    /// The same over the bound.
    times: [[Option<f64>; 4]; 2],
    /// [%] RMS error of the gap: mean and scatter together.
    gap: [Option<f64>; 2],
}

/// A map: its columns, and what is written above and below it.
struct Map<'a> {
    title: &'a str,
    note: &'a str,
    columns: Vec<&'a str>,
    /// Values of the first and the last colour.
    range: [f64; 2],
    unit: &'a str,
}

/// The rows of the table in a page.
pub fn rows(page: &str) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for line in page.lines() {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [name, joint, _, _, errors, _, times, _, gap, _] = cells[..] else { continue };
        let Some(index) = ["joint1", "joint2"].iter().position(|one| *one == joint) else { continue };
        if rows.last().is_none_or(|row| row.name != name) {
            rows.push(Row { name: name.to_owned(), errors: [[None; 4]; 2], times: [[None; 4]; 2], gap: [None; 2] });
        }
        let Some(row) = rows.last_mut() else { continue };
        (row.errors[index], row.times[index]) = (four(errors), four(times));
        row.gap[index] = gap.split_once('±').and_then(|(mean, scatter)| {
            let [mean, scatter]: [f64; 2] = [mean.trim().parse().ok()?, scatter.trim().parse().ok()?];
            Some(mean.hypot(scatter))
        });
    }
    rows
}

fn four(cell: &str) -> [Option<f64>; 4] {
    let mut values = cell.split('/').map(|value| value.trim().parse().ok());
    std::array::from_fn(|_| values.next().flatten())
}

/// The map of errors.
pub fn of_errors(rows: &[Row]) -> String {
    let map = Map {
        title: "Errors of friction and gap, RMS over the seeds [%]",
        note: "grey: not identified",
        columns: [&FRICTION[..], &["gap"]].concat(),
        range: [0.03, 30.0],
        unit: " %",
    };
    draw(&map, rows, |row, joint| row.errors[joint].into_iter().chain([row.gap[joint]]).collect())
}

/// The map of errors over their bounds.
pub fn of_bounds(rows: &[Row]) -> String {
    let map = Map {
        title: "Errors of friction over the Cramér-Rao bound of the steady windows",
        note: "grey: not identified; below 1 because accelerated motion tells of friction as well",
        columns: FRICTION.to_vec(),
        range: [0.3, 30.0],
        unit: " ×",
    };
    draw(&map, rows, |row, joint| row.times[joint].to_vec())
}

fn draw(map: &Map, rows: &[Row], values: impl Fn(&Row, usize) -> Vec<Option<f64>>) -> String {
    let block = CELL[0] * map.columns.len() as f64;
    let [width, height] = [NAMES + 2.0 * block + GAP + 12.0, HEAD + CELL[1] * rows.len() as f64 + 48.0];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{title}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
         <text x=\"12\" y=\"24\" font-size=\"15\" font-weight=\"600\">{title}</text>\n",
        title = map.title
    );
    for joint in 0..2 {
        let left = NAMES + joint as f64 * (block + GAP);
        text(&mut svg, [left + 0.5 * block, HEAD - 28.0], "middle", &format!("joint {}", joint + 1));
        for (k, name) in map.columns.iter().enumerate() {
            text(&mut svg, [left + CELL[0] * (k as f64 + 0.5), HEAD - 9.0], "middle", name);
        }
        for (i, row) in rows.iter().enumerate() {
            let top = HEAD + CELL[1] * i as f64;
            for (k, value) in values(row, joint).into_iter().enumerate() {
                cell(&mut svg, map.range, [left + CELL[0] * k as f64, top], value);
            }
        }
    }
    for (i, row) in rows.iter().enumerate() {
        text(&mut svg, [NAMES - 10.0, HEAD + CELL[1] * (i as f64 + 0.68)], "end", &row.name);
    }
    scale(&mut svg, map, height - 30.0);
    text(&mut svg, [12.0, 44.0], "start", map.note);
    svg + "</svg>\n"
}

fn text(svg: &mut String, [x, y]: [f64; 2], anchor: &str, text: &str) {
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"#222\">{text}</text>");
}

fn cell(svg: &mut String, range: [f64; 2], [x, y]: [f64; 2], value: Option<f64>) {
    let fill = value.map_or("#e6e6e6".to_owned(), |value| colour(range, value));
    let [width, height] = CELL.map(|size| size - 1.0);
    let _ = writeln!(svg, "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width}\" height=\"{height}\" fill=\"{fill}\"/>");
    if let Some(value) = value {
        text(svg, [x + 0.5 * width, y + 0.68 * CELL[1]], "middle", &crate::figure(value));
    }
}

/// The colour of a value on the logarithmic scale.
fn colour([low, high]: [f64; 2], value: f64) -> String {
    let last = COLOURS.len() - 1;
    let share = ((value / low).ln() / (high / low).ln()).clamp(0.0, 1.0) * last as f64;
    let from = (share as usize).min(last - 1);
    let part = share - from as f64;
    let mixed: [u8; 3] =
        std::array::from_fn(|k| (COLOURS[from][k] + part * (COLOURS[from + 1][k] - COLOURS[from][k])) as u8);
    format!("#{:02x}{:02x}{:02x}", mixed[0], mixed[1], mixed[2])
}

/// What the colours mean: a value of each decade and half decade.
fn scale(svg: &mut String, map: &Map, top: f64) {
    let [low, high] = map.range;
    let mut value = low;
    let mut left = 12.0;
    while value <= 1.001 * high {
        let _ = writeln!(
            svg,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"12\" height=\"12\" fill=\"{}\"/>",
            colour(map.range, value)
        );
        text(svg, [left + 16.0, top + 11.0], "start", &format!("{}{}", crate::figure(value), map.unit));
        left += 62.0;
        value *= 10f64.sqrt();
    }
}
