//! Frame ranges, and file names with frame numbers.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::folder_names::{FolderNames, file_names};
use crate::error::{Error, Result};

/// The frames `first..=last`; never empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FrameRange {
    /// First frame.
    pub first: u32,
    /// Last frame, inclusive, not below `first`.
    pub last: u32,
}

impl FrameRange {
    /// Returns the number of frames, at least 1 (u64: the range 0..=u32::MAX has 2^32).
    pub fn count(self) -> u64 {
        u64::from(self.last) - u64::from(self.first) + 1
    }

    /// Returns true if `frame` is in the range.
    pub fn contains(self, frame: u32) -> bool {
        (self.first..=self.last).contains(&frame)
    }

    /// Returns the frames in both ranges, or `None`.
    pub fn intersect(self, other: FrameRange) -> Option<FrameRange> {
        let first = self.first.max(other.first);
        let last = self.last.min(other.last);
        (first <= last).then_some(FrameRange { first, last })
    }

    /// Returns the smallest range that contains both.
    #[must_use]
    pub fn hull(self, other: FrameRange) -> FrameRange {
        FrameRange { first: self.first.min(other.first), last: self.last.max(other.last) }
    }

    /// Iterates over all frames in order.
    pub fn iter(self) -> impl DoubleEndedIterator<Item = u32> {
        self.first..=self.last
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.first, self.last)
    }
}

impl FromStr for FrameRange {
    type Err = Error;

    /// Parses `A-B` (both inclusive), or `A` for a single frame.
    fn from_str(text: &str) -> Result<Self> {
        let wrong = || Error::Usage(format!("\"{text}\" is not a frame range: write it as 0-99, or 7 for one frame"));
        let number = |part: &str| part.trim().parse::<u32>().map_err(|_| wrong());
        let (first, last) = match text.split_once('-') {
            Some((first, last)) => (number(first)?, number(last)?),
            None => (number(text)?, number(text)?),
        };
        if first > last {
            return Err(Error::Usage(format!("frame range {text} ends before it begins")));
        }
        Ok(FrameRange { first, last })
    }
}

/// A file name pattern with a field for the frame number.
///
/// Fields are `%d` and `%04d`; n `#` for n digits (a single `#` for four); n `@` for n digits; `$F`, `$F4` and `${F4}` as in
/// Houdini; `<frame>`, `<frame04>`, `<f>` and `<f4>`. Without a width, the number is not padded. The field is in the file
/// name. Beside a field with a percent sign all other marks are part of the name; else the last mark is the field. `%%` is a
/// percent sign. Numbers longer than the width are written in full.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    directory: PathBuf,
    before: String,
    /// `None` for a plain file name.
    field: Option<Field>,
    after: String,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Field {
    /// Minimum number of digits.
    digits: usize,
    /// Field as written, such as `####` or `%04d`, for messages.
    text: String,
}

impl Field {
    /// Returns a field of the form `%04d`.
    fn percent(digits: usize) -> Field {
        Field { digits, text: if digits == 1 { "%d".into() } else { format!("%0{digits}d") } }
    }

    /// Returns a field of another width in the same form.
    fn of_width(&self, digits: usize) -> Field {
        match self.text.chars().next() {
            Some(mark @ ('#' | '@')) if (mark, digits) != ('#', 1) => {
                Field { digits, text: mark.to_string().repeat(digits) }
            }
            Some('$') => Field { digits, text: format!("$F{digits}") },
            Some('<') => Field { digits, text: format!("<frame{digits:02}>") },
            _ => Field::percent(digits),
        }
    }
}

