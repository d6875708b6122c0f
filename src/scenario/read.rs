//! Reads a scenario file.
//!
//! ```toml
//! schema = "lostmotion/scenario/1"
//! name = "identify_scara"
//! question = "What friction and backlash do the drives have?"
//! robot = "../../robots/scara/model.toml"      # relative to this file
//! model = ["joints.joint1.backlash = 0.0017"]  # assignments that change the model file's values
//! sensors = "model"                            # or "ideal"
//! unread_shapes = "refused"                    # or "ignored": collisions of links whose meshes cannot be read are not checked
//! control_period = 0.001                       # [s]
//! procedure = "identify"                       # "diagnose", "compensate", "none"
//! seed = 1
//! [added_mass]                                 # a known mass [kg] at x, y, z [m] of the last body, in the nominal model too
//! [plant]                                      # engine = "rapier" or "reduced", step [s], substeps, evaluations, accuracy
//! [controller]                                 # law, velocity, a table of gains for every joint
//! [reference]                                  # or a list [[session]]: kind, start, a table for every joint that moves
//! # a scenario on recordings has `data` instead of all that follows, see `recorded`
//! # [session.added_mass]                       # the same in one session of a list [[session]] alone
//! [compensation]                               # for procedure = "compensate": crossing_time [s] of a gap, and
//! [compensation.motion]                        # the motion that is tracked, as in [reference]
//! [[obstacles]]                                # obstacles, see `read_obstacles`
//! [expect.joint1]                              # largest errors in per cent, see `expect`
//! # [expect] effects, [[expect.effect]]         # what a diagnosis names, see `expect_diagnosis`
//! [expect.obstacles.post]                      # least and greatest first_touch [s], peak_force [N], last_force [N]
//! ```

use std::path::Path;

use super::contact::CONTACT_QUANTITIES;
use super::expect::QUANTITIES;
use super::{ContactExpectation, DiagnosisExpectation, Expectation, Procedure, SCHEMA, Scenario, Session, Truth};
use super::{
    Limits, TRACKING_QUANTITIES, TrackingExpectation, ranges, read_added_mass, read_compensation, read_controller,
    read_obstacles, read_reference,
};
use crate::error::Result;
use crate::files;
use crate::plant::{Accuracy, Engine, Evaluations, Options};
use crate::robot::{Load, Model};
use crate::toml_input::{Document, Range, Table};

/// Most recordings of a scenario.
const MOST_SESSIONS: usize = 1000;

impl Scenario {
    /// Reads a scenario file and the model that it names. `assignments` (`KEY=VALUE`) change its values first; those whose
    /// key begins with `model.` change the model file's.
    ///
    /// # Errors
    /// A file cannot be read; a key is missing, unknown or out of its range; an assignment cannot be applied.
    pub fn load(file: &Path, assignments: &[String]) -> Result<Self> {
        Self::from_document(Document::read(file)?, assignments, None)
    }

