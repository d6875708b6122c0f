//! Checks of the footer of a Parquet file before the library reads it: the lengths of its lists, and the tree of the
//! schema.
//!
//! ```text
//!   pages, footer, its length u32, `PAR1`; the footer is FileMetaData { 2: list of SchemaElement { 5: num_children }, 4: row groups .. }
//! ```

use std::path::Path;

use parquet::file::reader::ChunkReader;

use super::thrift::{self, Event};
use crate::error::{Error, Place, Result};

/// Length and mark at the end [bytes].
const TAIL: u64 = 8;
/// Deepest nesting of columns.
const MAX_DEPTH: usize = 16;
/// Largest footer [bytes]: 60,000 columns in 100 groups of rows take 0.6 GB.
const MAX_FOOTER: u64 = 1 << 30;

/// Checks the footer; returns its length including the bytes that follow it.
///
/// # Errors
/// It is not a valid footer.
pub(super) fn check<R: ChunkReader>(path: &Path, size: u64, source: &R) -> Result<u64> {
    let refuse = |value: &str| Error::input(path, Place::File, "parquet", value, "an Apache Parquet file");
    let at = size.checked_sub(TAIL).ok_or_else(|| refuse("cut off"))?;
    let bytes = |start: u64, length: u64| source.get_bytes(start, length as usize).map_err(|_| refuse("cut off"));
    let tail = bytes(at, TAIL)?;
    let (length, mark) = tail.split_at(4);
    if mark == b"PARE" {
        return Err(refuse("encrypted"));
    }
    let length = u64::from(length.try_into().map_or(0, u32::from_le_bytes));
    if mark != b"PAR1" || length > at || length > MAX_FOOTER {
        return Err(refuse(if mark == b"PAR1" { "damaged footer" } else { "cut off" }));
    }
    let footer = bytes(at - length, length)?;
    let mut children = Vec::new();
    let walked = thrift::walk(&footer, &mut |path, event| match (path, event) {
        ([2], Event::Element) => children.push(0),
        ([2, 5], Event::Number(count)) => {
            if let Some(last) = children.last_mut() {
                *last = count;
            }
        }
        _ => {}
    });
    if walked.is_some() && is_tree(&children) { Ok(length + TAIL) } else { Err(refuse("damaged footer")) }
}

/// Whether counts of children, each node before its children, form one tree that is not too deep.
fn is_tree(children: &[i64]) -> bool {
    let mut open: Vec<i64> = Vec::new();
    for (index, &count) in children.iter().enumerate() {
        // A node whose children are all complete is complete, and its parent may be too.
        while open.last() == Some(&0) {
            open.pop();
        }
        match open.last_mut() {
            Some(left) => *left -= 1,
            None if index > 0 => return false,
            None => {}
        }
        if count < 0 || count as u64 > children.len() as u64 || open.len() > MAX_DEPTH {
            return false;
        }
        open.push(count);
    }
    !children.is_empty() && open.iter().all(|&left| left == 0)
}

#[cfg(test)]
mod tests {
    use super::is_tree;

    #[test]
    fn property_counts_of_children_that_are_no_tree_are_told() {
        for tree in [&[0][..], &[2, 0, 0], &[2, 1, 0, 0], &[1, 2, 0, 0]] {
            assert!(is_tree(tree), "{tree:?}");
        }
        let chain: Vec<i64> = std::iter::repeat_n(1, 1000).chain([0]).collect();
        for other in [&[][..], &[1], &[0, 0], &[2, 0], &[-1, 0], &[i64::MAX, 0], &[1, 0, 0], &chain] {
            assert!(!is_tree(other), "{other:?}");
        }
    }
}
