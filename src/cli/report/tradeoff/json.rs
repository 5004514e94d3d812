//! JSON report of a sweep. Keys are the names of the CSV columns.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::findings::Finding;
use super::kind::{self, Measured};
use super::schedule::FailedPoint;
use super::store::StoredPoint;
use super::study::Results;
use footage::json::put;

#[derive(Serialize)]
pub struct Report<'a> {
    #[serde(flatten)]
    pub results: &'a Results,
    pub version: &'static str,
    /// One object per point, as written by [`point`].
    pub points: Vec<Value>,
    pub findings: &'a [Finding],
    pub failed: &'a [FailedPoint],
}

pub fn point(row: &StoredPoint) -> Value {
    let mut value = values(&row.measured);
    value["studies"] = json!(row.studies);
    value["command"] = json!(row.command);
    value
}

fn values(of: &Measured) -> Value {
    let settings = of.point.settings.iter().map(|(name, value)| (of.kind.key(name).to_owned(), json!(value)));
    let mut value = json!({ "settings": settings.collect::<Map<_, _>>() });
    if let Some(stream) = of.point.stream {
        value["kind"] = json!(stream.name());
    }
    for measure in of.kind.measures {
        match of.value(measure.name) {
            None => value[measure.name] = Value::Null,
            Some(kind::Value::Count(count)) => value[measure.name] = json!(count),
            Some(kind::Value::Number(number)) => put(&mut value, measure.name, number),
            Some(kind::Value::Runs(runs)) => value[measure.name] = json!(runs),
        }
    }
    value
}
