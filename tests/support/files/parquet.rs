//! Parquet files.

use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FixedLenByteArray, FixedLenByteArrayType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use super::recordings::{ROWS, positions};

/// A third column.
pub enum Third<'a> {
    Numbers(&'a [f64]),
    Whole(&'a [i64]),
    Text,
    Bytes,
}

/// A recording whose time has this type and these values, and whose third column is this.
pub fn written(time: &str, values: &[i64], third: &str, content: &Third<'_>, compression: Compression) -> Vec<u8> {
    let schema = format!("message run {{ required int64 time {time}; required double turn.position; {third} }}");
    let schema = Arc::new(parse_message_type(&schema).expect("a schema"));
    let properties = WriterProperties::builder().set_compression(compression).build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, properties.into()).expect("a writer");
    let mut rows = writer.next_row_group().expect("rows");
    let mut column = rows.next_column().expect("rows").expect("time");
    column.typed::<Int64Type>().write_batch(values, None, None).expect("time");
    column.close().expect("time");
    let mut column = rows.next_column().expect("rows").expect("position");
    column.typed::<DoubleType>().write_batch(&positions()[..values.len()], None, None).expect("position");
    column.close().expect("position");
    {
        let mut column = rows.next_column().expect("rows").expect("a third");
        let count = values.len();
        match content {
            Third::Numbers(values) => column.typed::<DoubleType>().write_batch(values, None, None).map(drop),
            Third::Whole(values) => column.typed::<Int64Type>().write_batch(values, None, None).map(drop),
            Third::Text => {
                column.typed::<ByteArrayType>().write_batch(&vec![ByteArray::from("idle"); count], None, None).map(drop)
            }
            _ => {
                let bytes = FixedLenByteArray::from(vec![0_u8; 16]);
                column.typed::<FixedLenByteArrayType>().write_batch(&vec![bytes; count], None, None).map(drop)
            }
        }
        .expect("values");
        column.close().expect("a third");
    }
    rows.close().expect("rows");
    writer.into_inner().expect("the file")
}

/// Time stamps, so many to a millisecond.
pub fn counts(step: i64) -> Vec<i64> {
    (0..ROWS as i64).map(|row| 1_700_000_000 * 1000 * step + row * step).collect()
}

/// A good file.
pub fn good(compression: Compression) -> Vec<u8> {
    let torque: Vec<f64> = positions().iter().map(|position| -position).collect();
    let third = Third::Numbers(&torque);
    written("(TIMESTAMP(MICROS,true))", &counts(1000), "required double turn.torque;", &third, compression)
}
