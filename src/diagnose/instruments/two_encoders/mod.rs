//! A second encoder behind the gear: separates delay, wind-up and gap.
//!
//! ```text
//!   q(t) − l(t + T) = T_g/k + b/2 · side + mounting        q motor, l link as recorded, T_g torque through the gear
//! ```
//!
//! `T` is the delay of the link's encoder (one recorder, one delay for all joints), `k` the stiffness, `b` the total gap, `side` the flank
//! in contact (the sign of `T_g`), and the mounting a constant per session with once-per-turn terms of the second encoder.
//! The samples are shifted in time, so the correction is valid at any speed. Without it `T q̇` remains, which in a motion of
//! nearly constant speeds looks like a gap `2 T |q̇|`: on the KUKA KR300 of 0.016 to 0.033° where there is none.
//!
//! Rows count only where the link certainly lies on a flank (`contact`). With floating links included, machines with a gap of 8 mrad and
//! without gravity get gears that are too soft (160 N·m/rad for 3000). A gap that varies with the angle is sought too (`varying`); if there
//! is one, the other parameters are fitted beside it.
//!
//! `T_g` is the torque that the links need, with the share of friction behind the gear. Where the model's masses are estimated it is the measured
//! torque minus the rotor's; friction before the gear is then fitted too.
//! Left out: stiffness that grows with torque, transmission errors of the gear. Both remain in the residual, and so in the standard errors.
//! Reference: J. Weigand et al. (2022), KUKA KR300 data set.

mod contact;
mod difference;
mod fit;
mod flanks;
mod solved;
mod varying;
mod wave;

use crate::diagnose::evidence::probability::{calibrated, odds_against};
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::instruments::claims::{Sighting, claimed};
use crate::diagnose::instruments::{FittedRows, Instrument, Measurement};
use crate::diagnose::residuals::Residual;
use crate::diagnose::residuals::errors;
use crate::diagnose::result::{self, EffectGain, Findings, FitError, Measured, Split, Unexplained};
use crate::effects::Phenomenon;
use crate::error::Result;
use crate::replay::Gain;
use crate::timeseries::root_mean_square;
use crate::timeseries::{Estimate, TimeSeries};
use difference::{Difference, difference};
use fit::{AxisFit, Lag, fit, rest};
use varying::{Varying, varying};

/// [s] Lag between two channels of one recorder that occurs without a delay: by the channel's filter, or by an error of friction.
const NOTICEABLE: f64 = 2e-4;
/// Standard errors by which a value has to differ from the model's.
const SURELY: f64 = 4.0;
/// Wind-up relative to that of the model's stiffness above which a gear counts as soft.
const SOFT: f64 = 1.5;
/// Standard deviations of the stated accuracy of a stiffness within which a softer gear is no surprise.
const STATED: f64 = 1.96;
/// Largest product of [`STATED`] and the stated accuracy: a stiffness that is known to a factor of four is hardly known.
const MOST_STATED: f64 = 0.75;
/// The quantity in which the gains are given here.
const LINK_POSITION: &str = "link position";

/// Results of second encoders, apart from effects.
#[derive(Debug, Default)]
pub struct Encoders {
    /// One entry per joint with a second encoder.
    pub joints: Vec<result::TwoEncoders>,
    /// Errors of the link's position before and after.
    pub fit: Vec<FitError>,
    /// Gap of each joint of the model, where it shows.
    pub gaps: Vec<Option<Measured>>,
    /// Joints whose gap differs from the model's, with the measured gap [rad or m].
    pub other_gaps: Vec<(usize, f64)>,
}

/// The instrument for a second encoder behind the gear, in addition to that of the motor.
pub struct TwoEncoders;

impl Instrument<FittedRows<'_>> for TwoEncoders {
    fn measure(&self, scene: &FittedRows) -> Result<Measurement> {
        Ok(measured(scene))
    }
}

