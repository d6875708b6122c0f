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

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::diagnose::result::{EffectGain, Standing};
    use crate::effects::find;
    use crate::replay::Gain;

    fn line(evidence_nats: f64) -> FoundEffect {
        let about = find("periodic_disturbance").expect("an effect of the catalogue").about();
        let standing = Standing { probability: 0.9, evidence_nats, gain: EffectGain::of(Gain::default(), "amplitude") };
        FoundEffect::new(about, vec!["joint1".to_owned()], BTreeMap::new(), standing)
    }

    fn reading(effects: Vec<FoundEffect>) -> Findings {
        Findings { effects, ..Findings::default() }
    }

    #[test]
    fn regress_two_lines_of_one_reading_stay_apart() {
        let mut findings = Findings::default();
        findings.merge(reading(vec![line(50.0), line(20.0)]));
        assert_eq!(findings.effects.iter().map(|line| line.evidence_nats).collect::<Vec<_>>(), [50.0, 20.0]);
    }

    #[test]
    fn property_what_two_instruments_see_is_one_effect_with_the_larger_evidence() {
        let mut findings = reading(vec![line(50.0)]);
        findings.merge(reading(vec![line(20.0)]));
        assert_eq!(findings.effects.iter().map(|line| line.evidence_nats).collect::<Vec<_>>(), [50.0]);
    }
}
