//! What a URDF must hold: its elements, their names, and numbers that are numbers.
//!
//! Elements that URDF does not know are extensions of some tool and left alone, unless they look like a misspelt one.

use super::scan::Element;
use super::text::UrdfText;
use crate::error::{Error, Place, Result};
use crate::toml_input::nearest;

/// How often an element stands in another.
enum Count {
    Any,
    AtMostOne,
    One,
}
use Count::{Any, AtMostOne, One};

/// Elements by the one around them.
const ELEMENTS: &[(&str, &[(&str, Count)])] = &[
    ("robot", &[("link", Any), ("joint", Any), ("material", Any)]),
    ("link", &[("inertial", AtMostOne), ("visual", Any), ("collision", Any)]),
    ("inertial", &[("origin", AtMostOne), ("mass", One), ("inertia", One)]),
    ("visual", &[("origin", AtMostOne), ("geometry", One), ("material", AtMostOne)]),
    ("collision", &[("origin", AtMostOne), ("geometry", One)]),
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
const NAMES: &[(&str, &str)] = &[
    ("link", "name"),
    ("joint", "name"),
    ("joint", "type"),
    ("parent", "link"),
    ("child", "link"),
    ("mimic", "joint"),
    ("mesh", "filename"),
];

/// Types of joints that a tree of turning and sliding bodies can have.
const JOINT_TYPES: [&str; 4] = ["revolute", "continuous", "prismatic", "fixed"];

/// An attribute that holds numbers.
struct Numbers {
    element: &'static str,
    attribute: &'static str,
    count: usize,
    needed: bool,
}

const fn needed(element: &'static str, attribute: &'static str, count: usize) -> Numbers {
    Numbers { element, attribute, count, needed: true }
}

const fn optional(element: &'static str, attribute: &'static str, count: usize) -> Numbers {
    Numbers { element, attribute, count, needed: false }
}

const NUMBERS: &[Numbers] = &[
    optional("origin", "xyz", 3),
    optional("origin", "rpy", 3),
    needed("axis", "xyz", 3),
    needed("mass", "value", 1),
    needed("inertia", "ixx", 1),
    needed("inertia", "ixy", 1),
    needed("inertia", "ixz", 1),
    needed("inertia", "iyy", 1),
    needed("inertia", "iyz", 1),
    needed("inertia", "izz", 1),
    optional("limit", "lower", 1),
    optional("limit", "upper", 1),
    optional("limit", "effort", 1),
    // URDF 1.2 made it optional: see `velocity_may_miss`.
    needed("limit", "velocity", 1),
    optional("dynamics", "damping", 1),
    optional("dynamics", "friction", 1),
    optional("mimic", "multiplier", 1),
    optional("mimic", "offset", 1),
    needed("box", "size", 3),
    needed("sphere", "radius", 1),
    needed("cylinder", "radius", 1),
    needed("cylinder", "length", 1),
    needed("capsule", "radius", 1),
    needed("capsule", "length", 1),
    optional("mesh", "scale", 3),
];

/// Checks every element that URDF knows.
///
/// # Errors
/// The first one that lacks something, has it twice, or holds what is no number or name.
pub(super) fn check(text: &UrdfText<'_>) -> Result<()> {
    let elements = text.elements();
    if elements.first().is_none_or(|root| root.name != "robot") {
        let line = elements.first().map_or(1, |root| root.line);
        return Err(text.broken(line, "one <robot> around everything"));
    }
    let mut known = vec![false; elements.len()];
    for (index, element) in elements.iter().enumerate() {
        known[index] = match element.parent {
            None => true,
            Some(parent) => known[parent] && is_known(text, index, elements[parent].name)?,
        };
        if known[index] {
            check_children(text, element)?;
            check_names(text, element)?;
            check_numbers(text, element)?;
        }
    }
    Ok(())
}

fn children_of(name: &str) -> &'static [(&'static str, Count)] {
    ELEMENTS.iter().find(|(parent, _)| *parent == name).map_or(&[], |(_, children)| children)
}

fn is_known(text: &UrdfText<'_>, index: usize, parent: &str) -> Result<bool> {
    let element = &text.elements()[index];
    let names = || children_of(parent).iter().map(|(name, _)| *name);
    if names().any(|name| name == element.name) {
        return Ok(true);
    }
    match nearest(element.name, names()) {
        Some(near) => Err(text.broken(element.line, format!("the element <{near}>, not <{}>", element.name))),
        None => Ok(false),
    }
}

fn check_children(text: &UrdfText<'_>, element: &Element<'_>) -> Result<()> {
    let inside = || element.children.iter().map(|&child| &text.elements()[child]);
    for (name, count) in children_of(element.name) {
        let lines: Vec<usize> = inside().filter(|child| child.name == *name).map(|child| child.line).collect();
        match (count, lines.len()) {
            (One, 0) => {
                return Err(text.broken(element.line, format!("an element <{name}> in {}", text.title(element))));
            }
            (One | AtMostOne, 2..) => {
                return Err(text.broken(lines[1], format!("one element <{name}> in {}", text.title(element))));
            }
            _ => {}
        }
    }
    if element.name == "geometry" && element.children.len() != 1 {
        let expected = "one box, cylinder, capsule, sphere or mesh";
        return Err(text.broken(element.line, format!("{expected} in {}", text.title(element))));
    }
    Ok(())
}

fn check_names(text: &UrdfText<'_>, element: &Element<'_>) -> Result<()> {
    for (_, attribute) in NAMES.iter().filter(|(name, _)| *name == element.name) {
        if element.attribute(attribute).is_none_or(str::is_empty) {
            return Err(error(text, element, attribute, "", "a name (missing)"));
        }
    }
    match (element.name, element.attribute("type")) {
        ("joint", Some(kind)) if !JOINT_TYPES.contains(&kind) => {
            Err(error(text, element, "type", kind, &JOINT_TYPES.join(" or ")))
        }
        _ => Ok(()),
    }
}

fn check_numbers(text: &UrdfText<'_>, element: &Element<'_>) -> Result<()> {
    for Numbers { attribute, count, needed, .. } in NUMBERS.iter().filter(|numbers| numbers.element == element.name) {
        let expected = if *count == 1 { "a number".to_owned() } else { format!("{count} numbers") };
        match element.attribute(attribute) {
            None if *attribute == "velocity" && velocity_may_miss(text) => {}
            None if *needed => return Err(error(text, element, attribute, "", &format!("{expected} (missing)"))),
            None => {}
            // A limit may be infinite.
            Some(value) if holds_numbers(value, *count, element.name == "limit") => {}
            Some(value) => return Err(error(text, element, attribute, &format!("\"{value}\""), &expected)),
        }
    }
    Ok(())
}

fn velocity_may_miss(text: &UrdfText<'_>) -> bool {
    let version = text.elements().first().and_then(|robot| robot.attribute("version"));
    !matches!(version, None | Some("1.0" | "1.1"))
}

fn holds_numbers(text: &str, count: usize, infinite: bool) -> bool {
    let is_number =
        |word: &str| word.parse::<f64>().is_ok_and(|value| value.is_finite() || (infinite && !value.is_nan()));
    text.split_whitespace().count() == count && text.split_whitespace().all(is_number)
}

fn error(text: &UrdfText<'_>, element: &Element<'_>, attribute: &str, value: &str, expected: &str) -> Error {
    let key = match element.name {
        "link" | "joint" => format!("{}: {attribute}", text.title(element)),
        name => format!("{}: {name} {attribute}", text.title(element)),
    };
    Error::input(text.file(), Place::Line(element.line), key, value, expected)
}
