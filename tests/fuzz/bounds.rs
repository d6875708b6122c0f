//! What a case may take: time to compute and memory. What takes more ends the process.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{LazyLock, Once};
use std::time::{Duration, Instant};

/// [bytes] Most that may be allocated at a time.
const MOST_MEMORY: usize = 1_000_000_000;
/// [s] Most that a case may compute, on all threads together.
pub const LONGEST: f64 = 10.0;
/// [s] Most that it may last by the clock: one that waits for something computes nothing. Room for a busy machine.
const LONGEST_BY_CLOCK: f64 = 300.0;

/// Refuses what would go beyond [`MOST_MEMORY`]: the allocation fails, which ends the process.
struct Bounded;

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn take(size: usize) -> bool {
    let held = HELD.fetch_add(size, Ordering::Relaxed) + size;
    if held > MOST_MEMORY {
        HELD.fetch_sub(size, Ordering::Relaxed);
        return false;
    }
    PEAK.fetch_max(held, Ordering::Relaxed);
    true
}

unsafe impl GlobalAlloc for Bounded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if take(layout.size()) { unsafe { System.alloc(layout) } } else { std::ptr::null_mut() }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if take(layout.size()) { unsafe { System.alloc_zeroed(layout) } } else { std::ptr::null_mut() }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if !take(size) {
            return std::ptr::null_mut();
        }
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Bounded = Bounded;

/// [bytes] Most that was allocated at a time since the last question.
pub fn peak() -> usize {
    PEAK.swap(HELD.load(Ordering::Relaxed), Ordering::Relaxed)
}

static BEGINNING: LazyLock<Instant> = LazyLock::new(Instant::now);

/// [s] since the process began.
fn clock() -> f64 {
    BEGINNING.elapsed().as_secs_f64()
}

/// [s] that this process has computed, on all threads; where the system does not say, the time since it began.
pub fn computed() -> f64 {
    /// [1/s] Ticks of `/proc`, the same on every Linux.
    const TICKS: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name in parentheses may hold spaces; user and system time are the 12th and 13th field behind it.
    let fields = text.rsplit_once(')').map_or("", |(_, fields)| fields).split_whitespace();
    let ticks: Vec<f64> = fields.skip(11).take(2).filter_map(|field| field.parse().ok()).collect();
    if ticks.len() == 2 { (ticks[0] + ticks[1]) / TICKS } else { clock() }
}

/// The case that runs, and when it began: time computed and by the clock [s], as bits. No case is [`NONE`].
static CASE: AtomicU64 = AtomicU64::new(NONE);
static BEGAN: [AtomicU64; 2] = [AtomicU64::new(0), AtomicU64::new(0)];
const NONE: u64 = u64::MAX;

/// A case begins.
pub fn begin(seed: u64) {
    static WATCH: Once = Once::new();
    WATCH.call_once(|| drop(std::thread::spawn(watch)));
    CASE.store(NONE, Ordering::SeqCst);
    BEGAN[0].store(computed().to_bits(), Ordering::SeqCst);
    BEGAN[1].store(clock().to_bits(), Ordering::SeqCst);
    CASE.store(seed, Ordering::SeqCst);
}

/// It has ended. Gives the time that it has computed [s].
pub fn end() -> f64 {
    CASE.store(NONE, Ordering::SeqCst);
    computed() - f64::from_bits(BEGAN[0].load(Ordering::SeqCst))
}

/// Ends the process where a case lasts too long.
fn watch() {
    loop {
        std::thread::sleep(Duration::from_millis(200));
        let before = CASE.load(Ordering::SeqCst);
        let [began, by_clock] = [0, 1].map(|k| f64::from_bits(BEGAN[k].load(Ordering::SeqCst)));
        let late = computed() - began > LONGEST || clock() - by_clock > LONGEST_BY_CLOCK;
        if late && before != NONE && CASE.load(Ordering::SeqCst) == before {
            eprintln!("seed {before} takes longer than {LONGEST} s of computing; it is kept in target/tmp/fuzz");
            std::process::abort();
        }
    }
}
