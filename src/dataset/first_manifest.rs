//! Writes a first manifest for a file from its column names and numbers, with units; guesses are marked.

use std::fmt::Write as _;

use super::JointKinds;
use super::columns::CHANNEL_COLUMNS;
use super::derivative;
use super::layout::{FoundChannel, FoundJoint, Layout, assign};
use super::table::{Column, Table, list};
use crate::toml_input::{written_key, written_text};
use crate::units::JointKind;

/// A manifest that can be loaded if the file has a column of time and one of numbers. `file` is the name by which it refers to
/// the data file. If a model is given and the joints fit it, they get its names.
pub fn first_manifest(table: &Table, file: &str, model: Option<&JointKinds>) -> String {
    let layout = Layout::of(table);
    let mut text = String::from("schema = \"lostmotion/dataset/1\"\n");
    let _ = writeln!(text, "file = {}\nsource = \"who recorded it, when, on what\"", written_text(file));
    text += &time(table, &layout);
    let places = model.and_then(|model| assign(&layout.joints, model));
    let mut left = layout.left.clone();
    for (at, joint) in layout.joints.iter().enumerate() {
        let named = places.as_ref().and_then(|places| Some(&model?.get(places.0[at]?)?.0));
        text += &section(table, joint, named.unwrap_or(&joint.name), named.is_none());
    }
    if layout.joints.is_empty() {
        text += &guessed_joints(table, &layout, &mut left);
    }
    if !left.is_empty() {
        let names: Vec<&str> = left.iter().map(|at| table.columns[*at].name.as_str()).collect();
        let channels: Vec<&str> = CHANNEL_COLUMNS.iter().map(|entry| entry.0).collect();
        let _ = writeln!(text, "\n# columns that are not used: {}", comment(&list(&names)));
        let _ = writeln!(text, "# channels: {}", channels.join(", "));
        text += "# as `position = { column = \"NAME\", unit = \"deg\", scale = 1.0 }`; a column may be given by its number, from 1\n";
    }
    text
}

/// Text for a comment: in one line.
fn comment(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn time(table: &Table, layout: &Layout) -> String {
    let Some(time) = &layout.time else {
        return "\n[time]\ncolumn = \"?\"  # no column rises from row to row\n".to_owned();
    };
    let column = |at: usize| written_text(&table.columns[at].name);
    let mut text = format!("\n[time]\ncolumn = {}", column(time.column));
    let guess = time.guess.as_ref().map_or(String::new(), |guess| format!("  # guess: {}", comment(guess)));
    match (time.nanoseconds, time.unit) {
        (Some(at), _) => {
            let _ = write!(text, "\nnanoseconds = {}", column(at));
        }
        (None, Some(unit)) => {
            let _ = write!(text, "\nunit = \"{unit}\"");
        }
        (None, None) => {}
    }
    text + &guess + "\n"
}

/// The section of a joint.
fn section(table: &Table, joint: &FoundJoint, name: &str, of_file: bool) -> String {
    let said = if of_file { "  # this is the name in the file: use the name in the model" } else { "" };
    let mut text = format!("\n[joints.{}]{said}\n", written_key(name));
    let kind = joint.kind();
    let mut seen: Vec<&str> = Vec::new();
    for channel in &joint.channels {
        // A second column for a channel is left to the user.
        let off = if seen.contains(&channel.channel) { "# " } else { "" };
        seen.push(channel.channel);
        text += &format!("{off}{}", line(&table.columns[channel.column], channel, kind));
    }
    text
}

fn line(column: &Column, channel: &FoundChannel, kind: JointKind) -> String {
    let unit = match channel.unit {
        Some((unit, scale)) => {
            let scale = if scale == 1.0 { String::new() } else { format!(", scale = {scale:?}") };
            // Volts need a scale, which only the user knows.
            let scale = if unit == "V" && scale.is_empty() { ", scale = 1.0".to_owned() } else { scale };
            format!(", unit = \"{unit}\"{scale}")
        }
        None => unit_of(channel, kind).map_or(String::new(), |unit| format!(", unit = \"{unit}\"")),
    };
    let said = match (&channel.guess, channel.remark) {
        (Some(guess), _) => format!("  # guess: {}", comment(guess)),
        (None, Some(remark)) => format!("  # guess: {}", comment(remark)),
        (None, None) => String::new(),
    };
    format!("{} = {{ column = {}{unit} }}{said}\n", channel.channel, written_text(&column.name))
}

/// The unit to state for a channel without one: SI, or the one that its size suggests.
fn unit_of(channel: &FoundChannel, kind: JointKind) -> Option<&'static str> {
    let suggests = |unit: &str| channel.guess.as_ref().is_some_and(|guess| guess.contains(unit));
    let turning = kind == JointKind::Revolute;
    Some(match channel.channel {
        name if name.ends_with("position") && suggests("degrees?") => "deg",
        name if name.ends_with("position") => kind.position_unit(),
        name if name.ends_with("velocity") => {
            if turning {
                "rad/s"
            } else {
                "m/s"
            }
        }
        name if name.ends_with("current") => {
            if suggests("mA?") {
                "mA"
            } else {
                "A"
            }
        }
        "temperature" => "°C",
        "effort" | "torque" | "link_torque" | "force" | "link_force" => kind.effort_unit(),
        _ => return None,
    })
}

