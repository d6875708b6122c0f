//! Errors of the simulation before any cause is sought: a sentence per joint, a table, and small plots of its maps.

use super::display::shown;
use super::document::Section;
use super::number::significant;
use super::plot::{Layer, Mark, Plot, Role};
use super::table::Table;
use crate::diagnose::{
    Axis, AxisShare, Diagnosis, FrequencySpectrum, JointShares, OrderSpectrum, ResidualMap, Verdict, ZoneShares,
};
use crate::units::JointKind;

/// An error counts as no larger than its floor up to this ratio: the floor is known to about a factor of two.
const AT_FLOOR: f64 = 2.0;
/// [%] The simplest axis is chosen if its share is within this of the best.
const AS_GOOD: f64 = 3.0;
/// [%] Below this share, no dependence on a quantity is stated.
const WORTH_SAYING: f64 = 20.0;
/// Part of a share that must be equal in both directions, or opposite, for the dependence to be described so.
const MOSTLY: f64 = 0.8;

/// The first section: sentences and the table of shares.
pub fn section(diagnosis: &Diagnosis) -> Section {
    let mut section = Section::new("What the simulation gets wrong");
    section.text.extend(diagnosis.shares.iter().map(|joint| sentence(joint, diagnosis.verdict)));
    section.text.push("Percentages of an error are of its square; shares of several quantities overlap.".to_owned());
    section.tables.push(table(&diagnosis.shares));
    section
}

/// A sentence on one joint.
fn sentence(joint: &JointShares, verdict: Verdict) -> String {
    let times = joint.rms / joint.floor.max(1e-300);
    let size = format!(
        "{}: {} {} RMS on data held out, {} % of its {}, {}× its sensor floor",
        joint.joint,
        significant(joint.rms, 3),
        joint.unit,
        significant(joint.torque_percent, 2),
        joint.quantity,
        significant(times, 2)
    );
    if times < AT_FLOOR {
        return format!("{size}: only the noise and quantisation of the sensors remain.");
    }
    let mut sentence = format!("{size}; {}", dependence(&joint.axes));
    // Mentioned if it is more than twice the share of time that reversals take.
    let at_reversals = |zones: &ZoneShares| zones.reversal_percent > WORTH_SAYING.max(2.0 * zones.time_percent[1]);
    if let Some(zones) = joint.zones.filter(at_reversals) {
        sentence += &format!(
            "; in simulation {:.0} % of it lies around reversals, where the link crosses its gap",
            zones.reversal_percent
        );
    }
    if verdict == Verdict::NothingFound {
        sentence += "; no effect of the catalogue is supported by the evidence";
    }
    sentence + "."
}

/// The chosen axis in words.
fn dependence(axes: &[AxisShare]) -> String {
    // If a quantity of the motion explains a line in time nearly as well, the line is attributed to that quantity.
    let claim = |axis: &AxisShare| axis.share_percent - if axis.axis == Axis::Frequency { 10.0 } else { 0.0 };
    let best = axes.iter().map(claim).fold(0.0, f64::max);
    let simplest = axes.iter().find(|axis| claim(axis) > best - AS_GOOD);
    match simplest.filter(|axis| axis.share_percent >= WORTH_SAYING) {
        Some(axis) => {
            let as_good = |other: &&AxisShare| other.axis != axis.axis && claim(other) >= claim(axis);
            let others: Vec<&str> = axes.iter().filter(as_good).map(|other| name(other.axis)).collect();
            let or = if others.is_empty() { String::new() } else { format!(" (or {})", others.join(", ")) };
            format!("{:.0} % of it {}{or}", axis.share_percent, words(axis))
        }
        None => format!("no single quantity explains more than {best:.0} % of it"),
    }
}

