//! The table `[controller]` of a scenario file.

use super::{ControllerSettings, Feedback, Law, ranges};
use crate::control::{ObserverNoise, PiGains, SlidingGains};
use crate::error::Result;
use crate::robot::{JointModel, Model};
use crate::toml_input::{Range, Table};
use crate::units::JointKind;

/// [1] Standard deviation of an edge's position in counts, if the file gives none.
const EDGE_NOISE: f64 = 0.05;

/// [(rad/s)/√s or (m/s)/√s] Random walk of the observed velocity, if the file gives none.
const VELOCITY_NOISE: f64 = 0.01;

#[derive(Clone, Copy)]
enum Kind {
    SlidingMode,
    Independent,
    Pi,
}

/// Reads `law`, `velocity` and one table of gains for every joint of the model.
pub(super) fn read(table: &Table<'_>, model: &Model) -> Result<ControllerSettings> {
    let laws = [("sliding_mode", Kind::SlidingMode), ("independent", Kind::Independent), ("pi", Kind::Pi)];
    let law = table.optional_choice("law", &laws)?.unwrap_or(Kind::SlidingMode);
    let observed = table.optional_choice("velocity", &[("sensor", false), ("observer", true)])?.unwrap_or(false);
    let joints = table.table("joints")?;
    let (mut sliding, mut pi) = (Vec::new(), Vec::new());
    let (mut feedback, mut velocity_error_limit) = (Vec::new(), Vec::new());
    for joint in &model.joints {
        let table = joints.table(&joint.name)?;
        match law {
            Kind::SlidingMode | Kind::Independent => sliding.push(sliding_gains(&table, joint)?),
            Kind::Pi => pi.push(pi_gains(&table, joint)?),
        }
        feedback.push(feedback_of(&table, joint, observed)?);
        let speed = ranges::speed_error(joint.kind);
        velocity_error_limit.push(table.number_or("velocity_error_limit", &speed, f64::INFINITY)?);
        table.finish()?;
    }
    joints.finish()?;
    table.finish()?;
    let law = match law {
        Kind::SlidingMode => Law::SlidingMode(sliding),
        Kind::Independent => Law::Independent(sliding),
        Kind::Pi => Law::Pi(pi),
    };
    Ok(ControllerSettings { law, feedback, velocity_error_limit })
}

fn sliding_gains(table: &Table<'_>, joint: &JointModel) -> Result<SlidingGains> {
    Ok(SlidingGains {
        lambda: table.number("lambda", &ranges::positive_gain("1/s"))?,
        switching: table.number("switching", &ranges::positive_gain(joint.kind.effort_unit()))?,
        boundary: table.number("boundary", &ranges::speed_error(joint.kind))?,
    })
}

fn pi_gains(table: &Table<'_>, joint: &JointModel) -> Result<PiGains> {
    let (proportional, integral) = match joint.kind {
        JointKind::Revolute => ("N·m·s/rad", "N·m/rad"),
        JointKind::Prismatic => ("N·s/m", "N/m"),
    };
    Ok(PiGains {
        proportional: table.number("proportional", &ranges::positive_gain(proportional))?,
        integral: table.number_or("integral", &ranges::gain(integral), 0.0)?,
    })
}

/// The observer's parameters are allowed even if the sensor is used, so that one word switches between the two.
fn feedback_of(table: &Table<'_>, joint: &JointModel, observed: bool) -> Result<Feedback> {
    let (disturbance, velocity) = match joint.kind {
        JointKind::Revolute => ("N·m/√s", "(rad/s)/√s"),
        JointKind::Prismatic => ("N/√s", "(m/s)/√s"),
    };
    let noise = ObserverNoise {
        disturbance: match table.optional_number("disturbance_noise", &ranges::positive_gain(disturbance))? {
            None if observed => table.number("disturbance_noise", &ranges::positive_gain(disturbance))?,
            given => given.unwrap_or_default(),
        },
        velocity: table.number_or("velocity_noise", &ranges::gain(velocity), VELOCITY_NOISE)?,
        edge: table.number_or("edge_noise", &Range::positive("counts").up_to(1e3), EDGE_NOISE)?,
    };
    Ok(if observed { Feedback::Observer(noise) } else { Feedback::Sensor })
}
