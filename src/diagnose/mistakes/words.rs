//! The report of a mistake: its name, what was measured, and what to change.

use super::dead::{self, Dead};
use super::encoder::{SAME, count_ratio};
use super::kinematics::Ratio;
use super::limits::Outside;
use super::meaning::Meaning;
use super::overload::Overload;
use crate::diagnose::result::Mistake;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};
use crate::units::DEG;

/// A number with three digits.
pub fn figure(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude >= 1e5 || (magnitude < 1e-3 && magnitude > 0.0) {
        return format!("{value:.2e}");
    }
    let digits = if magnitude >= 100.0 {
        0
    } else if magnitude >= 10.0 {
        1
    } else if magnitude >= 1.0 {
        2
    } else {
        4
    };
    format!("{value:.digits$}")
}

pub fn name(model: &Model, joint: usize) -> String {
    model.joints[joint].name.clone()
}

fn all(model: &Model) -> Vec<String> {
    model.joints.iter().map(|joint| joint.name.clone()).collect()
}

fn plain(mistake: &'static str, joints: Vec<String>, evidence: String, remedy: String) -> Mistake {
    Mistake { mistake, joints, factor: None, evidence, remedy, alternatives: Vec::new() }
}

/// Dead channels, one mistake per joint and channel.
pub fn dead(model: &Model, found: &[Dead]) -> Vec<Mistake> {
    let mut mistakes: Vec<Mistake> = Vec::new();
    for one in found {
        let joint = name(model, one.joint);
        let unit = model.joints[one.joint].kind.position_unit();
        let since =
            if one.since > 0.0 { format!("from {} s on", figure(one.since)) } else { "all the time".to_owned() };
        let reads = match one.levels {
            1 => format!("is {} {since}", figure(one.value)),
            dead::MANY => "is noise that does not depend on the motion".to_owned(),
            levels => format!("has only {levels} values, which do not depend on the motion"),
        };
        let evidence = format!(
            "{}: {joint}.{} {reads}, while the joint moves by {} {unit}.",
            one.session,
            dead::name(one.channel),
            figure(one.way)
        );
        let remedy = format!(
            "check the column of `{joint}.{}` in the manifest and its sensor; leave out the sessions in which it is dead",
            dead::name(one.channel)
        );
        match mistakes.iter_mut().find(|other| other.remedy == remedy) {
            Some(other) => other.evidence += &format!(" {evidence}"),
            None => mistakes.push(plain("dead_channel", vec![joint], evidence, remedy)),
        }
    }
    mistakes
}

/// Time in another unit.
pub fn time_unit(model: &Model, interval: f64, factor: f64, unit: &str) -> Mistake {
    Mistake {
        mistake: "time_unit",
        joints: all(model),
        factor: Some(factor),
        evidence: format!(
            "The sample interval reads as {} s; taken as {unit} it is {} s, and the motion agrees with velocity or torque.",
            figure(interval),
            figure(interval * factor)
        ),
        remedy: format!(
            "time is recorded in {unit}: say so in the manifest, `[time] unit = \"{unit}\"`, or multiply the column `time` by {factor:e}"
        ),
        alternatives: Vec::new(),
    }
}

/// A time base that is stretched.
pub fn time_base(model: &Model, wrong: &[(usize, Channel, Ratio)], ratio: f64) -> Mistake {
    let factor = ratio;
    let of_joint = |(joint, channel, ratio): &(usize, Channel, Ratio)| {
        format!(
            "{} {}",
            name(model, *joint),
            figure(ratio.ratio) + if *channel == Channel::Velocity { "" } else { " (reference)" }
        )
    };
    let list: Vec<String> = wrong.iter().map(of_joint).collect();
    Mistake {
        mistake: "time_base",
        joints: all(model),
        factor: Some(factor),
        evidence: format!(
            "Change of position divided by integral of velocity is the same factor on every joint; it is 1 if the time is right: {}.",
            list.join(", ")
        ),
        remedy: format!(
            "multiply the column `time` by {}: its unit or the sample rate is not what the file says",
            figure(factor)
        ),
        alternatives: if wrong.len() == 1 { vec!["velocity_scale"] } else { Vec::new() },
    }
}

