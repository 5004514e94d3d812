//! Standard output and standard error: text, JSON, notes.

use std::io::Write;
use std::path::Path;

use serde::Serialize;

use crate::cli::with_option_names;
use crate::error::{Error, Result};
use crate::report::machine;

/// Whether the reader of our output has closed it, which is not a failure.
pub fn is_broken_pipe(error: &Error) -> bool {
    matches!(error, Error::Io { source, .. } if source.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Names the output in an error of writing.
pub fn name_output(error: Error, path: &Path) -> Error {
    if matches!(error, Error::Io { .. }) { error.in_file(path) } else { error }
}

/// Prints a result as JSON on standard output.
pub fn print_json(value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
    print_text(&format!("{text}\n"))
}

/// Prints a report as JSON on standard output, with the peak memory of this process where the system reports it.
pub fn print_report(report: &impl Serialize) -> Result<()> {
    #[derive(Serialize)]
    struct WithMemory<'a, T> {
        #[serde(flatten)]
        report: &'a T,
        #[serde(skip_serializing_if = "Option::is_none")]
        peak_memory_bytes: Option<u64>,
    }
    print_json(&WithMemory { report, peak_memory_bytes: machine::peak_memory_bytes() })
}

/// Adds the peak memory of this process to a JSON report, on systems that report it.
pub fn add_peak_memory(report: &mut serde_json::Value) {
    if let Some(bytes) = machine::peak_memory_bytes() {
        report["peak_memory_bytes"] = bytes.into();
    }
}

/// Prints a line on standard error, ignoring errors.
pub fn note(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr().lock(), "{}", with_option_names(&line.to_string()));
}

/// Prints text on standard output.
pub fn print_text(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| Error::io("-", error))
}

/// A number for JSON: infinities become the strings "inf" and "-inf", NaN null.
pub fn json_number(value: f64) -> serde_json::Value {
    if value.is_finite() {
        serde_json::json!(value)
    } else if value.is_nan() {
        serde_json::Value::Null
    } else {
        serde_json::json!(if value > 0.0 { "inf" } else { "-inf" })
    }
}

/// A size with a decimal unit, as `1.25 MB`.
pub fn human_bytes(bytes: u64) -> String {
    let units = ["B", "kB", "MB", "GB", "TB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 1000.0 && unit + 1 < units.len() {
        value /= 1000.0;
        unit += 1;
    }
    if unit == 0 { format!("{bytes} B") } else { format!("{value:.2} {}", units[unit]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_readable() {
        assert_eq!([0, 999, 1000, 1_250_000].map(human_bytes), ["0 B", "999 B", "1.00 kB", "1.25 MB"]);
        assert_eq!(json_number(f64::INFINITY), serde_json::json!("inf"));
    }
}
