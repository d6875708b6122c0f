//! Bodies, their joints and their masses, as links and joints of a URDF.

mod joints;

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::actuators::{Actuated, Mimic};
use super::classes::Classes;
use super::compiler::{Compiler, FromGeoms};
use super::document::Node;
use super::geoms::Geom;
use super::meshes::Meshes;
use super::written::{Written, escaped, origin};
use crate::error::{Error, Result};
use crate::robot::drives::Drives;
use crate::robot::remark::Remark;
use crate::robot::tree::Inertia;
use crate::robot::urdf::written_inertial;

/// Largest depth of nested bodies.
const MOST_NESTED: usize = 64;

/// Largest number of bodies: a humanoid with hands has a hundred, a scene a few hundred.
const MOST_BODIES: usize = 5000;

/// Elements of a body that add mass or motion but are not read.
const UNREAD: [&str; 5] = ["composite", "flexcomp", "replicate", "attach", "plugin"];

/// The walk through the bodies of a file.
pub(super) struct Walk<'n> {
    classes: &'n Classes,
    compiler: &'n Compiler,
    actuators: BTreeMap<String, Actuated>,
    mimics: BTreeMap<String, Mimic>,
    meshes: Meshes,
    /// `ref` of each joint [rad or m].
    references: BTreeMap<String, f64>,
    links: Names,
    joints: Names,
    written: Written,
    drives: Drives,
    remarks: Vec<Remark>,
    /// Whether a body with a joint has a mass.
    moves_mass: bool,
    /// The error of the first mesh that cannot be read for its mass.
    unread: Option<Error>,
}

/// Where a child element of a body stands: the `<frame>` around it, and the class that applies there.
#[derive(Clone, Copy)]
struct Around<'n> {
    class: Option<&'n str>,
    frame: Isometry3<f64>,
}

/// The parts of a body, with the frames around them resolved.
#[derive(Default)]
struct Parts<'n> {
    joints: Vec<(&'n Node, Around<'n>)>,
    geoms: Vec<(&'n Node, Around<'n>)>,
    bodies: Vec<(&'n Node, Around<'n>)>,
    inertial: Option<&'n Node>,
}

impl<'n> Walk<'n> {
    /// Prepares the walk.
    pub fn new(
        root: &'n Node,
        classes: &'n Classes,
        compiler: &'n Compiler,
        (actuators, mimics): (BTreeMap<String, Actuated>, BTreeMap<String, Mimic>),
        meshes: Meshes,
        remarks: Vec<Remark>,
    ) -> Self {
        let name = root.attribute("model").unwrap_or("robot");
        Self {
            classes,
            compiler,
            actuators,
            mimics,
            meshes,
            references: BTreeMap::new(),
            links: Names::new(),
            joints: Names::new(),
            written: Written::new(name, root.main_line),
            drives: Drives::new(),
            remarks,
            moves_mass: false,
            unread: None,
        }
    }

    /// Writes the base and all bodies.
    ///
    /// # Errors
    /// A value has no meaning, a class is unknown, or bodies are nested too deeply.
    pub fn all(mut self, root: &'n Node) -> Result<(Written, Drives, Vec<Remark>)> {
        let worlds: Vec<&Node> = root.all("worldbody").collect();
        let around = Around { class: None, frame: Isometry3::identity() };
        let mut parts = Parts::default();
        for world in &worlds {
            self.gather(world, around, &mut parts)?;
        }
        self.find_references(&worlds, around)?;
        let line = worlds.first().map_or(root.main_line, |world| world.main_line);
        let base = own_name(&mut self.links, "world");
        self.written.line(line, &format!("<link name=\"{}\">", escaped(&base)));
        self.shapes(&parts, &Isometry3::identity(), line)?;
        self.written.line(line, "</link>");
        for (node, around) in parts.bodies {
            self.body(node, around, &base, &Isometry3::identity(), 1)?;
        }
        match self.unread.filter(|_| !self.moves_mass) {
            Some(error) => Err(error),
            None => Ok((self.written, self.drives, self.remarks)),
        }
    }

