//! Finds the image sequences below a folder, and the kinds of images in their first files.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::numbers::{Numbers, Sorted};
use crate::dataset::manifest::{MaterialChannels, NORMAL_CHANNELS};
use crate::dataset::timed::{TIME, TimedFiles};
use crate::image_files::exr::FileHeader;
use crate::image_files::{exr, png};
use codec::error::{Error, Result};
use codec::image::channels::{find_color, find_depth, find_named};
use codec::image::{ChannelSelect, FolderNames, Pattern, ReadLimits, StreamKind};

/// Names of the parts or views of stereo files.
pub const EYES: [&str; 2] = ["left", "right"];
/// Maximum nesting depth of folders.
const MAX_FOLDERS: usize = 8;
/// Maximum number of image files.
const MAX_FILES: usize = 2_000_000;
/// Words that mark depth files by name.
const DEPTH_WORDS: [&str; 6] = ["depth", "zdepth", "z", "dist", "distance", "range"];
/// Words that mark files of disparity or inverse depth by name.
const DISPARITY_WORDS: [&str; 7] = ["disparity", "disp", "invdepth", "inversedepth", "idepth", "inverse", "inv"];
/// Words that mark files of values that look like depth but are no lengths.
const SHADE_WORDS: [&str; 3] = ["mist", "fog", "displacement"];
/// Words in the names of files that look like colour but hold another render pass.
const OTHER_WORDS: [&str; 22] = [
    "albedo",
    "normal",
    "normals",
    "nrm",
    "diffuse",
    "specular",
    "spec",
    "emission",
    "shadow",
    "shadows",
    "mask",
    "matte",
    "ao",
    "position",
    "motion",
    "velocity",
    "vector",
    "uv",
    "id",
    "crypto",
    "cryptomatte",
    "alpha",
];

/// Endings of the names of pictures, films and depth files that are not read.
const OTHER_FORMATS: [&str; 22] = [
    "avi", "avif", "bmp", "dds", "dpx", "gif", "hdr", "heic", "jp2", "jxl", "mkv", "mov", "mp4", "npy", "npz", "pfm",
    "sxr", "tga", "tif", "tiff", "webm", "webp",
];

/// Files whose names differ only in the frame number.
#[derive(Debug, Clone)]
pub struct Found {
    /// Pattern, relative to the folder, with `/` between folders.
    pub text: String,
    pub first: PathBuf,
    pub frames: BTreeSet<u32>,
    pub size: (u32, u32),
    /// Kinds of streams in the images.
    pub kinds: BTreeSet<StreamKind>,
    /// True if colour has to be selected by the name of an eye.
    pub has_eyes: bool,
    /// Channel that holds depth by the name of the file, where the names of channels are those of colour.
    pub depth_channel: Option<String>,
    /// EXR header of the first file; `None` for files of integer codes.
    pub header: Option<FileHeader>,
    /// Files named by times; `frames` are their places in this order.
    pub timed: Option<TimedFiles>,
}

impl Found {
    /// Names of channels, for messages.
    pub fn channels(&self) -> String {
        let names = self.header.iter().flat_map(|header| &header.channels).map(|channel| channel.name.clone());
        let names: Vec<String> = names.take(12).collect();
        if names.is_empty() { "of integer codes".into() } else { names.join(", ") }
    }

    /// Channels to read for inspection; the left of two eyes.
    pub fn select(&self) -> ChannelSelect {
        match &self.depth_channel {
            Some(channel) => ChannelSelect::Named(channel.clone()),
            None if self.has_eyes => ChannelSelect::Named(EYES[0].into()),
            None => ChannelSelect::Auto,
        }
    }

    /// True if the name of the depth channel says that it holds distance along rays.
    pub fn has_distance(&self) -> bool {
        let Some(header) = &self.header else { return false };
        let Ok(depth) = find_depth(&header.channels, &self.select()) else { return false };
        let name = header.channels[depth.channel].full().to_ascii_lowercase();
        name.contains("dist") || name.ends_with(".t")
    }

    /// True if the name has one of these words.
    fn is_named(&self, names: &[&str]) -> bool {
        words(&self.text).iter().any(|word| names.contains(&word.as_str()))
    }

    /// True if the name says that the files hold depth, disparity or inverse depth.
    fn is_named_depth(&self) -> bool {
        self.is_named(&DEPTH_WORDS) || self.is_disparity()
    }

    /// True if the name says that the files hold disparity or inverse depth.
    pub fn is_disparity(&self) -> bool {
        self.is_named(&DISPARITY_WORDS)
    }

    /// Returns the file of a frame.
    pub fn file(&self, frame: u32) -> Result<PathBuf> {
        if let Some(files) = &self.timed {
            return Ok(files.file(frame as usize).unwrap_or(&self.first).to_path_buf());
        }
        let name = self.text.rsplit('/').next().unwrap_or_default();
        let folder = self.first.parent().unwrap_or(Path::new(""));
        Ok(Pattern::parse(name)?.below(folder).path(frame))
    }
}

