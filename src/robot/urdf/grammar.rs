//! Required content of a URDF: its elements, their names, and attributes that are valid numbers.
//!
//! Unknown elements are extensions of some tool and are ignored, unless they look like a misspelt URDF element. Elements that only a
//! display needs are ignored too. An element of xacro is refused: it is not URDF.

use std::collections::BTreeSet;

use super::scan::Element;
use super::text::UrdfText;
use crate::error::{Error, Place, Result};
use crate::files::{PLAIN_NAME, is_plain_name};
use crate::robot::remark::Remark;
use crate::toml_input::nearest;

/// How often an element may occur inside its parent.
pub(super) enum Count {
    Any,
    /// Of several, the first one counts.
    AtMostOne,
    One,
}
use Count::{Any, AtMostOne, One};

impl Count {
    /// How many of them are read.
    pub(super) fn most(&self) -> usize {
        match self {
            Any => usize::MAX,
            AtMostOne | One => 1,
        }
    }
}

/// Elements, by their parent element.
const ELEMENTS: &[(&str, &[(&str, Count)])] = &[
    ("robot", &[("link", Any), ("joint", Any)]),
    ("link", &[("inertial", AtMostOne), ("collision", Any)]),
    ("inertial", &[("origin", AtMostOne), ("mass", One), ("inertia", AtMostOne)]),
    ("collision", &[("origin", AtMostOne), ("geometry", AtMostOne)]),
    ("geometry", &[("box", Any), ("cylinder", Any), ("capsule", Any), ("sphere", Any), ("mesh", Any)]),
    (
        "joint",
        &[
            ("parent", One),
            ("child", One),
            ("origin", AtMostOne),
            ("axis", AtMostOne),
            ("limit", AtMostOne),
            ("dynamics", AtMostOne),
            ("mimic", AtMostOne),
            ("calibration", AtMostOne),
            ("safety_controller", AtMostOne),
        ],
    ),
];

/// Attributes that hold names.
pub(super) const NAMES: &[(&str, &str)] = &[
    ("link", "name"),
    ("joint", "name"),
    ("joint", "type"),
    ("parent", "link"),
    ("child", "link"),
    ("mimic", "joint"),
];

/// Types of joints; the last one occurs in Bullet's dialect only.
const TYPES: [&str; 7] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical"];

/// Largest number of links, and of joints: the largest robots have some hundreds. What relates them to each other grows with their square.
const MOST_OWNERS: usize = 2000;

/// Elements that only a display needs: their content is not checked.
const DISPLAY: [&str; 2] = ["visual", "material"];

/// The word that the address of xacro's XML namespace contains.
const XACRO: &str = "xacro";

/// An attribute that holds numbers.
struct Numbers {
    element: &'static str,
    attribute: &'static str,
    count: usize,
    needed: bool,
    /// Largest magnitude. It is far above that of any machine, and squares and products of such numbers stay finite.
    most: f64,
    unit: &'static str,
}

impl Numbers {
    fn expected(&self) -> String {
        if self.count == 1 { "a number".to_owned() } else { format!("{} numbers", self.count) }
    }
}

const fn needed(
    element: &'static str,
    attribute: &'static str,
    count: usize,
    most: f64,
    unit: &'static str,
) -> Numbers {
    Numbers { element, attribute, count, needed: true, most, unit }
}

const fn optional(
    element: &'static str,
    attribute: &'static str,
    count: usize,
    most: f64,
    unit: &'static str,
) -> Numbers {
    Numbers { element, attribute, count, needed: false, most, unit }
}

/// [m] Largest length.
const LENGTH: f64 = 1e5;
/// [rad] Largest angle: a thousand turns.
const ANGLE: f64 = 1e4;
/// [kg] Largest mass.
const MASS: f64 = 1e9;
/// [kg·m²] Largest moment of inertia.
const INERTIA: f64 = 1e12;
/// [N·m·s/rad or N·s/m], [N·m or N] Largest damping and friction of a joint.
pub(in crate::robot) const FRICTION: f64 = 1e10;
/// [1] Largest factor.
const FACTOR: f64 = 1e6;
/// A limit may be arbitrarily large or infinite; a very large limit counts as none.
const ANY: f64 = f64::INFINITY;

