//! Picture folders that are kept when a command stops, and that the same command with `--resume` completes.

use std::path::{Path, PathBuf};

use super::{GlobalArgs, output};
use codec::error::{Error, Result, counted};
use footage::files::{Kept, Left, PartialFolder};
use footage::fingerprint::Fingerprint;

/// An unfinished output folder.
#[derive(Debug)]
pub struct UnfinishedFolder {
    pub folder: PartialFolder,
    /// Path of the output, for messages.
    path: PathBuf,
    /// Name of the work, such as "capture".
    what: &'static str,
}

impl UnfinishedFolder {
    pub fn new(folder: PartialFolder, path: &Path, what: &'static str) -> UnfinishedFolder {
        UnfinishedFolder { folder, path: path.to_path_buf(), what }
    }

    /// Keeps the intact pictures of an earlier run with the same options if it is to be resumed, else discards them.
    /// `all` is the total number of pictures.
    pub fn begin(&mut self, now: &Fingerprint, all: u64, (resume, global): (bool, &GlobalArgs)) -> Result<()> {
        let what = self.what;
        let say = |words: &str| global.note(format_args!("{}: {words}", self.path.display()));
        if !self.folder.is_locked() {
            say(&format!(
                "the file system does not support locks: do not run two commands that {what} into this \
                folder at the same time"
            ));
        }
        let Left { words: left, files: images } = self.folder.left()?;
        if resume && images > 0 {
            let begun: Vec<(String, String)> =
                serde_json::from_str(&left).map_err(|_| self.cannot("its state is damaged"))?;
            if let Some(difference) = Fingerprint(begun).difference(now) {
                return Err(self.cannot(&difference));
            }
            let Kept { intact, damaged } = self.folder.resume()?;
            let again = match damaged {
                0 => String::new(),
                1 => "; 1 damaged image is rewritten".to_owned(),
                many => format!("; {many} damaged images are rewritten"),
            };
            say(&format!("resuming with {intact} of {all} images{again}"));
            return Ok(());
        }
        if resume {
            say("nothing to resume; starting from the beginning");
        } else if images > 0 {
            let begun: Vec<(String, String)> = serde_json::from_str(&left).unwrap_or_default();
            let is_same = Fingerprint(begun).difference(now).is_none();
            let more = if is_same { "; --resume would continue it" } else { " with other options" };
            say(&format!("replacing an unfinished {what} of {}{more}", counted(images, "image")));
        }
        let state = serde_json::to_string(&now.0)
            .map_err(|error| Error::invalid(format!("the state of the {what}: {error}")))?;
        self.folder.start_over(&state)
    }

    fn cannot(&self, difference: &str) -> Error {
        Error::Usage(format!(
            "{}: cannot resume the unfinished {}: {difference}: use its options, or leave out --resume to start over",
            self.path.display(),
            self.what
        ))
    }

    /// Returns the error of a stopped run. Keeps the pictures, if there are any.
    pub fn stopped(&mut self, error: Error, all: u64) -> Error {
        let (error, images) = (self.folder.present(error), self.folder.keep());
        if images == 0 {
            return error;
        }
        let safe = format!(
            "{images} of {all} images are kept in {}; {}",
            self.folder.work_path().display(),
            output::how_to_resume(&error)
        );
        Error::Unfinished { cause: Box::new(error), safe }
    }
}
