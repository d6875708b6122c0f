//! A diagnosis for readers: what was found, with which confidence and gain, and what remains.

use std::collections::BTreeMap;

use serde_json::Value;

use super::Report;
use super::changes;
use super::display::{self, shown};
use super::document::{Document, Section};
use super::files::envelope;
use super::headline;
use super::judgement;
use super::number;
use super::plot::{Layer, Mark, Plot, Role};
use super::prediction;
use super::recording::{Motion, Trace};
use super::shortfall;
use super::table::Table;
use crate::diagnose::{
    BaselineEstimate, Change, Diagnosis, FitError, FoundEffect, ResidualSeries, Split, Verdict, mistakes,
};
use crate::effects;
use crate::error::Error;
use crate::scenario::Findings;
use crate::timeseries::Drawn;
use crate::units::JointKind;

/// The report of a diagnosis: the recordings as they are drawn, with their residuals.
pub fn report<'a>(findings: &'a Findings, name: &str, drawn: Vec<Drawn>) -> Report<'a> {
    let diagnosis = &findings.diagnosis;
    let json = serde_json::to_value(diagnosis).unwrap_or(Value::Null);
    let model = &diagnosis.extended_model;
    let motions = drawn.into_iter().map(|session| {
        let traces = traces(diagnosis, &session.name);
        Motion { traces, ..Motion::new(&model.robot, session) }
    });
    let mut document = document(name, diagnosis);
    let failure = findings.replay_failure.iter();
    document.warnings.extend(failure.map(|why| format!("the models were not replayed beside the data: {why}")));
    let failure = findings.judge_failure.iter();
    document.warnings.extend(failure.map(|why| format!("the simulation did not judge the recordings: {why}")));
    // What stops a replay stops the predictions as well, and is said once.
    let failures = findings.prediction_failures.iter().filter(|_| findings.replay_failure.is_none());
    document.warnings.extend(failures.map(|why| match why {
        Error::Diverged { joint, .. } => {
            format!("{joint} is not predicted, and held on its recorded track while others are: {why}")
        }
        why => format!("the models' predictions were not compared with the data: {why}"),
    }));
    Report {
        document,
        json: envelope(Diagnosis::SCHEMA, name, json),
        motions: motions.collect(),
        model: Some(model.clone()),
        extra: Vec::new(),
    }
}

/// The document of a diagnosis of the machine of that name.
pub fn document(name: &str, diagnosis: &Diagnosis) -> Document {
    if diagnosis.verdict == Verdict::MistakeSuspected && diagnosis.fit.is_empty() {
        return mistaken(name, diagnosis);
    }
    let mut sections: Vec<Section> = diagnosis.changes.as_deref().map(changes::section).into_iter().collect();
    sections.extend([shortfall::section(diagnosis), found(diagnosis)]);
    sections.extend(diagnosis.judgement.as_ref().map(judgement::section));
    sections.push(errors(diagnosis));
    sections.extend(super::two_encoders::section(diagnosis));
    let mut joints: Vec<(&str, JointKind)> = Vec::new();
    for series in &diagnosis.series {
        if !joints.iter().any(|(joint, _)| *joint == series.joint) {
            joints.push((&series.joint, series.kind));
        }
    }
    by_concern(diagnosis, &mut joints, |(joint, _)| joint);
    sections.extend(joints.iter().map(|(joint, kind)| shortfall::multiples(diagnosis, joint, *kind)));
    sections.extend(joints.iter().map(|(joint, kind)| residuals(diagnosis, joint, *kind)));
    let judged = diagnosis.judgement.as_ref().filter(|one| one.not_applied.is_none());
    sections.extend(judged.map(judgement::details));
    sections.push(candidates(diagnosis));
    sections.push(method(diagnosis));
    Document {
        title: match diagnosis.changes {
            Some(_) => format!("{name}: what has changed"),
            None => format!("{name}: what the simulation gets wrong"),
        },
        verdict: verdict(diagnosis),
        warnings: [mistakes::warnings(&diagnosis.mistakes), mistakes::warnings(&diagnosis.dead_channels)].concat(),
        sections,
        in_front: concerned(diagnosis).first().map(ToString::to_string),
    }
}

