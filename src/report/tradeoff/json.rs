//! The report of a sweep as JSON. Values have the names of CSV columns.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::findings::Finding;
use super::kind::{self, Measured};
use super::schedule::FailedPoint;
use super::store::StoredPoint;
use super::study::{Results, Study, Weights};

#[derive(Serialize)]
pub struct Report<'a> {
    input: &'a str,
    command_line: &'a str,
    machine: &'a str,
    version: &'static str,
    weights: Weights,
    studies: &'a [Study],
    points: Vec<Value>,
    findings: &'a [Finding],
    left_out: &'a [String],
    failed: Vec<Value>,
}

impl<'a> Report<'a> {
    /// A report; `rows` are those of the points.
    pub fn new(
        results: &'a Results,
        findings: &'a [Finding],
        rows: &[&StoredPoint],
        failed: &[FailedPoint],
    ) -> Report<'a> {
        let failed = failed.iter().map(|of| json!({ "point": of.point.to_string(), "error": of.error }));
        Report {
            input: &results.input,
            command_line: &results.command_line,
            machine: &results.machine,
            version: env!("CARGO_PKG_VERSION"),
            weights: results.weights,
            studies: &results.studies,
            points: rows.iter().map(|row| point(row)).collect(),
            findings,
            left_out: &results.left_out,
            failed: failed.collect(),
        }
    }
}

pub fn point(row: &StoredPoint) -> Value {
    let mut value = values(&row.measured);
    value["studies"] = json!(row.studies);
    value["command"] = json!(row.command);
    value
}

fn values(measured: &Measured) -> Value {
    let mut value = json!({ "settings": settings(measured) });
    if let Some(stream) = measured.point.stream {
        value["kind"] = json!(stream.name());
    }
    for measure in measured.kind.measures {
        value[measure.name] = match measured.value(measure.name) {
            None => Value::Null,
            Some(kind::Value::Count(count)) => json!(count),
            Some(kind::Value::Number(number)) => json_number(number),
            Some(kind::Value::Runs(runs)) => json!(runs),
        };
    }
    value
}

fn settings(of: &Measured) -> Map<String, Value> {
    of.point.settings.iter().map(|(name, value)| (of.kind.key(name).to_owned(), json!(value))).collect()
}

/// A number; infinities become "inf" and "-inf".
pub fn json_number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!(value.to_string()) }
}
