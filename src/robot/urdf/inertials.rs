//! Writes new inertias into the text of a URDF, for a file of its own: paths of meshes become absolute, all else stays unchanged.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::Range;

use super::Urdf;
use super::description::kind_of;
use super::mesh_paths;
use super::scan::Element;
use crate::robot::tree::{Inertia, Robot};

impl Urdf<'_> {
    /// The text with the inertias of some bodies of a tree. The link that a joint moves gets the inertia of its whole body; links fixed
    /// to it lose theirs.
    pub(in crate::robot) fn with_inertias(&self, text: &str, robot: &Robot, changed: &[usize]) -> String {
        let bodies: BTreeMap<&str, usize> = changed.iter().map(|body| (&*robot.bodies[*body].name, *body)).collect();
        let mut edits = mesh_paths::edits(self.file, text, self.text.elements());
        for link in self.text.owners("link") {
            let Some(name) = link.attribute("name") else { continue };
            let Some(body) = self.carrier(name, robot).and_then(|carrier| bodies.get(carrier)) else { continue };
            let moved = robot.bodies[*body].name == name;
            let inertial = if moved { written(&robot.bodies[*body].inertia) } else { String::new() };
            edits.extend(self.edits(text, link, inertial));
        }
        edits.sort_by_key(|(range, _)| range.start);
        let mut out = String::new();
        let mut from = 0;
        for (range, replacement) in edits {
            out.push_str(&text[from..range.start]);
            out.push_str(&replacement);
            from = range.end;
        }
        out.push_str(&text[from..]);
        out
    }

    /// Name of the link that represents a link's body: going from the link towards the base, the first one that a joint of the tree moves.
    fn carrier<'s>(&'s self, link: &'s str, robot: &Robot) -> Option<&'s str> {
        let mut at = link;
        loop {
            let joint = self.robot.joints.iter().find(|joint| joint.child.link == at)?;
            if kind_of(joint).is_some() && robot.bodies.iter().any(|body| body.joint.name == joint.name) {
                return Some(at);
            }
            at = &joint.parent.link;
        }
    }

    /// Places of a link's `<inertial>` elements, or the place for one, with their new text. A second one is removed; else it would count.
    fn edits(&self, text: &str, link: &Element<'_>, inertial: String) -> Vec<(Range<usize>, String)> {
        let own: Vec<_> = link
            .children
            .iter()
            .map(|child| &self.text.elements()[*child])
            .filter(|child| child.name == "inertial")
            .collect();
        if !own.is_empty() {
            let replacements = std::iter::once(inertial).chain(std::iter::repeat(String::new()));
            return own.iter().map(|own| own.range.clone()).zip(replacements).collect();
        }
        let edit = match text[link.range.start..link.inside].strip_suffix("/>") {
            Some(opening) if !inertial.is_empty() => (link.range.clone(), format!("{opening}>{inertial}</link>")),
            _ => (link.inside..link.inside, inertial),
        };
        vec![edit]
    }
}

/// The element `<inertial>` of an inertia in the frame of its link.
pub(in crate::robot) fn written(inertia: &Inertia) -> String {
    let (c, i) = (inertia.com, inertia.tensor);
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write!(
        out,
        "<inertial><origin xyz=\"{} {} {}\" rpy=\"0 0 0\"/><mass value=\"{}\"/>\
         <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/></inertial>",
        c.x,
        c.y,
        c.z,
        inertia.mass,
        i[(0, 0)],
        i[(0, 1)],
        i[(0, 2)],
        i[(1, 1)],
        i[(1, 2)],
        i[(2, 2)]
    );
    out
}
