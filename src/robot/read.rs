//! Reads a model file: `model.toml` and the URDF that it names.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::accuracy::Accuracy;
use super::coupling::Coupling;
use super::joint::{CURRENT_TIME_CONSTANT, read_joint};
use super::model::{EffectEntry, JointModel, Load, Masses, Model, TorqueAt};
use super::ranges;
use super::tree::Body;
use super::urdf::{Built, STANDARD_GRAVITY, Urdf};
use crate::drive::{Amplifier, Encoder, Motor};
use crate::error::{Error, Place, Result};
use crate::files;
use crate::gearhead::FrictionLaw;
use crate::toml_input::{Document, Places, Table, nearest, read_text};
use crate::units::JointKind;

/// Most effects: several on every joint of a large machine.
const MOST_EFFECTS: usize = 256;

/// Folder in the name of a URDF that exists only as a text: [`Model::save`] writes it beside the model file.
const OWN_FOLDER: &str = "(identified)";

/// [bytes] Longest URDF: the largest that CAD programs export have a megabyte.
const LONGEST_URDF: u64 = 8 << 20;

/// Most joints that move. A humanoid with hands has 60; the cost of a simulation grows with the cube of their number.
const MOST_JOINTS: usize = 128;

/// The schema that this reader understands.
pub(super) const SCHEMA: &str = "lostmotion/model/1";

impl Model {
    /// Reads a model file and the URDF that it names.
    ///
    /// # Errors
    /// A file cannot be read; a key is missing, unknown or out of its range; a joint is not in the URDF; an inertia is
    /// not physical. The error names file, line, key, value and what was expected.
    pub fn load(file: &Path) -> Result<Self> {
        Self::from_changed(&Document::read(file)?)
    }

