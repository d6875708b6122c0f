//! Finds pairs of columns of which one is the derivative of the other.

/// Number of rows that are compared, from the middle of the recording.
const ROWS: usize = 5000;
/// Largest number of columns that are compared with each other: ten joints with six channels.
const COLUMNS: usize = 64;
/// Half of the rows over which a difference is taken: encoders are too coarse for the difference of neighbouring rows.
const SPAN: usize = 10;
/// Least correlation of a velocity with the differences of its position: a velocity filtered by 20 ms has 0.95 and more in
/// motions of a second.
const ALIKE: f64 = 0.9;
/// Bounds of the ratio of the velocity to the differences: other units differ by factors of 9.5 (rpm) and 57 (degrees).
const RATIO: std::ops::Range<f64> = 0.8..1.25;

/// Positions and their velocities among signals of equal length: pairs of their names, each name once.
pub(super) fn pairs(time: &[f64], signals: &[(usize, &[f64])]) -> Vec<(usize, usize)> {
    let first = time.len().saturating_sub(ROWS) / 2;
    let rows = first..time.len().min(first + ROWS);
    if rows.len() < 4 * SPAN {
        return Vec::new();
    }
    let signals = &signals[..signals.len().min(COLUMNS)];
    let mut found: Vec<(usize, usize, usize)> = Vec::new();
    for (position, values) in signals {
        let slopes = slopes(&time[rows.clone()], &values[rows.clone()]);
        for (velocity, others) in signals.iter().filter(|(other, _)| other != position) {
            let (alike, ratio) = compared(&slopes, &others[rows.start + SPAN..rows.end - SPAN]);
            if alike > ALIKE && RATIO.contains(&ratio) {
                found.push((velocity.abs_diff(*position), *position, *velocity));
            }
        }
    }
    // References look alike too: the nearest column is more likely the measured one.
    found.sort_unstable();
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (_, position, velocity) in found {
        let used = |at: usize| pairs.iter().any(|pair| pair.0 == at || pair.1 == at);
        if !used(position) && !used(velocity) {
            pairs.push((position, velocity));
        }
    }
    pairs.sort_unstable();
    pairs
}

/// Differences over `2 SPAN` rows, divided by their time.
fn slopes(time: &[f64], values: &[f64]) -> Vec<f64> {
    let slope = |k: usize| (values[k + SPAN] - values[k - SPAN]) / (time[k + SPAN] - time[k - SPAN]);
    (SPAN..values.len() - SPAN).map(slope).collect()
}

/// Correlation of two signals, and ratio of the second's standard deviation to the first's.
pub(super) fn compared(a: &[f64], b: &[f64]) -> (f64, f64) {
    let count = a.len() as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / count, b.iter().sum::<f64>() / count);
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        aa += a * a;
        bb += b * b;
        ab += a * b;
    }
    (ab / (aa * bb).sqrt(), (bb / aa).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_positions_find_their_velocities() {
        let time: Vec<f64> = (0..3000).map(|k| f64::from(k) * 1e-3).collect();
        let of = |law: &dyn Fn(f64) -> f64| time.iter().map(|t| law(*t)).collect::<Vec<f64>>();
        // Encoders of 1e-4 rad.
        let p1 = of(&|t| ((3.0 * t).sin() * 1e4).round() * 1e-4);
        let p2 = of(&|t| ((5.0 * t).cos() * 1e4).round() * 1e-4);
        let (v1, v2) = (of(&|t| 3.0 * (3.0 * t).cos()), of(&|t| -5.0 * (5.0 * t).sin()));
        let current = of(&|t| 0.7 * (4.0 * t).sin());
        let signals = [(7, &p1[..]), (3, &v2[..]), (1, &current[..]), (9, &v1[..]), (2, &p2[..])];
        assert_eq!(pairs(&time, &signals), [(2, 3), (7, 9)]);
        assert_eq!(pairs(&time, &signals[2..3]), []);
        assert_eq!(pairs(&time[..20], &[(7, &p1[..20]), (9, &v1[..20])]), []);
    }
}