/// The joints that the result is about, most important first: those that have changed, those of effects, unless an effect concerns the whole
/// machine, and those where something is unexplained.
fn concerned(diagnosis: &Diagnosis) -> Vec<&str> {
    let changed = diagnosis.changes.iter().flatten().map(|change| &change.joint);
    let whole = diagnosis.baseline_model.joints.len();
    let named = diagnosis.effects.iter().filter(|found| found.joints.len() < whole || whole == 1);
    let unexplained = diagnosis.unexplained.iter().map(|one| &one.joint);
    changed.chain(named.flat_map(|found| &found.joints)).chain(unexplained).map(String::as_str).collect()
}

/// Sorts what belongs to joints: those first that the result is about.
pub(super) fn by_concern<T>(diagnosis: &Diagnosis, list: &mut [T], joint: impl Fn(&T) -> &str) {
    let concerned = concerned(diagnosis);
    list.sort_by_key(|one| concerned.iter().position(|name| *name == joint(one)).unwrap_or(concerned.len()));
}

/// The document of a diagnosis that ended with a suspected mistake.
fn mistaken(name: &str, diagnosis: &Diagnosis) -> Document {
    Document {
        title: format!("{name}: a mistake in the data or in the model is suspected"),
        verdict: verdict(diagnosis),
        warnings: mistakes::warnings(&diagnosis.mistakes),
        sections: vec![suspicions(diagnosis)],
        ..Document::default()
    }
}

/// Each mistake, the measurement that shows it, and the remedy.
fn suspicions(diagnosis: &Diagnosis) -> Section {
    let mut table = Table::new("", &["mistake", "joints", "factor", "or", "measured", "remedy"]);
    for one in &diagnosis.mistakes {
        table.row([
            one.mistake.to_owned(),
            one.joints.join(", "),
            one.factor.map_or(String::new(), |factor| number::significant(factor, 3)),
            one.alternatives.join(", "),
            one.evidence.clone(),
            one.remedy.clone(),
        ]);
    }
    let text = "No effect is sought before this is clear: correct the data or the model as proposed, or find out why they are right, and diagnose again.";
    Section { text: vec![text.to_owned()], tables: vec![table], detail: true, ..Section::new("What looks mistaken") }
}

/// The answer in sentences.
fn verdict(diagnosis: &Diagnosis) -> String {
    match diagnosis.verdict {
        Verdict::MistakeSuspected => {
            let list = mistakes::warnings(&diagnosis.mistakes).join("\n");
            format!("A mistake in the data or in the model is likelier than physics; no effect is named.\n{list}")
        }
        Verdict::NothingFound if diagnosis.changes.is_some() => "Nothing has changed.".to_owned(),
        Verdict::NothingFound => match not_judged(diagnosis).as_slice() {
            [] => "Nothing found: the nominal model explains the data.".to_owned(),
            joints => format!("Nothing found on the joints that could be judged. Not judged: {}.", joints.join(", ")),
        },
        Verdict::Unexplained => format!(
            "Structure remains that no effect of the catalogue explains: {}.",
            diagnosis
                .unexplained
                .iter()
                .map(|one| format!("{} ({})", one.joint, one.gist()))
                .collect::<Vec<_>>()
                .join("; ")
        ),
        Verdict::EffectsFound => {
            let mut changes: Vec<String> = diagnosis.changes.iter().flatten().map(changes::sentence).collect();
            let mut effects: Vec<String> =
                diagnosis.effects.iter().map(|found| sentence(found, &diagnosis.fit)).collect();
            let strongest = |nats: &mut dyn Iterator<Item = f64>| nats.fold(0.0, f64::max);
            let of_changes = strongest(&mut diagnosis.changes.iter().flatten().map(Change::evidence_nats));
            if of_changes < strongest(&mut diagnosis.effects.iter().map(|found| found.evidence_nats)) {
                std::mem::swap(&mut changes, &mut effects);
            }
            [changes, effects, headline::gains(diagnosis)].concat().join("\n")
        }
    }
}