    /// A model from a model file that was parsed and perhaps changed, and from the URDF that it names.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn from_changed(document: &Document) -> Result<Self> {
        let urdf = urdf_path(document)?;
        let text = read_text(&urdf, LONGEST_URDF).map_err(|error| {
            if files::exists(&urdf) { error } else { document.root().error("urdf", "a file that exists") }
        })?;
        Self::from_document(document, &urdf, &text)
    }

    /// A model from texts in memory, such as those embedded in the program. `file` is the name that errors use, and the
    /// place where meshes are searched.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn from_texts(model: &str, urdf: &str, file: &Path) -> Result<Self> {
        let document = Document::parse(file, model)?;
        Self::from_document(&document, &urdf_path(&document)?, urdf)
    }

    /// A model from a parsed model file and the text of its URDF.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn from_document(document: &Document, urdf_file: &Path, urdf_text: &str) -> Result<Self> {
        let root = document.root();
        check_schema(&root)?;
        let name = root.name("name")?.to_owned();
        root.text("urdf")?;
        let words = [("known", Masses::Known), ("estimated", Masses::Estimated)];
        let masses = root.optional_choice("masses", &words)?;
        let (accuracy, masses) = match (root.optional_table("accuracy")?, masses) {
            (Some(table), masses) => {
                let (accuracy, stated) = Accuracy::read(&table)?;
                table.finish()?;
                (accuracy, masses.unwrap_or(stated))
            }
            (None, Some(Masses::Estimated)) => (Accuracy::of_guesses(), Masses::Estimated),
            (None, _) => (Accuracy::default(), Masses::Known),
        };
        let gravity = root.optional_vector::<3>("gravity", &ranges::GRAVITY)?;
        let table = root.table("joints")?;
        let tables = table.named_tables()?;
        if tables.is_empty() {
            return Err(root.error("joints", "at least one joint that moves"));
        }
        if tables.len() > MOST_JOINTS {
            return Err(root.error("joints", format!("at most {MOST_JOINTS} joints that move, not {}", tables.len())));
        }

        let urdf = Urdf::parse(urdf_file, urdf_text)?;
        let movable = urdf.movable_joints();
        for name in table.keys() {
            if !movable.contains(&name) && !urdf.mimics(name) {
                let near = nearest(name, movable.iter().copied()).map_or_else(
                    || format!("one of its movable joints {}", movable.join(", ")),
                    |near| format!("a movable joint of it, such as {near}"),
                );
                return Err(table.error(name, format!("a joint of {}: {near}", urdf_file.display())));
            }
        }
        let Built { mut robot, held, remarks } = urdf.tree(&table.keys().collect::<BTreeSet<_>>())?;
        robot.gravity = gravity.map_or(STANDARD_GRAVITY, Into::into);
        robot.coupling = Coupling::read(&root, &robot.bodies)?;
        let mut joints = Vec::new();
        for body in &robot.bodies {
            let table = table.table(&body.joint.name)?;
            joints.push(read_joint(&table, body)?);
            table.finish()?;
        }
        let effects: Vec<EffectEntry> =
            root.tables("effects")?.iter().map(|table| read_effect(table, &robot.bodies)).collect::<Result<_>>()?;
        if effects.len() > MOST_EFFECTS {
            return Err(root.error("effects", format!("at most {MOST_EFFECTS} effects, not {}", effects.len())));
        }
        let loads = root.tables("loads")?.iter().map(read_load).collect::<Result<_>>()?;
        root.finish()?;
        Ok(Self {
            name,
            source: document.file().to_owned(),
            urdf: urdf_file.to_owned(),
            urdf_text: urdf_text.to_owned(),
            robot,
            joints,
            held,
            remarks,
            masses,
            accuracy,
            effects,
            loads,
            places: document.places(),
        })
    }

    /// A first model of a URDF: every movable joint that moves a mass gets a gear and a drive of common size, to be replaced by the
    /// machine's own numbers. Friction and gap are unknown. `plant::first_model` makes it one that can be simulated.
    ///
    /// # Errors
    /// The file cannot be read, or is refused as in [`Model::load`].
    pub fn from_urdf(file: &Path) -> Result<Self> {
        Self::from_urdf_holding(file, &BTreeMap::new())
    }

    /// As [`from_urdf`](Self::from_urdf), with some joints held at zero, each for a reason that becomes a remark.
    ///
    /// # Errors
    /// As [`from_urdf`](Self::from_urdf).
    pub fn from_urdf_holding(file: &Path, reasons: &BTreeMap<String, String>) -> Result<Self> {
        let text = read_text(file, LONGEST_URDF)?;
        let urdf = Urdf::parse(file, &text)?;
        let movable = urdf.movable_joints().len();
        if movable > MOST_JOINTS {
            let expected = format!("at most {MOST_JOINTS} joints that move, not {movable}");
            return Err(Error::input(file, Place::File, "joints", "", expected));
        }
        let Built { robot, held, remarks } = urdf.whole_tree(reasons)?;
        if robot.bodies.is_empty() {
            return Err(Error::input(file, Place::File, "", "", "at least one joint that turns or slides"));
        }
        let joints = robot.bodies.iter().map(first_joint).collect();
        Ok(Self {
            name: first_name(&robot.name, file).to_owned(),
            source: PathBuf::new(),
            urdf: file.to_owned(),
            urdf_text: text.clone(),
            robot,
            joints,
            held,
            remarks,
            masses: Masses::Known,
            accuracy: Accuracy::default(),
            effects: Vec::new(),
            loads: Vec::new(),
            places: Places::default(),
        })
    }
}

impl Model {
    /// Writes the inertias of some bodies of the tree into the text of the URDF, which becomes a file of this model's own.
    pub(super) fn write_inertias(&mut self, changed: &[usize]) {
        if changed.is_empty() {
            return;
        }
        let text = Urdf::parse(&self.urdf, &self.urdf_text)
            .map(|urdf| urdf.with_inertias(&self.urdf_text, &self.robot, changed));
        // A text that was read once is read again; if not, the tree alone is changed.
        if let Ok(text) = text {
            self.urdf_text = text;
            self.urdf = Path::new(OWN_FOLDER).join(self.urdf.file_name().unwrap_or("robot.urdf".as_ref()));
        }
    }

