//! How strong an effect of strength 1 is on these machines, and what else of it is drawn.
//!
//! Strength 1 is clearly visible and not grotesque: where it acts it moves the torque by roughly a tenth to a third of what friction
//! and inertia take, or shows as much at reversals. Half the strength is half the torque, the angle or the time of it.

use std::f64::consts::PI;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::machine::{Friction, around};

/// Parameters of an effect by name.
pub type Drawn = Vec<(&'static str, f64)>;

/// What the strengths on a joint are measured by.
#[derive(Debug, Clone, Copy)]
pub struct JointSizes {
    /// Motor turns per joint turn.
    pub gear_ratio: f64,
    /// [kg·m²] on the joint side.
    pub rotor_inertia: f64,
    /// [rad] whole gap.
    pub backlash: f64,
    pub friction: Friction,
    /// [1] friction on the link side.
    pub link_share: f64,
    /// [rad] middle of the motion, and how far from it contacts and rests of cables lie.
    pub middle: f64,
    pub reach: f64,
    /// [N·m/rad] of a cable and of a contact.
    pub cable: f64,
    pub contact: f64,
    /// [N·m·s²/rad²] of a quadratic drag.
    pub drag: f64,
    /// [N·m] of a periodic disturbance.
    pub disturbance: f64,
    /// [A] of an offset and of a dead band.
    pub offset: f64,
    pub dead_band: f64,
    /// [N·m/rad] of a soft gear.
    pub soft: f64,
    /// [1] friction by torque through the gear.
    pub load_friction: f64,
}

/// A load on the last link: mass [kg] and where it is [m].
#[derive(Debug, Clone, Copy)]
pub struct Payload {
    pub mass: f64,
    pub x: f64,
    pub z: f64,
}

/// Every effect that can be hidden, by name: all but `link_inertia`, for which the nominal model would have to be wrong and not the machine.
pub const EFFECTS: [&str; 29] = [
    "base_tilt",
    "cable_spring",
    "cogging",
    "coulomb_asymmetry",
    "coupling_slip",
    "current_offset",
    "drive_dead_band",
    "dwell_stiction",
    "encoder_eccentricity",
    "external_contact",
    "joint_compliance",
    "load_dependent_friction",
    "payload",
    "periodic_disturbance",
    "position_dependent_backlash",
    "position_dependent_friction",
    "presliding",
    "quadratic_drag",
    "rotor_inertia",
    "sensor_delay",
    "stribeck",
    "thermal_friction_drift",
    "torque_constant_error",
    "torque_ripple",
    "transmission_error",
    "velocity_lag",
    "viscous_asymmetry",
    // After the others: the index of a name is part of its seeds.
    "counterbalance",
    "regularised_friction",
];

/// An effect of the whole machine; `None` where it is one of a joint.
pub fn of_machine(rng: &mut ChaCha8Rng, effect: &str, strength: f64, payload: &Payload) -> Option<Drawn> {
    match effect {
        "base_tilt" => Some(vec![("tilt", 0.05 * strength), ("azimuth", angle(rng))]),
        "payload" => {
            let Payload { mass, x, z } = *payload;
            let height = (z != 0.0).then_some(("z", z));
            Some([("mass", mass * strength), ("x", x)].into_iter().chain(height).collect())
        }
        "sensor_delay" => {
            let channel = if rng.random_bool(0.5) { "current_delay" } else { "position_delay" };
            Some(vec![(channel, 0.01 * strength)])
        }
        _ => None,
    }
}

/// An effect of one joint.
pub fn of_joint(rng: &mut ChaCha8Rng, effect: &str, strength: f64, joint: &JointSizes) -> Drawn {
    match effect {
        "cogging" | "encoder_eccentricity" | "periodic_disturbance" | "torque_ripple" | "transmission_error" => {
            ripple(rng, effect, strength, joint)
        }
        "coupling_slip" | "dwell_stiction" | "joint_compliance" | "position_dependent_backlash" | "presliding" => {
            at_reversals(rng, effect, strength, joint)
        }
        "cable_spring"
        | "counterbalance"
        | "current_offset"
        | "drive_dead_band"
        | "external_contact"
        | "rotor_inertia"
        | "torque_constant_error" => of_torque(rng, effect, strength, joint),
        // As the channel of a small servo: 20 ms, or as much of a filter.
        "velocity_lag" => {
            let lag = if rng.random_bool(0.5) { "delay" } else { "time_constant" };
            vec![(lag, 0.02 * strength)]
        }
        _ => of_friction(rng, effect, strength, joint),
    }
}

fn angle(rng: &mut ChaCha8Rng) -> f64 {
    rng.random_range(-PI..PI)
}

fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_bool(0.5) { 1.0 } else { -1.0 }
}

fn whole(rng: &mut ChaCha8Rng, range: std::ops::RangeInclusive<u32>) -> f64 {
    f64::from(rng.random_range(range))
}

