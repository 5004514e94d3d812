//! Proposes a manifest for a folder of image sequences.
//!
//! Input: a folder. Output: a manifest, and a sentence for each property that the images do not determine and for each sequence that
//! is not used.
//!
//! 1. `sequences` finds files with frame numbers (`numbers`), and the kinds of images that the first file of each sequence holds.
//! 2. `names` derives for each kind one pattern with `{probe}` and `{face}`.
//! 3. `poses` reads cameras, if EXR files state them.
//! 4. `own_sizes` finds probes with images of another size, `panoramas` two eyes in one image.
//! 5. This module determines the frames, the projection from names and image shape, and depth properties from the first image.

mod depth;
mod names;
mod numbers;
mod own_sizes;
mod panoramas;
mod poses;
mod sequences;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use names::Named;
use sequences::{EYES, Found, Sequences};

pub use numbers::Numbers;

use super::manifest::{ColorInfo, FaceFiles, Files, Keep, MANIFEST_VERSION, Manifest, NORMAL_CHANNELS, Probe};
use super::normals;
use crate::image_files::{ColorSpace, exr, png};
use codec::error::{Error, Result};
use codec::image::channels::find_named;
use codec::image::layout::face_size;
use codec::image::{
    ColorPlane, DepthPlane, Eye, Face, FaceLayout, Plane, Projection, ReadLimits, StereoLayout, StreamKind,
};

/// Frames per second if no file states a rate.
const USUAL_FPS: f64 = 24.0;
/// Maximum number of reasons in the message about a folder without usable files.
const MAX_REASONS: usize = 8;

/// A proposed manifest for the files of a folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The manifest: valid, with patterns relative to the folder.
    pub manifest: Manifest,
    /// Properties that the images do not determine; one sentence each.
    pub unsure: Vec<String>,
    /// Files that are not used, with the reason; one sentence each.
    pub left_out: Vec<String>,
    /// Properties of cameras that the files do not state: positions and lenses; one sentence each.
    pub unsure_of_cameras: Vec<String>,
}

impl Proposal {
    /// Makes the patterns absolute, for a manifest in another folder.
    pub fn outside(mut self, folder: &Path) -> Result<Proposal> {
        let whole = folder.canonicalize().map_err(|error| Error::io(folder, error))?;
        let Some(whole) = whole.to_str().filter(|whole| !whole.contains(['{', '}'])) else {
            return Err(Error::invalid(
                "patterns cannot contain the path of this folder: write the manifest into the folder",
            )
            .in_file(folder));
        };
        let files = &mut self.manifest.files;
        for text in [&mut files.color, &mut files.depth, &mut files.material, &mut files.normal].into_iter().flatten() {
            *text = format!("{}/{text}", whole.trim_end_matches('/'));
        }
        Ok(self)
    }
}

/// Proposes a manifest for the images in a folder and the folders below it.
pub fn propose(folder: &Path, numbers: Numbers) -> Result<Proposal> {
    let limits = ReadLimits::default();
    let Sequences { mut found, mut left_out, unsure } = sequences::find(folder, numbers, &limits)?;
    if found.is_empty() {
        let first: Vec<&str> = left_out.iter().take(MAX_REASONS).map(String::as_str).collect();
        let left_out = if first.is_empty() { String::new() } else { format!(": {}", first.join("; ")) };
        let message = format!("it has no .exr, .png or .jpg files that can be used, such as beauty.0001.exr{left_out}");
        return Err(Error::invalid(message).in_file(folder));
    }
    let own_sizes = kinds_of(&found, folder, &mut Vec::new()).map(|kinds| own_sizes::of_probes(&kinds));
    let own_sizes = own_sizes.unwrap_or_default();
    if own_sizes.is_empty() {
        leave_out_previews(&mut found, &mut left_out);
    }
    let kinds = kinds_of(&found, folder, &mut left_out)?;
    if kinds.is_empty() {
        let channels = found[0].channels();
        let message =
            format!("its images have neither colour nor depth; {} has the channels {channels}", found[0].text);
        return Err(Error::invalid(message).in_file(folder));
    }
    Draft { folder, found: &found, kinds, own_sizes, limits, unsure, left_out }.manifest()
}

