//! Results as CSV. Columns have the names of the JSON keys.

use serde::Serialize;
use serde_json::Value;

use codec::error::{Error, Result};
use footage::json;

/// Writes one row per flat structure. The columns are the fields.
pub fn of_rows<T: Serialize>(rows: &[T]) -> Result<String> {
    text(|writer| rows.iter().try_for_each(|row| writer.serialize(row)))
}

pub fn of_records(records: impl IntoIterator<Item = Vec<String>>) -> Result<String> {
    text(|writer| records.into_iter().try_for_each(|record| writer.write_record(record)))
}

/// Writes one row per JSON object.
///
/// A column is named by its JSON key, or `outer.inner` for a key of a nested object; its heading is then `outer_inner`.
/// The cell is empty if the object lacks the key.
pub fn of_objects(columns: &[&str], objects: &[impl Serialize]) -> Result<String> {
    let mut records = vec![columns.iter().map(|column| column.replace('.', "_")).collect()];
    for object in objects {
        let object: Value =
            serde_json::from_str(&json::pretty(object)?).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
        let cell = |column: &&str| {
            let (outer, key) = column.rsplit_once('.').map_or(("", *column), |(outer, key)| (outer, key));
            let mut outer = outer.split('.').filter(|key| !key.is_empty());
            let Some(object) = outer.try_fold(&object, |object, key| object.get(key)) else { return String::new() };
            match object.get(key) {
                None | Some(Value::Null) => json::read_word(object, key).unwrap_or_default().to_owned(),
                Some(Value::String(text)) => text.clone(),
                Some(other) => other.to_string(),
            }
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
        let objects = [
            json!({ "a": 1, "b": { "c": 2.5 }, "d": "x,y" }),
            json!({ "a": null, "b": { "c": null, "c_is": "-inf" }, "d": null, "d_is": "inf" }),
        ];
        assert_eq!(of_objects(&["a", "b.c", "d"], &objects).unwrap(), "a,b_c,d\n1,2.5,\"x,y\"\n,-inf,inf\n");
        #[derive(Serialize)]
        struct Object {
            e_db: json::Number,
        }
        let objects = [f64::INFINITY, 2.5].map(|value| Object { e_db: json::Number(value) });
        assert_eq!(of_objects(&["e_db"], &objects).unwrap(), "e_db\ninf\n2.5\n");
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