    /// Notes on values of its files that are read in a different way, or have no effect.
    pub fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.remarks.iter().map(ToString::to_string).collect();
        let unread = |shape: &super::UnreadShape| {
            format!(
                "link {}: its collision shape {} was not read, expected {}",
                shape.link,
                shape.file.display(),
                shape.expected
            )
        };
        notes.extend(self.robot.unread_shapes.iter().map(unread));
        for joint in &self.joints {
            let JointModel { name, motor, amplifier, friction, .. } = joint;
            if amplifier.voltage_limit.is_finite() && motor.is_none_or(|motor| motor.resistance.is_none()) {
                notes.push(format!("joint {name}: voltage_limit is without effect, the motor has no resistance"));
            }
            if amplifier.current_limit.is_finite() && motor.is_none() {
                notes.push(format!("joint {name}: current_limit is without effect, the motor is unknown"));
            }
            if let Some(FrictionLaw::Exponential(laws)) = friction.as_ref().map(|friction| friction.law)
                && laws.iter().any(|law| law.breakaway < law.coulomb)
            {
                notes.push(format!("joint {name}: breakaway is below coulomb, friction rises as it begins to slip"));
            }
        }
        notes
    }
}

fn check_schema(root: &Table<'_>) -> Result<()> {
    root.optional_choice("schema", &[(SCHEMA, ())])?
        .ok_or_else(|| root.error("schema", format!("\"{SCHEMA}\" (missing)")))
}

fn urdf_path(document: &Document) -> Result<PathBuf> {
    check_schema(&document.root())?;
    let urdf = document.root().text("urdf")?;
    Ok(document.file().parent().unwrap_or(Path::new("")).join(urdf))
}

/// The URDF's name of the robot; the name of its file if the robot's name is not valid for a folder; else `robot`.
fn first_name<'a>(robot: &'a str, file: &'a Path) -> &'a str {
    let stem = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    [robot, stem].into_iter().find(|name| files::is_fit_name(name)).unwrap_or("robot")
}

/// A gear and a drive of common size.
fn first_joint(body: &Body) -> JointModel {
    let (gear_ratio, gear_stiffness, gear_damping) = match body.joint.kind {
        // A harmonic or planetary gear has 1:100; a ball screw of 5 mm per turn.
        JointKind::Revolute => (100.0, 1e4, 10.0),
        JointKind::Prismatic => (2.0 * std::f64::consts::PI / 0.005, 1e7, 1e4),
    };
    JointModel {
        name: body.joint.name.clone(),
        kind: body.joint.kind,
        gear_ratio,
        rotor_inertia: Some(1e-5),
        gear_stiffness: Some(gear_stiffness),
        gear_damping: Some(gear_damping),
        end_stop_stiffness: None,
        backlash: None,
        motor: Some(Motor { torque_constant: 0.05, resistance: None, inductance: None }),
        amplifier: Amplifier {
            voltage_limit: f64::INFINITY,
            current_limit: f64::INFINITY,
            current_time_constant: CURRENT_TIME_CONSTANT,
        },
        encoder: Some(Encoder { counts_per_turn: 4096.0 }),
        link_encoder: None,
        velocity_sensor: None,
        current_sensor: None,
        friction: None,
        torque_at: TorqueAt::Motor,
    }
}

fn read_load(table: &Table<'_>) -> Result<Load> {
    let load = Load::read(table, table.text("session")?)?;
    table.finish()?;
    Ok(load)
}

impl Load {
    /// Reads `mass`, `x`, `y`, `z` of a table.
    ///
    /// # Errors
    /// The mass is missing or not above zero, or a value is not a number.
    pub fn read(table: &Table<'_>, session: &str) -> Result<Self> {
        let mass = table.number("mass", &ranges::MASS)?;
        let coordinate = |axis: &str| table.number_or(axis, &ranges::PLACE, 0.0);
        let position = [coordinate("x")?, coordinate("y")?, coordinate("z")?];
        Ok(Self { session: session.to_owned(), mass, position })
    }
}

fn read_effect(table: &Table<'_>, bodies: &[Body]) -> Result<EffectEntry> {
    let effect = table.text("effect")?.to_owned();
    let joint = table.optional_text("joint")?;
    if let Some(name) = joint.filter(|name| bodies.iter().all(|body| body.joint.name != *name)) {
        let names: Vec<&str> = bodies.iter().map(|body| body.joint.name.as_str()).collect();
        let near = nearest(name, names.iter().copied()).map_or_else(|| names.join(", "), str::to_owned);
        return Err(table.error("joint", format!("a joint of this model: {near}")));
    }
    Ok(EffectEntry { effect, joint: joint.map(str::to_owned), parameters: table.remaining_numbers()? })
}
