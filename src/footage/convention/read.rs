//! Reads one frame of each probe, and keeps subsampled depth, borders, statistics and a hash of each image.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};

use glam::DQuat;
use half::f16;

use super::borders::Borders;
use super::light::ColorValues;
use super::probe_samples::{FaceSamples, Pose, ProbeSamples};
use super::seams::CubeBorders;
use super::values::{DepthValues, Stated};
use crate::dataset::{DepthKind, ProbeInfo, Source, SourceGroup, StreamKind, planar_to_distance};
use codec::depth::spread::Spread;
use codec::error::{Error, Result};
use codec::image::{ColorPlane, DepthPlane, Face, ImageProjection, Plane};
use codec::monitor::Monitor;
use codec::ordered::try_map_ordered;

/// Offset added to linear colour, so that the ratio of two dark values is near 1.
const DARK: f32 = 1e-3;

#[derive(Debug, Clone, Default)]
pub struct Choice {
    /// Names of the probes to check; all if empty.
    pub probes: Vec<String>,
    /// Maximum number of probes to check, selected evenly.
    pub max_probes: usize,
    /// Frame to check; if `None`, the first frame of each probe.
    pub frame: Option<u32>,
}

/// Content of an image, determined by the depth of its face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shows {
    /// Surfaces at more than one depth.
    Surfaces,
    /// Background, or surfaces at one depth, such as a sky dome, which looks the same from every position.
    Background,
    /// The face has no depth image.
    Unknown,
}

/// A non-constant image, and a hash of its pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HashedImage {
    /// Name of the image, such as `color 00/px`.
    pub name: String,
    pub probe: String,
    pub face: Face,
    pub kind: StreamKind,
    pub hash: u64,
    pub shows: Shows,
}

#[derive(Debug, Default)]
pub struct Footage {
    pub views: Vec<ProbeSamples>,
    pub depth_borders: Vec<(String, CubeBorders)>,
    pub color_borders: Vec<(String, CubeBorders)>,
    pub depth: Option<DepthValues>,
    /// Histogram of distances, by probe index.
    pub spreads: BTreeMap<usize, Spread>,
    pub color: Option<ColorValues>,
    /// Images with more than one value.
    pub hashes: Vec<HashedImage>,
    /// Constant colour images of faces whose depth is not constant.
    pub blank: Vec<String>,
    pub images: u64,
}

/// Data kept of an image.
struct Kept {
    face: Face,
    borders: Borders,
    hash: Option<u64>,
    values: Values,
}

enum Values {
    Depth(Box<(DepthValues, FaceSamples, Spread)>),
    Color(ColorValues),
}

/// Returns the indices of the probes to check.
pub fn chosen_probes(source: &Source, choice: &Choice) -> Result<Vec<usize>> {
    let probes = source.probes();
    if let Some(name) = choice.probes.iter().find(|name| probes.iter().all(|probe| probe.name != **name)) {
        return Err(Error::Usage(format!("there is no probe \"{name}\"")));
    }
    let has_images = |index: usize| source.groups().iter().any(|group| group.probe == index);
    let named = |index: usize| choice.probes.is_empty() || choice.probes.contains(&probes[index].name);
    let all: Vec<usize> = (0..probes.len()).filter(|index| named(*index) && has_images(*index)).collect();
    let most = choice.max_probes.max(1).min(all.len());
    Ok((0..most).map(|at| all[at * all.len() / most]).collect())
}

/// True if the checks read streams of this kind.
fn is_checked(kind: StreamKind) -> bool {
    matches!(kind, StreamKind::Color | StreamKind::Depth)
}

/// Returns the number of images that the checks could read.
pub fn all_images(source: &Source) -> u64 {
    let groups = source.groups().iter().filter(|group| is_checked(group.kind));
    groups.map(|group| group.faces.len() as u64 * group.frames.count()).sum()
}

pub fn jobs(source: &Source, choice: &Choice) -> Result<Vec<(SourceGroup, u32)>> {
    let probes = chosen_probes(source, choice)?;
    let wanted = |group: &&SourceGroup| is_checked(group.kind) && probes.contains(&group.probe);
    let frame = |group: &SourceGroup| {
        let frame = choice.frame.unwrap_or(group.frames.first);
        group.frames.contains(frame).then_some(frame)
    };
    let jobs: Vec<_> =
        source.groups().iter().filter(wanted).filter_map(|group| Some((group.clone(), frame(group)?))).collect();
    if jobs.is_empty() {
        return Err(Error::Usage("no probe has depth or colour in the requested frame".into()));
    }
    Ok(jobs)
}

