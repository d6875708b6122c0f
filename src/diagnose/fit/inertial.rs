//! Errors of the nominal inertias and scales, within the accuracy that the model states for them.
//!
//! `τ = Y(q, q̇, q̈) (π̄ + D u) + J_r (1 + s_J u) a − s_K u τ_rigid + …`, every `u ~ N(0, 1)`. `Y` is the regressor of the bodies' ten parameters `π`
//! and `D` their change by one standard deviation of each nominal value ([`Accuracy`]); `J_r` the rotor on the joint side. A torque constant
//! larger by `s_K u` makes the torque computed from a current too small.
//! What the motion shows of `u` are the directions `z = Vᵀ u` with the largest torque: `V` are eigenvectors of the Gram matrix of the
//! torques, each divided by the RMS torque of its joint. Their prior is `N(0, 1)` again; all other directions are left out.
//!
//! A fit of all joints has the columns of all directions, a fit of one joint those of its [view](super::views).
//! References: M. Gautier (1997), Dynamic identification of robots with power model; G. A. F. Seber, A. J. Lee (2003), Linear Regression
//! Analysis, ch. 12 (priors as ridges).

use nalgebra::{DMatrix, DVector};

use super::problem::{Fitted, Problem, Term};
use super::views::View;
use crate::diagnose::rows::observe::root_mean_square;
use crate::effects::{JointMotion, Kind, Motion};
use crate::robot::{Accuracy, Model};

/// [1] Torque of one standard deviation, as a share of the RMS torque, below which a direction is left out: no friction law is as accurate.
const LEAST_TORQUE: f64 = 1e-3;
/// Number of rows from which the directions are computed.
const ROWS: usize = 2000;

/// Unknown deviations of the nominal model, and what is known of them.
#[derive(Debug, Clone)]
pub struct Inertial {
    /// `V`: one row per nominal value (ten a body, then rotors, then torque constants), one column per direction.
    directions: DMatrix<f64>,
    /// `columns[joint][direction][row]` [N·m or N]: torque of one standard deviation.
    pub columns: Vec<Vec<Vec<f64>>>,
    /// Whether the columns contain what deviations do to the torque of effects.
    altered: bool,
    /// What each joint can still decide; `None` before the first fit.
    pub views: Vec<Option<View>>,
    /// The deviations of the last fit that was held.
    last: Option<Deviations>,
    /// Whether they are no longer fitted.
    fixed: bool,
}

