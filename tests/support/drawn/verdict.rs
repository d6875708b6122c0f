//! The program's answer to a set, beside what was hidden.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

use lostmotion::dataset;
use lostmotion::diagnose::{self, Diagnosis, FitError, FoundEffect, Measured, Options, Split, Withdrawn};
use lostmotion::error::Result;
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;

use super::generate::Set;

/// Parameters that say how an effect fades or is damped, not how large or where it is: their error counts for nothing.
const SECONDARY: [&str; 4] = ["damping", "duration", "side", "slip_distance"];
/// Standard errors to either side of a value within which 95 % of a normal variable lie.
const INTERVAL: f64 = 1.96;

/// One set: what was hidden, what was named.
#[derive(Debug)]
pub struct Verdict {
    /// Name of the set.
    pub name: String,
    /// Names of what was hidden; empty: nothing.
    pub effects: Vec<String>,
    /// Effect, joint and parameters, one entry a joint.
    pub hidden: Vec<Hidden>,
    /// The effects named, strongest first.
    pub found: Vec<FoundEffect>,
    /// Patterns that no effect explains.
    pub unexplained: Vec<String>,
    /// Suspected mistakes of data or model file.
    pub mistakes: Vec<String>,
    /// What was chosen and withdrawn again, with the reason.
    pub withdrawn: Vec<String>,
    /// The gaps of the joints, and what was measured of them.
    pub gaps: Vec<Gap>,
    /// Torque errors of nominal and extended model.
    pub fit: Vec<FitError>,
    /// [s] that the diagnosis took.
    pub seconds: f64,
    /// How the set was sampled, where that was drawn.
    pub sampling: Option<String>,
    /// The error or the panic of a run that ended without a report.
    pub failure: Option<String>,
}

/// What was hidden on one joint, or in the machine.
#[derive(Debug, Clone)]
pub struct Hidden {
    pub effect: String,
    pub joint: Option<String>,
    pub parameters: BTreeMap<String, f64>,
}

/// The gap of a joint that the nominal model does not give.
#[derive(Debug, Clone)]
pub struct Gap {
    pub joint: String,
    /// [rad]
    pub truth: f64,
    pub measured: Option<Measured>,
}

impl Gap {
    /// As it stands in the log [mrad], with a mark where the truth lies outside the interval.
    fn text(&self) -> String {
        let of = format!("{} of {:.3}", self.joint, 1e3 * self.truth);
        let Some(gap) = &self.measured else { return format!("{of} not measured") };
        let mark = if self.is_inside() == Some(true) { "" } else { "!" };
        format!("{mark}{of}: {:.3} ± {:.3}", 1e3 * gap.value, 1e3 * gap.std_error)
    }

    /// Whether the truth lies in the 95 % interval of what was measured.
    pub fn is_inside(&self) -> Option<bool> {
        self.measured.as_ref().map(|gap| (gap.value - self.truth).abs() <= INTERVAL * gap.std_error)
    }
}

/// A parameter of what was hidden, as it was estimated.
#[derive(Debug, Clone)]
pub struct Size {
    /// `joint.parameter`.
    pub name: String,
    pub truth: f64,
    pub value: f64,
    pub std_error: f64,
}

impl Size {
    /// Whether the truth lies in the 95 % interval; phases are taken modulo a turn.
    pub fn is_inside(&self) -> bool {
        let mut error = (self.value - self.truth).abs();
        if self.name.ends_with("phase") || self.name.ends_with("azimuth") {
            error = (error % TAU).min(TAU - error % TAU);
        }
        // A whole number is given without an error.
        error <= (INTERVAL * self.std_error).max(1e-9 * self.truth.abs())
    }
}

impl Verdict {
    /// Whether what was hidden and nothing else was named; where nothing was hidden, that nothing was named.
    pub fn is_right(&self) -> bool {
        self.failure.is_none()
            && self.effects.iter().all(|effect| self.names(effect))
            && self.found.iter().all(|found| self.effects.contains(&found.effect))
    }