/// Statistics of values.
#[derive(Debug, Default)]
pub struct FootageValues {
    pub depth: Option<DepthValues>,
    pub color: Option<ColorValues>,
}

/// Reads only the value statistics. The monitor advances by one per file.
pub fn read_values(source: &Source, choice: &Choice, stated: &Stated, monitor: &dyn Monitor) -> Result<FootageValues> {
    let counted = try_map_ordered(jobs(source, choice)?, |(group, frame)| {
        monitor.check()?;
        let mut values = FootageValues::default();
        if group.kind == StreamKind::Depth {
            let planes = source.read_depth_as_stored(&group, frame)?;
            values.depth = planes.iter().map(|plane| DepthValues::count(plane, stated)).reduce(DepthValues::add);
        } else {
            let planes = source.read_color_unfiltered(&group, frame)?;
            values.color = planes.iter().map(ColorValues::count).reduce(ColorValues::add);
        }
        monitor.advance(1);
        Ok(values)
    })?;
    let (depth, color): (Vec<_>, Vec<_>) = counted.into_iter().map(|values| (values.depth, values.color)).unzip();
    Ok(FootageValues {
        depth: depth.into_iter().flatten().reduce(DepthValues::add),
        color: color.into_iter().flatten().reduce(ColorValues::add),
    })
}

/// Reads all data that the checks need. The monitor advances by one per file.
pub fn read(source: &Source, choice: &Choice, stated: &Stated, monitor: &dyn Monitor) -> Result<Footage> {
    let jobs = jobs(source, choice)?;
    let kept = try_map_ordered(jobs, |(group, frame)| {
        monitor.check()?;
        let kept: Vec<Kept> = if group.kind == StreamKind::Depth {
            let probe = source.probes().get(group.probe);
            let faces = group.faces.iter().zip(source.read_depth_as_stored(&group, frame)?);
            let files = DepthFiles { probe, kind: source.depth_in_files, stated };
            faces.map(|(face, plane)| depth_face(*face, frame, &plane, &files)).collect()
        } else {
            let faces = group.faces.iter().zip(source.read_color_unfiltered(&group, frame)?);
            faces.map(|(face, plane)| color_face(*face, &plane)).collect()
        };
        monitor.advance(1);
        Ok((group.probe, frame, kept))
    })?;
    Ok(gather(source, kept))
}

fn gather(source: &Source, kept: Vec<(usize, u32, Vec<Kept>)>) -> Footage {
    let mut footage = Footage::default();
    // Faces with non-constant depth, the content of each face, and constant colour images.
    let (mut varied, mut shown, mut blank) = (HashSet::new(), HashMap::new(), Vec::new());
    for (index, frame, faces) in kept {
        let probe = &source.probes()[index];
        for Kept { face, borders, hash, values } in faces {
            footage.images += 1;
            let kind = if matches!(values, Values::Depth(..)) { StreamKind::Depth } else { StreamKind::Color };
            let name = format!("{} {}/{}", kind.name(), probe.name, face.name());
            match hash {
                Some(hash) => {
                    let (probe, shows) = (probe.name.clone(), Shows::Unknown);
                    footage.hashes.push(HashedImage { name, probe, face, kind, hash, shows });
                }
                None if kind == StreamKind::Color => blank.push((&probe.name, face, name)),
                None => {}
            }
            match values {
                Values::Depth(depth) => {
                    let (values, samples, spread) = *depth;
                    let before = footage.spreads.entry(index).or_default();
                    *before = std::mem::take(before).union(&spread);
                    let surfaces = values.min.is_some_and(|nearest| nearest < values.max);
                    let shows = if surfaces { Shows::Surfaces } else { Shows::Background };
                    shown.insert((probe.name.clone(), face), shows);
                    if hash.is_some() {
                        varied.insert((&probe.name, face));
                    }
                    footage.depth = Some(footage.depth.unwrap_or_default().add(values));
                    put_borders(&mut footage.depth_borders, &probe.name, face, borders);
                    // Without intrinsics, the samples of a perspective view have no direction.
                    if face == Face::View && probe.intrinsics.is_none() {
                        continue;
                    }
                    match footage.views.last_mut().filter(|view| view.name == probe.name) {
                        Some(view) => view.faces.push(samples),
                        None => footage.views.push(ProbeSamples {
                            name: probe.name.clone(),
                            frame,
                            pose: Pose {
                                position: probe.pose(frame).position.into(),
                                turn: DQuat::from_array(probe.pose(frame).orientation).normalize(),
                            },
                            faces: vec![samples],
                        }),
                    }
                }
                Values::Color(values) => {
                    footage.color = Some(footage.color.unwrap_or_default().add(values));
                    put_borders(&mut footage.color_borders, &probe.name, face, borders);
                }
            }
        }
    }
    for image in &mut footage.hashes {
        image.shows = shown.get(&(image.probe.clone(), image.face)).copied().unwrap_or(Shows::Unknown);
    }
    blank.retain(|(probe, face, _)| varied.contains(&(*probe, *face)));
    footage.blank = blank.into_iter().map(|(_, _, name)| name).collect();
    footage
}

