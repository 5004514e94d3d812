//! Interpolates views on a device, the same bits as on the CPU (Epipolar 3.3.2).
//!
//! Enters: source views and output views. Leaves: the output views before their holes are filled. The CPU makes the lines of source
//! pixels, which it holds in lists anyway, and sends them, some scanlines at a time. The device finds the winners of all pixels and
//! shades them; pixels with a highlight it marks, and the CPU adds that to them.

pub mod block;

use std::ops::Range;

use rayon::prelude::*;

use crate::epipolar::backend::Backend;
use crate::epipolar::counters::Counters;
use crate::epipolar::interpolate::{Coverage, InterpolatedView, Interpolator, Shader};
use crate::epipolar::lines::Line;
use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::harness::groups;
use crate::gpu::kernels::{self, Kernel};
use crate::gpu::layout::{SLICE_COLUMNS, SliceBlock, words_of};
use crate::image::Plane;
use crate::monitor::Monitor;
use block::{LineWords, color_of, coverage_of, covered, is_glossy, places, winner_of};

/// Lines that are sent at once, if one scanline does not have more: 64 MiB of lines, and as much of light.
const LINES: usize = 4 << 20;
/// Pixels of output views that are found at once, if one scanline does not have more: 64 MiB of winners, and as much of light.
const PIXELS: usize = 8 << 20;
/// Words of a winner, and of a pixel.
const PIXEL_WORDS: usize = 2;

/// Interpolates on a device.
pub struct GpuInterpolator<'a> {
    gpu: &'a Gpu,
    lines: usize,
    pixels: usize,
}

impl<'a> GpuInterpolator<'a> {
    pub fn new(gpu: &'a Gpu) -> GpuInterpolator<'a> {
        GpuInterpolator { gpu, lines: LINES, pixels: PIXELS }
    }

    /// With fewer lines and pixels of output views at once; results do not depend on it.
    pub fn with_limits(gpu: &'a Gpu, lines: usize, pixels: usize) -> GpuInterpolator<'a> {
        GpuInterpolator { gpu, lines: lines.min(LINES), pixels: pixels.min(PIXELS) }
    }

    /// Some scanlines of all views.
    fn rows(
        &self,
        of: &Interpolator<'_>,
        rows: Range<usize>,
        views: &mut NumberedViews<'_>,
        monitor: &dyn Monitor,
    ) -> Result<Counters> {
        let gpu = self.gpu;
        let width = of.views.size[0] as usize;
        let lines: Vec<(Vec<Line>, Counters)> = rows.clone().into_par_iter().map(|row| of.lines(row)).collect();
        let mut counters = Counters::default();
        lines.iter().for_each(|(_, of_row)| counters.add(of_row));
        let lines: Vec<&[Line]> = lines.iter().map(|(lines, _)| &lines[..]).collect();
        let words = LineWords::new(of, rows.start, &lines);
        let glossy =
            rows.clone().zip(&lines).map(|(row, lines)| of.has_gloss(row).then(|| Shader::new(of, lines, row)));
        let mut shaders: Vec<Option<Shader<'_>>> = glossy.collect();
        let has_gloss = shaders.iter().any(Option::is_some);
        let scanline = rows.len() * width;
        let at_once = (self.pixels / scanline).clamp(1, views.views.len().max(1));
        let buffer = |label, words| gpu.buffer(label, words, wgpu::BufferUsages::empty());
        let mut buffers = Buffers {
            block: buffer("block", SliceBlock::WORDS)?,
            starts: gpu.filled("starts", &words.starts)?,
            lines: gpu.filled("lines", &words.lines)?,
            lights: gpu.filled("lights", &words.lights)?,
            places: buffer("places", 0)?,
            winners: buffer("winners", PIXEL_WORDS * at_once * scanline)?,
            pixels: buffer("pixels", PIXEL_WORDS * at_once * scanline)?,
            fragments: buffer("fragments", at_once * rows.len())?,
        };
        let first_view = views.first;
        for (at, shown) in views.views.chunks_mut(at_once).enumerate() {
            monitor.check()?;
            let first = first_view + at * at_once;
            let range = first..first + shown.len();
            buffers.places = gpu.filled("places", &words_of(&places(of, range.clone())))?;
            let block =
                SliceBlock { width: width as u32, rows: rows.len() as u32, views: shown.len() as u32, spare: 0 };
            gpu.write("block", &buffers.block, &words_of(&[block]))?;
            gpu.write("fragments", &buffers.fragments, &vec![0; shown.len() * rows.len()])?;
            let pixel_count = shown.len() * scanline;
            let workgroups = shown.len() * rows.len() * width.div_ceil(SLICE_COLUMNS as usize);
            self.dispatch(&kernels::SLICES, &buffers, workgroups)?;
            self.dispatch(
                &kernels::LINE_LIGHT,
                &buffers,
                pixel_count.div_ceil(kernels::LINE_LIGHT.workgroup as usize),
            )?;
            let mut pixels = gpu.read(&buffers.pixels, PIXEL_WORDS * pixel_count)?;
            if has_gloss {
                let winners = gpu.read(&buffers.winners, PIXEL_WORDS * pixel_count)?;
                add_highlights(&mut shaders, range, (&mut pixels, &winners));
            }
            counters.fragments +=
                gpu.read(&buffers.fragments, shown.len() * rows.len())?.into_iter().map(u64::from).sum::<u64>();
            let strip = rows.start - of.rows.start..rows.end - of.rows.start;
            let holes = put(shown, strip, pixels.as_chunks().0);
            counters.hole_pixels += holes;
            counters.depth_tests_won += pixel_count as u64 - holes;
        }
        counters.splits = shaders.iter().flatten().map(Shader::splits).sum();
        Ok(counters)
    }

    fn dispatch(&self, kernel: &'static Kernel, buffers: &Buffers, workgroups: usize) -> Result<()> {
        let pipeline = self.gpu.pipeline(kernel)?;
        self.gpu.compute(kernel.name, |pass| {
            let group = self.gpu.bind(&pipeline, |name| Some(buffers.named(name)?.as_entire_binding()));
            pass.set_pipeline(&pipeline.pipeline);
            pass.set_bind_group(0, &group, &[]);
            let [x, y] = groups(workgroups as u32);
            pass.dispatch_workgroups(x, y, 1);
        })
    }

    /// The end of the scanlines from one on whose lines are sent at once.
    fn band_end(&self, of: &Interpolator<'_>, first: usize) -> usize {
        let lines = |row: usize| of.sources.iter().map(|source| source.rows[row].pixels.len()).sum::<usize>();
        let most = (first + (self.pixels / of.views.size[0] as usize).max(1)).min(of.rows.end);
        let mut sum = lines(first);
        let fits = |row: &usize| {
            sum += lines(*row);
            sum <= self.lines
        };
        (first + 1..most).take_while(fits).last().map_or(first + 1, |row| row + 1)
    }
}

/// Views with the number of the first.
struct NumberedViews<'v> {
    first: usize,
    views: &'v mut [InterpolatedView],
}

struct Buffers {
    block: wgpu::Buffer,
    starts: wgpu::Buffer,
    lines: wgpu::Buffer,
    lights: wgpu::Buffer,
    places: wgpu::Buffer,
    winners: wgpu::Buffer,
    pixels: wgpu::Buffer,
    fragments: wgpu::Buffer,
}

impl Buffers {
    /// The buffer of a binding.
    fn named(&self, name: &str) -> Option<&wgpu::Buffer> {
        Some(match name {
            "block" => &self.block,
            "starts" => &self.starts,
            "lines" => &self.lines,
            "lights" => &self.lights,
            "places" => &self.places,
            "winners" => &self.winners,
            "pixels" => &self.pixels,
            "fragments" => &self.fragments,
            _ => return None,
        })
    }
}

impl Backend for GpuInterpolator<'_> {
    fn views(
        &self,
        of: &Interpolator<'_>,
        range: Range<usize>,
        monitor: &dyn Monitor,
    ) -> Result<(Vec<InterpolatedView>, Counters)> {
        let [width, height] = [of.views.size[0], of.rows.len() as u32];
        let blank = || InterpolatedView {
            color: Plane::filled(width, height, Default::default()),
            coverage: Plane::filled(width, height, Coverage::Hole),
        };
        let mut views: Vec<InterpolatedView> = range.clone().map(|_| blank()).collect();
        let mut counters = Counters::default();
        let mut first = of.rows.start;
        while first < of.rows.end {
            let rows = first..self.band_end(of, first);
            first = rows.end;
            let count = rows.len() as u64;
            let mut shown = NumberedViews { first: range.start, views: &mut views };
            counters.add(&self.rows(of, rows, &mut shown, monitor)?);
            monitor.advance(count);
        }
        Ok((views, counters))
    }
}

