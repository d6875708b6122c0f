//! A second encoder behind the gear: delay, wind-up and gap, told apart.
//!
//! ```text
//!   q(t) − l(t + T) = T_g/k + b/2 · side + mounting        q motor, l link as recorded, T_g torque through the gear
//! ```
//!
//! `T` is how late the link's encoder is recorded (one recorder, one delay for all joints), `k` the stiffness, `b` the total gap, `side` the flank
//! that carries (the sign of `T_g`), and the mounting a constant a session with once-per-turn terms of the second encoder's seat.
//! The time shift is carried out on the samples, so it holds at any speed. Without it `T q̇` is left over, which in a motion of
//! nearly constant speeds looks like a gap `2 T |q̇|`: on the KUKA KR300 of 0.016 to 0.033° where there is none.
//!
//! A link that floats in its gap, or is about to, is ahead by anything: rows count in which it lies on a flank for certain (`contact`).
//! Before that, machines with a gap of 8 mrad and without gravity had soft gears named (160 N·m/rad for 3000). A gap that varies with the
//! angle is looked for (`varying`), and the rest is fitted beside it where there is one.
//!
//! `T_g` is what the links need, with the share of friction behind the gear. Where the model's masses are estimated it is the measured torque
//! less the rotor's; friction before the gear is then fitted beside it.
//! Left out: stiffness that grows with torque, errors of the gear's transmission. Both stay in the residual, and the residual in the errors.
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
use crate::diagnose::rows::observe::root_mean_square;
use crate::effects::Phenomenon;
use crate::error::Result;
use crate::replay::Gain;
use crate::timeseries::{Estimate, TimeSeries};
use difference::{Difference, difference};
use fit::{AxisFit, Lag, fit, rest};
use varying::{Varying, varying};

/// [s] Lag that two channels sampled by one recorder may show without a delay: the channel's own filter, friction that is not as fitted.
const NOTICEABLE: f64 = 2e-4;
/// Standard errors by which something has to differ from what the model says.
const SURELY: f64 = 4.0;
/// Wind-up over that of the model's stiffness from which on a gear is soft.
const SOFT: f64 = 1.5;
/// What the gains here are of.
const LINK_POSITION: &str = "link position";

/// What second encoders say of the machine, beside effects.
#[derive(Debug, Default)]
pub struct Encoders {
    /// One a joint that has one.
    pub joints: Vec<result::TwoEncoders>,
    /// Errors of the link's position before and after.
    pub fit: Vec<FitError>,
    /// Gap of each joint of the model, where it shows.
    pub gaps: Vec<Option<Measured>>,
    /// Joints whose gap is not as the model says, and the gap [rad or m] instead.
    pub other_gaps: Vec<(usize, f64)>,
}

/// A second encoder behind the gear beside that of the motor.
pub struct TwoEncoders;

impl Instrument<FittedRows<'_>> for TwoEncoders {
    fn measure(&self, scene: &FittedRows) -> Result<Measurement> {
        Ok(measured(scene))
    }
}

/// Looks at all joints that have a second encoder.
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

/// The lag that holds for all joints; where they do not agree, its error grows.
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

/// RMS error of the link's position: as the model says, and with what was found.
fn compared(problem: &Problem, sessions: &[&TimeSeries], fit: &AxisFit, lag: f64) -> Vec<FitError> {
    let model = &problem.motion.model.joints[fit.joint];
    let nominal = |rows: &Difference| -> Option<Vec<f64>> {
        let gap = 0.5 * model.backlash.unwrap_or(0.0);
        let side = rows.side(0.0);
        let wound = rows.load.iter().zip(&side).map(|(load, side)| load / model.gear_stiffness + gap * side);
        let left: Vec<f64> = rows.ahead.iter().zip(wound).map(|(ahead, wound)| ahead - wound).collect();
        rest(problem, rows, &left)
    };
    let of = |split: Split, part: bool| -> Option<FitError> {
        let shifted = difference(problem, sessions, fit.joint, lag)?.filtered(|row| problem.held_out[row] == part);
        // The same rows for both: a shift costs some at the ends.
        let recorded =
            difference(problem, sessions, fit.joint, 0.0)?.filtered(|row| shifted.rows.binary_search(&row).is_ok());
        let size = root_mean_square(&rest(problem, &recorded, &recorded.ahead)?);
        let (nominal, mended) = (nominal(&recorded)?, fit.residual(problem, &shifted)?);
        let (before, after) = (root_mean_square(&nominal), root_mean_square(&mended));
        let everywhere = |values: &[f64]| {
            let mut all = vec![0.0; problem.motion.rows()];
            shifted.rows.iter().zip(values).for_each(|(row, value)| all[*row] = *value);
            all
        };
        let residual = Residual { before: everywhere(&nominal), after: everywhere(&mended) };
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

/// By how much the error on what is held out is lower. The ends of the interval of several joints are those of all of them at once: that is
/// wider than it would be if they were independent.
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

/// [nats] Of a value this many standard errors from what the model says.
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
    let (c, soft) = (fit.wind_up, SOFT / model.gear_stiffness);
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
            "the gear winds up like one of {:.3e} ± {:.1e} {}, the model file says {:.3e}",
            stiffness.value,
            stiffness.std_error,
            model.kind.stiffness_unit(),
            model.gear_stiffness
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
            "the gap varies by ± {:.2e} {unit}, {:.2} periods a turn",
            wave.amplitude.value, wave.order.value
        ),
    }
}
