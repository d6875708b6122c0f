//! The question which quantities of which joints an experiment measures.

use crate::error::{Error, Place, Result};
use crate::robot::Model;
use crate::toml_input::nearest;

/// What is to be measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measurands {
    /// Friction, equation 6.
    pub friction: bool,
    /// The gap.
    pub backlash: bool,
    /// Indices of the joints, in the order of the model.
    pub joints: Vec<usize>,
}

impl Measurands {
    /// Reads `friction`, `backlash` or `friction,backlash`, for all joints or followed by ` of joint1,joint2`; `None` where the text names
    /// neither of them.
    ///
    /// # Errors
    /// Other quantities beside them, or a joint that the model lacks.
    pub fn parse(text: &str, model: &Model) -> Result<Option<Self>> {
        let (quantities, joints) =
            text.split_once(" of ").map_or((text, None), |(first, second)| (first, Some(second)));
        let names: Vec<&str> = quantities.split([',', '|']).map(str::trim).collect();
        let [friction, backlash] = ["friction", "backlash"].map(|name| names.contains(&name));
        if !friction && !backlash {
            return Ok(None);
        }
        let refused = |expected: String| Error::input("command line".as_ref(), Place::File, "question", text, expected);
        if quantities.contains('|') || names.len() != usize::from(friction) + usize::from(backlash) {
            return Err(refused("friction, backlash or friction,backlash, each once".to_owned()));
        }
        let Some(joints) = joints else {
            return Ok(Some(Self { friction, backlash, joints: (0..model.joints.len()).collect() }));
        };
        let mut found = Vec::new();
        for name in joints.split(',').map(str::trim) {
            let Some(index) = model.joints.iter().position(|joint| joint.name == name) else {
                let known = || model.joints.iter().map(|joint| joint.name.as_str());
                let hint = nearest(name, known()).map_or_else(String::new, |near| format!("; {name} may be {near}"));
                let names: Vec<&str> = known().collect();
                return Err(refused(format!("joints of the model after `of`: {}{hint}", names.join(", "))));
            };
            found.push(index);
        }
        found.sort_unstable();
        found.dedup();
        Ok(Some(Self { friction, backlash, joints: found }))
    }

    /// The question in words.
    pub fn words(&self) -> &'static str {
        match (self.friction, self.backlash) {
            (true, true) => "friction and backlash",
            (true, false) => "friction",
            (false, _) => "backlash",
        }
    }
}
