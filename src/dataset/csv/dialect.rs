//! How a file of text separates its columns: delimiter, decimal sign, comments, header, units.
//!
//! The beginning of the file is split in every way that occurs in practice. The way that yields the most numbers is
//! taken; of equal ones, the first of [`WAYS`].

use std::ops::Range;

/// Delimiter and decimal sign, in the order in which equally good ways are preferred. A blank stands for a run of
/// blanks and tabs.
const WAYS: [(u8, u8); 9] = [
    (b',', b'.'),
    (b';', b'.'),
    (b';', b','),
    (b'\t', b'.'),
    (b'\t', b','),
    (b'|', b'.'),
    (b' ', b'.'),
    (b' ', b','),
    (b'|', b','),
];

/// Lines at the beginning that are looked at.
const LINES: usize = 200;

/// Characters that begin a comment.
const COMMENTS: [&str; 3] = ["#", "%", "//"];

/// How a file of text is to be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Dialect {
    /// Character between two cells; a blank stands for a run of blanks and tabs.
    pub(super) delimiter: u8,
    /// Decimal sign.
    pub(super) decimal: u8,
    /// Character that begins a comment among the rows.
    pub(super) comment: Option<u8>,
    /// Number of lines before the header, or before the first row where there is none; empty lines and comments are not
    /// counted.
    pub(super) skipped: usize,
    /// Names of the columns if they have no line of their own: they are taken from a comment, or the file has none.
    pub(super) names: Option<Vec<String>>,
    /// Whether the names are numbers because the file has none.
    pub(super) nameless: bool,
}

/// Recognises the dialect of a text by its first lines. `whole` tells whether `head` is the complete text.
pub(super) fn recognise(head: &[u8], whole: bool) -> Dialect {
    let text = decoded(head);
    let mut lines: Vec<&str> = text.split(['\n', '\r']).collect();
    if !whole && lines.len() > 1 {
        // The last line may be cut off.
        lines.pop();
    }
    let lines: Vec<(usize, &str)> =
        lines.into_iter().filter(|line| !line.trim().is_empty()).enumerate().take(LINES).collect();
    let rows: Vec<(usize, &str)> = lines.iter().copied().filter(|(_, line)| comment_of(line).is_none()).collect();
    let signs = lines.iter().filter_map(|(_, line)| comment_of(line));
    // Names of topics begin with a slash.
    let comment = signs.map(|sign| sign.as_bytes()[0]).find(|&sign| sign != b'/');
    let scored = WAYS.iter().map(|way| (score(&rows, *way), way));
    // The first of the best: `max_by` would give the last.
    let best = scored.fold(None, |best: Option<(f64, _)>, (score, way)| match best {
        Some((most, _)) if most >= score => best,
        _ => Some((score, way)),
    });
    let &(delimiter, decimal) = best.map_or(&WAYS[0], |(_, way)| way);
    let width = width(&rows, delimiter);
    let first = first_row(&rows, delimiter, decimal, width);
    let begins = rows.get(first).map_or(0, |(line, _)| *line);
    let dropped = |line: &str| comment.is_some_and(|sign| line.as_bytes().first() == Some(&sign));
    let skipped = lines.iter().take_while(|(at, _)| *at < begins).filter(|(_, line)| !dropped(line)).count();
    let mut dialect = Dialect { delimiter, decimal, comment, skipped, names: None, nameless: false };
    let Some((_, line)) = rows.get(first).filter(|(_, line)| is_row(line, delimiter, decimal)) else {
        return dialect;
    };
    // The names may stand in the last comment before the rows, as numpy writes them.
    let before = lines.iter().take_while(|(at, _)| *at < begins).last().map(|(_, line)| *line);
    let named = before.and_then(|line| Some((line, comment_of(line)?)));
    let names = named.map(|(line, sign)| cells(line.trim_start_matches(sign).trim(), delimiter));
    let fits = |names: &Vec<String>| names.len() == width && names.iter().all(|name| !name.is_empty());
    dialect.names = names.filter(fits);
    if dialect.names.is_none() {
        dialect.nameless = true;
        dialect.names = Some((1..=cells(line, delimiter).len()).map(|number| number.to_string()).collect());
    }
    dialect
}

/// Text of bytes: UTF-8, or else Latin-1, in which old programs write `°` and `µ`.
pub(super) fn decoded(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
        // A character at the end may be cut off.
        Err(error) if error.error_len().is_none() => decoded(&bytes[..error.valid_up_to()]),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// The sign of a comment, if the line is one.
fn comment_of(line: &str) -> Option<&'static str> {
    COMMENTS.into_iter().find(|sign| line.starts_with(sign))
}

/// The cells of a line, without quotes.
pub(super) fn cells(line: &str, delimiter: u8) -> Vec<String> {
    ranges(line, delimiter).map(|range| line[range].trim().trim_matches('"').trim().to_owned()).collect()
}

/// Places of the cells of a line; a delimiter within quotes does not count.
fn ranges(line: &str, delimiter: u8) -> impl Iterator<Item = Range<usize>> {
    let mut ranges = Vec::new();
    let (mut quoted, mut start) = (false, 0);
    let blank = delimiter == b' ';
    for (at, byte) in line.bytes().enumerate() {
        quoted ^= byte == b'"';
        if !quoted && (byte == delimiter || (blank && byte == b'\t')) {
            ranges.push(start..at);
            start = at + 1;
        }
    }
    ranges.push(start..line.len());
    ranges.into_iter().filter(move |range| !(blank && range.is_empty()))
}