/// Evaluates all joints with a second encoder.
fn measured(scene: &FittedRows) -> Measurement {
    let FittedRows { problem, sessions, options, .. } = *scene;
    let dof = problem.motion.joints.len();
    let free: Vec<AxisFit> = (0..dof).filter_map(|joint| fit(problem, sessions, joint, Lag::Free, None)).collect();
    let mut found = Encoders { gaps: vec![None; dof], ..Encoders::default() };
    let mut findings = Findings::default();
    if free.is_empty() {
        return Measurement { encoders: Some(found), ..Measurement::default() };
    }
    let lag = common(&free);
    let late = lag.value.abs() - NOTICEABLE > SURELY * lag.std_error;
    let shift = if late { lag.value } else { 0.0 };
    let (mut errors, mut sightings) = (Vec::new(), Vec::new());
    for free in &free {
        let Some(constant) = fit(problem, sessions, free.joint, Lag::Known(shift), None) else { continue };
        let uneven = varying(problem, sessions, &constant, shift, &options.rules);
        let of = uneven.as_ref().map_or(&constant, |uneven| &uneven.fit);
        let without = fit(problem, sessions, free.joint, Lag::Ignored, None).and_then(|fit| fit.gap);
        let joint = result::TwoEncoders::of(problem, free, of, without);
        let model = &problem.motion.model.joints[free.joint];
        if let (Some(gap), Some(nominal)) = (&joint.backlash, model.backlash)
            && (gap.value - nominal).abs() > SURELY * gap.std_error
        {
            let pattern = format!(
                "the two encoders show a gap of {:.3e} ± {:.1e} {}, the model file says {nominal:.3e}",
                gap.value, gap.std_error, gap.unit
            );
            found.other_gaps.push((free.joint, gap.value.max(0.0)));
            findings.unexplained.push(Unexplained { joint: model.name.clone(), pattern });
        }
        found.gaps[free.joint].clone_from(&joint.backlash);
        let of_joint = compared(problem, sessions, of, shift);
        sightings.extend(soft(problem, of, &of_joint));
        sightings.extend(uneven.map(|uneven| varies(problem, &uneven)));
        errors.extend(of_joint);
        found.joints.push(joint);
    }
    if late {
        sightings.push(delay(lag, &free, &errors));
    }
    findings.merge(claimed(problem.motion.model, &options.catalogue, sightings));
    found.fit = errors;
    Measurement { findings, encoders: Some(found), ..Measurement::default() }
}

/// The common lag of all joints; its error grows if they disagree.
fn common(fits: &[AxisFit]) -> Estimate {
    let weight = |fit: &AxisFit| 1.0 / fit.lag.std_error.max(1e-6).powi(2);
    let total: f64 = fits.iter().map(weight).sum();
    let value = fits.iter().map(|fit| weight(fit) * fit.lag.value).sum::<f64>() / total;
    let chi2: f64 = fits.iter().map(|fit| weight(fit) * (fit.lag.value - value).powi(2)).sum();
    let disagreement = (chi2 / (fits.len() - 1).max(1) as f64).max(1.0);
    Estimate { value, std_error: (disagreement / total).sqrt() }
}

impl result::TwoEncoders {
    fn of(problem: &Problem, free: &AxisFit, fit: &AxisFit, without: Option<Estimate>) -> Self {
        let model = &problem.motion.model.joints[fit.joint];
        let (position, compliance) = (model.kind.position_unit(), model.kind.compliance_unit());
        let measured =
            |estimate: Estimate, unit| Measured { value: estimate.value, std_error: estimate.std_error, unit };
        let c = fit.wind_up;
        let resolved = c.value > 2.0 * c.std_error;
        let stiffness = Measured {
            value: 1.0 / c.value,
            std_error: c.std_error / c.value.powi(2),
            unit: model.kind.stiffness_unit(),
        };
        Self {
            joint: model.name.clone(),
            link_delay: measured(free.lag, "s"),
            explained_by_delay_percent: 100.0 * free.explained,
            wind_up: measured(c, compliance),
            stiffness: resolved.then_some(stiffness),
            backlash: fit.gap.map(|gap| measured(gap, position)),
            lost_motion: fit.lost.map(|lost| measured(lost, position)),
            backlash_without_delay: without.map(|gap| measured(gap, position)),
        }
    }
}

/// RMS error of the link's position: with the model's values, and with the measured ones.
fn compared(problem: &Problem, sessions: &[&TimeSeries], fit: &AxisFit, lag: f64) -> Vec<FitError> {
    let model = &problem.motion.model.joints[fit.joint];
    let nominal = |rows: &Difference| -> Option<Vec<f64>> {
        let gap = 0.5 * model.backlash.unwrap_or(0.0);
        let side = rows.side(0.0);
        let wound =
            rows.load.iter().zip(&side).map(|(load, side)| model.gear_stiffness.map_or(0.0, |k| load / k) + gap * side);
        let left: Vec<f64> = rows.ahead.iter().zip(wound).map(|(ahead, wound)| ahead - wound).collect();
        rest(problem, rows, &left)
    };
    let of = |split: Split, part: bool| -> Option<FitError> {
        let shifted = difference(problem, sessions, fit.joint, lag)?.filtered(|row| problem.held_out[row] == part);
        // Use the same rows for both: a shift loses some at the ends.
        let recorded =
            difference(problem, sessions, fit.joint, 0.0)?.filtered(|row| shifted.rows.binary_search(&row).is_ok());
        let size = root_mean_square(&rest(problem, &recorded, &recorded.ahead)?);
        let (nominal, extended) = (nominal(&recorded)?, fit.residual(problem, &shifted)?);
        let (before, after) = (root_mean_square(&nominal), root_mean_square(&extended));
        let everywhere = |values: &[f64]| {
            let mut all = vec![0.0; problem.motion.rows()];
            shifted.rows.iter().zip(values).for_each(|(row, value)| all[*row] = *value);
            all
        };
        let residual = Residual { before: everywhere(&nominal), after: everywhere(&extended) };
        let counts = [model.encoder_step(), model.link_encoder.map_or(0.0, |encoder| encoder.resolution)];
        Some(FitError {
            joint: model.name.clone(),
            quantity: "link_position",
            unit: model.kind.position_unit(),
            split,
            before,
            after,
            floor: (counts[0].powi(2) + counts[1].powi(2)).sqrt() / 12.0_f64.sqrt(),
            before_percent: 100.0 * before / size.max(1e-300),
            after_percent: 100.0 * after / size.max(1e-300),
            gain: errors::gain(problem, &shifted.rows, &residual),
        })
    };
    [of(Split::Train, false), of(Split::HeldOut, true)].into_iter().flatten().collect()
}

