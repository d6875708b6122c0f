//! Whether logged commands are what drove the machine.
//!
//! A logged command is the input of a replay where the current follows it. Some controllers log a target instead, computed from a model of
//! the arm without its load or its friction: the current that flowed differs from it by `i − i_cmd`, also in slow motion.

use std::borrow::Cow;

use super::low_pass::low_pass;
use crate::dataset::Session;
use crate::drive::Sensing;
use crate::robot::{Accuracy, JointModel, Model};
use crate::timeseries::{Channel, Clock, root_mean_square as rms};

/// The session without its commands if the current of a joint does not follow them, below the `bandwidth` [Hz] up to which a replay follows
/// the recording. A note says so.
pub(super) fn that_drove<'s>(
    model: &Model,
    session: &'s Session,
    bandwidth: f64,
    notes: &mut Vec<String>,
) -> Cow<'s, Session> {
    let of_joint = |joint| Some((joint, astray(joint, session, bandwidth)?));
    let Some((joint, share)) = model.joints.iter().find_map(of_joint) else { return Cow::Borrowed(session) };
    notes.push(format!(
        "in slow motion the current of {} differs from its command by {:.0} %: currents are the input, commands are not used",
        joint.name,
        100.0 * share
    ));
    let mut session = session.clone();
    session.series.joints.iter_mut().for_each(|joint| drop(joint.channels.remove(&Channel::CommandCurrent)));
    Cow::Owned(session)
}

/// RMS of `i − i_cmd` as a share of that of `i`, both below the bandwidth, if it is larger than what the torque constant leaves open.
/// The lag of a drive is short beside this motion, and noise is fast: neither counts. A current of noise alone is dead, and refutes no command.
fn astray(joint: &JointModel, session: &Session, bandwidth: f64) -> Option<f64> {
    /// Standard deviations of a vendor's torque constant: torques within them cannot be told from the model's own.
    const DEVIATIONS: f64 = 3.0;
    if joint.current_sensor.is_some_and(|sensor| sensor.sensing == Sensing::Absolute) {
        return None;
    }
    let series = session.series.joint(&joint.name)?;
    let (current, command) = (series.get(Channel::Current)?, series.get(Channel::CommandCurrent)?);
    let limit = joint.amplifier.current_limit;
    let clock = Clock::new(&session.series.time);
    let difference: Vec<f64> = current.iter().zip(command).map(|(i, u)| i - u.clamp(-limit, limit)).collect();
    let parts = |signal: &[f64]| {
        let slow = low_pass(signal, &clock, bandwidth);
        let fast: Vec<f64> = signal.iter().zip(&slow).map(|(all, slow)| all - slow).collect();
        [rms(&slow), rms(&fast)]
    };
    let ([difference, its_noise], [flowed, noise]) = (parts(&difference), parts(current));
    let share = difference / flowed;
    let seen = flowed > noise && difference > its_noise;
    (seen && share > DEVIATIONS * Accuracy::default().torque_constants).then_some(share)
}
