//! A sampled signal at another time.

/// The values of a signal `by` [s] before each of its samples, after it where negative: linear between samples, constant beyond the ends.
pub fn delayed(time: &[f64], values: &[f64], by: f64) -> Vec<f64> {
    let at = |now: &f64| {
        let then = now - by;
        let next = time.partition_point(|one| *one <= then).clamp(1, time.len() - 1);
        let span = time[next] - time[next - 1];
        let share = ((then - time[next - 1]) / span).clamp(0.0, 1.0);
        values[next - 1] + share * (values[next] - values[next - 1])
    };
    if time.len() < 2 || by == 0.0 { values.to_vec() } else { time.iter().map(at).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_line_is_shifted_either_way() {
        let time: Vec<f64> = (0..10).map(|k: i32| 0.1 * f64::from(k) + 0.003 * f64::from(k % 3)).collect();
        let line: Vec<f64> = time.iter().map(|time| 2.0 * time).collect();
        // A line is interpolated exactly, up to rounding.
        let shifted = |after: &f64, own: &f64, by: f64| (own - after - 2.0 * by).abs() < 1e-12;
        let late = delayed(&time, &line, 0.25);
        assert_eq!(late[..3], [0.0, 0.0, 0.0]);
        assert!(late[3..].iter().zip(&line[3..]).all(|(after, own)| shifted(after, own, 0.25)), "{late:?}");
        let early = delayed(&time, &line, -0.25);
        assert_eq!(early[7..], [line[9]; 3]);
        assert!(early[..7].iter().zip(&line[..7]).all(|(after, own)| shifted(after, own, -0.25)), "{early:?}");
        assert_eq!(delayed(&time, &line, 0.0), line);
    }
}
