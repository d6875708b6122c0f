//! Changes of flank in rows.

/// Share of the rows that has to lie on either flank for a gap to show.
const LEAST_SHARE: f64 = 0.02;

/// Changes of flank that a gap needs: one could be anything else that happened once.
const LEAST_CHANGES: usize = 2;

/// Changes from one flank to the other, and whether both are there for long enough.
pub fn flanks(side: &[f64]) -> (usize, bool) {
    let (mut last, mut changes) = (0.0, 0);
    for side in side.iter().copied().filter(|side| side.abs() >= 1.0) {
        changes += usize::from(side * last < 0.0);
        last = side;
    }
    let positive = side.iter().filter(|side| **side >= 1.0).count();
    let negative = side.iter().filter(|side| **side <= -1.0).count();
    let enough = positive.min(negative) as f64 >= LEAST_SHARE * side.len() as f64;
    (changes, enough && changes >= LEAST_CHANGES)
}
