//! An output folder whose files are collected in a folder beside it, from which a later process can resume.
//!
//! A file counts as made once the state file has its record: name, length and CRC-32, one line per file, after a first line
//! that describes the work. The order is fixed: the file's bytes and directory entry reach the disk before its record, and
//! all records before the folder is renamed. Files that are written within a second are recorded together, because each
//! record waits for the disk three times. A later process reads every recorded file again, and remakes files that differ from
//! their record.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::{Deserialize, Serialize};

use super::disk::{self, DiskFile};
use super::file_folder::FileFolder;
use super::lock::{Locked, open_locked};
use super::names::{check_name, hidden_beside, parent_of};
use super::output_folder::{MadeFolders, name_final_path, rename_or_move_into};
use codec::error::{Error, Result};

/// Names in and around an unfinished folder.
#[derive(Debug, Clone, Copy)]
pub struct FolderKind {
    /// Suffix of the folder's name, after a dot and the name of the output.
    pub suffix: &'static str,
    /// Name of the locked state file in the folder, with the description of the work and the records.
    pub state: &'static str,
}

/// Subfolder that becomes the output.
const FILES: &str = "files";
/// Minimum time between records; a killed process loses the files after the last record.
const PAUSE: Duration = Duration::from_secs(1);

/// Record of a finished file, a line of the state file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Record {
    file: PathBuf,
    bytes: u64,
    crc32: u32,
}

/// State of an earlier process.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Left {
    /// The words that the process passed to [`PartialFolder::start_over`].
    pub words: String,
    /// Number of recorded files, intact or not; without records, number of existing files.
    pub files: u64,
}

/// Number of recorded files of an earlier process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kept {
    pub intact: u64,
    pub damaged: u64,
}

/// An unfinished folder that this process has locked. Dropping it removes the folder, unless it was committed, kept, or left
/// by an earlier process.
#[derive(Debug)]
pub struct PartialFolder {
    kind: FolderKind,
    output: PathBuf,
    path: PathBuf,
    files: PathBuf,
    progress: Mutex<Progress>,
    is_locked: bool,
    keep: bool,
    /// Dropped after the unfinished folder inside it is removed.
    _made: MadeFolders,
}

#[derive(Debug)]
struct Progress {
    state: DiskFile,
    recorded: BTreeMap<PathBuf, Record>,
    /// Files that are written but not recorded yet.
    pending: Vec<Record>,
    /// Time when records were last written, or when writing them began.
    last: Option<Instant>,
}

impl PartialFolder {
    /// Opens the unfinished folder of an output and keeps its content; a new folder is empty. Creates missing parents.
    pub fn open(output: &Path, kind: FolderKind) -> Result<PartialFolder> {
        PartialFolder::open_part(output, kind, "")
    }

    /// As [`Self::open`], for an output that several processes write in parts; `part` is the name of this process's part.
    pub fn open_part(output: &Path, kind: FolderKind, part: &str) -> Result<PartialFolder> {
        let io = |error| Error::io(output, error);
        check_name(output)?;
        if std::fs::metadata(output).is_ok_and(|meta| !meta.is_dir()) {
            return Err(Error::Usage(format!("{}: a file, where a folder was expected", output.display())));
        }
        if output.is_symlink() && !output.exists() {
            return Err(Error::Usage(format!(
                "{}: a dangling link, where a folder was expected: remove it, or create its target",
                output.display()
            )));
        }
        let path = path_for(output, &format!("{part}{}", kind.suffix))?;
        if path.symlink_metadata().is_ok_and(|meta| !meta.is_dir()) {
            return Err(Error::Usage(format!(
                "{}: this is not a folder, and a folder is created there: remove it",
                path.display()
            )));
        }
        let made = MadeFolders::create(parent_of(&path)).map_err(io)?;
        let files = path.join(FILES);
        disk::create_folders(&files).map_err(io)?;
        let Some(Locked { file: state, is_locked }) = open_locked(&path.join(kind.state)).map_err(io)? else {
            let place = path.display();
            let message =
                format!("another lightfold process is writing it, in {place}: wait for it, or use another folder");
            return Err(Error::busy(output, message));
        };
        // Files without a state may be all that survived on a damaged disk.
        let keep = state.file().metadata().is_ok_and(|meta| meta.len() > 0) || count_files(&files) > 0;
        let progress = Mutex::new(Progress { state, recorded: BTreeMap::new(), pending: Vec::new(), last: None });
        Ok(PartialFolder { kind, output: output.to_path_buf(), path, files, progress, is_locked, keep, _made: made })
    }

