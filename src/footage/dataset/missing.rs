//! Frames whose files are missing, and the frames that replace them.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use codec::error::{Error, Result};
use codec::image::{FolderNames, FrameRange, Pattern, Sequence};

/// Treatment of frames whose file is missing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Missing {
    /// Fails with an error that names the file.
    #[default]
    Error,
    /// Replaced by the last earlier frame that has a file, or else by the first one.
    Hold,
    /// Dropped at the start and end of a stream; an error in between, because streams have no gaps.
    Skip,
    /// Replaced by black, background, no material and an alpha of 0.
    Black,
}

impl Missing {
    /// Returns the name used in manifests.
    pub fn name(self) -> &'static str {
        match self {
            Missing::Error => "error",
            Missing::Hold => "hold",
            Missing::Skip => "skip",
            Missing::Black => "black",
        }
    }
}

/// Files of the frames of a stream. Memory and time are proportional to the number of existing files, not of frames.
#[derive(Debug, Clone)]
pub(super) enum FrameFiles {
    Numbered {
        sequence: Sequence,
        gaps: Option<Gaps>,
    },
    /// One file for each of the frames, by their times.
    Listed {
        files: Vec<PathBuf>,
        frames: FrameRange,
    },
}

/// Frames without a file.
#[derive(Debug, Clone)]
pub(super) struct Gaps {
    /// Frames with a file, ascending; not empty.
    there: Vec<u32>,
    /// True if missing frames are black; else the last earlier frame with a file replaces them, or the first one.
    are_black: bool,
}

impl Gaps {
    fn stand_in(&self, frame: u32) -> Option<u32> {
        let before = self.there.partition_point(|there| *there <= frame).saturating_sub(1);
        (!self.are_black).then_some(self.there[before])
    }
}

impl FrameFiles {
    /// Finds the files of a pattern with a known range. Each folder is listed once for all calls with the same `folders`.
    pub fn known(
        pattern: Pattern,
        frames: FrameRange,
        missing: Missing,
        folders: &mut FolderNames,
    ) -> Result<FrameFiles> {
        match missing {
            Missing::Error => Sequence::known(pattern, frames).map(FrameFiles::whole),
            _ => FrameFiles::with_gaps(Sequence::unchecked(pattern, frames), missing, folders),
        }
    }

    /// Finds the files of a pattern, a folder or a file, as [`Sequence::find`].
    pub fn find(spec: &str, frames: Option<FrameRange>, missing: Missing) -> Result<FrameFiles> {
        match missing {
            Missing::Error => Sequence::find(spec, frames).map(FrameFiles::whole),
            _ => {
                let sequence = Sequence::find_with_gaps(spec, frames)?;
                FrameFiles::with_gaps(sequence, missing, &mut FolderNames::default())
            }
        }
    }

    /// Creates the files of `frames`, one for each.
    pub fn listed(files: Vec<PathBuf>, frames: FrameRange) -> FrameFiles {
        FrameFiles::Listed { files, frames }
    }

    fn whole(sequence: Sequence) -> FrameFiles {
        FrameFiles::Numbered { sequence, gaps: None }
    }

    fn with_gaps(mut sequence: Sequence, missing: Missing, folders: &mut FolderNames) -> Result<FrameFiles> {
        let frames = sequence.frames;
        if !sequence.has_field() && sequence.path(frames.first).is_file() {
            return Ok(FrameFiles::whole(sequence));
        }
        let mut there = sequence.frames_there(folders)?;
        let (Some(&first), Some(&last)) = (there.first(), there.last()) else {
            let message = format!("none of the frames {frames} exists");
            return Err(Error::invalid(message).in_file(sequence.path(frames.first)));
        };
        if missing == Missing::Skip {
            sequence.frames = FrameRange { first, last };
            if let Some(gap) = there.windows(2).find(|pair| pair[0] + 1 < pair[1]) {
                let frame = gap[0] + 1;
                let message = format!(
                    "frame {frame} is missing between frames {first} and {last}, and streams have no gaps: set `missing` to hold \
                     or black"
                );
                return Err(Error::invalid(message).in_file(sequence.path(frame)));
            }
        }
        there.shrink_to_fit();
        let has_all = there.len() as u64 == sequence.frames.count();
        let gaps = (!has_all).then_some(Gaps { there, are_black: missing == Missing::Black });
        Ok(FrameFiles::Numbered { sequence, gaps })
    }

    pub fn frames(&self) -> FrameRange {
        match self {
            FrameFiles::Numbered { sequence, .. } => sequence.frames,
            FrameFiles::Listed { frames, .. } => *frames,
        }
    }

    fn gaps(&self) -> Option<&Gaps> {
        match self {
            FrameFiles::Numbered { gaps, .. } => gaps.as_ref(),
            FrameFiles::Listed { .. } => None,
        }
    }

    /// Returns the file of a frame, or of the frame that replaces it; `None` for black.
    pub fn path(&self, frame: u32) -> Option<PathBuf> {
        let is_missing = |gaps: &&Gaps| gaps.there.binary_search(&frame).is_err();
        let from = self.gaps().filter(is_missing).map_or(Some(frame), |gaps| gaps.stand_in(frame));
        match self {
            FrameFiles::Numbered { sequence, .. } => from.map(|frame| sequence.path(frame)),
            FrameFiles::Listed { files, frames } => files.get(frame.checked_sub(frames.first)? as usize).cloned(),
        }
    }

