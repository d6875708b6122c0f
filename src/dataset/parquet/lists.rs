//! A column of lists: one column for each place in the list.

use parquet::column::reader::ColumnReader;
use parquet::errors::Result;

use super::super::source_file::MAX_CELLS;
use super::super::table::Column;
use super::numbers::{Meaning, Value, each_value};

/// Longest list whose places are columns: more than the joints of any robot. Pictures have more numbers.
const LONGEST: usize = 1000;

/// Adds the lists of a group of rows. The first list determines how many columns there are; a list of another length
/// counts as not a number in its row. `rows` is the number of rows of the file.
///
/// # Errors
/// They cannot be decoded.
pub(super) fn read(
    reader: ColumnReader,
    meaning: Meaning,
    defined: i16,
    rows: usize,
    columns: &mut Vec<Column>,
) -> Result<()> {
    let (mut list, mut begun) = (Vec::new(), false);
    each_value(reader, meaning, defined, |begins, value| {
        if begins && begun {
            put(&list, rows, columns);
            list.clear();
        }
        begun = true;
        // One more than allowed is enough to recognise a list that is too long.
        if list.len() <= LONGEST {
            list.push(value);
        }
    })?;
    if begun {
        put(&list, rows, columns);
    }
    Ok(())
}

fn put(list: &[Value], rows: usize, columns: &mut Vec<Column>) {
    let first = columns.len() == 1 && columns[0].values.is_empty();
    if first && (2..=LONGEST).contains(&list.len()) {
        let (name, seconds) = (columns[0].name.clone(), columns[0].seconds);
        *columns = (0..list.len()).map(|at| Column { seconds, ..Column::new(format!("{name}.{at}")) }).collect();
        columns.iter_mut().for_each(|column| column.make_room(rows.min(MAX_CELLS / list.len())));
    }
    let fits = list.len() == columns.len();
    for (at, column) in columns.iter_mut().enumerate() {
        match list.get(at).filter(|_| fits) {
            Some(value) => value.put(column),
            None => column.put(None, || format!("(a list of {} numbers)", list.len())),
        }
    }
}
