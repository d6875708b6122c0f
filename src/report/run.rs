//! A scenario that was run, for readers: results of its procedure, contacts, and expectations that failed.

use serde_json::{Value, json};

use super::contacts;
use super::diagnosis;
use super::document::Document;
use super::files::{self, Content, File, envelope};
use super::identification;
use super::paper_figures;
use super::recording::Motion;
use super::svg;
use super::tracking;
use super::{Report, Section};
use crate::dataset;
use crate::files::is_fit_name;
use crate::robot::JointModel;
use crate::scenario::{Compensated, Conclusion, Findings, Found, Identified, Procedure, Recorded, Run, Scenario};
use crate::timeseries::{Drawn, TimeSeries};

/// The report of a simulated scenario; `drawn` is how its sessions are shown.
pub fn report<'a>(
    scenario: &'a Scenario,
    seed: u64,
    run: &Run,
    conclusion: &Conclusion,
    drawn: Vec<Drawn>,
) -> Report<'a> {
    let mut report = match &conclusion.found {
        Found::Nothing => simulated(scenario, drawn),
        Found::Identified(identified) => identified_report(scenario, identified, drawn),
        Found::Compensated(compensated) => compensated_report(scenario, compensated, drawn),
        Found::Diagnosed(findings, identified) => {
            let mut report = match identified {
                Ok(identified) => joined(identified_report(scenario, identified, drawn), findings, &scenario.name),
                Err(why) => {
                    let report = diagnosed(scenario, findings, drawn);
                    if scenario.allows(why) { report } else { warned(report, &why.to_string()) }
                }
            };
            for motion in &mut report.motions {
                motion.traces = diagnosis::traces(&findings.diagnosis, &motion.session.name);
            }
            report
        }
    };
    note_contacts(&mut report, scenario, run);
    if let Value::Object(content) = &mut report.json {
        content.insert("seed".into(), seed.into());
        content.insert("failed_expectations".into(), conclusion.unmet.clone().into());
    }
    if !scenario.question.is_empty() {
        report.document.title = format!("{}: {}", scenario.name, scenario.question);
    }
    report
}

/// The report of a scenario on recordings.
pub fn of_recordings<'a>(
    scenario: &Recorded,
    findings: &'a Findings,
    unmet: &[String],
    drawn: Vec<Drawn>,
) -> Report<'a> {
    let mut report = diagnosis::report(findings, &scenario.name, drawn);
    report.document.title = format!("{}: {}", scenario.name, scenario.question);
    if let Value::Object(content) = &mut report.json {
        content.insert("failed_expectations".into(), unmet.into());
    }
    report
}

/// The report of a run that was only simulated.
fn simulated(scenario: &Scenario, drawn: Vec<Drawn>) -> Report<'_> {
    let mut document = Document { title: scenario.name.clone(), ..Document::default() };
    let seconds: f64 = scenario.sessions.iter().map(|session| session.duration).sum();
    document.verdict = format!("{} simulated for {seconds:.1} s.", scenario.model.name);
    let motions = drawn.into_iter().map(|session| Motion::new(&scenario.model.robot, session)).collect();
    let json = envelope("lostmotion/run/1", &scenario.name, json!({}));
    Report { document, json, motions, model: None, extra: Vec::new() }
}

fn identified_report<'a>(scenario: &'a Scenario, identified: &Identified, drawn: Vec<Drawn>) -> Report<'a> {
    let Identified { found, model } = identified;
    let report = identification::report(&scenario.name, found, Some(&scenario.truth), &scenario.model, drawn);
    Report { model: Some(model.clone()), ..report }
}

