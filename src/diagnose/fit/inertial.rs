//! Errors of the nominal inertias, scales and posture, within the accuracy that the model states for them.
//!
//! `τ = Y(q, q̇, q̈) (π̄ + D u) + J_r (1 + s_J u) a − s_K u τ_rigid + …`, every `u ~ N(0, 1)`. `Y` is the regressor of the bodies' ten parameters `π`
//! and `D` their change by one standard deviation of each nominal value ([`Accuracy`]); `J_r` the rotor on the joint side. A torque constant
//! larger by `s_K u` makes the torque computed from a current too small; `τ_rigid` is that of the links as they deviate: an [`Expansion`] has the product.
//! Unknown gaps and wind-ups move the [posture](super::posture).
//! What the motion shows of `u` are the directions `z = Vᵀ u` with the largest torque: `V` are eigenvectors of the Gram matrix of the
//! torques, each divided by the RMS torque of its joint. Their prior is `N(0, 1)` again; all other directions are left out.
//!
//! A fit of all joints has the columns of all directions, a fit of one joint those of its [view](super::view).
//! References: M. Gautier (1997), Dynamic identification of robots with power model; G. A. F. Seber, A. J. Lee (2003), Linear Regression
//! Analysis, ch. 12 (priors as ridges).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::expansion::Expansion;
use super::posture::Posture;
use super::term::Term;
use super::view::{View, combined};
use crate::effects::Motion;
use crate::timeseries::root_mean_square;

/// [1] Torque of one standard deviation, as a share of the RMS torque, below which a direction is left out. Beside a residual of 1 % of the torque it
/// is worth ½ · 1e-4 nats a row: less than a nat in thousands of rows, while one of 1e-3 is worth dozens, and looked like a current offset.
const LEAST_TORQUE: f64 = 1e-4;
/// Number of rows from which the directions are computed.
const ROWS: usize = 2000;

/// Unknown deviations of the nominal model, and what is known of them.
#[derive(Debug, Clone)]
pub struct Inertial {
    /// `V`: one row per nominal value (ten a body, then rotors, torque constants, gaps and wind-ups), one column per direction.
    pub directions: DMatrix<f64>,
    /// `columns[joint][direction][row]` [N·m or N]: torque of one standard deviation.
    pub columns: Vec<Vec<Vec<f64>>>,
    /// `F_C` [N·m or N] Rough Coulomb friction of each joint, which decides on flanks.
    pub coulomb: Vec<f64>,
    /// Where each joint's columns are linear.
    pub expansions: Vec<Expansion>,
    /// Whether the columns contain what deviations do to the torque of effects.
    pub altered: bool,
    /// What each joint can still decide; `None` before the first fit.
    pub views: Vec<Option<View>>,
    /// The deviations of the last fit that was held.
    pub last: Option<Deviations>,
    /// Whether they are no longer fitted.
    pub fixed: bool,
}

/// Deviations `z` and their torque.
#[derive(Debug, Clone)]
pub struct Deviations {
    /// `z`
    pub z: DVector<f64>,
    /// `torque[joint][row]`
    pub torque: Vec<Vec<f64>>,
}

/// How a fit treats the deviations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Treated {
    /// There are none, or they are held at their estimate.
    Fixed,
    /// Fitted over all joints, `count` coefficients from `at`.
    Shared {
        /// First coefficient.
        at: usize,
        /// Number of coefficients.
        count: usize,
    },
    /// Fitted to one joint, beside what the others say.
    Seen {
        /// The joint.
        joint: usize,
        /// First coefficient.
        at: usize,
        /// Number of coefficients.
        count: usize,
        /// Whether the coefficients of effects of the whole machine are among them.
        with_machine: bool,
    },
}

impl Treated {
    /// Coefficients of the deviations in a fit.
    pub fn range(self) -> std::ops::Range<usize> {
        match self {
            Self::Fixed => 0..0,
            Self::Shared { at, count } | Self::Seen { at, count, .. } => at..at + count,
        }
    }
}

impl Inertial {
    /// The directions that a motion of joints with the Coulomb friction `F_C` shows; `None` where the stated accuracy leaves nothing that it shows.
    pub fn new(motion: &Motion, coulomb: Vec<f64>) -> Option<Self> {
        let accuracy = motion.model.accuracy;
        let deviations = accuracy.inertial_deviations(&motion.model.robot);
        let rows: Vec<usize> = (0..motion.rows()).step_by(motion.rows().div_ceil(ROWS).max(1)).collect();
        let few = motion.at_rows(&rows);
        let count = deviations.ncols() + 2 * motion.joints.len() + Posture::count(motion.joints.len());
        let unit = DMatrix::identity(count, count);
        let nominal = |motion: &Motion| vec![Expansion::nominal(motion.rows()); motion.joints.len()];
        let eigen = gram(&few, &torques(&few, &coulomb, &deviations, &unit, &nominal(&few))).symmetric_eigen();
        let shown: Vec<usize> =
            (0..eigen.eigenvalues.len()).filter(|k| eigen.eigenvalues[*k] > LEAST_TORQUE * LEAST_TORQUE).collect();
        if shown.is_empty() {
            return None;
        }
        let directions = eigen.eigenvectors.select_columns(&shown);
        let expansions = nominal(motion);
        let columns = self::torques(motion, &coulomb, &deviations, &directions, &expansions);
        Some(Self {
            directions,
            columns,
            coulomb,
            expansions,
            views: vec![None; motion.joints.len()],
            last: None,
            fixed: false,
            altered: false,
        })
    }