    /// Whether the strongest effect named is one that was hidden.
    pub fn is_first(&self) -> bool {
        self.found.first().is_some_and(|found| self.effects.contains(&found.effect))
    }

    /// Whether an effect is among those named.
    pub fn names(&self, effect: &str) -> bool {
        self.found.iter().any(|found| found.effect == effect)
    }

    /// Parameters of what was hidden and named on the same joint.
    pub fn sizes(&self) -> Vec<Size> {
        let mut sizes = Vec::new();
        for hidden in &self.hidden {
            let same = |found: &&FoundEffect| {
                found.effect == hidden.effect && hidden.joint.as_ref().is_none_or(|joint| found.joints.contains(joint))
            };
            let Some(found) = self.found.iter().find(same) else { continue };
            for (name, truth) in hidden.parameters.iter().filter(|(name, _)| !SECONDARY.contains(&name.as_str())) {
                let Some(measured) = found.parameters.get(name) else { continue };
                let name = hidden.joint.as_ref().map_or(name.clone(), |joint| format!("{joint}.{name}"));
                sizes.push(Size { name, truth: *truth, value: measured.value, std_error: measured.std_error });
            }
        }
        sizes
    }

    /// One line for the log.
    pub fn line(&self) -> String {
        let hidden: Vec<String> = self
            .effects
            .iter()
            .map(|effect| {
                let on = self.hidden.iter().filter(|entry| entry.effect == *effect);
                let on: Vec<&str> = on.filter_map(|entry| entry.joint.as_deref()).collect();
                format!("{effect} {}", on.join("+"))
            })
            .collect();
        let named: Vec<String> = self
            .found
            .iter()
            .map(|found| {
                let listed = if found.confusable_with.is_empty() {
                    String::new()
                } else {
                    format!(", or {}", found.confusable_with.join(" or "))
                };
                let gain = found.gain.gain_percent;
                format!("{} {} ({:.2}{listed}; {gain:.1} %)", found.effect, found.joints.join("+"), found.probability)
            })
            .collect();
        let sizes: Vec<String> = self
            .sizes()
            .iter()
            .map(|size| {
                let mark = if size.is_inside() { "" } else { "!" };
                format!("{mark}{} {:.4} ± {:.4} of {:.4}", size.name, size.value, size.std_error, size.truth)
            })
            .collect();
        let held_out = self.fit.iter().filter(|error| error.split == Split::HeldOut);
        let errors: Vec<String> =
            held_out.map(|fit| format!("{:.1} → {:.1} m{}", 1e3 * fit.before, 1e3 * fit.after, fit.unit)).collect();
        let or_nothing = |list: Vec<String>| if list.is_empty() { "nothing".to_owned() } else { list.join(", ") };
        let mark = match (self.is_right(), self.is_first()) {
            (true, _) => "ok   ",
            (false, true) => "FIRST",
            (false, false) => "WRONG",
        };
        let list = |what: &str, list: &[String]| {
            if list.is_empty() { String::new() } else { format!("; {what} ({})", list.join("; ")) }
        };
        let unexplained = list("something unexplained", &self.unexplained);
        let mistakes = list("mistakes", &self.mistakes);
        let withdrawn = list("withdrawn", &self.withdrawn);
        let failure = list("NO REPORT", self.failure.as_slice());
        let sampling = list("sampled", self.sampling.as_slice());
        let gaps = list("gaps", &self.gaps.iter().map(Gap::text).collect::<Vec<_>>());
        format!(
            "{mark} {}: hidden {}; named {}{unexplained}{mistakes}{withdrawn}{failure}; {}; {}{gaps}; {:.1} s{sampling}",
            self.name,
            or_nothing(hidden),
            or_nothing(named),
            sizes.join(", "),
            errors.join(", "),
            self.seconds
        )
    }
}

