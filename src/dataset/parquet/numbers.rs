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
    each_value(reader, meaning, defined, |_, value| value.put(column))
}

/// A value of a column.
#[derive(Debug, Clone, Copy)]
pub(super) enum Value {
    /// None: it is missing, or a list is empty.
    Missing,
    /// A number.
    Number(f64),
    /// A whole number, which may be too long for a double.
    Whole(i64),
}

impl Value {
    /// Puts the value into a column.
    pub(super) fn put(self, column: &mut Column) {
        match self {
            Self::Missing => column.put(None, String::new),
            Self::Number(value) => column.put(Some(value), String::new),
            Self::Whole(value) => column.put_parts(value, 0.0),
        }
    }

    fn of(whole: Option<i64>, meaning: Meaning) -> Self {
        match (whole, meaning) {
            (None, _) => Self::Missing,
            (Some(value), Meaning::Decimal(one)) => Self::Number(value as f64 / one),
            (Some(value), Meaning::Unsigned) if value < 0 => Self::Number(value.cast_unsigned() as f64),
            (Some(value), _) => Self::Whole(value),
        }
    }
}

/// Passes every value to `take`, and whether it begins a row.
///
/// # Errors
/// They cannot be decoded.
pub(super) fn each_value(
    reader: ColumnReader,
    meaning: Meaning,
    defined: i16,
    mut take: impl FnMut(bool, Value),
) -> Result<()> {
    let number = |value: Option<f64>| value.map_or(Value::Missing, Value::Number);
    match reader {
        ColumnReader::DoubleColumnReader(reader) => {
            each(reader, defined, |begins, value| take(begins, number(value.copied())))
        }
        ColumnReader::FloatColumnReader(reader) => {
            each(reader, defined, |begins, value| take(begins, number(value.map(|&value| f64::from(value)))))
        }
        ColumnReader::Int32ColumnReader(reader) => each(reader, defined, |begins, value| {
            let whole = |&value: &i32| match meaning {
                Meaning::Unsigned => i64::from(value.cast_unsigned()),
                _ => i64::from(value),
            };
            take(begins, Value::of(value.map(whole), meaning));
        }),
        ColumnReader::Int64ColumnReader(reader) => {
            each(reader, defined, |begins, value| take(begins, Value::of(value.copied(), meaning)))
        }
        _ => Ok(()),
    }
}

/// Passes every value to `take`, or that it is missing, and whether it begins a row.
fn each<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    defined: i16,
    mut take: impl FnMut(bool, Option<&T::T>),
) -> Result<()> {
    let (mut levels, mut repeats, mut values) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        levels.clear();
        repeats.clear();
        values.clear();
        let (rows, _, count) = reader.read_records(BATCH, Some(&mut levels), Some(&mut repeats), &mut values)?;
        if rows == 0 {
            return Ok(());
        }
        let mut values = values.iter();
        // Without levels, every row has one value.
        for at in 0..count.max(rows) {
            let present = defined == 0 || levels.get(at).is_some_and(|&level| level == defined);
            take(repeats.get(at).is_none_or(|&level| level == 0), if present { values.next() } else { None });
        }
    }
}