/// Gain in the held-out error. The interval for several joints uses the ends of all their intervals at once, which is wider than for
/// independent errors.
fn gain(errors: &[FitError]) -> EffectGain {
    let held_out: Vec<&FitError> = errors.iter().filter(|error| error.split == Split::HeldOut).collect();
    let before: f64 = held_out.iter().map(|error| error.before.powi(2)).sum();
    let percent = |of: &dyn Fn(&Gain) -> f64| {
        let left = held_out.iter().map(|error| (error.before * (1.0 - 0.01 * of(&error.gain))).powi(2)).sum::<f64>();
        100.0 * (1.0 - (left / before.max(1e-300)).sqrt())
    };
    let interval_percent = [percent(&|gain| gain.interval_percent[0]), percent(&|gain| gain.interval_percent[1])];
    let shown = interval_percent[0] > 0.0;
    EffectGain::of(Gain { gain_percent: percent(&|gain| gain.gain_percent), interval_percent, shown }, LINK_POSITION)
}

/// [nats] Evidence for a value that differs from the model's by this many standard errors.
fn evidence(value: f64, std_error: f64) -> f64 {
    0.5 * (value / std_error.max(1e-300)).powi(2)
}

fn delay(lag: Estimate, fits: &[AxisFit], errors: &[FitError]) -> Sighting {
    Sighting {
        phenomenon: Phenomenon::LinkEncoderLag { lag },
        joints: fits.iter().map(|fit| fit.joint).collect(),
        probability: calibrated(odds_against(lag.value.abs(), NOTICEABLE, lag.std_error)),
        evidence_nats: evidence(lag.value, lag.std_error),
        gain: Some(gain(errors)),
        words: format!(
            "the encoder of the link is recorded {:.2} ± {:.2} ms behind that of the motor",
            1e3 * lag.value,
            1e3 * lag.std_error
        ),
    }
}

fn soft(problem: &Problem, fit: &AxisFit, errors: &[FitError]) -> Option<Sighting> {
    let model = &problem.motion.model.joints[fit.joint];
    // A gear without a stiffness in the model file is nominally rigid: any wind-up is more.
    let within = (STATED * problem.motion.model.accuracy.stiffness).min(MOST_STATED);
    let softest = SOFT.max(1.0 / (1.0 - within));
    let (c, soft) = (fit.wind_up, model.gear_stiffness.map_or(0.0, |k| softest / k));
    let nominal = model.gear_stiffness.map_or_else(|| "none".to_owned(), |k| format!("{k:.3e}"));
    if c.value - soft < SURELY * c.std_error {
        return None;
    }
    let stiffness = Estimate { value: 1.0 / c.value, std_error: c.std_error / c.value.powi(2) };
    Some(Sighting {
        phenomenon: Phenomenon::WindUp { stiffness },
        joints: vec![fit.joint],
        probability: calibrated(odds_against(c.value, soft, c.std_error)),
        evidence_nats: evidence(c.value - soft, c.std_error),
        gain: Some(gain(errors)),
        words: format!(
            "the gear winds up like one of {:.3e} ± {:.1e} {}, the model file says {nominal}",
            stiffness.value,
            stiffness.std_error,
            model.kind.stiffness_unit()
        ),
    })
}

/// A gap that varies with the angle.
fn varies(problem: &Problem, uneven: &Varying) -> Sighting {
    let (joint, wave) = (uneven.fit.joint, &uneven.wave);
    let unit = problem.motion.model.joints[joint].kind.position_unit();
    Sighting {
        phenomenon: Phenomenon::UnevenGap { amplitude: wave.amplitude, order: wave.order, phase: wave.phase },
        joints: vec![joint],
        probability: calibrated((-uneven.log_odds).exp()),
        evidence_nats: uneven.log_odds,
        gain: Some(EffectGain::of(uneven.gain, LINK_POSITION)),
        words: format!(
            "the gap varies by ± {:.2e} {unit}, {:.2} periods per turn",
            wave.amplitude.value, wave.order.value
        ),
    }
}
