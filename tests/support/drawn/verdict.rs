//! The program's answer to a set, beside what was hidden.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

use lostmotion::dataset;
use lostmotion::diagnose::{self, Diagnosis, FitError, FoundEffect, Options, Split};
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
    /// What was chosen and withdrawn again, with the reason.
    pub withdrawn: Vec<String>,
    /// Torque errors of nominal and extended model.
    pub fit: Vec<FitError>,
    /// [s] that the diagnosis took.
    pub seconds: f64,
}

/// What was hidden on one joint, or in the machine.
#[derive(Debug, Clone)]
pub struct Hidden {
    pub effect: String,
    pub joint: Option<String>,
    pub parameters: BTreeMap<String, f64>,
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
        self.effects.iter().all(|effect| self.names(effect))
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
                format!("{} {} ({:.2}{listed})", found.effect, found.joints.join("+"), found.probability)
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
        let unexplained = if self.unexplained.is_empty() {
            String::new()
        } else {
            format!("; something unexplained ({})", self.unexplained.join("; "))
        };
        let withdrawn = if self.withdrawn.is_empty() {
            String::new()
        } else {
            format!("; withdrawn ({})", self.withdrawn.join("; "))
        };
        format!(
            "{mark} {}: hidden {}; named {}{unexplained}{withdrawn}; {}; {}; {:.1} s",
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
    let Diagnosis { effects: found, unexplained, withdrawn, mistakes, fit, .. } = diagnosed(set, options);
    let seconds = start.elapsed().as_secs_f64();
    let unexplained = unexplained.into_iter().map(|one| format!("{}: {}", one.joint, one.pattern)).collect();
    let withdrawn = withdrawn.into_iter().map(|one| format!("{} {}: {}", one.effect, one.joints.join("+"), one.reason));
    let withdrawn = withdrawn.chain(mistakes.iter().map(|one| one.sentence())).collect();
    let (effects, hidden) = truth(&set.truth);
    Verdict { name: name.to_owned(), effects, hidden, found, unexplained, withdrawn, fit, seconds }
}

fn diagnosed(set: &Set, options: &Options) -> Diagnosis {
    let model = Model::load(&set.model).expect("the nominal model");
    let read = |file: &Path| dataset::load(file, &dataset::joints_of(&model)).expect("a recording").series;
    let train: Vec<TimeSeries> = set.data.iter().map(|file| read(file)).collect();
    let hold_out = [read(&set.hold_out)];
    diagnose::diagnose(&model, &train, &hold_out, options, &mut |_, _| {}).expect("a diagnosis")
}

/// What was hidden: names, and an entry a joint.
pub fn truth(file: &Path) -> (Vec<String>, Vec<Hidden>) {
    let text = std::fs::read_to_string(file).expect("the truth");
    let truth: serde_json::Value = serde_json::from_str(&text).expect("the truth is JSON");
    let list = |key: &str| truth[key].as_array().expect("a list").clone();
    let text = |value: &serde_json::Value| value.as_str().map(str::to_owned);
    let hidden = |entry: &serde_json::Value| Hidden {
        effect: text(&entry["effect"]).expect("a name"),
        joint: text(&entry["joint"]),
        parameters: serde_json::from_value(entry["parameters"].clone()).expect("parameters"),
    };
    (list("effects").iter().filter_map(text).collect(), list("entries").iter().map(hidden).collect())
}