/// Sequences below a folder.
#[derive(Debug, Default)]
pub struct Sequences {
    pub found: Vec<Found>,
    /// Files that are not used, with the reason; one sentence each.
    pub left_out: Vec<String>,
    /// Properties that the names do not determine; one sentence each.
    pub unsure: Vec<String>,
}

/// Finds all sequences, sorted by name. Files are stills, each a sequence of frame 0, if no name has a number or numbers are names
/// of views.
pub fn find(folder: &Path, numbers: Numbers, limits: &ReadLimits) -> Result<Sequences> {
    let (mut left_out, mut unsure) = (Vec::new(), Vec::new());
    let (images, others) = images_below(folder)?;
    let because = |reason: &'static str| move |file: &String| format!("{file} was left out: {reason}");
    left_out.extend(others.iter().map(because("only EXR, PNG and JPEG images are read")));
    let Sorted { groups, mut unnumbered, times, negative } = Sorted::of(images, numbers);
    let mut found = Vec::new();
    if groups.is_empty() {
        for [place, before, after] in times.into_keys() {
            let name = format!("{before}{TIME}{after}");
            let text = if place.is_empty() { name } else { format!("{place}/{name}") };
            if !is_pattern(&text.replace(TIME, "")) {
                left_out.push(because(NO_PATTERN)(&text));
                continue;
            }
            let files = TimedFiles::list(&folder.join(&text), &mut FolderNames::default())?;
            let Some(first) = files.file(0).map(Path::to_path_buf) else { continue };
            let frames = (0..files.times().len() as u32).collect();
            found.push(Found { timed: Some(files), ..look(text, first, frames, limits)? });
        }
    } else {
        left_out.extend(times.values().flatten().map(because("the name is a time, not a frame number")));
    }
    left_out.extend(negative.iter().map(because("frame numbers below 0 are not supported, number them from 0")));
    if groups.is_empty() && negative.is_empty() && found.is_empty() {
        for file in std::mem::take(&mut unnumbered) {
            let text = file.replace('%', "%%");
            match is_pattern(&text) && Pattern::parse(&text).is_ok_and(|pattern| !pattern.has_field()) {
                true => found.push(look(text, folder.join(&file), BTreeSet::from([0]), limits)?),
                false => left_out.push(because(NO_PATTERN)(&file)),
            }
        }
        if !found.is_empty() && numbers == Numbers::Frames {
            unsure.push("no file name has a frame number: each file was taken for a still of one frame".into());
        }
    }
    left_out.extend(unnumbered.iter().map(because("the name has no frame number")));
    for ([place, before, after], numbers) in groups {
        let digits = numbers.values().map(String::len).min().unwrap_or(1);
        let [before, after] = [before, after].map(|text| text.replace('%', "%%"));
        let field = if digits == 1 { "%d".to_owned() } else { format!("%0{digits}d") };
        let name = format!("{before}{field}{after}");
        let text = if place.is_empty() { name.clone() } else { format!("{place}/{name}") };
        let frames: BTreeSet<u32> = numbers.keys().copied().collect();
        let (Some(frame), Ok(pattern)) = (frames.first().copied(), Pattern::parse(&name)) else {
            left_out.push(because(NO_PATTERN)(&text));
            continue;
        };
        let first = pattern.below(&folder.join(&place)).path(frame);
        if !first.is_file() || !is_pattern(&text) {
            left_out.push(because(NO_PATTERN)(&text));
            continue;
        }
        found.push(look(text, first, frames, limits)?);
    }
    for of in found.iter_mut().filter(|of| of.is_named(&SHADE_WORDS)) {
        of.kinds.clear();
        left_out.push(format!("{} was left out: its name says that it holds no lengths", of.text));
    }
    let no_depth = found.iter().filter(|of| of.kinds.is_empty() && of.is_named_depth() && !of.is_named(&SHADE_WORDS));
    left_out
        .extend(no_depth.map(|of| {
            format!("{} was left out: its name says depth, but its channels differ, or it is JPEG", of.text)
        }));
    // Other render passes, such as albedo, are used as colour only if no other colour is found.
    let is_other = |of: &Found| words(&of.text).iter().any(|word| OTHER_WORDS.contains(&word.as_str()));
    if found.iter().any(|of| of.kinds.contains(&StreamKind::Color) && !is_other(of)) {
        for of in found.iter_mut().filter(|of| of.kinds.contains(&StreamKind::Color) && is_other(of)) {
            of.kinds.clear();
            left_out.push(format!("{} was left out: it looks like another pass than colour", of.text));
        }
    }
    Ok(Sequences { found, left_out, unsure })
}

/// Reason for leaving files out.
const NO_PATTERN: &str = "its name cannot be written as a pattern";

/// True if nothing in a text would be replaced by the name of a probe or face.
fn is_pattern(text: &str) -> bool {
    !["{probe}", "{face}"].iter().any(|mark| text.contains(mark))
}

