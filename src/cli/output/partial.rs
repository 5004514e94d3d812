//! The unfinished file beside an output, and the journal by which it can be gone on with.

use std::ffi::OsString;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::claim::{Claimed, claim};
use super::folder_of;
use crate::container::journal::{self, Recovered};
use crate::error::{Error, Result};
use crate::monitor::Monitor;

/// What the name of an unfinished file ends in; it begins with a dot and the name of the output.
const PARTIAL: &str = "partial";
/// What the name of its journal ends in.
const JOURNAL: &str = "journal";

/// An unfinished file that no other process has. It is removed when dropped, unless it was committed or is to be kept. One
/// with a journal is kept until it is said that it is not wanted.
#[derive(Debug)]
pub struct Partial {
    output: PathBuf,
    path: PathBuf,
    writer: BufWriter<File>,
    /// Its path, and the file where there is one.
    journal: (PathBuf, Option<File>),
    is_locked: bool,
    /// Why a part of it may not have reached the disk. The system tells it only once.
    doubt: Option<String>,
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
        let Claimed { file, is_locked } = claimed(&path)?;
        // One that was renamed just now may still have to remove its journal.
        let log = match journal.symlink_metadata().is_ok().then(|| claimed(&journal)).transpose() {
            Ok(log) => log.map(|log| log.file),
            Err(error) => {
                if file.metadata().is_ok_and(|meta| meta.len() == 0) {
                    // It was made just now.
                    let _ = std::fs::remove_file(&path);
                }
                return Err(error);
            }
        };
        let (output, writer, keep) = (output.to_path_buf(), BufWriter::new(file), log.is_some());
        Ok(Partial { output, path, writer, journal: (journal, log), is_locked, doubt: None, keep, committed: false })
    }

    /// Whether another process that wants it would notice this one.
    pub fn is_locked(&self) -> bool {
        self.is_locked
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
    ///
    /// # Errors
    /// When a file cannot be read, or the user asks to stop. Both files stay.
    pub fn recover(&mut self, monitor: &dyn Monitor) -> Result<Option<Recovered>> {
        let Some(log) = &mut self.journal.1 else { return Ok(None) };
        let io = |error| Error::io(&self.path, error);
        let mut records = Vec::new();
        log.seek(SeekFrom::Start(0)).and_then(|_| log.read_to_end(&mut records)).map_err(io)?;
        let file = self.writer.get_mut();
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        let found = journal::recover(&records, BufReader::new(Watched { from: file, monitor }));
        monitor.check()?;
        found.map_err(|error| error.in_file(&self.path))
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
            None => claim(&self.journal.0).map_err(io)?.ok_or_else(busy)?.file,
        };
        let done = cut(&mut log, records).and_then(|()| log.try_clone()).map_err(io);
        self.journal.1 = Some(log);
        if recovered.is_none() && done.is_ok() {
            self.keep = false;
        }
        done
    }

    /// Empties the file, and removes a journal.
    pub fn start_over(&mut self) -> Result<()> {
        cut(self.writer.get_mut(), 0).map_err(|error| Error::io(&self.output, error))?;
        self.keep = false;
        self.remove_journal();
        Ok(())
    }

    /// Leaves nothing, after all.
    pub fn discard(&mut self) {
        self.keep = false;
    }

    fn remove_journal(&mut self) {
        if self.journal.1.is_some() {
            // It is still ours: who comes next claims it, too.
            let _ = std::fs::remove_file(&self.journal.0);
            self.journal.1 = None;
        }
    }

    /// Leaves everything as it is.
    ///
    /// # Errors
    /// When what was written may not have reached the disk. It is left all the same.
    pub fn keep(&mut self) -> std::io::Result<()> {
        self.keep = true;
        // The disk may be full: no chunk that counts is still to be written.
        let _ = self.writer.flush();
        let file = self.sync();
        let log = self.journal.1.as_ref().map_or(Ok(()), File::sync_all);
        let folder = sync_folder(&self.output);
        match &self.doubt {
            Some(why) => Err(std::io::Error::other(why.clone())),
            None => file.and(log).and(folder),
        }
    }

    fn sync(&mut self) -> std::io::Result<()> {
        let done = self.writer.get_ref().sync_all();
        if let Err(error) = &done {
            self.doubt = Some(error.to_string());
        }
        done
    }

    /// Gives the file the name of the output once its bytes have reached the disk.
    pub fn commit(&mut self) -> std::io::Result<()> {
        self.writer.flush()?;
        self.sync()?;
        std::fs::rename(&self.path, &self.output)?;
        // From here on there is nothing under the old name.
        (self.keep, self.committed) = (true, true);
        // Should the disk lose the new name, the journal makes sense of the old one.
        sync_folder(&self.output)?;
        self.remove_journal();
        Ok(())
    }
}

