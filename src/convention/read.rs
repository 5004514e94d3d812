//! Reads one frame of each probe, and keeps of every image what the checks need: thinned depth, borders, counts.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use glam::DQuat;
use half::f16;

use super::borders::Borders;
use super::light::ColorValues;
use super::seams::CubeBorders;
use super::values::{DepthValues, Stated};
use super::views::{Samples, View};
use crate::dataset::{ProbeInfo, Source, SourceGroup, StreamKind};
use crate::error::{Error, Result};
use crate::image::{ColorPlane, DepthPlane, Face, ImageProjection, Plane};
use crate::monitor::Monitor;
use crate::ordered::try_map_ordered;

/// Light below this is black where faces are compared.
const DARK: f32 = 1e-3;

/// Which images are read.
#[derive(Debug, Clone, Default)]
pub struct Choice {
    /// Only these probes; all where empty.
    pub probes: Vec<String>,
    /// At most so many of them, evenly spread.
    pub max_probes: usize,
    /// Only this frame; where `None`, each probe's first.
    pub frame: Option<u32>,
}

/// What an image shows, by the depth of its face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shows {
    /// Surfaces at more than one depth.
    Surfaces,
    /// Nothing, or surfaces at one depth only, such as a sky, which looks the same from everywhere.
    Background,
    /// The face has no depth.
    Unknown,
}

/// An image that is not of one value, and a mark of its pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Marked {
    /// `color 00/px`.
    pub name: String,
    /// Its probe's name.
    pub probe: String,
    /// Its face.
    pub face: Face,
    /// What its values are.
    pub kind: StreamKind,
    /// Equal for equal pixels.
    pub mark: u64,
    /// What is to be seen.
    pub shows: Shows,
}

/// What was read.
#[derive(Debug, Default)]
pub struct Footage {
    /// Probes with depth.
    pub views: Vec<View>,
    /// Borders of depth of each probe's cube.
    pub depth_borders: Vec<(String, CubeBorders)>,
    /// Borders of colour of each probe's cube.
    pub color_borders: Vec<(String, CubeBorders)>,
    /// All values of depth.
    pub depth: Option<DepthValues>,
    /// All values of colour.
    pub color: Option<ColorValues>,
    /// Images of more than one value.
    pub marked: Vec<Marked>,
    /// Colour images of one value, whose depth has more.
    pub blank: Vec<String>,
    /// Images that were read.
    pub images: u64,
}

/// What is kept of one image.
enum Kept {
    Depth(DepthFace),
    Color(ColorFace),
}

struct DepthFace {
    samples: Samples,
    borders: Borders,
    values: DepthValues,
    mark: Option<u64>,
}

struct ColorFace {
    face: Face,
    borders: Borders,
    values: ColorValues,
    mark: Option<u64>,
}

/// The probes that are looked at, by index.
///
/// # Errors
/// When a name is none of the dataset's.
pub fn chosen_probes(source: &Source, choice: &Choice) -> Result<Vec<usize>> {
    let probes = source.probes();
    if let Some(name) = choice.probes.iter().find(|name| probes.iter().all(|probe| probe.name != **name)) {
        return Err(Error::Usage(format!("there is no probe \"{name}\"")));
    }
    let has_images = |index: usize| source.groups().iter().any(|group| group.probe == index);
    let named = |index: usize| choice.probes.is_empty() || choice.probes.contains(&probes[index].name);
    let all: Vec<usize> = (0..probes.len()).filter(|index| named(*index) && has_images(*index)).collect();
    let most = choice.max_probes.max(1);
    if all.len() <= most {
        return Ok(all);
    }
    Ok((0..most).map(|at| all[at * all.len() / most]).collect())
}

/// The images that [`read`] opens.
pub fn jobs(source: &Source, choice: &Choice) -> Result<Vec<(SourceGroup, u32)>> {
    let probes = chosen_probes(source, choice)?;
    let wanted = |group: &&SourceGroup| group.kind != StreamKind::Material && probes.contains(&group.probe);
    let frame = |group: &SourceGroup| {
        let frame = choice.frame.unwrap_or(group.frames.first);
        group.frames.contains(frame).then_some(frame)
    };
    let jobs: Vec<_> =
        source.groups().iter().filter(wanted).filter_map(|group| Some((group.clone(), frame(group)?))).collect();
    if jobs.is_empty() {
        return Err(Error::Usage("no probe has depth or colour in the frame asked for".into()));
    }
    Ok(jobs)
}

/// Reads; the monitor advances by one for each file.
///
/// # Errors
/// When a file cannot be read, or the monitor is interrupted.
pub fn read(source: &Source, choice: &Choice, stated: &Stated, monitor: &dyn Monitor) -> Result<Footage> {
    let jobs = jobs(source, choice)?;
    let kept = try_map_ordered(jobs, |(group, frame)| {
        monitor.check()?;
        let kept: Vec<Kept> = if group.kind == StreamKind::Depth {
            let probe = source.probes().get(group.probe);
            let planes = source.read_depth_as_stored(&group, frame)?;
            group
                .faces
                .iter()
                .zip(planes)
                .map(|(face, plane)| Kept::Depth(depth_face(*face, &plane, probe, stated)))
                .collect()
        } else {
            let planes = source.read_color(&group, frame)?;
            group.faces.iter().zip(planes).map(|(face, plane)| Kept::Color(color_face(*face, &plane))).collect()
        };
        monitor.advance(1);
        Ok((group.probe, frame, kept))
    })?;
    Ok(gather(source, kept))
}