    /// False if the file system has no locks.
    pub fn is_locked(&self) -> bool {
        self.is_locked
    }

    /// Path of the unfinished folder.
    pub fn work_path(&self) -> &Path {
        &self.path
    }

    fn progress(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn state_error(&self, error: std::io::Error) -> Error {
        Error::io(self.path.join(self.kind.state), error)
    }

    /// Returns the words of an earlier process and its number of files; empty for a new folder.
    pub fn left(&self) -> Result<Left> {
        let (words, records, _) = self.read_state()?;
        let files = if records.is_empty() { count_files(&self.files) } else { records.len() as u64 };
        Ok(Left { words, files })
    }

    /// Returns words, records, and the number of bytes up to the last complete record: after a power failure, a line may be
    /// cut off or overwritten.
    fn read_state(&self) -> Result<(String, BTreeMap<PathBuf, Record>, u64)> {
        let mut bytes = Vec::new();
        let state = &mut self.progress().state;
        state
            .seek(SeekFrom::Start(0))
            .and_then(|_| state.read_to_end(&mut bytes))
            .map_err(|error| self.state_error(error))?;
        let mut lines = bytes.split_inclusive(|byte| *byte == b'\n');
        let first = lines.next().unwrap_or_default();
        let (mut whole, mut records) = (first.len() as u64, BTreeMap::new());
        for line in lines {
            let record = serde_json::from_slice::<Record>(line).ok().filter(|_| line.ends_with(b"\n"));
            let Some(record) = record else { break };
            whole += line.len() as u64;
            // The later record of a file that was made again replaces the earlier one.
            records.insert(record.file.clone(), record);
        }
        Ok((String::from_utf8_lossy(first).trim_end().to_owned(), records, whole))
    }

    /// Reads the recorded files of an earlier process again, and continues with the intact ones.
    pub fn resume(&mut self) -> Result<Kept> {
        self.keep = true;
        let (_, records, whole) = self.read_state()?;
        let checked: Vec<(&Record, bool)> =
            records.values().collect::<Vec<_>>().par_iter().map(|record| (*record, self.is_intact(record))).collect();
        let intact = |record: &&(&Record, bool)| record.1;
        let recorded = checked.iter().filter(intact).map(|(record, _)| (record.file.clone(), (*record).clone()));
        let recorded: BTreeMap<PathBuf, Record> = recorded.collect();
        let kept = Kept { intact: recorded.len() as u64, damaged: (records.len() - recorded.len()) as u64 };
        let mut progress = self.progress();
        let state = &mut progress.state;
        let cut = state.set_len(whole).and_then(|()| state.seek(SeekFrom::Start(whole)));
        cut.map_err(|error| self.state_error(error))?;
        progress.recorded = recorded;
        drop(progress);
        Ok(kept)
    }

    fn is_intact(&self, record: &Record) -> bool {
        self.record_of(&record.file).is_ok_and(|found| found == *record)
    }

    /// Reads a file and returns its length and CRC-32.
    fn record_of(&self, file: &Path) -> std::io::Result<Record> {
        let mut opened = std::fs::File::open(self.files.join(file))?;
        let (mut hasher, mut bytes, mut buffer) = (crc32fast::Hasher::new(), 0, vec![0; 1 << 16]);
        loop {
            match opened.read(&mut buffer)? {
                0 => break,
                count => {
                    hasher.update(&buffer[..count]);
                    bytes += count as u64;
                }
            }
        }
        Ok(Record { file: file.to_path_buf(), bytes, crc32: hasher.finalize() })
    }

    /// Removes all files and writes the state of new work; `words` is one line.
    pub fn start_over(&mut self, words: &str) -> Result<()> {
        self.keep = false;
        let io = |error| Error::io(&self.path, error);
        let mut progress = self.progress();
        (progress.recorded, progress.pending) = (BTreeMap::new(), Vec::new());
        // Files are removed before their records, so that none is ever found without a state.
        for entry in std::fs::read_dir(&self.path).map_err(io)? {
            let path = entry.map_err(io)?.path();
            if path.file_name() != Some(self.kind.state.as_ref()) {
                let is_folder = path.symlink_metadata().is_ok_and(|meta| meta.is_dir());
                if is_folder { disk::remove_tree(&path) } else { disk::remove_file(&path) }.map_err(io)?;
            }
        }
        disk::sync_folder(&self.path).and_then(|()| disk::create_folders(&self.files)).map_err(io)?;
        let (state, line) = (&mut progress.state, words.replace(['\n', '\r'], " ") + "\n");
        let emptied = state.set_len(0).and_then(|()| state.seek(SeekFrom::Start(0)));
        emptied.and_then(|_| state.write_all(line.as_bytes())).and_then(|()| state.sync()).map_err(io)
    }

    /// Writes a file, and records the written files if that is due.
    fn put(&self, file: &Path, write: &mut dyn FnMut(&Path) -> Result<()>) -> Result<u64> {
        let path = self.files.join(file);
        let mut written = || {
            let io = |error| Error::io(&path, error);
            disk::create_folders(parent_of(&path)).map_err(io)?;
            write(&path)?;
            let record = self.record_of(file).map_err(io)?;
            let bytes = record.bytes;
            let mut progress = self.progress();
            progress.recorded.remove(file);
            progress.pending.push(record);
            let is_due = progress.last.is_none_or(|last| last.elapsed() >= PAUSE);
            drop(progress);
            if is_due {
                self.record().map_err(io)?;
            }
            Ok(bytes)
        };
        written().map_err(|error| {
            // On a full disk the records of other files need the space.
            let _ = disk::remove_file(&path);
            self.progress().pending.retain(|record| record.file.as_path() != file);
            self.present(error)
        })
    }

    /// Records the written files. Files are synced without the lock: a thread of the pool that waits for a sync may start
    /// another job, which takes the lock for its own file.
    fn record(&self) -> std::io::Result<()> {
        let mut progress = self.progress();
        let written = std::mem::take(&mut progress.pending);
        progress.last = Some(Instant::now());
        drop(progress);
        let done = self.sync_and_append(&written);
        let mut progress = self.progress();
        match done {
            Ok(()) => progress.recorded.extend(written.into_iter().map(|record| (record.file.clone(), record))),
            Err(_) => progress.pending.extend(written),
        }
        progress.last = Some(Instant::now());
        done
    }

    /// Syncs files, then appends and syncs their records.
    fn sync_and_append(&self, written: &[Record]) -> std::io::Result<()> {
        let mut folders: Vec<PathBuf> =
            written.iter().map(|record| parent_of(&self.files.join(&record.file)).to_path_buf()).collect();
        folders.sort();
        folders.dedup();
        written.par_iter().try_for_each(|record| disk::sync_file(&self.files.join(&record.file)))?;
        folders.iter().try_for_each(|folder| disk::sync_folder(folder))?;
        let mut lines = Vec::new();
        for record in written {
            serde_json::to_writer(&mut lines, record)?;
            lines.push(b'\n');
        }
        let mut progress = self.progress();
        let state = &mut progress.state;
        let end = state.stream_position()?;
        let appended = state.write_all(&lines).and_then(|()| state.sync());
        if appended.is_err() {
            // An incomplete line would hide all lines after it.
            let _ = state.set_len(end).and_then(|()| state.seek(SeekFrom::Start(end)));
        }
        appended
    }

    /// Makes drop keep the folder if it has recorded files. Returns their number.
    pub fn keep(&mut self) -> u64 {
        let has_pending = !self.progress().pending.is_empty();
        if has_pending && self.record().is_err() {
            // These files will be made again.
            self.progress().pending.clear();
        }
        let files = self.progress().recorded.len() as u64;
        self.keep |= files > 0;
        files
    }

    pub fn present(&self, error: Error) -> Error {
        name_final_path(error, &self.files, &self.output)
    }

    /// Writes `description`, a file that describes the others, moves all files to the output, and replaces files of the same
    /// names in it. Files without a record are removed. After an error a later process can resume.
    pub fn commit(&mut self, description: Option<(&str, &[u8])>) -> Result<()> {
        let output = &self.output;
        let io = |error| Error::io(output, error);
        self.keep = true;
        self.record().map_err(io)?;
        remove_others(&self.files, Path::new(""), &self.progress().recorded).map_err(io)?;
        if let Some((name, bytes)) = description {
            let path = self.files.join(name);
            DiskFile::create(&path).and_then(|mut file| file.write_all(bytes)).map_err(io)?;
        }
        disk::sync_tree(&self.files).and_then(|()| rename_or_move_into(&self.files, output)).map_err(io)?;
        // The remaining folder has no file of the output.
        let _ = disk::remove_tree(&self.path);
        Ok(())
    }
}

/// Path of the unfinished folder: beside the output, or inside an existing output, which may be a mount point or a link,
/// unless one exists beside it.
fn path_for(output: &Path, suffix: &str) -> Result<PathBuf> {
    match hidden_beside(output, suffix) {
        Some(beside) if beside.exists() || !output.exists() => Ok(beside),
        _ if output.is_dir() => Ok(output.join(suffix)),
        _ => Err(Error::Usage(format!("{}: this is not a folder name", output.display()))),
    }
}

fn count_files(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_folder = |entry: &std::fs::DirEntry| entry.file_type().is_ok_and(|kind| kind.is_dir());
    entries.map(|entry| if is_folder(&entry) { count_files(&entry.path()) } else { 1 }).sum()
}

/// Removes files without a record; folders stay.
fn remove_others(folder: &Path, below: &Path, recorded: &BTreeMap<PathBuf, Record>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let below = below.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            remove_others(&entry.path(), &below, recorded)?;
        } else if !recorded.contains_key(&below) {
            disk::remove_file(&entry.path())?;
        }
    }
    Ok(())
}

