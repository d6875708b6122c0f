//! Mistakes planted in sound recordings and models.

use lostmotion::robot::Model;
use lostmotion::timeseries::{Channel, Samples, TimeSeries};
use lostmotion::units::{DEG, JointKind, RPM};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// A mistake: its name here, and the names under which it may be told. Those that data cannot separate stand beside each other.
pub struct Planted {
    pub name: &'static str,
    pub told: &'static [&'static str],
    /// Planted in one joint at a time; else in all at once.
    pub of_joint: bool,
}

const fn planted(name: &'static str, told: &'static [&'static str], of_joint: bool) -> Planted {
    Planted { name, told, of_joint }
}

/// Everything that is planted.
pub const MISTAKES: [Planted; 44] = [
    planted("current turned", &["sign_of_current", "sign_of_torque", "sign_of_joint"], true),
    planted("position and velocity turned", &["sign_of_joint", "sign_of_current", "sign_of_torque"], true),
    planted("position turned", &["sign_of_joint"], true),
    planted("velocity turned", &["sign_of_velocity"], true),
    planted("axis turned", &["sign_of_joint"], true),
    planted("all currents turned", &["sign_of_current", "sign_of_torque", "sign_of_joint"], false),
    planted("position and velocity in degrees", &["degrees_for_radians", "millimetres_for_metres"], true),
    planted("all in degrees", &["degrees_for_radians", "millimetres_for_metres"], false),
    planted("position in degrees", &["degrees_for_radians", "millimetres_for_metres"], true),
    planted("velocity in degrees", &["degrees_for_radians", "millimetres_for_metres"], true),
    planted("velocity in rpm", &["rpm_for_radians_per_second"], true),
    planted("currents exchanged", &["joints_swapped"], true),
    planted("positions exchanged", &["joints_swapped"], true),
    planted("joints exchanged", &["joints_swapped"], true),
    planted("torque as current", &["torque_recorded_as_current", "torque_scale"], true),
    planted("motor torque as current", &["torque_recorded_as_current", "torque_scale"], true),
    planted("all motor torques as currents", &["torque_recorded_as_current", "torque_scale"], false),
    planted("all torques as currents", &["torque_recorded_as_current", "torque_scale"], false),
    planted("torque constant left at one", &["torque_recorded_as_current", "torque_scale"], true),
    planted("current as torque", &["current_recorded_as_torque", "torque_scale"], true),
    planted("gear ratio of another stage", &["gear_ratio", "torque_scale", "torque_recorded_as_current"], true),
    planted("gear ratio inverse", &["gear_ratio", "torque_scale", "torque_recorded_as_current"], true),
    planted("motor angle", &["motor_angle_for_joint_angle", "gear_ratio", "degrees_for_radians"], true),
    planted("all motor angles", &["motor_angle_for_joint_angle", "gear_ratio", "degrees_for_radians"], false),
    planted("time in ms", &["time_unit"], false),
    planted("time in µs", &["time_unit"], false),
    planted("time in ns", &["time_unit"], false),
    planted("time doubled", &["time_base", "torque_scale"], false),
    planted("time halved", &["time_base", "torque_scale"], false),
    planted("time stretched", &["time_base", "torque_scale"], false),
    planted("time shortened", &["time_base", "torque_scale"], false),
    planted("gravity upside down", &["gravity_upside_down"], false),
    planted("current unsigned", &["unsigned_current"], true),
    planted("all currents unsigned", &["unsigned_current"], false),
    planted("current in mA", &["milliampere_for_ampere", "torque_scale"], true),
    planted("all currents in mA", &["milliampere_for_ampere", "torque_scale"], false),
    planted("currents late", &["late_channel"], false),
    planted("position and velocity late", &["late_channel"], true),
    planted("velocity late", &["late_channel"], true),
    planted("current late", &["late_channel"], true),
    planted("current dead", &["dead_channel"], true),
    planted("current of noise alone", &["dead_channel"], true),
    planted("current of white noise", &["dead_channel"], true),
    planted("position dead", &["dead_channel"], true),
];

/// Model and recordings with a mistake in them; `None` where it is none for this machine.
pub fn plant(name: &str, model: &Model, sessions: &[TimeSeries], joint: usize) -> Option<(Model, Vec<TimeSeries>)> {
    let (mut model, mut sessions) = (model.clone(), sessions.to_vec());
    let dof = model.joints.len();
    let next = (joint + 1) % dof;
    let n = model.joints[joint].gear_ratio;
    let gain = model.joints[joint].torque_per_ampere();
    let slides = model.joints[joint].kind == JointKind::Prismatic;
    let degrees = if slides { 1e3 } else { 1.0 / DEG };
    let torque = [Channel::Current, Channel::Torque, Channel::CommandCurrent];
    let motion = [Channel::Position, Channel::Velocity];
    let reference = [Channel::ReferencePosition, Channel::ReferenceVelocity];
    let names: Vec<String> = model.joints.iter().map(|joint| joint.name.clone()).collect();
    let has = |sessions: &[TimeSeries], channel| {
        sessions.iter().all(|one| one.joint(&names[joint]).is_some_and(|one| one.get(channel).is_some()))
    };
    let velocity = has(&sessions, Channel::Velocity);
    let current = has(&sessions, Channel::Current);
    let scaled = |sessions: &mut [TimeSeries], joint: usize, channels: &[Channel], factor: f64| {
        each(sessions, &names[joint], channels, &|values| values.iter_mut().for_each(|value| *value *= factor));
    };
    let both: Vec<Channel> = motion.into_iter().chain(reference).collect();
    match name {
        "current turned" => scaled(&mut sessions, joint, &torque, -1.0),
        "position and velocity turned" => scaled(&mut sessions, joint, &both, -1.0),
        "position turned" if velocity => scaled(&mut sessions, joint, &[Channel::Position], -1.0),
        "velocity turned" if velocity => scaled(&mut sessions, joint, &[Channel::Velocity], -1.0),
        "axis turned" => {
            scaled(&mut sessions, joint, &both, -1.0);
            scaled(&mut sessions, joint, &torque, -1.0);
        }
        "all currents turned" => (0..dof).for_each(|joint| scaled(&mut sessions, joint, &torque, -1.0)),
        "position and velocity in degrees" => scaled(&mut sessions, joint, &both, degrees),
        "all in degrees" if !slides => (0..dof).for_each(|joint| scaled(&mut sessions, joint, &both, degrees)),
        "position in degrees" if velocity => scaled(&mut sessions, joint, &[Channel::Position], degrees),
        "velocity in degrees" if velocity => scaled(&mut sessions, joint, &[Channel::Velocity], degrees),
        "velocity in rpm" if velocity && !slides => scaled(&mut sessions, joint, &[Channel::Velocity], 1.0 / RPM),
        "currents exchanged" if dof > 1 => exchange(&mut sessions, [&names[joint], &names[next]], &torque),
        "positions exchanged" if dof > 1 => exchange(&mut sessions, [&names[joint], &names[next]], &both),
        "joints exchanged" if dof > 1 => {
            exchange(&mut sessions, [&names[joint], &names[next]], &both);
            exchange(&mut sessions, [&names[joint], &names[next]], &torque);
        }
        // A gain of the order of one is no mistake.
        "torque as current" if current && gain.ln().abs() > 1.2 => scaled(&mut sessions, joint, &torque, gain),
        "all torques as currents"
            if has_currents(&model, &sessions)
                && model.joints.iter().all(|one| one.torque_per_ampere().ln().abs() > 1.2) =>
        {
            (0..dof).for_each(|one| scaled(&mut sessions, one, &torque, model.joints[one].torque_per_ampere()));
        }
        "motor torque as current" if current && constant(&model, joint).ln().abs() > 1.2 => {
            scaled(&mut sessions, joint, &torque, constant(&model, joint));
        }
        "all motor torques as currents"
            if has_currents(&model, &sessions) && (0..dof).all(|one| constant(&model, one).ln().abs() > 1.2) =>
        {
            (0..dof).for_each(|one| scaled(&mut sessions, one, &torque, constant(&model, one)));
        }
        "torque constant left at one" if current && constant(&model, joint).ln().abs() > 1.2 => {
            model.joints[joint].motor.as_mut()?.torque_constant = 1.0;
        }
        "current as torque" if current && gain.ln().abs() > 1.2 => {
            for session in &mut sessions {
                let one = session.joints.iter_mut().find(|one| one.name == names[joint])?;
                let values = one.channels.remove(&Channel::Current)?;
                one.channels.insert(Channel::Torque, values);
            }
        }
        "gear ratio of another stage" => model.joints[joint].gear_ratio *= if n > 20.0 { 0.1 } else { 3.0 },
        "gear ratio inverse" if n > 1.5 => model.joints[joint].gear_ratio = 1.0 / n,
        "motor angle" if n > 1.5 => scaled(&mut sessions, joint, &both, n),
        "all motor angles" if dof > 1 && model.joints.iter().all(|joint| joint.gear_ratio > 1.5) => {
            (0..dof).for_each(|joint| scaled(&mut sessions, joint, &both, model.joints[joint].gear_ratio));
        }
        "time in ms" => stretch(&mut sessions, 1e3),
        "time in µs" => stretch(&mut sessions, 1e6),
        "time in ns" => stretch(&mut sessions, 1e9),
        "time doubled" => stretch(&mut sessions, 2.0),
        "time halved" => stretch(&mut sessions, 0.5),
        // A single velocity may have the wrong scale itself.
        "time stretched" if velocity && dof > 1 => stretch(&mut sessions, 1.3),
        "time shortened" if velocity && dof > 1 => stretch(&mut sessions, 0.8),
        "gravity upside down" if weighs(&model) => model.robot.gravity = -model.robot.gravity,
        "current unsigned" => unsigned(&mut sessions, &names[joint], &torque),
        "all currents unsigned" => names.iter().for_each(|name| unsigned(&mut sessions, name, &torque)),
        "current in mA" if current => scaled(&mut sessions, joint, &torque, 1e3),
        "all currents in mA" if current => (0..dof).for_each(|joint| scaled(&mut sessions, joint, &torque, 1e3)),
        "currents late" => names.iter().for_each(|name| late(&mut sessions, name, &torque, 0.2)),
        "current late" => late(&mut sessions, &names[joint], &torque, 0.2),
        "velocity late" if velocity => late(&mut sessions, &names[joint], &[Channel::Velocity], 0.2),
        "position and velocity late" => late(&mut sessions, &names[joint], &both, 0.2),
        "current dead" => each(&mut sessions, &names[joint], &torque, &|values| values.fill(0.0)),
        "current of noise alone" => each(&mut sessions, &names[joint], &torque, &|values| {
            // One step of 10 mA to either side, in an order that repeats after 9973 samples.
            values.iter_mut().enumerate().for_each(|(k, value)| *value = 0.01 * ((k * k % 9973 % 3) as f64 - 1.0));
        }),
        "current of white noise" => each(&mut sessions, &names[joint], &torque, &|values| {
            let mut rng = ChaCha8Rng::seed_from_u64(9);
            values.iter_mut().for_each(|value| *value = 0.01 * rng.sample::<f64, _>(StandardNormal));
        }),
        "position dead" if velocity => {
            each(&mut sessions, &names[joint], &[Channel::Position], &|values| {
                let first = values[0];
                values.fill(first);
            });
        }
        _ => return None,
    }
    Some((model, sessions))
}

/// Torque constant of a joint's motor [N·m/A]; 1 without a motor.
fn constant(model: &Model, joint: usize) -> f64 {
    model.joints[joint].motor.map_or(1.0, |motor| motor.torque_constant)
}

/// Whether every joint has a current.
fn has_currents(model: &Model, sessions: &[TimeSeries]) -> bool {
    let has =
        |session: &TimeSeries, name: &str| session.joint(name).is_some_and(|one| one.get(Channel::Current).is_some());
    model.joints.iter().all(|joint| sessions.iter().all(|session| has(session, &joint.name)))
}

fn each(sessions: &mut [TimeSeries], joint: &str, channels: &[Channel], change: &dyn Fn(&mut Samples)) {
    for session in sessions {
        for one in session.joints.iter_mut().filter(|one| one.name == joint) {
            one.channels
                .iter_mut()
                .filter(|(channel, _)| channels.contains(channel))
                .for_each(|(_, values)| change(values));
        }
    }
}

fn exchange(sessions: &mut [TimeSeries], [one, other]: [&str; 2], channels: &[Channel]) {
    for session in sessions {
        let at = |name: &str| session.joints.iter().position(|joint| joint.name == name).expect("the joint");
        let (i, j) = (at(one), at(other));
        for channel in channels {
            let (first, second) =
                (session.joints[i].channels.remove(channel), session.joints[j].channels.remove(channel));
            second.into_iter().for_each(|values| drop(session.joints[i].channels.insert(*channel, values)));
            first.into_iter().for_each(|values| drop(session.joints[j].channels.insert(*channel, values)));
        }
    }
}

fn stretch(sessions: &mut [TimeSeries], factor: f64) {
    sessions.iter_mut().for_each(|session| session.time.iter_mut().for_each(|time| *time *= factor));
}

fn unsigned(sessions: &mut [TimeSeries], joint: &str, channels: &[Channel]) {
    each(sessions, joint, channels, &|values| values.iter_mut().for_each(|value| *value = value.abs()));
}

/// Reads a channel as it was some time ago.
fn late(sessions: &mut [TimeSeries], joint: &str, channels: &[Channel], by: f64) {
    for session in sessions {
        let shift = (by / session.sample_interval()).round() as usize;
        each(std::slice::from_mut(session), joint, channels, &|values| {
            let first = values[0];
            let kept = values.len().saturating_sub(shift);
            *values = std::iter::repeat_n(first, values.len() - kept).chain(values[..kept].iter().copied()).collect();
        });
    }
}

/// Gives every velocity a first-order low-pass [s].
pub fn low_pass_velocities(session: &mut TimeSeries, time_constant: f64) {
    let share = 1.0 - (-session.sample_interval() / time_constant).exp();
    let names: Vec<String> = session.joints.iter().map(|joint| joint.name.clone()).collect();
    for name in names {
        each(std::slice::from_mut(session), &name, &[Channel::Velocity], &|values| {
            for k in 1..values.len() {
                values[k] = values[k - 1] + share * (values[k] - values[k - 1]);
            }
        });
    }
}

/// A session that has the values of another one after a part of it, 0 to 1.
pub fn with_end_of(session: &TimeSeries, other: &TimeSeries, part: f64) -> TimeSeries {
    let mut spliced = session.clone();
    let from = (part * session.time.len() as f64).ceil() as usize;
    for (joint, end) in spliced.joints.iter_mut().zip(&other.joints) {
        for (channel, values) in &mut joint.channels {
            values[from..].copy_from_slice(&end.channels[channel][from..]);
        }
    }
    spliced
}

/// Whether gravity acts on a joint.
fn weighs(model: &Model) -> bool {
    let dof = model.joints.len();
    let mut dynamics = lostmotion::dynamics::Dynamics::new(&model.robot);
    let mut tau = vec![0.0; dof];
    [0.0, 0.5].into_iter().any(|q| {
        dynamics.gravity(&vec![q; dof], &mut tau);
        tau.iter().any(|tau| tau.abs() > 1e-6)
    })
}
