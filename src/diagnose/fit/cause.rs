//! The cause behind a term: an effect, or the change of an effect between two recordings.

use std::ops::{Deref, Range};

use crate::effects::{Diagnosable, Kind, Motion, Scope};
use crate::robot::TorqueAt;

/// An effect in all sessions; or its change, which is the same effect in some sessions only: its columns are zero in all others.
///
/// A change does not claim phenomena: a phenomenon that both recordings show is no change.
#[derive(Clone, Copy)]
pub struct Cause {
    effect: &'static dyn Diagnosable,
    /// First session of a change, and the one after its last.
    within: Option<[usize; 2]>,
}

impl Cause {
    /// The change of an effect, in these sessions only.
    pub fn change(effect: impl Into<Self>, sessions: Range<usize>) -> Self {
        Self { within: Some([sessions.start, sessions.end]), ..effect.into() }
    }

    /// The effect itself, in all sessions.
    pub fn everywhere(self) -> Self {
        Self { within: None, ..self }
    }

    /// The same of another effect.
    pub fn by(self, effect: &'static dyn Diagnosable) -> Self {
        Self { effect, ..self }
    }

    /// Its name in a report: the name of the effect, with a mark if it is a change.
    pub fn label(&self) -> String {
        match self.within {
            None => self.effect.name().to_owned(),
            Some(_) => change_of(self.effect.name()),
        }
    }

    /// Whether an effect of this strength deserves its name; a change may have either sign.
    pub fn is_itself(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> bool {
        self.within.is_some() || self.effect.is_itself(motion, joint, shape, coefficients)
    }

    /// Torque on some joints [N·m or N] per unit of each coefficient, as [`Diagnosable::columns`].
    pub fn columns_of(&self, motion: &Motion, joints: &[usize], shape: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let mut columns = match self.effect.columns_of_all(motion, shape).filter(|_| joints.len() > 1) {
            Some(mut all) => joints.iter().map(|joint| std::mem::take(&mut all[*joint])).collect(),
            None => (0..joints.len()).map(|place| self.columns_at(motion, joints, place, shape)).collect::<Vec<_>>(),
        };
        columns.iter_mut().flatten().for_each(|column| self.mask(motion, column));
        if self.loads_machine() {
            for (columns, joint) in columns.iter_mut().zip(joints) {
                let shown = 1.0 - motion.joints[*joint].scale;
                columns.iter_mut().flatten().for_each(|value| *value *= shown);
            }
        }
        columns
    }

    /// Torque on one joint.
    pub fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        self.columns_of(motion, &[joint], shape).swap_remove(0)
    }

    /// Whether the nominal model lacks it on this joint and the recording could show it where its torque was measured.
    pub fn applies(&self, motion: &Motion, joint: usize) -> bool {
        let m = &motion.joints[joint];
        let seen = motion.model.joints[joint].torque_at == TorqueAt::Motor || self.effect.shows_behind_gear();
        m.left_out.is_none() && seen && self.effect.applies(motion, joint)
    }

    /// Axes whose torque shows it where it acts on one joint, the axis of that joint first.
    pub fn axes(&self, motion: &Motion, joint: usize) -> Vec<usize> {
        if self.is_on_link() { motion.model.robot.axes_of(joint) } else { vec![joint] }
    }

    /// Whether it loads all joints, in proportion to what is one and the same for them: torque constants scale what each of them shows of it.
    pub fn loads_machine(&self) -> bool {
        let about = self.effect.about();
        about.scope == Scope::Machine && about.kind == Kind::Physics
    }

    /// Whether it loads the link of one joint, and so every axis that moves this joint.
    fn is_on_link(&self) -> bool {
        self.effect.about().scope == Scope::Joint && self.effect.loads_link()
    }

    /// Torque on one of a term's `joints`, without the limits of a change. A torque `τ_q` on the link of the first joint is `C⁻ᵀ τ_q` on the axes.
    pub fn columns_at(&self, motion: &Motion, joints: &[usize], place: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        let (first, axis) = (joints[0], joints[place]);
        let coupling = motion.model.robot.coupling.as_ref().filter(|_| self.is_on_link());
        let Some(coupling) = coupling else { return self.effect.columns(motion, axis, shape) };
        let share = coupling.joint_per_axis(first, axis);
        let mut columns = self.effect.columns(motion, first, shape);
        columns.iter_mut().flatten().for_each(|value| *value *= share);
        columns
    }

    /// A change is zero in all other sessions.
    fn mask(&self, motion: &Motion, column: &mut [f64]) {
        let Some([first, end]) = self.within else { return };
        let cells = column.iter_mut().zip(&motion.session);
        cells.filter(|(_, session)| !(first..end).contains(*session)).for_each(|(value, _)| *value = 0.0);
    }
}

impl std::fmt::Debug for Cause {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(&self.label())
    }
}

/// Prefix of the name of a change.
const CHANGE: &str = "change of ";

/// The name of the change of an effect.
pub fn change_of(name: &str) -> String {
    format!("{CHANGE}{name}")
}

/// The name without the prefix of a change, if it has one.
pub fn changed(name: &str) -> Option<&str> {
    name.strip_prefix(CHANGE)
}

/// Equal name, and equal sessions of a change.
impl PartialEq for Cause {
    fn eq(&self, other: &Self) -> bool {
        self.effect.name() == other.effect.name() && self.within == other.within
    }
}

impl Deref for Cause {
    type Target = dyn Diagnosable;

    fn deref(&self) -> &Self::Target {
        self.effect
    }
}

impl From<&'static dyn Diagnosable> for Cause {
    fn from(effect: &'static dyn Diagnosable) -> Self {
        Self { effect, within: None }
    }
}

impl<T: Diagnosable> From<&'static T> for Cause {
    fn from(effect: &'static T) -> Self {
        Self { effect, within: None }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::effects::drawn::{LENGTH, MODEL, ROBOT, drawn};
    use crate::effects::find;
    use crate::robot::Model;

    /// A current shows `1 − s u` of what a tilted base adds. What acts on one joint alone is measured in the torque that the current shows.
    #[test]
    fn analytic_a_constant_scales_what_loads_the_machine() {
        let beside = ROBOT.replace("<inertial>", "<inertial><origin xyz=\"0.1 0 0\"/>");
        let level = beside.replace("xyz=\"0 0 1\"", "xyz=\"0 -1 0\"");
        let model = Model::from_texts(MODEL, &level, Path::new("model.toml")).expect("a model");
        let mut motion = drawn(&model, 1, None, LENGTH);
        for (name, share) in [("base_tilt", 0.6), ("payload", 0.6), ("cable_spring", 1.0)] {
            let cause = Cause::from(find(name).and_then(|effect| effect.diagnosable()).expect("an effect"));
            let shape = cause.shapes(&motion, 0).into_iter().next().unwrap_or_default();
            motion.joints[0].scale = 0.0;
            let exact = cause.columns(&motion, 0, &shape);
            motion.joints[0].scale = 0.4;
            let scaled = cause.columns(&motion, 0, &shape);
            for (exact, scaled) in exact.iter().flatten().zip(scaled.iter().flatten()) {
                // Rounding.
                assert!((scaled - share * exact).abs() <= 1e-12 * exact.abs(), "{name}: {scaled} of {exact}");
            }
            assert!(exact.iter().flatten().any(|torque| *torque != 0.0), "{name}");
        }
    }
}
