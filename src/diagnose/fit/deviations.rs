//! A fit whose nominal model deviates within its stated accuracy: what is free in it, what is held, and what one joint's rows can decide.

use std::borrow::Cow;

use nalgebra::DVector;

use super::cause::Cause;
use super::expansion::Expansion;
use super::inertial::{Deviations, Inertial, Treated, torques};
use super::pose::rough_coulomb;
use super::problem::{Fitted, Part, Problem};
use super::term::Term;
use super::view::{Information, View, combined};
use crate::robot::Model;

/// [1] Precision of what has no prior, as a share of what all rows say of it: half of the digits.
const FLAT: f64 = 1e-8;
/// Largest number of fits until the scales of torque have settled.
const FITS: usize = 8;
/// [1] Change of a joint's scale of torque from one fit to the next below which it has settled: a fifth of the accuracy of a usual constant.
const SETTLED: f64 = 0.01;

/// Torque [N·m or N] of the deviations on one joint, as a fit has it.
pub struct OnJoint<'s> {
    /// Of each free coefficient, in all rows.
    pub columns: Cow<'s, [Vec<f64>]>,
    /// What is known of it; `None` where the model does not deviate.
    pub known: Option<Cow<'s, [f64]>>,
}

impl Problem<'_> {
    /// From now on the nominal model may deviate within its stated accuracy.
    pub fn deviate(&mut self) {
        let coulomb = (0..self.baseline.len()).map(|joint| rough_coulomb(self, joint)).collect();
        self.inertial = Inertial::new(&self.motion, coulomb);
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

    /// The deviations on a joint beside these terms.
    pub fn deviations(&self, joint: usize, terms: &[&Term], treated: Treated) -> OnJoint<'_> {
        let fixed = |known| OnJoint { columns: Cow::Borrowed(&[]), known };
        let Some(inertial) = &self.inertial else { return fixed(None) };
        match treated {
            Treated::Fixed => fixed(inertial.held().map(|held| Cow::Borrowed(&held.torque[joint][..]))),
            Treated::Shared { .. } => self.beside_loads(inertial, joint, terms),
            Treated::Seen { .. } => match inertial.view(joint, terms) {
                Some(view) => {
                    OnJoint { columns: Cow::Borrowed(&view.columns), known: Some(Cow::Borrowed(&view.shift)) }
                }
                None => self.beside_loads(inertial, joint, terms),
            },
        }
    }

    /// All deviations on a joint, with products that are linear near the loads that these terms are.
    fn beside_loads<'s>(&self, inertial: &'s Inertial, joint: usize, terms: &[&Term]) -> OnJoint<'s> {
        let expansion = &inertial.expansions[joint];
        let (mut columns, mut shift) = (Cow::from(&inertial.columns[joint]), Cow::from(expansion.shift()));
        let is_scaled = self.motion.scale_accuracy(joint) > 0.0;
        for load in terms.iter().filter(|_| is_scaled).filter_map(|term| term.load(&self.motion, joint)) {
            let constant = inertial.constant(&self.motion, joint);
            expansion.add_load(columns.to_mut(), shift.to_mut(), &load, &constant);
        }
        OnJoint { columns, known: Some(shift) }
    }

    /// Torque of the deviations of a fit with these terms on a joint in all rows; `None` where there are none.
    pub fn deviating_torque(&self, terms: &[&Term], fitted: &Fitted, joint: usize) -> Option<Vec<f64>> {
        let inertial = self.inertial.as_ref()?;
        let coefficients = &fitted.solution.coefficients;
        match (fitted.inertial, &inertial.views[joint]) {
            (Treated::Fixed, _) => inertial.held().map(|held| held.torque[joint].clone()),
            (Treated::Seen { joint: own, .. }, Some(view)) if own == joint => {
                Some(view.torque(&coefficients.as_slice()[fitted.inertial.range()]))
            }
            _ => {
                let OnJoint { columns, known } = self.beside_loads(inertial, joint, terms);
                let mut torque = combined(&columns, &inertial.estimate(fitted.inertial, coefficients));
                torque.iter_mut().zip(&*known?).for_each(|(sum, known)| *sum += known);
                Some(torque)
            }
        }
    }

    /// Deviations of bodies alter the torque of physical effects of the machine where it is proportional to masses. From now on as at this fit, if it has
    /// such effects.
    pub fn deviate_beside(&mut self, terms: &[&Term], fitted: &Fitted) {
        let Some(inertial) = &mut self.inertial else { return };
        let accuracy = self.motion.model.accuracy;
        let deviations = accuracy.inertial_deviations(&self.motion.model.robot);
        let changes = &deviations * inertial.directions.rows(0, deviations.ncols());
        let motion = &self.motion;
        let coefficients = fitted.solution.coefficients.as_slice();
        let found = terms.iter().zip(&fitted.term_at).filter(|(term, _)| term.effect.loads_machine());
        let loads: Vec<(&Term, &[f64])> =
            found.map(|(term, at)| (*term, &coefficients[*at..at + term.coefficients()])).collect();
        if loads.is_empty() && !inertial.altered {
            return;
        }
        inertial.altered = !loads.is_empty();
        inertial.columns = torques(motion, &inertial.coulomb, &deviations, &inertial.directions, &inertial.expansions);
        inertial.views.fill(None);
        let altered = loads.iter().filter_map(|(term, own)| term.effect.on_changed_bodies(motion, &changes, own));
        for of_joints in altered {
            for ((columns, torques), m) in inertial.columns.iter_mut().zip(of_joints).zip(&motion.joints) {
                for (column, torque) in columns.iter_mut().zip(torques) {
                    column.iter_mut().zip(torque).for_each(|(sum, x)| *sum += (1.0 - m.scale) * x);
                }
            }
        }
    }

    /// Expands the product of torque constants and deviating links near this fit; returns by how much a joint's scale changed, relative to it.
    pub fn expand(&mut self, fitted: &Fitted) -> f64 {
        let Some(inertial) = self.inertial.as_mut().filter(|_| fitted.inertial != Treated::Fixed) else { return 0.0 };
        let z = inertial.estimate(fitted.inertial, &fitted.solution.coefficients);
        let change = inertial.expand(&self.motion, &z);
        self.motion.joints.iter_mut().zip(&inertial.expansions).for_each(|(m, expansion)| m.scale = expansion.scale());
        change
    }

    /// Repeats fits with these terms until products with torque constants are linear near their own fit. `fit` may change the baseline's friction, on which
    /// columns depend as well; it receives the fit before.
    pub fn fit_near_itself(
        &mut self,
        terms: &mut [&mut Term],
        fit: impl Fn(&mut Self, &[&Term], Option<&Fitted>) -> Option<Fitted>,
    ) -> Option<Fitted> {
        let mut last: Option<Fitted> = None;
        for pass in 1..=FITS {
            let fitted = fit(self, &shared(terms), last.as_ref())?;
            let change = self.expand(&fitted);
            for (term, at) in terms.iter_mut().zip(&fitted.term_at) {
                let near = &fitted.solution.coefficients.as_slice()[*at..at + term.coefficients()];
                **term = term.along(&self.motion, near.to_vec());
            }
            last = Some(fitted);
            if pass > 1 && change < SETTLED {
                break;
            }
        }
        last
    }

    /// This problem with the products of torque constants and deviating links linear near the nominal model.
    pub fn near_nominal(&self) -> Self {
        let mut near = self.clone();
        let Some(inertial) = &mut near.inertial else { return near };
        near.motion.joints.iter_mut().for_each(|m| m.scale = 0.0);
        let motion = &near.motion;
        let deviations = motion.model.accuracy.inertial_deviations(&motion.model.robot);
        inertial.expansions = vec![Expansion::nominal(motion.rows()); motion.joints.len()];
        inertial.columns = torques(motion, &inertial.coulomb, &deviations, &inertial.directions, &inertial.expansions);
        inertial.views.fill(None);
        inertial.altered = false;
        near
    }

    /// From now on the deviations have the values of this fit.
    pub fn hold(&mut self, fitted: &Fitted) {
        if let Some(inertial) = &mut self.inertial {
            let z = inertial.estimate(fitted.inertial, &fitted.solution.coefficients);
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

    /// The nominal model with the deviations that are held; and the true torque of each joint relative to that of the nominal model. A recorded
    /// torque remains the unit of its joint: it drives a simulation as it is, and no torque constant of the model has a part in it.
    pub fn deviating_model(&self) -> (Model, Vec<f64>) {
        let (model, dof) = (self.motion.model, self.baseline.len());
        let held = self.inertial.as_ref().and_then(|inertial| Some((inertial, inertial.values(&inertial.held()?.z))));
        let Some((inertial, mut u)) = held else { return (model.clone(), vec![1.0; dof]) };
        for joint in (0..dof).filter(|joint| !self.motion.joints[*joint].has_current) {
            u[inertial.constant_at(joint)] = 0.0;
        }
        let factor = |joint: usize| model.torque_factor(joint, u[inertial.constant_at(joint)]);
        (model.deviating(u.as_slice()), (0..dof).map(factor).collect())
    }

    /// Row of a joint's torque constant in the directions, and its deviation `u` where deviations are held.
    pub fn constant(&self, joint: usize) -> Option<(Vec<f64>, f64)> {
        let inertial = self.inertial.as_ref()?;
        let row: Vec<f64> = inertial.directions.row(inertial.constant_at(joint)).iter().copied().collect();
        let u = inertial.held()?.z.iter().zip(&row).map(|(z, v)| z * v).sum();
        Some((row, u))
    }

    /// Updates what each joint can decide, from a loose fit of all joints with these terms.
    pub fn look(&mut self, terms: &[&Term], fitted: &Fitted) {
        let (Some(inertial), Treated::Shared { at, count }) = (&self.inertial, fitted.inertial) else { return };
        if self.baseline.len() < 2 {
            return;
        }
        let system = self.system(terms, Part::Train, true).system;
        let machine: Vec<(&Term, usize)> =
            terms.iter().copied().zip(fitted.term_at.iter().copied()).filter(|(term, _)| term.is_machine()).collect();
        let mut shared: Vec<usize> = (at..at + count).collect();
        shared.extend(machine.iter().flat_map(|(term, at)| *at..at + term.coefficients()));
        let x = DVector::from_iterator(shared.len(), shared.iter().map(|at| fitted.solution.coefficients[*at]));
        let of_joint = |joint: usize| {
            let solution = &fitted.solution;
            let trust = self.independence[joint] / solution.scale[joint].powi(2);
            let weights: Vec<f64> = solution.weights[joint].iter().map(|w| w * trust).collect();
            Information::new(&system.blocks[joint], &weights, &solution.residual[joint], &shared, &x)
        };
        let known: Vec<Information> = (0..self.baseline.len()).map(of_joint).collect();
        let mut prior = DVector::zeros(shared.len());
        for (k, at) in shared.iter().enumerate() {
            let stated = system.priors.iter().filter(|(of, _)| of == at).map(|(_, precision)| precision).sum::<f64>();
            let shown: f64 = known.iter().map(|known| known.q[(k, k)]).sum();
            prior[k] = stated + if shown > 0.0 { FLAT * shown } else { 1.0 };
        }
        let beside: Vec<(Cause, Vec<f64>)> =
            machine.iter().map(|(term, _)| (term.effect, term.shape.clone())).collect();
        let seen = |joint: usize| {
            let own = self.beside_loads(inertial, joint, terms);
            let place = |term: &Term| term.joints.iter().position(|own| *own == joint).unwrap_or(0);
            let of_terms = machine.iter().flat_map(|(term, _)| &term.columns[place(term)]);
            let columns: Vec<&Vec<f64>> = own.columns.iter().chain(of_terms).collect();
            Some(View::new(beside.clone(), &columns, &prior, &known, joint)?.shifted(&own.known?))
        };
        let views = (0..known.len()).map(seen).collect();
        if let Some(inertial) = &mut self.inertial {
            inertial.views = views;
        }
    }
}

/// References that only read.
fn shared<'t>(terms: &'t [&mut Term]) -> Vec<&'t Term> {
    terms.iter().map(|term| &**term).collect()
}
