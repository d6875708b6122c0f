//! A rate, with its interval.

/// Standard errors to either side within which 95 % of a normal variable lie.
const Z: f64 = 1.959_964;

/// So many of so many.
#[derive(Debug, Clone, Copy, Default)]
pub struct Share {
    pub good: usize,
    pub all: usize,
}

impl Share {
    pub fn of(answers: impl Iterator<Item = bool>) -> Self {
        answers.fold(Self::default(), |sum, good| Self { good: sum.good + usize::from(good), all: sum.all + 1 })
    }

    /// 95 % interval of the rate `p = k/n` by E. B. Wilson (1927): the rates `w` with `|p − w| ≤ z √(w (1 − w)/n)`,
    ///
    /// ```text
    ///   w = (p + z²/2n ± z √(p (1 − p)/n + z²/4n²)) / (1 + z²/n)
    /// ```
    ///
    /// It is right for rates near 0 and 1 and for few trials, where `p ± z √(p (1 − p)/n)` is too narrow.
    pub fn interval(self) -> [f64; 2] {
        let n = self.all as f64;
        if self.all == 0 {
            return [0.0, 1.0];
        }
        let p = self.good as f64 / n;
        let z2 = Z * Z;
        let middle = p + z2 / (2.0 * n);
        let half = Z * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
        [-1.0, 1.0].map(|side| ((middle + side * half) / (1.0 + z2 / n)).clamp(0.0, 1.0))
    }

    /// Rate, numbers and interval.
    pub fn text(self) -> String {
        if self.all == 0 {
            return "–".to_owned();
        }
        let [low, high] = self.interval().map(|end| 100.0 * end);
        let rate = 100.0 * self.good as f64 / self.all as f64;
        format!("{rate:.1} % ({} of {}; {low:.1} to {high:.1} %)", self.good, self.all)
    }

    /// Numbers alone.
    pub fn short(self) -> String {
        if self.all == 0 { "–".to_owned() } else { format!("{}/{}", self.good, self.all) }
    }
}