fn gather(source: &Source, kept: Vec<(usize, u32, Vec<Kept>)>) -> Footage {
    let mut footage = Footage::default();
    // Whether depth of a (probe, face) has more than one value, and what it shows.
    let mut varied = Vec::new();
    let mut blank = Vec::new();
    let mut shown = HashMap::new();
    let mut marked = Vec::new();
    for (index, frame, faces) in kept {
        let probe = &source.probes()[index];
        for kept in faces {
            footage.images += 1;
            let (face, mark, kind) = match &kept {
                Kept::Depth(kept) => (kept.samples.face, kept.mark, StreamKind::Depth),
                Kept::Color(kept) => (kept.face, kept.mark, StreamKind::Color),
            };
            let name = format!("{} {}/{}", kind.name(), probe.name, face.name());
            match (mark, kind) {
                (Some(mark), _) => marked.push((index, (face, kind), name, mark)),
                (None, StreamKind::Color) => blank.push((index, face, name)),
                (None, _) => {}
            }
            match kept {
                Kept::Depth(kept) => {
                    let surfaces = kept.values.surfaces > 0 && kept.values.min < kept.values.max;
                    shown.insert((index, face), if surfaces { Shows::Surfaces } else { Shows::Background });
                    if kept.mark.is_some() {
                        varied.push((index, face));
                    }
                    let all = footage.depth.unwrap_or_default();
                    footage.depth = Some(all.add(kept.values));
                    put_borders(&mut footage.depth_borders, &probe.name, face, kept.borders);
                    // A perspective view through an unknown lens shows nothing in space.
                    if face == Face::View && probe.intrinsics.is_none() {
                        continue;
                    }
                    match footage.views.last_mut().filter(|view| view.name == probe.name) {
                        Some(view) => view.faces.push(kept.samples),
                        None => footage.views.push(View {
                            name: probe.name.clone(),
                            frame,
                            position: probe.position.into(),
                            turn: DQuat::from_array(probe.orientation).normalize(),
                            faces: vec![kept.samples],
                        }),
                    }
                }
                Kept::Color(kept) => {
                    footage.color = Some(footage.color.unwrap_or_default().add(kept.values));
                    put_borders(&mut footage.color_borders, &probe.name, face, kept.borders);
                }
            }
        }
    }
    let of_varied = |(index, face, _): &(usize, Face, String)| varied.contains(&(*index, *face));
    footage.marked = marked
        .into_iter()
        .map(|(index, (face, kind), name, mark)| {
            let shows = shown.get(&(index, face)).copied().unwrap_or(Shows::Unknown);
            Marked { name, probe: source.probes()[index].name.clone(), face, kind, mark, shows }
        })
        .collect();
    footage.blank = blank.into_iter().filter(of_varied).map(|(_, _, name)| name).collect();
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

fn depth_face(face: Face, plane: &DepthPlane, probe: Option<&ProbeInfo>, stated: &Stated) -> DepthFace {
    let values = DepthValues::count(plane, stated);
    let mark = mark_of(plane, |value| value.to_bits());
    let metres = plane.map(|&value| {
        if value == f32::INFINITY || value == stated.background {
            f32::INFINITY
        } else if value > 0.0 {
            (f64::from(value) * stated.scale) as f32
        } else {
            f32::NAN
        }
    });
    let borders = Borders::new(plane.width().min(plane.height()), |x, y| metres.get(x, y));
    let size = [metres.width(), metres.height()];
    let known = probe.and_then(|probe| probe.projection(face, size));
    let projection = known.unwrap_or(ImageProjection::CubeFace { face, size });
    DepthFace { samples: Samples::new(face, &metres, projection), borders, values, mark }
}

fn color_face(face: Face, plane: &ColorPlane) -> ColorFace {
    let light = |x, y| plane.get(x, y).map(f16::to_f32).iter().sum::<f32>() / 3.0;
    // Columns and rows of three pixels: renderings are noisy.
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
    let mark = mark_of(plane, |value| value.map(f16::to_bits));
    ColorFace { face, borders: Borders::new(side, smooth), values: ColorValues::count(plane), mark }
}

/// A mark of the pixels of an image, unless all are the same.
fn mark_of<T: Copy, B: Hash + PartialEq>(plane: &Plane<T>, bits: impl Fn(T) -> B) -> Option<u64> {
    let first = bits(*plane.data().first()?);
    if plane.data().iter().all(|value| bits(*value) == first) {
        return None;
    }
    let mut hasher = DefaultHasher::new();
    (plane.width(), plane.height()).hash(&mut hasher);
    plane.data().iter().for_each(|value| bits(*value).hash(&mut hasher));
    Some(hasher.finish())
}