/// Adds highlights to the pixels that lack them: of scanlines, of all views in a range.
fn add_highlights(shaders: &mut [Option<Shader<'_>>], views: Range<usize>, (pixels, winners): (&mut [u32], &[u32])) {
    let words = (pixels.len() / shaders.len()).max(1);
    let rows = shaders.par_iter_mut().zip(pixels.par_chunks_mut(words).zip(winners.par_chunks(words)));
    rows.for_each(|(shader, (pixels, winners))| {
        let Some(shader) = shader else { return };
        let (pixels, winners) = (pixels.as_chunks_mut().0, winners.as_chunks().0);
        let width = pixels.len() / views.len();
        for (at, (pixel, winner)) in pixels.iter_mut().zip(winners).enumerate() {
            if is_glossy(*pixel) {
                *pixel = covered(shader.pixel(winner_of(*winner), views.start + at / width).0);
            }
        }
    });
}

/// Puts scanlines into views; answers the number of holes.
fn put(views: &mut [InterpolatedView], rows: Range<usize>, pixels: &[[u32; PIXEL_WORDS]]) -> u64 {
    let count = views.len();
    let of_view = |(number, view): (usize, &mut InterpolatedView)| {
        let width = view.color.width() as usize;
        for (at, row) in rows.clone().enumerate() {
            let start = (at * count + number) * width;
            let shown = &pixels[start..start + width];
            let colors = view.color.row_mut(row as u32).iter_mut().zip(shown);
            colors.for_each(|(color, shown)| *color = color_of(*shown));
            let coverage = view.coverage.row_mut(row as u32).iter_mut().zip(shown);
            coverage.for_each(|(coverage, shown)| *coverage = coverage_of(*shown));
        }
        let band = &view.coverage.data()[rows.start * width..rows.end * width];
        band.iter().filter(|coverage| **coverage == Coverage::Hole).count() as u64
    };
    views.par_iter_mut().enumerate().map(of_view).sum()
}
