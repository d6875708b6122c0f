//! Broken versions of good files.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Numbers that a slip of the keyboard, a script or malice can write.
const NUMBERS: [&str; 26] = [
    "0",
    "-0.0",
    "-1",
    "1",
    "1e-3",
    "1e3",
    "1e-6",
    "1e6",
    "1e-9",
    "1e9",
    "1e-12",
    "1e12",
    "1e-15",
    "1e18",
    "1e-300",
    "1e300",
    "-1e300",
    "5e-324",
    "1.7976931348623157e308",
    "1e400",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "99999999999999999999",
    "0.1",
];

/// Values of other types.
const OTHERS: [&str; 8] = ["true", "\"\"", "\"text\"", "[]", "[1, 2]", "{}", "1979-05-27", "[[1], [2]]"];

/// Numbers that lengths like to be wrong by.
const EXTREMES: [u64; 8] = [0, 1, 0x7f, 0xff, 0x7fff_ffff, 0xffff_ffff, 0x7fff_ffff_ffff_ffff, u64::MAX];

fn pick<'a>(rng: &mut ChaCha8Rng, of: &[&'a str]) -> &'a str {
    of[rng.random_range(0..of.len())]
}

/// Positions of the numbers in a text.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let bytes = text.as_bytes();
    let is_part = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'e' | b'+');
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let starts =
            bytes[at].is_ascii_digit() || (bytes[at] == b'-' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit));
        let free = at == 0 || matches!(bytes[at - 1], b' ' | b'=' | b'[' | b',' | b'"' | b'\n');
        if starts && free {
            let end = at + bytes[at..].iter().take_while(|&&byte| is_part(byte)).count();
            found.push((at, end));
            at = end;
        } else {
            at += 1;
        }
    }
    found
}

/// One change, or up to three: a number made extreme, a value of another type, a line dropped, doubled, moved, or taken from `other`. One in
/// eight has bytes changed as well.
pub fn of_text(rng: &mut ChaCha8Rng, good: &str, other: &str) -> Vec<u8> {
    let mut text = good.to_owned();
    let changes = if rng.random_bool(0.5) { 1 } else { rng.random_range(2..4) };
    for _ in 0..changes {
        change_text(rng, &mut text, other);
    }
    if rng.random_range(0..8) == 0 { of_bytes(rng, text.as_bytes()) } else { text.into_bytes() }
}

fn change_text(rng: &mut ChaCha8Rng, text: &mut String, other: &str) {
    let mut lines: Vec<&str> = text.lines().collect();
    if lines.is_empty() {
        return;
    }
    let [from, to] = [0; 2].map(|_| rng.random_range(0..lines.len()));
    let changed;
    match rng.random_range(0..11) {
        0..6 => {
            let places = numbers(text);
            if !places.is_empty() {
                let (start, end) = places[rng.random_range(0..places.len())];
                text.replace_range(start..end, pick(rng, &NUMBERS));
            }
            return;
        }
        6 => {
            let Some((key, _)) = lines[from].split_once(" = ") else { return };
            changed = format!("{key} = {}", pick(rng, &OTHERS));
            lines[from] = &changed;
        }
        7 => drop(lines.remove(from)),
        8 => lines.insert(to, lines[from]),
        9 => {
            let others: Vec<&str> = other.lines().collect();
            if !others.is_empty() {
                lines.insert(to, others[rng.random_range(0..others.len())]);
            }
        }
        _ => lines.swap(from, to),
    }
    *text = lines.join("\n");
}

/// One to four edits: a byte changed, a bit changed, a piece cut out, repeated or taken from elsewhere, a length made extreme, the end cut off.
pub fn of_bytes(rng: &mut ChaCha8Rng, good: &[u8]) -> Vec<u8> {
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