/// Reads until the user asks to stop.
struct Watched<'a, R> {
    from: R,
    monitor: &'a dyn Monitor,
}

impl<R: Read> Read for Watched<'_, R> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        // After an error of the kind `Interrupted` readers try again.
        if self.monitor.interrupted() { Err(std::io::Error::other("asked to stop")) } else { self.from.read(bytes) }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Silent;
    use tempfile::TempDir;

    const LEFT: [(&str, &[u8]); 2] = [(".a.journal", b"records"), (".a.partial", b"chunks")];

    /// A folder with what an unfinished encode of `a` left.
    fn left() -> (TempDir, PathBuf) {
        let folder = TempDir::new().unwrap();
        for (name, bytes) in LEFT {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        let output = folder.path().join("a");
        (folder, output)
    }

    #[track_caller]
    fn is_untouched(folder: &TempDir) {
        for (name, bytes) in LEFT {
            assert_eq!(std::fs::read(folder.path().join(name)).unwrap(), bytes, "{name}");
        }
    }

    fn count(folder: &TempDir) -> usize {
        std::fs::read_dir(folder.path()).unwrap().count()
    }

    #[test]
    fn what_cannot_be_read_or_cut_stays() {
        let (folder, output) = left();
        // A journal that may not be read.
        let mut partial = Partial::open(&output).unwrap();
        partial.journal.1 = Some(File::options().write(true).open(folder.path().join(".a.journal")).unwrap());
        assert!(matches!(partial.recover(&Silent), Err(Error::Io { .. })));
        drop(partial);
        is_untouched(&folder);
        // A file that may not be cut.
        for recovered in [Some(Recovered::default()), None] {
            let mut partial = Partial::open(&output).unwrap();
            partial.writer = BufWriter::new(File::open(folder.path().join(".a.partial")).unwrap());
            assert!(matches!(partial.go_on(recovered.as_ref()), Err(Error::Io { .. })));
            drop(partial);
            is_untouched(&folder);
            let mut partial = Partial::open(&output).unwrap();
            partial.writer = BufWriter::new(File::open(folder.path().join(".a.partial")).unwrap());
            assert!(matches!(partial.start_over(), Err(Error::Io { .. })));
            drop(partial);
            is_untouched(&folder);
        }
        // One that is begun anew is nobody's loss.
        let mut partial = Partial::open(&output).unwrap();
        partial.go_on(None).unwrap();
        drop(partial);
        assert_eq!(count(&folder), 0);
    }

    #[test]
    fn checking_what_was_left_stops_when_asked_and_leaves_it() {
        struct Stops;
        impl Monitor for Stops {
            fn advance(&self, _steps: u64) {}

            fn interrupted(&self) -> bool {
                true
            }
        }
        let (folder, output) = left();
        let mut partial = Partial::open(&output).unwrap();
        assert!(matches!(partial.recover(&Stops), Err(Error::Interrupted)));
        drop(partial);
        is_untouched(&folder);
        let mut watched = Watched { from: &b"abc"[..], monitor: &Stops };
        assert!(watched.read_to_end(&mut Vec::new()).is_err(), "it goes on reading");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_disk_that_may_have_lost_something_is_told() {
        let null = || File::options().write(true).open("/dev/null").unwrap();
        let (folder, output) = left();
        let mut partial = Partial::open(&output).unwrap();
        partial.keep().unwrap();
        // The system has no such thing as bringing this one to the disk.
        let file = std::mem::replace(&mut partial.writer, BufWriter::new(null()));
        assert!(partial.commit().is_err());
        assert!(!partial.is_committed() && !output.exists());
        // What it said once, it does not say again.
        partial.writer = file;
        assert!(partial.keep().is_err());
        drop(partial);
        let mut partial = Partial::open(&output).unwrap();
        partial.journal.1 = Some(null());
        assert!(partial.keep().is_err());
        drop(partial);
        is_untouched(&folder);
    }

    #[test]
    fn a_journal_that_another_process_has_leaves_no_new_file() {
        let (folder, output) = left();
        std::fs::remove_file(folder.path().join(".a.partial")).unwrap();
        let theirs = claim(&folder.path().join(".a.journal")).unwrap();
        assert!(matches!(Partial::open(&output), Err(Error::Usage(_))));
        assert_eq!(count(&folder), 1);
        // One with bytes is not ours to remove.
        std::fs::write(folder.path().join(".a.partial"), b"chunks").unwrap();
        assert!(Partial::open(&output).is_err());
        is_untouched(&folder);
        drop(theirs);
        assert!(Partial::open(&output).is_ok());
    }
}
