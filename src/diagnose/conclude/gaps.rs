//! Gaps that the model file does not give, from reversals or from two encoders, and the uncertainty that they add to other parameters.

use rayon::prelude::*;

use super::link_load::{self, Loaded};
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::term::Term;
use crate::diagnose::result::{FoundEffect, Measured};
use crate::diagnose::rows::gentlest::gentlest;
use crate::diagnose::select::selection::Selection;
use crate::effects::Catalogue;
use crate::error::Error;
use crate::identify::backlash::{self, BacklashIdentification};
use crate::robot::{Masses, Model, TorqueAt};
use crate::timeseries::TimeSeries;

/// Result for a gap that the model file does not give.
#[derive(Debug, Clone, Default)]
pub struct MeasuredGap {
    /// The gap, where the data show one.
    pub measured: Option<Measured>,
    /// [1] Share of friction behind the gap.
    pub link_share: Option<f64>,
    /// Why it was not measured.
    pub left_out: Option<String>,
    /// Whether it was not, because a named effect loads the link.
    pub held: bool,
}

impl MeasuredGap {
    fn none(reason: impl Into<String>) -> Self {
        Self { left_out: Some(reason.into()), ..Self::default() }
    }

    /// [rad or m] The gap, where the data show one.
    pub fn value(&self) -> Option<f64> {
        self.measured.as_ref().map(|gap| gap.value)
    }
}

/// The gap of each joint; `seen` are gaps from two encoders, and `sessions` do not contain the torque of named effects.
pub fn measured(
    model: &Model,
    sessions: &[&TimeSeries],
    problem: &Problem,
    selection: &Selection,
    seen: &[Option<Measured>],
) -> Vec<MeasuredGap> {
    let measure = |index: usize| {
        let joint = &model.joints[index];
        if joint.backlash.is_some() || problem.motion.joints[index].left_out.is_some() {
            return MeasuredGap::default();
        }
        // Two encoders measure a gap directly.
        if let Some(gap) = &seen[index] {
            let gap = Measured { value: gap.value.max(0.0), ..gap.clone() };
            return MeasuredGap { measured: Some(gap), ..MeasuredGap::default() };
        }
        if joint.torque_at == TorqueAt::Link {
            return MeasuredGap::none(
                "its torque was measured behind the gear: reversals of the rotor do not show there. For the same reason the friction is that of the \
                 link side, and effects of motor and gear were not sought",
            );
        }
        if model.masses == Masses::Estimated {
            return MeasuredGap::default();
        }
        if let Some(reason) = link_load::why_not(problem, selection, &|_| true, index, sessions) {
            return MeasuredGap { held: true, ..MeasuredGap::none(reason) };
        }
        let friction = problem.motion.joints[index].friction.on_motor();
        match backlash::identify(model, index, &gentlest(model, index, sessions), &friction) {
            Ok(found) => of(&found, joint.kind.position_unit()),
            Err(error) => MeasuredGap::none(lacking(&error)),
        }
    };
    (0..model.joints.len()).into_par_iter().map(measure).collect()
}

/// Gaps of joints whose links are held by effects that the loaded model has, where they are sure; `sessions` contain the torque of these effects.
pub fn measure_held(
    gaps: &mut [MeasuredGap],
    loaded: &Loaded,
    sessions: &[&TimeSeries],
    problem: &Problem,
    selection: &Selection,
) {
    let nominal = problem.motion.model;
    let outside = |term: &Term| !loaded.contains(term);
    gaps.par_iter_mut().enumerate().filter(|(_, gap)| gap.held).for_each(|(index, gap)| {
        if link_load::why_not(problem, selection, &outside, index, sessions).is_some() {
            return;
        }
        let friction = problem.motion.joints[index].friction.on_motor();
        let data = gentlest(&loaded.model, index, sessions);
        let found = backlash::identify_loaded(&loaded.model, nominal, index, &data, &friction);
        let sure = found.map(|found| of(&found, nominal.joints[index].kind.position_unit()));
        if let Some(sure) = sure.filter(|sure| sure.measured.is_some()) {
            *gap = sure;
        }
    });
}

/// What reversals told.
fn of(found: &BacklashIdentification, unit: &'static str) -> MeasuredGap {
    let mean = &found.best.mean;
    if !(mean.std_error > 0.0 && mean.std_error.is_finite()) {
        return MeasuredGap::none("the reversals of this motion do not determine it");
    }
    let link_share = found.link_share.as_ref().map(|share| share.value.clamp(0.0, 1.0));
    let measured = Measured { value: mean.value.max(0.0), std_error: mean.std_error, unit };
    MeasuredGap { measured: Some(measured), link_share, ..MeasuredGap::default() }
}

/// What the data lack, and what to record.
fn lacking(error: &Error) -> String {
    match error {
        Error::TooLittleData { found, unit, needed, advice, .. } => {
            format!("{found} {unit}, at least {needed} needed: {advice}")
        }
        Error::Undetermined { reason, .. } => reason.clone(),
        other => other.to_string(),
    }
}

/// Adds to angles of links the uncertainty that gaps cause. The rotor's angle does not show where in its gap `b` a link is: the angle of
/// the link is within `± b/2` of it, which is a standard error of `b/√12`.
pub fn blur(effects: &mut [FoundEffect], model: &Model, gaps: &[MeasuredGap], catalogue: &Catalogue) {
    for found in effects {
        let joint = model.joints.iter().position(|joint| Some(&joint.name) == found.joints.first());
        let effect = catalogue.diagnosable().find(|effect| effect.about().name == found.effect);
        let (Some(joint), Some(effect)) = (joint, effect) else { continue };
        let gap = gaps[joint].value().or(model.joints[joint].backlash).unwrap_or(0.0);
        for name in effect.angles_of_link() {
            if let Some(angle) = found.parameters.get_mut(*name) {
                angle.std_error = angle.std_error.hypot(gap / 12.0_f64.sqrt());
            }
        }
    }
}
