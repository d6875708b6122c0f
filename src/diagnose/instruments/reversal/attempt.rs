//! A gear with effects, fitted to the rows around reversals: gap, link share and the effects' parameters by Gauss-Newton steps,
//! whose length depends on the likelihood of the regression's heavy-tailed error.

use std::collections::BTreeMap;

use super::gear::{Altered, Gear};
use super::turn_rows::TurnRows;
use crate::diagnose::fit::problem::Part;
use crate::effects::{AtTurns, Trial};
use crate::gearhead::Friction;

/// Largest number of steps of a fit.
const MOST_STEPS: usize = 8;
/// [nats] Gain below which no further step is taken.
const SETTLED: f64 = 0.3;
/// Number of times that a step without gain is halved.
const HALVINGS: usize = 4;
/// Step of numerical derivatives relative to a parameter's scale: large enough to smooth over the grid of times.
const DIFFERENCE: f64 = 0.1;
/// Scale of the gap, in counts and relative to the gap.
const GAP_SCALE: [f64; 2] = [1.0, 0.2];
/// Scale of the link share.
const SHARE_SCALE: f64 = 0.2;
/// Largest link share.
const MOST_SHARE: f64 = 0.95;

/// An effect installed in the gear.
#[derive(Clone)]
pub struct Planted {
    /// The effect.
    pub effect: &'static dyn AtTurns,
    /// Its parameter values.
    pub values: Vec<f64>,
    /// Possible error of each parameter; zero for one that keeps its value.
    pub scales: Vec<f64>,
}

impl Planted {
    /// An effect with the values of a trial.
    pub fn new(effect: &'static dyn AtTurns, trial: Trial) -> Self {
        Self { effect, values: trial.values, scales: trial.scales }
    }
}

/// A gear with its effects.
#[derive(Clone)]
pub struct Setting {
    /// `b` [rad or m].
    pub gap: f64,
    /// `s` [1].
    pub share: f64,
    /// [rad or m] Least and largest gap.
    pub within: [f64; 2],
    /// Effects in the gear.
    pub planted: Vec<Planted>,
}

/// Result of a fit.
#[derive(Clone)]
pub struct TurnFit {
    /// The fitted setting.
    pub setting: Setting,
    /// Torque that the rows lack with this setting.
    pub lack: Vec<f64>,
    /// Derivatives of that torque by each parameter, and by a delay.
    pub columns: Vec<Vec<f64>>,
    /// Log-likelihood of the training rows.
    pub log_likelihood: f64,
}

impl Setting {
    /// Its parameters in order: gap, share, those of the effects.
    pub fn values(&self) -> Vec<f64> {
        [self.gap, self.share].into_iter().chain(self.planted.iter().flat_map(|one| one.values.clone())).collect()
    }

    fn scales(&self, count: f64) -> Vec<f64> {
        let gap = (GAP_SCALE[0] * count).max(GAP_SCALE[1] * self.gap).max(1e-9);
        let of_effects = self.planted.iter().flat_map(|one| one.scales.clone());
        [gap, SHARE_SCALE].into_iter().chain(of_effects).collect()
    }

    fn with(&self, values: &[f64]) -> Self {
        let mut setting = self.clone();
        (setting.gap, setting.share) =
            (values[0].clamp(setting.within[0], setting.within[1]), values[1].clamp(0.0, MOST_SHARE));
        let mut rest = &values[2..];
        for one in &mut setting.planted {
            let (own, others) = rest.split_at(one.values.len());
            one.values.copy_from_slice(own);
            rest = others;
        }
        setting
    }
}

impl TurnRows<'_, '_> {
    /// Torque that the rows lack with a setting, and its derivative by a delay; `None` where an effect rejects its parameters.
    pub fn simulate(&self, setting: &Setting) -> Option<[Vec<f64>; 2]> {
        let gear = Gear { gap: setting.gap, share: setting.share };
        let lack = self.torque(&gear, &setting.planted)?;
        let step = self.path.step;
        let rate: Vec<f64> = (0..lack.len())
            .map(|k| (lack[(k + 1).min(lack.len() - 1)] - lack[k.saturating_sub(1)]) / (2.0 * step))
            .collect();
        Some([self.windows.averages(&lack), self.windows.averages(&rate)])
    }

