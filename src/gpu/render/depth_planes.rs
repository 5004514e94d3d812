//! Inverse depths of a probe and their pyramids in device buffers: planes of words, one for the texels of each face and one for
//! each level of its pyramid (CALF 6.2). Kernels write them from decoded tiles; textures are copied from them.
//!
//! The words equal those of `views::face_cache` and `march::pyramid` on the CPU: inverse depths come from a table and are
//! multiplied at most once.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::Gpu;
use crate::harness::groups;
use crate::render::scene::NO_BOUND;
use codec::error::Result;
use codec::image::{DepthKind, Face};
use codec::streams::DepthHeader;
use kernels::Kernel;
use kernels::layout::{DepthJob, NONE, PyramidJob, Unit, Words, list_of};
use render::march::DepthPyramid;
use render::views::{DepthPart, FaceTexels, InverseDepth, NewFace, Rect, UNKNOWN, bounds};

/// Row alignment in words, required for copies into textures.
pub const ROW_WORDS: u32 = 64;
/// Words before the first plane: the topmost level of each face, one word at the index of the face, then the reductions of the
/// six cube faces.
const HEAD_WORDS: u32 = 64;
/// Word ranges of the topmost levels of the six cube faces, and of their successive reductions: first word and number of words.
const REDUCTIONS: [[u32; 2]; 4] = [[0, 6], [8, 3], [11, 2], [13, 1]];
/// Word that holds the maximum inverse depth of a cube, clamped to [`NO_BOUND`].
pub const GREATEST_WORD: u32 = REDUCTIONS[3][0];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plane {
    /// First word.
    pub at: u32,
    /// Row pitch in words.
    pub pitch: u32,
    pub size: [u32; 2],
}

/// A rectangle of an image in a buffer, one word per texel.
#[derive(Debug, Clone, Copy)]
pub struct TexelWords<'p> {
    pub buffer: &'p wgpu::Buffer,
    /// First word.
    pub at: u32,
    /// Row pitch in words.
    pub pitch: u32,
    /// Position in the image.
    pub rect: Rect,
}

/// Planes and tables of a face.
struct FacePlanes {
    /// Texels, then the pyramid levels.
    levels: Vec<Plane>,
    /// Offset of the table that maps codes to inverse depths.
    table: u32,
    /// Offset of the ray lengths, stored row by row.
    ray_lengths: Option<u32>,
}

/// Parts of tiles in one buffer of pictures whose depths must be written.
pub struct TileParts<'p> {
    pub pictures: &'p wgpu::Buffer,
    pub parts: Vec<TilePart>,
}

#[derive(Debug, Clone, Copy)]
pub struct TilePart {
    pub face: usize,
    pub part: DepthPart,
    /// The tile's unit in the buffer of pictures.
    pub unit: Unit,
    /// Left and top of the tile in the face.
    pub corner: [u32; 2],
}

pub struct DepthPlanes {
    pub planes: wgpu::Buffer,
    tables: wgpu::Buffer,
    jobs: Option<wgpu::Buffer>,
    faces: BTreeMap<usize, FacePlanes>,
}

/// Returns the sizes of a face's planes: its texels, then the pyramid levels.
fn plane_sizes(size: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    std::iter::once(size).chain(DepthPyramid::sizes(size))
}

fn plane_words([width, height]: [u32; 2]) -> u64 {
    u64::from(width.next_multiple_of(ROW_WORDS)) * u64::from(height)
}

/// Returns the words of the larger of a probe's two buffers, planes and tables, from the sizes and headers of its depth
/// streams.
pub fn buffer_words(faces: &[([u32; 2], DepthHeader)]) -> u64 {
    let planes = faces.iter().flat_map(|(size, _)| plane_sizes(*size)).map(plane_words).sum::<u64>();
    let mut ranges = Vec::new();
    let mut tables = 0;
    for ([width, height], header) in faces {
        if !ranges.contains(&(header.range, header.kind)) {
            ranges.push((header.range, header.kind));
            tables += 1 << u16::BITS;
        }
        if header.kind == DepthKind::Distance {
            tables += u64::from(*width) * u64::from(*height);
        }
    }
    tables.max(u64::from(HEAD_WORDS) + planes)
}

