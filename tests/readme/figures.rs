//! How far the figures of a printed line may be from what a command prints now.
//!
//! The same program and seed print the same figures. A processor with other rounding in its mathematical functions moves them: encoder edges
//! fall into other samples, and an estimate moves by a small part of its own standard error. So:
//!
//! ```text
//!   A ± B                        A by SHARE·B,            B by SPREAD·B          and the last printed digit of each
//!   row of a table with the column "std. error", s:
//!     recovered SHARE·s,  std. error SPREAD·s,  ends of the interval (SHARE + 2 SPREAD)·s,  error [%] 100 SHARE·s/|injected|,
//!     injected exactly
//!   any other figure             DIGITS of its last printed digit
//! ```
//! A figure that differs by its own standard error never passes.

/// Part of its standard error that a figure may move by. Measured with a rotor's inertia (a gear's damping for the elbow) changed by some
/// 1e-10 of it, which moves every rounding and no figure by itself: nothing moved in `01_identify_scara`, figures by up to 0.37 standard errors
/// in `02_name_the_cause` and 0.44 in `03_identify_elbow`, whose gear hangs on every reversal.
const SHARE: f64 = 0.5;
/// Part of itself that a standard error may move by; 0.07 in the same trials.
const SPREAD: f64 = 0.1;
/// Units of its last printed digit that a figure without a standard error may move by; 3 in the same trials, and 5 of a slowest speed.
const DIGITS: f64 = 5.0;

/// A number as it is printed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Figure {
    value: f64,
    /// One unit of its last printed digit.
    digit: f64,
}

/// A word of a line: what stands around its number, and the number.
#[derive(Debug, Clone, PartialEq)]
enum Word<'a> {
    Text(&'a str),
    Number {
        before: &'a str,
        figure: Figure,
        after: &'a str,
    },
    /// The line under the head of a table, as long as its columns happen to be wide.
    Rule,
}

fn word(text: &str) -> Word<'_> {
    if !text.is_empty() && text.chars().all(|c| c == '─') {
        return Word::Rule;
    }
    let inner = text.trim_matches(|edge: char| "()[]°%×,;:=".contains(edge) || edge == '.');
    let Some(at) = text.find(inner) else { return Word::Text(text) };
    match inner.parse::<f64>() {
        Ok(value) if inner.contains(|c: char| c.is_ascii_digit()) && value.is_finite() => {
            let decimals = inner.split_once('.').map_or(0, |(_, decimals)| decimals.len());
            let digit = 10_f64.powi(-i32::try_from(decimals).unwrap_or(0));
            Word::Number { before: &text[..at], figure: Figure { value, digit }, after: &text[at + inner.len()..] }
        }
        _ => Word::Text(text),
    }
}

fn words(line: &str) -> Vec<Word<'_>> {
    line.split_whitespace().map(word).collect()
}

/// The head of the table that the following lines are rows of.
#[derive(Debug, Default)]
pub struct Table {
    columns: Vec<String>,
}

/// Cells of a row: two spaces and more part them.
fn cells(line: &str) -> Vec<&str> {
    line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect()
}

impl Table {
    /// Takes a line as the head of a table, or as what ends one.
    pub fn read(&mut self, line: &str) {
        if line.contains("std. error") {
            self.columns = cells(line).into_iter().map(str::to_owned).collect();
        } else if line.trim().is_empty() || line.trim() == "…" {
            self.columns.clear();
        }
    }

    /// Allowed differences of the figures of a row, in their order; `None` where the line is no row of a table with standard errors.
    fn tolerances(&self, line: &str) -> Option<Vec<f64>> {
        let cells = cells(line);
        // The first cell is the row's name; the unit may hold a figure too, and has no tolerance.
        if self.columns.is_empty() || cells.len() != self.columns.len() + 1 {
            return None;
        }
        let cell = |name: &str| {
            let at = self.columns.iter().position(|column| column == name)?;
            words(cells[at + 1]).into_iter().find_map(figure_of)
        };
        let s = cell("std. error")?;
        let injected = cell("injected").map_or(f64::INFINITY, |figure| figure.value.abs());
        let mut tolerances = Vec::new();
        for (cell, column) in cells.iter().zip(std::iter::once("").chain(self.columns.iter().map(String::as_str))) {
            for figure in words(cell).into_iter().filter_map(figure_of) {
                tolerances.push(match column {
                    "recovered" => SHARE * s.value + figure.digit,
                    "std. error" => SPREAD * s.value + figure.digit,
                    "95 % interval" => (SHARE + 2.0 * SPREAD) * s.value + figure.digit,
                    "error" => 100.0 * SHARE * s.value / injected + figure.digit,
                    _ => 0.0,
                });
            }
        }
        Some(tolerances)
    }
}

fn figure_of(word: Word<'_>) -> Option<Figure> {
    match word {
        Word::Number { figure, .. } => Some(figure),
        _ => None,
    }
}