    /// A scenario from a text in memory. `file` is the name that errors use, and the robot's path is relative to it.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn from_text(text: &str, file: &Path, assignments: &[String]) -> Result<Self> {
        Self::from_document(Document::parse(file, text)?, assignments, None)
    }

    /// As [`from_text`](Self::from_text), for a given model: the file that the text names as `robot` need not exist
    /// yet.
    ///
    /// # Errors
    /// The text is not a scenario of this model.
    pub fn of_model(text: &str, file: &Path, model: &Model) -> Result<Self> {
        Self::from_document(Document::parse(file, text)?, &[], Some(model))
    }

    fn from_document(mut document: Document, assignments: &[String], at_hand: Option<&Model>) -> Result<Self> {
        let (of_model, of_scenario): (Vec<&String>, Vec<&String>) =
            assignments.iter().partition(|assignment| assignment.trim_start().starts_with("model."));
        for assignment in of_scenario {
            document.set(assignment)?;
        }
        let of_model: Vec<&str> =
            of_model.iter().map(|assignment| &assignment.trim_start()["model.".len()..]).collect();
        Self::read(&document.root(), &of_model, at_hand)
    }

    fn read(root: &Table<'_>, of_model: &[&str], at_hand: Option<&Model>) -> Result<Self> {
        root.optional_choice("schema", &[(SCHEMA, ())])?
            .ok_or_else(|| root.error("schema", format!("\"{SCHEMA}\" (missing)")))?;
        let mut model = read_model(root, of_model, at_hand)?;
        let shapes = [("refused", false), ("ignored", true)];
        if root.optional_choice("unread_shapes", &shapes)? == Some(true) {
            model.robot.unread_shapes.clear();
        }
        let words = [
            ("identify", Procedure::Identify),
            ("diagnose", Procedure::Diagnose),
            ("compensate", Procedure::Compensate),
            ("none", Procedure::None),
        ];
        let mut options = read_options(root)?;
        options.obstacles = read_obstacles::read(root, &model.robot, options.engine)?;
        let procedure = root.optional_choice("procedure", &words)?.unwrap_or(Procedure::None);
        let expected = read_expectations(root, &model, &options, procedure)?;
        let (sessions, loads): (Vec<Session>, Vec<Option<Load>>) = read_sessions(root, &model)?.into_iter().unzip();
        let (tracking, load) = read_compensation::read(root, &model, procedure, &sessions)?.unzip();
        model.loads.extend(loads.into_iter().chain(load).flatten());
        let truth = Truth::of(model);
        let nominal = truth.nominal();
        let scenario = Self {
            name: root.name("name")?.to_owned(),
            question: root.optional_text("question")?.unwrap_or_default().to_owned(),
            source: root.file().to_owned(),
            options,
            seed: root.optional_integer("seed", 0, i64::MAX)?.unwrap_or(1).unsigned_abs(),
            control_period: root.number_or("control_period", &ranges::CONTROL_PERIOD, 1e-3)?,
            controller: read_controller::read(&root.table("controller")?, &nominal)?,
            sessions,
            procedure,
            tracking,
            tracking_expectations: expected.tracking,
            expectations: expected.joints,
            diagnosis_expectation: expected.diagnosis,
            contact_expectations: expected.contacts,
            model: nominal,
            truth,
            limits: Limits::default(),
        };
        root.finish()?;
        Ok(scenario)
    }
}

/// The model that `robot` names, changed by the scenario's own assignments and then by those of the command line.
fn read_model(root: &Table<'_>, assignments: &[&str], at_hand: Option<&Model>) -> Result<Model> {
    let file = root.file().parent().unwrap_or(Path::new("")).join(root.text("robot")?);
    let added = read_added_mass::read(root, "")?;
    let own = root.optional_texts("model")?.unwrap_or_default();
    let mut model = match at_hand {
        Some(model) => model.clone(),
        None if !files::exists(&file) => return Err(root.error("robot", "a model file that exists")),
        None => {
            let mut document = Document::read(&file)?;
            for assignment in own.iter().chain(assignments) {
                document.set(assignment)?;
            }
            Model::from_changed(&document)?
        }
    };
    if let (Some(added), Some(body)) = (added, model.robot.bodies.last_mut()) {
        body.inertia = body.inertia.joined(&added.inertia());
    }
    Ok(model)
}

fn read_options(root: &Table<'_>) -> Result<Options> {
    let ideal_sensors = root.optional_choice("sensors", &[("model", false), ("ideal", true)])?.unwrap_or(false);
    let mut options = Options { ideal_sensors, ..Options::default() };
    if let Some(table) = root.optional_table("plant")? {
        if table.optional_choice("accuracy", &[("fine", Accuracy::Fine), ("coarse", Accuracy::Coarse)])?
            == Some(Accuracy::Coarse)
        {
            options = Options { ideal_sensors, ..Options::coarse() };
        }
        let engines = [("rapier", Engine::Rapier), ("reduced", Engine::Reduced)];
        options.engine = table.optional_choice("engine", &engines)?.unwrap_or(options.engine);
        let evaluations = [
            ("as_needed", Evaluations::AsNeeded),
            ("every_interval", Evaluations::EveryInterval),
            ("every_stage", Evaluations::EveryStage),
        ];
        options.evaluations = table.optional_choice("evaluations", &evaluations)?.unwrap_or_default();
        options.step = table.number_or("step", &ranges::PLANT_STEP, options.step)?;
        let substeps = table.optional_integer("substeps", 1, 10_000)?.and_then(|count| usize::try_from(count).ok());
        options.substeps = substeps.unwrap_or(options.substeps);
        table.finish()?;
    }
    Ok(options)
}

