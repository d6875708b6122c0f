//! The samples of one channel, shared between copies of a recording.

use std::ops::{Deref, DerefMut, Range};
use std::sync::Arc;

/// The samples of a channel. A clone or a part is free: all share the samples until one of them is changed.
///
/// Half an hour of one channel at 1 kHz is 14 MB; all channels of a six-joint arm are half a gigabyte.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    shared: Arc<Vec<f64>>,
    range: Range<usize>,
}

impl Samples {
    /// The samples.
    pub fn as_slice(&self) -> &[f64] {
        &self.shared[self.range.clone()]
    }

    /// The samples of a range.
    #[must_use]
    pub fn part(&self, range: Range<usize>) -> Self {
        assert!(range.start <= range.end && range.end <= self.range.len(), "{range:?} of {} samples", self.range.len());
        let range = self.range.start + range.start..self.range.start + range.end;
        Self { shared: Arc::clone(&self.shared), range }
    }

    /// Appends a sample.
    pub fn push(&mut self, value: f64) {
        self.own().push(value);
        self.range.end = self.shared.len();
    }

    /// These samples alone, no longer shared.
    fn own(&mut self) -> &mut Vec<f64> {
        if self.range.len() < self.shared.len() {
            *self = self.as_slice().to_vec().into();
        }
        Arc::make_mut(&mut self.shared)
    }
}

impl PartialEq for Samples {
    fn eq(&self, other: &Self) -> bool {
        self.as_slice() == other.as_slice()
    }
}

impl Deref for Samples {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        self.as_slice()
    }
}

impl DerefMut for Samples {
    fn deref_mut(&mut self) -> &mut [f64] {
        self.own().as_mut_slice()
    }
}

impl From<Vec<f64>> for Samples {
    fn from(values: Vec<f64>) -> Self {
        Self { range: 0..values.len(), shared: Arc::new(values) }
    }
}

impl FromIterator<f64> for Samples {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        Vec::from_iter(values).into()
    }
}

impl<'a> IntoIterator for &'a Samples {
    type Item = &'a f64;
    type IntoIter = std::slice::Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a> IntoIterator for &'a mut Samples {
    type Item = &'a mut f64;
    type IntoIter = std::slice::IterMut<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::Samples;

    #[test]
    fn property_copies_share_samples_until_one_is_changed() {
        let first: Samples = vec![1.0, 2.0].into();
        let mut second = first.clone();
        assert!(std::ptr::eq(first.as_slice(), second.as_slice()));
        second[0] = 5.0;
        assert_eq!((first.as_slice(), second.as_slice()), ([1.0, 2.0].as_slice(), [5.0, 2.0].as_slice()));
    }

    #[test]
    fn property_a_part_shares_samples_until_it_is_changed() {
        let whole: Samples = vec![1.0, 2.0, 3.0, 4.0].into();
        let mut inner = whole.part(1..4).part(1..2);
        assert!(std::ptr::eq(&whole[2], &inner[0]));
        inner[0] = 7.0;
        inner.push(8.0);
        assert_eq!((whole.as_slice(), inner.as_slice()), ([1.0, 2.0, 3.0, 4.0].as_slice(), [7.0, 8.0].as_slice()));
    }
}
