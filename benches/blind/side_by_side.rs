//! Two at a time, so that memory stays bounded whatever the number.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How many are worked on at once.
const AT_ONCE: usize = 2;

/// Works on all of them; `done` hears of each as soon as it is ready. Results in the order of the items.
pub fn side_by_side<T: Sync, R: Send>(
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
    done: impl Fn(&T, &R) + Sync,
) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(items.iter().map(|_| None).collect::<Vec<Option<R>>>());
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                while let Some(index) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|index| *index < items.len())
                {
                    let result = work(&items[index]);
                    done(&items[index], &result);
                    results.lock().expect("no worker has failed")[index] = Some(result);
                }
            });
        }
    });
    results.into_inner().expect("no worker has failed").into_iter().flatten().collect()
}
