//! Pauses of a recording: steps in time so long that nothing is known of the motion within them.

use std::borrow::Cow;
use std::ops::Range;

use super::{JointSeries, TimeSeries};

/// Number of median steps above which a step is a pause. Fewer samples may get lost on a bus.
const LONG: f64 = 5.0;
/// [s] A pause is longer than this, the full width of the narrowest smoothing kernel: a shorter step hides no motion that a row would show.
const SHORTEST: f64 = 0.012;

/// The samples before which rising times [s] pause.
pub fn pauses(time: &[f64]) -> Vec<usize> {
    let limit = SHORTEST.max(LONG * median_step(time));
    (1..time.len()).filter(|k| time[*k] - time[k - 1] > limit).collect()
}

/// [s] Median of the steps of rising times; 0 with fewer than two samples.
pub(super) fn median_step(time: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return 0.0;
    }
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The samples between pauses, in order.
pub fn uninterrupted(time: &[f64]) -> Vec<Range<usize>> {
    let pauses = pauses(time);
    let starts = std::iter::once(0).chain(pauses.iter().copied());
    let ends = pauses.iter().copied().chain(std::iter::once(time.len()));
    starts.zip(ends).map(|(start, end)| start..end).collect()
}

impl TimeSeries {
    /// The parts of the session between its pauses, each with its name; the session itself if it has none.
    pub fn uninterrupted(&self) -> Vec<Cow<'_, Self>> {
        let parts = uninterrupted(&self.time);
        match parts.len() {
            0 | 1 => vec![Cow::Borrowed(self)],
            _ => parts.into_iter().map(|part| Cow::Owned(self.part(part))).collect(),
        }
    }

    /// The samples of a range, shared with the whole, and their times.
    #[must_use]
    pub fn part(&self, range: Range<usize>) -> Self {
        let joints = self.joints.iter().map(|joint| JointSeries {
            name: joint.name.clone(),
            channels: joint.channels.iter().map(|(channel, all)| (*channel, all.part(range.clone()))).collect(),
        });
        Self { name: self.name.clone(), joints: joints.collect(), time: self.time[range].to_vec() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_is_longer_than_five_steps_and_than_a_kernel() {
        let with = |step: f64, pause: f64| -> Vec<f64> {
            (0..20).map(|k| f64::from(k) * step + if k >= 8 { pause } else { 0.0 }).collect()
        };
        // 1 + 3.9 steps of 10 ms are no pause, 1 + 4.1 are one.
        assert!(pauses(&with(0.01, 0.039)).is_empty());
        assert_eq!(pauses(&with(0.01, 0.041)), [8]);
        // At 5 kHz, 10 ms hide less than a kernel averages.
        assert!(pauses(&with(0.0002, 0.010)).is_empty());
        assert_eq!(uninterrupted(&with(0.0002, 0.013)), [0..8, 8..20]);
    }
}
