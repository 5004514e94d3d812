//! Reports of the library as dictionaries.

use pyo3::prelude::*;
use serde::Serialize;

use crate::errors::refuse;

/// JSON of a report, with the infinities that Python's parser knows.
pub fn json(report: &impl Serialize) -> PyResult<String> {
    let text = serde_json::to_string(report).or_else(|error| refuse(format!("JSON: {error}")))?;
    Ok(text.replace("\"∞\"", "Infinity").replace("\"-∞\"", "-Infinity"))
}

/// JSON as Python's own objects.
pub fn object<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (json,))
}