fn words(axis: &AxisShare) -> String {
    let what = match axis.axis {
        Axis::Constant => "is the same everywhere",
        Axis::Direction => "depends only on the direction of motion",
        Axis::Velocity => "depends on velocity",
        Axis::Position => "depends on position",
        Axis::Load => "depends on the torque through the gear",
        Axis::MotorAngle => "repeats with every turn of the motor",
        Axis::Acceleration => "depends on acceleration",
        Axis::ReversalPhase => "depends on the time since the last reversal",
        Axis::Time => "drifts with time",
        Axis::Frequency => {
            return format!("is a line at {} Hz", significant(axis.frequency.unwrap_or(0.0), 3));
        }
    };
    let (Some(alike), Some(opposed)) = (axis.alike_percent, axis.opposed_percent) else { return what.to_owned() };
    let how = if alike >= MOSTLY * axis.share_percent {
        "alike in both directions"
    } else if opposed >= MOSTLY * axis.share_percent {
        "against the motion in both directions, as friction does"
    } else {
        "differently in each direction"
    };
    format!("{what}, {how}")
}

const fn name(axis: Axis) -> &'static str {
    match axis {
        Axis::Constant => "constant",
        Axis::Direction => "direction",
        Axis::Velocity => "velocity",
        Axis::Position => "position",
        Axis::Load => "gear torque",
        Axis::MotorAngle => "motor angle",
        Axis::Acceleration => "acceleration",
        Axis::ReversalPhase => "reversal phase",
        Axis::Time => "time",
        Axis::Frequency => "one frequency",
    }
}

/// Zones and axes, with two columns per joint.
fn table(shares: &[JointShares]) -> Table {
    let heads = ["squared error of the nominal model"].into_iter().chain(shares.iter().map(|one| one.joint.as_str()));
    let mut table = Table::new("", &heads.collect::<Vec<_>>());
    let mut row = |label: String, value: &dyn Fn(&JointShares) -> String| {
        table.row(std::iter::once(label).chain(shares.iter().map(value)));
    };
    let percent = |value: f64| format!("{value:.0} %");
    if shares.iter().any(|one| one.zones.is_some()) {
        for (index, label) in ["in the rigid zone", "around reversals", "elsewhere"].into_iter().enumerate() {
            row(format!("simulated: {label} (of the time)"), &|one| {
                let Some(zones) = one.zones else { return String::new() };
                let part = [zones.rigid_percent, zones.reversal_percent, zones.rest_percent][index];
                format!("{part:.0} % ({:.0} %)", zones.time_percent[index])
            });
        }
    }
    let axes = shares.first().map_or(&[][..], |one| &one.axes);
    for (index, axis) in axes.iter().enumerate() {
        row(format!("rigid zone: explained by {}", name(axis.axis)), &|one| {
            one.axes.get(index).map_or_else(String::new, |axis| percent(axis.share_percent))
        });
    }
    table
}

/// The small plots of a joint: its maps and spectra with the floor of its sensors.
pub fn multiples(diagnosis: &Diagnosis, joint: &str, kind: JointKind) -> Section {
    let mut section = Section { detail: true, ..Section::new(format!("{joint}: what its error depends on")) };
    section.text.push(
        "Measured less simulated torque. Alike: half the sum of both directions of motion; opposed: half their difference; \
         grey: what noise and quantisation of the sensors leave of a single sample (of a line, in the spectra)."
            .to_owned(),
    );
    let share = |axis: Axis| {
        let of_joint = diagnosis.shares.iter().find(|one| one.joint == joint)?;
        of_joint.axes.iter().find(|one| one.axis == axis).map(|one| one.share_percent)
    };
    let maps = diagnosis.maps.iter().filter(|map| map.joint == joint && map.axis != Axis::Direction);
    section.plots.extend(maps.map(|map| over_axis(map, kind, share(map.axis))));
    let orders = diagnosis.order_spectrum.iter().filter(|one| one.joint == joint);
    section.plots.extend(orders.map(|one| over_order(one, kind)));
    let spectra = diagnosis.frequency_spectrum.iter().filter(|one| one.joint == joint);
    section.plots.extend(spectra.map(|one| over_frequency(one, kind, share(Axis::Frequency))));
    section
}

