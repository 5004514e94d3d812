//! Files named by times, such as `rgb/{time}.png` (formats/manifest.md 2): the frames of one stream in the order of their times, and
//! for each of them the file of another stream that is nearest in time.

use std::path::{Path, PathBuf};

use super::missing::FrameFiles;
use codec::error::{Error, Result, counted};
use codec::image::{FolderNames, FrameRange};

/// Mark of the time in a pattern.
pub const TIME: &str = "{time}";

/// Returns the time in seconds that a file name states: decimal seconds, or an integer of milliseconds (13 digits), microseconds (16)
/// or nanoseconds (19) since 1970.
pub fn seconds(text: &str) -> Option<f64> {
    let is_number = text.split('.').all(|part| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit()));
    let value: f64 = text.parse().ok().filter(|_| is_number && text.matches('.').count() <= 1)?;
    Some(match text.len() {
        13 if !text.contains('.') => value / 1e3,
        16 if !text.contains('.') => value / 1e6,
        19 if !text.contains('.') => value / 1e9,
        _ => value,
    })
}

/// Files of a pattern with their times in seconds, in the order of times.
#[derive(Debug, Clone)]
pub struct TimedFiles(Vec<(f64, PathBuf)>);

impl TimedFiles {
    /// Lists the files of a pattern, which has [`TIME`] once, in its file name.
    pub fn list(pattern: &Path, folders: &mut FolderNames) -> Result<TimedFiles> {
        let name = pattern.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let (before, after) = name.split_once(TIME).unwrap_or((name, ""));
        let folder = pattern.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let names = folders.list(folder)?.ok_or_else(|| {
            Error::invalid("the folder cannot be listed, which names with times need").in_file(folder)
        })?;
        let timed = |name: &String| {
            let time = seconds(name.strip_prefix(before)?.strip_suffix(after)?)?;
            Some((time, folder.join(name)))
        };
        let mut files: Vec<(f64, PathBuf)> = names.iter().filter_map(timed).collect();
        files.sort_by(|one, other| one.0.total_cmp(&other.0));
        match files.is_empty() {
            true => Err(Error::not_found(pattern, "no file has a time in place of {time}")),
            false => Ok(TimedFiles(files)),
        }
    }

    /// Returns the file at a place in the order of times.
    pub fn file(&self, place: usize) -> Option<&Path> {
        self.0.get(place).map(|(_, file)| file.as_path())
    }

    pub fn times(&self) -> Vec<f64> {
        self.0.iter().map(|(time, _)| *time).collect()
    }

    /// Returns the file that is nearest to a time, the earlier one of two, and its distance in seconds.
    fn nearest(&self, time: f64) -> (f64, &Path) {
        let after = self.0.partition_point(|(other, _)| *other < time);
        let beside = [after.saturating_sub(1), after.min(self.0.len() - 1)].map(|at| &self.0[at]);
        let [before, after] = beside.map(|(other, file)| ((other - time).abs(), file.as_path()));
        if before.0 <= after.0 { before } else { after }
    }

    /// Returns the largest distance in seconds between one of `times` and the nearest file.
    pub fn farthest(&self, times: &[f64]) -> f64 {
        times.iter().map(|time| self.nearest(*time).0).fold(0.0, f64::max)
    }

    /// Returns the files of frames: the first frame of `whole` has the first of `times`. Fails if `frames` go beyond `times`.
    pub(super) fn frames(&self, times: &[f64], whole: FrameRange, frames: FrameRange) -> Result<FrameFiles> {
        let [start, end] = [frames.first, frames.last].map(|frame| (frame.saturating_sub(whole.first)) as usize);
        let Some(wanted) = times.get(start..=end) else {
            let there = counted(times.len() as u64, "file");
            let message = format!("frames {frames} from {} on, but {there} of this pattern", whole.first);
            return Err(Error::invalid(message));
        };
        Ok(FrameFiles::listed(wanted.iter().map(|time| self.nearest(*time).1.to_path_buf()).collect(), frames))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units_by_their_digits() {
        let expected = [
            ("1305031102.175304", Some(1_305_031_102.175_304)),
            ("12", Some(12.0)),
            ("1714564800164", Some(1_714_564_800.164)),
            ("1403636579763555584", Some(1_403_636_579.763_555_6)),
            ("1.2.3", None),
            (".5", None),
            ("-1", None),
            ("", None),
        ];
        for (text, time) in expected {
            assert_eq!(seconds(text), time, "{text}");
        }
    }

    #[test]
    fn frames_take_the_nearest_file_in_time() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["d_10.5.png", "d_9.1.png", "d_11.png", "d_x.png", "c_10.png"] {
            std::fs::write(folder.path().join(name), b"").unwrap();
        }
        let list = |name: &str| TimedFiles::list(&folder.path().join(name), &mut FolderNames::default());
        let files = list("d_{time}.png").unwrap();
        assert_eq!(files.times(), [9.1, 10.5, 11.0]);
        let names = |frames: FrameFiles| -> Vec<String> {
            let name = |path: PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
            frames.files().map(name).collect()
        };
        let whole = FrameRange { first: 5, last: 8 };
        let of = |first, last| files.frames(&[9.0, 9.7, 10.75, 30.0], whole, FrameRange { first, last });
        // 10.75 is as near to 10.5 as to 11.
        assert_eq!(names(of(5, 8).unwrap()), ["d_9.1.png", "d_9.1.png", "d_10.5.png", "d_11.png"]);
        assert_eq!(names(of(7, 7).unwrap()), ["d_10.5.png"]);
        assert!(of(5, 9).unwrap_err().to_string().contains("4 files"));
        assert!((files.farthest(&[9.0, 30.0]) - 19.0).abs() < 1e-12);
        assert!(list("e_{time}.png").unwrap_err().to_string().contains("no file has a time"));
    }
}
