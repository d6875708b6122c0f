//! Figures of `docs/exactness.md`, each beside the measurement that gives it.
//!
//! With `LOSTMOTION_REFRESH=1` the figures of the page are replaced by those that are measured now (`docs/refresh` does that).

use std::fs;
use std::ops::Range;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// [1] Largest part by which a figure of the page may differ: it tells the size of an error, which other processors round otherwise.
const SHARE: f64 = 0.5;

/// The tests of a file run side by side, and all write to one page.
static PAGE: Mutex<()> = Mutex::new(());

/// Requires that the page says these figures behind a text, in this order, on the same line. Further figures of the line are not judged.
pub fn says(text: &str, figures: &[f64]) {
    let _alone = PAGE.lock().unwrap_or_else(PoisonError::into_inner);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/exactness.md");
    let page = fs::read_to_string(&path).expect("docs/exactness.md");
    let begins = page.find(text).unwrap_or_else(|| panic!("docs/exactness.md lacks: {text}")) + text.len();
    let length = page[begins..].find('\n').unwrap_or(page.len() - begins);
    let line = &page[begins..begins + length];
    let numbers = numbers(line);
    assert!(numbers.len() >= figures.len(), "docs/exactness.md: {text}{line}: {figures:?}");
    if std::env::var_os("LOSTMOTION_REFRESH").is_some_and(|value| !value.is_empty() && value != "0") {
        let mut new = line.to_owned();
        for (number, figure) in numbers.into_iter().zip(figures).rev() {
            let shown = like(&line[number.clone()], *figure);
            new.replace_range(number, &shown);
        }
        fs::write(&path, format!("{}{new}{}", &page[..begins], &page[begins + length..])).expect("docs/exactness.md");
        return;
    }
    for (number, figure) in numbers.into_iter().zip(figures) {
        let written = &line[number];
        assert!(
            agrees(written, *figure),
            "docs/exactness.md says {written}, measured {figure:.2e}, run docs/refresh: {text}{line}"
        );
    }
}

/// Places of the numbers in a text.
fn numbers(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let end = at + length(&bytes[at..]);
        if end > at {
            found.push(at..end);
        }
        // What follows a letter is part of a name.
        let word = bytes[at..].iter().take_while(|byte| byte.is_ascii_alphanumeric()).count();
        at = end.max(at + word).max(at + 1);
    }
    found
}

/// Length of the number at the beginning of a text: digits, a point with digits, an exponent.
fn length(text: &[u8]) -> usize {
    let digits = |from: usize| text[from.min(text.len())..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut end = digits(0);
    if end > 0 && text.get(end) == Some(&b'.') && digits(end + 1) > 0 {
        end += 1 + digits(end + 1);
    }
    if end > 0 && text.get(end..end + 2) == Some(b"e-") && digits(end + 2) > 0 {
        end += 2 + digits(end + 2);
    }
    end
}

/// A figure with as many digits as a written one has.
fn like(written: &str, figure: f64) -> String {
    let mantissa = written.split('e').next().unwrap_or_default();
    let places = mantissa.split_once('.').map_or(0, |(_, places)| places.len());
    if written.contains('e') { format!("{figure:.places$e}") } else { format!("{figure:.places$}") }
}

/// Whether a written figure is of the size of a measured one, or differs by one in its last digit.
fn agrees(written: &str, figure: f64) -> bool {
    let value: f64 = written.parse().expect("a number");
    let (mantissa, exponent) = written.split_once('e').unwrap_or((written, "0"));
    let places = mantissa.split_once('.').map_or(0, |(_, places)| places.len());
    let digit = 10_f64.powi(exponent.parse::<i32>().expect("an exponent") - places as i32);
    // Half a digit more: the measured figure is not rounded.
    (value - figure).abs() <= (SHARE * value.max(figure)).max(1.5 * digit)
}

#[test]
fn property_figures_are_found_compared_and_written_in_their_form() {
    let line = " 52, 39, 18 | 1.9e-4 deg; 3.7e-5 with M2 and 3 steps |";
    let found: Vec<&str> = numbers(line).into_iter().map(|place| &line[place]).collect();
    assert_eq!(found, ["52", "39", "18", "1.9e-4", "3.7e-5", "3"]);
    assert_eq!(
        (like("1.9e-4", 2.34e-5), like("4e-6", 3.2e-6), like("3.8", 4.04)),
        ("2.3e-5".into(), "3e-6".into(), "4.0".into())
    );
    assert!(agrees("1.9e-4", 1.2e-4) && agrees("0.1", 0.24) && agrees("18", 19.0) && agrees("1e-11", 2.4e-11));
    assert!(!agrees("1.9e-4", 8e-5) && !agrees("1.9e-4", 4.1e-4) && !agrees("0.1", 0.4) && !agrees("18", 40.0));
}
