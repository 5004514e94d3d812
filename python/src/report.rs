//! Conversion of the library's reports to Python dictionaries.

use std::io::{self, Write};

use pyo3::prelude::*;
use serde::Serialize;
use serde_json::ser::Formatter;

use crate::errors::refuse;

/// Returns a report as JSON; infinite numbers are `Infinity` and `-Infinity`, which Python's parser accepts.
pub fn json(report: &impl Serialize) -> PyResult<String> {
    let mut text = Vec::new();
    let written = report.serialize(&mut serde_json::Serializer::with_formatter(&mut text, WithInfinities));
    written.or_else(|error| refuse(format!("JSON: {error}")))?;
    String::from_utf8(text).or_else(|error| refuse(format!("JSON: {error}")))
}

/// Formats byte arrays as infinities: the only byte arrays in reports are the words "inf" and "-inf" of infinite numbers.
struct WithInfinities;

impl Formatter for WithInfinities {
    fn write_byte_array<W: ?Sized + Write>(&mut self, writer: &mut W, word: &[u8]) -> io::Result<()> {
        writer.write_all(if word.starts_with(b"-") { b"-Infinity" } else { b"Infinity" })
    }
}

/// Parses JSON into Python objects.
pub fn object<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (json,))
}
