//! How a session was sampled: evenly or not, with or without pauses.
//!
//! Where the samples of a window lie at even times but for rounding, the weights are those of the [`Kernel`]. Elsewhere
//! they are those of a [local polynomial](super::local) in true time, with the same half width. No window reaches across a pause.

use std::ops::Range;

use super::kernel::{Averages, Kernel};
use super::local::{LEAST, LocalWeights};
use crate::timeseries::{is_uneven_step, uninterrupted};

/// [1] Largest difference of a window's length from its steps, in median steps, as [`is_uneven_step`] allows of a step.
const ROUNDING: f64 = 0.02;

/// Times of a session.
pub struct Sampling<'t> {
    time: &'t [f64],
    /// [s] Median step.
    pub median: f64,
    /// The samples between pauses.
    pub parts: Vec<Range<usize>>,
    /// Number of uneven steps before each sample; empty if there are none.
    uneven: Vec<u32>,
}

/// Weights of the samples around one of them.
pub enum Window<'k> {
    /// Samples at even times around the centre.
    Even(&'k Kernel, usize),
    /// Samples at uneven times.
    Uneven(LocalWeights),
}

impl<'t> Sampling<'t> {
    /// For rising times [s]; `median` [s] is their median step.
    pub fn new(time: &'t [f64], median: f64) -> Self {
        let odd = |pair: &[f64]| is_uneven_step(pair[1] - pair[0], median);
        let mut uneven = Vec::new();
        if time.windows(2).any(odd) {
            uneven.reserve(time.len());
            uneven.push(0);
            let mut count = 0;
            for pair in time.windows(2) {
                count += u32::from(odd(pair));
                uneven.push(count);
            }
        }
        Self { time, median, parts: uninterrupted(time), uneven }
    }

    /// Whether all samples from `first` to `last` lie at even times, but for rounding.
    fn is_even(&self, first: usize, last: usize) -> bool {
        let steps = (last - first) as f64 * self.median;
        let none = self.uneven.is_empty() || self.uneven[first] == self.uneven[last];
        none && (self.time[last] - self.time[first] - steps).abs() <= ROUNDING * self.median
    }

    /// [s] The times.
    pub fn time(&self) -> &'t [f64] {
        self.time
    }

    /// [1] Share of the steps that differ from the median.
    pub fn uneven_share(&self) -> f64 {
        let uneven = self.uneven.last().copied().unwrap_or(0);
        f64::from(uneven) / (self.time.len().max(2) - 1) as f64
    }

    /// [s] Mean step between pauses where steps are uneven, else the median.
    pub fn mean(&self) -> f64 {
        if self.uneven.is_empty() {
            return self.median;
        }
        let of_part = |part: &Range<usize>| (self.time[part.end - 1] - self.time[part.start], part.len() - 1);
        let spans = self.parts.iter().filter(|part| !part.is_empty()).map(of_part);
        let (span, steps) = spans.fold((0.0, 0), |(span, steps), (s, n)| (span + s, steps + n));
        if steps == 0 { self.median } else { span / steps as f64 }
    }

    /// The samples of a range between pauses.
    pub fn within(&self, range: &Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let [start, end] = [range.start, range.end];
        self.parts.iter().map(move |part| part.start.max(start)..part.end.min(end)).filter(|part| !part.is_empty())
    }

    /// Runs of samples at even times within a range.
    pub fn even_runs(&self, range: Range<usize>) -> Vec<Range<usize>> {
        if self.uneven.is_empty() {
            return vec![range];
        }
        let mut runs = Vec::new();
        let mut start = range.start;
        for k in range.start + 1..=range.end {
            if k == range.end || self.uneven[k] != self.uneven[k - 1] {
                runs.push(start..k);
                start = k;
            }
        }
        runs
    }

    /// Samples of a part that are at least `edge` [s] away from both ends, and have enough neighbours for a window.
    pub fn inner(&self, part: &Range<usize>, edge: f64) -> Range<usize> {
        if part.len() <= 2 * LEAST {
            return part.start..part.start;
        }
        let time = &self.time[part.clone()];
        let (begin, end) = (time[0] + edge, time[time.len() - 1] - edge);
        let first = time.partition_point(|t| *t < begin).max(LEAST);
        let last = time.partition_point(|t| *t <= end).min(time.len() - LEAST);
        part.start + first..part.start + last.max(first)
    }

    /// Samples at distances of `steps` median steps, at least `edge` [s] away from the ends of their part; and the number of that part.
    pub fn centres(&self, edge: f64, steps: usize) -> Vec<(usize, usize)> {
        let distance = (steps as f64 - 0.5) * self.median;
        let mut centres = Vec::new();
        for (number, part) in self.parts.iter().enumerate() {
            let inner = self.inner(part, edge);
            let mut centre = inner.start;
            while centre < inner.end {
                centres.push((centre, number));
                let next = self.time[centre] + distance;
                centre += 1 + self.time[centre + 1..inner.end].partition_point(|t| *t < next);
            }
        }
        centres
    }

    /// The weights of a kernel, made for the median step, around a sample; `part` is the number of the part that contains it.
    pub fn window<'k>(&self, kernel: &'k Kernel, centre: usize, part: usize) -> Window<'k> {
        let part = &self.parts[part];
        let inside = centre >= part.start + kernel.reach && centre + kernel.reach < part.end;
        if inside && self.is_even(centre - kernel.reach, centre + kernel.reach) {
            return Window::Even(kernel, centre);
        }
        Window::Uneven(self.around(self.time[centre], kernel.half_width, part))
    }

    /// The weights of the half width `w` [s] around any time within a part.
    fn around(&self, t: f64, w: f64, part: &Range<usize>) -> LocalWeights {
        let mut weights = LocalWeights::new(&self.time[part.clone()], t, w);
        weights.shift(part.start);
        weights
    }

    /// The weights of the half width `w` [s] around a time; `None` where no uninterrupted part covers the kernel.
    pub fn around_time(&self, t: f64, w: f64) -> Option<Window<'static>> {
        let covers = |part: &&Range<usize>| {
            part.len() > 2 * LEAST
                && self.time[part.start + LEAST] < t
                && self.time[part.start] <= t - w
                && t + w <= self.time[part.end - 1]
                && t < self.time[part.end - 1 - LEAST]
        };
        self.parts.iter().find(covers).map(|part| Window::Uneven(self.around(t, w, part)))
    }
}

