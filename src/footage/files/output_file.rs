//! Output files: a locked partial file, a pipe, a device, or standard output.

use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::disk::DiskFile;
use super::partial_file::{IntactBytes, PartialFile};
use super::standard_output::standard_output;
use codec::error::{Error, Result};

enum Sink {
    Partial(PartialFile),
    Direct(Box<dyn Write + Send>),
}

/// An output file that gets its name when it is complete; `-` is standard output. Until then its bytes are in a locked file
/// beside the output.
pub struct OutputFile {
    path: PathBuf,
    sink: Sink,
}

impl OutputFile {
    /// Starts a file. An existing file stays until [`Self::commit`]; an unfinished one is emptied.
    pub fn create(path: &Path) -> Result<OutputFile> {
        let mut file = Self::open(path)?;
        if let Sink::Partial(partial) = &mut file.sink {
            partial.start_over()?;
        }
        Ok(file)
    }

    /// Opens an unfinished file and keeps its content; call [`Self::resume`] before writing.
    pub fn open(path: &Path) -> Result<OutputFile> {
        let io = |error| Error::io(path, error);
        let sink = if path == Path::new("-") {
            Sink::Direct(Box::new(BufWriter::new(standard_output()?)))
        } else if std::fs::metadata(path).is_ok_and(|meta| !meta.is_file()) {
            if path.is_dir() {
                return Err(Error::Usage(format!("{}: a folder, where a file name was expected", path.display())));
            }
            Sink::Direct(Box::new(BufWriter::new(DiskFile::device(path).map_err(io)?)))
        } else {
            Sink::Partial(PartialFile::open(path)?)
        };
        Ok(OutputFile { path: path.to_path_buf(), sink })
    }

    /// True if a later process could resume the file; false for pipes and devices, and after [`Self::commit`].
    pub fn is_resumable(&self) -> bool {
        matches!(&self.sink, Sink::Partial(partial) if !partial.is_committed)
    }

    pub fn is_locked(&self) -> bool {
        matches!(&self.sink, Sink::Partial(partial) if partial.is_locked)
    }

    /// Path of the bytes until [`Self::commit`].
    pub fn work_path(&self) -> &Path {
        match &self.sink {
            Sink::Partial(partial) => &partial.path,
            Sink::Direct(_) => &self.path,
        }
    }

    /// Calls `check` with the journal's bytes and the unfinished file, to find the intact chunks. Returns `None` if there is
    /// no journal.
    pub fn recover<T>(&mut self, check: impl FnOnce(&[u8], &mut dyn Read) -> Result<Option<T>>) -> Result<Option<T>> {
        match &mut self.sink {
            Sink::Partial(partial) => partial.recover(check),
            Sink::Direct(_) => Ok(None),
        }
    }

    /// Truncates the file to its intact bytes. Returns the writer of the journal.
    pub fn resume(&mut self, intact: Option<IntactBytes>) -> Result<Box<dyn Write + Send>> {
        match &mut self.sink {
            Sink::Partial(partial) => Ok(Box::new(partial.resume(intact)?)),
            Sink::Direct(_) => Ok(Box::new(std::io::sink())),
        }
    }

    /// Keeps the unfinished file at [`Self::work_path`]. An error means that bytes may not have reached the disk; the file is
    /// kept nevertheless.
    pub fn keep(&mut self) -> std::io::Result<()> {
        match &mut self.sink {
            Sink::Partial(partial) => partial.keep(),
            Sink::Direct(_) => Ok(()),
        }
    }

    pub fn discard(&mut self) {
        if let Sink::Partial(partial) = &mut self.sink {
            partial.discard();
        }
    }

    /// As [`Self::commit`], and sets the modification time to `time`, which a later run may compare with the times of its
    /// sources. Times of pipes and devices are not changed.
    pub fn commit_as_of(&mut self, time: SystemTime) -> Result<()> {
        if let Sink::Partial(partial) = &mut self.sink {
            partial.modified = Some(time);
        }
        self.commit()
    }

    /// Syncs the file and renames it to the output. After an error the file can still be kept.
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

/// Writes a complete file: an [`OutputFile`] with these bytes.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut file = OutputFile::create(path)?;
    file.write_all(bytes).map_err(|error| Error::io(path, error))?;
    file.commit()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn replaces_files_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("page");
        for text in ["first", "2nd"] {
            write_whole(&path, text.as_bytes()).unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
        let missing = write_whole(&folder.path().join("none/page"), b"").unwrap_err().to_string();
        assert!(missing.contains("page") && !missing.contains("partial"), "{missing}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

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
        let before = SystemTime::now() - Duration::from_secs(9);
        let mut file = OutputFile::create(&path).unwrap();
        file.write_all(b"later").unwrap();
        file.commit_as_of(before).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().modified().unwrap(), before);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
