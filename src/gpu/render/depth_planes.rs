//! Inverse depths of a probe and their pyramids in device buffers: planes of words, one for the texels of each face and one for
//! each level of its pyramid (CALF 6.2). Kernels write them from decoded tiles; textures are copied from them.
//!
//! The words equal those of `views::face_cache` and `march::pyramid` on the CPU: inverse depths come from a table, and are
//! multiplied at most once.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use crate::depth::quantise::DepthRange;
use crate::error::{Error, Result};
use crate::gpu::device::Gpu;
use crate::gpu::harness::groups;
use crate::gpu::kernels::{self, Kernel};
use crate::gpu::layout::{DepthJob, NONE, PyramidJob, Unit, Words, words_of};
use crate::gpu::render::scene::NO_BOUND;
use crate::image::DepthKind;
use crate::image::cube::Face;
use crate::march::pyramid::DepthPyramid;
use crate::views::backend::NewFace;
use crate::views::face_cache::DepthPart;
use crate::views::inverse_depth::InverseDepth;
use crate::views::light_field::{FaceTexels, UNKNOWN};
use crate::views::rects::{Rect, bounds};

/// Alignment of rows in words: copies into textures require it.
pub const ROW_WORDS: u32 = 64;
/// Words before the first plane: the topmost level of each face, one word at the number of the face, then reductions of those
/// of a cube.
const HEAD_WORDS: u32 = 64;
/// Words of the six tops of a cube, then of their reductions: the first of each, and how many.
const REDUCTIONS: [[u32; 2]; 4] = [[0, 6], [8, 3], [11, 2], [13, 1]];
/// The word of the greatest inverse depth of a cube, and at most [`NO_BOUND`].
pub const GREATEST_WORD: u32 = REDUCTIONS[3][0];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plane {
    /// Its first word.
    pub at: u32,
    /// Words from row to row.
    pub pitch: u32,
    /// Columns and rows.
    pub size: [u32; 2],
}

/// Planes and tables of a face.
#[derive(Debug)]
struct FacePlanes {
    /// Texels, and the levels above them.
    levels: Vec<Plane>,
    /// First of the inverse depths by code.
    table: u32,
    /// First of the ray lengths, row by row.
    ray_lengths: Option<u32>,
}

/// Parts of the tiles in one buffer of pictures, whose depths are to be written.
#[derive(Debug)]
pub struct TileParts<'p> {
    pub pictures: &'p wgpu::Buffer,
    pub parts: Vec<TilePart>,
}

#[derive(Debug, Clone, Copy)]
pub struct TilePart {
    pub face: usize,
    pub part: DepthPart,
    /// Where the tile lies in the buffer.
    pub unit: Unit,
    /// Left and top of the tile in the face.
    pub corner: [u32; 2],
}

/// Planes of a probe.
#[derive(Debug)]
pub struct DepthPlanes {
    planes: wgpu::Buffer,
    tables: wgpu::Buffer,
    jobs: Option<wgpu::Buffer>,
    faces: BTreeMap<usize, FacePlanes>,
}

/// Columns and rows of the planes of a face: its texels, and the levels above them.
fn plane_sizes(size: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    std::iter::once(size).chain(DepthPyramid::sizes(size))
}

fn plane_words([width, height]: [u32; 2]) -> u64 {
    u64::from(width.next_multiple_of(ROW_WORDS)) * u64::from(height)
}

/// The depth stream of a face.
#[derive(Debug, Clone, Copy)]
pub struct DepthImage {
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub range: DepthRange,
    /// Planar depth or distance.
    pub kind: DepthKind,
}

/// Most words of the larger buffer of a probe: the planes of its faces, or the tables.
pub fn buffer_words(faces: &[DepthImage]) -> u64 {
    let planes = faces.iter().flat_map(|face| plane_sizes(face.size)).map(plane_words).sum::<u64>();
    let mut ranges = Vec::new();
    let mut tables = 0;
    for face in faces {
        if !ranges.contains(&(face.range, face.kind)) {
            ranges.push((face.range, face.kind));
            tables += 1 << u16::BITS;
        }
        if face.kind == DepthKind::Distance {
            tables += u64::from(face.size[0]) * u64::from(face.size[1]);
        }
    }
    tables.max(u64::from(HEAD_WORDS) + planes)
}

/// A dispatch: its kernel, and its list among the jobs.
#[derive(Debug)]
struct Step<'p> {
    kernel: &'static Kernel,
    pictures: Option<&'p wgpu::Buffer>,
    words: [usize; 2],
    invocations: u32,
}