/// A dispatch, with the position of its list in the jobs buffer.
pub struct Step<'p> {
    pictures: Option<&'p wgpu::Buffer>,
    /// First word of the list, and its length in words.
    at: u64,
    words: u64,
    invocations: u32,
}

/// Lists of jobs that write inverse depths, and of jobs that then write the pyramids.
#[derive(Default)]
pub struct Jobs<'p> {
    words: Vec<u32>,
    pub texels: Vec<Step<'p>>,
    pub squares: Vec<Step<'p>>,
}

/// Tables and their first words: inverse depths by code, one table per range; ray lengths, one table per projection.
#[derive(Default)]
struct Tables<'f> {
    words: Vec<u32>,
    inverse: Vec<(&'f Arc<InverseDepth>, u32)>,
    ray_lengths: Vec<(&'f FaceTexels, u32)>,
}

impl<'f> Tables<'f> {
    fn inverse(&mut self, table: &'f Arc<InverseDepth>) -> u32 {
        if let Some((_, at)) = self.inverse.iter().find(|(other, _)| Arc::ptr_eq(other, table)) {
            return *at;
        }
        let at = self.words.len() as u32;
        self.words.extend(table.of_code.iter().map(|inverse| inverse.to_bits()));
        self.inverse.push((table, at));
        at
    }

    fn ray_lengths(&mut self, face: &'f FaceTexels) -> u32 {
        let alike = |other: &FaceTexels| (other.size, other.map) == (face.size, face.map);
        if let Some((_, at)) = self.ray_lengths.iter().find(|(other, _)| alike(other)) {
            return *at;
        }
        let at = self.words.len() as u32;
        let [width, height] = face.size;
        let texels = (0..height).flat_map(|row| (0..width).map(move |column| [column, row]));
        self.words.extend(texels.map(|[column, row]| face.map.ray_length_factor(column, row).to_bits()));
        self.ray_lengths.push((face, at));
        at
    }
}

impl DepthPlanes {
    /// Creates planes with all texels unknown; returns them with the number of bytes sent.
    pub fn new(gpu: &Gpu, faces: &[NewFace<'_>]) -> Result<(DepthPlanes, u64)> {
        let (mut tables, mut known, mut at) = (Tables::default(), BTreeMap::new(), u64::from(HEAD_WORDS));
        for new in faces {
            let mut levels: Vec<Plane> = Vec::new();
            for size in plane_sizes(new.texels.size) {
                let pitch = size[0].next_multiple_of(ROW_WORDS);
                levels.push(Plane { at: u32::try_from(at).unwrap_or(u32::MAX), pitch, size });
                at += plane_words(size);
            }
            if let Some(top) = levels.last_mut() {
                top.at = new.face as u32;
            }
            let table = tables.inverse(new.inverse);
            let ray_lengths = (new.inverse.kind == DepthKind::Distance).then(|| tables.ray_lengths(new.texels));
            known.insert(new.face, FacePlanes { levels, table, ray_lengths });
        }
        // If the buffer is too large, its error states both the needed and the allowed size.
        let words = usize::try_from(at).unwrap_or(usize::MAX / 8);
        let planes = gpu.buffer("planes", words, wgpu::BufferUsages::empty())?;
        let mut start = vec![UNKNOWN.to_bits(); words];
        start[GREATEST_WORD as usize] = NO_BOUND.to_bits();
        gpu.write("planes", &planes, &start)?;
        let sent = 4 * (words + tables.words.len()) as u64;
        let tables = gpu.filled("tables", &tables.words)?;
        Ok((DepthPlanes { planes, tables, jobs: None, faces: known }, sent))
    }

    pub fn bytes(&self) -> u64 {
        self.planes.size() + self.tables.size() + self.jobs.as_ref().map_or(0, wgpu::Buffer::size)
    }

    /// Returns the planes of a face: its texels, then the pyramid levels.
    pub fn levels(&self, face: usize) -> &[Plane] {
        self.faces.get(&face).map_or(&[], |face| &face.levels)
    }

    /// Returns a rectangle of a plane.
    pub fn texels(&self, plane: &Plane, rect: Rect) -> TexelWords<'_> {
        let [left, top, ..] = rect;
        TexelWords { buffer: &self.planes, at: plane.at + top * plane.pitch + left, pitch: plane.pitch, rect }
    }

    /// True if [`GREATEST_WORD`] is computed: the probe has all six cube faces.
    pub fn has_greatest(&self) -> bool {
        Face::CUBE.iter().all(|&face| self.faces.contains_key(&(face as usize)))
            && !self.faces.contains_key(&(Face::View as usize))
    }

    pub fn list<'p>(&self, tiles: &[TileParts<'p>]) -> Jobs<'p> {
        let (mut all, mut changed) = (Jobs::default(), BTreeMap::<usize, Rect>::new());
        for tile in tiles {
            let mut jobs: Vec<DepthJob> = Vec::new();
            for TilePart { face, part, unit, corner } in &tile.parts {
                let Some(planes) = self.faces.get(face) else { continue };
                let end = jobs.last().map_or(0, |job| job.end) + part.rect[2] * part.rect[3];
                jobs.push(DepthJob { end, ..planes.job(part, unit, *corner) });
                let box_of = bounds(changed.get(face).copied(), part.rect);
                changed.insert(*face, box_of);
            }
            let end = jobs.last().map_or(0, |job| job.end);
            all.texels.extend(list(&mut all.words, &jobs, end, Some(tile.pictures)));
        }
        for jobs in self.pyramid_jobs(&changed) {
            let end = jobs.last().map_or(0, |job| job.end);
            all.squares.extend(list(&mut all.words, &jobs, end, None));
        }
        all
    }

    /// Lists the jobs of each level, from the texels up, then those of the reductions.
    fn pyramid_jobs(&self, changed: &BTreeMap<usize, Rect>) -> Vec<Vec<PyramidJob>> {
        let max_levels = changed.keys().map(|face| self.levels(*face).len()).max().unwrap_or(0);
        let mut all = Vec::new();
        for level in 1..max_levels {
            let mut jobs: Vec<PyramidJob> = Vec::new();
            for (face, &rect) in changed {
                let levels = self.levels(*face);
                let (Some(below), Some(plane)) = (levels.get(level - 1), levels.get(level)) else { continue };
                let end = jobs.last().map_or(0, |job| job.end);
                jobs.push(pyramid_job([below, plane], above(rect, level - 1), end));
            }
            all.push(jobs);
        }
        if self.has_greatest() && !changed.is_empty() {
            for pair in REDUCTIONS.windows(2) {
                let [below, plane] = [pair[0], pair[1]].map(|[at, count]| Plane { at, pitch: count, size: [count, 1] });
                let job = pyramid_job([&below, &plane], [0, 0, plane.size[0], 1], 0);
                all.push(vec![PyramidJob { limit: NO_BOUND.to_bits(), ..job }]);
            }
        }
        all
    }

    /// Sends lists of jobs; returns the number of bytes.
    pub fn send(&mut self, gpu: &Gpu, jobs: &Jobs<'_>) -> Result<u64> {
        let (words, bytes) = (jobs.words.len(), 4 * jobs.words.len() as u64);
        if words == 0 {
            return Ok(0);
        }
        let buffer = match self.jobs.take().filter(|buffer| buffer.size() >= bytes) {
            Some(buffer) => buffer,
            None => {
                let most = gpu.info.max_binding_bytes as usize / 4;
                gpu.buffer("jobs", words.next_power_of_two().min(most).max(words), wgpu::BufferUsages::empty())?
            }
        };
        gpu.write("jobs", &buffer, &jobs.words)?;
        self.jobs = Some(buffer);
        Ok(bytes)
    }

    pub fn run(&self, gpu: &Gpu, kernel: &'static Kernel, steps: &[Step<'_>]) -> Result<()> {
        let Some(jobs) = self.jobs.as_ref().filter(|_| !steps.is_empty()) else { return Ok(()) };
        let pipeline = gpu.pipeline(kernel)?;
        gpu.compute("planes", |pass| {
            for step in steps {
                let size = wgpu::BufferSize::new(4 * step.words);
                let list = wgpu::BufferBinding { buffer: jobs, offset: 4 * step.at, size };
                let group = gpu.bind(&pipeline, |name| match name {
                    "pictures" => step.pictures.map(wgpu::Buffer::as_entire_binding),
                    "tables" => Some(self.tables.as_entire_binding()),
                    "jobs" => Some(wgpu::BindingResource::Buffer(list.clone())),
                    _ => Some(self.planes.as_entire_binding()),
                });
                pass.set_pipeline(&pipeline.pipeline);
                pass.set_bind_group(0, &group, &[]);
                let [x, y] = groups(step.invocations.div_ceil(kernel.workgroup));
                pass.dispatch_workgroups(x, y, 1);
            }
        })
    }
}