/// Deviations `z` and their torque.
#[derive(Debug, Clone)]
struct Deviations {
    z: DVector<f64>,
    /// `torque[joint][row]`
    torque: Vec<Vec<f64>>,
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
    /// The directions that a motion shows; `None` where the stated accuracy leaves nothing that it shows.
    pub fn new(motion: &Motion) -> Option<Self> {
        let accuracy = motion.model.accuracy;
        let deviations = accuracy.inertial_deviations(&motion.model.robot);
        let rows: Vec<usize> = (0..motion.rows()).step_by(motion.rows().div_ceil(ROWS).max(1)).collect();
        let few = motion.at_rows(&rows);
        let unit = DMatrix::identity(
            deviations.ncols() + 2 * motion.joints.len(),
            deviations.ncols() + 2 * motion.joints.len(),
        );
        let eigen = gram(&few, &torques(&few, &accuracy, &deviations, &unit)).symmetric_eigen();
        let shown: Vec<usize> =
            (0..eigen.eigenvalues.len()).filter(|k| eigen.eigenvalues[*k] > LEAST_TORQUE * LEAST_TORQUE).collect();
        if shown.is_empty() {
            return None;
        }
        let directions = eigen.eigenvectors.select_columns(&shown);
        let columns = self::torques(motion, &accuracy, &deviations, &directions);
        Some(Self {
            directions,
            columns,
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

    /// `u`: deviations of the nominal values, in standard deviations.
    fn values(&self, z: &DVector<f64>) -> DVector<f64> {
        &self.directions * z
    }

    fn held(&self) -> Option<&Deviations> {
        self.last.as_ref().filter(|_| self.fixed)
    }

    fn torque_of(&self, joint: usize, z: &DVector<f64>) -> Vec<f64> {
        combined(&self.columns[joint], z)
    }

    /// `z` of a fit; for the fit of one joint, what its rows and those of the other joints say together.
    fn estimate(&self, fitted: &Fitted) -> DVector<f64> {
        let own =
            |treated: Treated| DVector::from_column_slice(&fitted.solution.coefficients.as_slice()[treated.range()]);
        match (fitted.inertial, self.held()) {
            (Treated::Fixed, Some(held)) => held.z.clone(),
            (Treated::Fixed, None) => DVector::zeros(self.count()),
            (treated @ Treated::Shared { .. }, _) => own(treated),
            (treated @ Treated::Seen { joint, .. }, _) => match &self.views[joint] {
                Some(view) => view.deviations(&own(treated), self.count()),
                None => own(treated),
            },
        }
    }

    /// What the rows of a joint can still decide, where that was computed beside the effects of the machine among these terms.
    pub fn view(&self, joint: usize, terms: &[&Term]) -> Option<&View> {
        self.views[joint].as_ref().filter(|view| view.is_beside(terms))
    }
}

/// `Σ c_k column_k`.
pub fn combined<'c>(columns: &[Vec<f64>], coefficients: impl IntoIterator<Item = &'c f64>) -> Vec<f64> {
    let mut sum = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, c) in columns.iter().zip(coefficients) {
        sum.iter_mut().zip(column).for_each(|(sum, x)| *sum += c * x);
    }
    sum
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

/// Torque of each direction on each joint.
fn torques(
    motion: &Motion,
    accuracy: &Accuracy,
    deviations: &DMatrix<f64>,
    directions: &DMatrix<f64>,
) -> Vec<Vec<Vec<f64>>> {
    let (of_bodies, dof) = (deviations.ncols(), motion.joints.len());
    let mut torques = motion.regressed(&(deviations * directions.rows(0, of_bodies)));
    for (joint, torques) in torques.iter_mut().enumerate() {
        let m = &motion.joints[joint];
        let rotor = accuracy.rotor_inertias * motion.model.joints[joint].reflected_inertia();
        let scale = if m.has_current { -accuracy.torque_constants } else { 0.0 };
        for (torque, direction) in torques.iter_mut().zip(directions.column_iter()) {
            let (rotor, scale) = (rotor * direction[of_bodies + joint], scale * direction[of_bodies + dof + joint]);
            if rotor != 0.0 || scale != 0.0 {
                torque.iter_mut().enumerate().for_each(|(row, x)| *x += rotor * m.a[row] + scale * m.rigid[row]);
            }
        }
    }
    torques
}

/// What the torque constants in each direction do to the torque of an effect of the machine.
fn rescaled(
    motion: &Motion,
    accuracy: &Accuracy,
    directions: &DMatrix<f64>,
    term: &Term,
    coefficients: &[f64],
) -> Vec<Vec<Vec<f64>>> {
    let first = directions.nrows() - motion.joints.len();
    let of_joint = |(joint, m): (usize, &JointMotion)| -> Vec<Vec<f64>> {
        let place = term.joints.iter().position(|own| *own == joint).filter(|_| m.has_current);
        let torque =
            place.map_or_else(|| vec![0.0; motion.rows()], |place| combined(&term.columns[place], coefficients));
        let scale = |u: &f64| torque.iter().map(|torque| -accuracy.torque_constants * u * torque).collect();
        directions.row(first + joint).iter().map(scale).collect()
    };
    motion.joints.iter().enumerate().map(of_joint).collect()
}

impl Problem<'_> {
    /// From now on the nominal model may deviate within its stated accuracy.
    pub fn deviate(&mut self) {
        self.inertial = Inertial::new(&self.motion);
    }

    /// The joints that a fit of some joints has to include: all, where deviations of the model couple several.
    pub fn within(&self, joints: Vec<usize>) -> Vec<usize> {
        if self.is_deviating() && joints.len() > 1 { self.joints() } else { joints }
    }

    /// Whether deviations are fitted.
    fn is_deviating(&self) -> bool {
        self.inertial.as_ref().is_some_and(|inertial| inertial.held().is_none())
    }

    /// Whether a joint can be fitted alone beside these terms, because it is known what the other joints say of all that they share.
    pub fn stands_alone(&self, joints: &[usize], terms: &[&Term]) -> bool {
        let [joint] = joints else { return false };
        let own: Vec<&Term> = terms.iter().copied().filter(|term| term.joints != *joints).collect();
        self.is_deviating() && self.inertial.as_ref().is_some_and(|inertial| inertial.view(*joint, &own).is_some())
    }

    /// How a fit of these joints and terms treats the deviations, with the first coefficient that is free.
    pub fn treated(&self, joints: &[usize], terms: &[&Term], at: usize) -> Treated {
        match (self.inertial.as_ref().filter(|inertial| !inertial.fixed), joints) {
            (None, _) => Treated::Fixed,
            (Some(inertial), [joint]) if inertial.columns.len() > 1 => {
                let view = inertial.view(*joint, terms);
                let count = view.map_or(inertial.count(), |view| view.columns.len());
                Treated::Seen { joint: *joint, at, count, with_machine: view.is_some() }
            }
            (Some(inertial), _) => Treated::Shared { at, count: inertial.count() },
        }
    }

    /// Columns of the deviations for a joint, and the torque that is known of them.
    pub fn deviations(&self, joint: usize, terms: &[&Term], treated: Treated) -> (&[Vec<f64>], Option<&[f64]>) {
        let Some(inertial) = &self.inertial else { return (&[], None) };
        match (treated, inertial.held()) {
            (Treated::Fixed, Some(held)) => (&[], Some(&held.torque[joint])),
            (Treated::Fixed, None) => (&[], None),
            (Treated::Shared { .. }, _) => (&inertial.columns[joint], None),
            (Treated::Seen { .. }, _) => match inertial.view(joint, terms) {
                Some(view) => (&view.columns, Some(&view.shift)),
                None => (&inertial.columns[joint], None),
            },
        }
    }

    /// Torque of the deviations of a fit on a joint in all rows; `None` where there are none.
    pub fn deviating_torque(&self, fitted: &Fitted, joint: usize) -> Option<Vec<f64>> {
        let inertial = self.inertial.as_ref()?;
        match (fitted.inertial, inertial.held()) {
            (Treated::Fixed, Some(held)) => Some(held.torque[joint].clone()),
            (Treated::Fixed, None) => None,
            (Treated::Seen { joint: own, .. }, _) if own == joint => match &inertial.views[joint] {
                Some(view) => Some(view.torque(&fitted.solution.coefficients.as_slice()[fitted.inertial.range()])),
                None => Some(inertial.torque_of(joint, &inertial.estimate(fitted))),
            },
            _ => Some(inertial.torque_of(joint, &inertial.estimate(fitted))),
        }
    }

    /// Deviations alter the torque of physical effects of the machine: of bodies where it is proportional to masses, of torque constants where it is
    /// computed from a current, as that of the links. From now on as at this fit, if it has such effects.
    pub fn deviate_beside(&mut self, terms: &[&Term], fitted: &Fitted) {
        let Some(inertial) = &mut self.inertial else { return };
        let accuracy = self.motion.model.accuracy;
        let deviations = accuracy.inertial_deviations(&self.motion.model.robot);
        let changes = &deviations * inertial.directions.rows(0, deviations.ncols());
        let (motion, directions) = (&self.motion, &inertial.directions);
        let of_term = |(term, at): (&&Term, &usize)| {
            let own = &fitted.solution.coefficients.as_slice()[*at..at + term.coefficients()];
            let by_scale = rescaled(motion, &accuracy, directions, term, own);
            term.effect.on_changed_bodies(motion, &changes, own).into_iter().chain([by_scale])
        };
        let physical = |term: &&Term| term.is_machine() && term.effect.about().kind == Kind::Physics;
        let found = terms.iter().zip(&fitted.term_at).filter(|(term, _)| physical(term));
        let altered: Vec<_> = found.flat_map(of_term).collect();
        if altered.is_empty() && !inertial.altered {
            return;
        }
        inertial.altered = !altered.is_empty();
        inertial.columns = torques(&self.motion, &accuracy, &deviations, &inertial.directions);
        inertial.views.fill(None);
        for torque in &altered {
            for (column, torque) in inertial.columns.iter_mut().flatten().zip(torque.iter().flatten()) {
                column.iter_mut().zip(torque).for_each(|(sum, x)| *sum += x);
            }
        }
    }

    /// From now on the deviations have the values of this fit.
    pub fn hold(&mut self, fitted: &Fitted) {
        if let Some(inertial) = &mut self.inertial {
            let z = inertial.estimate(fitted);
            let torque = (0..inertial.columns.len()).map(|joint| inertial.torque_of(joint, &z)).collect();
            (inertial.last, inertial.fixed) = (Some(Deviations { z, torque }), true);
        }
    }

    /// From now on the deviations are fitted.
    pub fn free(&mut self) {
        if let Some(inertial) = &mut self.inertial {
            inertial.fixed = false;
        }
    }

    /// From now on the deviations have the values that were held before.
    pub fn hold_again(&mut self) {
        if let Some(inertial) = &mut self.inertial {
            inertial.fixed = inertial.last.is_some();
        }
    }

    /// The nominal model with the deviations that are held; and the true torque of
    /// each joint relative to that of the nominal model.
    pub fn deviating_model(&self) -> (Model, Vec<f64>) {
        let (model, dof) = (self.motion.model, self.baseline.len());
        let held = self.inertial.as_ref().and_then(|inertial| Some((inertial, inertial.values(&inertial.held()?.z))));
        let Some((_, u)) = held else { return (model.clone(), vec![1.0; dof]) };
        let factor = |joint: usize| model.accuracy.torque_factor(u[u.len() - dof + joint]);
        (model.deviating(u.as_slice()), (0..dof).map(factor).collect())
    }

    /// Row of a joint's torque constant in the directions, and its deviation `u` where deviations are held.
    pub fn constant(&self, joint: usize) -> Option<(Vec<f64>, f64)> {
        let inertial = self.inertial.as_ref()?;
        let at = inertial.directions.nrows() - self.baseline.len() + joint;
        let row: Vec<f64> = inertial.directions.row(at).iter().copied().collect();
        let u = inertial.held()?.z.iter().zip(&row).map(|(z, v)| z * v).sum();
        Some((row, u))
    }
}