impl Pattern {
    /// Parses a pattern; a pattern without a field names one file.
    pub fn parse(text: &str) -> Result<Pattern> {
        let path = Path::new(text);
        let name = path
            .file_name()
            .and_then(|name| name.to_str())
            .filter(|_| !text.ends_with(['/', std::path::MAIN_SEPARATOR]));
        let Some(name) = name else {
            return Err(Error::Usage(format!("\"{text}\" is not a file name")));
        };
        let directory = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let fields = fields(name).map_err(|message| Error::Usage(format!("\"{text}\"{message}")))?;
        // Fields with a percent sign are the only ones that can be escaped, so other marks beside one are part of the name.
        let of_percent = |field: &&Range<usize>| name[field.start..].starts_with('%');
        let field = match fields.iter().filter(of_percent).collect::<Vec<_>>()[..] {
            [] => fields.last(),
            [one] => Some(one),
            _ => return Err(Error::Usage(format!("\"{text}\" has more than one place for the frame number"))),
        };
        let plain = |text: &str| text.replace("%%", "%");
        let Some(field) = field.cloned() else {
            return Ok(Pattern { directory, before: plain(name), field: None, after: String::new() });
        };
        let digits = digits_of(&name[field.clone()]);
        if digits > 20 {
            return Err(Error::Usage(format!("\"{text}\" asks for a frame number of {digits} digits")));
        }
        let (before, after) = (plain(&name[..field.start]), plain(&name[field.end..]));
        Ok(Pattern { directory, before, field: Some(Field { digits, text: name[field].into() }), after })
    }

    fn folder(&self) -> &Path {
        if self.directory.as_os_str().is_empty() { Path::new(".") } else { &self.directory }
    }

    pub fn has_field(&self) -> bool {
        self.field.is_some()
    }

    /// Returns the path of a frame; without a field, the one file.
    pub fn path(&self, frame: u32) -> PathBuf {
        let name = match &self.field {
            Some(Field { digits, .. }) => format!("{}{frame:0digits$}{}", self.before, self.after),
            None => self.before.clone(),
        };
        self.directory.join(name)
    }

    #[must_use]
    pub fn below(mut self, folder: &Path) -> Pattern {
        self.directory = folder.join(&self.directory);
        self
    }

    /// Returns true if `file` exists and its name matches the pattern.
    pub fn has_name_of(&self, file: &Path) -> bool {
        let is_beside = match (self.folder().canonicalize(), file.canonicalize()) {
            (Ok(folder), Ok(file)) => file.parent() == Some(&folder),
            _ => false,
        };
        let name = file.file_name().and_then(|name| name.to_str());
        is_beside
            && name.is_some_and(|name| self.frame_of(name).is_some() || self.field.is_none() && name == self.before)
    }

    /// Returns the digits of a file name that matches the pattern with any number of digits.
    fn number_of<'a>(&self, name: &'a str) -> Option<&'a str> {
        let number = name.strip_prefix(self.before.as_str())?.strip_suffix(self.after.as_str())?;
        (!number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())).then_some(number)
    }

    /// Returns the frame number of a file name that [`Pattern::path`] would produce.
    fn frame_of(&self, name: &str) -> Option<u32> {
        let digits = self.field.as_ref()?.digits;
        let number = self.number_of(name)?;
        let padded = number.len() == digits || (number.len() > digits && !number.starts_with('0'));
        if padded { number.parse().ok() } else { None }
    }

    /// Suggests another number of digits if a file name matches the pattern except for its width.
    fn other_width(&self, names: &[String]) -> Option<String> {
        let field = self.field.as_ref()?;
        // The shortest number determines the padding, as in `only_sequence`.
        let near = names.iter().filter_map(|name| {
            let number = self.number_of(name)?;
            let usable = number.len() != field.digits && number.parse::<u32>().is_ok();
            usable.then_some((number.len(), name))
        });
        let (width, name) = near.min()?;
        Some(format!("{name} is there: did you mean {}?", field.of_width(width).text))
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let escape = |text: &str| text.replace('%', "%%");
        let name = match &self.field {
            Some(field) => format!("{}{}{}", escape(&self.before), field.text, escape(&self.after)),
            None => escape(&self.before),
        };
        write!(f, "{}", self.directory.join(name).display())
    }
}

