//! The last checks for a mistake: a torque constant that would be off by a factor of two, and more than half of the torque that remains after
//! every effect has been tried.
//!
//! A single effect, such as a tilted base, can be most of what a nominal model lacks; so this check runs at the end. Two conditions are needed. The
//! error of the finished diagnosis on held-out data is above half of the torque and well above the sensor's floor. And the torque balance, with
//! free masses, tilt, payload and spring, leaves more than a quarter of the squares. Held-out data are read here after the diagnosis is finished:
//! they judge it, and change nothing in it.

use super::balance;
use super::balance::UNSOUND;
use super::rows;
use crate::diagnose::result::Mistake;
use crate::diagnose::result::{FitError, FoundEffect, Parts, Split};
use crate::effects::TORQUE_CONSTANT_FAR_OFF as FAR_OFF;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// [%] of the RMS torque.
const HALF: f64 = 50.0;
/// Errors below this multiple of the floor are due to the sensors.
const FLOORS: f64 = 3.0;

/// Mistakes that a finished diagnosis shows; empty where there are none.
pub fn found(model: &Model, sessions: &[&TimeSeries], parts: &Parts) -> Vec<Mistake> {
    let scales = scales(&parts.findings.effects);
    if scales.is_empty() { unexplained(model, sessions, &parts.fit) } else { scales }
}

/// Torque constants that would be off by more than [`FAR_OFF`]: none is chosen as such, but others beside it can move it there.
fn scales(effects: &[FoundEffect]) -> Vec<Mistake> {
    let of_effect = |found: &FoundEffect| {
        let factor = 1.0 + found.parameters.get("error").filter(|_| found.effect == "torque_constant_error")?.value;
        (factor > 0.0 && factor.ln().abs() > FAR_OFF.ln()).then(|| Mistake {
            mistake: "torque_scale",
            joints: found.joints.clone(),
            factor: Some(factor),
            evidence: format!(
                "{}: the motion needs {factor:.2} times the torque that the model computes from the recorded current; torque constants do not differ by that much.",
                found.joints.join(", ")
            ),
            remedy: "check the unit of the current, whether a torque stands in its column, and gear ratio and torque constant of the model".to_owned(),
            alternatives: vec!["torque_recorded_as_current", "gear_ratio"],
        })
    };
    effects.iter().filter_map(of_effect).collect()
}

/// The joints with more than half of the torque unexplained; empty where there are none.
fn unexplained(model: &Model, sessions: &[&TimeSeries], errors: &[FitError]) -> Vec<Mistake> {
    let large = |name: &str| {
        errors.iter().find(|fit| {
            let torque =
                fit.joint == name && ["torque", "force"].contains(&fit.quantity) && fit.split == Split::HeldOut;
            torque && fit.after_percent > HALF && fit.after > FLOORS * fit.floor
        })
    };
    if model.joints.iter().all(|joint| large(&joint.name).is_none()) {
        return Vec::new();
    }
    let rows = rows::rows(model, sessions);
    let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
    let balances = balance::balances(model, &rows, &moves);
    let of_joint = |(joint, left): (&crate::robot::JointModel, &Option<balance::Balance>)| {
        let fit = large(&joint.name)?;
        let left = (*left)?.left;
        (left > UNSOUND).then(|| Mistake {
            mistake: "baseline_error",
            joints: vec![joint.name.clone()],
            factor: None,
            evidence: format!(
                "{}: {:.0} % of the torque on data held out is unexplained after every effect was tried, and {:.0} % of the torque if masses, tilt, payload and a spring are free.",
                joint.name,
                fit.after_percent,
                100.0 * left.sqrt()
            ),
            remedy: "compare the manifest's columns, units and signs with the recording, and gear ratio, torque constant, masses and axes of the model with the machine".to_owned(),
            alternatives: Vec::new(),
        })
    };
    model.joints.iter().zip(&balances).filter_map(of_joint).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::result::{EffectGain, Measured, Standing};
    use crate::effects::find;
    use crate::replay::Gain;

    fn named(effect: &str, error: f64) -> FoundEffect {
        let about = find(effect).expect("an effect of the catalogue").about();
        let standing =
            Standing { probability: 0.9, evidence_nats: 90.0, gain: EffectGain::of(Gain::default(), "torque") };
        let error = Measured { value: error, std_error: 0.01, unit: "1" };
        FoundEffect::new(about, vec!["joint1".to_owned()], [("error".to_owned(), error)].into(), standing)
    }

    #[test]
    fn property_a_torque_constant_off_by_a_factor_is_a_mistake() {
        let [mistake] = scales(&[named("torque_constant_error", -0.75)]).try_into().expect("one mistake");
        assert_eq!((mistake.mistake, mistake.factor), ("torque_scale", Some(0.25)));
        assert_eq!(scales(&[named("torque_constant_error", 1.5)]).len(), 1);
        for effect in
            [named("torque_constant_error", 0.4), named("torque_constant_error", -0.3), named("rotor_inertia", 3.0)]
        {
            assert_eq!(scales(&[effect]), []);
        }
    }
}