/// Returns the image files below a folder that can be read, and pictures and films in other formats: sorted, as paths relative to the
/// folder with `/` between folders.
fn images_below(folder: &Path) -> Result<(Vec<String>, Vec<String>)> {
    let (mut files, mut others) = (Vec::new(), Vec::new());
    let mut folders = vec![(String::new(), 0)];
    while let Some((place, depth)) = folders.pop() {
        let whole = folder.join(&place);
        for entry in std::fs::read_dir(&whole).map_err(|error| Error::io(&whole, error))? {
            let path = entry.map_err(|error| Error::io(&whole, error))?.path();
            let Some(name) = path.file_name().and_then(|name| name.to_str()).filter(|name| !name.starts_with('.'))
            else {
                continue;
            };
            let relative = if place.is_empty() { name.to_owned() } else { format!("{place}/{name}") };
            let lower = name.to_ascii_lowercase();
            let ends_in =
                |endings: &[&str]| lower.rsplit_once('.').is_some_and(|(_, ending)| endings.contains(&ending));
            if path.is_dir() {
                if depth < MAX_FOLDERS {
                    folders.push((relative, depth + 1));
                }
            } else if ends_in(&["exr", "png", "jpg", "jpeg"]) {
                files.push(relative);
            } else if ends_in(&OTHER_FORMATS) {
                others.push(relative);
            }
        }
        if files.len() > MAX_FILES {
            return Err(Error::invalid(format!(
                "the folder has more than {MAX_FILES} images: choose a folder inside it"
            ))
            .in_file(folder));
        }
    }
    files.sort();
    others.sort();
    Ok((files, others))
}

/// Splits a path into words, in lower case.
fn words(text: &str) -> Vec<String> {
    text.to_ascii_lowercase().split(|c: char| !c.is_ascii_alphanumeric()).map(str::to_owned).collect()
}

fn look(text: String, first: PathBuf, frames: BTreeSet<u32>, limits: &ReadLimits) -> Result<Found> {
    let is_named = |names: &[&str]| words(&text).iter().any(|word| names.contains(&word.as_str()));
    let is_named_depth = is_named(&DEPTH_WORDS) || is_named(&DISPARITY_WORDS);
    if png::has_codes(&first) {
        let size = png::read_size(&first, limits)?;
        let is_depth = match is_named_depth {
            true => png::read_depth(&first, 1.0, limits).is_ok(),
            false => png::is_gray16(&first, limits)?,
        };
        // A picture of depth in false colours, or in JPEG, is neither depth nor colour.
        let kind = match is_depth {
            true => Some(StreamKind::Depth),
            false => (!is_named_depth).then_some(StreamKind::Color),
        };
        let kinds = kind.into_iter().collect();
        return Ok(Found {
            text,
            first,
            frames,
            size,
            kinds,
            has_eyes: false,
            depth_channel: None,
            header: None,
            timed: None,
        });
    }
    let header = exr::read_header(&first, limits)?;
    let names = &header.channels;
    let eyes = EYES.map(|eye| find_color(names, &ChannelSelect::Named(eye.into())).is_ok());
    // Y of a vector is no gray.
    let is_vector = NORMAL_CHANNELS.iter().all(|name| find_named(names, name).is_ok());
    let color = find_color(names, &ChannelSelect::Auto).ok().filter(|[r, g, _]| !is_vector || r != g);
    let has_eyes = eyes == [true; 2];
    let gray = color.filter(|[r, g, _]| r == g).map(|[gray, ..]| gray);
    let of_eye = ChannelSelect::Named(EYES[0].into());
    let select = if has_eyes { &of_eye } else { &ChannelSelect::Auto };
    let depth = find_depth(names, select).ok().filter(|depth| is_named_depth || Some(depth.channel) != gray);
    let red = color.filter(|_| is_named_depth && depth.is_none() && gray.is_none()).map(|[red, ..]| red);
    let depth_channel = match red {
        Some(red) if is_equal_in_all(&first, limits)? => Some(names[red].full()),
        _ => None,
    };
    let mut kinds = BTreeSet::new();
    if has_eyes || color.is_some() && !(is_named_depth && (gray.is_some() || depth.is_none())) {
        kinds.insert(StreamKind::Color);
    }
    if depth.is_some() || depth_channel.is_some() {
        kinds.insert(StreamKind::Depth);
    }
    if MaterialChannels::default().names().iter().all(|name| find_named(names, name).is_ok()) {
        kinds.insert(StreamKind::Material);
    }
    Ok(Found {
        text,
        first,
        frames,
        size: header.size,
        kinds,
        has_eyes,
        depth_channel,
        header: Some(header),
        timed: None,
    })
}

/// True if red, green and blue of an EXR file are equal in every pixel.
fn is_equal_in_all(path: &Path, limits: &ReadLimits) -> Result<bool> {
    let plane = exr::read_color(path, &ChannelSelect::Auto, limits)?;
    Ok(plane.data().iter().all(|pixel| pixel.iter().all(|value| value.to_bits() == pixel[0].to_bits())))
}
