//! A hypothesis: the machine has these effects, with some of their parameters unknown.

use super::gears::Gear;
use crate::robot::EffectEntry;

/// What a machine may have beside its nominal model.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// What it is called in reports.
    pub name: String,
    /// Places from which its parameters are fitted. The most probable one is refined.
    pub starts: Vec<Start>,
    /// The parameters that are refined; the others stay as they start.
    pub free: Vec<Free>,
}

/// A place from which a hypothesis is fitted: all starts have the same list of effects, with other numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// The effects with their parameters.
    pub effects: Vec<EffectEntry>,
    /// Gears that differ from those of the model, one per joint or none at all: an effect that winds up at a reversal was taken for a part of the gap
    /// where nobody knew of it.
    pub gears: Vec<Option<Gear>>,
}

impl Start {
    /// With the gears of the model.
    pub const fn new(effects: Vec<EffectEntry>) -> Self {
        Self { effects, gears: Vec::new() }
    }
}

/// A parameter of an effect that is refined.
#[derive(Debug, Clone, PartialEq)]
pub struct Free {
    /// Index of the effect in the list.
    pub effect: usize,
    /// Its name, as in a model file.
    pub parameter: String,
    /// A change of it that is neither negligible nor grotesque: the fit takes no longer steps than two, and expects it within ten of them.
    pub scale: Scale,
}

/// A change of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// By so much, in its own unit.
    By(f64),
    /// Of its logarithm: a parameter that is positive.
    Times(f64),
}

impl Hypothesis {
    /// Nothing but the nominal model.
    pub fn baseline() -> Self {
        Self { name: "baseline".to_owned(), starts: vec![Start::new(Vec::new())], free: Vec::new() }
    }

    /// Without these of its effects, under another name.
    pub fn without(&self, dropped: &[usize], name: String) -> Self {
        let count = self.starts.first().map_or(0, |start| start.effects.len());
        let kept: Vec<usize> = (0..count).filter(|effect| !dropped.contains(effect)).collect();
        let start = |start: &Start| Start {
            effects: kept.iter().filter_map(|effect| start.effects.get(*effect).cloned()).collect(),
            gears: start.gears.clone(),
        };
        let free = self
            .free
            .iter()
            .filter_map(|free| Some(Free { effect: kept.iter().position(|one| *one == free.effect)?, ..free.clone() }));
        Self { name, starts: self.starts.iter().map(start).collect(), free: free.collect() }
    }
}