/// Diagnoses a set. The program is given nothing but the nominal model and the data.
pub fn verdict(name: &str, set: &Set, options: &Options) -> Verdict {
    let start = Instant::now();
    let diagnosed = catch_unwind(AssertUnwindSafe(|| diagnosed(set, options)));
    let seconds = start.elapsed().as_secs_f64();
    let Truth { effects, hidden, gaps, sampling } = truth(&set.truth);
    let mut verdict = Verdict {
        name: name.to_owned(),
        effects,
        hidden,
        found: Vec::new(),
        unexplained: Vec::new(),
        mistakes: Vec::new(),
        gaps,
        withdrawn: Vec::new(),
        fit: Vec::new(),
        seconds,
        sampling,
        failure: None,
    };
    match diagnosed {
        Ok(Ok(found)) => verdict.take(found),
        Ok(Err(error)) => verdict.failure = Some(format!("error: {error}")),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without a message");
            verdict.failure = Some(format!("panic: {text}"));
        }
    }
    verdict
}

impl Verdict {
    fn take(&mut self, found: Diagnosis) {
        let Diagnosis { effects, unexplained, withdrawn, mistakes, fit, mut baseline, .. } = found;
        let of_withdrawn = |one: Withdrawn| format!("{} {}: {}", one.effect, one.joints.join("+"), one.reason);
        self.found = effects;
        self.unexplained = unexplained.into_iter().map(|one| format!("{}: {}", one.joint, one.pattern)).collect();
        self.mistakes = mistakes.iter().map(|one| one.sentence()).collect();
        self.withdrawn = withdrawn.into_iter().map(of_withdrawn).collect();
        self.fit = fit;
        for gap in &mut self.gaps {
            gap.measured = baseline.remove(&gap.joint).and_then(|baseline| baseline.backlash);
        }
    }
}

/// Reads model and recordings as the commands do, and diagnoses.
fn diagnosed(set: &Set, options: &Options) -> Result<Diagnosis> {
    let model = Model::load(&set.model)?;
    let read = |file: &PathBuf| dataset::load_for(file, &model);
    let mut sessions = set.data.iter().chain([&set.hold_out]).map(read).collect::<Result<Vec<_>>>()?;
    let model = dataset::meet(&model, &sessions.iter().collect::<Vec<_>>())?;
    let hold_out: Vec<TimeSeries> = sessions.pop().into_iter().map(|session| session.series).collect();
    let train: Vec<TimeSeries> = sessions.into_iter().map(|session| session.series).collect();
    diagnose::diagnose(&model, &train, &hold_out, options, &mut |_, _| {})
}

/// What was hidden in a set.
pub struct Truth {
    /// Names.
    pub effects: Vec<String>,
    /// An entry a joint.
    pub hidden: Vec<Hidden>,
    /// The gaps of the joints, not measured.
    pub gaps: Vec<Gap>,
    /// How it was sampled, where that was drawn.
    pub sampling: Option<String>,
}

/// Reads what was hidden.
pub fn truth(file: &Path) -> Truth {
    let text = std::fs::read_to_string(file).expect("the truth");
    let truth: serde_json::Value = serde_json::from_str(&text).expect("the truth is JSON");
    let list = |key: &str| truth[key].as_array().expect("a list").clone();
    let text = |value: &serde_json::Value| value.as_str().map(str::to_owned);
    let hidden = |entry: &serde_json::Value| Hidden {
        effect: text(&entry["effect"]).expect("a name"),
        joint: text(&entry["joint"]),
        parameters: serde_json::from_value(entry["parameters"].clone()).expect("parameters"),
    };
    let gap = |(joint, gap): (&String, &serde_json::Value)| {
        gap.as_f64().map(|truth| Gap { joint: joint.clone(), truth, measured: None })
    };
    let gaps = truth["gaps"].as_object().into_iter().flatten().filter_map(gap).collect();
    let effects = list("effects").iter().filter_map(text).collect();
    let hidden = list("entries").iter().map(hidden).collect();
    Truth { effects, hidden, gaps, sampling: text(&truth["sampling"]) }
}
