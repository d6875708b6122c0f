//! Broken versions of good files of every format: no panic, no hang, no memory without end, and no session that breaks its own promises.
//!
//! A case may compute for 10 s and hold 1 GB; ten seconds are a hundred times what the slowest takes. One process runs one case at a
//! time, and keeps it as a file in `target/tmp/fuzz` until the next, so that a case that ends the process is there to be looked at.
//!
//! ```text
//! LOSTMOTION_FUZZ_SECONDS=600 cargo test --release --test fuzz -- --nocapture mcap
//! ```
//! runs one format for ten minutes; `LOSTMOTION_FUZZ_SEED` begins at another case.

#[path = "../support/files/mod.rs"]
mod support;

mod bounds;
mod campaign;
mod mutation;
mod recordings;
mod texts;
