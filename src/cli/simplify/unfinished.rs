//! File of a scene under construction, and the selected tiles beside it, from which `simplify --resume` continues.

use std::io::{Read, Write};
use std::path::Path;

use super::args::Args;
use crate::{GlobalArgs, output};
use codec::error::{Error, Result};
use codec::memory::Budget;
use footage::files::{IntactBytes, OutputFile};
use footage::fingerprint::{Fingerprint, digest, file_state};
use simplify::capture::Capture;
use simplify::settings::Settings;

/// Returns everything that tiles depend on. Files are identified by size and modification time.
pub fn fingerprint(args: &Args, settings: &Settings, capture: &Capture) -> Fingerprint {
    let input = &args.input;
    let mut fields = Fingerprint::of_program(&[
        codec::SOURCES,
        footage::SOURCES,
        scene::SOURCES,
        render::SOURCES,
        evaluate::SOURCES,
        simplify::SOURCES,
        kernels::SOURCES,
        gpu::SOURCES,
    ]);
    fields.extend(args.options());
    // Settings derived from options and input.
    let settings = Settings { memory: Budget::UNLIMITED, ..settings.clone() };
    fields.push(("the set of options", digest(format!("{settings:?}").as_bytes())));
    fields.push(("the frame", capture.frame().to_string()));
    fields.push(("the list of input images", digest(format!("{:?}", capture.images).as_bytes())));
    let mut files: Vec<_> = capture.files().iter().chain([input]).map(|path| file_state(path)).collect();
    files.sort();
    fields.push(("the list of input files", digest(format!("{files:?}").as_bytes())));
    Fingerprint(fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
}

/// File of an unfinished scene.
pub struct UnfinishedScene<'a> {
    pub file: OutputFile,
    path: &'a Path,
    fingerprint: Fingerprint,
    has_tiles: bool,
}

impl<'a> UnfinishedScene<'a> {
    /// Opens the file. If resuming, returns the serialised tiles that an earlier run left.
    pub fn open(
        args: &'a Args,
        fingerprint: Fingerprint,
        global: &GlobalArgs,
    ) -> Result<(UnfinishedScene<'a>, Option<Vec<u64>>)> {
        let (path, resume) = (args.output.as_path(), args.resume);
        let say = |words: &str| global.note(format_args!("{}: {words}", path.display()));
        let mut file = OutputFile::open(path)?;
        if !file.is_resumable() && resume {
            say("not a regular file, so there is nothing to resume");
        }
        let left = file.recover(|records, _: &mut dyn Read| Ok(Some(records.to_vec())))?;
        let left = left.filter(|records| !records.is_empty());
        let mut unfinished = UnfinishedScene { file, path, fingerprint, has_tiles: false };
        let words = match (left, resume) {
            (Some(records), true) => {
                let words = unfinished.words_of(&records);
                if words.is_err() {
                    unfinished.file.keep().map_err(|error| Error::io(path, error))?;
                }
                let words = words?;
                say(match words {
                    Some(_) => "resuming with the selected tiles",
                    None => "the selected tiles are damaged; starting over",
                });
                words
            }
            (Some(records), false) => {
                let more = match unfinished.words_of(&records) {
                    Ok(Some(_)) => "; --resume would continue it",
                    Ok(None) => "",
                    Err(_) => " with other options",
                };
                say(&format!("replacing an unfinished scene{more}"));
                None
            }
            (None, true) => {
                say("nothing to resume; starting from the beginning");
                None
            }
            (None, false) => None,
        };
        Ok((unfinished, words))
    }

    /// Returns the serialised tiles of an earlier run with the same options. `None` if they are damaged, for example by
    /// a power failure.
    fn words_of(&self, records: &[u8]) -> Result<Option<Vec<u64>>> {
        let Some(end) = records.iter().position(|byte| *byte == b'\n') else { return Ok(None) };
        let (head, body) = (&records[..end], &records[end + 1..]);
        let Ok((fields, expected)) = serde_json::from_slice::<(Vec<(String, String)>, String)>(head) else {
            return Ok(None);
        };
        if let Some(difference) = Fingerprint(fields).difference(&self.fingerprint) {
            return Err(self.cannot(&difference));
        }
        if digest(body) != expected {
            return Ok(None);
        }
        Ok(Some(body.as_chunks::<8>().0.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect()))
    }

    pub fn cannot(&self, why: &str) -> Error {
        Error::Usage(format!(
            "{}: cannot resume the unfinished scene: {why}: use its options, or leave out --resume to start over",
            self.path.display()
        ))
    }

    /// Writes the selected tiles beside the file, for a later process.
    pub fn keep_tiles(&mut self, words: &[u64]) -> Result<()> {
        let body: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let head = serde_json::to_string(&(&self.fingerprint.0, digest(&body)))
            .map_err(|error| Error::invalid(format!("the state of the scene: {error}")))?;
        let mut journal = self.file.resume(None::<IntactBytes>)?;
        let written = journal.write_all(format!("{head}\n").as_bytes()).and_then(|()| journal.write_all(&body));
        written
            .and_then(|()| journal.flush())
            .map_err(|error| output::name_output(Error::io(self.path, error), self.path))?;
        self.has_tiles = self.file.is_resumable();
        Ok(())
    }

    /// Returns the error of a stopped run. After an interrupt or a system error, kept tiles allow a later process to
    /// resume.
    pub fn stopped(&mut self, error: Error) -> Error {
        let may_succeed = matches!(error, Error::Interrupted | Error::Io { .. });
        if may_succeed && self.has_tiles && self.file.is_resumable() { self.kept(error) } else { error }
    }

    fn kept(&mut self, error: Error) -> Error {
        let how = match self.file.keep() {
            Ok(()) => "kept".to_owned(),
            Err(error) => format!("kept, possibly not on disk ({error}),"),
        };
        let safe = format!(
            "the selected tiles are {how} beside {}; {}",
            self.file.work_path().display(),
            output::how_to_resume(&error)
        );
        Error::Unfinished { cause: Box::new(error), safe }
    }
}
