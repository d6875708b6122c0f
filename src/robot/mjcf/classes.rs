//! Default classes, and the values that attributes take from them.
//!
//! An attribute is the element's own; else that of its `class`; else that of the innermost `childclass` around it; else that of the class `main`.
//! A class inherits all attributes of its parent class and may override them.

use std::collections::BTreeMap;

use super::document::Node;
use crate::error::Result;

/// Elements of `<actuator>`: they share their defaults.
pub(super) const ACTUATORS: [&str; 9] =
    ["general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion"];

/// [1] Largest magnitude of a number: squares and products of such numbers stay finite.
const LARGEST: f64 = 1e12;

/// Name of the outermost class.
const MAIN: &str = "main";

/// Largest number of attributes of all classes together, inherited ones included: models of many robots have a few thousand.
const MOST_ATTRIBUTES: usize = 200_000;

type Attributes = BTreeMap<String, String>;

/// All classes by their names.
#[derive(Debug, Default)]
pub(super) struct Classes {
    /// Attributes of elements by the element's name.
    classes: BTreeMap<String, BTreeMap<String, Attributes>>,
    /// Number of all attributes.
    attributes: usize,
}

impl Classes {
    /// Reads all elements `<default>` of the root.
    ///
    /// # Errors
    /// A nested class has no name.
    pub fn read(root: &Node) -> Result<Self> {
        let mut classes = Self::default();
        classes.classes.entry(MAIN.to_owned()).or_default();
        for default in root.all("default") {
            let name = default.attribute("class").unwrap_or(MAIN);
            classes.add(default, name, MAIN)?;
        }
        Ok(classes)
    }

    fn add(&mut self, node: &Node, name: &str, parent: &str) -> Result<()> {
        let inherited = self.classes.get(parent).cloned().unwrap_or_default();
        let own: usize = node.children.iter().map(|child| child.attributes().count()).sum();
        self.attributes += own + inherited.values().map(BTreeMap::len).sum::<usize>();
        if self.attributes > MOST_ATTRIBUTES {
            return Err(node.error(
                "",
                "",
                format!("at most {MOST_ATTRIBUTES} attributes of default classes, inherited ones included"),
            ));
        }
        let class = self.classes.entry(name.to_owned()).or_insert(inherited);
        for child in node.children.iter().filter(|child| child.name != "default") {
            let own = class.entry(shared(&child.name).to_owned()).or_default();
            own.extend(child.attributes().map(|(key, value)| (key.to_owned(), value.to_owned())));
        }
        for child in node.all("default") {
            let name_of_child = child.attribute("class").ok_or_else(|| child.error("class", "", "a name (missing)"))?;
            self.add(child, name_of_child, name)?;
        }
        Ok(())
    }

    /// An element with its defaults; `around` is the innermost `childclass` around it.
    ///
    /// # Errors
    /// Its class does not exist.
    pub fn with<'n>(&'n self, node: &'n Node, around: Option<&str>) -> Result<Item<'n>> {
        let name = node.attribute("class").or(around).unwrap_or(MAIN);
        let class = self.classes.get(name).ok_or_else(|| node.error("class", name, "a default class of this file"))?;
        Ok(Item { node, defaults: class.get(shared(&node.name)) })
    }
}

/// The element name under which the classes store the defaults of an element.
fn shared(name: &str) -> &str {
    if ACTUATORS.contains(&name) { ACTUATORS[0] } else { name }
}

/// An element with its defaults.
#[derive(Clone, Copy)]
pub(super) struct Item<'n> {
    pub node: &'n Node,
    defaults: Option<&'n Attributes>,
}

impl<'n> Item<'n> {
    /// An attribute that is not blank.
    pub fn text(&self, name: &str) -> Option<&'n str> {
        let default = || self.defaults.and_then(|all| all.get(name)).map(|value| value.trim());
        self.node.attribute(name).or_else(default).filter(|value| !value.is_empty())
    }

    /// The numbers of an attribute: at least `least` and at most `most` of them.
    ///
    /// # Errors
    /// A word is not a number, a number is not finite or too large, or their count is wrong.
    pub fn numbers(&self, name: &str, least: usize, most: usize) -> Result<Option<Vec<f64>>> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let parsed: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let sound = |numbers: &Vec<f64>| numbers.iter().all(|number| number.abs() <= LARGEST);
        match parsed.filter(sound) {
            Some(numbers) if (least..=most).contains(&numbers.len()) => Ok(Some(numbers)),
            _ => {
                let count = if least == most { least.to_string() } else { format!("{least} to {most}") };
                let shown: String = text.chars().take(60).collect();
                Err(self.node.error(name, &shown, format!("{count} numbers from -{LARGEST:e} to {LARGEST:e}")))
            }
        }
    }

    /// A fixed count of numbers.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn array<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>> {
        Ok(self.numbers(name, N, N)?.and_then(|numbers| numbers.try_into().ok()))
    }

    /// One number, or a default.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn number_or(&self, name: &str, default: f64) -> Result<f64> {
        Ok(self.array::<1>(name)?.map_or(default, |[number]| number))
    }

    /// One number that is not negative, or a default.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers); it is negative.
    pub fn magnitude_or(&self, name: &str, default: f64) -> Result<f64> {
        let number = self.number_or(name, default)?;
        if number < 0.0 { Err(self.node.error(name, &number.to_string(), "a number ≥ 0")) } else { Ok(number) }
    }

    /// `true`, `false`, or `None` for `auto`.
    ///
    /// # Errors
    /// It is another word.
    pub fn switch(&self, name: &str) -> Result<Option<bool>> {
        match self.text(name).map(|word| self.node.word(name, word, &["true", "false", "auto"])).transpose()? {
            Some("true") => Ok(Some(true)),
            Some("false") => Ok(Some(false)),
            _ => Ok(None),
        }
    }
}
