//! The sample times of a session without pauses: a number of intervals where sampling is even, true times elsewhere.
//!
//! Times of an even clock are often rounded in a file. Their median step is then more accurate than a single difference.

use super::pauses::median_step;

/// [1] Largest difference of an even step from the median step, in median steps. Times that are rounded to a hundredth of a step differ
/// from even ones by half of that; through a window of `n` steps, a rate is off by no more than `ROUNDING/n`.
const ROUNDING: f64 = 0.02;
/// [1] Largest difference of the mean step of an even clock from its median step, in median steps: the error of all rates.
const DRIFT: f64 = 1e-4;

/// Whether a step in time [s] differs from the median step by more than rounding.
pub fn is_uneven_step(step: f64, median: f64) -> bool {
    (step - median).abs() > ROUNDING * median
}

/// Sample times of a session, or of a part of it, without a pause.
#[derive(Debug, Clone, Copy)]
pub struct Clock<'t> {
    time: &'t [f64],
    /// [s] Median step.
    pub interval: f64,
    /// Whether the samples lie at even times, but for rounding.
    pub even: bool,
}

impl<'t> Clock<'t> {
    /// For rising times [s].
    pub fn new(time: &'t [f64]) -> Self {
        let interval = median_step(time);
        let span = time.last().unwrap_or(&0.0) - time.first().unwrap_or(&0.0);
        let steps = time.len().saturating_sub(1) as f64 * interval;
        let even = (span - steps).abs() <= DRIFT * steps + ROUNDING * interval
            && !time.windows(2).any(|pair| is_uneven_step(pair[1] - pair[0], interval));
        Self { time, interval, even }
    }

    /// [s] The times.
    pub const fn time(&self) -> &'t [f64] {
        self.time
    }

    /// [s] From sample `from` to sample `to`, not before it.
    pub fn elapsed(&self, from: usize, to: usize) -> f64 {
        if self.even { (to - from) as f64 * self.interval } else { self.time[to] - self.time[from] }
    }

    /// The sample nearest to `duration` [s] after a sample; the number of samples if the session ends before.
    pub fn after(&self, from: usize, duration: f64) -> usize {
        if self.even {
            return (from + self.samples(duration)).min(self.time.len());
        }
        let wanted = self.time[from] + duration;
        if wanted > self.time[self.time.len() - 1] + 0.5 * self.interval {
            return self.time.len();
        }
        self.nearest(wanted)
    }

    /// The sample nearest to `duration` [s] before a sample; the first if the session begins after.
    pub fn before(&self, from: usize, duration: f64) -> usize {
        if self.even {
            return from.saturating_sub(self.samples(duration));
        }
        self.nearest(self.time[from] - duration)
    }

    /// [s] The longest step.
    pub fn longest_step(&self) -> f64 {
        if self.even {
            return self.interval;
        }
        self.time.windows(2).map(|pair| pair[1] - pair[0]).fold(self.interval, f64::max)
    }

    /// Number of even steps in a time [s].
    fn samples(&self, duration: f64) -> usize {
        (duration / self.interval).round() as usize
    }

    /// The sample nearest to a time [s].
    fn nearest(&self, wanted: f64) -> usize {
        let next = self.time.partition_point(|time| *time < wanted);
        let closer = next > 0 && (next == self.time.len() || wanted - self.time[next - 1] < self.time[next] - wanted);
        if closer { next - 1 } else { next }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_rounded_times_of_an_even_clock_are_even() {
        // 3 ms, rounded to 10 µs: 0.3 % of a step.
        let time: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 3.001e-3 * 1e5).round() / 1e5).collect();
        let clock = Clock::new(&time);
        assert!(!clock.even, "the median step is off by 3e-4, the error of all rates");
        let time: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 3e-3 * 1e6 + 0.3).round() / 1e6).collect();
        let clock = Clock::new(&time);
        assert!(clock.even);
        assert_eq!((clock.after(10, 0.06), clock.before(10, 0.06), clock.after(999, 0.06)), (30, 0, 1000));
        assert!((clock.elapsed(10, 30) - 0.06).abs() < 1e-15);
    }

    #[test]
    fn property_uneven_times_count_as_they_are() {
        let time = [0.0, 0.013, 0.018, 0.03, 0.04];
        let clock = Clock::new(&time);
        assert!(!clock.even);
        assert_eq!(clock.elapsed(1, 3), time[3] - time[1]);
        assert_eq!((clock.after(1, 0.006), clock.after(0, 0.031), clock.after(3, 0.02)), (2, 3, 5));
        assert_eq!((clock.before(3, 0.016), clock.before(2, 1.0)), (1, 0));
        assert_eq!(clock.longest_step(), 0.013);
    }
}
