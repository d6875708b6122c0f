//! What experiments that are planned for a machine have in common: the friction and the controller with which they are rehearsed in
//! simulation, the check of efforts, and the table of references that a real controller plays.

use std::fmt::Write as _;

use super::Session;
use super::reach::Reach;
use super::trial::gains;
use crate::control::Target;
use crate::dynamics::Dynamics;
use crate::error::{Error, Place, Result};
use crate::gearhead::{Exponential, Friction, FrictionLaw};
use crate::robot::{JointModel, Model, Placeholders, two_digits};
use crate::toml_input::{written_key, written_number};
use crate::units::JointKind;

/// [s] Between two readings in the rehearsal.
pub(super) const CONTROL_PERIOD: f64 = 0.001;

/// [1] Largest part of a joint's speed limit.
pub(super) const SPEED_SHARE: f64 = 0.3;

/// [1] Effort that is planned for, per effort of links and rotors alone.
const EFFORT_MARGIN: f64 = 1.3;

/// [s] Interval of the table of references, and of the check of efforts.
const INTERVAL: f64 = 0.01;

/// [rad/s² or m/s²] Deceleration by which the rehearsal's friction alone would stop a joint: a placeholder.
const FRICTION: f64 = 1.0;

/// [1] Most of that friction as a part of the joint's effort limit.
const FRICTION_SHARE: f64 = 0.05;

/// [rad/s or m/s] Top speed of a staircase with room and without limits.
pub(super) fn top_speed(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => 10.0_f64.to_radians(),
        JointKind::Prismatic => 0.05,
    }
}

/// Friction of the rehearsal, and rotors, gears and encoders that are guesses, as assignments to the model. Their keys are split at dots: joints with
/// special characters in their names get none.
pub(super) fn write_assumed(text: &mut String, model: &Model, reaches: &[Reach], placeholders: &Placeholders) {
    let plain = |joint: &JointModel| {
        joint.friction.is_none() && joint.name.chars().all(|c| c.is_alphanumeric() || "_-".contains(c))
    };
    *text += "model = [                           # for the rehearsal only\n";
    for (index, joint) in model.joints.iter().enumerate().filter(|(_, joint)| plain(joint)) {
        let Exponential { coulomb, breakaway, stribeck_velocity, viscous } = rehearsed(model, &reaches[index], index);
        let friction = [
            ("friction.coulomb", coulomb),
            ("friction.breakaway", breakaway),
            ("friction.stribeck_velocity", stribeck_velocity),
            ("friction.viscous", viscous),
        ];
        let gear = [
            ("rotor_inertia", joint.rotor_inertia),
            ("gear_stiffness", joint.gear_stiffness),
            ("gear_damping", joint.gear_damping),
            ("encoder.counts_per_turn", joint.encoder.map(|encoder| encoder.counts_per_turn)),
        ];
        let guessed = gear.into_iter().filter(|(key, _)| placeholders.is_guess(&joint.name, key));
        let guessed = guessed.filter_map(|(key, value)| Some((key, value?)));
        for (key, value) in guessed.chain(friction) {
            let _ = writeln!(text, "  \"joints.{}.{key} = {}\",  # placeholder", joint.name, written_number(value));
        }
    }
    *text += "]\n";
}

/// The controller of the rehearsal.
pub(super) fn write_controller(text: &mut String, model: &Model, reaches: &[Reach]) {
    *text += "\n[controller]\nlaw = \"independent\"\nvelocity = \"sensor\"\n";
    let rehearsal = with_friction(model, reaches);
    for (index, joint) in model.joints.iter().enumerate() {
        let gains = gains(&rehearsal, reaches, index, CONTROL_PERIOD);
        let _ = writeln!(
            text,
            "[controller.joints.{}]\nlambda = {:?}\nswitching = {:?}\nboundary = {:?}",
            written_key(&joint.name),
            gains.lambda,
            two_digits(gains.switching),
            two_digits(gains.boundary)
        );
    }
}

/// The model with the friction of the rehearsal.
pub(super) fn with_friction(model: &Model, reaches: &[Reach]) -> Model {
    let mut model = model.clone();
    for (index, reach) in reaches.iter().enumerate() {
        let law = rehearsed(&model, reach, index);
        let own = Friction { law: FrictionLaw::Exponential([law; 2]), link_share: 0.0 };
        if model.joints[index].friction.is_none() {
            model.set_friction(index, own);
        }
    }
    model
}

/// Friction of the rehearsal, where the model has none.
fn rehearsed(model: &Model, reach: &Reach, index: usize) -> Exponential {
    let (joint, limits) = (&model.joints[index], model.robot.bodies[index].joint.limits);
    let coulomb = two_digits((FRICTION * reach.inertia).min(FRICTION_SHARE * limits.effort));
    let top = top_speed(joint.kind);
    // A third more at rest, which falls off over a tenth of the top speed; at three times the top speed the viscous part is as large as
    // Coulomb friction.
    Exponential {
        coulomb,
        breakaway: two_digits(1.3 * coulomb),
        stribeck_velocity: two_digits(0.1 * top),
        viscous: two_digits(coulomb / (3.0 * top)),
    }
}

/// Refuses a motion for which a joint needs more than its effort limit.
pub(super) fn check_effort(model: &Model, session: &Session) -> Result<()> {
    let n = model.joints.len();
    let mut dynamics = Dynamics::new(&model.robot);
    let (mut targets, mut torques) = (vec![Target::default(); n], vec![0.0; n]);
    for tick in 0..=(session.duration / INTERVAL) as usize {
        session.profile.sample(tick as f64 * INTERVAL, &mut targets);
        let each = |of: fn(&Target) -> f64| targets.iter().map(of).collect::<Vec<f64>>();
        let (q, v, a) = (each(|t| t.position), each(|t| t.velocity), each(|t| t.acceleration));
        dynamics.inverse(&q, &v, &a, &mut torques);
        for (i, body) in model.robot.bodies.iter().enumerate() {
            let torque = (torques[i] + model.joints[i].reflected_inertia() * a[i]).abs();
            let (limit, unit) = (body.joint.limits.effort, body.joint.kind.effort_unit());
            if EFFORT_MARGIN * torque > limit {
                let key = format!("joint {}: limit effort", body.joint.name);
                let expected = format!(
                    "at least {:.3} {unit}: links and rotors alone need {torque:.3} {unit} in the first experiment",
                    EFFORT_MARGIN * torque
                );
                return Err(Error::input(&model.urdf, Place::File, key, limit, expected));
            }
        }
    }
    Ok(())
}

/// Positions and velocities of the reference of all joints, every hundredth of a second.
pub(super) fn references(model: &Model, session: &Session) -> String {
    let mut targets = vec![Target::default(); model.joints.len()];
    let mut text = String::from("time");
    for joint in &model.joints {
        let name = quoted(&joint.name);
        let _ = write!(text, ",{}", name(".reference_position"));
        let _ = write!(text, ",{}", name(".reference_velocity"));
    }
    for tick in 0..=(session.duration / INTERVAL).ceil() as usize {
        let time = tick as f64 * INTERVAL;
        session.profile.sample(time, &mut targets);
        let _ = write!(text, "\n{time:.2}");
        for Target { position, velocity, .. } in &targets {
            let _ = write!(text, ",{position:.9},{velocity:.9}");
        }
    }
    text.push('\n');
    text
}

/// A column's name of a joint, in quotes where CSV needs them.
fn quoted(joint: &str) -> impl Fn(&str) -> String {
    move |column| {
        let name = format!("{joint}{column}");
        if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name }
    }
}
