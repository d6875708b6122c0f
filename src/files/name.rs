//! Which names from the content of files may become file names.

/// Longest name [bytes in UTF-8]: file systems allow 255, and endings such as `.csv` need room.
const LONGEST: usize = 200;

/// What [`is_fit_name`] expects, for errors.
pub const FIT_NAME: &str =
    "a name: 1 to 200 bytes without / and \\, control characters, a dot in front or spaces around it";

/// Whether a text is a valid name for a file or a folder on every system, and cannot leave its folder.
///
/// Refused are the empty name, `.`, `..` and hidden names, path separators, control characters (including those that
/// change the writing direction), leading or trailing spaces, and more than 200 bytes.
pub fn is_fit_name(name: &str) -> bool {
    let turns = |c: char| matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let unfit = |c: char| matches!(c, '/' | '\\') || c.is_control() || turns(c);
    !name.is_empty() && name.len() <= LONGEST && !name.starts_with('.') && name.trim() == name && !name.contains(unfit)
}