impl FileFolder for PartialFolder {
    fn made(&self, file: &Path) -> Option<PathBuf> {
        self.progress().recorded.contains_key(file).then(|| self.files.join(file))
    }

    fn write_file(&self, file: &Path, write: &mut dyn FnMut(&Path) -> Result<()>) -> Result<u64> {
        self.put(file, write)
    }
}

impl Drop for PartialFolder {
    fn drop(&mut self) {
        if !self.keep && !std::thread::panicking() {
            let _ = disk::remove_tree(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATE: &str = ".capture.json";
    const CAPTURE: FolderKind = FolderKind { suffix: ".capture.partial", state: STATE };

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn put(folder: &PartialFolder, file: &str, text: &str) {
        let mut write = |path: &Path| std::fs::write(path, text).map_err(|error| Error::io(path, error));
        assert_eq!(folder.write_file(Path::new(file), &mut write).unwrap(), text.len() as u64);
    }

    #[test]
    fn resumes_what_was_kept_and_removes_what_was_not() {
        let base = tempfile::tempdir().unwrap();
        let output = base.path().join("deep/cap");
        let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
        assert_eq!(folder.left().unwrap(), Left { words: String::new(), files: 0 });
        folder.start_over("of a").unwrap();
        put(&folder, "sub/one.exr", "1");
        let second = PartialFolder::open(&output, CAPTURE);
        assert!(matches!(second, Err(Error::Io { .. })), "there are two of them");
        assert_eq!(folder.keep(), 1);
        drop(folder);
        let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
        assert_eq!(folder.left().unwrap(), Left { words: "of a".to_owned(), files: 1 });
        assert_eq!(folder.resume().unwrap(), Kept { intact: 1, damaged: 0 });
        drop(folder);
        assert_eq!(names(&base.path().join("deep")), [".cap.capture.partial"], "it was not ours to remove");
        let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
        folder.start_over("of b").unwrap();
        drop(folder);
        assert_eq!(names(&base.path().join("deep")), [""; 0]);
    }

    #[test]
    fn makes_damaged_files_again() {
        let base = tempfile::tempdir().unwrap();
        let output = base.path().join("cap");
        let files = ["whole", "empty", "halved", "blank", "gone", "longer", "unrecorded"];
        let text = "pixels of a picture";
        let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
        folder.start_over("words").unwrap();
        files[..6].iter().for_each(|file| put(&folder, file, text));
        folder.keep();
        let at = folder.files.clone();
        drop(folder);
        for (file, damaged) in [
            ("empty", String::new()),
            ("halved", text[..9].to_owned()),
            ("blank", "\0".repeat(text.len())),
            ("longer", format!("{text}.")),
            ("unrecorded", text.to_owned()),
        ] {
            std::fs::write(at.join(file), damaged).unwrap();
        }
        std::fs::remove_file(at.join("gone")).unwrap();
        let state = at.with_file_name(STATE);
        let whole = std::fs::read(&state).unwrap();
        // The last record may be incomplete on disk.
        for torn in ["", "{\"file\":\"unreco", "\0\0\0\0"] {
            std::fs::write(&state, [&whole, torn.as_bytes()].concat()).unwrap();
            let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
            assert_eq!(folder.left().unwrap(), Left { words: "words".to_owned(), files: 6 });
            assert_eq!(folder.resume().unwrap(), Kept { intact: 1, damaged: 5 });
            assert!(
                folder.made(Path::new("whole")).is_some()
                    && files[1..].iter().all(|file| folder.made(Path::new(file)).is_none())
            );
        }
        let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
        folder.resume().unwrap();
        files[1..6].iter().for_each(|file| put(&folder, file, text));
        folder.commit(Some(("lightfield.json", b"{}"))).unwrap();
        assert_eq!(names(&output), ["blank", "empty", "gone", "halved", "lightfield.json", "longer", "whole"]);
        assert!(files[..6].iter().all(|file| std::fs::read_to_string(output.join(file)).unwrap() == text));
        assert_eq!(names(base.path()), ["cap"]);
    }

    #[test]
    fn everything_moves_to_the_output_also_where_there_is_one() {
        let base = tempfile::tempdir().unwrap();
        let output = base.path().join("cap");
        for round in ["0", "1"] {
            let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
            folder.start_over("of it").unwrap();
            ["a.exr", "sub/b.exr"].iter().for_each(|file| put(&folder, file, round));
            std::fs::write(folder.files.join("sub/b.exr.partial"), round).unwrap();
            folder.commit(None).unwrap();
            drop(folder);
            assert_eq!(names(&output), ["a.exr", "sub"]);
            assert_eq!(names(&output.join("sub")), ["b.exr"]);
            assert_eq!(std::fs::read(output.join("sub/b.exr")).unwrap(), round.as_bytes());
            assert_eq!(names(base.path()), ["cap"]);
        }
    }

    #[test]
    fn images_without_a_state_are_not_removed() {
        let base = tempfile::tempdir().unwrap();
        let left = base.path().join(".cap.capture.partial");
        std::fs::create_dir_all(left.join(FILES)).unwrap();
        std::fs::write(left.join(FILES).join("a.exr"), "1").unwrap();
        std::fs::write(left.join(STATE), "").unwrap();
        let folder = PartialFolder::open(&base.path().join("cap"), CAPTURE).unwrap();
        assert_eq!(folder.left().unwrap(), Left { words: String::new(), files: 1 });
        drop(folder);
        assert_eq!(names(&left.join(FILES)), ["a.exr"]);
    }

    #[test]
    #[cfg(unix)]
    fn a_link_that_leads_nowhere_is_refused() {
        let base = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink(base.path().join("gone"), base.path().join("cap")).unwrap();
        let said = PartialFolder::open(&base.path().join("cap"), CAPTURE).unwrap_err().to_string();
        assert!(said.contains("a dangling link"), "{said}");
        assert_eq!(names(base.path()), ["cap"]);
    }

    #[test]
    fn parents_that_were_made_for_nothing_are_removed() {
        let base = tempfile::tempdir().unwrap();
        drop(PartialFolder::open(&base.path().join("new/deep/cap"), CAPTURE).unwrap());
        assert_eq!(names(base.path()), [""; 0]);
    }

    #[test]
    fn what_lies_in_the_way_is_left_alone() {
        let base = tempfile::tempdir().unwrap();
        std::fs::write(base.path().join("cap"), "theirs").unwrap();
        assert!(PartialFolder::open(&base.path().join("cap"), CAPTURE).is_err());
        std::fs::write(base.path().join(".other.capture.partial"), "theirs").unwrap();
        let said = PartialFolder::open(&base.path().join("other"), CAPTURE).unwrap_err().to_string();
        assert!(said.contains("not a folder, and a folder is created there"), "{said}");
        assert_eq!(names(base.path()), [".other.capture.partial", "cap"]);
        assert!(PartialFolder::open(&base.path().join("none/.."), CAPTURE).is_err());
    }
}
