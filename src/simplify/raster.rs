//! Rasteriser of a textured mesh on the CPU (Seurat 6). It draws every triangle from both sides, in the order of the mesh, and
//! samples the texture bilinearly in linear RGB.
//!
//! [`Compositing::Painter`] blends each triangle over those before it. The implementation draws triangles from the last to the
//! first, each behind the existing ones, which gives the same picture and skips what an opaque triangle hides; [`draw_plainly`]
//! blends in order. Triangles that share an edge cover each sample at that edge exactly once.
//!
//! [`alpha::AlphaRaster`] draws only alpha: whether pixels are covered.
//!
//! [`Compositing::ZBuffer`] shows the nearest triangle at each sample among those whose alpha covers the sample (alpha to
//! coverage): the samples of a pixel have thresholds that are spread evenly over 0..1.

pub mod alpha;
mod plain;
mod texels;
mod triangle;

use glam::Vec4;
use rayon::prelude::*;

use super::quad_mesh::QuadMesh;
use codec::error::Result;
use codec::image::plane::Plane;
use codec::math::Camera;
use codec::monitor::Monitor;

pub use plain::{Drawn, draw_plainly};
use texels::Texels;
pub use texels::{light_of_codes, texture_coordinates};
use triangle::{Pixels, Triangle};

/// Number of rows that one job draws.
const ROWS_A_JOB: u32 = 16;
/// Transmittance of a pixel below which nothing behind it is visible: 1/257 of an 8-bit step.
const MIN_OPEN: f32 = 1.0 / 65_536.0;

/// Number of low bits of a single-precision inverse depth that a z-buffer ignores. 13 bits of the mantissa remain, 0.01%.
pub const DEPTH_BITS_LEFT_OUT: u32 = 10;

/// Rule by which triangles hide each other.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Compositing {
    /// Each triangle is blended over those before it.
    #[default]
    Painter,
    /// The nearest triangle hides the others; of those within 0.01% of the same distance, the last.
    ZBuffer,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawSettings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub compositing: Compositing,
    /// Number of samples in each row and column of a pixel, at least 1.
    pub samples: u32,
}

/// One sample of each pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Position in the pixel, 0..1 to the right and down.
    pub offset: [f64; 2],
    /// A texel covers the sample if its alpha is above this threshold.
    pub threshold: f32,
}

impl DrawSettings {
    /// Returns the samples of a pixel: the centres of a regular grid. Their thresholds are a permutation in which neighbours
    /// differ, as in ordered dithering.
    pub fn samples(&self) -> Vec<Sample> {
        let side = self.samples.max(1);
        let place = |at: u32| (f64::from(at) + 0.5) / f64::from(side);
        let sample = |at: u32| {
            let (x, y) = (at % side, at / side);
            let rank = x + side * ((x + y) % side);
            let threshold = (f64::from(rank) + 0.5) / f64::from(side * side);
            Sample { offset: [place(x), place(y)], threshold: threshold as f32 }
        };
        (0..side * side).map(sample).collect()
    }
}

/// Draws the mesh over a transparent picture, in order, with one sample at the centre of each pixel.
pub fn draw(scene: &QuadMesh, camera: &Camera, size: [u32; 2]) -> Drawn {
    let settings = DrawSettings { size, compositing: Compositing::Painter, samples: 1 };
    let (raster, texels) = (Raster::new(scene, camera, &settings), Texels::new(scene));
    Drawn::of_rows(raster.jobs().map(|job| raster.rows(job, &texels)).collect())
}

/// Returns the number of triangles over the centre of each pixel.
pub fn overdraw(scene: &QuadMesh, camera: &Camera, size: [u32; 2]) -> Result<Plane<u32>> {
    let settings = DrawSettings { size, compositing: Compositing::Painter, samples: 1 };
    let (raster, texels) = (Raster::new(scene, camera, &settings), Texels::new(scene));
    let counts: Vec<Vec<u32>> = raster.jobs().map(|job| raster.rows(job, &texels).1).collect();
    Plane::new(size[0], size[1], counts.concat())
}

