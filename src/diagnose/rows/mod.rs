//! Recordings → rows of smooth motion and torque, and which of them are fitted.
//!
//! Takes the recordings and the nominal model. Gives motion and torque averaged by a kernel, in rows at even distances, with the
//! zone of each row and the division into training and held-out data.
//! - `observe`: makes the rows; `signals`: of what; `widths`: how wide their kernels are
//! - `kernel`: the smoothing kernel; `local`: its weights at uneven times; `sampling`: even times, uneven ones, pauses
//! - `direction`: which way a joint moves within a kernel, and whether it sticks and slips
//! - `resonance`: motion that is too fast for links to follow their rotors
//! - `division`: training data and held-out data
//! - `zones`: the rigid zone, in which the links follow the rotors
//! - `loads`: rows under a load that holds a link whatever floats
//! - `reversals`: times since reversals, and durations of rests
//! - `standstill`: currents before the first motion
//! - `gentlest`: the sessions with the gentlest reversals
//! - `measured`: where torque was measured, and what of the model shows there
//! - `inertia`: a typical inertia of each joint

pub mod direction;
pub mod division;
pub mod gentlest;
pub mod inertia;
pub mod kernel;
pub mod loads;
pub mod local;
pub mod measured;
pub mod observe;
pub mod resonance;
pub mod reversals;
pub mod sampling;
pub mod signals;
pub mod standstill;
pub mod widths;
pub mod zones;
