//! Held-out scores of sets of effects → probabilities of sets and of names.
//!
//! ```text
//!   P(S) ∝ e^{T (L_S − L_∅)} K^{−|S|} n^{|S| − m}       P(name) = Σ P(S) over the sets that contain it
//! ```
//! `L` [nat]: score on windows that took no part in the fit, `K`: effects of the catalogue, `T`: share of a nat that counts as evidence, `m`: joints on which the
//! effects act, one after the other, `n`: joints of the machine, any of which a further joint may be.

/// `T` [1]. Held-out scores contain no fitted noise, but fits stop beside their best place: a healthy machine whose nominal values are off by their accuracy gave
/// rivals 29, 23, 10 and 0 nats that no effect earned (`docs/gate.md`, tuning seeds of `benches/gate`, which repeats this with `--rough 1`). With a tenth of
/// a nat, the largest of these stays below the price of one effect among thirty, `ln 30 = 3.4`, and 100 nats leave odds of 700 to 1.
const TEMPER: f64 = 0.1;

/// A set: its effects, the joints on which they act, and its score [nat].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scored {
    pub effects: usize,
    pub entries: usize,
    pub nats: f64,
}

/// Probabilities of sets; `catalogue`: effects that there are, `joints`: those of the machine.
pub fn of_sets(sets: &[Scored], catalogue: usize, joints: usize) -> Vec<f64> {
    let [of_effect, of_joint] = [catalogue.max(2), joints.max(1)].map(|count| (count as f64).ln());
    let height = |set: &Scored| {
        let further = set.entries.saturating_sub(set.effects);
        TEMPER * set.nats - of_effect * set.effects as f64 - of_joint * further as f64
    };
    let heights: Vec<f64> = sets.iter().map(height).collect();
    let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let odds: Vec<f64> = heights.iter().map(|height| (height - highest).exp()).collect();
    let sum: f64 = odds.iter().sum();
    odds.iter().map(|odds| odds / sum).collect()
}

/// Probability of a name: the sum over the sets that contain it.
pub fn of_name(name: &str, sets: &[Vec<String>], probabilities: &[f64]) -> f64 {
    let with = sets.iter().zip(probabilities).filter(|(set, _)| set.iter().any(|one| one == name));
    with.map(|(_, probability)| probability).sum::<f64>().min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(effects: usize, entries: usize, nats: f64) -> Scored {
        Scored { effects, entries, nats }
    }

    #[test]
    fn analytic_one_set_beside_nothing() {
        // Odds e^{0.1 · 60}/30.
        let odds = 6.0_f64.exp() / 30.0;
        let found = of_sets(&[set(0, 0, 0.0), set(1, 1, 60.0)], 30, 2);
        assert!((found[1] - odds / (1.0 + odds)).abs() < 1e-12, "{found:?}");
        assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn property_a_dead_heat_is_one_half_each() {
        let found = of_sets(&[set(0, 0, 0.0), set(1, 1, 2000.0), set(1, 1, 2000.0)], 30, 2);
        assert!((found[1] - 0.5).abs() < 1e-9 && (found[2] - 0.5).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn property_of_equal_scores_fewer_effects_are_likelier() {
        let found = of_sets(&[set(0, 0, 0.0), set(1, 1, 500.0), set(2, 2, 500.0)], 30, 2);
        assert!((found[1] / found[2] - 30.0).abs() < 1e-9, "{found:?}");
    }

    /// Gains that inexact nominal values gave to rivals: nothing is likeliest, and no name reaches one half.
    #[test]
    fn regress_gains_of_rivals_on_a_healthy_machine_decide_nothing() {
        let found =
            of_sets(&[set(0, 0, 0.0), set(1, 1, 29.0), set(1, 1, 23.0), set(1, 1, 10.0), set(1, 1, 0.0)], 30, 2);
        assert!(found[1..].iter().all(|rival| *rival < found[0] && *rival < 0.5), "{found:?}");
    }

    #[test]
    fn property_scores_of_any_size_give_probabilities() {
        let found = of_sets(&[set(0, 0, 0.0), set(1, 1, 1e7), set(1, 1, -1e7)], 30, 2);
        assert!(found.iter().all(|p| (0.0..=1.0).contains(p)), "{found:?}");
        let sets = [vec![], vec!["a".to_owned()], vec!["a".to_owned(), "b".to_owned()]];
        assert!((of_name("a", &sets, &[0.2, 0.5, 0.3]) - 0.8).abs() < 1e-12);
        assert!((of_name("b", &sets, &[0.2, 0.5, 0.3]) - 0.3).abs() < 1e-12);
    }

    #[test]
    fn property_of_equal_scores_fewer_joints_are_likelier() {
        let found = of_sets(&[set(1, 1, 500.0), set(1, 2, 500.0)], 30, 2);
        assert!((found[0] - 2.0 * found[1]).abs() < 1e-12, "{found:?}");
    }
}