/// The report of an identification with the tracking that uses it: the tracking first, then what it used.
fn compensated_report<'a>(scenario: &'a Scenario, compensated: &Compensated, drawn: Vec<Drawn>) -> Report<'a> {
    let Compensated { identified, tracking } = compensated;
    let mut report = identified_report(scenario, identified, drawn);
    let runs = tracking.drawn.iter().cloned();
    report.motions.extend(runs.map(|session| Motion::new(&scenario.model.robot, session)));
    report.document.verdict = format!("{}\n{}", tracking::verdict(tracking), report.document.verdict);
    report.document.sections.insert(0, tracking::section(tracking));
    report.json["tracking"] = json!({ "joints": tracking::json(tracking) });
    let pictures = report.document.plots().filter_map(|(_, plot)| {
        let name = picture_name(&plot.file)?;
        Some((name, Content::from(svg::draw(plot))))
    });
    report.extra = pictures.collect();
    report
}

/// The report of a diagnosis alone.
fn diagnosed<'a>(scenario: &'a Scenario, findings: &Findings, drawn: Vec<Drawn>) -> Report<'a> {
    let Report { json, document, model, .. } = diagnosis::report(findings, &scenario.name, Vec::new());
    Report { json, document, model, ..simulated(scenario, drawn) }
}

fn warned<'a>(mut report: Report<'a>, why: &str) -> Report<'a> {
    report.document.warnings.push(format!("friction and gap were not identified: {why}"));
    report
}

/// The report of an identification with the diagnosis that came before it: the diagnosis first, friction before its details.
fn joined<'a>(mut report: Report<'a>, findings: &Findings, name: &str) -> Report<'a> {
    let diagnosis = diagnosis::report(findings, name, Vec::new());
    let joints = std::mem::take(&mut report.json["joints"]);
    report.json = diagnosis.json;
    report.json["identification"] = json!({ "joints": joints });
    let friction = std::mem::replace(&mut report.document, diagnosis.document);
    report.document.verdict += &format!("\n{}", friction.verdict);
    let sections: &mut Vec<Section> = &mut report.document.sections;
    let at = sections.iter().position(|section| section.detail).unwrap_or(sections.len());
    sections.splice(at..at, friction.sections);
    report
}

/// Adds the contacts to the report and its recording.
fn note_contacts<'a>(report: &mut Report<'a>, scenario: &'a Scenario, run: &Run) {
    for ((motion, session), touched) in report.motions.iter_mut().zip(&run.sessions).zip(&run.contacts) {
        motion.obstacles = &scenario.options.obstacles;
        contacts::trace(motion, &session.time, touched);
    }
    if let Some(section) = contacts::section(run) {
        report.document.sections.insert(0, section);
        report.json["contacts"] = contacts::json(run).into();
    }
}

/// Names of the files that the report of a scenario may hold; `recordings`: those of its sessions as well.
pub fn planned(scenario: &Scenario, recordings: bool) -> Vec<String> {
    let model = Some(&scenario.model).filter(|_| scenario.procedure != Procedure::None);
    let sessions = scenario.sessions.iter().filter(|_| recordings).map(|session| csv_name(&session.name));
    let joints = scenario.model.joints.iter().filter(|_| scenario.procedure == Procedure::Compensate);
    let figures = |joint: &JointModel| {
        paper_figures::files(&joint.name).into_iter().chain([tracking::file(&joint.name)]).collect::<Vec<_>>()
    };
    let pictures = joints.flat_map(figures).filter_map(|figure| picture_name(&figure));
    files::planned(model, sessions.chain(pictures))
}

/// Name of the file of a picture; none where the joint's name fits no file.
fn picture_name(figure: &str) -> Option<String> {
    let name = format!("{figure}.svg");
    (!figure.is_empty() && is_fit_name(&name)).then_some(name)
}

/// Name of the file of a session.
fn csv_name(session: &str) -> String {
    format!("{session}.csv")
}

/// Name and content of a session as its machine would have recorded it.
pub fn csv<'a>(scenario: &Scenario, session: &'a TimeSeries) -> File<'a> {
    let kinds: Vec<_> = scenario.model.joints.iter().map(|joint| joint.kind).collect();
    let rows = Content::Stream(Box::new(move |out| dataset::write_csv_rows(out, session, &kinds)));
    (csv_name(&session.name), rows)
}