impl Window<'_> {
    /// Averages of a signal of the session.
    pub fn averages(&self, signal: &[f64]) -> Averages {
        match self {
            Self::Even(kernel, centre) => kernel.averages(signal, *centre),
            Self::Uneven(weights) => weights.averages(signal),
        }
    }

    /// The samples of the session that have a weight.
    pub fn samples(&self) -> Range<usize> {
        match self {
            Self::Even(kernel, centre) => centre - kernel.reach..centre + kernel.reach + 1,
            Self::Uneven(weights) => weights.samples(),
        }
    }

    /// `w` [s]
    pub fn half_width(&self) -> f64 {
        match self {
            Self::Even(kernel, _) => kernel.half_width,
            Self::Uneven(weights) => weights.half_width,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn median(time: &[f64]) -> f64 {
        let series = crate::timeseries::TimeSeries { time: time.to_vec(), ..Default::default() };
        series.sample_interval()
    }

    /// Rounded times of an even clock: all windows are those of the kernel, at every fourth sample.
    #[test]
    fn property_even_samples_keep_the_kernel_and_the_distance() {
        let time: Vec<f64> = (0..400).map(|k| f64::from(k) * 1e-3).collect();
        let sampling = Sampling::new(&time, median(&time));
        let kernel = Kernel::new(20, sampling.median);
        let edge = kernel.half_width;
        let centres: Vec<usize> = sampling.centres(edge, 4).into_iter().map(|(centre, _)| centre).collect();
        assert_eq!(centres, (21..400 - 21).step_by(4).collect::<Vec<_>>());
        let signal: Vec<f64> = time.iter().map(|t| (30.0 * t).sin()).collect();
        for centre in centres {
            let window = sampling.window(&kernel, centre, 0);
            assert!(matches!(window, Window::Even(..)));
            assert_eq!(window.averages(&signal), kernel.averages(&signal, centre));
        }
    }

    /// A lost sample changes the windows that contain it, and no others.
    #[test]
    fn property_a_lost_sample_is_bridged_in_true_time() {
        let time: Vec<f64> = (0..200).filter(|k| *k != 100).map(|k| f64::from(k) * 0.01).collect();
        let sampling = Sampling::new(&time, median(&time));
        let kernel = Kernel::new(5, sampling.median);
        let signal: Vec<f64> = time.iter().map(|t| 2.0 - 3.0 * t + 4.0 * t * t).collect();
        for (centre, part) in sampling.centres(kernel.half_width, 1) {
            let window = sampling.window(&kernel, centre, part);
            assert_eq!(matches!(window, Window::Uneven(_)), centre.abs_diff(99) <= 5 && centre + 5 > 99, "{centre}");
            let found = window.averages(&signal);
            // Rounding of values near 10 in sums with weights up to 20/w².
            assert!((found.rate - (-3.0 + 8.0 * time[centre])).abs() < 1e-11, "{centre}: {found:?}");
            assert!((found.curvature - 8.0).abs() < 1e-9, "{centre}: {found:?}");
        }
    }

    #[test]
    fn property_no_window_reaches_across_a_pause() {
        let time: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.01 + if k < 90 { 0.0 } else { 3.0 }).collect();
        let sampling = Sampling::new(&time, median(&time));
        assert_eq!(sampling.parts, [0..90, 90..200]);
        let kernel = Kernel::new(5, sampling.median);
        let jump: Vec<f64> = (0..200).map(|k| if k < 90 { 1.0 } else { 7.0 }).collect();
        let centres = sampling.centres(kernel.half_width, 1);
        assert!(centres.iter().any(|(_, part)| *part == 0) && centres.iter().any(|(_, part)| *part == 1));
        for (centre, part) in centres {
            assert!(centre.abs_diff(90) > 4, "{centre}");
            assert!(sampling.window(&kernel, centre, part).averages(&jump).rate.abs() < 1e-12);
        }
    }
}