const NUMBERS: &[Numbers] = &[
    optional("origin", "xyz", 3, LENGTH, "m"),
    optional("origin", "rpy", 3, ANGLE, "rad"),
    optional("origin", "quat_xyzw", 4, FACTOR, "1"),
    needed("axis", "xyz", 3, FACTOR, "1"),
    needed("mass", "value", 1, MASS, "kg"),
    needed("inertia", "ixx", 1, INERTIA, "kg·m²"),
    optional("inertia", "ixy", 1, INERTIA, "kg·m²"),
    optional("inertia", "ixz", 1, INERTIA, "kg·m²"),
    needed("inertia", "iyy", 1, INERTIA, "kg·m²"),
    optional("inertia", "iyz", 1, INERTIA, "kg·m²"),
    needed("inertia", "izz", 1, INERTIA, "kg·m²"),
    optional("limit", "lower", 1, ANY, ""),
    optional("limit", "upper", 1, ANY, ""),
    optional("limit", "effort", 1, ANY, ""),
    optional("limit", "velocity", 1, ANY, ""),
    optional("dynamics", "damping", 1, FRICTION, "N·m·s/rad"),
    optional("dynamics", "friction", 1, FRICTION, "N·m"),
    optional("mimic", "multiplier", 1, FACTOR, "1"),
    optional("mimic", "offset", 1, ANGLE, "rad"),
    needed("box", "size", 3, LENGTH, "m"),
    needed("sphere", "radius", 1, LENGTH, "m"),
    needed("cylinder", "radius", 1, LENGTH, "m"),
    needed("cylinder", "length", 1, LENGTH, "m"),
    needed("capsule", "radius", 1, LENGTH, "m"),
    needed("capsule", "length", 1, LENGTH, "m"),
];

/// Checks every element that belongs to URDF.
///
/// # Errors
/// The first element that lacks a part, has one twice, or has an invalid number or name; or an element of xacro.
pub(super) fn check(text: &UrdfText<'_>) -> Result<Vec<Remark>> {
    let elements = text.elements();
    if elements.first().is_none_or(|root| root.name != "robot") {
        let line = elements.first().map_or(1, |root| root.line);
        return Err(text.broken(line, "one outermost element <robot>"));
    }
    for kind in ["link", "joint"] {
        if let Some(beyond) = text.owners(kind).nth(MOST_OWNERS) {
            return Err(text.broken(beyond.line, format!("at most {MOST_OWNERS} elements <{kind}>")));
        }
    }
    check_plain(text)?;
    let mut remarks = Vec::new();
    let mut known = vec![false; elements.len()];
    for (index, element) in elements.iter().enumerate() {
        known[index] = match element.parent {
            None => true,
            Some(parent) => known[parent] && is_known(text, index, elements[parent].name)?,
        };
        if known[index] {
            check_attributes(text, element)?;
            check_children(text, element, &mut remarks)?;
            check_names(text, element)?;
            check_numbers(text, element, &mut remarks)?;
        }
    }
    Ok(remarks)
}

/// Refuses elements of xacro. A namespace of xacro that is declared but not used is accepted.
fn check_plain(text: &UrdfText<'_>) -> Result<()> {
    let spaces = text.elements().first().map_or(&[][..], |robot| &robot.attributes);
    let declared = spaces.iter().filter(|(_, address)| address.contains(XACRO));
    let prefixes: BTreeSet<&str> =
        declared.filter_map(|(name, _)| name.strip_prefix("xmlns:")).chain([XACRO]).collect();
    let foreign =
        |element: &&Element<'_>| element.name.split_once(':').is_some_and(|(prefix, _)| prefixes.contains(prefix));
    match text.elements().iter().find(foreign) {
        Some(element) => {
            let (file, place) = (text.file(), Place::Line(element.line));
            let value = format!("<{}>", element.name);
            Err(Error::input(file, place, "", "", format!("plain URDF, not {value}; run xacro on this file first")))
        }
        None => Ok(()),
    }
}

/// The elements that an element of this name may contain.
pub(super) fn children_of(name: &str) -> &'static [(&'static str, Count)] {
    ELEMENTS.iter().find(|(parent, _)| *parent == name).map_or(&[], |(_, children)| children)
}

/// The attributes of an element that hold numbers. A scale is checked where the mesh is read: a faulty scale loses one shape, not the file.
pub(super) fn numbers_of(name: &str) -> impl Iterator<Item = &'static str> {
    let scale = (name == "mesh").then_some("scale");
    NUMBERS.iter().filter(move |numbers| numbers.element == name).map(|numbers| numbers.attribute).chain(scale)
}

fn is_known(text: &UrdfText<'_>, index: usize, parent: &str) -> Result<bool> {
    let element = &text.elements()[index];
    let names = || children_of(parent).iter().map(|(name, _)| *name);
    if names().any(|name| name == element.name) {
        return Ok(true);
    }
    if element.name.contains(':') || DISPLAY.contains(&element.name) {
        return Ok(false);
    }
    match nearest(element.name, names()) {
        Some(near) => Err(text.broken(element.line, format!("the element <{near}>, not <{}>", element.name))),
        None => Ok(false),
    }
}

