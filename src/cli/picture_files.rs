//! Picture files that are moved into place together. The pattern has a field for a number, and `%V` for a word such as
//! an eye or a view.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::GlobalArgs;
use super::look::Look;
use super::unfinished_folder::UnfinishedFolder;
use codec::error::{Error, Result};
use codec::image::sequence::Pattern;
use footage::export::FileFormat;
use footage::files::{FileFolder, FolderKind, OutputFolder, PartialFolder};
use footage::fingerprint::Fingerprint;
use footage::image_files::{exr, png};
use render::rendered_image::{HoleFill, RenderedImage};

/// Placeholder of the word.
pub const WORD_FIELD: &str = "%V";

#[derive(Debug)]
pub struct PictureFiles {
    /// Pattern below the folder. It contains subfolders if their names contain the word.
    text: String,
    pub format: FileFormat,
    root: PathBuf,
    work: Work,
}

#[derive(Debug)]
enum Work {
    /// Folder that is removed if the command stops.
    Whole(OutputFolder),
    /// Folder that is kept if the command stops.
    Unfinished(UnfinishedFolder),
}

const UNFINISHED: FolderKind = FolderKind { suffix: ".views.partial", state: ".views.json" };

/// Conversion of pictures to codes or linear RGB.
#[derive(Debug, Clone)]
pub struct PictureCoding {
    pub look: Look,
    pub holes: HoleFill,
}

impl PictureFiles {
    /// Creates the files of a pattern. The extension determines the format.
    pub fn create(path: &Path, format: FileFormat) -> Result<PictureFiles> {
        let (root, text) = root_and_text(path);
        Ok(PictureFiles { text, format, work: Work::Whole(OutputFolder::create(here(&root))?), root })
    }

    /// Creates files that are kept if the command stops, so that a later command can resume. Several processes may each
    /// write a named part of them.
    pub fn resumable(path: &Path, format: FileFormat, part: &str) -> Result<PictureFiles> {
        let (root, text) = root_and_text(path);
        let folder = PartialFolder::open_part(here(&root), UNFINISHED, part)?;
        let work = Work::Unfinished(UnfinishedFolder::new(folder, path, "sequence"));
        Ok(PictureFiles { text, format, work, root })
    }

    /// Begins resumable files, see [`UnfinishedFolder::begin`].
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

    /// True if an earlier run wrote a file.
    pub fn has(&self, word: &str, number: u32) -> Result<bool> {
        Ok(self.folder().made(&self.below(word, number)?).is_some())
    }

    /// Returns the error of a stopped command, with a note about kept files.
    pub fn stopped(&mut self, error: Error, all: u64) -> Error {
        match &mut self.work {
            Work::Whole(_) => error,
            Work::Unfinished(unfinished) => unfinished.stopped(error, all),
        }
    }

    /// Creates PNG files in a folder, named by word and number.
    pub fn in_folder(folder: &Path) -> Result<PictureFiles> {
        let text = format!("{WORD_FIELD}.%04d.png");
        let root = folder.to_path_buf();
        Ok(PictureFiles { text, format: FileFormat::Png, work: Work::Whole(OutputFolder::create(folder)?), root })
    }

    /// True if the names contain the word.
    pub fn has_word(&self) -> bool {
        has_word(Path::new(&self.text))
    }

    /// Returns the path of a file below the folder.
    fn below(&self, word: &str, number: u32) -> Result<PathBuf> {
        Ok(Pattern::parse(&self.text.replace(WORD_FIELD, word))?.path(number))
    }

    /// Returns the path of a file from the current directory.
    pub fn path(&self, word: &str, number: u32) -> Result<PathBuf> {
        Ok(self.root.join(self.below(word, number)?))
    }

    /// Returns the path of the pattern from the current directory.
    pub fn pattern(&self) -> PathBuf {
        self.root.join(&self.text)
    }

    /// Writes a picture. Returns the size of the file in bytes.
    pub fn write(&self, (word, number): (&str, u32), picture: &RenderedImage, coding: &PictureCoding) -> Result<u64> {
        self.write_by(word, number, &mut |path: &Path| match self.format {
            FileFormat::Png => png::write_rgba8(path, &coding.look.rgba_codes(picture)),
            FileFormat::Exr => {
                let aovs = picture.aovs.iter().map(|aov| (aov.channel, &aov.plane));
                exr::write_rgba_and(path, &picture.rgba_light(coding.holes), aovs, picture.primaries)
            }
        })
    }

    /// Writes a file with a function of its path. It is moved into place by [`Self::commit`]. Returns its size in
    /// bytes.
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

/// Splits a path into the folder that is moved into place as a whole, and the pattern below it. Folders with the word
/// in their name are part of the pattern.
fn root_and_text(path: &Path) -> (PathBuf, String) {
    let parts: Vec<&OsStr> = path.iter().collect();
    let fixed = parts.iter().position(|part| has_word(Path::new(part))).unwrap_or(parts.len());
    let (above, below) = parts.split_at(fixed.min(parts.len().saturating_sub(1)));
    (above.iter().collect(), below.iter().collect::<PathBuf>().to_string_lossy().into_owned())
}

fn here(root: &Path) -> &Path {
    if root.as_os_str().is_empty() { Path::new(".") } else { root }
}

/// True if a path contains the placeholder of the word.
pub fn has_word(path: &Path) -> bool {
    path.to_string_lossy().contains(WORD_FIELD)
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::ToneMap;

    #[test]
    fn words_may_be_in_folders_and_everything_appears_at_once() {
        let base = tempfile::tempdir().unwrap();
        let picture = RenderedImage::of_pixels([1, 1], std::iter::once([1.0; 4])).unwrap();
        let coding = PictureCoding { look: ToneMap::default().into(), holes: HoleFill::Blank };
        let files = PictureFiles::create(&base.path().join("out/%V/v.%03d.png"), FileFormat::Png).unwrap();
        assert!(files.has_word());
        let expected = base.path().join("out/left/v.007.png");
        assert_eq!(files.path("left", 7).unwrap(), expected);
        assert!(files.write(("left", 7), &picture, &coding).unwrap() > 0);
        assert!(!expected.exists());
        files.commit().unwrap();
        assert!(expected.exists());
        let plain = PictureFiles::in_folder(&base.path().join("all")).unwrap();
        assert_eq!(plain.path("view", 12).unwrap(), base.path().join("all/view.0012.png"));
    }
}
