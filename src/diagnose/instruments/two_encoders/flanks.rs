//! Changes of flank in rows.

/// Least share of the rows on each flank for a gap to show.
const LEAST_SHARE: f64 = 0.02;

/// Least number of changes of flank: a single one may have any other cause.
const LEAST_CHANGES: usize = 2;

/// Number of changes of flank, and whether both flanks have enough rows.
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
