//! Bodies, their joints and their masses, as links and joints of a URDF.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use super::actuators::{Actuated, Mimic, limited};
use super::classes::{Classes, Item};
use super::compiler::{Compiler, FromGeoms, unit};
use super::document::Node;
use super::geoms::Geom;
use super::meshes::Meshes;
use super::written::{Written, escaped, origin};
use crate::error::Result;
use crate::robot::drives::{DriveData, Drives};
use crate::robot::remark::Remark;
use crate::robot::tree::Inertia;
use crate::robot::urdf::{LARGEST_DAMPING, written_inertial};

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
        Ok((self.written, self.drives, self.remarks))
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

    /// [rad or m] One unit of a joint's positions.
    fn unit_of(&self, item: &Item<'_>) -> Result<f64> {
        Ok(if kind(item)? == "hinge" { self.compiler.angle } else { 1.0 })
    }

    /// Writes a joint and returns the pose of the body in the frame of the link that the joint moves.
    fn joint(
        &mut self,
        node: &'n Node,
        around: Around<'n>,
        body: &Node,
        (parent, link): (&str, &str),
        at: &Isometry3<f64>,
    ) -> Result<Isometry3<f64>> {
        let fallback = || format!("{}_joint", body.attribute("name").unwrap_or("body"));
        let given = node.attribute("name").map(str::to_owned);
        let name = own_name(&mut self.joints, &given.unwrap_or_else(fallback));
        if node.name == "freejoint" {
            self.write_joint(node.main_line, (&name, "floating"), (parent, link), at, "");
            return Ok(Isometry3::identity());
        }
        let item = self.classes.with(node, around.class)?;
        let kind = kind(&item)?;
        let anchor = around.frame * nalgebra::Point3::from(Vector3::from(item.array::<3>("pos")?.unwrap_or_default()));
        let anchor = Translation3::from(anchor.coords);
        if kind == "fixed" {
            self.remarks
                .push(node.remark("of type fixed, which MuJoCo does not have: the body is fixed to its parent"));
            self.write_joint(node.main_line, (&name, kind), (parent, link), at, "");
            return Ok(Isometry3::identity());
        }
        if kind == "free" || kind == "ball" {
            let of_urdf = if kind == "free" { "floating" } else { "spherical" };
            self.write_joint(node.main_line, (&name, of_urdf), (parent, link), &(at * anchor), "");
            return Ok(anchor.inverse() * Isometry3::identity());
        }
        if let Some(damping) =
            item.numbers("damping", 1, 3)?.and_then(|damping| damping.first().copied()).filter(|c| *c > LARGEST_DAMPING)
        {
            let text = format!("its damping of {damping:e} holds it: it is fixed at its reference");
            self.remarks.push(node.remark(&text));
            self.write_joint(node.main_line, (&name, "fixed"), (parent, link), &(at * anchor), "");
            return Ok(anchor.inverse() * Isometry3::identity());
        }
        let axis = Vector3::from(item.array::<3>("axis")?.unwrap_or([0.0, 0.0, 1.0]));
        let axis = unit(around.frame.rotation * axis)
            .ok_or_else(|| node.error("axis", item.text("axis").unwrap_or_default(), "an axis that is not zero"))?;
        let reference = item.number_or("ref", 0.0)? * self.unit_of(&item)?;
        let back = if kind == "hinge" {
            Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&axis, -reference))
        } else {
            Isometry3::from_parts(Translation3::from(*axis * -reference), UnitQuaternion::identity())
        };
        let limits = self.limits(&item, kind, &name)?;
        let inner = format!("<axis xyz=\"{} {} {}\"/>{limits}{}", axis.x, axis.y, axis.z, self.dynamics(&item, &name)?);
        let of_urdf = match (kind, limits.contains("lower")) {
            ("hinge", true) => "revolute",
            ("hinge", false) => "continuous",
            _ => "prismatic",
        };
        self.write_joint(node.main_line, (&name, of_urdf), (parent, link), &(at * anchor * back), &inner);
        Ok(anchor.inverse() * Isometry3::identity())
    }

    /// `<limit>`, with a range only where there is one.
    fn limits(&self, item: &Item<'_>, kind: &str, name: &str) -> Result<String> {
        let unit = self.unit_of(item)?;
        let range = limited(item, self.compiler, "range", "limited")?;
        let range = match (range, kind) {
            (Some([lower, upper]), _) => format!(" lower=\"{}\" upper=\"{}\"", lower * unit, upper * unit),
            (None, "slide") => " lower=\"-inf\" upper=\"inf\"".to_owned(),
            (None, _) => String::new(),
        };
        let of_joint = limited(item, self.compiler, "actuatorfrcrange", "actuatorfrclimited")?;
        let of_joint = of_joint.map(|[low, high]| low.abs().max(high.abs()));
        let of_actuators = self.actuators.get(name).and_then(|actuated| actuated.effort);
        let effort = of_joint.into_iter().chain(of_actuators).fold(f64::INFINITY, f64::min);
        Ok(format!("<limit{range} effort=\"{effort}\" velocity=\"inf\"/>"))
    }

    /// `<dynamics>` and `<mimic>` of a joint; also stores its drive data.
    fn dynamics(&mut self, item: &Item<'_>, name: &str) -> Result<String> {
        let damping = item.numbers("damping", 1, 3)?.unwrap_or_default();
        let friction = item.magnitude_or("frictionloss", 0.0)?;
        if damping.iter().skip(1).any(|higher| *higher != 0.0) {
            self.remarks.push(item.node.remark("only the part of its damping linear in velocity is taken"));
        }
        if item.numbers("stiffness", 1, 3)?.is_some_and(|stiffness| stiffness.iter().any(|value| *value != 0.0)) {
            self.remarks.push(item.node.remark("its spring (stiffness) is not taken"));
        }
        let armature = Some(item.magnitude_or("armature", 0.0)?).filter(|armature| *armature > 0.0);
        let gear_ratio = self.actuators.get(name).map(|actuated| actuated.gear).filter(|gear| *gear > 1.0);
        self.drives.insert(name.to_owned(), DriveData { gear_ratio, armature, ..DriveData::default() });
        let mut out = String::new();
        let damping = damping.first().copied().unwrap_or_default();
        if damping != 0.0 || friction != 0.0 {
            out = format!("<dynamics damping=\"{damping}\" friction=\"{friction}\"/>");
        }
        if let Some(Mimic { other, polynomial: [a0, a1] }) = self.mimics.get(name) {
            let reference = |joint: &str| self.references.get(joint).copied().unwrap_or_default();
            let offset = reference(name) + a0 - a1 * reference(other);
            out += &format!("<mimic joint=\"{}\" multiplier=\"{a1}\" offset=\"{offset}\"/>", escaped(other));
        }
        Ok(out)
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
            return Ok(Some((node.main_line, self.inertial(node)?)));
        }
        if self.compiler.inertia == FromGeoms::Never {
            return Ok(None);
        }
        let mut sum = Inertia::zero();
        let mut unread = None;
        for (node, around) in &parts.geoms {
            let geom = Geom::read(self.classes.with(node, around.class)?, self.compiler, &around.frame)?;
            let mut expected = "a mesh, box, capsule, cylinder, ellipsoid or sphere".to_owned();
            let mesh = |name: &str| self.meshes.inertia(name).map_err(|fault| expected = fault).ok();
            match geom.inertia(mesh)? {
                Some(inertia) => sum = sum.joined(&inertia),
                None if geom.is_solid() => {
                    self.remarks.push(node.remark(&format!("its mass is not read: expected {expected}")));
                    unread.get_or_insert((*node, geom.mesh.unwrap_or(geom.kind), expected));
                }
                None => {}
            }
        }
        // Another body that is fixed to this one may bring a mass.
        let alone = !parts.joints.is_empty() && parts.bodies.iter().all(|(body, _)| body.all("joint").next().is_some());
        if let Some((node, value, expected)) = unread.filter(|_| sum.mass == 0.0 && alone) {
            let expected = format!("{expected}, or an <inertial> of its body, which has no other mass");
            return Err(node.error("mesh", value, expected));
        }
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

/// How a joint moves. `fixed` is a word of other simulators, whose meaning is clear.
fn kind(item: &Item<'_>) -> Result<&'static str> {
    if item.text("type") == Some("fixed") {
        return Ok("fixed");
    }
    item.node.word("type", item.text("type").unwrap_or("hinge"), &["hinge", "slide", "ball", "free"])
}