/// Joints whose torque was not judged.
fn not_judged(diagnosis: &Diagnosis) -> Vec<&str> {
    let joints = diagnosis.extended_model.joints.iter().map(|joint| joint.name.as_str());
    joints.filter(|joint| !diagnosis.baseline.contains_key(*joint)).collect()
}

/// One effect in a sentence.
fn sentence(found: &FoundEffect, fit: &[FitError]) -> String {
    format!(
        "{} on {} ({}), {:.0} % sure; it lowers the error on data held out by {} ({}).",
        found.effect,
        found.joints.join(", "),
        parameters(found),
        100.0 * found.probability,
        number::part(found.gain.gain_percent),
        headline::quantity(found, fit)
    )
}

fn parameters(found: &FoundEffect) -> String {
    let one = |(name, value): (&String, &crate::diagnose::Measured)| {
        format!("{name} = {}", display::estimate(value.value, value.std_error, value.unit))
    };
    found.parameters.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Effects of the machine, then effects of the measurement, then structure without a name.
fn found(diagnosis: &Diagnosis) -> Section {
    let mut section = Section::new("What was found");
    for (title, kind) in [
        ("In the machine", effects::Kind::Physics),
        ("In the measurement", effects::Kind::Measurement),
        ("In the simulator that made the data", effects::Kind::Simulation),
    ] {
        let mut table = Table::new(title, &["effect", "joints", "parameter", "value", "probability", "gain held out"]);
        for found in diagnosis.effects.iter().filter(|found| found.kind == kind) {
            // An effect on several joints is explained only once.
            let new: Vec<String> =
                about(found, diagnosis).into_iter().filter(|line| !section.text.contains(line)).collect();
            section.text.extend(new);
            rows(found, &mut table);
        }
        if !table.rows.is_empty() {
            section.tables.push(table);
        }
    }
    for (joint, baseline) in &diagnosis.baseline {
        section.text.extend(rising_friction(joint, baseline));
    }
    section.text.extend(gaps_left_out(&diagnosis.baseline));
    section.text.extend(diagnosis.method.left_out.clone());
    section.text.extend(diagnosis.method.listed_effects.clone());
    for withdrawn in &diagnosis.withdrawn {
        let (effect, joints, reason) = (&withdrawn.effect, withdrawn.joints.join(", "), &withdrawn.reason);
        section.text.push(format!("Not named: {effect} on {joints}: {reason}."));
    }
    for unexplained in &diagnosis.unexplained {
        section.text.push(format!("Unexplained on {}: {}", unexplained.joint, unexplained.pattern));
    }
    section
}

/// A note is given if breakaway friction lies below Coulomb friction by more than this number of standard errors.
const SURELY_BELOW: f64 = 3.0;

/// Why gaps were not measured, joints with the same reason together.
fn gaps_left_out(baseline: &BTreeMap<String, BaselineEstimate>) -> Vec<String> {
    let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
    for (joint, estimate) in baseline {
        let Some(reason) = estimate.backlash_left_out.as_deref() else { continue };
        match reasons.iter_mut().find(|(other, _)| *other == reason) {
            Some((_, joints)) => joints.push(joint),
            None => reasons.push((reason, vec![joint])),
        }
    }
    reasons.iter().map(|(reason, joints)| format!("Gap of {}: not determined, {reason}.", joints.join(", "))).collect()
}

/// A note on friction that is less at rest than in motion: the law assumes that friction falls with speed.
fn rising_friction(joint: &str, baseline: &BaselineEstimate) -> Option<String> {
    let (breakaway, coulomb) = (baseline.friction.get("breakaway")?, baseline.friction.get("coulomb")?);
    let error = breakaway.std_error.hypot(coulomb.std_error);
    (coulomb.value - breakaway.value > SURELY_BELOW * error).then(|| {
        let [at_rest, moving] =
            [breakaway, coulomb].map(|one| display::estimate(one.value, one.std_error, one.unit));
        format!(
            "Friction of {joint} rises from {at_rest} at rest to {moving} in slow motion: this is not Stribeck's law, or another effect acts in slow motion. Do not take the figure at rest for a breakaway torque."
        )
    })
}

/// An explanation of an effect, and its look-alikes.
fn about(found: &FoundEffect, diagnosis: &Diagnosis) -> Vec<String> {
    let place = match found.kind {
        effects::Kind::Physics => "the machine",
        effects::Kind::Measurement => "the measurement, not the machine",
        effects::Kind::Simulation => "a simulator that made the data, no machine",
    };
    let summary = diagnosis.catalogue.find(&found.effect).map_or("", |effect| effect.about().summary);
    let mut text = vec![format!("{} ({place}): {summary}", found.effect)];
    if !found.confusable_with.is_empty() {
        let others = found.confusable_with.join(", ");
        text.push(format!(
            "{} looks like {others} in these data. To separate them: {}",
            found.effect, found.separate_by
        ));
    }
    text
}

fn rows(found: &FoundEffect, table: &mut Table) {
    let mut head = [
        found.effect.clone(),
        found.joints.join(", "),
        format!("{:.2}", found.probability),
        number::part(found.gain.gain_percent),
    ];
    for (name, value) in &found.parameters {
        // Only the first row of an effect has its name.
        let [effect, joints, probability, gain] = std::mem::take(&mut head);
        let value = display::estimate(value.value, value.std_error, value.unit);
        table.row([effect, joints, name.clone(), value, probability, gain]);
    }
}

const fn split(split: Split) -> &'static str {
    match split {
        Split::Train => "train",
        Split::HeldOut => "held out",
    }
}