    fn torque(&self, gear: &Gear, planted: &[Planted]) -> Option<Vec<f64>> {
        if planted.is_empty() {
            return Some(super::gear::lack(&self.path, gear, &Altered::default()));
        }
        let mut model = self.problem.motion.model.clone();
        model.joints[self.joint].backlash = Some(gear.gap);
        model.set_friction(self.joint, Friction { link_share: gear.share, ..self.path.friction.on_motor() });
        let mut actions = Vec::new();
        for one in planted {
            let names = one.effect.about().parameters.iter().map(|spec| spec.name.to_owned());
            let given: BTreeMap<String, f64> = names.zip(one.values.iter().copied()).collect();
            actions.extend(one.effect.install(&mut model, Some(self.joint), &given).ok()?);
        }
        Some(super::gear::lack(&self.path, gear, &Altered::by(&actions, self.joint)))
    }

    /// Log-likelihood of the training rows with a setting.
    pub fn likelihood(&self, setting: &Setting) -> Option<f64> {
        let [lack, delay] = self.simulate(setting)?;
        self.fit(Part::Train, &lack, &[delay]).map(|solution| solution.log_likelihood[0])
    }

    /// Fits a setting.
    pub fn fitted(&self, setting: &Setting) -> Option<TurnFit> {
        let mut fit = self.at(setting)?;
        for _ in 0..MOST_STEPS {
            let solution = self.fit(Part::Train, &fit.lack, &fit.columns)?;
            let values = fit.setting.values();
            let scales = fit.setting.scales(self.count());
            let mut stride = 1.0;
            let mut better = None;
            for _ in 0..HALVINGS {
                let moved: Vec<f64> = (0..values.len())
                    .map(|i| values[i] + stride * solution.coefficients[i].clamp(-scales[i], scales[i]))
                    .collect();
                let setting = fit.setting.with(&moved);
                if let Some(gained) = self.likelihood(&setting).filter(|l| *l > fit.log_likelihood) {
                    better = Some((setting, gained));
                    break;
                }
                stride *= 0.5;
            }
            let Some((setting, gained)) = better else { break };
            let settled = gained - fit.log_likelihood < SETTLED;
            fit = self.at(&setting)?;
            if settled {
                break;
            }
        }
        Some(fit)
    }

    fn at(&self, setting: &Setting) -> Option<TurnFit> {
        let [lack, delay] = self.simulate(setting)?;
        let log_likelihood = self.fit(Part::Train, &lack, std::slice::from_ref(&delay))?.log_likelihood[0];
        let (values, scales) = (setting.values(), setting.scales(self.count()));
        let mut columns = Vec::new();
        for (index, scale) in scales.iter().enumerate() {
            if *scale == 0.0 {
                columns.push(vec![0.0; lack.len()]);
                continue;
            }
            let moved = |by: f64| {
                let mut moved = values.clone();
                moved[index] += by;
                let setting = setting.with(&moved);
                // A bound may have shortened the step.
                let by = setting.values()[index] - values[index];
                (by != 0.0).then(|| self.simulate(&setting)).flatten().map(|[lack, _]| (lack, by))
            };
            let (other, by) = moved(DIFFERENCE * scale).or_else(|| moved(-DIFFERENCE * scale))?;
            columns.push(other.iter().zip(&lack).map(|(other, lack)| (other - lack) / by).collect());
        }
        columns.push(delay);
        Some(TurnFit { setting: setting.clone(), lack, columns, log_likelihood })
    }

    fn count(&self) -> f64 {
        self.problem.motion.model.joints[self.joint].encoder_step()
    }
}
