//! An effect of typical strength: one that changes the torque of a recording by a given share.

use crate::diagnose::fit::pose::{nothing_moves, pose};
use crate::diagnose::options::Options;
use crate::diagnose::rows::division::Division;
use crate::effects::Scope;
use crate::error::Result;
use crate::robot::{EffectEntry, Model};
use crate::timeseries::TimeSeries;

/// An effect on the first joint where it can show. Its RMS torque along the recording of the nominal machine is the `share` (0 to 1) of the
/// total RMS torque; `None` where a diagnosis does not identify the effect by its torque.
///
/// # Errors
/// As [`diagnose`](crate::diagnose::diagnose).
pub fn typical(
    model: &Model,
    sessions: &[TimeSeries],
    effect: &str,
    share: f64,
    options: &Options,
) -> Result<Option<EffectEntry>> {
    let Some(effect) = options.catalogue.find(effect).and_then(|effect| effect.diagnosable()) else { return Ok(None) };
    let own: Vec<&TimeSeries> = sessions.iter().collect();
    let mut problem = pose(model, &own, Division::of(&own, own.len(), options.held_out_share), options)?;
    problem.settle(&[]).ok_or_else(|| nothing_moves(model))?;
    let motion = &problem.motion;
    let rms =
        |values: &[f64]| (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt();
    let about = effect.about();
    for joint in (0..model.joints.len()).filter(|joint| effect.applies(motion, *joint)) {
        let shapes = effect.shapes(motion, joint);
        // The middle of a range of shapes; of places that are no range the first, which is the usual one.
        let is_range =
            shapes.first().is_some_and(|shape| about.scope == Scope::Joint || effect.refined_shapes(shape) > 0);
        let usual = if is_range { shapes.len() / 2 } else { 0 };
        let Some(shape) = shapes.get(usual) else { continue };
        let columns = effect.columns(motion, joint, shape);
        let Some(size) = columns.first().map(|column| rms(column)).filter(|size| *size > 0.0) else { continue };
        for sign in [1.0, -1.0] {
            let mut coefficients = vec![0.0; columns.len()];
            coefficients[0] = sign * share * rms(&motion.joints[joint].torque) / size;
            let values = effect.parameters(motion, joint, shape, &coefficients);
            let named = || about.parameters.iter().zip(&values);
            if named().all(|(spec, value)| value.is_finite() && *value >= spec.min && *value <= spec.max) {
                let of_joint = about.scope == Scope::Joint;
                return Ok(Some(EffectEntry {
                    effect: about.name.to_owned(),
                    joint: of_joint.then(|| model.joints[joint].name.clone()),
                    parameters: named().map(|(spec, value)| (spec.name.to_owned(), *value)).collect(),
                }));
            }
        }
    }
    Ok(None)
}
