//! The unfinished file beside an output, and the journal by which it can be gone on with.

use std::ffi::OsString;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::claim::claim;
use super::folder_of;
use crate::container::journal::{self, Recovered};
use crate::error::{Error, Result};

/// What the name of an unfinished file ends in; it begins with a dot and the name of the output.
const PARTIAL: &str = "partial";
/// What the name of its journal ends in.
const JOURNAL: &str = "journal";

/// An unfinished file that no other process has. It is removed when dropped, unless it was committed or is to be kept.
#[derive(Debug)]
pub struct Partial {
    output: PathBuf,
    path: PathBuf,
    writer: BufWriter<File>,
    /// Its path, and the file where there is one.
    journal: (PathBuf, Option<File>),
    keep: bool,
    committed: bool,
}

/// The name of a file beside an output.
fn beside(output: &Path, end: &str) -> Result<PathBuf> {
    let mut name = OsString::from(".");
    name.push(output.file_name().ok_or_else(|| Error::Usage(format!("{}: no file name", output.display())))?);
    name.push(".");
    name.push(end);
    Ok(folder_of(output).join(name))
}

impl Partial {
    /// Opens the unfinished file of an output, as it is; a new one is empty.
    pub fn open(output: &Path) -> Result<Partial> {
        let folder = folder_of(output);
        if !folder.is_dir() {
            return Err(Error::Usage(format!("{}: there is no folder {}", output.display(), folder.display())));
        }
        let (path, journal) = (beside(output, PARTIAL)?, beside(output, JOURNAL)?);
        let busy = || {
            Error::Usage(format!(
                "{}: another lightfold is writing it, in {}; wait for it, or name another file",
                output.display(),
                path.display()
            ))
        };
        let claimed = |path: &Path| claim(path).map_err(|error| Error::io(output, error))?.ok_or_else(busy);
        let file = claimed(&path)?;
        // One that was renamed just now may still have to remove its journal.
        let log = if journal.symlink_metadata().is_ok() { Some(claimed(&journal)?) } else { None };
        let (output, writer) = (output.to_path_buf(), BufWriter::new(file));
        Ok(Partial { output, path, writer, journal: (journal, log), keep: false, committed: false })
    }

    /// Whether the output has its name.
    pub fn is_committed(&self) -> bool {
        self.committed
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What there is to go on with: `None` without a journal, or where nothing of either file is sound.
    pub fn recover(&mut self) -> Result<Option<Recovered>> {
        let Some(log) = &mut self.journal.1 else { return Ok(None) };
        let io = |error| Error::io(&self.path, error);
        let mut records = Vec::new();
        log.seek(SeekFrom::Start(0)).and_then(|_| log.read_to_end(&mut records)).map_err(io)?;
        let file = self.writer.get_mut();
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        journal::recover(&records, BufReader::new(file)).map_err(|error| error.in_file(&self.path))
    }

    /// Cuts file and journal to what was recovered, or to nothing; what is written then is appended. Answers where the
    /// journal is to be written.
    pub fn go_on(&mut self, recovered: Option<&Recovered>) -> Result<File> {
        let io = |error| Error::io(&self.output, error);
        let (bytes, records) = recovered.map_or((0, 0), |found| (found.container_bytes(), found.journal_bytes()));
        cut(self.writer.get_mut(), bytes).map_err(io)?;
        let busy = || Error::Usage(format!("{}: another process has it", self.journal.0.display()));
        let mut log = match self.journal.1.take() {
            Some(log) => log,
            None => claim(&self.journal.0).map_err(io)?.ok_or_else(busy)?,
        };
        cut(&mut log, records).map_err(io)?;
        let other = log.try_clone().map_err(io);
        self.journal.1 = Some(log);
        other
    }

    /// Empties the file, and removes a journal.
    pub fn start_over(&mut self) -> Result<()> {
        cut(self.writer.get_mut(), 0).map_err(|error| Error::io(&self.output, error))?;
        self.remove_journal();
        Ok(())
    }

    fn remove_journal(&mut self) {
        if self.journal.1.is_some() {
            // It is still ours: who comes next claims it, too.
            let _ = std::fs::remove_file(&self.journal.0);
            self.journal.1 = None;
        }
    }

    /// Leaves everything as it is, with what was written on its way to the disk.
    pub fn keep(&mut self) {
        self.keep = true;
        // The disk may be full or broken: what counts is checked when it is gone on with.
        let _ = self.writer.flush();
        let _ = self.writer.get_ref().sync_all();
        if let (_, Some(log)) = &self.journal {
            let _ = log.sync_all();
        }
        let _ = sync_folder(&self.output);
    }

    /// Gives the file the name of the output once its bytes have reached the disk.
    pub fn commit(&mut self) -> std::io::Result<()> {
        self.writer.flush()?;
        self.writer.get_ref().sync_all()?;
        std::fs::rename(&self.path, &self.output)?;
        // From here on there is nothing under the old name.
        (self.keep, self.committed) = (true, true);
        self.remove_journal();
        sync_folder(&self.output)
    }
}

fn cut(file: &mut File, bytes: u64) -> std::io::Result<()> {
    file.set_len(bytes)?;
    file.seek(SeekFrom::Start(bytes)).map(|_| ())
}

/// Brings a rename to the disk, where folders can be told to.
#[cfg(unix)]
fn sync_folder(output: &Path) -> std::io::Result<()> {
    use std::io::ErrorKind::{InvalidInput, Unsupported};
    // A folder that may be written to but not read cannot be opened.
    let Ok(folder) = File::open(folder_of(output)) else { return Ok(()) };
    match folder.sync_all() {
        Err(error) if !matches!(error.kind(), InvalidInput | Unsupported) => Err(error),
        _ => Ok(()),
    }
}

#[cfg(not(unix))]
fn sync_folder(_output: &Path) -> std::io::Result<()> {
    Ok(())
}

impl Write for Partial {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.writer.flush()
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        // A journal makes sense of what was left by a panic, too.
        let panicked = std::thread::panicking() && self.journal.1.is_some();
        if !self.keep && !panicked {
            let _ = std::fs::remove_file(&self.path);
            self.remove_journal();
        }
    }
}