fn titled(against: &str, share: Option<f64>) -> String {
    share.map_or_else(|| format!("Against {against}"), |share| format!("Against {against}: {share:.0} %"))
}

fn over_axis(map: &ResidualMap, kind: JointKind, share: Option<f64>) -> Plot {
    let si = match map.axis {
        Axis::Velocity => kind.velocity_unit(),
        Axis::Position => kind.position_unit(),
        Axis::MotorAngle => "rad",
        Axis::Load => kind.effort_unit(),
        Axis::Acceleration if kind == JointKind::Revolute => "rad/s²",
        Axis::Acceleration => "m/s²",
        Axis::Time | Axis::ReversalPhase => "s",
        Axis::Frequency => "Hz",
        Axis::Constant | Axis::Direction => "1",
    };
    let (unit, factor) = shown(si);
    let x: Vec<f64> = map.centre.iter().map(|x| x * factor).collect();
    let points = |values: &[f64]| x.iter().zip(values).map(|(x, y)| [*x, *y]).collect::<Vec<_>>();
    let label = match map.axis {
        Axis::ReversalPhase => "time since a reversal",
        axis => name(axis),
    };
    let plot = Plot::new(titled(label, share), format!("{label} [{unit}]"), format!("error [{}]", kind.effort_unit()))
        .small()
        .with(Layer::new("floor", Mark::Band, Role::Reference, band(&x, &map.floor)));
    // If most bins have one direction only, the directions cannot be compared.
    let both = map.alike.iter().filter(|value| value.is_finite()).count();
    let apart = !matches!(map.axis, Axis::Load | Axis::Acceleration) && 2 * both > map.centre.len();
    let plot = if apart {
        plot.with(Layer::new("alike", Mark::Line, Role::Before, points(&map.alike))).with(Layer::new(
            "opposed",
            Mark::Dashed,
            Role::Before,
            points(&map.opposed),
        ))
    } else {
        plot.with(Layer::new("nominal", Mark::Line, Role::Before, points(&map.before)))
    };
    plot.with(Layer::new("extended", Mark::Line, Role::After, points(&map.after)))
}

/// Outline of the range from `−height` to `height`.
fn band(x: &[f64], height: &[f64]) -> Vec<[f64; 2]> {
    let upper = x.iter().zip(height).map(|(x, y)| [*x, *y]);
    let lower = x.iter().zip(height).rev().map(|(x, y)| [*x, -y]);
    upper.chain(lower).collect()
}

fn over_order(spectrum: &OrderSpectrum, kind: JointKind) -> Plot {
    let title = "Against the order of the motor".to_owned();
    amplitudes(
        title,
        "periods per motor turn",
        &spectrum.order,
        [&spectrum.before, &spectrum.after],
        spectrum.floor,
        kind,
    )
}

fn over_frequency(spectrum: &FrequencySpectrum, kind: JointKind, share: Option<f64>) -> Plot {
    let title = share.map_or_else(String::new, |share| format!("Against frequency: {share:.0} % in one line"));
    amplitudes(title, "frequency [Hz]", &spectrum.frequency, [&spectrum.before, &spectrum.after], spectrum.floor, kind)
}

fn amplitudes(
    title: String,
    across: &str,
    x: &[f64],
    [before, after]: [&[f64]; 2],
    floor: f64,
    kind: JointKind,
) -> Plot {
    let points = |values: &[f64]| x.iter().zip(values).map(|(x, y)| [*x, *y]).collect::<Vec<_>>();
    let [first, last] = [x.first(), x.last()].map(|end| end.copied().unwrap_or(0.0));
    let floor = vec![[first, 0.0], [first, floor], [last, floor], [last, 0.0]];
    Plot::new(title, across, format!("amplitude [{}]", kind.effort_unit()))
        .small()
        .with(Layer::new("floor", Mark::Band, Role::Reference, floor))
        .with(Layer::new("nominal", Mark::Line, Role::Before, points(before)))
        .with(Layer::new("extended", Mark::Line, Role::After, points(after)))
}
