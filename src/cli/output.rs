//! Where results go: files that appear whole or not at all, standard output, tables and JSON.

mod claim;
mod partial;
mod partial_folder;

use std::ffi::OsStr;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use tempfile::TempDir;

use crate::container::Recovered;
use crate::error::{Error, Result};
use crate::monitor::Monitor;
use crate::report::machine;

pub use claim::claim;
use partial::Partial;
pub use partial_folder::PartialFolder;

/// Whether an error is that the reader of our output went away, which is no failure of ours.
pub fn is_broken_pipe(error: &Error) -> bool {
    matches!(error, Error::Io { source, .. } if source.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Names the output in an error of writing; errors that name no file for another reason stay as they are.
pub fn name_output(error: Error, path: &Path) -> Error {
    if matches!(error, Error::Io { .. }) { error.in_file(path) } else { error }
}

/// Prints a result as JSON on standard output.
pub fn print_json(value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
    print_text(&format!("{text}\n"))
}

/// Adds the largest memory that this process took to a JSON report, where the system tells it.
pub fn add_peak_memory(report: &mut serde_json::Value) {
    if let Some(bytes) = machine::peak_memory_bytes() {
        report["peak_memory_bytes"] = bytes.into();
    }
}

/// Prints a line on standard error; where that is closed or full, nothing is lost but the line.
pub fn note(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Prints text on standard output.
pub fn print_text(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| Error::io("-", error))
}

/// A number for JSON: infinities, which JSON has no word for, become the strings "inf" and "-inf".
pub fn json_number(value: f64) -> serde_json::Value {
    if value.is_finite() {
        serde_json::json!(value)
    } else if value.is_nan() {
        serde_json::Value::Null
    } else {
        serde_json::json!(if value > 0.0 { "inf" } else { "-inf" })
    }
}

/// A size for people: `1.25 MB`, powers of ten as in the papers' tables.
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

enum Sink {
    /// A file beside the final one.
    Partial(Partial),
    /// A device, a pipe, or standard output.
    Direct(Box<dyn Write + Send>),
}

/// An output file that takes its name only when it is whole; `-` is standard output. Until then its bytes are in a file
/// beside it, which one process at a time has.
pub struct OutputFile {
    path: PathBuf,
    sink: Sink,
}

impl OutputFile {
    /// Starts the file. Whatever stands under its name stays until [`Self::commit`]; what an unfinished one left goes.
    ///
    /// # Errors
    /// When another process is writing the same output, or no file can be made there.
    pub fn create(path: &Path) -> Result<OutputFile> {
        let mut file = Self::open(path)?;
        if let Sink::Partial(partial) = &mut file.sink {
            partial.start_over()?;
        }
        Ok(file)
    }

    /// The same, with what an unfinished one left: [`Self::go_on`] comes next.
    ///
    /// # Errors
    /// As for [`Self::create`].
    pub fn open(path: &Path) -> Result<OutputFile> {
        let io = |error| Error::io(path, error);
        let sink = if path == Path::new("-") {
            Sink::Direct(Box::new(BufWriter::new(std::io::stdout())))
        } else if std::fs::metadata(path).is_ok_and(|meta| !meta.is_file()) {
            if path.is_dir() {
                return Err(Error::Usage(format!("{}: a folder, where a file name was expected", path.display())));
            }
            Sink::Direct(Box::new(BufWriter::new(File::options().write(true).open(path).map_err(io)?)))
        } else {
            Sink::Partial(Partial::open(path)?)
        };
        Ok(OutputFile { path: path.to_path_buf(), sink })
    }

    /// Whether it can be gone on with after this process: not where it goes into a pipe or a device, or is finished.
    pub fn is_resumable(&self) -> bool {
        matches!(&self.sink, Sink::Partial(partial) if !partial.is_committed())
    }

    /// Whether another process that would write the same output notices this one.
    pub fn is_locked(&self) -> bool {
        matches!(&self.sink, Sink::Partial(partial) if partial.is_locked())
    }

    /// Where the bytes are until [`Self::commit`].
    pub fn work_path(&self) -> &Path {
        match &self.sink {
            Sink::Partial(partial) => partial.path(),
            Sink::Direct(_) => &self.path,
        }
    }

    /// What an earlier process left to go on with, if anything.
    ///
    /// # Errors
    /// When it cannot be read, or the user asks to stop; it is left as it is.
    pub fn recover(&mut self, monitor: &dyn Monitor) -> Result<Option<Recovered>> {
        match &mut self.sink {
            Sink::Partial(partial) => partial.recover(monitor),
            Sink::Direct(_) => Ok(None),
        }
    }

    /// Cuts off what is not sound, or everything where nothing was recovered. Answers where the journal is to be written.
    ///
    /// # Errors
    /// When a file cannot be cut or made; what an earlier process left is left as it is.
    pub fn go_on(&mut self, recovered: Option<&Recovered>) -> Result<Box<dyn Write + Send>> {
        match &mut self.sink {
            Sink::Partial(partial) => Ok(Box::new(partial.go_on(recovered)?)),
            Sink::Direct(_) => Ok(Box::new(std::io::sink())),
        }
    }

    /// Leaves the unfinished file where it is: in [`Self::work_path`].
    ///
    /// # Errors
    /// When what was written may not have reached the disk. It is left all the same.
    pub fn keep(&mut self) -> std::io::Result<()> {
        match &mut self.sink {
            Sink::Partial(partial) => partial.keep(),
            Sink::Direct(_) => Ok(()),
        }
    }

    /// Leaves nothing of the unfinished file, nor of what an earlier process left.
    pub fn discard(&mut self) {
        if let Sink::Partial(partial) = &mut self.sink {
            partial.discard();
        }
    }

    /// Gives the file its name, after its bytes have reached the disk.
    ///
    /// # Errors
    /// When they do not; the file can then still be kept.
    pub fn commit(&mut self) -> Result<()> {
        let written = match &mut self.sink {
            Sink::Partial(partial) => partial.commit(),
            Sink::Direct(writer) => writer.flush(),
        };
        written.map_err(|error| Error::io(&self.path, error))
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match &mut self.sink {
            Sink::Partial(partial) => partial.write(bytes),
            Sink::Direct(writer) => writer.write(bytes),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        match &mut self.sink {
            Sink::Partial(partial) => partial.flush(),
            Sink::Direct(writer) => writer.flush(),
        }
    }
}

/// An output folder whose files appear only when all of them are written.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    work: TempDir,
}

impl OutputFolder {
    /// Starts the folder; its parents are made where they are missing.
    pub fn create(path: &Path) -> Result<OutputFolder> {
        let io = |error| Error::io(path, error);
        if std::fs::metadata(path).is_ok_and(|meta| !meta.is_dir()) {
            return Err(Error::Usage(format!("{}: a file, where a folder was expected", path.display())));
        }
        // Beside the folder, or inside where it exists: it may be a mount point or a link to another disk.
        let parent = if path.exists() { path } else { folder_of(path) };
        if std::fs::metadata(parent).is_ok_and(|meta| !meta.is_dir()) {
            return Err(Error::Usage(format!("{}: a file, where a folder was expected", parent.display())));
        }
        std::fs::create_dir_all(parent).map_err(io)?;
        let work = tempfile::Builder::new().prefix(".lightfold.").suffix(".partial").tempdir_in(parent);
        let work = work.map_err(|error| io(error.kind().into()))?;
        Ok(OutputFolder { path: path.to_path_buf(), work })
    }

    /// Where to write until [`Self::commit`].
    pub fn work_path(&self) -> &Path {
        self.work.path()
    }

    /// Names the final folder in an error that speaks of the temporary one.
    pub fn present(&self, error: Error) -> Error {
        match error {
            Error::Io { file, source } => {
                let file = file.strip_prefix(self.work_path()).map_or(file.clone(), |below| self.path.join(below));
                Error::Io { file, source }
            }
            other => other,
        }
    }

    /// Moves everything to the final folder; files of the same names there are replaced.
    pub fn commit(self) -> Result<()> {
        let path = &self.path;
        let io = |error| Error::io(path, error);
        #[cfg(unix)]
        std::fs::set_permissions(self.work.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755)).map_err(io)?;
        if path.exists() {
            return move_into(self.work.path(), path, &|_| true).map_err(io);
        }
        std::fs::rename(self.work.path(), path).map_err(io)?;
        // There is nothing left to remove under the old name.
        let _ = self.work.keep();
        Ok(())
    }
}

/// Moves what a folder holds, but for what is not wanted by its name.
fn move_into(from: &Path, to: &Path, is_wanted: &dyn Fn(&OsStr) -> bool) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        if !is_wanted(&entry.file_name()) {
            continue;
        }
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            move_into(&entry.path(), &target, is_wanted)?;
        } else {
            std::fs::rename(entry.path(), target)?;
        }
    }
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_that_is_not_committed_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.lfold");
        std::fs::write(&path, "old").unwrap();
        let mut file = OutputFile::create(&path).unwrap();
        file.write_all(b"half").unwrap();
        drop(file);
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let mut file = OutputFile::create(&path).unwrap();
        file.write_all(b"whole").unwrap();
        file.commit().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_appears_whole_and_joins_one_that_exists() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("new/out");
        for name in ["a/x", "a/y"] {
            let folder = OutputFolder::create(&path).unwrap();
            std::fs::create_dir(folder.work_path().join("a")).unwrap();
            std::fs::write(folder.work_path().join(name), name).unwrap();
            folder.commit().unwrap();
        }
        assert_eq!(std::fs::read_dir(path.join("a")).unwrap().count(), 2);
        drop(OutputFolder::create(&path).unwrap());
        assert_eq!(std::fs::read_dir(base.path().join("new")).unwrap().count(), 1);
    }

    #[test]
    fn sizes_are_readable() {
        assert_eq!([0, 999, 1000, 1_250_000].map(human_bytes), ["0 B", "999 B", "1.00 kB", "1.25 MB"]);
        assert_eq!(json_number(f64::INFINITY), serde_json::json!("inf"));
    }
}
