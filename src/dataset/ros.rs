//! Joint states of ROS, whatever file holds them: the message and the topics.

mod joint_state;
mod topics;

#[cfg(feature = "mcap")]
pub(super) use self::joint_state::Reader;
pub(super) use self::joint_state::Wire;
pub(super) use self::topics::{Topics, is_joint_state};