/// Tables with their first words: inverse depths by code, once per range, and ray lengths, once per projection.
#[derive(Default)]
struct Tables<'f> {
    words: usize,
    inverse: Vec<(&'f Arc<InverseDepth>, usize)>,
    ray_lengths: Vec<(&'f FaceTexels, usize)>,
}

impl<'f> Tables<'f> {
    fn inverse(&mut self, table: &'f Arc<InverseDepth>) -> u32 {
        if let Some((_, at)) = self.inverse.iter().find(|(other, _)| Arc::ptr_eq(other, table)) {
            return *at as u32;
        }
        let at = self.words;
        self.words += table.of_codes().len();
        self.inverse.push((table, at));
        at as u32
    }

    fn ray_lengths(&mut self, face: &'f FaceTexels) -> u32 {
        let alike = |other: &FaceTexels| (other.size, other.map) == (face.size, face.map);
        if let Some((_, at)) = self.ray_lengths.iter().find(|(other, _)| alike(other)) {
            return *at as u32;
        }
        let at = self.words;
        self.words += face.size[0] as usize * face.size[1] as usize;
        self.ray_lengths.push((face, at));
        at as u32
    }

    /// All their words.
    fn values(&self) -> Vec<u32> {
        let mut words = vec![0; self.words];
        for (table, at) in &self.inverse {
            words[*at..].iter_mut().zip(table.of_codes()).for_each(|(word, inverse)| *word = inverse.to_bits());
        }
        for (face, at) in &self.ray_lengths {
            let [width, height] = face.size;
            let texels = (0..height).flat_map(|row| (0..width).map(move |column| [column, row]));
            let lengths = texels.map(|[column, row]| face.map.ray_length_factor(column, row).to_bits());
            words[*at..].iter_mut().zip(lengths).for_each(|(word, length)| *word = length);
        }
        words
    }
}

impl DepthPlanes {
    /// Planes of faces without known texels, and the bytes that were sent.
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
            let ray_lengths = (new.inverse.kind() == DepthKind::Distance).then(|| tables.ray_lengths(new.texels));
            known.insert(new.face, FacePlanes { levels, table, ray_lengths });
        }
        // The error of a buffer that is too large names both sizes.
        let words = usize::try_from(at).unwrap_or(usize::MAX / 8);
        let none = wgpu::BufferUsages::empty();
        let planes = gpu.buffer("planes", words, none)?;
        let buffer = gpu.buffer("tables", tables.words, none)?;
        let values = tables.values();
        let mut start = vec![UNKNOWN.to_bits(); words];
        start[GREATEST_WORD as usize] = NO_BOUND.to_bits();
        gpu.guard("planes", || {
            gpu.queue.write_buffer(&planes, 0, bytemuck::cast_slice(&start));
            gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&values));
        })?;
        let sent = 4 * (words + values.len()) as u64;
        Ok((DepthPlanes { planes, tables: buffer, jobs: None, faces: known }, sent))
    }

    /// Bytes of the device that they take.
    pub fn bytes(&self) -> u64 {
        self.planes.size() + self.tables.size() + self.jobs.as_ref().map_or(0, wgpu::Buffer::size)
    }

    /// All planes.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.planes
    }

    /// The texels of a face, and the levels of its pyramid.
    pub fn levels(&self, face: usize) -> &[Plane] {
        self.faces.get(&face).map_or(&[], |face| &face.levels)
    }

    /// Whether there is [`GREATEST_WORD`]: a face in every direction.
    pub fn has_greatest(&self) -> bool {
        Face::CUBE.iter().all(|&face| self.faces.contains_key(&(face as usize)))
            && !self.faces.contains_key(&(Face::View as usize))
    }

    /// Writes inverse depths and their pyramids; answers the bytes that were sent. `done` is called after the texels, and after
    /// the pyramids.
    pub fn write(&mut self, gpu: &Gpu, tiles: &[TileParts<'_>], mut done: impl FnMut() -> Result<()>) -> Result<u64> {
        let mut words = Vec::new();
        let mut changed: BTreeMap<usize, Rect> = BTreeMap::new();
        let mut texels = Vec::new();
        for tile in tiles {
            let mut jobs: Vec<DepthJob> = Vec::new();
            for TilePart { face, part, unit, corner } in &tile.parts {
                let Some(planes) = self.faces.get(face) else { continue };
                let end = jobs.last().map_or(0, |job| job.end) + part.rect[2] * part.rect[3];
                jobs.push(DepthJob { end, ..planes.job(part, unit, *corner) });
                let box_of = bounds(changed.get(face).copied(), part.rect);
                changed.insert(*face, box_of);
            }
            let invocations = jobs.last().map_or(0, |job| job.end);
            texels.extend(list(&mut words, &jobs, invocations).map(|words| Step {
                kernel: &kernels::TEXELS,
                pictures: Some(tile.pictures),
                words,
                invocations,
            }));
        }
        let mut squares = Vec::new();
        for jobs in self.pyramid_jobs(&changed) {
            let invocations = jobs.last().map_or(0, |job| job.end);
            squares.extend(list(&mut words, &jobs, invocations).map(|words| Step {
                kernel: &kernels::SQUARES,
                pictures: None,
                words,
                invocations,
            }));
        }
        if texels.is_empty() {
            return Ok(0);
        }
        self.send_jobs(gpu, &words)?;
        for steps in [texels, squares] {
            self.run(gpu, &steps)?;
            done()?;
        }
        Ok(4 * words.len() as u64)
    }

    /// The jobs of each level, from the texels up, and of the reductions.
    fn pyramid_jobs(&self, changed: &BTreeMap<usize, Rect>) -> Vec<Vec<PyramidJob>> {
        let most_levels = changed.keys().map(|face| self.levels(*face).len()).max().unwrap_or(0);
        let mut all = Vec::new();
        for level in 1..most_levels {
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

    /// Brings lists of jobs onto the device.
    fn send_jobs(&mut self, gpu: &Gpu, words: &[u32]) -> Result<()> {
        let buffer = match self.jobs.take().filter(|buffer| buffer.size() >= 4 * words.len() as u64) {
            Some(buffer) => buffer,
            None => {
                let most = gpu.info.max_binding_bytes as usize / 4;
                let room = words.len().next_power_of_two().min(most).max(words.len());
                gpu.buffer("jobs", room, wgpu::BufferUsages::empty())?
            }
        };
        gpu.guard("jobs", || gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(words)))?;
        self.jobs = Some(buffer);
        Ok(())
    }

    fn run(&self, gpu: &Gpu, steps: &[Step<'_>]) -> Result<()> {
        let Some(jobs) = &self.jobs else { return Ok(()) };
        let pipelines: HashMap<&str, _> = steps
            .iter()
            .map(|step| Ok((step.kernel.name, gpu.pipeline(step.kernel)?)))
            .collect::<Result<_, Error>>()?;
        gpu.guard("planes", || {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for step in steps {
                let Some(pipeline) = pipelines.get(step.kernel.name) else { continue };
                let list = wgpu::BufferBinding {
                    buffer: jobs,
                    offset: 4 * step.words[0] as u64,
                    size: wgpu::BufferSize::new(4 * step.words[1] as u64),
                };
                let resources = step.kernel.bindings.iter().filter_map(|binding| match binding.name {
                    "pictures" => step.pictures.map(wgpu::Buffer::as_entire_binding),
                    "tables" => Some(self.tables.as_entire_binding()),
                    "jobs" => Some(wgpu::BindingResource::Buffer(list.clone())),
                    _ => Some(self.planes.as_entire_binding()),
                });
                let group = gpu.bind_resources(pipeline, resources);
                pass.set_pipeline(&pipeline.pipeline);
                pass.set_bind_group(0, &group, &[]);
                let [x, y] = groups(step.invocations.div_ceil(step.kernel.workgroup));
                pass.dispatch_workgroups(x, y, 1);
            }
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
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

/// The part of a level of a pyramid, counted from 0, that covers a rectangle of texels.
pub fn above([left, top, width, height]: Rect, level: usize) -> Rect {
    let span = |begin: u32, length: u32| {
        let first = begin >> (level + 1);
        [first, ((begin + length - 1) >> (level + 1)) - first + 1]
    };
    let ([left, width], [top, height]) = (span(left, width.max(1)), span(top, height.max(1)));
    [left, top, width, height]
}

/// The job that writes a rectangle of a level from the level below.
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

/// Appends a list of jobs where a binding may begin; answers its first word and its words. None of an empty list.
fn list<T: Words>(words: &mut Vec<u32>, jobs: &[T], total: u32) -> Option<[usize; 2]> {
    if jobs.is_empty() {
        return None;
    }
    words.resize(words.len().next_multiple_of(ROW_WORDS as usize), 0);
    let at = words.len();
    words.extend([total, jobs.len() as u32]);
    words.extend(words_of(jobs));
    Some([at, words.len() - at])
}