/// Draws the mesh over a transparent picture. The monitor advances by one per row.
pub fn draw_picture(
    scene: &QuadMesh,
    camera: &Camera,
    settings: &DrawSettings,
    monitor: &dyn Monitor,
) -> Result<Drawn> {
    monitor.check()?;
    let (raster, texels) = (Raster::new(scene, camera, settings), Texels::new(scene));
    let rows = raster.jobs().map(|job| {
        monitor.check()?;
        let rows = raster.rows(job, &texels);
        monitor.advance(u64::from(raster.rows_of(job)[1] - raster.rows_of(job)[0]));
        Ok(rows)
    });
    Ok(Drawn::of_rows(rows.collect::<Result<_>>()?))
}

/// Returns the bytes of memory that drawing a picture takes.
pub fn drawing_bytes(scene: &QuadMesh, settings: &DrawSettings) -> u64 {
    let [width, height] = settings.size.map(u64::from);
    let samples = u64::from(settings.samples).pow(2);
    // Corners, projected triangles, and their indices in the lists of jobs: for most triangles, two.
    let of_mesh = 24 * scene.mesh.positions.len() as u64
        + scene.mesh.triangles.len() as u64 * (size_of::<Triangle>() as u64 + 16);
    // The sum of a pixel and the counts of its samples stay in memory until the end.
    of_mesh.saturating_add((width * height).saturating_mul(32 + 4 * samples))
}

/// Returns the value that a z-buffer compares: an inverse depth above 0 without the low bits of its mantissa. Overlapping tiles
/// lie along nearly the same surface, where rounding would decide, differently on each device; with equal values the later tile
/// is visible.
fn nearness(inverse_depth: f32) -> u32 {
    inverse_depth.to_bits() >> DEPTH_BITS_LEFT_OUT
}

/// Projected triangles of a picture, and the job of each.
struct Raster {
    settings: DrawSettings,
    samples: Vec<Sample>,
    /// Visible triangles, in order.
    triangles: Vec<Triangle>,
    /// Indices of the triangles of each job.
    of_job: Vec<Vec<u32>>,
}

impl Raster {
    fn new(scene: &QuadMesh, camera: &Camera, settings: &DrawSettings) -> Raster {
        let pixels = Pixels::new(camera, settings.size);
        let mesh = &scene.mesh;
        let corners: Vec<_> = mesh.positions.par_iter().map(|&point| pixels.seen_from_eye(point)).collect();
        let kinds = scene.runs.iter().zip([false, true].into_iter().cycle());
        let is_opaque: Vec<bool> =
            kinds.flat_map(|(&count, is_opaque)| std::iter::repeat_n(is_opaque, count as usize)).collect();
        let see = |(at, triangle): (usize, &[u32; 3])| {
            let stq = triangle.map(|corner| texture_coordinates(scene, corner));
            let mut seen = Triangle::new(&triangle.map(|corner| corners[corner as usize]), stq, &pixels)?;
            seen.is_opaque = is_opaque.get(at).copied().unwrap_or(false);
            Some(seen)
        };
        let triangles: Vec<Triangle> = mesh.triangles.par_iter().enumerate().filter_map(see).collect();
        let mut of_job = vec![Vec::new(); settings.size[1].div_ceil(ROWS_A_JOB) as usize];
        for (at, triangle) in (0..).zip(&triangles) {
            let [first, end] = triangle.rows;
            of_job[(first / ROWS_A_JOB) as usize..end.div_ceil(ROWS_A_JOB) as usize]
                .iter_mut()
                .for_each(|list| list.push(at));
        }
        Raster { settings: *settings, samples: settings.samples(), triangles, of_job }
    }

    fn jobs(&self) -> impl IndexedParallelIterator<Item = usize> {
        (0..self.of_job.len()).into_par_iter()
    }

    /// Returns the first and the end row of a job.
    fn rows_of(&self, job: usize) -> [u32; 2] {
        let first = job as u32 * ROWS_A_JOB;
        [first, (first + ROWS_A_JOB).min(self.settings.size[1])]
    }

