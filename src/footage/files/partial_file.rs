//! The unfinished file beside an output, and the journal from which a later process resumes.

use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::disk::{self, DiskFile};
use super::lock::{Locked, open_locked};
use super::names::{check_file, hidden_beside, parent_of};
use codec::error::{Error, Result};

/// Suffix of an unfinished file's name, after a dot and the name of the output.
const PARTIAL: &str = ".partial";
/// Suffix of the journal's name.
const JOURNAL: &str = ".journal";

/// Size of the write buffer in bytes.
const BUFFER_BYTES: usize = 1 << 20;

/// Number of intact bytes at the start of an unfinished file and of its journal.
#[derive(Debug, Clone, Copy, Default)]
pub struct IntactBytes {
    pub file: u64,
    pub journal: u64,
}

/// An unfinished file that this process has locked. Dropping it removes the file, unless it was committed or kept. A file
/// with a journal is kept until [`Self::discard`].
#[derive(Debug)]
pub struct PartialFile {
    output: PathBuf,
    /// Path of the unfinished file.
    pub path: PathBuf,
    writer: BufWriter<DiskFile>,
    journal_path: PathBuf,
    /// `None` if it does not exist yet.
    journal: Option<DiskFile>,
    /// False if the file system has no locks.
    pub is_locked: bool,
    /// Error of a sync: a part of the file may not have reached the disk. The system reports it only once.
    sync_error: Option<String>,
    keep: bool,
    pub is_committed: bool,
    /// Modification time of the output; `None` for the actual one.
    pub modified: Option<SystemTime>,
}

fn beside(output: &Path, end: &str) -> Result<PathBuf> {
    hidden_beside(output, end).ok_or_else(|| Error::Usage(format!("{}: no file name", output.display())))
}

impl PartialFile {
    /// Opens the unfinished file of an output and keeps its content; a new file is empty.
    pub fn open(output: &Path) -> Result<PartialFile> {
        check_file(output)?;
        let (path, journal_path) = (beside(output, PARTIAL)?, beside(output, JOURNAL)?);
        let busy = || {
            let place = path.display();
            Error::busy(
                output,
                format!("another lightfold process is writing it, in {place}: wait for it, or use another file"),
            )
        };
        let open = |path: &Path| open_locked(path).map_err(|error| Error::io(output, error))?.ok_or_else(busy);
        let Locked { file, is_locked } = open(&path)?;
        // A process that has just renamed its file may not have removed its journal yet.
        let journal = match journal_path.symlink_metadata().is_ok().then(|| open(&journal_path)).transpose() {
            Ok(journal) => journal.map(|journal| journal.file),
            Err(error) => {
                if file.file().metadata().is_ok_and(|meta| meta.len() == 0) {
                    // The file was created above.
                    let _ = disk::remove_file(&path);
                }
                return Err(error);
            }
        };
        Ok(PartialFile {
            output: output.to_path_buf(),
            path,
            writer: BufWriter::with_capacity(BUFFER_BYTES, file),
            keep: journal.is_some(),
            journal_path,
            journal,
            is_locked,
            sync_error: None,
            is_committed: false,
            modified: None,
        })
    }

    /// Calls `check` with the journal's bytes and the file. Returns `None` if there is no journal. Neither file is changed.
    pub fn recover<T>(&mut self, check: impl FnOnce(&[u8], &mut dyn Read) -> Result<Option<T>>) -> Result<Option<T>> {
        let Some(journal) = &mut self.journal else { return Ok(None) };
        let io = |error| Error::io(&self.path, error);
        let mut records = Vec::new();
        journal.seek(SeekFrom::Start(0)).and_then(|_| journal.read_to_end(&mut records)).map_err(io)?;
        let file = self.writer.get_mut();
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        check(&records, &mut BufReader::new(file)).map_err(|error| error.in_file(&self.path))
    }

    /// Truncates file and journal to their intact bytes, or to 0; later writes append. Returns the journal for appending.
    pub fn resume(&mut self, intact: Option<IntactBytes>) -> Result<DiskFile> {
        let io = |error| Error::io(&self.output, error);
        let bytes = intact.unwrap_or_default();
        truncate(self.writer.get_mut(), bytes.file).map_err(io)?;
        let busy = || Error::busy(&self.journal_path, "another process is using it");
        let mut journal = match self.journal.take() {
            Some(journal) => journal,
            None => open_locked(&self.journal_path).map_err(io)?.ok_or_else(busy)?.file,
        };
        let done = truncate(&mut journal, bytes.journal).and_then(|()| journal.try_clone()).map_err(io);
        self.journal = Some(journal);
        if intact.is_none() && done.is_ok() {
            self.keep = false;
        }
        done
    }

    pub fn start_over(&mut self) -> Result<()> {
        truncate(self.writer.get_mut(), 0).map_err(|error| Error::io(&self.output, error))?;
        self.keep = false;
        self.remove_journal();
        Ok(())
    }

    /// Makes drop remove the file and its journal.
    pub fn discard(&mut self) {
        self.keep = false;
    }

    fn remove_journal(&mut self) {
        if self.journal.is_some() {
            // Removed while it is still locked.
            let _ = disk::remove_file(&self.journal_path);
            self.journal = None;
        }
    }