/// Joints of a file whose column names show none: from columns that are each other's derivative, else the first column of numbers.
fn guessed_joints(table: &Table, layout: &Layout, left: &mut Vec<usize>) -> String {
    let rows = table.rows();
    let numbers: Vec<usize> = left.iter().copied().filter(|at| is_signal(&table.columns[*at], rows)).collect();
    let time = layout.time.as_ref().filter(|time| time.nanoseconds.is_none());
    let pairs = time.map_or(Vec::new(), |time| {
        let column = &table.columns[time.column];
        let size = column.seconds.unwrap_or_else(|| time.factor().0);
        let seconds: Vec<f64> = column.values.iter().map(|value| value * size).collect();
        let signals: Vec<(usize, &[f64])> =
            numbers.iter().map(|at| (*at, table.columns[*at].values.as_slice())).collect();
        derivative::pairs(&seconds, &signals)
    });
    let mut text = String::new();
    for (number, (position, velocity)) in pairs.iter().enumerate() {
        let name = |at: &usize| written_text(&table.columns[*at].name);
        let _ = write!(
            text,
            "\n[joints.joint{}]  # guess: the second column is the derivative of the first\n\
             position = {{ column = {}, unit = \"rad\" }}\nvelocity = {{ column = {}, unit = \"rad/s\" }}\n",
            number + 1,
            name(position),
            name(velocity)
        );
        left.retain(|at| at != position && at != velocity);
    }
    // A column that always rises is a counter.
    let rises = |at: &&usize| table.columns[**at].values.windows(2).all(|pair| pair[1] > pair[0]);
    if let Some(first) = numbers.iter().find(|at| !rises(at)).or(numbers.first()).filter(|_| pairs.is_empty()) {
        let name = written_text(&table.columns[*first].name);
        let _ = write!(
            text,
            "\n[joints.joint1]  # guess: the file does not tell what its columns hold\nposition = {{ column = {name}, unit = \"rad\" }}\n"
        );
        left.retain(|at| at != first);
    }
    if text.is_empty() {
        "\n[joints.NAME]  # a joint of the model; the file has no column of numbers for it\n".to_owned()
    } else {
        text
    }
}

/// Whether a column holds a number in every row, and not always the same.
fn is_signal(column: &Column, rows: usize) -> bool {
    let values = &column.values;
    column.fault.is_none()
        && values.len() == rows
        && values.iter().all(|value| value.is_finite())
        && values.iter().any(|value| *value != values[0])
}
