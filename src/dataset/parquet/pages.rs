//! Checks of the pages of a column before the library decodes them: their place, and the sizes that they state.
//!
//! ```text
//!   PageHeader { 1: type, 2: uncompressed size, 3: compressed size, 5: { 1: values }, 7: { 1: values }, 8: { 1: values } }
//! ```
//! with the numbers of values of a data page, a dictionary and a data page of version 2.

use std::path::Path;

use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::ChunkReader;

use super::super::source_file::{self, MAX_BYTES};
use super::thrift::{self, Event};
use crate::error::{Error, Place, Result};

/// Largest page when decompressed [bytes]. Writers cut pages at 1 MB, some at a group of rows of 128 MB.
const MAX_PAGE: i64 = 256 << 20;
/// Bytes of a header that are read: without the statistics of long texts a header has some hundred.
const MAX_HEADER: u64 = 1 << 16;

/// Type of a dictionary.
const DICTIONARY: i64 = 2;

/// A header of a page.
#[derive(Debug, Default)]
struct Header {
    kind: i64,
    uncompressed: i64,
    compressed: i64,
    values: i64,
    dictionary: i64,
}

/// Checks the pages of a column in a group of `rows` rows; returns the decompressed size of all pages so far [bytes].
///
/// `end` is the position at which the pages of the file end.
///
/// # Errors
/// They do not lie within the file, or are too large.
pub(super) fn check<R: ChunkReader>(
    path: &Path,
    source: &R,
    end: u64,
    chunk: &ColumnChunkMetaData,
    rows: i64,
    inflated: u64,
) -> Result<u64> {
    let name = chunk.column_path().string();
    let refuse = |value: &str| Error::input(path, Place::File, &name, value, "whole pages of a Parquet file");
    let start = chunk.dictionary_page_offset().unwrap_or_else(|| chunk.data_page_offset());
    let span = u64::try_from(start).ok().zip(u64::try_from(chunk.compressed_size()).ok());
    let (mut at, left) = span.ok_or_else(|| refuse("pages outside of the file"))?;
    let stop = at.checked_add(left).filter(|&stop| stop <= end).ok_or_else(|| refuse("pages outside of the file"))?;
    let (mut values, mut inflated) = (0_i64, inflated);
    while at < stop {
        let length = (stop - at).min(MAX_HEADER);
        let bytes = source.get_bytes(at, length as usize).map_err(|_| refuse("cut off"))?;
        let (length, header) = header(&bytes).ok_or_else(|| refuse("a damaged page"))?;
        let compressed = u64::try_from(header.compressed).map_err(|_| refuse("a damaged page"))?;
        at = at.saturating_add(length as u64).saturating_add(compressed);
        if at > stop || header.uncompressed < 0 || header.values < 0 {
            return Err(refuse("a damaged page"));
        }
        // A value in a dictionary has bytes of its own.
        if header.kind == DICTIONARY && !(0..=header.uncompressed).contains(&header.dictionary) {
            return Err(refuse("a damaged dictionary"));
        }
        if header.uncompressed > MAX_PAGE {
            let value = format!("a page of {}", source_file::shown(header.uncompressed as u64));
            let expected = format!("pages of at most {}", source_file::shown(MAX_PAGE as u64));
            return Err(Error::input(path, Place::File, &name, value, expected));
        }
        values = values.saturating_add(header.values);
        inflated += header.uncompressed as u64;
        if inflated > 2 * MAX_BYTES {
            let expected = format!("at most {} in all pages", source_file::shown(2 * MAX_BYTES));
            return Err(Error::input(path, Place::File, "uncompressed size", source_file::shown(inflated), expected));
        }
    }
    if values > rows { Err(refuse("more values than rows")) } else { Ok(inflated) }
}

fn header(bytes: &[u8]) -> Option<(usize, Header)> {
    let mut header = Header::default();
    let length = thrift::walk(bytes, &mut |path, event| {
        let Event::Number(number) = event else { return };
        match path {
            [1] => header.kind = number,
            [2] => header.uncompressed = number,
            [3] => header.compressed = number,
            [5 | 8, 1] => header.values = number,
            [7, 1] => header.dictionary = number,
            _ => {}
        }
    })?;
    Some((length, header))
}