    /// Writes a body below a link. `at` is the pose of the parent body in the frame of that link.
    fn body(
        &mut self,
        node: &'n Node,
        around: Around<'n>,
        parent: &str,
        pose: &Isometry3<f64>,
        depth: usize,
    ) -> Result<()> {
        if depth > MOST_NESTED {
            return Err(node.error("", "", format!("at most {MOST_NESTED} bodies within each other")));
        }
        if self.links.len() > MOST_BODIES {
            return Err(node.error("", "", format!("at most {MOST_BODIES} bodies")));
        }
        let item = self.classes.with(node, around.class)?;
        if item.number_or("gravcomp", 0.0)? != 0.0 {
            self.remarks.push(node.remark("gravcomp is not taken: gravity acts on the body in full"));
        }
        let inner = Around { class: node.attribute("childclass").or(around.class), frame: Isometry3::identity() };
        let mut parts = Parts::default();
        self.gather(node, inner, &mut parts)?;
        let name = own_name(&mut self.links, node.attribute("name").unwrap_or("body"));
        let mut at = pose * around.frame * self.compiler.pose(&item)?;
        let mut above = parent.to_owned();
        let count = parts.joints.len();
        for (index, (joint, around)) in parts.joints.iter().enumerate() {
            let link = if index + 1 == count {
                name.clone()
            } else {
                own_name(&mut self.links, &format!("{name}_{}", index + 1))
            };
            at = self.joint(joint, *around, node, (&above, &link), &at)?;
            if index + 1 < count {
                self.written.line(joint.main_line, &format!("<link name=\"{}\"/>", escaped(&link)));
            }
            above = link;
        }
        if count == 0 {
            let joint = own_name(&mut self.joints, &format!("{name}_fixed"));
            self.write_joint(node.main_line, (&joint, "fixed"), (&above, &name), &at, "");
            at = Isometry3::identity();
        }
        self.written.line(node.main_line, &format!("<link name=\"{}\">", escaped(&name)));
        if let Some((line, inertia)) = self.inertia(node, &parts)? {
            self.written.line(line, &written_inertial(&inertia.seen_from(&at)));
        }
        self.shapes(&parts, &at, node.main_line)?;
        self.written.line(node.main_line, "</link>");
        for (child, around) in parts.bodies {
            self.body(child, around, &name, &at, depth + 1)?;
        }
        Ok(())
    }