/// Allowed differences of the figures of a line of text: `A ± B`, and any other.
fn in_text(words: &[Word<'_>]) -> Vec<f64> {
    let plus_minus = |at: usize| matches!(words.get(at), Some(Word::Text("±")));
    let at = |index: usize| words.get(index).cloned().and_then(figure_of);
    let mut tolerances = Vec::new();
    for (k, word) in words.iter().enumerate() {
        let Some(figure) = figure_of(word.clone()) else { continue };
        let own = if plus_minus(k + 1) { at(k + 2) } else { None };
        let is_error = k > 0 && plus_minus(k - 1);
        tolerances.push(match own {
            Some(std_error) => SHARE * std_error.value + figure.digit,
            None if is_error => SPREAD * figure.value + figure.digit,
            None => DIGITS * figure.digit,
        });
    }
    tolerances
}

/// Whether both lines have the same words, whatever their figures.
pub fn same_words(expected: &str, found: &str) -> bool {
    let (expected, found) = (words(expected), words(found));
    expected.len() == found.len()
        && expected.iter().zip(&found).all(|pair| match pair {
            (Word::Number { before: one, after: end, .. }, Word::Number { before: other, after: other_end, .. }) => {
                one == other && end == other_end
            }
            (one, other) => one == other,
        })
}

/// Whether a printed line agrees with the one that is expected, in the table that it is a row of, if it is one.
pub fn agree(expected: &str, found: &str, table: &Table) -> bool {
    let tolerances = table.tolerances(expected).unwrap_or_else(|| in_text(&words(expected)));
    let figures = |line: &str| words(line).into_iter().filter_map(figure_of).collect::<Vec<_>>();
    // Half of what the last digit may hide is rounding of the two decimal numbers themselves.
    let near = |((one, other), tolerance): ((&Figure, &Figure), &f64)| {
        (one.value - other.value).abs() <= tolerance + 1e-9 * one.value.abs()
    };
    let (ours, theirs) = (figures(expected), figures(found));
    same_words(expected, found) && ours.len() == tolerances.len() && ours.iter().zip(&theirs).zip(&tolerances).all(near)
}

/// Checks of the comparison itself.
pub mod checks {
    use super::*;

    const HEAD: &str = "       injected  recovered  std. error    error        95 % interval  unit";
    const ROW: &str = "F_C +    0.2718    0.27166     0.00060  -0.05 %    0.27045 … 0.27288  N·m";
    const TEXT: &str = "base_tilt on joint1 (tilt = 0.5721 ± 0.0034°), 98 % sure; it lowers the error by 96 %.";

    fn row(found: &str) -> bool {
        let mut table = Table::default();
        table.read(HEAD);
        agree(ROW, found, &table)
    }

    /// The line with one text in it replaced.
    fn with(line: &str, old: &str, new: &str) -> String {
        assert!(line.contains(old), "{old} in {line}");
        line.replacen(old, new, 1)
    }

    pub fn a_line_agrees_with_itself_and_with_other_last_digits() {
        assert!(row(ROW));
        assert!(row(&with(ROW, "0.27166", "0.27168")) && row(&with(ROW, "0.00060", "0.00063")));
        assert!(row(&with(ROW, "-0.05", "-0.07")) && row(&with(ROW, "0.27288", "0.27300")));
        let text = |found: &str| agree(TEXT, found, &Table::default());
        assert!(text(TEXT) && text(&with(TEXT, "0.5721", "0.5724")) && text(&with(TEXT, "96", "95")));
        // Wider columns make a longer rule.
        assert!(agree("─────", "────────", &Table::default()));
    }

    pub fn a_figure_that_moved_by_its_standard_error_does_not_agree() {
        for (old, new) in [("0.27166", "0.27226"), ("0.27166", "0.27106"), ("0.00060", "0.00070"), ("-0.05", "+0.17")] {
            assert!(!row(&with(ROW, old, new)), "{old} for {new}");
        }
        // What was injected is no estimate.
        assert!(!row(&with(ROW, "0.2718", "0.2719")));
        for (old, new) in [("0.27045", "0.27105"), ("0.27288", "0.27348")] {
            assert!(!row(&with(ROW, old, new)), "{old} for {new}");
        }
        for (old, new) in [("0.5721", "0.5755"), ("0.5721", "0.5687"), ("0.0034", "0.0040"), ("96", "90"), ("98", "88")]
        {
            assert!(!agree(TEXT, &with(TEXT, old, new), &Table::default()), "{old} for {new}");
        }
    }

    pub fn other_words_units_and_signs_do_not_agree() {
        for (old, new) in
            [("base_tilt", "payload"), ("°", ""), ("joint1", "joint2"), ("0.5721", "-0.5721"), ("sure;", "")]
        {
            assert!(!agree(TEXT, &with(TEXT, old, new), &Table::default()), "{old} for {new}");
        }
        assert!(!row(&with(ROW, "N·m", "N")) && !row(&with(ROW, "F_C +", "F_C −")));
        assert!(!same_words("a 1", "a 1 2") && !same_words("a 1", "a b") && same_words("a 1 %", "a 2.5 %"));
    }

    pub fn a_row_is_judged_by_its_own_table_only() {
        // Without a head the figure has the last digits alone, and after an empty line the head counts no more.
        let mut table = Table::default();
        let moved = with(ROW, "0.27166", "0.27172");
        assert!(!agree(ROW, &moved, &table));
        table.read(HEAD);
        assert!(agree(ROW, &moved, &table));
        table.read("");
        assert!(!agree(ROW, &moved, &table));
    }
}
