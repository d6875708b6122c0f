//! The words that names of columns are made of.
//!
//! One table for all formats. A word stands here in lower case; names are cut into words at punctuation, at changes from
//! letters to digits and at capitals (`names`). Sources: `sensor_msgs/JointState` and PlotJuggler (`position`, `effort`),
//! RTDE of Universal Robots (`actual_q`, `target_qd`, `actual_current`), libfranka (`q_d`, `dq`, `tau_J`), Drake, Pinocchio
//! and MuJoCo (`q`, `v`, `qpos`, `qvel`), LeRobot (`observation.state`, `action`), Dynamixel (`present_position`).

/// What a channel measures, whatever its role.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Position,
    Velocity,
    Current,
    Torque,
    /// As `Torque`, at a joint that slides.
    Force,
    /// A torque or a force; many drivers put a current there.
    Effort,
    Temperature,
    /// Known but not used here: acceleration, voltage, poses.
    Other,
}

/// Which one of the signals of a quantity it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// What was measured; also if the name states no role.
    Actual,
    /// What was commanded.
    Reference,
    /// Behind the gear.
    Link,
    /// In front of the gear, maybe at the motor's shaft.
    Motor,
}

/// What a word means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Word {
    Quantity(Quantity),
    Role(Role),
    /// A word without a meaning here: a topic, a list.
    Filler,
    /// A quantity that has to be confirmed, and the reason.
    Guess(Quantity, Role, &'static str),
}

use Quantity::{Current, Effort, Force, Other, Position, Temperature, Torque, Velocity};

/// The table: words with the same meaning.
const WORDS: &[(&[&str], Word)] = &[
    (&["position", "positions", "pos", "posn", "q", "qpos", "angle", "angles", "theta"], Word::Quantity(Position)),
    (
        &["velocity", "velocities", "vel", "velo", "speed", "speeds", "qd", "dq", "qdot", "qvel", "omega"],
        Word::Quantity(Velocity),
    ),
    (&["current", "currents", "curr", "cur", "amperage", "iq"], Word::Quantity(Current)),
    (&["torque", "torques", "tau", "trq", "tq", "moment", "moments"], Word::Quantity(Torque)),
    (&["force", "forces"], Word::Quantity(Force)),
    (&["effort", "efforts", "eff"], Word::Quantity(Effort)),
    (&["temperature", "temperatures", "temp", "temps"], Word::Quantity(Temperature)),
    (&["acceleration", "accelerations", "acc", "accel", "qdd", "ddq", "qddot", "qacc", "jerk"], Word::Quantity(Other)),
    (&["voltage", "voltages", "volt", "pwm", "power", "load", "duty", "stiffness", "damping"], Word::Quantity(Other)),
    (&["tcp", "pose", "cartesian", "wrench", "imu", "orientation", "quaternion", "twist"], Word::Quantity(Other)),
    (&["error", "err", "std", "stddev", "var", "variance", "covariance", "limit", "min", "max"], Word::Quantity(Other)),
    (&["mode", "status", "flag", "flags", "seq", "sequence", "id", "index", "count", "counter"], Word::Quantity(Other)),
    (&["ext", "external", "hat", "gravity", "coriolis", "friction"], Word::Quantity(Other)),
    (&["actual", "measured", "meas", "act", "present", "feedback", "fbk", "fb"], Word::Role(Role::Actual)),
    (&["reference", "ref", "target", "desired", "des", "setpoint", "goal"], Word::Role(Role::Reference)),
    (&["command", "commanded", "commands", "cmd", "request", "requested", "set"], Word::Role(Role::Reference)),
    (&["link", "output", "secondary", "absolute"], Word::Role(Role::Link)),
    (&["motor", "rotor"], Word::Role(Role::Motor)),
    (&["joint", "joints", "axis", "axes", "state", "states", "data", "msg", "log"], Word::Filler),
    (&["controller", "broadcaster", "observation", "field", "value", "values", "dof", "vector"], Word::Filler),
    (
        &["action"],
        Word::Guess(Position, Role::Reference, "an action of LeRobot: the position that was asked for, in what unit?"),
    ),
];

/// Meaning of a word in lower case.
pub(super) fn meaning(word: &str) -> Option<Word> {
    WORDS.iter().find(|(words, _)| words.contains(&word)).map(|&(_, meaning)| meaning)
}

/// Words that name a column of time.
pub(super) const TIME: [&str; 14] = [
    "time",
    "t",
    "timestamp",
    "timestamps",
    "stamp",
    "datetime",
    "date",
    "clock",
    "elapsed",
    "seconds",
    "sec",
    "secs",
    "millis",
    "nanoseconds",
];

/// Names of seconds and nanoseconds of a time in two columns.
pub(super) const SECONDS: [&str; 4] = ["sec", "secs", "seconds", "s"];
pub(super) const NANOSECONDS: [&str; 7] = ["nanosec", "nanosecs", "nsec", "nsecs", "nanoseconds", "nanos", "ns"];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_every_word_stands_once_and_in_lower_case() {
        let mut seen = std::collections::HashSet::new();
        for word in WORDS.iter().flat_map(|(words, _)| *words) {
            assert!(seen.insert(*word), "{word} twice");
            assert!(word.chars().all(|c| c.is_ascii_lowercase()), "{word}");
        }
    }
}