/// Whether a cell is a number with that decimal sign.
fn is_number(cell: &str, decimal: u8) -> bool {
    let plain = |text: &str| text.parse::<f64>().is_ok() && text.bytes().any(|byte| byte.is_ascii_digit());
    if decimal == b',' { !cell.contains('.') && plain(&cell.replace(',', ".")) } else { plain(cell) }
}

/// Most frequent number of cells of the rows; of equally frequent ones, the largest.
fn width(rows: &[(usize, &str)], delimiter: u8) -> usize {
    let mut counts: Vec<usize> = rows.iter().map(|(_, line)| ranges(line, delimiter).count()).collect();
    counts.sort_unstable();
    let runs = counts.chunk_by(|a, b| a == b);
    runs.max_by_key(|run| run.len()).map_or(0, |run| run[0])
}

/// Share of all characters that belong to numeric cells in rows of the usual width; 0 for fewer than two cells, which
/// are not a table. Characters are counted instead of cells, so that a way that splits numbers does not win.
fn score(rows: &[(usize, &str)], (delimiter, decimal): (u8, u8)) -> f64 {
    let width = width(rows, delimiter);
    if width < 2 {
        return 0.0;
    }
    let (mut numbers, mut all) = (0, 0);
    for (_, line) in rows {
        let ranges: Vec<Range<usize>> = ranges(line, delimiter).collect();
        all += line.len();
        if ranges.len() == width {
            let cells = ranges.iter().map(|range| line[range.clone()].trim().trim_matches('"'));
            // The delimiter counts as part of its cell; otherwise many short cells would count less than a few long ones.
            numbers += cells.filter(|cell| is_number(cell, decimal)).map(|cell| cell.len() + 1).sum::<usize>();
        }
    }
    numbers as f64 / all.max(1) as f64
}

/// Index of the header, or of the first row where there is none: lines of text before it, with another number of cells,
/// are a preamble.
fn first_row(rows: &[(usize, &str)], delimiter: u8, decimal: u8, width: usize) -> usize {
    let fits = |(_, line): &(usize, &str)| ranges(line, delimiter).count() == width;
    let Some(first) = rows.iter().position(fits) else { return 0 };
    // A quote that stays open makes a header look like text.
    let is_text = |line: &str| ranges(line, delimiter).count() < 2 && line.matches('"').count().is_multiple_of(2);
    let preamble = rows[..first].iter().all(|(_, line)| is_text(line));
    if preamble || !is_row(rows[first].1, delimiter, decimal) { first } else { 0 }
}

/// Whether a line is a row of numbers and not a header: its first cell is a number or a time, and so are half of all.
fn is_row(line: &str, delimiter: u8, decimal: u8) -> bool {
    let cells = cells(line, delimiter);
    let counts = |cell: &String| is_number(cell, decimal) || super::super::date_time::nanoseconds(cell).is_some();
    cells.first().is_some_and(counts) && 2 * cells.iter().filter(|cell| counts(cell)).count() >= cells.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Dialect {
        recognise(text.as_bytes(), true)
    }

    #[test]
    fn property_delimiter_and_decimal_sign_are_found() {
        for (text, delimiter, decimal) in [
            ("time,a,b\n0,1.5,2\n1,2.5,3\n", b',', b'.'),
            ("time;a;b\n0;1.5;2\n1;2.5;3\n", b';', b'.'),
            ("time;a;b\n0,0;1,5;2,5\n0,1;2,5;3,5\n", b';', b','),
            ("time;a\n0,0;1,5\n0,1;2,5\n", b';', b','),
            ("time\ta\n0,0\t1,5\n0,1\t2,5\n", b'\t', b','),
            ("time\ta\n0.0\t1.5\n0.1\t2.5\n", b'\t', b'.'),
            ("time  a   b\n 0.0  1.5 -2\n 0.1 -2.5  3\n", b' ', b'.'),
            ("time|a\n0.0|1.5\n0.1|2.5\n", b'|', b'.'),
            // Text among the numbers.
            ("time,a,state\n0,1.5,idle; waiting\n1,2.5,run\n", b',', b'.'),
        ] {
            let found = of(text);
            assert_eq!((found.delimiter, found.decimal), (delimiter, decimal), "{text}");
            assert!(!found.nameless && found.skipped == 0 && found.names.is_none(), "{text}: {found:?}");
        }
    }

    #[test]
    fn property_preambles_and_names_in_comments_are_found() {
        assert_eq!(of("Log of robot 7\n\nrecorded today\ntime,a\n0,1\n1,2\n").skipped, 2);
        let numpy = of("# made by numpy\n# time a\n0.0 1.5\n0.1 2.5\n");
        assert_eq!(numpy.names.as_deref(), Some(&["time".to_owned(), "a".to_owned()][..]));
        assert!(!numpy.nameless && numpy.comment == Some(b'#'));
        let bare = of("0.0,1.5\n0.1,2.5\n");
        assert!(bare.nameless && bare.names.as_deref() == Some(&["1".to_owned(), "2".to_owned()][..]));
        // A header that lacks a name is still taken as the header, and the rows are refused.
        assert_eq!(of("time,a\n0,1,2\n1,2,3\n").skipped, 0);
        assert!(!of("time,a\n0,1,2\n1,2,3\n").nameless);
    }
}