    /// Collects the parts of a body, including those inside its frames.
    fn gather(&mut self, node: &'n Node, around: Around<'n>, parts: &mut Parts<'n>) -> Result<()> {
        for child in &node.children {
            match child.name.as_str() {
                "joint" | "freejoint" => parts.joints.push((child, around)),
                "geom" => parts.geoms.push((child, around)),
                "body" => parts.bodies.push((child, around)),
                "inertial" => parts.inertial = Some(child),
                "frame" => {
                    let pose = self.compiler.pose(&self.classes.with(child, None)?)?;
                    let class = child.attribute("childclass").or(around.class);
                    self.gather(child, Around { class, frame: around.frame * pose }, parts)?;
                }
                name if UNREAD.contains(&name) => {
                    self.remarks.push(child.remark("it is not read, nor is anything inside it"))
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Reads `ref` of all joints; equalities need them.
    fn find_references(&mut self, nodes: &[&'n Node], around: Around<'n>) -> Result<()> {
        let mut waiting: Vec<(&Node, Around<'n>)> = nodes.iter().map(|node| (*node, around)).collect();
        while let Some((node, around)) = waiting.pop() {
            let inner = Around { class: node.attribute("childclass").or(around.class), ..around };
            waiting.extend(
                node.children
                    .iter()
                    .filter(|child| ["body", "frame"].contains(&child.name.as_str()))
                    .map(|child| (child, inner)),
            );
            for joint in node.all("joint") {
                let item = self.classes.with(joint, inner.class)?;
                if let Some(name) = joint.attribute("name") {
                    let reference = item.number_or("ref", 0.0)? * self.unit_of(&item)?;
                    self.references.insert(name.to_owned(), reference);
                }
            }
        }
        Ok(())
    }

    fn write_joint(
        &mut self,
        line: usize,
        (name, kind): (&str, &str),
        (parent, link): (&str, &str),
        at: &Isometry3<f64>,
        inner: &str,
    ) {
        let [name, parent, link] = [name, parent, link].map(escaped);
        let origin = origin(at);
        self.written.line(
            line,
            &format!("<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{link}\"/>{origin}{inner}</joint>"),
        );
    }

    /// Inertia of a body in its frame, with its line in the file.
    fn inertia(&mut self, body: &'n Node, parts: &Parts<'n>) -> Result<Option<(usize, Inertia)>> {
        let own = parts.inertial.filter(|_| self.compiler.inertia != FromGeoms::Always || parts.geoms.is_empty());
        if let Some(node) = own {
            let inertia = self.inertial(node)?;
            self.moves_mass |= inertia.mass > 0.0 && !parts.joints.is_empty();
            return Ok(Some((node.main_line, inertia)));
        }
        if self.compiler.inertia == FromGeoms::Never {
            return Ok(None);
        }
        let mut sum = Inertia::zero();
        for (node, around) in &parts.geoms {
            let geom = Geom::read(self.classes.with(node, around.class)?, self.compiler, &around.frame)?;
            let mut expected = "a mesh, box, capsule, cylinder, ellipsoid or sphere".to_owned();
            let mesh = |name: &str| self.meshes.inertia(name).map_err(|fault| expected = fault).ok();
            match geom.inertia(mesh)? {
                Some(inertia) => sum = sum.joined(&inertia),
                None if geom.is_solid() => {
                    self.remarks.push(node.remark(&format!("its mass is not read: expected {expected}")));
                    let expected = format!("{expected}, or an <inertial> of its body: no body that moves has a mass");
                    self.unread.get_or_insert(node.error("mesh", geom.mesh.unwrap_or(geom.kind), expected));
                }
                None => {}
            }
        }
        self.moves_mass |= sum.mass > 0.0 && !parts.joints.is_empty();
        Ok((sum.mass > 0.0).then_some((body.main_line, sum)))
    }

    /// `<inertial>`: the tensor about the centre of mass, in axes turned against those of the body.
    fn inertial(&self, node: &Node) -> Result<Inertia> {
        let item = self.classes.with(node, None)?;
        let mass = item.magnitude_or("mass", 0.0)?;
        let tensor = match (item.array::<6>("fullinertia")?, item.array::<3>("diaginertia")?) {
            (Some([xx, yy, zz, xy, xz, yz]), _) => Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            (None, Some(diagonal)) => Matrix3::from_diagonal(&diagonal.into()),
            (None, None) => Matrix3::zeros(),
        };
        Ok(Inertia { mass, com: Vector3::zeros(), tensor }.seen_from(&self.compiler.pose(&item)?))
    }

    /// Writes the geoms that collide, and the meshes that are only drawn; `at` is the pose of the body in the frame of its link.
    fn shapes(&mut self, parts: &Parts<'n>, at: &Isometry3<f64>, line: usize) -> Result<()> {
        for (node, around) in &parts.geoms {
            let geom = Geom::read(self.classes.with(node, around.class)?, self.compiler, &around.frame)?;
            if ["plane", "hfield"].contains(&geom.kind) {
                continue;
            }
            let element = if geom.collides { "collision" } else { "visual" };
            match geom.urdf(|mesh| self.meshes.element(mesh)) {
                Some(shape) => {
                    let origin = origin(&(at * geom.pose));
                    self.written.line(line, &format!("<{element}>{origin}<geometry>{shape}</geometry></{element}>"));
                }
                None if !geom.collides => {}
                None => self.remarks.push(node.remark(&format!("a {} is not taken as a collision shape", geom.kind))),
            }
        }
        Ok(())
    }
}

/// Names in use, each with the number of times that it was requested.
type Names = BTreeMap<String, usize>;

/// A unique name: the wanted one, followed by a number if it is in use.
fn own_name(names: &mut Names, wanted: &str) -> String {
    let mut name = wanted.to_owned();
    while names.contains_key(&name) {
        let asked = names.entry(wanted.to_owned()).or_insert(1);
        *asked += 1;
        name = format!("{wanted}_{asked}");
    }
    names.insert(name.clone(), 1);
    name
}
