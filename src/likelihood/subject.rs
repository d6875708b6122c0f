//! A machine that is about to be carried along a recording: its model, and the currents that have flowed if this model is right.
//!
//! ```text
//!   x ← x + Sᵀ (r − S x)        r: recorded currents, S: what the sensor makes of a current, x: the current that flowed
//! ```
//! An effect on the readings is simulated as it acts, from current to reading; the filter needs it the other way. `Sᵀ` is `S` along the reversed
//! time; an offset is undone by the first step, since its linear part is one. Delays are undone by shifting the currents: positions that are
//! recorded late are those of a machine that is late itself, driven by delayed currents. A filter that corrected the present by what it reads
//! of the past would oscillate.
//! Reference: L. Landweber (1951), An iteration formula for Fredholm integral equations of the first kind.

use super::Settings;
use super::recording::Recording;
use crate::effects::{take_current_delay, take_position_delay};
use crate::error::Result;
use crate::plant::carried::Carrier;
use crate::robot::Model;
use crate::timeseries::delayed;

/// Steps of the iteration: the first undoes an offset or whole samples of lag, the others what interpolation between samples loses.
const STEPS: usize = 3;

/// A model, and what else a hypothesis says of a recording.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Setup {
    /// The machine.
    pub model: Model,
    /// `Δw` [1] Change of the weight `w` of currents ([`recording`](super::recording)).
    pub weight: f64,
    /// [A] Offset of the current sensors, one per joint.
    pub offsets: Vec<f64>,
}

/// The machine of a setup and the currents that drive it.
pub(super) struct Subject {
    /// The machine.
    pub carrier: Carrier,
    /// [A] `[joint][interval]`: from a sample to the next.
    currents: Vec<Vec<f64>>,
}

impl Subject {
    /// The machine of a setup for a recording.
    ///
    /// # Errors
    /// As [`Carrier::new`].
    pub fn new(setup: &Setup, recording: &Recording, settings: &Settings) -> Result<Self> {
        let mut setup = Setup { model: setup.model.in_session(&recording.name), ..setup.clone() };
        let late = take_position_delay(&mut setup.model) - take_current_delay(&mut setup.model);
        let currents = (0..recording.joints.len()).map(|joint| flowed(&setup, recording, settings, joint, late));
        let currents = currents.collect::<Result<_>>()?;
        Ok(Self { carrier: Carrier::new(&setup.model, &settings.catalogue)?, currents })
    }

    /// Writes the currents [A] from a sample to the next, one per joint.
    pub fn currents(&self, sample: usize, out: &mut [f64]) {
        out.iter_mut().zip(&self.currents).for_each(|(out, currents)| *out = currents[sample]);
    }
}

/// Currents of a joint from each sample to the next; `late`: by how much more [s] the positions are delayed than the currents.
fn flowed(setup: &Setup, recording: &Recording, settings: &Settings, joint: usize, late: f64) -> Result<Vec<f64>> {
    let recorded = &recording.joints[joint];
    let read = |currents: &[f64]| -> Result<Option<Vec<f64>>> {
        Ok(Carrier::new(&setup.model, &settings.catalogue)?.read_currents(joint, &recording.time, currents))
    };
    let mut x = recorded.current.clone();
    if let Some(idle) = read(&vec![0.0; x.len()])? {
        for _ in 0..STEPS {
            let seen = read(&x)?.unwrap_or_default();
            let missing: Vec<f64> = recorded.current.iter().zip(&seen).map(|(r, seen)| r - seen).rev().collect();
            let back = read(&missing)?.unwrap_or_default();
            let back = back.iter().zip(&idle).map(|(back, idle)| back - idle).rev();
            x.iter_mut().zip(back).for_each(|(x, back)| *x += back);
        }
    }
    let x = delayed(&recording.time, &x, late);
    let (w, offset) = (recorded.weight + setup.weight, setup.offsets[joint]);
    Ok(x.windows(2).map(|i| w * i[0] + (1.0 - w) * i[1] - offset).collect())
}