    /// The existing files.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        let (sequence, listed) = match self {
            FrameFiles::Numbered { sequence, .. } => (Some(sequence), &[][..]),
            FrameFiles::Listed { files, .. } => (None, files.as_slice()),
        };
        let gaps = self.gaps();
        let all = sequence.filter(|_| gaps.is_none()).into_iter().flat_map(Sequence::files);
        let there = gaps.into_iter().flat_map(|gaps| &gaps.there);
        all.chain(there.filter_map(move |&frame| Some(sequence?.path(frame)))).chain(listed.iter().cloned())
    }

    /// Frames without a file, each with the frame that replaces it; `None` for black.
    pub fn stand_ins(&self) -> impl Iterator<Item = (u32, Option<u32>)> {
        let FrameRange { first, last } = self.frames();
        self.gaps().into_iter().flat_map(move |gaps| {
            let mut there = gaps.there.iter().copied().peekable();
            let is_missing = move |frame: &u32| there.next_if_eq(frame).is_none();
            (first..=last).filter(is_missing).map(move |frame| (frame, gaps.stand_in(frame)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn something_stands_in_for_missing_frames() {
        let folder = tempfile::tempdir().unwrap();
        for frame in [3, 4, 7] {
            std::fs::write(folder.path().join(format!("d.{frame:04}.exr")), b"").unwrap();
        }
        let pattern = || Pattern::parse("d.%04d.exr").unwrap().below(folder.path());
        let known = |first, last, missing| {
            FrameFiles::known(pattern(), FrameRange { first, last }, missing, &mut FolderNames::default())
        };
        let held = known(2, 8, Missing::Hold).unwrap();
        let expected = [(2, Some(3)), (5, Some(4)), (6, Some(4)), (8, Some(7))];
        assert!(held.stand_ins().eq(expected), "{held:?}");
        assert_eq!(held.path(6), Some(folder.path().join("d.0004.exr")));
        assert_eq!((held.path(7), held.files().count()), (Some(folder.path().join("d.0007.exr")), 3));
        let black = known(2, 8, Missing::Black).unwrap();
        assert_eq!((black.path(5), black.stand_ins().count()), (None, 4));
        assert_eq!(known(2, 5, Missing::Skip).unwrap().frames(), FrameRange { first: 3, last: 4 });
        let words = known(2, 8, Missing::Skip).unwrap_err().to_string();
        assert!(words.contains("d.0005.exr") && words.contains("no gaps"), "{words}");
        let words = known(2, 4, Missing::Error).unwrap_err().to_string();
        assert!(words.contains("frame 2 is missing"), "{words}");
        let words = known(8, 9, Missing::Black).unwrap_err().to_string();
        assert!(words.contains("none of the frames 8-9"), "{words}");
        let spec = folder.path().join("d.####.exr");
        let found = FrameFiles::find(spec.to_str().unwrap(), None, Missing::Hold).unwrap();
        assert!(found.stand_ins().eq([(5, Some(4)), (6, Some(4))]), "{found:?}");
        assert_eq!(found.frames(), FrameRange { first: 3, last: 7 });
    }

    #[test]
    fn a_range_costs_what_its_files_cost() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["d.0003.exr", "d.4000000000.exr", "d.00007.exr", "d.0005.exr.txt", "c.0004.exr"] {
            std::fs::write(folder.path().join(name), b"").unwrap();
        }
        std::fs::create_dir(folder.path().join("d.0009.exr")).unwrap();
        let range = FrameRange { first: 0, last: u32::MAX };
        let mut folders = FolderNames::default();
        let mut known = |pattern: &str, missing| {
            let pattern = Pattern::parse(pattern).unwrap().below(folder.path());
            FrameFiles::known(pattern, range, missing, &mut folders)
        };
        for missing in [Missing::Hold, Missing::Black] {
            // Visiting every frame would take minutes, and an entry for each would take 32 GiB.
            let files = known("d.%04d.exr", missing).unwrap();
            assert_eq!((files.frames(), files.files().count()), (range, 2));
            let held = |frame| files.path(frame).map(|path| path.file_name().unwrap().to_string_lossy().into_owned());
            let gap = |name: &str| (missing == Missing::Hold).then(|| name.to_owned());
            assert_eq!(held(0), gap("d.0003.exr"));
            assert_eq!(held(3), Some("d.0003.exr".to_owned()));
            assert_eq!(held(3_999_999_999), gap("d.0003.exr"));
            assert_eq!(held(u32::MAX), gap("d.4000000000.exr"));
            let first = [0, 1, 2, 4].map(|frame| (frame, (missing == Missing::Hold).then_some(3)));
            assert!(files.stand_ins().take(4).eq(first));
        }
        let words = known("d.%04d.exr", Missing::Skip).unwrap_err().to_string();
        assert!(words.contains("frame 4 is missing between frames 3 and 4000000000"), "{words}");
        assert_eq!(known("c.%04d.exr", Missing::Skip).unwrap().frames(), FrameRange { first: 4, last: 4 });
        let one = known("c.0004.exr", Missing::Hold).unwrap();
        assert_eq!((one.path(77), one.stand_ins().next()), (Some(folder.path().join("c.0004.exr")), None));
        for missing in [Missing::Error, Missing::Hold] {
            assert_eq!(known("c.0004.exr", missing).unwrap().files().count(), 1, "one file for all frames");
        }
        for nothing in ["e.%04d.exr", "e.exr", "none/d.%04d.exr"] {
            let words = known(nothing, Missing::Hold).unwrap_err().to_string();
            assert!(words.contains("none of the frames 0-4294967295 exists"), "{words}");
        }
    }
}