    /// Keeps the file and its journal when this value is dropped, and flushes them to disk. They are kept also if the flush fails.
    pub fn keep(&mut self) -> std::io::Result<()> {
        self.keep = true;
        // Fails on a full disk; chunks that the journal lists were flushed before.
        let _ = self.writer.flush();
        let file = self.sync();
        let journal = self.journal.as_ref().map_or(Ok(()), DiskFile::sync);
        let folder = disk::sync_folder(parent_of(&self.output));
        match &self.sync_error {
            Some(why) => Err(std::io::Error::other(why.clone())),
            None => file.and(journal).and(folder),
        }
    }

    fn sync(&mut self) -> std::io::Result<()> {
        let done = self.writer.get_ref().sync();
        if let Err(error) = &done {
            self.sync_error = Some(error.to_string());
        }
        done
    }

    pub fn commit(&mut self) -> std::io::Result<()> {
        self.writer.flush()?;
        if let Some(time) = self.modified {
            // Some network file systems refuse this. The file then appears newer than it is, but is complete.
            let _ = self.writer.get_ref().file().set_modified(time);
        }
        self.sync()?;
        disk::rename(&self.path, &self.output)?;
        (self.keep, self.is_committed) = (true, true);
        // Before the journal is removed: if the disk loses the rename, the journal belongs to the old name.
        disk::sync_folder(parent_of(&self.output))?;
        self.remove_journal();
        Ok(())
    }
}

fn truncate(file: &mut DiskFile, bytes: u64) -> std::io::Result<()> {
    file.set_len(bytes)?;
    file.seek(SeekFrom::Start(bytes)).map(|_| ())
}

impl Write for PartialFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.writer.flush()
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        // After a panic a file with a journal can still be resumed.
        let panicked = std::thread::panicking() && self.journal.is_some();
        if !self.keep && !panicked {
            let _ = disk::remove_file(&self.path);
            self.remove_journal();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    use tempfile::TempDir;

    const LEFT: [(&str, &[u8]); 2] = [(".a.journal", b"records"), (".a.partial", b"chunks")];

    /// Folder with the files of an unfinished encode of `a`.
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
        // A journal that cannot be read.
        let mut partial = PartialFile::open(&output).unwrap();
        partial.journal = Some(File::options().write(true).open(folder.path().join(".a.journal")).unwrap().into());
        assert!(matches!(partial.recover(|_, _| Ok(Some(()))), Err(Error::Io { .. })));
        drop(partial);
        is_untouched(&folder);
        // A file that cannot be truncated.
        for intact in [Some(IntactBytes::default()), None] {
            let mut partial = PartialFile::open(&output).unwrap();
            partial.writer = BufWriter::new(File::open(folder.path().join(".a.partial")).unwrap().into());
            assert!(matches!(partial.resume(intact), Err(Error::Io { .. })));
            drop(partial);
            is_untouched(&folder);
            let mut partial = PartialFile::open(&output).unwrap();
            partial.writer = BufWriter::new(File::open(folder.path().join(".a.partial")).unwrap().into());
            assert!(matches!(partial.start_over(), Err(Error::Io { .. })));
            drop(partial);
            is_untouched(&folder);
        }
        // A file that was started over is removed.
        let mut partial = PartialFile::open(&output).unwrap();
        partial.resume(None).unwrap();
        drop(partial);
        assert_eq!(count(&folder), 0);
    }

    #[test]
    fn an_error_of_checking_names_the_file_and_leaves_it() {
        let (folder, output) = left();
        let mut partial = PartialFile::open(&output).unwrap();
        let checked = partial.recover(|records, bytes| {
            let mut text = String::new();
            bytes.read_to_string(&mut text).unwrap();
            assert_eq!((records, text.as_str()), (&b"records"[..], "chunks"));
            Err::<Option<()>, _>(Error::Interrupted)
        });
        assert!(matches!(checked, Err(Error::Interrupted)));
        drop(partial);
        is_untouched(&folder);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_disk_that_may_have_lost_something_is_told() {
        let null = || DiskFile::from(File::options().write(true).open("/dev/null").unwrap());
        let (folder, output) = left();
        let mut partial = PartialFile::open(&output).unwrap();
        partial.keep().unwrap();
        // The null device cannot be synced.
        let file = std::mem::replace(&mut partial.writer, BufWriter::new(null()));
        assert!(partial.commit().is_err());
        assert!(!partial.is_committed && !output.exists());
        // The system reports an error of a sync only once.
        partial.writer = file;
        assert!(partial.keep().is_err());
        drop(partial);
        let mut partial = PartialFile::open(&output).unwrap();
        partial.journal = Some(null());
        assert!(partial.keep().is_err());
        drop(partial);
        is_untouched(&folder);
    }

    #[test]
    fn a_journal_that_another_process_has_leaves_no_new_file() {
        let (folder, output) = left();
        std::fs::remove_file(folder.path().join(".a.partial")).unwrap();
        let theirs = open_locked(&folder.path().join(".a.journal")).unwrap();
        assert!(
            matches!(PartialFile::open(&output), Err(Error::Io { source, .. }) if source.kind() == std::io::ErrorKind::ResourceBusy)
        );
        assert_eq!(count(&folder), 1);
        // A file with content is not removed.
        std::fs::write(folder.path().join(".a.partial"), b"chunks").unwrap();
        assert!(PartialFile::open(&output).is_err());
        is_untouched(&folder);
        drop(theirs);
        assert!(PartialFile::open(&output).is_ok());
    }
}