/// Position and velocity of a joint that differ by a factor.
pub fn velocity(
    model: &Model,
    joint: usize,
    channel: Channel,
    ratio: &Ratio,
    meaning: Meaning,
    turned: bool,
) -> Mistake {
    let b = ratio.ratio;
    let own = name(model, joint);
    let column = if channel == Channel::Velocity { "velocity" } else { "reference_velocity" };
    let evidence = format!(
        "{own}: change of position divided by integral of {column} is {} (1 where both are right), correlation {:.3}.",
        figure(b),
        ratio.at_lag
    );
    let (mistake, factor, remedy) = match meaning {
        Meaning::Sign if turned => (
            "sign_of_joint",
            -1.0,
            "the position has the opposite sign to velocity and torque: `scale = -1` for `position` in the manifest"
                .to_owned(),
        ),
        Meaning::Sign => (
            "sign_of_velocity",
            -1.0,
            format!(
                "the velocity has the opposite sign to position and torque: `scale = -1` for `{column}` in the manifest"
            ),
        ),
        Meaning::Position(unit) => (unit, 1.0 / b, position_remedy(unit)),
        Meaning::Velocity(unit) => (unit, b, velocity_remedy(unit, column)),
        Meaning::Unknown => (
            "velocity_scale",
            b,
            format!(
                "`scale = {}` for `{column}` in the manifest, or its inverse for `position`: one of the two is in another unit",
                figure(b)
            ),
        ),
    };
    Mistake { mistake, joints: vec![own], factor: Some(factor), evidence, remedy, alternatives: Vec::new() }
}

pub fn position_remedy(unit: &str) -> String {
    match unit {
        "degrees_for_radians" => "positions are in degrees: `unit = \"deg\"` for `position` in the manifest".to_owned(),
        "millimetres_for_metres" => {
            "positions are in millimetres: `unit = \"mm\"` for `position` in the manifest".to_owned()
        }
        _ => "positions are those of the motor: divide them by `gear_ratio`, `scale` of `position` in the manifest"
            .to_owned(),
    }
}

fn velocity_remedy(unit: &str, column: &str) -> String {
    match unit {
        "degrees_for_radians" => format!("velocities are in deg/s: `unit = \"deg/s\"` for `{column}` in the manifest"),
        "rpm_for_radians_per_second" => {
            format!("velocities are in revolutions per minute: `unit = \"rpm\"` for `{column}` in the manifest")
        }
        "millimetres_for_metres" => format!("velocities are in mm/s: `scale = 0.001` for `{column}` in the manifest"),
        _ => format!(
            "velocities are those of the motor: divide them by `gear_ratio`, `scale` of `{column}` in the manifest"
        ),
    }
}

/// A velocity or position that is late.
pub fn late_velocity(model: &Model, joint: usize, ratio: &Ratio) -> Mistake {
    let own = name(model, joint);
    let (column, other) = if ratio.lag > 0.0 { ("velocity", "position") } else { ("position", "velocity") };
    let late = ratio.lag.abs();
    Mistake {
        mistake: "late_channel",
        joints: vec![own.clone()],
        factor: None,
        evidence: format!(
            "{own}: {column} follows {other} by about {late:.2} s: correlation {:.3} at that lag, {:.3} without.",
            ratio.at_lag, ratio.correlation
        ),
        remedy: format!(
            "shift `{column}` of {own} by {late:.2} s to earlier times, or record both channels by one clock"
        ),
        alternatives: Vec::new(),
    }
}

/// Encoder counts of another size than the model's.
pub fn counts(model: &Model, sessions: &[&TimeSeries]) -> Vec<Mistake> {
    let dof = model.joints.len();
    let off = |ratio: &f64| ratio.ln().abs() > SAME;
    let ratios: Vec<Option<f64>> = (0..dof).map(|joint| count_ratio(model, joint, sessions).filter(off)).collect();
    let step = |joint: usize| model.joints[joint].encoder_step();
    // Each of the two joints has the counts of the other.
    let exchanged = |i: usize, j: usize| match (ratios[i], ratios[j]) {
        (Some(one), Some(other)) => {
            let expected = step(j) / step(i);
            (one / expected).ln().abs() < SAME && (other * expected).ln().abs() < SAME
        }
        _ => false,
    };
    let mut mistakes = Vec::new();
    for (i, ratio) in ratios.iter().enumerate() {
        let Some(ratio) = *ratio else { continue };
        match (0..dof).find(|j| *j != i && exchanged(i, *j)) {
            Some(j) if j > i => mistakes.push(exchanged_counts(model, [i, j], ratio)),
            Some(_) => {}
            None => mistakes.push(count(model, i, ratio)),
        }
    }
    mistakes
}

