//! A cause in a fit: an effect, or its change, with its torque on the joints where it acts.

use super::cause::Cause;
use crate::effects::{Motion, Scope};

/// An effect on certain joints, which share its coefficients.
#[derive(Clone)]
pub struct Term {
    /// The effect.
    pub effect: Cause,
    /// One joint, or all of them for an effect of the machine. After a joint whose link is loaded come the other axes that move it.
    pub joints: Vec<usize>,
    /// Its shape.
    pub shape: Vec<f64>,
    /// `columns[position in joints][coefficient][row]`.
    pub columns: Vec<Vec<Vec<f64>>>,
}

impl Term {
    /// Evaluates an effect along the motion.
    pub fn new(motion: &Motion, effect: impl Into<Cause>, joints: &[usize], shape: Vec<f64>) -> Self {
        let effect = effect.into();
        let columns = effect.columns_of(motion, joints, &shape);
        Self { effect, joints: joints.to_vec(), shape, columns }
    }

    /// Number of linear coefficients.
    pub fn coefficients(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Joints that it is an effect of: all, or one.
    pub fn own_joints(&self) -> &[usize] {
        if self.is_machine() { &self.joints } else { &self.joints[..1] }
    }

    /// Whether one set of parameters applies to the whole machine.
    pub fn is_machine(&self) -> bool {
        self.effect.about().scope == Scope::Machine
    }
}
