//! The findings of a stage.

use super::{FoundEffect, Unexplained, Withdrawn};

/// Effects that are named, effects that are withdrawn, and what no effect explains.
#[derive(Debug, Clone, Default)]
pub struct Findings {
    /// Effects with a gain on held-out data.
    pub effects: Vec<FoundEffect>,
    /// Effects without a gain, or with a parameter outside its range.
    pub withdrawn: Vec<Withdrawn>,
    /// What no effect of the catalogue explains.
    pub unexplained: Vec<Unexplained>,
}

impl Findings {
    /// Adds the findings of an instrument, which measures more directly than the torque along the motion. An effect that both find on the same
    /// joint becomes one entry, with the instrument's parameters first. Several findings of one instrument (lines of one joint) stay separate.
    pub fn merge(&mut self, seen: Self) {
        let mut known_before = self.effects.len();
        for mut effect in seen.effects {
            let same = |known: &FoundEffect| known.effect == effect.effect && known.joints[0] == effect.joints[0];
            if let Some(known) = self.effects[..known_before].iter().position(same) {
                known_before -= 1;
                let known = self.effects.remove(known);
                for (name, measured) in known.parameters {
                    effect.parameters.entry(name).or_insert(measured);
                }
                effect.probability = effect.probability.max(known.probability);
                effect.evidence_nats = effect.evidence_nats.max(known.evidence_nats);
            }
            self.effects.push(effect);
        }
        self.withdrawn.extend(seen.withdrawn);
        self.unexplained.extend(seen.unexplained);
    }
}
