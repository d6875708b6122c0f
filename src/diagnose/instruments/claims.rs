//! From phenomena to effects: which effect of the catalogue claims what an instrument has measured.

use crate::diagnose::result::{EffectGain, Findings, FoundEffect, Measured, Standing, Unexplained};
use crate::diagnose::select::confirm::part;
use crate::effects::{Catalogue, Phenomenon};
use crate::robot::Model;

/// A phenomenon that an instrument has measured, with its evidence.
pub struct Sighting {
    /// What was measured.
    pub phenomenon: Phenomenon,
    /// Joints of the model that show it.
    pub joints: Vec<usize>,
    /// Probability that it is there, 0 to 1.
    pub probability: f64,
    /// [nats] Evidence for it in the training data.
    pub evidence_nats: f64,
    /// What its correction gains on data held out; `None` where nothing held out could confirm it.
    pub gain: Option<EffectGain>,
    /// What is reported where no effect claims it.
    pub words: String,
}

/// The effects that claim these phenomena. What no effect claims is unexplained where its correction gains on data held out; so is what nothing
/// held out could confirm.
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
