//! Many broken versions of good files: no panic, no hang, no memory without end, and no session that breaks its own promises.

use std::path::Path;
use std::time::{Duration, Instant};

use lostmotion::dataset;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::make::{array, compressed, doubles, mat, positions, run_csv, times};

/// Versions of each file; `LOSTMOTION_FUZZ` asks for more.
const ROUNDS: u64 = 400;

/// Longest that one version may take: some 0.1 ms; the rest is room for a busy machine.
const LIMIT: Duration = Duration::from_secs(5);

/// Numbers that lengths like to be wrong by.
const EXTREMES: [u64; 8] = [0, 1, 0x7f, 0xff, 0x7fff_ffff, 0xffff_ffff, 0x7fff_ffff_ffff_ffff, u64::MAX];

/// One to four edits: a byte changed, a bit changed, a piece cut out, repeated or taken from elsewhere, a length made extreme, the end cut off.
fn mutate(rng: &mut ChaCha8Rng, good: &[u8]) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..rng.random_range(1..5) {
        if bytes.is_empty() {
            break;
        }
        let at = rng.random_range(0..bytes.len());
        let to = (at + rng.random_range(1..40)).min(bytes.len());
        match rng.random_range(0..8) {
            0 => bytes[at] = rng.random(),
            1 => bytes[at] ^= 1 << rng.random_range(0..8),
            2 => drop(bytes.drain(at..to)),
            3 => {
                let piece = bytes[at..to].to_vec();
                bytes.splice(at..at, piece);
            }
            4 => {
                let from = rng.random_range(0..good.len());
                let piece = good[from..(from + to - at).min(good.len())].to_vec();
                bytes.splice(at..to, piece);
            }
            5 | 6 => {
                let extreme = EXTREMES[rng.random_range(0..EXTREMES.len())];
                let width = [1, 2, 4, 8][rng.random_range(0..4)];
                let to = (at + width).min(bytes.len());
                bytes[at..to].copy_from_slice(&extreme.to_le_bytes()[..to - at]);
            }
            _ => bytes.truncate(at),
        }
    }
    bytes
}

/// Reads many versions; gives how many were refused.
fn survive(name: &str, seed: u64, good: &[u8]) {
    let path = Path::new(name);
    assert!(dataset::parse_alone(path, good).is_ok(), "{name}: {:?}", dataset::parse_alone(path, good).err());
    let rounds = std::env::var("LOSTMOTION_FUZZ").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(ROUNDS);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut refused = 0;
    for round in 0..rounds {
        let bytes = mutate(&mut rng, good);
        let start = Instant::now();
        match dataset::parse_alone(path, &bytes) {
            Ok(session) => {
                let series = &session.series;
                assert!(series.time.windows(2).all(|pair| pair[1] > pair[0]), "{name}, round {round}");
                for values in series.joints.iter().flat_map(|joint| joint.channels.values()) {
                    assert_eq!(values.len(), series.len(), "{name}, round {round}");
                    assert!(values.iter().all(|value| value.is_finite()), "{name}, round {round}");
                }
                dataset::survey_session(&session);
            }
            Err(error) => {
                refused += 1;
                let message = error.to_string();
                assert!(message.starts_with(name) && message.len() < 3000, "{name}, round {round}: {message}");
                assert!(!message.chars().any(char::is_control), "{name}, round {round}: {message}");
            }
        }
        if let Ok(table) = dataset::parse_table(path, &bytes) {
            dataset::survey(&table);
            dataset::first_manifest(&table);
        }
        assert!(start.elapsed() < LIMIT, "{name}, round {round}: {:?}", start.elapsed());
    }
    // Most of these edits break something; that nearly none is refused would mean that nothing is checked.
    assert!(refused > rounds / 10, "{name}: {refused} of {rounds} refused");
}

#[test]
fn property_no_mutated_csv_breaks_the_reader() {
    survive("run.csv", 1, run_csv().as_bytes());
}

#[test]
fn property_no_mutated_matlab_file_breaks_the_reader() {
    let numbers: Vec<u8> = (0..200_i16).flat_map(i16::to_le_bytes).collect();
    let good = mat(&[
        doubles("time", &times()),
        compressed(&doubles("turn.position", &positions())),
        array(10, &[200, 1], "turn.torque", 3, &numbers),
        array(4, &[1, 4], "note", 4, &[0; 8]),
    ]);
    survive("run.mat", 2, &good);
}

#[cfg(feature = "mcap")]
#[test]
fn property_no_mutated_mcap_breaks_the_reader() {
    use mcap::Compression;
    for (seed, compression) in [(3, None), (4, Some(Compression::Zstd)), (5, Some(Compression::Lz4))] {
        survive("run.mcap", seed, &super::mcap::good(compression));
    }
}

#[cfg(feature = "parquet")]
#[test]
fn property_no_mutated_parquet_breaks_the_reader() {
    use parquet::basic::{Compression, ZstdLevel};
    let compressions = [
        Compression::UNCOMPRESSED,
        Compression::SNAPPY,
        Compression::ZSTD(ZstdLevel::default()),
        Compression::LZ4,
        Compression::LZ4_RAW,
    ];
    for (seed, compression) in (6..).zip(compressions) {
        survive("run.parquet", seed, &super::parquet::good(compression));
    }
}
