//! From phenomena to effects: the effect of the catalogue that claims a measured phenomenon is named.

use crate::diagnose::result::{EffectGain, Findings, FoundEffect, Measured, Standing, Unexplained};
use crate::diagnose::select::confirm::part;
use crate::effects::{Catalogue, Phenomenon};
use crate::robot::Model;

/// A measured phenomenon with its evidence.
pub struct Sighting {
    /// What was measured.
    pub phenomenon: Phenomenon,
    /// Joints of the model on which it shows.
    pub joints: Vec<usize>,
    /// Probability that it is present, 0 to 1.
    pub probability: f64,
    /// [nats] Evidence for it in the training data.
    pub evidence_nats: f64,
    /// Gain of its correction on held-out data; `None` where there are no held-out data to confirm it.
    pub gain: Option<EffectGain>,
    /// Description for the report if no effect claims it.
    pub words: String,
}

/// The effects that claim these phenomena. A phenomenon without a claim is unexplained if its correction gains on held-out data, or if there
/// are no held-out data to confirm it.
pub fn claimed(model: &Model, catalogue: &Catalogue, sightings: Vec<Sighting>) -> Findings {
    let mut found = Vec::new();
    let mut unexplained = Vec::new();
    for sighting in sightings {
        let joints = sighting.joints.iter().map(|joint| model.joints[*joint].name.clone());
        let claim = catalogue.iter().find_map(|effect| Some((effect.about(), effect.claims(&sighting.phenomenon)?)));
        match (claim, sighting.gain) {
            (Some((about, claim)), Some(gain)) => {
                let kind = model.joints[sighting.joints[0]].kind;
                let measured = claim.into_iter().filter_map(|(name, estimate)| {
                    let spec = about.parameters.iter().find(|spec| spec.name == name)?;
                    Some((name.to_owned(), Measured::of(estimate, spec.unit_for(kind))))
                });
                let Sighting { probability, evidence_nats, .. } = sighting;
                let standing = Standing { probability, evidence_nats, gain };
                found.push(FoundEffect::new(about, joints.collect(), measured.collect(), standing));
            }
            (None, Some(gain)) if !gain.shown() => {}
            _ => unexplained.extend(joints.map(|joint| Unexplained { joint, pattern: sighting.words.clone() })),
        }
    }
    let mut findings = part(found, catalogue);
    findings.unexplained = unexplained;
    findings
}