    /// Number of directions.
    pub fn count(&self) -> usize {
        self.directions.ncols()
    }

    /// Row of a joint's torque constant in the directions.
    pub fn constant_at(&self, joint: usize) -> usize {
        let dof = self.columns.len();
        self.directions.nrows() - Posture::count(dof) - dof + joint
    }

    /// `s c` of a joint: by how much each direction alters its torque constant, relative to it.
    pub fn constant(&self, motion: &Motion, joint: usize) -> DVector<f64> {
        self.directions.row(self.constant_at(joint)).transpose() * motion.scale_accuracy(joint)
    }

    /// `u`: deviations of the nominal values, in standard deviations.
    pub fn values(&self, z: &DVector<f64>) -> DVector<f64> {
        &self.directions * z
    }

    /// The deviations that are held, where they are not fitted.
    pub fn held(&self) -> Option<&Deviations> {
        self.last.as_ref().filter(|_| self.fixed)
    }

    /// Torque of deviations on a joint.
    pub fn torque_of(&self, joint: usize, z: &DVector<f64>) -> Vec<f64> {
        let mut torque = combined(&self.columns[joint], z);
        torque.iter_mut().zip(self.expansions[joint].shift()).for_each(|(sum, shift)| *sum += shift);
        torque
    }

    /// Expands the products of torque constants and deviating links near the deviations `z` of the last fit. Returns the largest change of a joint's scale,
    /// relative to it.
    pub fn expand(&mut self, motion: &Motion, z: &DVector<f64>) -> f64 {
        self.views.fill(None);
        let mut largest = 0.0_f64;
        for (joint, m) in motion.joints.iter().enumerate() {
            let constant = self.constant(motion, joint);
            if motion.scale_accuracy(joint) > 0.0 {
                let change = self.expansions[joint].step(&mut self.columns[joint], &m.rigid, &constant, z);
                largest = largest.max(change.abs());
            }
        }
        largest
    }

    /// `z` of the coefficients of a fit; for the fit of one joint, what its rows and those of the other joints say together.
    pub fn estimate(&self, treated: Treated, coefficients: &DVector<f64>) -> DVector<f64> {
        let own = || DVector::from_column_slice(&coefficients.as_slice()[treated.range()]);
        match (treated, self.held()) {
            (Treated::Fixed, Some(held)) => held.z.clone(),
            (Treated::Fixed, None) => DVector::zeros(self.count()),
            (Treated::Shared { .. }, _) => own(),
            (Treated::Seen { joint, .. }, _) => match &self.views[joint] {
                Some(view) => view.deviations(&own(), self.count()),
                None => own(),
            },
        }
    }

    /// What the rows of a joint can still decide, where that was computed beside the effects of the machine among these terms.
    pub fn view(&self, joint: usize, terms: &[&Term]) -> Option<&View> {
        self.views[joint].as_ref().filter(|view| view.is_beside(terms))
    }
}

/// Gram matrix of the torques of all directions, `torques[joint][direction][row]`, each divided by the RMS torque of its joint and averaged. Joints
/// that are not judged show nothing.
fn gram(motion: &Motion, torques: &[Vec<Vec<f64>>]) -> DMatrix<f64> {
    let count = torques.first().map_or(0, Vec::len);
    let mut gram = DMatrix::zeros(count, count);
    let judged = motion.joints.iter().zip(torques).filter(|(m, _)| m.left_out.is_none());
    for (m, torques) in judged {
        let power = root_mean_square(&m.torque).max(1e-300).powi(2) * motion.rows().max(1) as f64;
        let shown: Vec<usize> = (0..count).filter(|k| torques[*k].iter().any(|x| *x != 0.0)).collect();
        for a in &shown {
            for b in shown.iter().take_while(|b| *b <= a) {
                let product: f64 = torques[*a].iter().zip(&torques[*b]).map(|(x, y)| x * y).sum();
                gram[(*a, *b)] += product / power;
            }
        }
    }
    gram.fill_upper_triangle_with_lower_triangle();
    gram
}

