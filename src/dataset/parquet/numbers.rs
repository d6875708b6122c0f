//! The numbers of a column of Parquet: its types, its missing values, its time stamps.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::Result;
use parquet::schema::types::ColumnDescriptor;

use super::super::table::Column;

/// Number of rows that are decoded at once.
const BATCH: usize = 4096;
/// Largest number of decimal places of a decimal number in 64 bits.
const MAX_SCALE: i32 = 18;

/// Meaning of the numbers of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Meaning {
    /// Numbers.
    Number,
    /// Whole numbers without a sign.
    Unsigned,
    /// Whole numbers of fractions of one; the fraction.
    Decimal(f64),
    /// Whole numbers of time units; the unit in seconds.
    Time(f64),
}

impl Meaning {
    /// Meaning of a column of numbers; `None` for any other.
    pub(super) fn of(column: &ColumnDescriptor) -> Option<Self> {
        if matches!(column.physical_type(), Type::FLOAT | Type::DOUBLE) {
            return Some(Self::Number);
        }
        if !matches!(column.physical_type(), Type::INT32 | Type::INT64) {
            return None;
        }
        let converted = match column.converted_type() {
            ConvertedType::TIME_MILLIS | ConvertedType::TIMESTAMP_MILLIS => Self::Time(1e-3),
            ConvertedType::TIME_MICROS | ConvertedType::TIMESTAMP_MICROS => Self::Time(1e-6),
            ConvertedType::DATE => Self::Time(86_400.0),
            ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64 => {
                Self::Unsigned
            }
            ConvertedType::DECIMAL => decimal(column.type_scale())?,
            _ => Self::Number,
        };
        Some(match column.logical_type_ref() {
            Some(LogicalType::Time { unit, .. } | LogicalType::Timestamp { unit, .. }) => Self::Time(match unit {
                TimeUnit::MILLIS => 1e-3,
                TimeUnit::MICROS => 1e-6,
                TimeUnit::NANOS => 1e-9,
            }),
            Some(LogicalType::Date) => Self::Time(86_400.0),
            Some(LogicalType::Integer { is_signed: false, .. }) => Self::Unsigned,
            Some(LogicalType::Decimal { scale, .. }) => decimal(*scale)?,
            _ => converted,
        })
    }

    /// [s] Size of one unit, for time stamps.
    pub(super) fn seconds(self) -> Option<f64> {
        if let Self::Time(seconds) = self { Some(seconds) } else { None }
    }
}

fn decimal(scale: i32) -> Option<Meaning> {
    (0..=MAX_SCALE).contains(&scale).then(|| Meaning::Decimal(10_f64.powi(scale)))
}

/// The content of a column that is not numeric.
pub(super) fn description(column: &ColumnDescriptor, flat: bool) -> &'static str {
    let decimal = matches!(column.logical_type_ref(), Some(LogicalType::Decimal { .. }))
        || column.converted_type() == ConvertedType::DECIMAL;
    match column.physical_type() {
        _ if !flat => "(lists or structures)",
        _ if decimal => "(decimal numbers of more than 18 digits)",
        Type::BOOLEAN => "(true or false)",
        Type::INT96 => "(time stamps of the outdated type INT96)",
        Type::BYTE_ARRAY => "(text)",
        _ => "(bytes)",
    }
}

/// Adds the values of a column in a group of rows.
///
/// # Errors
/// They cannot be decoded.
pub(super) fn read(reader: ColumnReader, meaning: Meaning, defined: i16, column: &mut Column) -> Result<()> {
    match reader {
        ColumnReader::DoubleColumnReader(reader) => each(reader, defined, |value| put(column, value.copied())),
        ColumnReader::FloatColumnReader(reader) => {
            each(reader, defined, |value| put(column, value.map(|&value| f64::from(value))))
        }
        ColumnReader::Int32ColumnReader(reader) => each(reader, defined, |value| {
            let whole = |&value: &i32| match meaning {
                Meaning::Unsigned => i64::from(value.cast_unsigned()),
                _ => i64::from(value),
            };
            put_whole(column, meaning, value.map(whole));
        }),
        ColumnReader::Int64ColumnReader(reader) => {
            each(reader, defined, |value| put_whole(column, meaning, value.copied()))
        }
        _ => Ok(()),
    }
}

fn put(column: &mut Column, value: Option<f64>) {
    column.put(value, String::new);
}

fn put_whole(column: &mut Column, meaning: Meaning, value: Option<i64>) {
    match (value, meaning) {
        (None, _) => put(column, None),
        (Some(value), Meaning::Decimal(one)) => put(column, Some(value as f64 / one)),
        (Some(value), Meaning::Unsigned) if value < 0 => put(column, Some(value.cast_unsigned() as f64)),
        (Some(value), _) => column.put_parts(value, 0.0),
    }
}

/// Passes every row to `take`: its value, or that it has none.
fn each<T: DataType>(mut reader: ColumnReaderImpl<T>, defined: i16, mut take: impl FnMut(Option<&T::T>)) -> Result<()> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    loop {
        levels.clear();
        values.clear();
        let (rows, ..) = reader.read_records(BATCH, Some(&mut levels), None, &mut values)?;
        if rows == 0 {
            return Ok(());
        }
        let mut values = values.iter();
        for row in 0..rows {
            let present = defined == 0 || levels.get(row).is_some_and(|&level| level == defined);
            take(if present { values.next() } else { None });
        }
    }
}
