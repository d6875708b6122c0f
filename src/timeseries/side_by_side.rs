//! Parallel work on joints or recordings, within a memory limit.

use rayon::prelude::*;

use super::give_back_memory;

/// [bytes] Memory that may be in use at a time. A comparison of two recordings (half an hour, six joints, 1 kHz) reads 0.75 GB; of the rest
/// of 1 GB, half is for this and half for everything else.
const HELD: usize = 120_000_000;

/// The results of `of` for all items, in their order; `bytes` is the memory that one item needs. Short recordings run all in parallel.
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
