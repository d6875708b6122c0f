//! Reads a model file: `model.toml` and the URDF that it names.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::accuracy::Accuracy;
use super::coupling::Coupling;
use super::joint::read_joint;
use super::model::{EffectEntry, JointModel, Load, Masses, Model};
use super::robot_file::RobotFile;
use super::tree::{Body, STANDARD_GRAVITY};
use super::urdf::{Built, Urdf};
use super::{format, ranges};
use crate::error::Result;
use crate::files;
use crate::gearhead::{Friction, FrictionLaw};
use crate::toml_input::{Document, Table, nearest, read_text};

/// Largest number of effects: several on every joint of a large machine.
const MOST_EFFECTS: usize = 256;

/// Folder that stands in the path of a URDF that exists only in memory; [`Model::save`] writes that URDF beside the model file.
const OWN_FOLDER: &str = "(identified)";

/// [bytes] Longest URDF: the largest that CAD programs export have a megabyte.
const LONGEST_URDF: u64 = 8 << 20;

/// Largest number of joints that move. A humanoid with hands has 60; the cost of a simulation grows with the cube of their number.
pub(super) const MOST_JOINTS: usize = 128;

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

    /// A model from a parsed model file, which may have been changed, and from the URDF that it names.
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
        let (accuracy, masses) = read_accuracy(&root)?;
        let gravity = root.optional_vector::<3>("gravity", &ranges::GRAVITY)?;
        let table = root.table("joints")?;
        let tables = table.named_tables()?;
        if tables.is_empty() {
            return Err(root.error("joints", "at least one joint that moves"));
        }
        if tables.len() > MOST_JOINTS {
            return Err(root.error("joints", format!("at most {MOST_JOINTS} joints that move, not {}", tables.len())));
        }

        let robot_file = format::robot_file(urdf_file, urdf_text)?;
        let urdf = Urdf::of(urdf_file, &robot_file)?;
        require_movable(&table, &urdf, urdf_file)?;
        let Built { mut robot, held, remarks } = urdf.tree(&table.keys().collect::<BTreeSet<_>>())?;
        robot.gravity = gravity.map_or(STANDARD_GRAVITY, Into::into);
        robot.coupling = Coupling::read(&root, &robot.bodies)?;
        let mut joints: Vec<JointModel> = Vec::new();
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
        let stated: Vec<Option<Friction>> = joints.iter().map(|joint| joint.friction).collect();
        let mut model = Self {
            name,
            source: document.file().to_owned(),
            urdf: urdf_file.to_owned(),
            urdf_text: robot_file.text,
            robot,
            joints,
            held,
            remarks,
            masses,
            accuracy,
            effects,
            loads,
            places: document.places(),
        };
        for (joint, friction) in stated.into_iter().enumerate() {
            friction.into_iter().for_each(|friction| model.set_friction(joint, friction));
        }
        Ok(model)
    }
}

/// How well the nominal values are known, and whether the masses are more than a guess.
fn read_accuracy(root: &Table) -> Result<(Accuracy, Masses)> {
    let words = [("known", Masses::Known), ("estimated", Masses::Estimated)];
    let masses = root.optional_choice("masses", &words)?;
    let Some(table) = root.optional_table("accuracy")? else {
        return Ok(match masses {
            Some(Masses::Estimated) => (Accuracy::of_guesses(), Masses::Estimated),
            _ => (Accuracy::default(), Masses::Known),
        });
    };
    let (accuracy, stated) = Accuracy::read(&table)?;
    table.finish()?;
    Ok((accuracy, masses.unwrap_or(stated)))
}

/// Every joint of the model file is one of the URDF that can move.
fn require_movable(table: &Table, urdf: &Urdf, file: &Path) -> Result<()> {
    let movable = urdf.movable_joints();
    let Some(name) = table.keys().find(|name| !movable.contains(name) && !urdf.mimics(name)) else { return Ok(()) };
    let near = nearest(name, movable.iter().copied()).map_or_else(
        || format!("one of its movable joints {}", movable.join(", ")),
        |near| format!("a movable joint of it, such as {near}"),
    );
    Err(table.error(name, format!("a joint of {}: {near}", file.display())))
}

impl Model {
    /// Writes the inertias of some bodies of the tree into the text of the URDF. From then on the model has a URDF file of its own.
    pub(crate) fn write_inertias(&mut self, changed: &[usize]) {
        if changed.is_empty() {
            return;
        }
        let text = Urdf::parse(&self.urdf, &self.urdf_text)
            .map(|urdf| urdf.with_inertias(&self.urdf_text, &self.robot, changed));
        // The text was read before, so reading it again succeeds; if it fails, only the tree changes.
        if let Ok(text) = text {
            self.urdf_text = text;
            self.urdf = Path::new(OWN_FOLDER)
                .join(self.urdf.with_extension("urdf").file_name().unwrap_or("robot.urdf".as_ref()));
        }
    }

    /// Notes on values of its files that are not taken as written or have no effect.
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

/// Reads a robot file.
///
/// # Errors
/// It cannot be read.
pub(super) fn read_robot_file(file: &Path) -> Result<RobotFile> {
    format::robot_file(file, &read_text(file, LONGEST_URDF)?)
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
