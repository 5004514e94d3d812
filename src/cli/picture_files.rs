//! Files of pictures that appear together: a pattern with a field for a number, and `%V` for a word, such as an eye or a view.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::GlobalArgs;
use super::unfinished_folder::UnfinishedFolder;
use crate::decode::FileFormat;
use crate::error::{Error, Result};
use crate::evaluate::rendered_image::{HoleFill, RenderedImage};
use crate::files::{FileFolder, FolderKind, OutputFolder, PartialFolder};
use crate::fingerprint::Fingerprint;
use crate::image::sequence::Pattern;
use crate::image::transfer::ToneMap;
use crate::image::{exr, png};

/// Stands for the word.
pub const WORD_FIELD: &str = "%V";

#[derive(Debug)]
pub struct PictureFiles {
    /// What lies below the folder: a pattern, in further folders where the word is in their names.
    text: String,
    pub format: FileFormat,
    root: PathBuf,
    work: Work,
}

#[derive(Debug)]
enum Work {
    /// Removed where the command stops.
    Whole(OutputFolder),
    /// Kept.
    Unfinished(UnfinishedFolder),
}

const UNFINISHED: FolderKind = FolderKind { suffix: ".views.partial", state: ".views.json" };

/// How pictures become codes or light.
#[derive(Debug, Clone, Copy)]
pub struct PictureCoding {
    pub tone: ToneMap,
    pub holes: HoleFill,
}

impl PictureFiles {
    /// The files of a pattern, whose format follows from its ending.
    pub fn create(path: &Path, format: FileFormat) -> Result<PictureFiles> {
        let (root, text) = root_and_text(path);
        Ok(PictureFiles { text, format, work: Work::Whole(OutputFolder::create(here(&root))?), root })
    }

    /// Files that are kept where the command stops, so that a later one resumes. Processes may each write a part of them, by its name.
    pub fn resumable(path: &Path, format: FileFormat, part: &str) -> Result<PictureFiles> {
        let (root, text) = root_and_text(path);
        let folder = PartialFolder::open_part(here(&root), UNFINISHED, part)?;
        let work = Work::Unfinished(UnfinishedFolder::new(folder, path, "sequence"));
        Ok(PictureFiles { text, format, work, root })
    }

    /// Begins resumable files: as [`UnfinishedFolder::begin`].
    pub fn begin(&mut self, now: &Fingerprint, all: u64, (resume, global): (bool, &GlobalArgs)) -> Result<()> {
        match &mut self.work {
            Work::Whole(_) => Ok(()),
            Work::Unfinished(unfinished) => unfinished.begin(now, all, (resume, global)),
        }
    }

    fn folder(&self) -> &dyn FileFolder {
        match &self.work {
            Work::Whole(folder) => folder,
            Work::Unfinished(unfinished) => &unfinished.folder,
        }
    }

    /// Whether an earlier run made a file.
    pub fn has(&self, word: &str, number: u32) -> Result<bool> {
        Ok(self.folder().made(&self.below(word, number)?).is_some())
    }

    /// The error that stopped a command.
    pub fn stopped(&mut self, error: Error, all: u64) -> Error {
        match &mut self.work {
            Work::Whole(_) => error,
            Work::Unfinished(unfinished) => unfinished.stopped(error, all),
        }
    }

    /// PNG files in a folder, by word and number.
    pub fn in_folder(folder: &Path) -> Result<PictureFiles> {
        let text = format!("{WORD_FIELD}.%04d.png");
        let root = folder.to_path_buf();
        Ok(PictureFiles { text, format: FileFormat::Png, work: Work::Whole(OutputFolder::create(folder)?), root })
    }

    /// Whether the word stands in the names.
    pub fn has_word(&self) -> bool {
        has_word(Path::new(&self.text))
    }

    /// A file below the folder.
    fn below(&self, word: &str, number: u32) -> Result<PathBuf> {
        Ok(Pattern::parse(&self.text.replace(WORD_FIELD, word))?.path(number))
    }

    /// A file, as a path from here.
    pub fn path(&self, word: &str, number: u32) -> Result<PathBuf> {
        Ok(self.root.join(self.below(word, number)?))
    }

    /// Their pattern, as a path from here.
    pub fn pattern(&self) -> PathBuf {
        self.root.join(&self.text)
    }

    /// Writes a picture. Answers its bytes.
    pub fn write(&self, (word, number): (&str, u32), picture: &RenderedImage, coding: PictureCoding) -> Result<u64> {
        self.write_by(word, number, &mut |path: &Path| match self.format {
            FileFormat::Png => png::write_rgba8(path, &picture.rgba_codes(coding.tone)),
            FileFormat::Exr => {
                let aovs = picture.aovs.iter().map(|aov| (aov.channel, &aov.plane));
                exr::write_rgba_and(path, &picture.rgba_light(coding.holes), aovs, picture.primaries)
            }
        })
    }

    /// Writes a file by its path until [`Self::commit`]. Answers its bytes.
    pub fn write_by(&self, word: &str, number: u32, write: &mut dyn FnMut(&Path) -> Result<()>) -> Result<u64> {
        self.folder().write_file(&self.below(word, number)?, write)
    }

    pub fn commit(self) -> Result<()> {
        match self.work {
            Work::Whole(folder) => folder.commit(),
            Work::Unfinished(mut unfinished) => unfinished.folder.commit(None),
        }
    }
}

/// The folder in which everything appears at once, and the pattern below it: a folder with the word in its name lies below.
fn root_and_text(path: &Path) -> (PathBuf, String) {
    let parts: Vec<&OsStr> = path.iter().collect();
    let fixed = parts.iter().position(|part| has_word(Path::new(part))).unwrap_or(parts.len());
    let (above, below) = parts.split_at(fixed.min(parts.len().saturating_sub(1)));
    (above.iter().collect(), below.iter().collect::<PathBuf>().to_string_lossy().into_owned())
}

fn here(root: &Path) -> &Path {
    if root.as_os_str().is_empty() { Path::new(".") } else { root }
}

/// Whether a path has a place for the word.
pub fn has_word(path: &Path) -> bool {
    path.to_string_lossy().contains(WORD_FIELD)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_may_be_in_folders_and_everything_appears_at_once() {
        let base = tempfile::tempdir().unwrap();
        let picture = RenderedImage::of_pixels([1, 1], std::iter::once([1.0; 4])).unwrap();
        let coding = PictureCoding { tone: ToneMap::default(), holes: HoleFill::Blank };
        let files = PictureFiles::create(&base.path().join("out/%V/v.%03d.png"), FileFormat::Png).unwrap();
        assert!(files.has_word());
        let expected = base.path().join("out/left/v.007.png");
        assert_eq!(files.path("left", 7).unwrap(), expected);
        assert!(files.write(("left", 7), &picture, coding).unwrap() > 0);
        assert!(!expected.exists());
        files.commit().unwrap();
        assert!(expected.exists());
        let plain = PictureFiles::in_folder(&base.path().join("all")).unwrap();
        assert_eq!(plain.path("view", 12).unwrap(), base.path().join("all/view.0012.png"));
    }
}