/// Returns the sequences of each kind with their common pattern.
fn kinds_of<'a>(
    found: &'a [Found],
    folder: &Path,
    left_out: &mut Vec<String>,
) -> Result<BTreeMap<StreamKind, OfKind<'a>>> {
    let mut kinds = BTreeMap::new();
    for kind in StreamKind::ALL {
        let chosen = choose(found, kind);
        if chosen.is_empty() {
            continue;
        }
        let named = names::name(&chosen.iter().map(|of| of.text.as_str()).collect::<Vec<_>>())
            .map_err(|error| error.context(format!("the files of {}", kind.name())).in_file(folder))?;
        left_out.extend(named.left_out.iter().map(|at| {
            let (text, kind) = (&chosen[*at].text, kind.name());
            format!("{kind} of {text} was left out: its name has a different form than {}", named.text)
        }));
        kinds.insert(kind, (chosen, named));
    }
    Ok(kinds)
}

/// Leaves out colour of another size, if some colour has the size of most depth images, or else of most images.
fn leave_out_previews(found: &mut [Found], left_out: &mut Vec<String>) {
    let sizes = |kind: StreamKind| found.iter().filter(move |of| of.kinds.contains(&kind)).map(|of| of.size);
    let depth: BTreeSet<(u32, u32)> = sizes(StreamKind::Depth).collect();
    let mut counts: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    sizes(StreamKind::Color).for_each(|size| *counts.entry(size).or_default() += 1);
    let usable = counts.iter().filter(|(size, _)| depth.is_empty() || depth.contains(size));
    let Some((&chosen, _)) = usable.max_by_key(|(size, count)| (**count, **size)) else { return };
    for of in found.iter_mut().filter(|of| of.kinds.len() == 1 && of.kinds.contains(&StreamKind::Color)) {
        if of.size != chosen {
            of.kinds.clear();
            let ([width, height], (other, high)) = ([of.size.0, of.size.1], chosen);
            left_out
                .push(format!("{} was left out: it is {width}x{height} pixels, others are {other}x{high}", of.text));
        }
    }
}

/// Returns the sequences of a kind. Metric depth takes precedence over disparity, and files
/// with only depth over files with depth and colour.
fn choose(found: &[Found], kind: StreamKind) -> Vec<&Found> {
    let of_kind: Vec<&Found> = found.iter().filter(|of| of.kinds.contains(&kind)).collect();
    if kind != StreamKind::Depth {
        return of_kind;
    }
    let alone = |of: &&&Found| of.kinds.len() == 1;
    let metric = |of: &&&Found| !of.is_disparity();
    let some = |is: &dyn Fn(&&&Found) -> bool| of_kind.iter().any(|of| is(&of));
    let (some_metric, some_alone) =
        (some(&metric), some(&|of| alone(of) && metric(of)) || !some(&metric) && some(&alone));
    let is_chosen = |of: &&Found| (!some_metric || metric(&of)) && (!some_alone || alone(&of));
    of_kind.iter().copied().filter(is_chosen).collect()
}

/// The sequences of a kind, and their common pattern.
type OfKind<'a> = (Vec<&'a Found>, Named);

struct Draft<'a> {
    folder: &'a Path,
    found: &'a [Found],
    kinds: BTreeMap<StreamKind, OfKind<'a>>,
    /// Sizes of images of probes, where they are not those of the first probe.
    own_sizes: BTreeMap<String, (u32, u32)>,
    limits: ReadLimits,
    unsure: Vec<String>,
    left_out: Vec<String>,
}