/// Torque errors and replay errors: nominal model against extended model.
fn errors(diagnosis: &Diagnosis) -> Section {
    let mut fit = Table::new(
        "RMS torque error along the measured motion",
        &["joint", "data", "nominal", "extended", "sensor floor", "unit", "nominal", "extended", "gain"],
    );
    for error in &diagnosis.fit {
        fit.row([
            error.joint.clone(),
            split(error.split).to_owned(),
            number::significant(error.before, 3),
            number::significant(error.after, 3),
            number::significant(error.floor, 2),
            error.unit.to_owned(),
            format!("{:.2} %", error.before_percent),
            format!("{:.2} %", error.after_percent),
            headline::gain(error.gain),
        ]);
    }
    let mut replay = Table::new(
        "RMS error of the simulation in closed loop beside the data",
        &["joint", "channel", "data", "nominal", "extended", "unit", "gain"],
    );
    for error in diagnosis.replay.iter().filter(|error| error.horizon.is_none()) {
        let (unit, factor) = shown(error.unit);
        replay.row([
            error.joint.clone(),
            error.quantity.to_owned(),
            split(error.split).to_owned(),
            number::significant(error.before * factor, 3),
            number::significant(error.after * factor, 3),
            unit.to_owned(),
            headline::gain(error.gain),
        ]);
    }
    let text = if diagnosis.effects.is_empty() {
        Vec::new()
    } else {
        vec!["Gains with their 95 % interval, from the scatter between blocks of some seconds; a gain whose interval includes zero is not shown.".to_owned()]
    };
    let tables = [fit, headline::by_effect(diagnosis), prediction::table(diagnosis), replay];
    let tables = tables.into_iter().filter(|table| !table.rows.is_empty()).collect();
    Section { text, tables, plots: prediction::plots(diagnosis), ..Section::new("The gain") }
}

