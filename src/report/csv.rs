//! Rows of results as CSV, under the names that JSON has for them.

use serde::Serialize;
use serde_json::Value;

use crate::error::{Error, Result};
use crate::json;

/// Rows of flat structures; the columns are their fields.
pub fn of_rows<T: Serialize>(rows: &[T]) -> Result<String> {
    text(|writer| rows.iter().try_for_each(|row| writer.serialize(row)))
}

pub fn of_records(records: impl IntoIterator<Item = Vec<String>>) -> Result<String> {
    text(|writer| records.into_iter().try_for_each(|record| writer.write_record(record)))
}

/// One row for each JSON object.
///
/// A column is named by the key that it shows, `outer.inner` for a key of an object inside; the heading is then
/// `outer_inner`. A key that an object does not have leaves its cell empty.
pub fn of_objects(columns: &[&str], objects: &[impl Serialize]) -> Result<String> {
    let mut records = vec![columns.iter().map(|column| column.replace('.', "_")).collect()];
    for object in objects {
        let object = serde_json::to_value(object).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
        let cell = |column: &&str| match column.split('.').try_fold(&object, |object, key| object.get(key)) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) => json::word(text).to_owned(),
            Some(other) => other.to_string(),
        };
        records.push(columns.iter().map(cell).collect());
    }
    of_records(records)
}

fn text(write: impl FnOnce(&mut csv::Writer<Vec<u8>>) -> csv::Result<()>) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let broken = |error: &dyn std::error::Error| Error::invalid(format!("CSV: {error}"));
    write(&mut writer).map_err(|error| broken(&error))?;
    let bytes = writer.into_inner().map_err(|error| broken(error.error()))?;
    String::from_utf8(bytes).map_err(|error| broken(&error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn keys_become_columns_and_missing_ones_empty_cells() {
        let objects =
            [json!({ "a": 1, "b": { "c": 2.5 }, "d": "x,y" }), json!({ "a": null, "d": json::Number(f64::INFINITY) })];
        assert_eq!(of_objects(&["a", "b.c", "d"], &objects).unwrap(), "a,b_c,d\n1,2.5,\"x,y\"\n,,inf\n");
    }

    #[test]
    fn fields_become_columns() {
        #[derive(Serialize)]
        struct Row {
            name: &'static str,
            count: u64,
        }
        let rows = [Row { name: "a", count: 1 }, Row { name: "b", count: 2 }];
        assert_eq!(of_rows(&rows).unwrap(), "name,count\na,1\nb,2\n");
    }
}
