//! A cause in a fit: an effect, or its change, with its torque on the joints where it acts.

use super::cause::Cause;
use super::view::combined;
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
    /// Numbers of the shape that are free.
    pub free_shapes: usize,
    /// `columns[position in joints][coefficient][row]`.
    pub columns: Vec<Vec<Vec<f64>>>,
    /// Coefficients near which the products with torque constants are linear, of an effect that loads the machine; none where those are zeros.
    pub near: Vec<f64>,
}

impl Term {
    /// Evaluates an effect along the motion.
    pub fn new(motion: &Motion, effect: impl Into<Cause>, joints: &[usize], shape: Vec<f64>) -> Self {
        let effect = effect.into();
        let columns = effect.columns_of(motion, joints, &shape);
        let free_shapes = if effect.is_given(motion, joints[0], &shape) { 0 } else { shape.len() };
        Self { effect, joints: joints.to_vec(), shape, free_shapes, columns, near: Vec::new() }
    }

    /// The same along a motion in which something else was fitted, linear near coefficients of its own.
    pub fn along(&self, motion: &Motion, near: Vec<f64>) -> Self {
        Self { near, ..Self::new(motion, self.effect, &self.joints, self.shape.clone()) }
    }

    /// `E₀` of a joint [N·m or N], as its links feel it; `None` for what does not load the machine, or not near these coefficients.
    pub fn load(&self, motion: &Motion, joint: usize) -> Option<Vec<f64>> {
        let place = self.joints.iter().position(|own| *own == joint)?;
        if self.near.is_empty() || !self.effect.loads_machine() {
            return None;
        }
        let shown = 1.0 - motion.joints[joint].scale;
        Some(combined(&self.columns[place], &self.near).into_iter().map(|torque| torque / shown).collect())
    }

    /// Number of linear coefficients.
    pub fn coefficients(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Number of coefficients and free numbers of the shape.
    pub fn complexity(&self) -> usize {
        self.coefficients() + self.free_shapes
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
