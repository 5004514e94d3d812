//! Sorts file names by their numbers: sequences of frames, names without a frame number, and numbers that are times or negative.

use std::collections::BTreeMap;

use codec::image::sequence::split_number;

/// How numbers in file names are read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Numbers {
    /// As frames of a film, if any name has a number.
    #[default]
    Frames,
    /// As names of views that were taken at one moment.
    Views,
}

/// Folder, text before and text behind the number.
type Group = [String; 3];

#[derive(Debug, Default, PartialEq, Eq)]
pub struct Sorted {
    /// Digits of each frame, by files whose names differ only in them.
    pub groups: BTreeMap<Group, BTreeMap<u32, String>>,
    pub unnumbered: Vec<String>,
    /// Files named by times, by folder and text before and behind the time.
    pub times: BTreeMap<Group, Vec<String>>,
    /// Files with frame numbers below 0.
    pub negative: Vec<String>,
}

impl Sorted {
    /// Sorts paths with `/` between folders.
    pub fn of(files: Vec<String>, numbers: Numbers) -> Sorted {
        let mut sorted = Sorted::default();
        if numbers == Numbers::Views {
            sorted.unnumbered = files;
            return sorted;
        }
        for file in files {
            let (place, name) = file.rsplit_once('/').unwrap_or(("", file.as_str()));
            let Some((before, number, after)) = split_number(name) else {
                sorted.unnumbered.push(file);
                continue;
            };
            if is_negative(before) {
                sorted.negative.push(file);
            } else if let Some(start) = time_start(before, number) {
                let group = [place, &name[..start], after].map(str::to_owned);
                sorted.times.entry(group).or_default().push(file);
            } else if let Ok(frame) = number.parse() {
                let group = [place, before, after].map(str::to_owned);
                sorted.groups.entry(group).or_default().insert(frame, number.to_owned());
            } else {
                sorted.unnumbered.push(file);
            }
        }
        sorted.skip_labels();
        sorted
    }

    /// Takes the number before the last one for the frame number, where the last one is part of a word, such as 1080p or v02, and
    /// the same in all files.
    fn skip_labels(&mut self) {
        let mut alike: BTreeMap<Group, Vec<(Group, u32, String)>> = BTreeMap::new();
        for (group, numbers) in &self.groups {
            let [place, before, after] = group;
            let is_letter = |c: Option<char>| c.is_some_and(char::is_alphabetic);
            let is_in_word = is_letter(before.chars().last()) || is_letter(after.chars().next());
            let [label] = &numbers.values().collect::<Vec<_>>()[..] else { continue };
            // Image0001 is a frame.
            let is_label = is_in_word && !(label.len() >= 3 && label.starts_with('0'));
            // The dot keeps `split_number` from taking the text for a file extension.
            let whole = format!("{before}.");
            let Some((start, number, end)) = split_number(&whole).filter(|_| is_label) else { continue };
            let Ok(frame) = number.parse() else { continue };
            let end = format!("{}{label}{after}", end.trim_end_matches('.'));
            let new = [place.clone(), start.to_owned(), end];
            alike.entry(new).or_default().push((group.clone(), frame, number.to_owned()));
        }
        for (new, files) in alike.into_iter().filter(|(_, files)| files.len() > 1) {
            for (old, frame, number) in files {
                self.groups.remove(&old);
                self.groups.entry(new.clone()).or_default().insert(frame, number);
            }
        }
    }
}

/// True if the number behind this text is below 0: `a.-005.exr`, unlike `take-005.exr`.
fn is_negative(before: &str) -> bool {
    let sign = before.strip_suffix('-');
    sign.is_some_and(|before| before.is_empty() || before.ends_with(['.', '_', ' ']))
}

/// Returns the start of the time in a name whose last number is a time since 1970: seconds with a fraction, or milli-, micro- or
/// nanoseconds; `None` for other numbers.
fn time_start(before: &str, number: &str) -> Option<usize> {
    let is_digit = |byte: &u8| byte.is_ascii_digit();
    let seconds = before.strip_suffix('.').map_or(0, |text| text.bytes().rev().take_while(is_digit).count());
    match seconds {
        9.. => Some(before.len() - seconds - 1),
        _ => (number.len() >= 12).then_some(before.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(files: &[&str]) -> Sorted {
        Sorted::of(files.iter().map(|file| (*file).to_owned()).collect(), Numbers::Frames)
    }

    fn frames(files: &[&str]) -> Vec<(String, Vec<u32>)> {
        let of = |(group, numbers): (Group, BTreeMap<u32, String>)| (group.concat(), numbers.into_keys().collect());
        sorted(files).groups.into_iter().map(of).collect()
    }

    #[test]
    fn labels_are_no_frames() {
        let one = |text: &str, frames: &[u32]| vec![(text.to_owned(), frames.to_vec())];
        assert_eq!(frames(&["x_0001_1080p.exr", "x_0002_1080p.exr"]), one("x__1080p.exr", &[1, 2]));
        assert_eq!(frames(&["0000_v02.exr", "0001_v02.exr"]), one("_v02.exr", &[0, 1]));
        assert_eq!(frames(&["a.7.clean2.exr", "a.8.clean2.exr"]), one("a..clean2.exr", &[7, 8]));
        // Probes of one frame.
        assert_eq!(frames(&["cam1_0001.exr", "cam2_0001.exr"]).len(), 2);
        assert_eq!(frames(&["cam1_Image0001.exr", "cam2_Image0001.exr"]).len(), 2);
        assert_eq!(frames(&["v02.0001.exr", "v02.0002.exr"]), one("v02..exr", &[1, 2]));
        assert_eq!(frames(&["take1.exr", "take2.exr"]), one("take.exr", &[1, 2]));
        assert_eq!(frames(&["x_0001_1080p.exr"]).len(), 1);
    }

    #[test]
    fn times_and_negative_numbers_are_no_frames() {
        for time in ["1305031102.175304.png", "c_1714564800.164.png", "1714564800164.png", "1403636579763555584.exr"] {
            assert_eq!(sorted(&[time]).times.into_values().flatten().collect::<Vec<_>>(), [time]);
        }
        let group = ["", "c_", ".png"].map(str::to_owned);
        assert!(sorted(&["c_1714564800.164.png"]).times.contains_key(&group));
        for negative in ["a.-005.exr", "a/-1.exr", "a_-0003.png"] {
            assert_eq!(sorted(&[negative]).negative, [negative]);
        }
        for frame in ["take-005.exr", "shot_1700.25.png", "20240501.exr"] {
            assert_eq!(sorted(&[frame]).groups.len(), 1, "{frame}");
        }
        let views = Sorted::of(vec!["a_01.png".into()], Numbers::Views);
        assert_eq!((views.unnumbered.len(), views.groups.len()), (1, 0));
    }
}