fn check_children<'a>(text: &UrdfText<'a>, element: &Element<'a>, remarks: &mut Vec<Remark>) -> Result<()> {
    for (name, count) in children_of(element.name) {
        let found: Vec<_> = text.children(element, name).collect();
        match (count, &found[..]) {
            (One, []) => {
                return Err(text.broken(element.line, format!("an element <{name}> in {}", text.title(element))));
            }
            (One, [_, second, ..]) => {
                return Err(text.broken(second.line, format!("one element <{name}> in {}", text.title(element))));
            }
            (AtMostOne, [first, second, ..]) => {
                let ignored = format!("a second <{name}> has no effect, the first in line {} counts", first.line);
                remarks.push(text.remark_at(second, &ignored));
            }
            _ => {}
        }
    }
    if element.name == "geometry" && element.children.len() > 1 {
        let expected = "one box, cylinder, capsule, sphere or mesh";
        return Err(text.broken(element.line, format!("{expected} in {}", text.title(element))));
    }
    Ok(())
}

/// XML allows an attribute only once.
fn check_attributes(text: &UrdfText<'_>, element: &Element<'_>) -> Result<()> {
    let mut seen = BTreeSet::new();
    match element.attributes.iter().find(|(name, _)| !seen.insert(*name)) {
        Some((name, _)) => Err(text.broken(
            element.line,
            format!("the attribute `{name}` once in <{}> of {}", element.name, text.title(element)),
        )),
        None => Ok(()),
    }
}

fn check_names(text: &UrdfText<'_>, element: &Element<'_>) -> Result<()> {
    for (_, attribute) in NAMES.iter().filter(|(name, _)| *name == element.name) {
        let name = element.attribute(attribute).unwrap_or_default();
        if name.is_empty() {
            return Err(error(text, element, attribute, "", "a name (missing)"));
        }
        if !is_plain_name(name) {
            return Err(error(text, element, attribute, name, PLAIN_NAME));
        }
    }
    match (element.name, element.attribute("type")) {
        ("joint", Some(kind)) if !TYPES.contains(&kind) => Err(error(text, element, "type", kind, &TYPES.join(" or "))),
        _ => Ok(()),
    }
}

fn check_numbers<'a>(text: &UrdfText<'a>, element: &Element<'a>, remarks: &mut Vec<Remark>) -> Result<()> {
    for numbers in NUMBERS.iter().filter(|numbers| numbers.element == element.name) {
        let Numbers { attribute, needed, .. } = numbers;
        match element.attribute(attribute) {
            None if *needed => {
                return Err(error(text, element, attribute, "", &format!("{} (missing)", numbers.expected())));
            }
            // Products of inertia may be left out where the frame is that of the principal axes.
            None if element.name == "inertia" => {
                remarks.push(text.remark_at(element, &format!("inertia without {attribute}: taken as 0")));
            }
            None => {}
            Some(value) if value.trim().is_empty() && !*needed => {
                let taken = format!("{} {attribute} = \"\": taken as not given", element.name);
                remarks.push(text.remark_at(element, &taken));
            }
            Some(value) => check_value(text, element, numbers, value, remarks)?,
        }
    }
    Ok(())
}

/// The value of an attribute that holds numbers.
fn check_value<'a>(
    text: &UrdfText<'a>,
    element: &Element<'a>,
    numbers: &Numbers,
    value: &str,
    remarks: &mut Vec<Remark>,
) -> Result<()> {
    let Numbers { attribute, count, most, unit, .. } = numbers;
    let quoted = format!("\"{}\"", value.chars().take(60).collect::<String>());
    let refused = |expected: &str| Err(error(text, element, attribute, &quoted, expected));
    let expected = numbers.expected();
    let Some(parsed) = parsed(value, *count, most.is_infinite()) else {
        let unexpanded = value.contains("${") || value.contains("$(");
        let remedy = if unexpanded { "; run xacro on this file first" } else { "" };
        return refused(&format!("{expected}{remedy}"));
    };
    if parsed.iter().any(|number| number.abs() > *most) {
        return refused(&format!("{expected} from -{most:e} to {most:e} [{unit}]"));
    }
    if value.contains(',') {
        let taken = format!("{} {attribute} = {quoted}: the commas are taken as spaces", element.name);
        remarks.push(text.remark_at(element, &taken));
    }
    Ok(())
}

/// A fixed number of values, finite unless they may be infinite. Several values may have a comma behind each but the last.
pub(super) fn parsed(text: &str, count: usize, infinite: bool) -> Option<Vec<f64>> {
    let number =
        |word: &str| word.parse::<f64>().ok().filter(|value| value.is_finite() || (infinite && !value.is_nan()));
    let mut left = count;
    let number = |word: &str| {
        left = left.saturating_sub(1);
        number(if left > 0 { word.strip_suffix(',').unwrap_or(word) } else { word })
    };
    let numbers: Option<Vec<f64>> = text.split_whitespace().take(count + 1).map(number).collect();
    numbers.filter(|numbers| numbers.len() == count)
}

fn error(text: &UrdfText<'_>, element: &Element<'_>, attribute: &str, value: &str, expected: &str) -> Error {
    let key = match element.name {
        "link" | "joint" => format!("{}: {attribute}", text.title(element)),
        name => format!("{}: {name} {attribute}", text.title(element)),
    };
    Error::input(text.file(), Place::Line(element.line), key, value, expected)
}