/// Returns the places of all fields for a frame number in a file name.
fn fields(name: &str) -> Result<Vec<Range<usize>>, &'static str> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(first) = name[at..].chars().next() {
        let rest = &name[at..];
        let (is_field, used) = match first {
            '#' | '@' => (true, rest.len() - rest.trim_start_matches(first).len()),
            '%' if rest.starts_with("%%") => (false, 2),
            '%' => match percent_field(rest) {
                Some((_, used)) => (true, used),
                None => return Err(": a frame number is written %d or %04d, a percent sign %%"),
            },
            '$' | '<' => named_field(rest).map_or((false, 1), |(_, used)| (true, used)),
            _ => (false, first.len_utf8()),
        };
        if is_field {
            found.push(at..at + used);
        }
        at += used;
    }
    Ok(found)
}

/// Returns the number of digits that a field asks for.
fn digits_of(field: &str) -> usize {
    match field.as_bytes() {
        [b'#'] => 4,
        [b'#' | b'@', ..] => field.len(),
        [b'%', ..] => percent_field(field).map_or(1, |(digits, _)| digits),
        _ => named_field(field).map_or(1, |(digits, _)| digits),
    }
}

/// Parses a `%d` or `%0Nd` at the start of the text; returns its number of digits and its length.
fn percent_field(text: &str) -> Option<(usize, usize)> {
    let inner = &text[1..text.find('d')?];
    match inner.strip_prefix('0') {
        None if inner.is_empty() => Some((1, 2)),
        Some(digits) if digits.bytes().all(|byte| byte.is_ascii_digit()) => {
            Some((digits.parse::<usize>().ok()?.max(1), inner.len() + 2))
        }
        _ => None,
    }
}