/// Baseline and residual plots of a joint.
fn residuals(diagnosis: &Diagnosis, joint: &str, kind: JointKind) -> Section {
    let mut section = Section { detail: true, ..Section::new(format!("{joint}: baseline and residuals")) };
    if let Some(baseline) = diagnosis.baseline.get(joint) {
        let mut table = Table::new("Baseline as fitted", &["", "value", "unit"]);
        let mut row = |name: &str, found: &crate::diagnose::Measured| {
            let (unit, factor) = shown(found.unit);
            let (value, std_error) = number::with_error(found.value * factor, found.std_error * factor);
            table.row([name.to_owned(), format!("{value} ± {std_error}"), unit.to_owned()]);
        };
        baseline.friction.iter().for_each(|(name, found)| row(name, found));
        baseline.rotor_inertia.iter().for_each(|found| row("rotor_inertia", found));
        baseline.backlash.iter().for_each(|found| row("backlash", found));
        baseline.torque_offset.iter().for_each(|(session, found)| row(&format!("offset, {session}"), found));
        section.tables.push(table);
    }
    let of_joint = |series: &&ResidualSeries| series.joint == joint;
    section.plots.extend(diagnosis.series.iter().filter(of_joint).map(|series| over_time(series, kind)));
    section
}

/// Only rows in which the errors are evaluated; the line is interrupted elsewhere.
fn judged(series: &ResidualSeries, values: &[f64]) -> Vec<[f64; 2]> {
    let rows = series.time.iter().zip(values).zip(&series.rigid);
    rows.map(|((time, value), rigid)| [*time, if *rigid { *value } else { f64::NAN }]).collect()
}

fn over_time(series: &ResidualSeries, kind: JointKind) -> Plot {
    Plot::new(
        format!("{}, {} ({}): torque residual", series.joint, series.session, split(series.split)),
        "time [s]",
        format!("measured − model [{}]", kind.effort_unit()),
    )
    .with(Layer::new("nominal", Mark::Line, Role::Before, judged(series, &series.before)))
    .with(Layer::new("extended", Mark::Line, Role::After, judged(series, &series.after)))
}

fn candidates(diagnosis: &Diagnosis) -> Section {
    let mut table = Table::new("", &["candidate", "joints", "alone gains", "needed", "named", "why"]);
    for candidate in &diagnosis.candidates {
        table.row([
            candidate.effect.clone(),
            candidate.joints.join(", "),
            format!("{:.1} %", candidate.gain_percent),
            format!("{:.1} %", candidate.threshold_percent),
            if candidate.named { "yes" } else { "no" }.to_owned(),
            candidate.reason.clone(),
        ]);
    }
    let tables = if table.rows.is_empty() { Vec::new() } else { vec![table] };
    Section { tables, detail: true, ..Section::new("What was tried") }
}

fn method(diagnosis: &Diagnosis) -> Section {
    let method = &diagnosis.method;
    let [narrow, wide] = method.half_width.map(|width| 1000.0 * width);
    let text = vec![
        format!("Filter: {}, half width {narrow:.0} to {wide:.0} ms.", method.filter),
        format!("Zones: {}", method.zones),
        format!("Baseline: {}", method.baseline),
        format!("Held out: {}", method.held_out),
    ];
    Section { text, detail: true, ..Section::new("How the data were read") }
}

/// Residuals over time for the recording.
pub fn traces(diagnosis: &Diagnosis, session: &str) -> Vec<Trace> {
    let mut traces = prediction::traces(diagnosis, session);
    for series in diagnosis.series.iter().filter(|series| series.session == session) {
        for (label, role, values) in
            [("nominal", Role::Before, &series.before), ("extended", Role::After, &series.after)]
        {
            let shown =
                values.iter().zip(&series.rigid).map(|(value, rigid)| if *rigid { *value } else { 0.0 }).collect();
            let (joint, time) = (series.joint.clone(), series.time.clone());
            traces.push(Trace { joint, panel: "residual", label, role, time, values: shown });
        }
    }
    traces
}
