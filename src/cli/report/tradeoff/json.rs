//! JSON reports of sweeps and recommendations. Keys are the names of the CSV columns.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::findings::Finding;
use super::point::{self, Measured};
use super::recommend::Advice;
use super::schedule::FailedPoint;
use super::store::StoredPoint;
use super::study::Results;
use footage::json::put;

#[derive(Serialize)]
pub struct Report<'a> {
    #[serde(flatten)]
    pub results: &'a Results,
    pub version: &'static str,
    /// One object per point, as written by [`point()`].
    pub points: Vec<Value>,
    pub findings: &'a [Finding],
    pub failed: &'a [FailedPoint],
    /// Names of all files of the folder that the sweep wrote.
    pub files: Vec<String>,
    #[serde(flatten)]
    pub more: Map<String, Value>,
}

pub fn point(row: &StoredPoint) -> Value {
    let mut value = values(&row.measured);
    value["studies"] = json!(row.studies);
    value["command"] = json!(row.command);
    value
}

fn values(of: &Measured) -> Value {
    let settings = of.point.settings.iter().map(|(name, value)| ((*name).to_owned(), json!(value)));
    let mut value = json!({ "settings": settings.collect::<Map<_, _>>() });
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