/// Torque of each direction on each joint, linear near the expansions.
pub fn torques(
    motion: &Motion,
    coulomb: &[f64],
    deviations: &DMatrix<f64>,
    directions: &DMatrix<f64>,
    expansions: &[Expansion],
) -> Vec<Vec<Vec<f64>>> {
    let (of_bodies, dof) = (deviations.ncols(), motion.joints.len());
    let accuracy = &motion.model.accuracy;
    let posture = Posture::new(motion, coulomb);
    let mut torques = motion.regressed(&(deviations * directions.rows(0, of_bodies)));
    torques.par_iter_mut().enumerate().for_each(|(joint, torques)| {
        let m = &motion.joints[joint];
        let rotor = accuracy.rotor_inertias * motion.model.joints[joint].reflected_inertia();
        let scale = motion.scale_accuracy(joint);
        for (torque, direction) in torques.iter_mut().zip(directions.column_iter()) {
            posture.add_to(torque, joint, direction.rows(of_bodies + 2 * dof, Posture::count(dof)));
            let (rotor, scale) = (rotor * direction[of_bodies + joint], scale * direction[of_bodies + dof + joint]);
            torque.iter_mut().zip(&m.a).for_each(|(x, a)| *x += rotor * a);
            expansions[joint].scale_column(torque, &m.rigid, scale);
        }
    });
    torques
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::effects::JointMotion;
    use crate::effects::drawn::{MODEL, ROBOT};
    use crate::robot::Model;

    /// A link with its centre on a level axis is balanced in the nominal model. Off by `c` it weighs `m g c cos q`, of which a current shows
    /// `(1 − s u)` where the torque constant is larger by `s u`. A torque that the drive computes from it shows as much, and is off by no more than a
    /// usual constant where that of the model is a guess.
    #[test]
    fn analytic_a_torque_constant_scales_the_weight_of_a_link_that_is_off() {
        for (stated, has_current) in [(0.05, true), (0.05, false), (1.0, false)] {
            scales_the_weight(stated, has_current);
        }
    }

    fn scales_the_weight(stated: f64, has_current: bool) {
        let accuracy = format!(
            "[accuracy]\nmasses = 0\ncentres = 0.02\ntorque_constants = {stated}\nrotor_inertias = 0\ninertias = 0\n"
        );
        let text = MODEL.replace("[accuracy]\nmasses = 0\ncentres = 0\ninertias = 0\n", &accuracy);
        let robot = ROBOT.replace("xyz=\"0 0 1\"", "xyz=\"0 -1 0\"");
        let model = Model::from_texts(&text, &robot, Path::new("model.toml")).expect("a model");
        let times: Vec<f64> = (0..400).map(|row| 0.01 * f64::from(row)).collect();
        let of = |value: &dyn Fn(f64) -> f64| -> Vec<f64> { times.iter().map(|t| value(*t)).collect() };
        // Two waves: with one, the torque of inertia would be that of a weight beside the axis.
        let q = of(&|t| t.sin() + 0.3 * (2.7 * t).sin());
        let a = of(&|t| -t.sin() - 0.3 * 2.7 * 2.7 * (2.7 * t).sin());
        let rigid: Vec<f64> = a.iter().map(|a| 0.2 * a).collect();
        let m = JointMotion {
            has_current,
            v: of(&|t| t.cos() + 0.81 * (2.7 * t).cos()),
            torque: rigid.clone(),
            link_torque: rigid.clone(),
            direction: of(&|_| 1.0),
            link_inertia: vec![0.2; times.len()],
            torque_rate: vec![0.0; times.len()],
            q,
            a,
            rigid,
            ..JointMotion::default()
        };
        let rows = times.len();
        let motion = Motion {
            model: &model,
            sessions: 1,
            session: vec![0; rows],
            part: vec![0; rows],
            start: vec![0.0],
            interval: 0.01,
            time: times,
            half_width: vec![0.01; rows],
            joints: vec![m],
        };
        let mut inertial = Inertial::new(&motion, vec![0.0]).expect("deviations that show");
        // Three standard deviations of the centre along x, one of the torque constant.
        let (c, scale) = (3.0 * 0.02, 0.05);
        let mut u = DVector::zeros(inertial.directions.nrows());
        (u[1], u[inertial.constant_at(0)]) = (3.0, 1.0);
        let z = inertial.directions.tr_mul(&u);
        let weight: Vec<f64> = motion.joints[0].q.iter().map(|q| 9.81 * c * q.cos()).collect();
        let error = |inertial: &Inertial| {
            let shown = inertial.torque_of(0, &z);
            let expected = weight.iter().zip(&motion.joints[0].rigid).map(|(w, rigid)| w - scale * (rigid + w));
            shown.iter().zip(expected).map(|(shown, expected)| (shown - expected).abs()).fold(0.0, f64::max)
        };
        // The product of both is missing: 5 % of the weight, which is largest at the start.
        assert!((error(&inertial) / (scale * weight[0]) - 1.0).abs() < 1e-9, "{}", error(&inertial));
        for _ in 0..2 {
            inertial.expand(&motion, &z);
            // Rounding, through the eigenvectors of the directions.
            assert!(error(&inertial) < 1e-9 * weight[0], "{}", error(&inertial));
        }
    }
}
