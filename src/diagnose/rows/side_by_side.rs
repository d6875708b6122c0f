//! Work on joints side by side, as far as what it holds meanwhile fits in memory.

use rayon::prelude::*;

use crate::timeseries::give_back_memory;

/// [bytes] that are held at a time: what is left of 1 GB beside two recordings of half an hour of six joints at 1 kHz, 0.75 GB of what a
/// comparison reads, half for this and half for all else.
const HELD: usize = 120_000_000;

/// What `of` makes of each item, in their order; `bytes` is what it holds of one meanwhile. Short recordings are worked on all at once.
pub fn side_by_side<T: Sync, R: Send>(items: &[T], bytes: usize, of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let together = (HELD / bytes.max(1)).max(1);
    give_back_memory();
    let of_some = |some: &[T]| {
        let made: Vec<R> = some.par_iter().map(&of).collect();
        give_back_memory();
        made
    };
    items.chunks(together).flat_map(of_some).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::{HELD, side_by_side};

    #[test]
    fn property_no_more_are_worked_on_than_fit() {
        let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let items: Vec<usize> = (0..12).collect();
        let doubled = side_by_side(&items, HELD / 2, |item| {
            most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
            std::thread::sleep(std::time::Duration::from_millis(2));
            now.fetch_sub(1, Ordering::SeqCst);
            2 * item
        });
        assert_eq!(doubled, (0..12).map(|item| 2 * item).collect::<Vec<_>>());
        assert!(most.into_inner() <= 2);
    }
}
