//! Velocity channel against the derivative of the position: a delay, or a low-pass that the model does not know.
//!
//! Both are averaged by one kernel, which does not change their relation ([`channel`]): a linear filter or a delay acts on the average of a
//! signal as on the signal itself. The expected velocity passes the low-pass of the model's sensor; the lag beyond it is fitted ([`fit`]).
//! A lag is reported if it exceeds one sample interval by [`SURELY`] standard errors: a difference of two readings is half an interval old, and
//! a reading that waits for its message another half. Its gain is the fall of the channel's error on held-out data.
//! Rows do not use the channel, so nothing else of a diagnosis changes.
//! Left out: sensors that time pulses, whose lag depends on the speed; channels that are ahead of the position.
//! Reference: C. H. Knapp, G. C. Carter (1976), The generalized correlation method for estimation of time delay.

mod channel;
mod fit;

use rayon::prelude::*;

use super::claims::{Sighting, claimed};
use super::{FittedRows, Instrument, Measurement};
use crate::diagnose::evidence::probability::{calibrated, odds_against};
use crate::diagnose::residuals::gains;
use crate::diagnose::result::EffectGain;
use crate::diagnose::rows::division::Division;
use crate::effects::Phenomenon;
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::TimeSeries;
use channel::Channels;
use fit::Lags;

/// Standard errors by which a lag has to exceed the threshold.
const SURELY: f64 = 4.0;
/// [1] First-order estimate of the lag, in thresholds, below which there is none. The estimate is too small by `(ω L)²/3`, a third for `ω
/// L` = 1.
const ROUGHLY: f64 = 0.5;
/// [1] Squares of the channel that a first-order lag may leave; a larger rest may be a lag beyond the first order.
const LEFT: f64 = 0.1;

/// The instrument for a velocity channel that lags.
pub struct VelocityLag;

impl Instrument<FittedRows<'_>> for VelocityLag {
    fn measure(&self, scene: &FittedRows) -> Result<Measurement> {
        let FittedRows { problem, sessions, division, options, .. } = *scene;
        let model = problem.motion.model;
        let of_joint = |joint: usize| {
            let channels = Channels::new(model, joint, sessions, division)?;
            sighting(model, joint, &channels)
        };
        let sightings = (0..model.joints.len()).into_par_iter().filter_map(of_joint).collect();
        Ok(Measurement { findings: claimed(model, &options.catalogue, sightings), ..Measurement::default() })
    }
}

/// [s] Lag of a joint's velocity channel beyond the sensor of the model; `None` where none is noticeable.
pub fn late_velocity(model: &Model, joint: usize, sessions: &[&TimeSeries], division: Division) -> Option<f64> {
    Some(noticeable(&Channels::new(model, joint, sessions, division)?)?.total.value)
}

/// Lags of a joint's channel that exceed one sample interval.
fn noticeable(channels: &Channels) -> Option<Lags> {
    let least = channels.step;
    let [rough, left] = channels.roughly();
    if rough < ROUGHLY * least && left < LEFT {
        return None;
    }
    channels.lags().filter(|lags| lags.total.value - least >= SURELY * lags.total.std_error)
}

/// A lag of a joint's channel, where it is noticeable.
fn sighting(model: &Model, joint: usize, channels: &Channels) -> Option<Sighting> {
    let lags = noticeable(channels)?;
    let Lags { total, delay, time_constant, gain, .. } = lags;
    Some(Sighting {
        phenomenon: Phenomenon::VelocityLag { delay, time_constant, gain },
        joints: vec![joint],
        probability: calibrated(odds_against(total.value, channels.step, total.std_error)),
        evidence_nats: 0.5 * (total.value / total.std_error).powi(2),
        gain: Some(held_out_gain(channels, &lags)),
        words: format!(
            "the velocity channel of {} follows its position {:.1} ± {:.1} ms late",
            model.joints[joint].name,
            1e3 * total.value,
            1e3 * total.std_error
        ),
    })
}

/// Fall of the channel's error on held-out points; gain and offset of both models are fitted to the training points.
fn held_out_gain(channels: &Channels, lags: &Lags) -> EffectGain {
    let value = |lag: Option<crate::timeseries::Estimate>| lag.map_or(0.0, |lag| lag.value);
    let models = [channels.at(0.0, 0.0), channels.at(value(lags.delay), value(lags.time_constant))];
    let mut sessions: Vec<[Vec<f64>; 3]> = Vec::new();
    let mut last = None;
    for stretch in &channels.stretches {
        // The parts of one session belong together.
        if last != Some(stretch.session) {
            sessions.push(Default::default());
            last = Some(stretch.session);
        }
        let Some(session) = sessions.last_mut() else { continue };
        session[0].extend(&stretch.time[stretch.held_out..]);
        for (errors, model) in session[1..].iter_mut().zip(&models) {
            errors.extend(&stretch.errors(model)[stretch.held_out - stretch.first..]);
        }
    }
    EffectGain::of(gains::gain(&sessions), "velocity channel")
}