fn counts_differ(own: &str, ratio: f64) -> String {
    format!(
        "{own}: the position moves by counts of {} times what `counts_per_turn` and `gear_ratio` of the model give.",
        figure(ratio)
    )
}

fn exchanged_counts(model: &Model, [i, j]: [usize; 2], ratio: f64) -> Mistake {
    let (one, other) = (name(model, i), name(model, j));
    Mistake {
        mistake: "joints_swapped",
        evidence: format!("{} {other} has the counts of {one} in turn.", counts_differ(&one, ratio)),
        remedy: format!(
            "exchange the columns of {one} and {other} in the manifest, `position` and `velocity` at least, or their `gear_ratio` in the model file"
        ),
        joints: vec![one, other],
        factor: None,
        alternatives: vec!["gear_ratio"],
    }
}

fn count(model: &Model, joint: usize, ratio: f64) -> Mistake {
    let (n, own) = (model.joints[joint].gear_ratio, name(model, joint));
    let is = |factor: f64| (ratio / factor).ln().abs() < SAME;
    let (mistake, factor, remedy, alternatives) = if is(1.0 / DEG) {
        ("degrees_for_radians", DEG, position_remedy("degrees_for_radians"), Vec::new())
    } else if is(n) {
        ("motor_angle_for_joint_angle", 1.0 / n, position_remedy("motor"), vec!["gear_ratio"])
    } else if is(n / DEG) {
        ("motor_degrees_for_joint_angle", DEG / n, position_remedy("motor"), Vec::new())
    } else {
        let remedy = format!(
            "`gear_ratio = {}` for {own} in the model file, if `counts_per_turn` is right; otherwise multiply `counts_per_turn` by {}",
            figure(n / ratio),
            figure(1.0 / ratio)
        );
        ("gear_ratio", 1.0 / ratio, remedy, vec!["encoder_counts"])
    };
    let evidence = counts_differ(&own, ratio);
    Mistake { mistake, joints: vec![own], factor: Some(factor), evidence, remedy, alternatives }
}

/// Positions beyond the range of the joint.
pub fn limits(model: &Model, outside: &Outside) -> Mistake {
    let (joint, [low, high], names) = (outside.joint, outside.extent, &outside.units);
    let own = name(model, joint);
    let limits = model.robot.bodies[joint].joint.limits;
    let unit = model.joints[joint].kind.position_unit();
    Mistake {
        mistake: names[0].1,
        joints: vec![own.clone()],
        factor: Some(names[0].0),
        evidence: format!(
            "{own}: positions from {} to {} {unit}; the URDF allows {} to {} {unit}.",
            figure(low),
            figure(high),
            figure(limits.lower),
            figure(limits.upper)
        ),
        remedy: position_remedy(names[0].1),
        alternatives: names[1..].iter().map(|one| one.1).collect(),
    }
}

/// Torques beyond what the drive can give; the factors that bring them back, by name.
pub fn overload(model: &Model, from_current: bool, overload: &Overload) -> Mistake {
    let joint = &model.joints[overload.joint];
    let named: [(f64, &'static str); 3] = if from_current {
        [
            (1e-3, "milliampere_for_ampere"),
            (1.0 / joint.torque_per_ampere(), "torque_recorded_as_current"),
            (1.0 / joint.gear_ratio, "gear_ratio"),
        ]
    } else {
        [(1e-3, "torque_scale"), (1.0 / joint.gear_ratio, "torque_scale"), (1.0, "torque_scale")]
    };
    let mut names: Vec<&'static str> =
        named.iter().filter(|(factor, _)| *factor < 1.0 && overload.explained_by(*factor)).map(|one| one.1).collect();
    names.dedup();
    let first = names.first().copied().unwrap_or("torque_scale");
    let unit = joint.kind.effort_unit();
    Mistake {
        mistake: first,
        joints: vec![joint.name.clone()],
        factor: None,
        evidence: format!(
            "{}: the recorded torque reaches {} {unit}, {} times what effort limit and current limit of URDF and model file allow.",
            joint.name, figure(overload.torque), figure(overload.times())
        ),
        remedy: "say in the manifest what the channel holds: `unit = \"mA\"` for a current in milliamperes, `torque` instead of `current` for a torque; or correct `gear_ratio` and `torque_constant` in the model file".to_owned(),
        alternatives: names.iter().skip(1).copied().collect(),
    }
}