    /// Returns the pixels of a job, and the number of triangles over each of their samples.
    fn rows(&self, job: usize, texels: &Texels) -> (Vec<Vec4>, Vec<u32>) {
        let [first, end] = self.rows_of(job);
        let pixels = self.settings.size[0] as usize * (end - first) as usize;
        let draw = match self.settings.compositing {
            Compositing::Painter => Self::blend,
            Compositing::ZBuffer => Self::hide,
        };
        let mut counts = vec![0u32; pixels * self.samples.len()];
        let mut sums = vec![Vec4::ZERO; pixels];
        for (sample, counts) in self.samples.iter().zip(counts.chunks_exact_mut(pixels.max(1))) {
            let drawn = draw(self, job, texels, sample, counts);
            sums.iter_mut().zip(drawn).for_each(|(sum, pixel)| *sum += pixel);
        }
        if self.samples.len() > 1 {
            let share = 1.0 / self.samples.len() as f32;
            sums.iter_mut().for_each(|sum| *sum *= share);
        }
        (sums, counts)
    }

    /// Calls `shade` for each row of each triangle of a job, starting with the last triangle. The arguments are the triangle, the
    /// y coordinate of the samples, the columns that the triangle covers, and the index of the first of these pixels in the job.
    fn spans(&self, job: usize, sample: &Sample, mut shade: impl FnMut(&Triangle, f64, std::ops::Range<u32>, usize)) {
        let ([first, end], width) = (self.rows_of(job), self.settings.size[0]);
        for &at in self.of_job[job].iter().rev() {
            let triangle = &self.triangles[at as usize];
            for row in triangle.rows[0].max(first)..triangle.rows[1].min(end) {
                let span = triangle.span(row, width, sample.offset);
                if !span.is_empty() {
                    let place = (row - first) as usize * width as usize + span.start as usize;
                    shade(triangle, f64::from(row) + sample.offset[1], span, place);
                }
            }
        }
    }

    /// Blends triangles behind the existing ones.
    fn blend(&self, job: usize, texels: &Texels, sample: &Sample, counts: &mut [u32]) -> Vec<Vec4> {
        let mut pixels = vec![Vec4::ZERO; counts.len()];
        self.spans(job, sample, |triangle, y, span, place| {
            let [s, t, q] = triangle.stq.map(|axis| axis.row(y));
            let range = place..place + span.len();
            counts[range.clone()].iter_mut().for_each(|count| *count += 1);
            for (x, pixel) in span.zip(&mut pixels[range]) {
                let open = 1.0 - pixel.w;
                if open < MIN_OPEN {
                    continue;
                }
                let x = f64::from(x) + sample.offset[0];
                let scale = 1.0 / q.at(x);
                let texel = texels.sample([s.at(x) * scale, t.at(x) * scale]);
                let share = open * texel.w;
                *pixel += (texel * share).truncate().extend(share);
            }
        });
        pixels
    }

    /// Draws the nearest triangle that covers each sample.
    fn hide(&self, job: usize, texels: &Texels, sample: &Sample, counts: &mut [u32]) -> Vec<Vec4> {
        let mut pixels = vec![Vec4::ZERO; counts.len()];
        let mut nearest = vec![0u32; counts.len()];
        self.spans(job, sample, |triangle, y, span, place| {
            let (sum, [s, t, q]) = (triangle.sum.row(y), triangle.stq.map(|axis| axis.row(y)));
            let range = place..place + span.len();
            counts[range.clone()].iter_mut().for_each(|count| *count += 1);
            for ((x, pixel), nearest) in span.zip(&mut pixels[range.clone()]).zip(&mut nearest[range]) {
                let x = f64::from(x) + sample.offset[0];
                let nearness = nearness((sum.at(x) / triangle.volume) as f32);
                if nearness <= *nearest {
                    continue;
                }
                let scale = 1.0 / q.at(x);
                let texel = texels.sample([s.at(x) * scale, t.at(x) * scale]);
                if texel.w > sample.threshold {
                    *nearest = nearness;
                    *pixel = texel.truncate().extend(1.0);
                }
            }
        });
        pixels
    }
}

#[cfg(test)]
mod tests;