fn ripple(rng: &mut ChaCha8Rng, effect: &str, strength: f64, joint: &JointSizes) -> Drawn {
    let phase = ("phase", angle(rng));
    match effect {
        "cogging" => {
            let amplitude = 0.15 * joint.friction.coulomb * strength;
            vec![("amplitude", amplitude), ("order", whole(rng, 3..=12)), phase]
        }
        "torque_ripple" => vec![("amplitude", 0.12 * strength), ("order", whole(rng, 3..=12)), phase],
        // 30 mrad at the motor shaft.
        "encoder_eccentricity" => vec![("amplitude", 0.03 * strength / joint.gear_ratio), phase],
        // The link's speed ripples by 2 % whatever the number of teeth: 0.2 to 0.67 mrad.
        "transmission_error" => {
            let teeth = whole(rng, 30..=100);
            vec![("amplitude", 0.02 * strength / teeth), ("teeth", teeth), phase]
        }
        _ => {
            vec![
                ("amplitude", joint.disturbance * strength),
                ("frequency", 15.0 * 8.0_f64.powf(rng.random_range(0.0..1.0))),
                phase,
            ]
        }
    }
}

fn at_reversals(rng: &mut ChaCha8Rng, effect: &str, strength: f64, joint: &JointSizes) -> Drawn {
    let gap = joint.backlash;
    let coulomb = joint.friction.coulomb;
    match effect {
        // In every session at the same time since its start, as a model file says it; all of them last for 40 s or more.
        "coupling_slip" => {
            let jump = gap * strength * rng.random_range(1.0..2.0) * sign(rng);
            vec![("jump", jump), ("time", rng.random_range(8.0..32.0))]
        }
        "dwell_stiction" => vec![("growth", 0.25 * coulomb * strength), ("time_constant", around(rng, 1.0, 2.0))],
        "joint_compliance" => vec![("stiffness", around(rng, joint.soft, 1.6) / strength)],
        "position_dependent_backlash" => {
            vec![("amplitude", 0.5 * gap * strength), ("order", whole(rng, 1..=3)), ("phase", angle(rng))]
        }
        // Friction yields by 3 to 8 mrad before it slips; damped as a spring with the rotor's inertia is at its limit.
        _ => {
            let yielding = around(rng, 0.005, 1.6) * strength;
            let stiffness = (1.0 - joint.link_share) * coulomb / yielding;
            vec![("stiffness", stiffness), ("damping", (stiffness * joint.rotor_inertia).sqrt())]
        }
    }
}

fn of_torque(rng: &mut ChaCha8Rng, effect: &str, strength: f64, joint: &JointSizes) -> Drawn {
    let sign = sign(rng);
    match effect {
        "cable_spring" => {
            vec![
                ("stiffness", joint.cable * strength),
                ("rest_position", joint.middle + joint.reach * rng.random_range(-1.0..1.0)),
            ]
        }
        // At its largest as much as a cable pulls one and a half ranges from its rest.
        "counterbalance" => {
            vec![("amplitude", 1.5 * joint.reach * joint.cable * strength), ("angle", angle(rng))]
        }
        "current_offset" => vec![("offset", joint.offset * strength * sign)],
        "drive_dead_band" => vec![("width", joint.dead_band * strength)],
        // The runs go to ±1.8 times this reach: it is met in part of them, on one side.
        "external_contact" => {
            let place = joint.middle + joint.reach * (sign * rng.random_range(0.8..1.2));
            vec![("angle", place), ("stiffness", joint.contact * strength), ("side", sign)]
        }
        "rotor_inertia" => vec![("error", 0.25 * strength * sign)],
        _ => vec![("error", 0.08 * strength * sign)],
    }
}

fn of_friction(rng: &mut ChaCha8Rng, effect: &str, strength: f64, joint: &JointSizes) -> Drawn {
    let friction = joint.friction;
    match effect {
        "coulomb_asymmetry" => vec![("asymmetry", 0.15 * strength * sign(rng))],
        "load_dependent_friction" => vec![("coefficient", joint.load_friction * strength)],
        "position_dependent_friction" => {
            vec![("amplitude", 0.25 * strength), ("order", whole(rng, 1..=3)), ("phase", angle(rng))]
        }
        "quadratic_drag" => vec![("coefficient", joint.drag * strength)],
        // As fast as the slow steps of the runs, where it shows most.
        "regularised_friction" => vec![("velocity", around(rng, 0.015, 2.0) * strength)],
        "stribeck" => vec![
            ("breakaway", friction.coulomb * (1.0 + 0.3 * strength)),
            ("stribeck_velocity", friction.stribeck_velocity),
        ],
        "thermal_friction_drift" => vec![("excess", 0.4 * strength), ("time_constant", around(rng, 40.0, 1.25))],
        "viscous_asymmetry" => {
            let difference = 0.25 * strength * sign(rng);
            vec![
                ("positive", friction.viscous * (1.0 + difference)),
                ("negative", friction.viscous * (1.0 - difference)),
            ]
        }
        other => unreachable!("{other} has no strength"),
    }
}
