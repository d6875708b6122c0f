//! Expectations of a scenario about a diagnosis: named effects, and bounds of their figures.
//!
//! ```toml
//! [expect]
//! effects = ["base_tilt"]            # all effects that are named, in any order; [] if none must be named
//!
//! [[expect.effect]]                  # least and greatest values of an effect that is named, SI
//! effect = "base_tilt"
//! tilt = [0.0098, 0.0102]            # [rad]
//! gain_percent = [90, 100]           # on data held out
//! probability = [0.9, 1]
//!
//! [[expect.effect]]
//! effect = "load_dependent_friction"
//! joint = "joint2"                   # the effect on this joint; without this key, every effect of that name
//! coefficient = [0.21, 0.24]
//! ```

use std::collections::BTreeSet;
use std::fmt;

use crate::diagnose::{Diagnosis, FoundEffect};
use crate::effects;
use crate::error::Result;
use crate::toml_input::{Range, Table, nearest};

/// Figures of every effect, in addition to its parameters.
const FIGURES: [(&str, &str); 2] = [("gain_percent", "%"), ("probability", "1")];

/// Expected effects and figures.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DiagnosisExpectation {
    /// All names, in any order; `None` if names are not checked.
    pub effects: Option<Vec<String>>,
    /// Bounds of figures.
    pub figures: Vec<EffectFigure>,
}

/// Bounds of one figure of an effect.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectFigure {
    /// The effect.
    pub effect: String,
    /// The joint; `None`: every joint on which it is named.
    pub joint: Option<String>,
    /// A parameter of the effect, `gain_percent` or `probability`.
    pub figure: String,
    /// Unit of the bounds.
    pub unit: &'static str,
    /// Least and greatest.
    pub range: [f64; 2],
}

/// A failed expectation about a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub enum UnmetDiagnosis {
    /// Other effects are named.
    Named {
        /// Named effects, in alphabetical order.
        found: Vec<String>,
        /// Expected effects.
        expected: Vec<String>,
    },
    /// A figure is out of its bounds, or the effect is not named and there is no figure.
    Figure {
        /// What was expected.
        expectation: EffectFigure,
        /// What was found.
        found: Option<f64>,
    },
}

impl fmt::Display for UnmetDiagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |names: &[String]| if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
        match self {
            Self::Named { found, expected } => write!(f, "named: {}, expected: {}", list(found), list(expected)),
            Self::Figure {
                expectation: EffectFigure { effect, joint, figure, unit, range: [least, greatest] },
                found,
            } => {
                let on = joint.as_ref().map_or_else(String::new, |joint| format!(" on {joint}"));
                match found {
                    Some(found) => write!(f, "{effect}{on}: {figure} is {found:.6} {unit}, ")?,
                    None => write!(f, "{effect}{on} is not named with its {figure}, ")?,
                }
                write!(f, "expected {least} to {greatest} {unit}")
            }
        }
    }
}

impl DiagnosisExpectation {
    /// Reads the keys `effects` and `effect` of `[expect]`; `joints` are the machine's.
    ///
    /// # Errors
    /// A name that is not an effect or a joint, a key that is not a figure of the effect, or invalid bounds.
    pub fn read(expect: &Table<'_>, joints: Option<&[&str]>) -> Result<Self> {
        let effects = expect.optional_texts("effects")?;
        for name in effects.iter().flatten() {
            known(expect, "effects", name)?;
        }
        let mut figures = Vec::new();
        for table in expect.tables("effect")? {
            read_figures(&table, joints, &mut figures)?;
        }
        let effects = effects.map(|names| names.into_iter().map(str::to_owned).collect());
        Ok(Self { effects, figures })
    }

    /// Whether nothing is expected.
    pub const fn is_empty(&self) -> bool {
        self.effects.is_none() && self.figures.is_empty()
    }

    /// The failed expectations.
    pub fn check(&self, found: &Diagnosis) -> Vec<UnmetDiagnosis> {
        let names = |names: &mut dyn Iterator<Item = &String>| -> Vec<String> {
            names.collect::<BTreeSet<_>>().into_iter().cloned().collect()
        };
        let mut unmet = Vec::new();
        if let Some(expected) = &self.effects {
            let found = names(&mut found.effects.iter().map(|one| &one.effect));
            let expected = names(&mut expected.iter());
            if found != expected {
                unmet.push(UnmetDiagnosis::Named { found, expected });
            }
        }
        unmet.extend(self.figures.iter().flat_map(|figure| figure.check(&found.effects)));
        unmet
    }
}

impl EffectFigure {
    fn check(&self, found: &[FoundEffect]) -> Vec<UnmetDiagnosis> {
        let on_joint = |one: &&FoundEffect| self.joint.as_ref().is_none_or(|joint| one.joints.contains(joint));
        let named: Vec<&FoundEffect> = found.iter().filter(|one| one.effect == self.effect).filter(on_joint).collect();
        let unmet = |found| UnmetDiagnosis::Figure { expectation: self.clone(), found };
        if named.is_empty() {
            return vec![unmet(None)];
        }
        let [least, greatest] = self.range;
        let values = named.into_iter().map(|one| self.of(one));
        // NaN meets no expectation.
        values.filter(|value| !value.is_some_and(|value| (least..=greatest).contains(&value))).map(unmet).collect()
    }

    fn of(&self, found: &FoundEffect) -> Option<f64> {
        match self.figure.as_str() {
            "gain_percent" => Some(found.gain.gain_percent),
            "probability" => Some(found.probability),
            name => found.parameters.get(name).map(|measured| measured.value),
        }
    }
}

/// The effect of this name.
fn known(table: &Table<'_>, key: &str, name: &str) -> Result<&'static dyn effects::Effect> {
    effects::find(name).ok_or_else(|| {
        let near = nearest(name, effects::CATALOGUE.iter().map(|effect| effect.name()));
        let hint = near.map_or_else(String::new, |near| format!(", such as {near}"));
        table.error(key, format!("names of `lostmotion list effects`{hint}; `{name}` is not one of them"))
    })
}

fn read_figures(table: &Table<'_>, joints: Option<&[&str]>, figures: &mut Vec<EffectFigure>) -> Result<()> {
    let effect = table.text("effect")?;
    let about = known(table, "effect", effect)?.about();
    let joint = table.optional_text("joint")?;
    if let (Some(joint), Some(joints)) = (joint, joints)
        && !joints.contains(&joint)
    {
        return Err(table.error("joint", format!("one of the joints {}", joints.join(", "))));
    }
    let parameters = about.parameters.iter().map(|parameter| (parameter.name, parameter.unit));
    for (figure, unit) in parameters.chain(FIGURES) {
        let Some(range) = table.optional_vector::<2>(figure, &Range::any(unit))? else { continue };
        if range[0] > range[1] {
            return Err(table.error(figure, "least and greatest, in this order"));
        }
        let (effect, joint) = (effect.to_owned(), joint.map(str::to_owned));
        figures.push(EffectFigure { effect, joint, figure: figure.to_owned(), unit, range });
    }
    table.finish()
}
