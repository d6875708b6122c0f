//! Converts MJCF, the XML format of MuJoCo, to a URDF.
//!
//! ```text
//!   body with joints j_1 … j_k  →  k links in series, all but the last without mass
//!   frame of a link             =  frame of its body, moved to the anchor of the joint that moves the link: no other joint moves it
//!   joint with a reference      →  origin turned or moved back by `ref`: positions equal MuJoCo's qpos
//!   armature                    →  rotor inertia of the first model, J_r = armature / N²
//! ```
//! Damping and dry friction of a joint become `<dynamics>`, ranges and forces `<limit>`, an equality of two joints `<mimic>`. Free and ball
//! joints become floating and spherical ones, which the URDF reader holds fixed. What is not taken is remarked, with its line. Where the
//! URDF reader reports an element of an included file, it gives the line of the `<include>`.
//! Left out: springs of joints, tendons, closed loops, contacts, sensors, keyframes, gains of actuators.
//! Reference: MuJoCo documentation, XML reference, version 4.0.

mod actuators;
mod bodies;
mod classes;
mod compiler;
mod document;
mod geoms;
mod meshes;
mod written;

use std::path::Path;

use self::bodies::Walk;
use self::classes::Classes;
use self::compiler::Compiler;
use self::meshes::Meshes;
use super::remark::Remark;
use super::robot_file::RobotFile;
use crate::error::Result;

/// Sections that are read, and sections that are ignored without a remark because they do not change the motion.
const READ: [&str; 12] = [
    "compiler",
    "option",
    "default",
    "asset",
    "worldbody",
    "actuator",
    "equality",
    "visual",
    "statistic",
    "size",
    "custom",
    "sensor",
];

/// Whether a text is MJCF: its outermost element is `<mujoco>`. This also works for a text with errors further on.
pub(super) fn is_mjcf(text: &str) -> bool {
    let opening = |name: &str| text.find(&format!("<{name}")).unwrap_or(usize::MAX);
    opening("mujoco") < opening("robot")
}

/// The robot of an MJCF text; included files are read from disk.
///
/// # Errors
/// It is not XML, an included file cannot be read, or a value has no meaning.
pub(super) fn read(file: &Path, text: &str) -> Result<RobotFile> {
    let root = document::read(file, text)?;
    let mut remarks: Vec<Remark> = Vec::new();
    for node in root.children.iter().filter(|node| !READ.contains(&node.name.as_str())) {
        remarks.push(node.remark("this section is not read"));
    }
    let classes = Classes::read(&root)?;
    let compiler = Compiler::read(&root, &classes, &mut remarks)?;
    let actuators = actuators::actuators(&root, &classes, &compiler, &mut remarks)?;
    let mimics = actuators::mimics(&root, &classes, &mut remarks)?;
    let meshes = Meshes::read(file, &root, &classes, &compiler, &mut remarks)?;
    let walk = Walk::new(&root, &classes, &compiler, (actuators, mimics), meshes, remarks);
    let gravity = compiler.gravity;
    let (written, drives, remarks) = walk.all(&root)?;
    let (text, lines) = written.finish();
    Ok(RobotFile { text, lines: Some(lines), remarks, drives, gravity })
}