impl Draft<'_> {
    fn manifest(mut self) -> Result<Proposal> {
        let size = self.size()?;
        let faces = self.faces()?;
        let names = self.probe_names()?;
        let stereo_parts = self.kinds.values().all(|(files, _)| files[0].has_eyes) && names.len() == 1;
        let (projection, layout, stereo) = self.projection(size, &faces, names.len())?;
        let frames = self.frames(&names)?;
        let all = frames.values().copied().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default();
        let depth = self.depth(projection, stereo_parts)?.map(|depth| self.sized(depth, size));
        let mut probes = Vec::new();
        for name in &names {
            let frames = (frames[name] != all).then_some(frames[name]);
            let first = self.first_file(name);
            let place = first.map(|(of, face)| poses::of(of, face, frames.unwrap_or(all), &self.limits)).transpose()?;
            let own = self.own_sizes.get(name).copied();
            let mut probe =
                Probe { name: name.clone(), frames, size: own.map(Into::into), ..place.flatten().unwrap_or_default() };
            if projection == Projection::Perspective {
                let size = own.unwrap_or(size);
                probe.intrinsics = first.and_then(|(of, _)| poses::lens(of, size, frames.unwrap_or(all), &self.limits));
            }
            if probe.position.is_none() && probe.poses.is_empty() {
                probe.position = Some([0.0; 3]);
            }
            probes.push(probe);
        }
        if stereo_parts {
            probes = EYES.map(|eye| Probe { name: eye.into(), ..probes[0].clone() }).to_vec();
            self.unsure.push("the files hold two eyes, which became the probes left and right".into());
        }
        if stereo.is_some() {
            let eyes = EYES.into_iter().zip([Eye::Left, Eye::Right]);
            probes = eyes.map(|(name, eye)| Probe { name: name.into(), eye: Some(eye), ..probes[0].clone() }).collect();
            self.unsure.push("both eyes have the same position: move each by half the eye distance".into());
        }
        let unsure_of_cameras = unsure_of_cameras(&probes, projection);
        let fps = self.fps();
        let channel = stereo_parts.then(|| "{probe}".to_owned());
        let color = self.color_space().map(|space| ColorInfo { space: Some(space), ..ColorInfo::default() });
        let color = match channel {
            Some(layer) => Some(ColorInfo { layer: Some(layer), ..color.unwrap_or_default() }),
            None => color,
        };
        let file = |kind| self.kinds.get(&kind).map(|(_, named): &OfKind<'_>| named.text.clone());
        let color = color.filter(|_| self.kinds.contains_key(&StreamKind::Color));
        let color = match self.exceeds_8_bits()? {
            true => Some(ColorInfo { keep: Some(Keep::Hdr), ..color.unwrap_or_default() }),
            false => color,
        };
        let manifest = Manifest {
            schema: None,
            lightfield: MANIFEST_VERSION,
            name: self.name(),
            fps,
            frames: all,
            projection,
            size: size.into(),
            faces: layout.filter(|layout| *layout != FaceFiles::Six),
            faces_present: (faces.len() < 6 && !faces.is_empty())
                .then(|| faces.keys().map(|face| face.name().to_owned()).collect()),
            face_names: faces
                .iter()
                .any(|(face, word)| face.name() != word)
                .then(|| faces.iter().map(|(face, word)| (face.name().to_owned(), word.clone())).collect()),
            stereo,
            depth,
            color,
            material: None,
            alpha: None,
            missing: None,
            files: Files {
                color: file(StreamKind::Color),
                depth: file(StreamKind::Depth),
                material: file(StreamKind::Material),
                alpha: file(StreamKind::Alpha),
                normal: self.normals(&names)?,
            },
            probes,
            view: None,
            extra: None,
        };
        manifest.validate()?;
        Ok(Proposal { manifest, unsure: self.unsure, left_out: self.left_out, unsure_of_cameras })
    }

    fn name(&self) -> String {
        let whole = self.folder.canonicalize().unwrap_or_else(|_| self.folder.to_path_buf());
        let name = whole.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name.is_empty() || name.contains(char::is_control) { "footage".into() } else { name.into() }
    }

    /// Returns the size of the first image. Fails if sizes differ, except for depth of another size and of the same shape, and for
    /// probes with sizes of their own.
    fn size(&mut self) -> Result<(u32, u32)> {
        let mut all = self.kinds.values().flat_map(|(files, _)| files);
        let first = all.next().map_or(&self.found[0], |of| *of);
        if !self.own_sizes.is_empty() {
            let (width, height) = first.size;
            self.unsure.extend(self.own_sizes.iter().map(|(probe, (wide, high))| {
                format!("images of probe {probe} are {wide}x{high} pixels, of others {width}x{height}: it has its own \"size\"")
            }));
            return Ok(first.size);
        }
        let depth = self.kinds.get(&StreamKind::Depth).map(|(files, _)| files[0]);
        let may_differ = depth.filter(|of| has_shape_of(of.size, first.size)).map_or(first.size, |of| of.size);
        let is_depth = |of: &Found| of.kinds.len() == 1 && of.kinds.contains(&StreamKind::Depth);
        match all.find(|of| of.size != if is_depth(of) { may_differ } else { first.size }) {
            Some(other) => Err(Error::invalid(format!(
                "{} is {}x{} pixels, {} is {}x{}: all images of a dataset must have the same size; move others to \
                another folder",
                first.text, first.size.0, first.size.1, other.text, other.size.0, other.size.1
            ))
            .in_file(self.folder)),
            None => Ok(first.size),
        }
    }

    /// Returns the names of the faces in files; empty if one image holds all faces, or there is only one face.
    fn faces(&self) -> Result<BTreeMap<Face, String>> {
        let mut all = self.kinds.values().map(|(_, named)| &named.faces);
        let first = all.next().cloned().unwrap_or_default();
        match all.all(|faces| *faces == first) {
            true => Ok(first),
            false => Err(Error::invalid("the files of colour and depth use different face names").in_file(self.folder)),
        }
    }

    /// Returns the names of the probes that have files of every kind.
    fn probe_names(&mut self) -> Result<Vec<String>> {
        let of_kinds: Vec<BTreeSet<String>> = self.kinds.values().map(|(_, named)| named.probes()).collect();
        let all: BTreeSet<String> = of_kinds.iter().flatten().cloned().collect();
        let common: Vec<String> =
            all.iter().filter(|name| of_kinds.iter().all(|names| names.contains(*name))).cloned().collect();
        if common.is_empty() {
            let texts: Vec<&str> = self.kinds.values().map(|(_, named)| named.text.as_str()).collect();
            let message = format!("no probe has files of every kind: they are {}", texts.join(", "));
            return Err(Error::invalid(message).in_file(self.folder));
        }
        let lacking: Vec<&String> = all.iter().filter(|name| !common.contains(name)).collect();
        self.left_out.extend(
            lacking.iter().map(|name| format!("probe {name} was left out: it does not have files of every kind")),
        );
        Ok(common)
    }

    fn first_file(&self, probe: &str) -> Option<(&Found, Face)> {
        self.kinds.values().find_map(|(files, named)| {
            let (&(_, face), &at) = named.members.iter().find(|((name, _), _)| name == probe)?;
            Some((files[at], face))
        })
    }

    /// Returns the first and last frame common to all files of a probe, by probe name.
    fn frames(&mut self, names: &[String]) -> Result<BTreeMap<String, [u32; 2]>> {
        let mut frames = BTreeMap::new();
        for name in names {
            let files: Vec<&Found> = self
                .kinds
                .values()
                .flat_map(|(files, named)| {
                    named.members.iter().filter(|((of, _), _)| of == name).map(|(_, at)| files[*at])
                })
                .collect();
            let files = self.paired(files);
            let first = files.iter().filter_map(|(_, frames)| frames.first()).max().copied().unwrap_or(0);
            let last = files.iter().filter_map(|(_, frames)| frames.last()).min().copied().unwrap_or(0);
            if first > last {
                let message = format!("the files of probe {name} have no frame in common");
                return Err(Error::invalid(message).in_file(self.folder));
            }
            for (of, own) in files {
                let [own_first, own_last] = [own.first(), own.last()].map(|frame| frame.copied().unwrap_or(0));
                if [own_first, own_last] != [first, last] {
                    let text = &of.text;
                    self.unsure.push(format!(
                        "{text} has the frames {own_first}-{own_last}, of which {first}-{last} are used"
                    ));
                }
                let missing: Vec<u32> = (first..=last).filter(|frame| !own.contains(frame)).collect();
                if let Some(frame) = missing.first() {
                    let more =
                        if missing.len() > 1 { format!(" and {} more", missing.len() - 1) } else { String::new() };
                    self.unsure
                        .push(format!("{} lacks frame {frame}{more}: \"missing\" selects a replacement", of.text));
                }
            }
            frames.insert(name.clone(), [first, last]);
        }
        Ok(frames)
    }

    /// Returns the frames of sequences of one probe. Where files are named by times, frames are the files of the first sequence, and
    /// the others are paired with it by time.
    fn paired<'f>(&mut self, files: Vec<&'f Found>) -> Vec<(&'f Found, &'f BTreeSet<u32>)> {
        let first = files.iter().copied().find_map(|of| Some((of, of.timed.as_ref()?)));
        let mut all = Vec::new();
        for of in files {
            let Some(((first, times), own)) = first.zip(of.timed.as_ref()) else {
                all.push((of, &of.frames));
                continue;
            };
            all.push((of, &first.frames));
            if of.text != first.text {
                let apart = (own.farthest(&times.times()) * 1e3).ceil();
                self.unsure.push(format!(
                    "{} was paired with {} by the nearest time, at most {apart} ms apart",
                    of.text, first.text
                ));
            }
        }
        all
    }

    fn projection(
        &mut self,
        size: (u32, u32),
        faces: &BTreeMap<Face, String>,
        probes: usize,
    ) -> Result<(Projection, Option<FaceFiles>, Option<StereoLayout>)> {
        if !faces.is_empty() {
            if faces.iter().any(|(face, word)| face.name() != word) {
                let words: Vec<String> = faces.iter().map(|(face, word)| format!("{word} = {}", face.name())).collect();
                self.unsure.push(format!("the faces were assumed to be {}", words.join(", ")));
            }
            if self.kinds.values().any(|(_, named)| named.are_cameras) {
                self.unsure.push(
                    "the faces were taken for pictures of six cameras, not mirrored; for OpenGL cube maps leave \
                     \"faces\" out and exchange pz and nz in \"face_names\""
                        .into(),
                );
                return Ok((Projection::Cubemap, Some(FaceFiles::Cameras), None));
            }
            return Ok((Projection::Cubemap, Some(FaceFiles::Six), None));
        }
        let (width, height) = size;
        let is = |layout| face_size(layout, width, height).is_ok();
        Ok(if is(FaceLayout::Strip) {
            (Projection::Cubemap, Some(FaceFiles::Strip), None)
        } else if is(FaceLayout::Cross) && self.has_empty_corners(size)? {
            (Projection::Cubemap, Some(FaceFiles::Cross), None)
        } else if u64::from(width) == 2 * u64::from(height) {
            self.unsure.push("images twice as wide as high were assumed to be equirectangular panoramas".into());
            (Projection::Equirect, None, None)
        } else if let Some((stereo, words)) = panoramas::stereo(size)
            && probes == 1
            && panoramas::are_alike(&self.shades()?, stereo)
        {
            self.unsure.push(words.into());
            (Projection::Equirect, None, Some(stereo))
        } else {
            (Projection::Perspective, None, None)
        })
    }

    /// Returns true if each cell of a cross that no face covers is constant, and the image as a whole is not.
    fn has_empty_corners(&self, (width, height): (u32, u32)) -> Result<bool> {
        let cells: &[[u32; 2]] = if width > height {
            &[[0, 0], [2, 0], [3, 0], [0, 2], [2, 2], [3, 2]]
        } else {
            &[[0, 0], [2, 0], [0, 2], [2, 2], [0, 3], [2, 3]]
        };
        let side = face_size(FaceLayout::Cross, width, height)?;
        let file = self.kinds.iter().next().map(|(kind, (files, _))| (*kind, files[0]));
        let Some((kind, file)) = file else { return Ok(false) };
        let corners = |value: &dyn Fn(u32, u32) -> [u32; 3]| {
            cells.iter().all(|[column, row]| {
                let (left, top) = (column * side, row * side);
                (0..side * side).all(|at| value(left + at % side, top + at / side) == value(left, top))
            })
        };
        // A constant image proves nothing.
        let varies = |of: &[[u32; 3]]| of.iter().any(|value| *value != of[0]);
        let values = match kind {
            StreamKind::Color => self.read_color(file)?.map(|pixel| pixel.map(|value| u32::from(value.to_bits()))),
            StreamKind::Depth => self.read_depth(file)?.map(|value| [value.to_bits(); 3]),
            StreamKind::Material | StreamKind::Alpha => return Ok(false),
        };
        Ok(varies(values.data()) && corners(&|x, y| values.get(x, y)))
    }

    /// Returns the first image in gray, from colour, or from inverse depth with a black background; black if there is only
    /// material.
    fn shades(&self) -> Result<Plane<f32>> {
        let first = |kind| self.kinds.get(&kind).map(|(files, _)| files[0]);
        if let Some(file) = first(StreamKind::Color) {
            return Ok(self
                .read_color(file)?
                .map(|pixel| pixel.map(|value| value.to_f32().max(0.0).ln_1p()).iter().sum()));
        }
        match first(StreamKind::Depth) {
            Some(file) => Ok(self.read_depth(file)?.map(|value| value.abs().max(1e-6).recip())),
            None => Ok(Plane::filled(2, 2, 0.0)),
        }
    }

    fn read_color(&self, files: &Found) -> Result<ColorPlane> {
        match png::has_codes(&files.first) {
            true => png::read_color(&files.first, ColorSpace::Srgb, &self.limits),
            false => exr::read_color(&files.first, &files.select(), &self.limits),
        }
    }

    fn read_depth(&self, files: &Found) -> Result<DepthPlane> {
        match png::has_codes(&files.first) {
            true => png::read_depth(&files.first, 1.0, &self.limits),
            false => exr::read_depth(&files.first, &files.select(), &self.limits),
        }
    }

    fn fps(&mut self) -> f64 {
        let stated = self.found.iter().find_map(|of| of.header.as_ref()?.fps);
        let timed = || {
            let times = self.kinds.values().find_map(|(files, _)| files[0].timed.as_ref())?.times();
            let rate = (times.len() - 1) as f64 / (times.last()? - times.first()?);
            Some((rate * 1e3).round() / 1e3).filter(|rate| rate.is_finite() && *rate > 0.0)
        };
        stated.or_else(timed).unwrap_or_else(|| {
            self.unsure.push(format!("no file states its frame rate: \"fps\" is {USUAL_FPS}"));
            USUAL_FPS
        })
    }

    /// Returns the colour space, if it differs from the default of the file format.
    fn color_space(&mut self) -> Option<ColorSpace> {
        let (files, _) = self.kinds.get(&StreamKind::Color)?;
        if png::has_codes(&files[0].first) {
            self.unsure.push("colour of PNG and JPEG files was assumed to be sRGB".into());
            return Some(ColorSpace::Srgb);
        }
        let Some(primaries) = exr::read_stated_primaries(&files[0].first).ok()? else {
            self.unsure.push("colour has no chromaticities, and was assumed to be linear light of Rec. 709".into());
            return None;
        };
        let space = ColorSpace::of_light(primaries);
        if space.is_none() {
            let stated = primaries.to_array();
            self.unsure.push(format!(
                "colour has the chromaticities {stated:?} of its files, which match no named colour space"
            ));
        }
        space.filter(|space| *space != ColorSpace::LinearRec709)
    }

    /// True if a first file of colour has values above 1. Unreadable files are found by the checks.
    fn exceeds_8_bits(&self) -> Result<bool> {
        let Some((files, _)) = self.kinds.get(&StreamKind::Color) else { return Ok(false) };
        for files in files.iter().filter(|files| !png::has_codes(&files.first)) {
            let plane = self.read_color(files)?;
            if plane.data().iter().flatten().any(|value| value.to_f32() > 1.0) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Returns the pattern of normal maps that cover the same probes and faces, and notes what else of the files is not used.
    fn normals(&mut self, names: &[String]) -> Result<Option<String>> {
        let is_normal = |of: &&Found| {
            let header = of.header.as_ref();
            let has_normals = header
                .is_some_and(|header| NORMAL_CHANNELS.iter().all(|name| find_named(&header.channels, name).is_ok()));
            of.kinds.is_empty() && has_normals && normals::are_unit_vectors(&of.first, &self.limits)
        };
        let texts: Vec<&str> = self.found.iter().filter(is_normal).map(|of| of.text.as_str()).collect();
        let named = if texts.is_empty() { None } else { names::name(&texts).ok() };
        let faces = self.faces()?;
        let is_whole = |named: &Named| {
            let all_there = names.iter().all(|name| named.probes().contains(name));
            all_there && named.faces == faces && named.left_out.is_empty()
        };
        let named = named.filter(is_whole);
        let of_normals = if named.is_some() { texts.as_slice() } else { &[] };
        let is_noted = |of: &Found| {
            of_normals.contains(&of.text.as_str()) || self.left_out.iter().any(|note| note.contains(of.text.as_str()))
        };
        let is_read = |of: &Found| {
            let of_kind = |(files, named): &OfKind<'_>| named.members.values().any(|at| files[*at].text == of.text);
            self.kinds.values().any(of_kind)
        };
        let silent = self.found.iter().filter(|of| !is_noted(of) && !is_read(of));
        let left_out =
            silent.map(|of| format!("{} was left out: no stream is read from its {}", of.text, of.channels()));
        let left_out: Vec<String> = left_out.collect();
        self.left_out.extend(left_out);
        Ok(named.map(|named| named.text))
    }
}

/// True if two sizes have the same aspect, within 1%.
fn has_shape_of((width, height): (u32, u32), (other, high): (u32, u32)) -> bool {
    let [one, two] = [(width, high), (other, height)].map(|(a, b)| u64::from(a) * u64::from(b));
    100 * one.abs_diff(two) <= one.max(two)
}

fn unsure_of_cameras(probes: &[Probe], projection: Projection) -> Vec<String> {
    let mut unsure = Vec::new();
    let without = probes.iter().filter(|probe| probe.poses.is_empty() && probe.position == Some([0.0; 3])).count();
    if without > 0 {
        let stand = match probes.len() {
            1 => "the probe stands".to_owned(),
            all => format!("{without} of {all} probes stand"),
        };
        unsure.push(format!("no file states where {stand}: \"position\" is 0, 0, 0"));
    }
    if projection == Projection::Perspective && probes.iter().any(|probe| probe.intrinsics.is_none()) {
        let give = "set \"fov_y_deg\" or \"intrinsics\"; without them planar depth is not converted to distance";
        unsure.push(format!("no file states the lens: {give}"));
    }
    unsure
}
