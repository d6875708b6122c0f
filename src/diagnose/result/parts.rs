//! The parts of a diagnosis, and the one place that assembles them.

use std::collections::BTreeMap;

use super::{
    BaselineEstimate, CandidateRecord, Change, Diagnosis, Findings, FitError, FrequencySpectrum, JointShares, Method,
    Mistake, OrderSpectrum, ResidualMap, ResidualSeries, TwoEncoders, Verdict,
};
use crate::effects::Catalogue;
use crate::robot::Model;

/// The parts of a diagnosis; the fields correspond to those of [`Diagnosis`].
pub struct Parts {
    /// Suspected mistakes, which end the diagnosis.
    pub mistakes: Vec<Mistake>,
    /// What is named, withdrawn, or unexplained.
    pub findings: Findings,
    /// Quantities that differ between two recordings, where two are compared.
    pub changes: Option<Vec<Change>>,
    /// Errors of the nominal and the extended model.
    pub fit: Vec<FitError>,
    /// Free parameters of the nominal model.
    pub baseline: BTreeMap<String, BaselineEstimate>,
    /// Results of second encoders.
    pub two_encoders: Vec<TwoEncoders>,
    /// Every candidate.
    pub candidates: Vec<CandidateRecord>,
    /// How the data were processed.
    pub method: Method,
    /// Where the error of the nominal model lies.
    pub shares: Vec<JointShares>,
    /// Maps of the residual.
    pub maps: Vec<ResidualMap>,
    /// Spectra against the order of the motor angle.
    pub order_spectrum: Vec<OrderSpectrum>,
    /// Spectra against frequency.
    pub frequency_spectrum: Vec<FrequencySpectrum>,
    /// The nominal model with baseline and effects.
    pub extended_model: Model,
    /// The nominal model with the baseline.
    pub baseline_model: Model,
    /// The catalogue of effects that could be named.
    pub catalogue: Catalogue,
    /// Residuals sample by sample.
    pub series: Vec<ResidualSeries>,
}

impl Parts {
    /// The parts for an unchanged model: nothing fitted, nothing found.
    pub fn new(model: &Model, method: Method, catalogue: &Catalogue) -> Self {
        Self {
            mistakes: Vec::new(),
            findings: Findings::default(),
            changes: None,
            fit: Vec::new(),
            baseline: BTreeMap::new(),
            two_encoders: Vec::new(),
            candidates: Vec::new(),
            method,
            shares: Vec::new(),
            maps: Vec::new(),
            order_spectrum: Vec::new(),
            frequency_spectrum: Vec::new(),
            extended_model: model.clone(),
            baseline_model: model.clone(),
            catalogue: catalogue.clone(),
            series: Vec::new(),
        }
    }

    /// Assembles the diagnosis. If a mistake is suspected, no effect is named and the extended model equals the baseline model.
    pub fn assembled(mut self) -> Diagnosis {
        let suspected = !self.mistakes.is_empty();
        if suspected {
            self.findings.effects.clear();
            self.changes = self.changes.map(|_| Vec::new());
            self.extended_model.clone_from(&self.baseline_model);
        }
        let Findings { effects, withdrawn, unexplained } = self.findings;
        let changed = self.changes.as_ref().is_some_and(|changes| !changes.is_empty());
        let verdict = match suspected {
            true => Verdict::MistakeSuspected,
            false => Verdict::of(changed || !effects.is_empty(), !unexplained.is_empty()),
        };
        Diagnosis {
            schema: Diagnosis::SCHEMA,
            versions: BTreeMap::from([
                ("lostmotion", env!("CARGO_PKG_VERSION")),
                ("rapier3d", crate::plant::RAPIER_VERSION),
            ]),
            verdict,
            mistakes: self.mistakes,
            dead_channels: Vec::new(),
            effects,
            changes: self.changes,
            fit: self.fit,
            replay: Vec::new(),
            predictions: Vec::new(),
            baseline: self.baseline,
            two_encoders: self.two_encoders,
            unexplained,
            judgement: None,
            withdrawn,
            candidates: self.candidates,
            method: self.method,
            shares: self.shares,
            maps: self.maps,
            order_spectrum: self.order_spectrum,
            frequency_spectrum: self.frequency_spectrum,
            extended_model: self.extended_model,
            baseline_model: self.baseline_model,
            catalogue: self.catalogue,
            series: self.series,
        }
    }
}
