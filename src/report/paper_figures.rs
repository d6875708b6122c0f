//! The paper's figures of an identification: staircase (2), one reversal (5), friction of a joint (6 and 7).

use super::display::{self, shown};
use super::plot::{Layer, Mark, Plot, Role};
use crate::gearhead::{Direction, FrictionLaw};
use crate::identify::backlash::ShownReversal;
use crate::identify::{JointIdentification, LawKind};
use crate::timeseries::{Channel, Drawn, Envelope};
use crate::units::JointKind;

/// Points of a curve in one direction.
const CURVE: usize = 240;

/// All of a joint; `drawn` are the recordings, and `truth` is the injected friction where it is known.
pub fn of_joint(joint: &JointIdentification, drawn: &[Drawn], truth: Option<FrictionLaw>) -> Vec<Plot> {
    let gap = joint.backlash.as_ref().and_then(|gap| gap.shown.as_ref());
    let reversal = gap.map(|shown| reversal(&joint.joint, joint.kind, shown));
    let staircase = staircase(joint, drawn);
    [friction(joint, truth)].into_iter().chain(reversal.into_iter().flatten()).chain(staircase).collect()
}

/// Names of the files of these figures for a joint.
pub fn files(joint: &str) -> [String; 4] {
    ["friction", "reversal_velocity", "reversal_torque", "staircase"].map(|figure| file(figure, joint))
}

fn file(figure: &str, joint: &str) -> String {
    format!("{figure}_{joint}")
}

/// Figure 2: the reference of the session in which the joint moves fastest.
fn staircase(joint: &JointIdentification, drawn: &[Drawn]) -> Option<Plot> {
    let reference = |session: &'_ Drawn| -> Option<Envelope> {
        let drawn = session.joints.iter().find(|one| one.name == joint.joint)?;
        drawn.channels.get(&Channel::ReferenceVelocity).cloned()
    };
    let fastest = |line: &Envelope| line.values.iter().fold(0.0_f64, |fastest, v| fastest.max(v.abs()));
    let line = drawn.iter().filter_map(reference).max_by(|a, b| fastest(a).total_cmp(&fastest(b)))?;
    if fastest(&line) == 0.0 {
        return None;
    }
    let (unit, factor) = shown(joint.kind.velocity_unit());
    let points = line.time.iter().zip(&line.values).map(|(time, v)| [*time, v * factor]).collect();
    let title = format!("{}: reference velocity (Figure 2)", joint.joint);
    let plot = Plot::new(title, "time [s]", format!("velocity [{unit}]")).in_file(file("staircase", &joint.joint));
    Some(plot.with(Layer::new("", Mark::Line, Role::Reference, points)))
}

/// Figure 5: velocity and current at one reversal, `t1`, `t2`, and the area between them.
fn reversal(joint: &str, kind: JointKind, one: &ShownReversal) -> [Plot; 2] {
    let (unit, factor) = shown(kind.velocity_unit());
    let series = |values: &[f64], factor: f64| -> Vec<[f64; 2]> {
        one.time.iter().zip(values).map(|(time, value)| [*time, value * factor]).collect()
    };
    let [t1, t2] = one.ends;
    let velocity = series(&one.velocity, factor);
    let (start, end) = (one.time[t1], one.time[t2]);
    let mut area = vec![[start, 0.0]];
    area.extend_from_slice(&velocity[t1..=t2]);
    area.push([end, 0.0]);
    let integrated = display::value(one.area, kind.position_unit());
    let over_time = |title: &str, axis: String| Plot::new(format!("{joint}: {title} (Figure 5)"), "time [s]", axis);
    let torque = series(&one.filtered, 1.0);
    [
        over_time("velocity at a reversal", format!("velocity [{unit}]"))
            .with(Layer::new(format!("area from t1 to t2: {integrated}"), Mark::Band, Role::Fit, area))
            .with(Layer::new("measured", Mark::Line, Role::Measured, velocity.clone()))
            .with(Layer::new("t1", Mark::Points, Role::Before, vec![velocity[t1]]))
            .with(Layer::new("t2", Mark::Points, Role::After, vec![velocity[t2]]))
            .in_file(file("reversal_velocity", joint)),
        over_time("torque from the current at a reversal", format!("torque [{}]", kind.effort_unit()))
            .with(Layer::new("measured", Mark::Line, Role::Measured, series(&one.torque, 1.0)))
            .with(Layer::new("filtered", Mark::Line, Role::Fit, torque.clone()))
            .with(Layer::new("t1", Mark::Points, Role::Before, vec![torque[t1]]))
            .with(Layer::new("t2", Mark::Points, Role::After, vec![torque[t2]]))
            .in_file(file("reversal_torque", joint)),
    ]
}

/// Figures 6 and 7: points of equation 11 as they were measured, those of the balance over the motion, and both laws.
fn friction(joint: &JointIdentification, truth: Option<FrictionLaw>) -> Plot {
    let (unit, factor) = shown(joint.kind.velocity_unit());
    let fastest = 1.03 * joint.friction.speeds[1];
    let measured = joint.points.iter().map(|point| {
        // The average of the velocity channel is the paper's; where none was recorded, the counts give it.
        let velocity = point.mean_measured_velocity.unwrap_or(point.velocity);
        [velocity * factor, point.torque - point.rigid_body]
    });
    let balanced = joint.points.iter().map(|point| [point.velocity * factor, point.friction]);
    let law = |kind: LawKind| curve(&joint.friction.law(kind), fastest, factor);
    let effort = joint.kind.effort_unit();
    let title = format!("{}: friction (Figures 6 and 7)", joint.joint);
    let mut plot = Plot::new(title, format!("velocity [{unit}]"), format!("friction [{effort}]"))
        .in_file(file("friction", &joint.joint))
        .with(Layer::new("measured, equation 11", Mark::Points, Role::Measured, measured.collect()))
        .with(Layer::new("balance over the motion", Mark::Points, Role::Before, balanced.collect()))
        .with(Layer::new("two lines", Mark::Line, Role::After, law(LawKind::TwoLines)))
        .with(Layer::new("exponential law", Mark::Line, Role::Fit, law(LawKind::Exponential)));
    if let Some(truth) = truth {
        plot = plot.with(Layer::new("injected", Mark::Dashed, Role::Truth, curve(&truth, fastest, factor)));
    }
    plot
}

/// A law in both directions, in the units of the plot, interrupted at rest.
fn curve(law: &FrictionLaw, fastest: f64, factor: f64) -> Vec<[f64; 2]> {
    let branch = |direction: Direction| {
        (0..=CURVE).map(move |k| {
            #[expect(clippy::cast_precision_loss, reason = "a few hundred")]
            let share = k as f64 / CURVE as f64;
            // The curve bends at low speeds, so most of its points are there.
            let speed = fastest * share * share;
            let sign = direction.sign();
            [sign * speed * factor, sign * law.magnitude(direction, speed)]
        })
    };
    let interruption = std::iter::once([f64::NAN; 2]);
    branch(Direction::Positive).chain(interruption).chain(branch(Direction::Negative)).collect()
}
