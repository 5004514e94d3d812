//! Standard output and standard error: text, JSON, notes.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

use crate::report::machine;
use crate::report::plot::number::bytes_unit;
use codec::error::{Error, Result};
use footage::files::OutputFile;
use footage::json;

/// Adds the path of the output to a write error.
pub fn name_output(error: Error, path: &Path) -> Error {
    if matches!(error, Error::Io { .. }) { error.in_file(path) } else { error }
}

/// True if a report was printed. Printing a failure as well would make two JSON documents.
static HAS_REPORTED: AtomicBool = AtomicBool::new(false);

pub fn print_json(value: &impl Serialize) -> Result<()> {
    HAS_REPORTED.store(true, Ordering::Relaxed);
    print_text(&json::pretty(value)?)
}

pub fn has_reported() -> bool {
    HAS_REPORTED.load(Ordering::Relaxed)
}

pub fn print_either(as_json: bool, report: &impl Serialize, text: impl FnOnce() -> String) -> Result<()> {
    if as_json { print_json(report) } else { print_text(&text()) }
}

/// A report with the peak memory of this process, if the system provides it.
#[derive(Serialize)]
pub struct WithMemory<T> {
    #[serde(flatten)]
    report: T,
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_memory_bytes: Option<u64>,
}

pub fn with_memory<T: Serialize>(report: T) -> WithMemory<T> {
    WithMemory { report, peak_memory_bytes: machine::peak_memory_bytes() }
}

/// Describes how to resume a stopped command. If an option caused the stop, the same command would stop again.
pub fn how_to_resume(error: &Error) -> &'static str {
    let message = error.to_string();
    match matches!(error, Error::Usage(_)) || with_option_names(&message) != message {
        true => "fix the input, then use --resume with the same options, or start over without --resume",
        false if matches!(error, Error::Invalid { .. }) => {
            "fix the input, then continue with the same command and --resume"
        }
        false => "the same command with --resume continues",
    }
}

pub fn note(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr().lock(), "{}", with_option_names(&line.to_string()));
}

pub fn print_text(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| Error::io("-", error))
}

/// Writes a whole file, or to standard output for `-`.
pub fn write_file(path: &Path, text: &str) -> Result<()> {
    TextFile::create(path)?.write(text)
}

/// A file that is written at the end. Creating it checks that its folder exists.
pub struct TextFile<'a> {
    path: &'a Path,
    file: OutputFile,
}

impl TextFile<'_> {
    pub fn create(path: &Path) -> Result<TextFile<'_>> {
        Ok(TextFile { path, file: OutputFile::create(path)? })
    }

    /// Writes the whole file.
    pub fn write(mut self, text: &str) -> Result<()> {
        self.file.write_all(text.as_bytes()).map_err(|error| Error::io(self.path, error))?;
        self.file.commit()
    }
}

/// Formats durations and counts of stages, one per line: "seconds: merge 1.234", "count: points 7".
pub fn stage_lines(seconds: &impl Serialize, counts: &impl Serialize) -> Result<String> {
    let to_value = |error: serde_json::Error| Error::invalid(format!("JSON: {error}"));
    let [seconds, counts] =
        [serde_json::to_value(seconds), serde_json::to_value(counts)].map(|of| of.map_err(to_value));
    let mut lines = String::new();
    for (title, values) in [("seconds", seconds?), ("count", counts?)] {
        for (name, value) in values.as_object().into_iter().flatten() {
            let value = value.as_f64().filter(|_| title == "seconds").map_or(value.to_string(), |s| format!("{s:.3}"));
            lines += &format!("{title}: {} {value}\n", name.replace('_', " "));
        }
    }
    Ok(lines)
}

/// Formats a size with a decimal unit, such as `1.25 MB`.
pub fn human_bytes(bytes: u64) -> String {
    if bytes < 1000 {
        return format!("{bytes} B");
    }
    let unit = bytes_unit(bytes as f64);
    format!("{:.2} {}", bytes as f64 / unit.size, unit.name)
}

/// Replaces settings, which library messages name in backquotes, by options: `` `depth_window` `` by `--depth-window`.
/// Messages of the JSON parser are unchanged: they name keys of a file in backquotes.
pub fn with_option_names(message: &str) -> String {
    let of_a_file = [
        "unknown field `",
        "missing field `",
        "duplicate field `",
        "unknown variant `",
        "invalid type: ",
        "invalid value: ",
    ];
    if of_a_file.iter().any(|words| message.contains(words)) {
        return message.to_owned();
    }
    let is_setting = |text: &str| {
        text.starts_with(|c: char| c.is_ascii_lowercase())
            && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    let mut text = String::new();
    let mut rest = message;
    while let Some((before, behind)) = rest.split_once('`') {
        text += before;
        rest = behind;
        match behind.split_once('`') {
            Some((name, behind)) if is_setting(name) => {
                text += &format!("--{}", name.replace('_', "-"));
                rest = behind;
            }
            _ => text.push('`'),
        }
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_readable() {
        assert_eq!([0, 999, 1000, 1_250_000].map(human_bytes), ["0 B", "999 B", "1.00 kB", "1.25 MB"]);
    }

    #[test]
    fn settings_become_options() {
        let text = with_option_names("use a smaller `depth_tile` or `hdr`; see `lightfold inspect`, `x y`, `");
        assert_eq!(text, "use a smaller --depth-tile or --hdr; see `lightfold inspect`, `x y`, `");
        let of_files =
            ["unknown field `fvo`, expected one of `eye`, `frames`", "invalid type: boolean `true`, expected an array"];
        for words in of_files {
            assert_eq!(with_option_names(words), words);
        }
    }
}
