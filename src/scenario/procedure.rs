//! Carries out the procedure of a scenario on its recordings, and compares what it finds with what is expected.

use std::path::Path;

use super::{Findings, Keep, Run, Scenario, Tracking};
use crate::dataset;
use crate::effects::{self, Catalogue};
use crate::error::{Error, Result};
use crate::identify::{self, Identification, Options};
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// What is done with the data of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Procedure {
    /// Nothing.
    None,
    /// Friction and backlash are identified.
    Identify,
    /// The nominal machine is compared with the data.
    Diagnose,
    /// Friction and backlash are identified, and a motion is tracked with and without their compensation.
    Compensate,
}

impl Procedure {
    /// Which signals of a run are kept for it; `written`: the recordings are to be written as well. No procedure sees the truth.
    pub fn keep(self, written: bool) -> Keep {
        if self == Self::None && !written { Keep::Nothing } else { Keep::Measured }
    }
}

/// What a procedure finds.
#[derive(Debug)]
pub enum Found {
    /// Nothing was looked for.
    Nothing,
    /// Friction and gaps.
    Identified(Box<Identified>),
    /// Friction and gaps, and tracking with and without their compensation.
    Compensated(Box<Compensated>),
    /// What the nominal model gets wrong; then friction and gaps with the cause in the model, or why there are none.
    Diagnosed(Box<Findings>, Result<Box<Identified>>),
}

/// Friction and gaps, with the injected values beside them.
#[derive(Debug)]
pub struct Identified {
    /// What was identified.
    pub found: Identification,
    /// The model with the identified values.
    pub model: Model,
}

/// Friction and gaps, and tracking with their compensation.
#[derive(Debug)]
pub struct Compensated {
    /// What was identified.
    pub identified: Identified,
    /// How the motion was tracked.
    pub tracking: Tracking,
}

/// What a procedure finds, and the expectations that failed.
#[derive(Debug)]
pub struct Conclusion {
    /// What it finds.
    pub found: Found,
    /// One sentence for each expectation that failed.
    pub unmet: Vec<String>,
}

impl Scenario {
    /// Carries out the procedure on a run; `show` receives the present step and the share of it that is done.
    ///
    /// # Errors
    /// As [`identify::identify`] and [`Findings::new`].
    pub fn carry_out(&self, run: &Run, show: &mut dyn FnMut(&str, f64)) -> Result<Conclusion> {
        let mut conclusion = match self.procedure {
            Procedure::None => Conclusion { found: Found::Nothing, unmet: Vec::new() },
            Procedure::Identify => {
                let identified = self.identify(&self.model, &self.model, run, show)?;
                Conclusion { unmet: self.missed(&identified.found), found: Found::Identified(Box::new(identified)) }
            }
            Procedure::Diagnose => self.diagnose(run, show)?,
            Procedure::Compensate => self.compensate(run, show)?,
        };
        let met = self.contact_expectations.iter().filter_map(|expectation| expectation.check(run));
        conclusion.unmet.extend(met.map(|unmet| unmet.to_string()));
        Ok(conclusion)
    }

    /// Identifies friction and gaps with the `trusted` model, and writes the injected values beside them; `base` is the model that
    /// receives the result.
    fn identify(
        &self,
        trusted: &Model,
        base: &Model,
        run: &Run,
        show: &mut dyn FnMut(&str, f64),
    ) -> Result<Identified> {
        show("identifying", 0.0);
        let mut found = identify::identify(trusted, &run.sessions, &Options::default())?;
        self.truth.compare(&mut found);
        let model = found.apply(base);
        Ok(Identified { found, model })
    }

    /// Friction and gaps, and the planned motion tracked with their compensation.
    fn compensate(&self, run: &Run, show: &mut dyn FnMut(&str, f64)) -> Result<Conclusion> {
        let identified = self.identify(&self.model, &self.model, run, show)?;
        let mut unmet = self.missed(&identified.found);
        let Some(plan) = &self.tracking else {
            return Ok(Conclusion { unmet, found: Found::Identified(Box::new(identified)) });
        };
        show("tracking", 0.0);
        let tracking = self.track(plan, &identified.model, run.seed)?;
        let missed = self.tracking_expectations.iter().filter_map(|expectation| expectation.check(&tracking));
        unmet.extend(missed.map(|missed| missed.to_string()));
        Ok(Conclusion { unmet, found: Found::Compensated(Box::new(Compensated { identified, tracking })) })
    }

    /// The nominal machine compared with what was measured; then friction and gap, with the cause in the model that the
    /// identification trusts. A finished diagnosis is kept even if the identification fails.
    fn diagnose(&self, run: &Run, show: &mut dyn FnMut(&str, f64)) -> Result<Conclusion> {
        let recordings = run.sessions.iter().map(|series| recording(series, &self.source)).collect();
        let findings = Findings::new(&self.model, recordings, Vec::new(), show)?;
        let extended = &findings.diagnosis.extended_model;
        let identified = effects::applied(extended, &Catalogue::default())
            .and_then(|trusted| self.identify(&trusted.model, extended, run, show));
        let named = self.diagnosis_expectation.check(&findings.diagnosis);
        let mut unmet: Vec<String> = named.iter().map(ToString::to_string).collect();
        match &identified {
            Ok(identified) => unmet.extend(self.missed(&identified.found)),
            Err(why) if !self.expectations.is_empty() => {
                unmet.push(format!("friction and gap were expected and not identified: {why}"));
            }
            Err(_) => {}
        }
        Ok(Conclusion { found: Found::Diagnosed(Box::new(findings), identified.map(Box::new)), unmet })
    }

    /// The expectations that an identification misses, one sentence each.
    fn missed(&self, found: &Identification) -> Vec<String> {
        self.expectations.iter().filter_map(|expectation| Some(expectation.check(found)?.to_string())).collect()
    }

    /// Whether an identification may fail for this reason: where no motion is steady, no friction law can be identified, and a
    /// diagnosis does not need one, unless the scenario expects something of it.
    pub fn allows(&self, why: &Error) -> bool {
        matches!(why, Error::TooLittleData { .. }) && self.expectations.is_empty()
    }
}

/// A simulated recording, as if it had been read from a file.
fn recording(series: &TimeSeries, source: &Path) -> dataset::Session {
    let controllers = vec![None; series.joints.len()];
    dataset::Session { series: series.clone(), notes: Vec::new(), source: source.to_owned(), controllers }
}