fn put_borders(all: &mut Vec<(String, CubeBorders)>, probe: &str, face: Face, borders: Borders) {
    if face == Face::View {
        return;
    }
    if all.last().is_none_or(|(name, _)| name != probe) {
        all.push((probe.to_owned(), CubeBorders::default()));
    }
    if let Some((_, cube)) = all.last_mut() {
        cube[face as usize] = Some(borders);
    }
}

/// Meaning of the depth files of a probe.
struct DepthFiles<'a> {
    probe: Option<&'a ProbeInfo>,
    kind: DepthKind,
    stated: &'a Stated,
}

fn depth_face(face: Face, frame: u32, plane: &DepthPlane, files: &DepthFiles<'_>) -> Kept {
    let &DepthFiles { probe, kind, stated } = files;
    let values = DepthValues::count(plane, stated);
    let hash = hash_of(plane, |value| value.to_bits().into());
    let farthest = stated.rules.farthest(plane);
    let metres = |x: u32, y: u32| match stated.rules.units(plane.get(x, y)) {
        units if units >= farthest => f32::INFINITY,
        units if units > 0.0 => (f64::from(units) * stated.rules.scale.abs()) as f32,
        _ => f32::NAN,
    };
    let borders = Borders::new(plane.width().min(plane.height()), metres);
    let size = [plane.width(), plane.height()];
    let known = probe.and_then(|probe| probe.projection(face, size));
    let projection = known.unwrap_or(ImageProjection::CubeFace { face, size });
    let mut distances = DepthPlane::from_fn(size[0], size[1], metres);
    if kind == DepthKind::Planar {
        planar_to_distance(&mut distances, &projection);
    }
    let spread = Spread::of(&distances, frame, face);
    let samples = FaceSamples::new(face, metres, projection);
    Kept { face, borders, hash, values: Values::Depth(Box::new((values, samples, spread))) }
}

fn color_face(face: Face, plane: &ColorPlane) -> Kept {
    let light = |x, y| plane.get(x, y).map(f16::to_f32).iter().sum::<f32>() / 3.0;
    // Average 3x3 pixels to reduce render noise.
    let (width, height) = (plane.width(), plane.height());
    let side = width.min(height);
    let smooth = |x: u32, y: u32| {
        let mut sum = 0.0;
        let (mut count, reach) = (0, 1);
        for row in y.saturating_sub(reach)..=(y + reach).min(side - 1) {
            for col in x.saturating_sub(reach)..=(x + reach).min(side - 1) {
                sum += light(col, row);
                count += 1;
            }
        }
        (sum / count as f32).max(0.0) + DARK
    };
    let hash = hash_of(plane, |light| light.iter().fold(0, |bits, value| bits << 16 | u64::from(value.to_bits())));
    Kept { face, borders: Borders::new(side, smooth), hash, values: Values::Color(ColorValues::count(plane)) }
}

/// Returns a hash of the pixels of an image, or `None` if all are equal.
fn hash_of<T: Copy>(plane: &Plane<T>, bits: impl Fn(T) -> u64) -> Option<u64> {
    let first = bits(*plane.data().first()?);
    if plane.data().iter().all(|value| bits(*value) == first) {
        return None;
    }
    let mut hasher = DefaultHasher::new();
    (plane.width(), plane.height()).hash(&mut hasher);
    plane.data().iter().for_each(|value| hasher.write_u64(bits(*value)));
    Some(hasher.finish())
}
