//! Rewrites a checked text for urdf-rs: only elements that are read stay, and every value that the grammar does not take as written is
//! replaced by the value that it takes.

use std::fmt::Write as _;
use std::path::PathBuf;

use nalgebra::{Quaternion, UnitQuaternion};

use super::grammar;
use super::mesh::Unread;
use super::scan::Element;
use super::text::UrdfText;

/// From this version of URDF on, an `<origin>` may have `quat_xyzw`.
const QUATERNIONS: (u32, u32) = (1, 1);

/// From this version of URDF on, a missing limit means that there is none.
const OPEN_LIMITS: (u32, u32) = (1, 2);

/// Elements of URDF that nothing reads.
const UNUSED: [&str; 2] = ["calibration", "safety_controller"];

/// Attributes that are not numbers and may be missing.
const WORDS: [(&str, &str); 2] = [("robot", "name"), ("mesh", "filename")];

/// Value of a missing number that urdf-rs requires or would take as zero. A missing tensor is that of a point mass.
const DEFAULTS: [(&str, &str, &str); 8] = [
    ("inertia", "ixx", "0"),
    ("inertia", "ixy", "0"),
    ("inertia", "ixz", "0"),
    ("inertia", "iyy", "0"),
    ("inertia", "iyz", "0"),
    ("inertia", "izz", "0"),
    ("limit", "effort", "inf"),
    ("limit", "velocity", "inf"),
];

/// The same for limits in versions where a missing limit means none.
const OPEN: [(&str, &str, &str); 2] = [("limit", "lower", "-inf"), ("limit", "upper", "inf")];

/// A URDF of some links and joints of a text. It states no version: values that depend on the version are written explicitly.
pub(super) fn mended<'e>(text: &UrdfText<'_>, content: impl Iterator<Item = &'e Element<'e>>) -> String {
    let mut out = String::new();
    if let Some(robot) = text.elements().first() {
        open(text, robot, &mut out);
        content.for_each(|element| write(text, element, &mut out));
        out.push_str("</robot>\n");
    }
    out
}

/// Why the shape of a `<collision>` cannot be read: its kind is unknown, or it is a mesh without a file or with an invalid scale.
pub(super) fn unread(text: &UrdfText<'_>, collision: &Element<'_>) -> Option<Unread> {
    let shape = text.child(collision, "geometry").and_then(|geometry| text.inside(geometry).next());
    let name = shape.map_or("", |shape| shape.name);
    let because = |what: &str, expected: &str| Some((PathBuf::from(what), expected.to_owned()));
    match shape {
        Some(mesh) if name == "mesh" => match (mesh.attribute("filename"), mesh.attribute("scale")) {
            (None | Some(""), _) => because("(no filename)", "a mesh with a filename"),
            (Some(file), Some(scale)) if grammar::parsed(scale, 3, false).is_none() => {
                because(file, "a scale of 3 numbers")
            }
            _ => None,
        },
        Some(_) if grammar::children_of("geometry").iter().any(|(known, _)| *known == name) => None,
        _ => because(&format!("<{name}>"), "one box, cylinder, capsule, sphere or mesh"),
    }
}

/// Writes an element with those parts of it that are read.
fn write(text: &UrdfText<'_>, element: &Element<'_>, out: &mut String) {
    open(text, element, out);
    for (name, count) in grammar::children_of(element.name).iter().filter(|(name, _)| !UNUSED.contains(name)) {
        let all = text.children(element, name).filter(|child| *name != "collision" || unread(text, child).is_none());
        all.take(count.most()).for_each(|child| write(text, child, out));
    }
    if element.name == "inertial" && text.child(element, "inertia").is_none() {
        let zero = DEFAULTS.iter().filter(|(owner, ..)| *owner == "inertia");
        tag("inertia", zero.map(|(_, name, value)| (*name, (*value).to_owned())), out);
        out.push_str("</inertia>\n");
    }
    // Writing to a String cannot fail.
    let _ = writeln!(out, "</{}>", element.name);
}

/// Writes the opening tag of an element.
fn open(text: &UrdfText<'_>, element: &Element<'_>, out: &mut String) {
    let of_element = |(owner, name): &(&str, &'static str)| (*owner == element.name).then_some(*name);
    let words = grammar::NAMES.iter().chain(&WORDS).filter_map(of_element);
    let words = words.filter_map(|name| Some((name, element.attribute(name)?.to_owned())));
    let numbers = grammar::numbers_of(element.name).filter_map(|name| Some((name, number(text, element, name)?)));
    tag(element.name, words.chain(numbers), out);
}

/// Writes an opening tag.
pub(super) fn tag<'n>(name: &str, attributes: impl Iterator<Item = (&'n str, String)>, out: &mut String) {
    let _ = write!(out, "<{name}");
    for (name, value) in attributes {
        let value = value.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        let _ = write!(out, " {name}=\"{value}\"");
    }
    out.push('>');
}

/// The numbers of an attribute in the form that urdf-rs reads; `None` where the default of urdf-rs is right.
fn number(text: &UrdfText<'_>, element: &Element<'_>, name: &str) -> Option<String> {
    let version = text.version();
    let turned = || rotation(element).filter(|_| version >= QUATERNIONS);
    match (name, element.given(name)) {
        ("quat_xyzw", _) => None,
        ("rpy", value) => turned().or_else(|| value.map(plain)),
        (_, Some(value)) => Some(plain(value)),
        (_, None) => {
            let open = OPEN.iter().filter(|_| version >= OPEN_LIMITS);
            let default = DEFAULTS.iter().chain(open).find(|(owner, own, _)| *owner == element.name && *own == name);
            default.map(|(_, _, value)| (*value).to_owned())
        }
    }
}

/// `quat_xyzw` of an `<origin>` as angles about the fixed axes x, y, z in this order [rad].
fn rotation(origin: &Element<'_>) -> Option<String> {
    let [x, y, z, w] = grammar::parsed(origin.given("quat_xyzw")?, 4, false)?.try_into().ok()?;
    let (roll, pitch, yaw) = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9)?.euler_angles();
    Some(format!("{roll} {pitch} {yaw}"))
}

/// Numbers with their commas replaced by spaces.
fn plain(value: &str) -> String {
    value.replace(',', " ")
}