impl FacePlanes {
    fn job(&self, part: &DepthPart, unit: &Unit, corner: [u32; 2]) -> DepthJob {
        let [left, top, width, _] = part.rect;
        let Some(plane) = self.levels.first() else { return DepthJob::default() };
        let (output, pitch) = (plane.at + top * plane.pitch + left, plane.pitch);
        let plain = DepthJob { width, output, pitch, ray_length: NONE, ..DepthJob::default() };
        if !part.is_known {
            return DepthJob { picture: NONE, table: UNKNOWN.to_bits(), ..plain };
        }
        let ray_length_pitch = plane.size[0];
        DepthJob {
            picture: unit.picture,
            stride: unit.stride,
            left: left - corner[0],
            top: top - corner[1],
            table: self.table,
            ray_length: self.ray_lengths.map_or(NONE, |first| first + top * ray_length_pitch + left),
            ray_length_pitch,
            ..plain
        }
    }
}

/// Returns the part of pyramid level `level`, counted from 0, that covers a rectangle of texels.
pub fn above([left, top, width, height]: Rect, level: usize) -> Rect {
    let span = |begin: u32, length: u32| {
        let first = begin >> (level + 1);
        [first, ((begin + length - 1) >> (level + 1)) - first + 1]
    };
    let ([left, width], [top, height]) = (span(left, width.max(1)), span(top, height.max(1)));
    [left, top, width, height]
}

/// Returns the job that computes a rectangle of a level from the level below.
fn pyramid_job([below, plane]: [&Plane; 2], [left, top, width, height]: Rect, end: u32) -> PyramidJob {
    PyramidJob {
        below: below.at,
        below_pitch: below.pitch,
        below_width: below.size[0],
        below_height: below.size[1],
        left,
        top,
        width,
        output: plane.at,
        pitch: plane.pitch,
        limit: u32::MAX,
        end: end + width * height,
    }
}

/// Appends a list of jobs at an offset where a binding may begin; returns no step for an empty list.
fn list<'p, T: Words>(
    words: &mut Vec<u32>,
    jobs: &[T],
    invocations: u32,
    pictures: Option<&'p wgpu::Buffer>,
) -> Option<Step<'p>> {
    if jobs.is_empty() {
        return None;
    }
    words.resize(words.len().next_multiple_of(ROW_WORDS as usize), 0);
    let at = words.len();
    words.extend(list_of([invocations, jobs.len() as u32], jobs));
    Some(Step { pictures, at: at as u64, words: (words.len() - at) as u64, invocations })
}
