//! Frames whose files are missing, and what stands in their place.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::image::{FrameRange, Pattern, Sequence};

/// Treatment of frames whose file is missing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Missing {
    /// An error that names the file.
    #[default]
    Error,
    /// The last frame before it that is there, else the first one.
    Hold,
    /// At the start and end of a stream they are left out; within it they are an error, as streams have no gaps.
    Skip,
    /// Black light, background, no material, and an alpha of 0.
    Black,
}

impl Missing {
    /// As in manifests.
    pub fn name(self) -> &'static str {
        match self {
            Missing::Error => "error",
            Missing::Hold => "hold",
            Missing::Skip => "skip",
            Missing::Black => "black",
        }
    }
}

/// The files of a stream's frames.
#[derive(Debug, Clone)]
pub(super) struct FrameFiles {
    sequence: Sequence,
    /// Frames without a file, and the frame in their place; none for black.
    stand_ins: BTreeMap<u32, Option<u32>>,
}

impl FrameFiles {
    /// Those of a pattern whose range is known.
    pub fn known(pattern: Pattern, frames: FrameRange, missing: Missing) -> Result<FrameFiles> {
        match missing {
            Missing::Error => Sequence::known(pattern, frames).map(FrameFiles::whole),
            _ => FrameFiles::with_gaps(Sequence::unchecked(pattern, frames), missing),
        }
    }

    /// Those of a pattern, a folder or a file, as [`Sequence::find`].
    pub fn find(spec: &str, frames: Option<FrameRange>, missing: Missing) -> Result<FrameFiles> {
        match missing {
            Missing::Error => Sequence::find(spec, frames).map(FrameFiles::whole),
            _ => FrameFiles::with_gaps(Sequence::find_with_gaps(spec, frames)?, missing),
        }
    }

    fn whole(sequence: Sequence) -> FrameFiles {
        FrameFiles { sequence, stand_ins: BTreeMap::new() }
    }

    fn with_gaps(mut sequence: Sequence, missing: Missing) -> Result<FrameFiles> {
        let is_there = |frame: &u32| sequence.path(*frame).is_file();
        let there: Vec<u32> = sequence.frames.iter().filter(is_there).collect();
        let (Some(&first), Some(&last)) = (there.first(), there.last()) else {
            let message = format!("none of the frames {} is there", sequence.frames);
            return Err(Error::invalid(message).in_file(sequence.path(sequence.frames.first)));
        };
        if missing == Missing::Skip {
            sequence.frames = FrameRange { first, last };
        }
        let mut stand_ins = BTreeMap::new();
        let (mut held, mut next) = (first, there.iter().copied().peekable());
        for frame in sequence.frames.iter() {
            match next.next_if_eq(&frame) {
                Some(frame) => held = frame,
                None if missing == Missing::Skip => {
                    let message = format!(
                        "frame {frame} is missing between frames {first} and {last}, and streams have no gaps: set `missing` to \
                         hold or black"
                    );
                    return Err(Error::invalid(message).in_file(sequence.path(frame)));
                }
                None => {
                    stand_ins.insert(frame, (missing == Missing::Hold).then_some(held));
                }
            }
        }
        Ok(FrameFiles { sequence, stand_ins })
    }

    pub fn frames(&self) -> FrameRange {
        self.sequence.frames
    }

    /// The file of a frame, or of that in its place; none for black.
    pub fn path(&self, frame: u32) -> Option<PathBuf> {
        let from = self.stand_ins.get(&frame).copied().unwrap_or(Some(frame));
        from.map(|frame| self.sequence.path(frame))
    }

    /// The files that are there.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        self.frames().iter().filter(|frame| !self.stand_ins.contains_key(frame)).map(|frame| self.sequence.path(frame))
    }

    /// Frames without a file, and the frame in their place; none for black.
    pub fn stand_ins(&self) -> impl Iterator<Item = (u32, Option<u32>)> {
        self.stand_ins.iter().map(|(frame, held)| (*frame, *held))
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
        let known = |first, last, missing| FrameFiles::known(pattern(), FrameRange { first, last }, missing);
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
}
