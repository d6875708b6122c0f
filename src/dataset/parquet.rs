//! Apache Parquet: reads every top-level column of numbers; time stamps are converted to seconds.
//!
//! A column of lists of equal lengths, as LeRobot writes joints, becomes the columns `name.0`, `name.1` ...
//! Left out: other nested columns, text, decimal numbers of more than 18 digits.

mod footer;
mod lists;
mod numbers;
mod pages;
mod quiet;
mod thrift;

use std::fs::File;
use std::panic::AssertUnwindSafe;
use std::path::Path;

use bytes::Bytes;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::{FileMetaData, ParquetMetaDataReader};
use parquet::file::properties::ReaderProperties;
use parquet::file::reader::{ChunkReader, FileReader as _};
use parquet::file::serialized_reader::{ReadOptionsBuilder, SerializedFileReader};

use self::numbers::Meaning;
use super::source_file::{self, MAX_CELLS};
use super::table::{Column, Table, check_cells, check_count};
use crate::error::{Error, Place, Result};

/// Reads all columns. A value that is not a number is stored as a fault of its column.
///
/// # Errors
/// The file cannot be read, is not a Parquet file, is damaged, or is too large.
pub(super) fn read(path: &Path) -> Result<Table> {
    let (file, size) = source_file::open(path)?;
    let probe = file.try_clone().map_err(|source| Error::file(path, "read", source))?;
    decode::<File>(path, size, file, &probe)
}

/// As [`read`], from memory.
///
/// # Errors
/// As [`read`].
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Table> {
    let bytes = Bytes::copy_from_slice(bytes);
    decode::<Bytes>(path, bytes.len() as u64, bytes.clone(), &bytes)
}

/// `probe` is the same file again, for checks before the library allocates memory.
fn decode<R: ChunkReader + 'static>(path: &Path, size: u64, source: R, probe: &R) -> Result<Table> {
    let footer_size = footer::check(path, size, probe)?;
    // The decoders assert properties that a damaged page may violate, in many places that a check beforehand cannot
    // cover. The closure shares only the open files with the caller.
    quiet::catch(AssertUnwindSafe(|| columns(path, size - footer_size, source, probe)))
        .unwrap_or_else(|| Err(damaged(path, "broken pages")))
}

fn columns<R: ChunkReader + 'static>(path: &Path, end: u64, source: R, probe: &R) -> Result<Table> {
    let unreadable = |_: ParquetError| damaged(path, "damaged");
    let metadata = ParquetMetaDataReader::new().parse_and_finish(probe).map_err(unreadable)?;
    let schema = metadata.file_metadata().schema_descr();
    let fields = schema.root_schema().get_fields();
    check_count(path, Place::File, fields.len())?;
    // For each field its column, or several for a field of lists.
    let mut columns: Vec<Vec<Column>> = fields.iter().map(|field| vec![Column::new(field.name())]).collect();
    let mut parts = vec![0; fields.len()];
    (0..schema.num_columns()).for_each(|leaf| parts[schema.get_column_root_idx(leaf)] += 1);
    let mut leaves = Vec::new();
    for (leaf, described) in schema.columns().iter().enumerate() {
        let root = schema.get_column_root_idx(leaf);
        let flat = fields[root].is_primitive() && described.max_rep_level() == 0;
        let list = described.max_rep_level() == 1 && parts[root] == 1;
        match Meaning::of(described).filter(|_| flat || list) {
            Some(meaning) => {
                columns[root][0].seconds = meaning.seconds();
                leaves.push((leaf, root, meaning, list));
            }
            None => columns[root][0].fault = Some((1, numbers::description(described, flat).to_owned())),
        }
    }
    for (name, seconds) in durations(metadata.file_metadata()) {
        columns.iter_mut().filter(|own| own[0].name == name).for_each(|own| own[0].seconds = Some(seconds));
    }
    let groups = metadata.row_groups();
    let rows = groups.iter().try_fold(0_u64, |sum, group| sum.checked_add(u64::try_from(group.num_rows()).ok()?));
    let rows = rows.ok_or_else(|| damaged(path, "a negative count of rows"))?;
    check_cells(path, rows, leaves.len())?;

    let properties = ReaderProperties::builder().set_backward_compatible_lz4(false).build();
    let options = ReadOptionsBuilder::new().with_reader_properties(properties).build();
    let reader = SerializedFileReader::new_with_options(source, options).map_err(unreadable)?;
    let (mut inflated, mut cells) = (0, 0);
    for (index, group) in groups.iter().enumerate() {
        let pages = reader.get_row_group(index).map_err(unreadable)?;
        for &(leaf, root, meaning, list) in &leaves {
            let chunk = group.column(leaf);
            if matches!(chunk.compression(), Compression::LZO) {
                let expected = "columns that are not compressed, or by Snappy, gzip, Zstandard, brotli or LZ4";
                return Err(Error::input(path, Place::File, "compression", "LZO", expected));
            }
            let most = if list { MAX_CELLS as i64 } else { group.num_rows() };
            inflated = pages::check(path, probe, end, chunk, most, inflated)?;
            let columns = &mut columns[root];
            let before = columns[0].values.len();
            let values = pages.get_column_reader(leaf).map_err(unreadable)?;
            let defined = chunk.column_descr().max_def_level();
            if list {
                lists::read(values, meaning, defined, rows as usize, columns).map_err(unreadable)?;
            } else {
                columns[0].make_room(rows as usize - before);
                numbers::read(values, meaning, defined, &mut columns[0]).map_err(unreadable)?;
            }
            if columns.iter().any(|column| (column.values.len() - before) as i64 != group.num_rows()) {
                return Err(damaged(path, "fewer values than rows"));
            }
            cells = check_lists(path, cells, columns.len(), group.num_rows())?;
        }
    }
    let columns = columns.into_iter().flatten().collect();
    Table::new(path, Place::File, columns, Vec::new())
}

/// Columns of durations, with the size of their unit [s]: Parquet has no such type; pandas lists them in its own
/// metadata.
fn durations(metadata: &FileMetaData) -> Vec<(String, f64)> {
    let entries = metadata.key_value_metadata().into_iter().flatten();
    let said = entries.filter(|entry| entry.key == "pandas").find_map(|entry| entry.value.as_deref());
    let said: serde_json::Value = said.and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default();
    let duration = |column: &serde_json::Value| {
        let unit = column["numpy_type"].as_str()?.strip_prefix("timedelta64[")?.strip_suffix(']')?;
        let (_, seconds) = crate::units::unit(unit)?;
        Some((column["field_name"].as_str().or(column["name"].as_str())?.to_owned(), seconds))
    };
    said["columns"].as_array().into_iter().flatten().filter_map(duration).collect()
}

/// Count of cells so far, plus `rows` rows of `columns` columns.
///
/// # Errors
/// They are too many.
fn check_lists(path: &Path, cells: u64, columns: usize, rows: i64) -> Result<u64> {
    let total = cells + rows.unsigned_abs() * columns as u64;
    check_cells(path, total, 1).map(|()| total)
}

fn damaged(path: &Path, value: &str) -> Error {
    Error::input(path, Place::File, "parquet", value, "an Apache Parquet file")
}