/// Parses a `$F4`, `${F4}`, `<frame04>` or `<f4>` at the start of the text; returns its number of digits and its length.
fn named_field(text: &str) -> Option<(usize, usize)> {
    let (name, used) = if let Some(name) = text.strip_prefix("$F") {
        let digits = name.bytes().take_while(u8::is_ascii_digit).count();
        (&name[..digits], 2 + digits)
    } else {
        let (open, close) = if text.starts_with('<') { ("<", '>') } else { ("${F", '}') };
        let inner = &text.strip_prefix(open)?[..text.strip_prefix(open)?.find(close)?];
        let used = open.len() + inner.len() + 1;
        let lower = inner.to_ascii_lowercase();
        let name = match open {
            "<" => lower.strip_prefix("frame").or_else(|| lower.strip_prefix('f'))?.len(),
            _ => inner.len(),
        };
        (&inner[inner.len() - name..], used)
    };
    match name {
        "" => Some((1, used)),
        digits if digits.bytes().all(|byte| byte.is_ascii_digit()) => {
            Some((digits.parse::<usize>().ok()?.max(1), used))
        }
        _ => None,
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sequence {
    pattern: Pattern,
    pub frames: FrameRange,
}

impl Sequence {
    /// Finds the files of `spec`: a pattern, a folder with one sequence of .exr or .png files, or one file. The range defaults to
    /// the first and last file on disk. Fails if the file of a frame is missing.
    pub fn find(spec: &str, frames: Option<FrameRange>) -> Result<Sequence> {
        let sequence = Sequence::find_with_gaps(spec, frames)?;
        if sequence.pattern.has_field() { Sequence::known(sequence.pattern, sequence.frames) } else { Ok(sequence) }
    }

    /// Finds files as [`Self::find`] does; files of frames may be missing.
    pub fn find_with_gaps(spec: &str, frames: Option<FrameRange>) -> Result<Sequence> {
        let path = Path::new(spec);
        if path.is_dir() {
            return Sequence::of_pattern(only_sequence(path)?, frames);
        }
        // An existing file is taken literally, even if its name looks like a pattern.
        if path.is_file() {
            return Sequence::of_file(path, frames);
        }
        let pattern = Pattern::parse(spec)?;
        if !pattern.has_field() {
            return Err(Error::not_found(spec, "there is no such file or folder"));
        }
        Sequence::of_pattern(pattern, frames)
    }

    /// Creates the sequence of a pattern with a known range. Fails if a file is missing.
    pub fn known(pattern: Pattern, frames: FrameRange) -> Result<Sequence> {
        // Without a field all frames share one file.
        for frame in frames.iter().take(if pattern.has_field() { usize::MAX } else { 1 }) {
            let path = pattern.path(frame);
            if !path.is_file() {
                return Err(Error::not_found(
                    path,
                    format!(
                        "frame {frame} is missing: the file does not exist; \"missing\" in the manifest selects a \
                        replacement"
                    ),
                ));
            }
        }
        Ok(Sequence { pattern, frames })
    }

    /// Creates the sequence of a pattern with a known range, without checking that files exist.
    pub fn unchecked(pattern: Pattern, frames: FrameRange) -> Sequence {
        Sequence { pattern, frames }
    }

    /// Returns the frames of the range whose file exists, ascending, found by listing the folder. The time is proportional to
    /// their number, not to the length of the range.
    pub fn frames_there(&self, folders: &mut FolderNames) -> Result<Vec<u32>> {
        let is_there = |frame: &u32| self.path(*frame).is_file();
        let Some(names) = folders.list(self.pattern.folder())? else {
            // A folder that permits access but no listing still allows its files to be checked by name.
            return Ok(self.frames.iter().filter(is_there).collect());
        };
        let start = names.partition_point(|name| name.as_str() < self.pattern.before.as_str());
        let alike = names[start..].iter().take_while(|name| name.starts_with(&self.pattern.before));
        let numbers = alike.filter_map(|name| self.pattern.frame_of(name)).filter(|frame| self.frames.contains(*frame));
        let mut there: Vec<u32> = numbers.filter(is_there).collect();
        there.sort_unstable();
        Ok(there)
    }

    /// Returns true if each frame has its own file; false if all frames share one.
    pub fn has_field(&self) -> bool {
        self.pattern.has_field()
    }

    /// Iterates over the files of all frames, each file once.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        let count = if self.has_field() { usize::MAX } else { 1 };
        self.frames.iter().take(count).map(|frame| self.path(frame))
    }

    fn of_file(path: &Path, frames: Option<FrameRange>) -> Result<Sequence> {
        let name = path
            .file_name()
            .and_then(|name| name.to_str())
            .ok_or_else(|| Error::Usage(format!("the file name {} is not valid UTF-8", path.display())))?;
        let frame = split_number(name).and_then(|(_, number, _)| number.parse().ok()).unwrap_or(0);
        if let Some(range) = frames
            && range != (FrameRange { first: frame, last: frame })
        {
            let message = format!("frames {range} were requested, but this single file is frame {frame}");
            return Err(Error::invalid(message).in_file(path));
        }
        let directory = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let pattern = Pattern { directory, before: name.to_string(), field: None, after: String::new() };
        Ok(Sequence { pattern, frames: FrameRange { first: frame, last: frame } })
    }

    fn of_pattern(pattern: Pattern, frames: Option<FrameRange>) -> Result<Sequence> {
        if !pattern.has_field() {
            return Sequence::of_file(&pattern.path(0), frames);
        }
        let names = match (file_names(pattern.folder()), frames) {
            (Ok(names), _) => names,
            // A folder that permits access but no listing still allows its files to be opened by name.
            (Err(_), Some(_)) => Vec::new(),
            (Err(error), None) => return Err(error),
        };
        let numbers: BTreeSet<u32> = names.iter().filter_map(|name| pattern.frame_of(name)).collect();
        let hint = if numbers.is_empty() { pattern.other_width(&names) } else { None };
        if let (Some(frames), None) = (frames, &hint) {
            return Ok(Sequence { pattern, frames });
        }
        let (Some(&first), Some(&last)) = (numbers.first(), numbers.last()) else {
            let none = "no file matches this pattern";
            return Err(match hint {
                None => Error::not_found(pattern.to_string(), none),
                Some(hint) => Error::invalid(format!("{none}; {hint}")).in_file(pattern.to_string()),
            });
        };
        Ok(Sequence { pattern, frames: FrameRange { first, last } })
    }

    /// Returns the path of a frame; outside `frames` the file may not exist.
    pub fn path(&self, frame: u32) -> PathBuf {
        self.pattern.path(frame)
    }
}

/// Splits a file name at the last number before its extension: prefix, digits, suffix.
pub fn split_number(name: &str) -> Option<(&str, &str, &str)> {
    let stem = name.rfind('.').map_or(name, |dot| &name[..dot]);
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end]
        .rfind(|c: char| !c.is_ascii_digit())
        .map_or(0, |at| at + stem[at..].chars().next().map_or(1, char::len_utf8));
    Some((&name[..start], &name[start..end], &name[end..]))
}

