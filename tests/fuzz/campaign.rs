//! Many cases of one format, one after the other.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{bounds, mutation};

/// Cases of a format where no time is given.
const CASES: u64 = 400;

/// A good file, or many: what is broken.
pub struct Good {
    /// Where it stands, or would.
    pub path: PathBuf,
    /// Its content.
    pub bytes: Vec<u8>,
}

impl Good {
    /// A file of the disk.
    pub fn of_disk(path: &Path) -> Self {
        Self { path: path.to_owned(), bytes: std::fs::read(path).expect("a good file") }
    }

    fn text(&self) -> &str {
        std::str::from_utf8(&self.bytes).expect("a good text")
    }
}

/// How far a case came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reached {
    /// Refused while it was read.
    Refused,
    /// Read, and refused before anything moved.
    Read,
    /// Carried out, or given up underway.
    Done,
}

/// Files of the project below a folder whose path ends like this.
pub fn corpus(folder: &str, ending: &str) -> Vec<Good> {
    fn collect(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                collect(&path, ending, found);
            } else if path.to_string_lossy().ends_with(ending) {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    collect(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), ending, &mut found);
    found.sort();
    found.iter().map(|path| Good::of_disk(path)).collect()
}

/// Breaks the files of a corpus and carries each case out; `carry_out` gets the index of the good file and the broken content. Half of the
/// cases are made of the first file, which goes all the way.
pub fn run(format: &str, text: bool, corpus: &[Good], mut carry_out: impl FnMut(usize, &[u8]) -> Reached) {
    /// Formats take turns: what a case takes is what the process takes.
    static ONE: Mutex<()> = Mutex::new(());
    let _turn = ONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let (seconds, first) = (number("LOSTMOTION_FUZZ_SECONDS"), number("LOSTMOTION_FUZZ_SEED").unwrap_or(0));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz");
    std::fs::create_dir_all(&folder).expect("a folder");
    let kept = folder.join(format);

    let start = Instant::now();
    let mut reached = [0_u64; 3];
    let (mut slowest, mut largest) = ((0.0, 0), (0, 0));
    for seed in first.. {
        let over = seconds.map_or(seed - first >= CASES, |seconds| start.elapsed().as_secs() >= seconds);
        if over {
            break;
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let [at, other] = [0; 2].map(|_| rng.random_range(0..corpus.len()));
        let at = if rng.random_bool(0.5) { 0 } else { at };
        let bytes = if text {
            mutation::of_text(&mut rng, corpus[at].text(), corpus[other].text())
        } else {
            mutation::of_bytes(&mut rng, &corpus[at].bytes)
        };
        std::fs::write(&kept, &bytes).expect("the case is kept");
        bounds::peak();
        bounds::begin(seed);
        let outcome = catch_unwind(AssertUnwindSafe(|| carry_out(at, &bytes)));
        let taken = bounds::end();
        match outcome {
            Ok(far) => reached[far as usize] += 1,
            Err(panic) => {
                eprintln!("{format}: seed {seed}, {} broken as in {}", corpus[at].path.display(), kept.display());
                resume_unwind(panic);
            }
        }
        slowest = if taken > slowest.0 { (taken, seed) } else { slowest };
        largest = largest.max((bounds::peak(), seed));
    }
    let cases: u64 = reached.iter().sum();
    let [refused, read, done] = reached;
    println!(
        "{format}: {cases} cases in {:.0} s: {refused} refused, {read} read, {done} carried out; slowest {:.2} s (seed {}), largest {:.0} \
         MB (seed {})",
        start.elapsed().as_secs_f64(),
        slowest.0,
        slowest.1,
        largest.0 as f64 / 1e6,
        largest.1
    );
    // That nearly none is refused, or nearly all, would mean that the changes are none, or too many.
    assert!(refused > cases / 20 && read + done > cases / 100, "{format}: {reached:?}");
}
