//! Links with another inertia than the nominal one, as findings.

use super::Data;
use crate::diagnose::evidence::probability::{calibrated, odds_against};
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::uncertainty::Uncertainty;
use crate::diagnose::instruments::claims::{Sighting, claimed};
use crate::diagnose::options::Options;
use crate::diagnose::result::Findings;
use crate::diagnose::select::links::OtherLink;
use crate::effects::Phenomenon;
use crate::timeseries::Estimate;

/// The effects that claim them.
pub fn findings(data: &Data, problem: &Problem, uncertainty: &Uncertainty, options: &Options) -> Findings {
    let sightings = data.other_links.iter().filter_map(|link| sighting(problem, uncertainty, link, options));
    claimed(data.model, &options.catalogue, sightings.collect())
}

fn sighting(problem: &Problem, uncertainty: &Uncertainty, link: &OtherLink, options: &Options) -> Option<Sighting> {
    let body = link.surprise.body;
    let changes = problem.changes_of(body)?;
    let values = &changes * problem.held()?;
    let estimate = |number: usize| {
        let gradient: Vec<(usize, f64)> =
            changes.row(number).iter().enumerate().map(|(k, slope)| (uncertainty.deviations_at + k, *slope)).collect();
        Estimate { value: values[number], std_error: uncertainty.std_error(&gradient) }
    };
    let name = &problem.motion.model.joints[body].name;
    // One nat of evidence in ten is lost to laws that are only nearly right, as with other effects.
    let nats = link.surprise.nats;
    let probability = calibrated(odds_against(nats, options.rules.nats, 0.1 * nats + 3.0));
    Some(Sighting {
        phenomenon: Phenomenon::OtherLink { difference: std::array::from_fn(estimate) },
        joints: vec![body],
        probability,
        evidence_nats: nats,
        gain: Some(link.gain.clone()),
        words: format!("the link of {name} is not as accurate as the model states"),
    })
}
