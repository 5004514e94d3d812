//! JSON reports of sweeps and recommendations. Keys are the names of the CSV columns.

use serde_json::{Map, Value, json};

use super::findings::Finding;
use super::point;
use super::recommend::Advice;
use super::schedule::FailedPoint;
use super::store::StoredPoint;
use super::study::Results;
use codec::error::{Error, Result};
use footage::json::put;

/// Returns the report of a sweep. `rows` are its points, `files` the names of all files of the folder that it wrote, and
/// `more` further keys.
pub fn report(
    results: &Results,
    rows: &[&StoredPoint],
    (findings, failed): (&[Finding], &[FailedPoint]),
    files: &[String],
    more: Map<String, Value>,
) -> Result<Value> {
    let mut all = serde_json::to_value(results).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
    let points: Vec<Value> = rows.iter().map(|row| point(row)).collect();
    let own = [
        ("version", json!(env!("CARGO_PKG_VERSION"))),
        ("points", json!(points)),
        ("findings", json!(findings)),
        ("failed", json!(failed)),
        ("files", json!(files)),
    ];
    own.into_iter().for_each(|(key, value)| all[key] = value);
    more.into_iter().for_each(|(key, value)| all[key] = value);
    Ok(all)
}

fn point(row: &StoredPoint) -> Value {
    let of = &row.measured;
    let settings = of.point.settings.iter().map(|(name, value)| ((*name).to_owned(), json!(value)));
    let settings: Map<_, _> = settings.collect();
    let mut value = json!({ "settings": settings, "studies": row.studies, "command": row.command });
    if let Some(stream) = of.point.stream {
        value["kind"] = json!(stream.name());
    }
    for measure in &of.kind.measures {
        match of.value(measure.name) {
            None => value[measure.name] = Value::Null,
            Some(point::Value::Count(count)) => value[measure.name] = json!(count),
            Some(point::Value::Number(number)) => put(&mut value, measure.name, number),
            Some(point::Value::Runs(runs)) => value[measure.name] = json!(runs),
        }
    }
    value
}

pub fn advice(advice: &Advice<'_>) -> Value {
    json!({
        "kind": advice.row.measured.point.stream.map(|stream| stream.name()),
        "found": advice.misses.is_empty(),
        "misses": advice.misses,
        "command": advice.row.command,
        "point": point(advice.row),
    })
}
