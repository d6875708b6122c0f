//! `lostmotion design --model M --question "A|B"`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::effects::Catalogue;
use crate::error::Result;
use crate::report::files::{envelope, planned};
use crate::report::{Document, Report, Section, Table};
use crate::robot::Model;
use crate::scenario::{Budget, Design as Designed, Measurands, Question, TriedExperiment, design, measurement};

use super::console::{OutputOptions, Progress};
use super::folder::{Folder, Request};
use super::limits::LimitOptions;
use super::{Outcome, console, input, measured};

/// Design the experiment that separates two causes, or measures friction, backlash or one effect best, as a scenario file
#[derive(Debug, Args)]
pub struct Design {
    /// Model, for effects with friction: a file, or the name of a robot of the catalogue
    #[arg(long, value_name = "MODEL")]
    model: PathBuf,
    /// Two effects of the catalogue with a | between them, or one; or friction, backlash, friction,backlash, with the joints after "of" (friction of joint1,joint2)
    #[arg(long, value_name = "\"A|B\"")]
    question: String,
    /// Longest experiment [s]
    #[arg(long, value_name = "SECONDS", default_value_t = 120.0)]
    budget: f64,
    #[command(flatten)]
    limits: LimitOptions,
    #[command(flatten)]
    output: OutputOptions,
}

impl Design {
    /// Simulates experiments and writes the best one.
    pub fn run(self) -> Result<Outcome> {
        let model = input::model(&self.model)?;
        if let Some(asked) = Measurands::parse(&self.question, &model)? {
            return self.measure(&model, &asked);
        }
        let question = Question::parse(&self.question, &Catalogue::default())?;
        let folder = Folder::reserve(
            self.output.out.as_deref(),
            Request {
                verb: "design",
                name: "design",
                files: planned(Some(&model), ["scenario.toml".to_owned()]),
                inputs: input::files(&model, &[], &[]),
            },
        )?;
        let progress = Progress::start("designing", self.output.quiet);
        let budget = Budget { seconds: self.budget, limits: self.limits.limits() };
        let found = design(&model, &question, budget, &mut |doing, share| progress.show(doing, share))?;
        drop(progress);
        let name = &model.name;
        let mut json = serde_json::to_value(&found).unwrap_or_default();
        json["question"] = json!(question.causes());
        let report = Report {
            document: document(name, &question, &found),
            json: envelope("lostmotion/design/1", name, json),
            motions: Vec::new(),
            model: Some(model.clone()),
            extra: vec![("scenario.toml".to_owned(), found.best.scenario.clone().into())],
        };
        console::finish(&report, &folder, &self.output)
    }

    /// Plans a measurement and writes it, with the references of its recordings.
    fn measure(self, model: &Model, asked: &Measurands) -> Result<Outcome> {
        let progress = Progress::start("planning", self.output.quiet);
        let found = measurement(model, asked, self.budget)?;
        drop(progress);
        let references = found.references.iter().map(|(name, _)| name.clone());
        let names = references.chain(["scenario.toml".to_owned()]);
        let folder = Folder::reserve(
            self.output.out.as_deref(),
            Request {
                verb: "design",
                name: "design",
                files: planned(Some(model), names),
                inputs: input::files(model, &[], &[]),
            },
        )?;
        let mut json = serde_json::to_value(&found).unwrap_or_default();
        json["question"] = json!([self.question]);
        let table = |(name, content): &(String, String)| (name.clone(), content.clone().into());
        let mut extra = vec![("scenario.toml".to_owned(), found.scenario.clone().into())];
        extra.extend(found.references.iter().map(table));
        let report = Report {
            document: measured::document(model, asked, &found),
            json: envelope("lostmotion/design/1", &model.name, json),
            motions: Vec::new(),
            model: Some(model.clone()),
            extra,
        };
        console::finish(&report, &folder, &self.output)
    }
}

fn parts(trial: &TriedExperiment) -> String {
    let names = trial.experiment.iter().map(|part| json!(part).as_str().unwrap_or_default().replace('_', " "));
    names.collect::<Vec<_>>().join(", then ")
}

fn document(name: &str, question: &Question, found: &Designed) -> Document {
    let causes = question.causes().join(" or ");
    let verdict = if found.decides {
        format!("{} for {:.0} s answers it: {causes}.", parts(&found.best), found.best.duration)
    } else {
        let within = if found.beyond_budget.is_some() { " within the budget" } else { "" };
        format!("No experiment{within} decides it ({causes}); the best is {}.", parts(&found.best))
    };
    let mut table = Table::new("", &["experiment", "length", "cause", "named with", "standard error"]);
    for trial in &found.tried {
        for one in &trial.predictions {
            table.row([
                parts(trial),
                format!("{:.0} s", trial.duration),
                one.cause.clone(),
                format!("{:.2}", one.probability),
                one.relative_error.map_or_else(String::new, |error| format!("{:.1} %", 100.0 * error)),
            ]);
        }
    }
    let mut section = Section::new("What was simulated");
    section.text.push(
        "Each cause was simulated with a strength of a tenth of the torque, and the recording was diagnosed; where this decided \
         the question, also with a weaker and a stronger one. `named with` is the probability with which the diagnosis names \
         this cause and not the other: 0 where it does not name it, and at most 0.5 where it cannot rule the other out."
            .to_owned(),
    );
    section.text.push(
        "Carry it out on the machine as scenario.toml describes it, or on the simulated one with \
         `lostmotion run scenario.toml`; a mass under [session.added_mass] is fastened to the last link for that session. To \
         diagnose recordings of the machine, write it into the model file as [[loads]] with `session`, the recording's name."
            .to_owned(),
    );
    if !found.decides {
        section.text.push(format!("What would decide the question: {}.", found.told_apart_by.join("; ")));
        if let Some(least) = found.beyond_budget {
            section.text.push(format!("The next experiment takes {least:.0} s: try a longer --budget."));
        }
    }
    section.tables.push(table);
    let title = format!("{name}: an experiment for {causes}");
    let undecided = "scenario.toml is the best that was found; what it records may leave the question open";
    let warnings = if found.decides { Vec::new() } else { vec![undecided.to_owned()] };
    Document { title, verdict, warnings, sections: vec![section], ..Document::default() }
}