fn read_sessions(root: &Table<'_>, model: &Model) -> Result<Vec<(Session, Option<Load>)>> {
    let sessions = root.tables("session")?;
    if sessions.len() > MOST_SESSIONS {
        return Err(root.error("session", format!("at most {MOST_SESSIONS} sessions, not {}", sessions.len())));
    }
    match root.optional_table("reference")? {
        Some(table) if sessions.is_empty() => Ok(vec![read_reference::read(&table, model, "session1")?]),
        Some(_) => Err(root.error("reference", "either [reference] or [[session]]")),
        None if sessions.is_empty() => Err(root.error("reference", "the motion of the joints (missing)")),
        None => {
            let mut found: Vec<(Session, Option<Load>)> = Vec::new();
            for (i, table) in sessions.iter().enumerate() {
                let one = read_reference::read(table, model, &format!("session{}", i + 1))?;
                // Some file systems do not distinguish upper and lower case.
                let folded = one.0.name.to_lowercase();
                if found.iter().any(|(other, _)| other.name.to_lowercase() == folded) {
                    return Err(
                        table.error("name", format!("a name that no other session has; `{}` is taken", one.0.name))
                    );
                }
                found.push(one);
            }
            Ok(found)
        }
    }
}

/// The content of `[expect]`.
#[derive(Default)]
struct Expected {
    joints: Vec<Expectation>,
    diagnosis: DiagnosisExpectation,
    contacts: Vec<ContactExpectation>,
    tracking: Vec<TrackingExpectation>,
}

fn read_expectations(root: &Table<'_>, model: &Model, options: &Options, procedure: Procedure) -> Result<Expected> {
    let Some(expect) = root.optional_table("expect")? else { return Ok(Expected::default()) };
    let names: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
    let diagnosis = DiagnosisExpectation::read(&expect, Some(&names))?;
    if let (false, true) = (diagnosis.is_empty(), procedure != Procedure::Diagnose) {
        let key = if diagnosis.effects.is_some() { "effects" } else { "effect" };
        return Err(expect.error(key, "a scenario with procedure = \"diagnose\""));
    }
    let mut expected = Expected { diagnosis, ..Expected::default() };
    for joint in expect.keys().filter(|key| !["effects", "effect"].contains(key)) {
        let table = expect.table(joint)?;
        if joint == "obstacles" {
            expected.contacts = read_contact_expectations(&table, options)?;
            continue;
        }
        if model.robot.joint_index(joint).is_none() {
            return Err(root.error("expect", format!("joints of the model; `{joint}` is not one of them")));
        }
        for (quantity, _) in QUANTITIES {
            if let Some(limit_percent) = table.optional_number(quantity, &Range::non_negative("%").up_to(1e6))? {
                expected.joints.push(Expectation { joint: joint.to_owned(), quantity, limit_percent });
            }
        }
        if procedure == Procedure::Compensate {
            read_tracking_expectations(&table, joint, &mut expected.tracking)?;
        }
        table.finish()?;
    }
    Ok(expected)
}

fn read_tracking_expectations(table: &Table<'_>, joint: &str, expected: &mut Vec<TrackingExpectation>) -> Result<()> {
    for (quantity, _) in TRACKING_QUANTITIES {
        if let Some(bound) = table.optional_number(quantity, &Range::non_negative("").up_to(1e6))? {
            expected.push(TrackingExpectation { joint: joint.to_owned(), quantity, bound });
        }
    }
    Ok(())
}

fn read_contact_expectations(table: &Table<'_>, options: &Options) -> Result<Vec<ContactExpectation>> {
    let mut expectations = Vec::new();
    for (obstacle, table_of_one) in table.named_tables()? {
        if options.obstacles.iter().all(|known| known.shape.link != obstacle) {
            return Err(table.error(obstacle, "an obstacle of the scenario"));
        }
        for (quantity, unit) in CONTACT_QUANTITIES {
            if let Some(range) = table_of_one.optional_vector::<2>(quantity, &Range::non_negative(unit).up_to(1e9))? {
                if range[0] > range[1] {
                    return Err(table_of_one.error(quantity, "the least value before the greatest"));
                }
                expectations.push(ContactExpectation { obstacle: obstacle.to_owned(), quantity, range });
            }
        }
        table_of_one.finish()?;
    }
    Ok(expectations)
}
