//! What a fit maximises: the score of the training recordings beside the prior, with its derivatives.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::Settings;
use super::filter::{Outcome, Run, Shadow};
use super::parameters::{self, Kind, Parameter};
use super::recording::Recording;
use super::subject::{Setup, Subject};
use super::uneven::UNEVEN_GAP;
use crate::error::Result;
use crate::robot::{EffectEntry, Model};

/// Step of a shadow, in `x`: small against every bend, large against rounding.
const STEP: f64 = 1e-3;

/// A fit.
pub(super) struct Fit<'a> {
    pub model: &'a Model,
    pub effects: &'a [EffectEntry],
    pub parameters: Vec<Parameter>,
    pub train: &'a [Recording],
    pub settings: &'a Settings,
}

/// Score with its derivatives.
pub(super) struct Slope {
    pub nats: f64,
    pub gradient: DVector<f64>,
    pub information: DMatrix<f64>,
}

impl Fit<'_> {
    /// Whether a parameter is a gap, which no step moves.
    pub fn is_gap(&self, parameter: usize) -> bool {
        matches!(self.parameters[parameter].kind, Kind::Gap(_))
    }

    /// Whether a parameter is a gap, or says how a gap varies: where flanks are met, the score bends less than the derivative of the prediction says.
    pub fn shapes_gap(&self, parameter: usize) -> bool {
        match &self.parameters[parameter].kind {
            Kind::Effect(effect, _) => self.effects[*effect].effect == UNEVEN_GAP,
            _ => self.is_gap(parameter),
        }
    }

    /// The setup at `x`.
    pub fn setup(&self, x: &[f64]) -> Setup {
        parameters::setup(self.model, self.effects, &self.parameters, x)
    }

    /// `½ Σ ρ x²` [nat].
    pub fn prior(&self, x: &[f64]) -> f64 {
        self.parameters.iter().zip(x).map(|(parameter, x)| 0.5 * parameter.precision * x * x).sum()
    }

    /// Runs along the training recordings.
    fn runs(&self, x: &[f64], lambda: &[f64], sloped: bool, train: &[Recording]) -> Result<Vec<Outcome>> {
        let setup = self.setup(x);
        let shadows: Vec<(Setup, f64)> = match sloped {
            true => (0..x.len()).map(|index| self.shadow(x, index)).collect(),
            false => Vec::new(),
        };
        let run = |recording: &Recording| -> Result<Outcome> {
            let subject = |setup: &Setup| Subject::new(setup, recording, self.settings);
            let shadow = |(setup, step): &(Setup, f64)| -> Result<Shadow> {
                Ok(Shadow { subject: subject(setup)?, step: *step })
            };
            let shadows = shadows.iter().map(shadow).collect::<Result<_>>()?;
            let pair = [subject(&setup)?, subject(&setup)?];
            Ok(Run::new(recording, self.settings, pair, shadows, lambda).go(false))
        };
        train.par_iter().map(run).collect()
    }

    /// The setup with one parameter a step away, inside its limits.
    fn shadow(&self, x: &[f64], index: usize) -> (Setup, f64) {
        let mut moved = x.to_vec();
        let parameter = &self.parameters[index];
        let step = if parameter.value(x[index] + STEP) == parameter.value(x[index]) { -STEP } else { STEP };
        moved[index] += step;
        (self.setup(&moved), step)
    }

    /// [nat] of each joint.
    pub fn nats(&self, x: &[f64], lambda: &[f64]) -> Result<Vec<f64>> {
        let runs = self.runs(x, lambda, false, self.train)?;
        Ok((0..lambda.len()).map(|joint| runs.iter().map(|run| run.nats[joint]).sum()).collect())
    }

    /// The score of these recordings with its derivatives.
    pub fn slope(&self, x: &[f64], lambda: &[f64], train: &[Recording]) -> Result<Slope> {
        let runs = self.runs(x, lambda, true, train)?;
        let size = x.len();
        let mut slope = Slope { nats: 0.0, gradient: DVector::zeros(size), information: DMatrix::zeros(size, size) };
        for mut run in runs {
            slope.nats += run.nats.iter().sum::<f64>();
            run.information.fill_upper_triangle_with_lower_triangle();
            slope.gradient += run.gradient;
            slope.information += run.information;
        }
        Ok(slope)
    }

    /// [nat] Score and prior together.
    pub fn height(&self, x: &[f64], lambda: &[f64]) -> f64 {
        self.nats(x, lambda).map_or(f64::NEG_INFINITY, |nats| nats.iter().sum::<f64>() - self.prior(x))
    }
}
