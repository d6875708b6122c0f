//! Recordings whose channels are late, in step with themselves.
//!
//! ```text
//!   q_rec(t) = q(t − T_q),  i_rec(t) = i(t − T_i)      so that  q_rec(t)  is driven by  i(t − T_q) = i_rec(t + T_i − T_q)
//! ```
//! A machine that is late by `T_q` itself has moved as recorded. It is simulated without delays, driven by currents and commands in step with its positions:
//! a tracking controller or an observer that corrected the present by a reading of the past would oscillate, and a current cannot be found from
//! a reading of an earlier one.
//! The machine's own controller has seen the late positions. Beside it, those stay late in the simulation, and only the currents are shifted.
//! Left out: effects that depend on the time act `T_q` early.

use std::borrow::Cow;

use crate::dataset::Session;
use crate::effects::{take_current_delay, take_position_delay};
use crate::robot::Model;
use crate::timeseries::{Channel, delayed};

/// Whose controller acts on the simulated machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Control {
    /// The machine's own, where the session gives it.
    Own,
    /// Another one, or none.
    Other,
}

/// Takes the delays of motor-side channels out of a model, and shifts the recorded currents and commands accordingly.
pub(super) fn in_step<'s>(model: &mut Model, session: &'s Session, control: Control) -> Cow<'s, Session> {
    let own = control == Control::Own && session.controllers.iter().any(Option::is_some);
    let current = take_current_delay(model);
    let position = if own { 0.0 } else { take_position_delay(model) };
    if current == 0.0 && position == 0.0 {
        return Cow::Borrowed(session);
    }
    let mut session = session.clone();
    let time = &session.series.time;
    for joint in &mut session.series.joints {
        for (channel, samples) in &mut joint.channels {
            let by = match channel {
                Channel::Current | Channel::Torque => position - current,
                Channel::CommandCurrent => position,
                _ => continue,
            };
            *samples = delayed(time, samples, by).into();
        }
    }
    Cow::Owned(session)
}
