//! The quality of a signal: resolution, noise, saturation, and the delay between two.

use std::fmt::Write as _;

use super::super::derivative::compared;

/// Samples that are looked at, from the middle of the recording.
const MOST: usize = 50_000;
/// Share of the gaps between values that are whole multiples of a resolution.
const WHOLE: f64 = 0.9;
/// Distance from a whole multiple, in parts of the resolution: values are rounded to decimals.
const ROUNDED: f64 = 0.1;
/// Least share of samples at an extreme value that is mentioned.
const MANY: f64 = 0.01;
/// [s] Longest delay that is looked for: filters and buses of robots stay below it.
const LONGEST: f64 = 0.2;
/// Least correlation at which two signals show the same motion.
const ALIKE: f64 = 0.9;
/// Half of the samples over which a slope is taken.
const SPAN: usize = 5;

/// Resolution, noise and saturation of a signal that changes.
pub(super) fn quality(values: &[f64], minimum: f64, maximum: f64) -> String {
    let first = values.len().saturating_sub(MOST) / 2;
    let values = &values[first..values.len().min(first + MOST)];
    let mut text = String::new();
    let resolution = resolution(values, maximum - minimum);
    if let Some(step) = resolution {
        let _ = write!(text, "  resolution {step:.3e}");
    }
    match noise(values) {
        Some(noise) if resolution.is_none_or(|step| noise > step) => {
            let _ = write!(text, "  noise {noise:.1e}");
        }
        Some(_) => text += "  noise below the resolution",
        None => {}
    }
    for (name, extreme) in [("smallest", minimum), ("largest", maximum)] {
        let share = values.iter().filter(|value| **value == extreme).count() as f64 / values.len() as f64;
        if share > MANY {
            let _ = write!(text, "  {:.0} % at the {name} value", 100.0 * share);
        }
    }
    text
}

/// The step of which the gaps between the values that occur are whole multiples; `None` for a continuous signal.
fn resolution(values: &[f64], range: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    // Differences below this come from the digits of a number.
    let digits = 1e-12 * range.max(f64::MIN_POSITIVE);
    let gaps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > digits).collect();
    let smallest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let mut single: Vec<f64> = gaps.iter().copied().filter(|gap| *gap < 1.5 * smallest).collect();
    if gaps.len() < 2 {
        return None;
    }
    let middle = single.len() / 2;
    let step = *single.select_nth_unstable_by(middle, f64::total_cmp).1;
    let whole = gaps.iter().filter(|gap| (*gap / step - (*gap / step).round()).abs() < ROUNDED).count();
    (whole as f64 >= WHOLE * gaps.len() as f64).then_some(step)
}

/// Standard deviation of white noise, from third differences, in which a smooth motion vanishes: the variance of
/// `x(k+3) − 3x(k+2) + 3x(k+1) − x(k)` is 20 times that of the noise, and its median size 0.6745 of the deviation.
fn noise(values: &[f64]) -> Option<f64> {
    let third = |w: &[f64]| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs();
    let mut sizes: Vec<f64> = values.windows(4).map(third).collect();
    if sizes.is_empty() {
        return None;
    }
    let middle = sizes.len() / 2;
    let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    Some(median / 0.6745 / 20_f64.sqrt())
}

/// Slopes of a signal, one per sample.
pub(super) fn slopes(time: &[f64], values: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let slope = |k: usize| {
        let (a, b) = (k.saturating_sub(SPAN), (k + SPAN).min(last));
        if b > a { (values[b] - values[a]) / (time[b] - time[a]) } else { 0.0 }
    };
    (0..values.len()).map(slope).collect()
}

/// [s] By how much the second signal is behind the first: where their correlation is largest, between samples by a
/// parabola; `None` where they do not show the same motion.
pub(super) fn delay(first: &[f64], second: &[f64], step: f64) -> Option<f64> {
    /// Rows that are compared.
    const ROWS: usize = 20_000;
    let reach = (LONGEST / step).min(1000.0) as usize;
    let begin = (first.len().saturating_sub(ROWS) / 2).max(reach);
    let end = first.len().checked_sub(reach)?.min(begin + ROWS);
    if reach == 0 || begin + 10 * reach > end {
        return None;
    }
    let alike = |lag: usize| {
        // `lag` counts from −reach.
        compared(&first[begin..end], &second[begin + lag - reach..end + lag - reach]).0
    };
    let all: Vec<f64> = (0..=2 * reach).map(alike).collect();
    let best = (1..2 * reach).max_by(|a, b| all[*a].total_cmp(&all[*b]))?;
    if all[best].is_nan() || all[best] < ALIKE {
        return None;
    }
    let (left, middle, right) = (all[best - 1], all[best], all[best + 1]);
    let curved = left - 2.0 * middle + right;
    let shift = if curved < 0.0 { 0.5 * (left - right) / curved } else { 0.0 };
    Some((best as f64 + shift - reach as f64) * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(law: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..20_000).map(|k| law(f64::from(k) * 1e-3)).collect()
    }

    #[test]
    fn recover_the_resolution_of_a_quantised_signal() {
        let step = 2e-4;
        let quantised = signal(|t| ((2.0 * t).sin() / step).round() * step);
        let found = resolution(&quantised, 2.0).expect("a resolution");
        // The step is exact but for the rounding of a double.
        assert!((found / step - 1.0).abs() < 1e-9, "{found}");
        assert_eq!(resolution(&signal(|t| (2.0 * t).sin() + 1e-5 * (977.0 * t * t).sin()), 2.0), None);
    }

    #[test]
    fn recover_the_deviation_of_noise_on_a_motion() {
        // Sums of twelve numbers of a congruential generator, even from −1/2 to 1/2: nearly normal, with deviation 1.
        let mut state = 1_u64;
        let mut even = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut random = || (0..12).map(|_| even()).sum::<f64>();
        let noisy: Vec<f64> = signal(|t| (2.0 * t).sin()).iter().map(|value| value + 0.01 * random()).collect();
        let found = noise(&noisy).expect("noise");
        // The median of 20,000 correlated sizes has a standard error of about 2 %.
        assert!((found / 0.01 - 1.0).abs() < 0.06, "{found}");
        assert!(noise(&signal(|t| (2.0 * t).sin())).expect("noise") < 1e-8);
    }

    #[test]
    fn recover_a_delay_between_two_signals() {
        let motion = |t: f64| (3.0 * t).sin() + 0.3 * (11.0 * t).cos();
        let first = signal(motion);
        for delay_ in [0.0, 0.0123, -0.0304] {
            let found = delay(&first, &signal(|t| motion(t - delay_)), 1e-3).expect("a delay");
            // A hundredth of a step: the parabola finds a smooth peak that precisely.
            assert!((found - delay_).abs() < 1e-5, "{found} for {delay_}");
        }
        assert_eq!(delay(&first, &signal(|t| (7.0 * t).sin()), 1e-3), None);
    }
}
