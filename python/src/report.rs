//! Reports of the library as dictionaries.

use std::io::{self, Write};

use pyo3::prelude::*;
use serde::Serialize;
use serde_json::ser::Formatter;

use crate::errors::refuse;

/// JSON of a report, with the infinities that Python's parser knows.
pub fn json(report: &impl Serialize) -> PyResult<String> {
    let mut text = Vec::new();
    let written = report.serialize(&mut serde_json::Serializer::with_formatter(&mut text, WithInfinities));
    written.or_else(|error| refuse(format!("JSON: {error}")))?;
    String::from_utf8(text).or_else(|error| refuse(format!("JSON: {error}")))
}

/// Reports have no bytes but the words of infinite numbers, "inf" and "-inf".
struct WithInfinities;

impl Formatter for WithInfinities {
    fn write_byte_array<W: ?Sized + Write>(&mut self, writer: &mut W, word: &[u8]) -> io::Result<()> {
        writer.write_all(if word.starts_with(b"-") { b"-Infinity" } else { b"Infinity" })
    }
}

/// JSON as Python's own objects.
pub fn object<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (json,))
}
