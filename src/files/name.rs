//! Which names from the content of files may become file names, and which may be shown.

/// Longest name [bytes in UTF-8]: file systems allow 255, and endings such as `.csv` need room.
const LONGEST: usize = 200;

/// What [`is_fit_name`] expects, for errors.
pub const FIT_NAME: &str =
    "a name: 1 to 200 bytes without / and \\, control characters, a dot in front or spaces around it";

/// What [`is_plain_name`] expects, for errors.
pub const PLAIN_NAME: &str = "a name without control characters";

/// Whether a character is invisible and acts on what shows a text: control characters, and those that change the writing direction.
pub fn is_control(c: char) -> bool {
    c.is_control() || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Whether a terminal shows a name as it is: no [control characters](is_control).
pub fn is_plain_name(name: &str) -> bool {
    !name.contains(is_control)
}

/// Whether a text is a valid name for a file or a folder on every system, and cannot leave its folder.
///
/// Refused are the empty name, `.`, `..` and hidden names, path separators, [control characters](is_control), leading or
/// trailing spaces, and more than 200 bytes.
pub fn is_fit_name(name: &str) -> bool {
    let one_part = !name.starts_with('.') && !name.contains(['/', '\\']);
    !name.is_empty() && name.len() <= LONGEST && one_part && name.trim() == name && is_plain_name(name)
}