fn only_sequence(folder: &Path) -> Result<Pattern> {
    let mut found: BTreeMap<(String, String), Option<usize>> = BTreeMap::new();
    for name in file_names(folder)? {
        let lower = name.to_ascii_lowercase();
        if name.starts_with('.') || !(lower.ends_with(".exr") || lower.ends_with(".png")) {
            continue;
        }
        match split_number(&name) {
            Some((before, number, after)) => {
                // The shortest number determines the padding: 08, 09, 10, 100 are %02d.
                let digits = found.entry((before.into(), after.into())).or_insert(Some(number.len()));
                *digits = digits.map(|least| least.min(number.len()));
            }
            None => {
                found.insert((name, String::new()), None);
            }
        }
    }
    let patterns: Vec<Pattern> = found
        .into_iter()
        .map(|((before, after), digits)| Pattern {
            directory: folder.to_path_buf(),
            before,
            field: digits.map(Field::percent),
            after,
        })
        .collect();
    match patterns.as_slice() {
        [] => Err(Error::invalid("the folder holds no .exr or .png files").in_file(folder)),
        [one] => Ok(one.clone()),
        many => {
            let mut names: Vec<String> = many.iter().take(8).map(ToString::to_string).collect();
            if many.len() > names.len() {
                names.push(format!("and {} more", many.len() - names.len()));
            }
            let message = format!("the folder has several sequences: select one of them: {}", names.join(", "));
            Err(Error::invalid(message).in_file(folder))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(folder: &Path, names: &[&str]) {
        for name in names {
            std::fs::write(folder.join(name), b"").unwrap();
        }
    }

    fn spec(folder: &Path, name: &str) -> String {
        folder.join(name).to_str().unwrap().to_string()
    }

    #[test]
    fn ranges() {
        assert_eq!("3-9".parse::<FrameRange>().unwrap(), FrameRange { first: 3, last: 9 });
        assert_eq!("7".parse::<FrameRange>().unwrap(), FrameRange { first: 7, last: 7 });
        for bad in ["", "-", "9-3", "a", "1-", "-1", "4294967296", "1-2-3"] {
            assert!(bad.parse::<FrameRange>().is_err(), "{bad}");
        }
    }

    #[test]
    fn fields() {
        for (text, expected) in [
            ("a/b.%04d.exr", "a/b.0012.exr"),
            ("b%d.exr", "b12.exr"),
            ("b.#.exr", "b.0012.exr"),
            ("b.##.exr", "b.12.exr"),
            ("b.######.exr", "b.000012.exr"),
            ("b@@@.exr", "b012.exr"),
            ("b@.exr", "b12.exr"),
            ("b%%%01d.exr", "b%12.exr"),
            ("shot#1/b.exr", "shot#1/b.exr"),
            ("é#.png", "é0012.png"),
            ("b.$F4.exr", "b.0012.exr"),
            ("b.$F.exr", "b.12.exr"),
            ("b.${F6}.exr", "b.000012.exr"),
            ("b.<frame>.exr", "b.12.exr"),
            ("b.<frame04>.exr", "b.0012.exr"),
            ("b_<Frame3>.exr", "b_012.exr"),
            ("b.<f4>.exr", "b.0012.exr"),
            ("b$HIP<UDIM>.#.exr", "b$HIP<UDIM>.0012.exr"),
            ("b$<.exr", "b$<.exr"),
            // The field is the mark with a percent sign, else the last mark.
            ("#.#.exr", "#.0012.exr"),
            ("%d@.exr", "12@.exr"),
            ("a#1_%03d_$F.exr", "a#1_012_$F.exr"),
            ("$F.#", "$F.0012"),
            ("<f>$F", "<f>12"),
        ] {
            assert_eq!(Pattern::parse(text).unwrap().path(12), Path::new(expected), "{text}");
        }
        for bad in ["", "a/", "%d.%d.exr", "%4d.exr", "%s.exr", "%", "%0xd", "%99d", "%099d", "$F99"] {
            assert!(Pattern::parse(bad).is_err(), "{bad}");
        }
        for text in [
            "a/x%%.####.exr",
            "x.#.exr",
            "x.@@.exr",
            "x.$F4.exr",
            "x.<frame>.exr",
            "x.%d.exr",
            "x.%01d.exr",
            "x.%04d.exr",
        ] {
            assert_eq!(Pattern::parse(text).unwrap().to_string(), text);
        }
    }

    #[test]
    fn finds_and_names_holes() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        touch(at, &["c.0003.exr", "c.0004.exr", "c.0006.exr", "c.00005.exr", "c.x.exr"]);
        let message = Sequence::find(&spec(at, "c.%04d.exr"), None).unwrap_err().to_string();
        assert!(message.contains("c.0005.exr") && message.contains("frame 5"), "{message}");
        let range = FrameRange { first: 3, last: 4 };
        let some = Some(range);
        let sequence = Sequence::find(&spec(at, "c.####.exr"), some).unwrap();
        assert_eq!((sequence.frames, sequence.path(4)), (range, at.join("c.0004.exr")));
        let message = Sequence::find(&spec(at, "c.%04d.exr"), Some(FrameRange { first: 2, last: 3 })).unwrap_err();
        assert!(message.to_string().contains("c.0002.exr"), "{message}");
        assert!(Sequence::find(&spec(at, "d.%04d.exr"), None).is_err());
        assert!(Sequence::find(&spec(at, "nowhere/d.%04d.exr"), None).is_err());
        let single = Sequence::find(&spec(at, "c.0006.exr"), None).unwrap();
        assert_eq!(single.frames, FrameRange { first: 6, last: 6 });
        assert_eq!(single.path(6), at.join("c.0006.exr"));
        assert!(Sequence::find(&spec(at, "c.0006.exr"), some).is_err());
    }

    #[test]
    fn another_width_is_proposed() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        touch(at, &["frame-000150.depth.png", "frame-000151.depth.png", "frame-.depth.png", "s9.exr", "s10.exr"]);
        let frames = Some(FrameRange { first: 150, last: 151 });
        for (name, frames, words) in [
            (
                "frame-%04d.depth.png",
                None,
                "frame-%04d.depth.png: no file matches this pattern; frame-000150.depth.png is there: did you mean %06d?",
            ),
            ("frame-%04d.depth.png", frames, "did you mean %06d?"),
            ("frame-####.depth.png", None, "did you mean ######?"),
            ("frame-@.depth.png", frames, "did you mean @@@@@@?"),
            ("frame-$F4.depth.png", frames, "did you mean $F6?"),
            ("frame-<f>.depth.png", frames, "did you mean <frame06>?"),
            ("s####.exr", None, "####.exr: no file matches this pattern; s9.exr is there: did you mean %d?"),
            ("frame-%04d.png", None, "frame-%04d.png: no file matches this pattern"),
            ("frame-%06d.depth.png", Some(FrameRange { first: 7, last: 8 }), "frame 7 is missing"),
        ] {
            let message = Sequence::find(&spec(at, name), frames).unwrap_err().to_string();
            assert!(message.ends_with(words) || message.contains("is missing") && message.contains(words), "{message}");
        }
    }

    #[test]
    fn folders() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let here = at.to_str().unwrap().to_string();
        assert!(Sequence::find(&here, None).is_err(), "empty");
        touch(at, &["z8.exr", "z9.exr", "z10.exr", "notes.txt"]);
        assert_eq!(Sequence::find(&here, None).unwrap().frames, FrameRange { first: 8, last: 10 });
        touch(at, &["c.0001.png"]);
        let message = Sequence::find(&here, None).unwrap_err().to_string();
        assert!(message.contains("z%d.exr") && message.contains("c.%04d.png"), "{message}");
    }
}
