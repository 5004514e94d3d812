//! Interpolates views on a device (Epipolar 3.3.2).
//!
//! Takes source views and output views; returns the output views before their holes are filled. The CPU makes the lines of
//! source pixels, which it stores as lists, and sends them a few scanlines at a time. The device finds the winners of all
//! pixels, shades them, and marks the lines whose highlights are visible. The CPU places splits for these lines, and the device
//! interpolates highlights between the splits in single precision. Everything but highlights is bit-exact with the CPU.

pub mod block;
pub mod highlights;

use std::ops::Range;

use rayon::prelude::*;

use crate::Gpu;
use crate::harness::dispatch;
use block::{LineWords, color_of, coverage_of, places};
use codec::error::Result;
use codec::image::Plane;
use codec::monitor::Monitor;
use epipolar::backend::Backend;
use epipolar::coalesce::LineRuns;
use epipolar::counters::Counters;
use epipolar::erosion::Moves;
use epipolar::interpolate::{Coverage, InterpolatedView, Interpolator};
use epipolar::stages::Lap;
use highlights::{Highlights, SplitWords};
use kernels::layout::{PixelRows, SLICE_COLUMNS, SliceBlock, words_of};

/// Maximum lines that are sent at once; a single scanline may have more. At most 64 MiB of runs, and as much of radiance.
const LINES: usize = 4 << 20;
/// Maximum splits that are sent at once; a single scanline may have more. 64 MiB.
const SPLITS: usize = 4 << 20;
/// Maximum output pixels that are processed at once; a single scanline may have more. 64 MiB of winners, and as much of
/// colours.
const PIXELS: usize = 8 << 20;
/// Maximum pixels whose moves are processed at once; a single scanline may have more. 32 MiB of moves, and as much of edge counts.
const MOVES: usize = 8 << 20;
/// Words per winner, and per pixel.
const PIXEL_WORDS: usize = 2;

/// Interpolates views on a device.
pub struct GpuInterpolator<'a> {
    gpu: &'a Gpu,
    lines: usize,
    pixels: usize,
}

impl<'a> GpuInterpolator<'a> {
    pub fn new(gpu: &'a Gpu) -> GpuInterpolator<'a> {
        GpuInterpolator { gpu, lines: LINES, pixels: PIXELS }
    }

    /// Lowers the limits of lines and output pixels per batch. The results do not depend on them.
    pub fn with_limits(gpu: &'a Gpu, lines: usize, pixels: usize) -> GpuInterpolator<'a> {
        GpuInterpolator { gpu, lines: lines.min(LINES), pixels: pixels.min(PIXELS) }
    }

    /// Interpolates some scanlines of all views.
    fn rows(
        &self,
        of: &Interpolator<'_>,
        rows: Range<usize>,
        views: &mut NumberedViews<'_>,
        monitor: &dyn Monitor,
    ) -> Result<Counters> {
        let gpu = self.gpu;
        let width = of.views.size[0] as usize;
        let mut lap = Lap::begin();
        let lines: Vec<(LineRuns, Counters)> = rows.clone().into_par_iter().map(|row| of.lines(row)).collect();
        let mut counters = Counters::default();
        lines.iter().for_each(|(_, of_row)| counters.add(of_row));
        let lines: Vec<&LineRuns> = lines.iter().map(|(lines, _)| lines).collect();
        let words = LineWords::new(of, rows.start, &lines);
        counters.threads.filter += lap.time();
        let mut highlights = Highlights::new(of, rows.start, &lines);
        let line_count = words.depths.len();
        let scanline = rows.len() * width;
        let at_once = (self.pixels / scanline).clamp(1, views.views.len().max(1));
        let buffer = |label, words| gpu.buffer(label, words, wgpu::BufferUsages::empty());
        let mut buffers = Buffers {
            block: buffer("block", SliceBlock::WORDS)?,
            starts: gpu.filled("starts", &words.starts)?,
            run_starts: gpu.filled("run_starts", &words.run_starts)?,
            runs: gpu.filled("runs", &words.runs)?,
            depths: gpu.filled("depths", &words.depths)?,
            lights: gpu.filled("lights", &words.lights)?,
            places: buffer("places", 0)?,
            winners: buffer("winners", PIXEL_WORDS * at_once * scanline)?,
            pixels: buffer("pixels", PIXEL_WORDS * at_once * scanline)?,
            fragments: buffer("fragments", at_once * rows.len())?,
            wanted: buffer("wanted", line_count.div_ceil(32))?,
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
            dispatch(gpu, &kernels::SLICES, workgroups, |name| buffers.named(name))?;
            let workgroups = pixel_count.div_ceil(kernels::LINE_LIGHT.workgroup as usize);
            dispatch(gpu, &kernels::LINE_LIGHT, workgroups, |name| buffers.named(name))?;
            if let Some(highlights) = &mut highlights {
                let wanted = gpu.read(&buffers.wanted, line_count.div_ceil(32))?;
                counters.threads.interpolate += lap.time();
                let splits = highlights.words(&wanted);
                if !splits.splits.is_empty() {
                    let eyes: Vec<f32> = range.map(|view| of.eye_place(view) as f32).collect();
                    add_highlights(gpu, &buffers, workgroups, (&splits, &eyes))?;
                }
                counters.threads.light += lap.time();
            }
            let pixels = gpu.read(&buffers.pixels, PIXEL_WORDS * pixel_count)?;
            counters.fragments +=
                gpu.read(&buffers.fragments, shown.len() * rows.len())?.into_iter().map(u64::from).sum::<u64>();
            let strip = rows.start - of.rows.start..rows.end - of.rows.start;
            let holes = put(shown, strip, pixels.as_chunks().0);
            counters.hole_pixels += holes;
            counters.depth_tests_won += pixel_count as u64 - holes;
        }
        counters.threads.interpolate += lap.time();
        counters.splits = highlights.map_or(0, |highlights| highlights.splits());
        Ok(counters)
    }

    /// Returns the end of the scanlines, starting at `first`, whose lines are sent together.
    fn band_end(&self, of: &Interpolator<'_>, first: usize) -> usize {
        let lines = |row: usize| of.sources.iter().map(|source| source.rows[row].pixels.len()).sum::<usize>();
        let most = (first + (self.pixels / of.views.size[0] as usize).max(1)).min(of.rows.end);
        let splits = |row: usize| {
            let glossy = of.sources.iter().map(|source| source.rows[row].gloss.len()).sum::<usize>();
            glossy.saturating_mul(of.max_splits())
        };
        let (mut line_sum, mut split_sum) = (lines(first), splits(first));
        let fits = |row: &usize| {
            line_sum += lines(*row);
            split_sum = split_sum.saturating_add(splits(*row));
            line_sum <= self.lines && split_sum <= SPLITS
        };
        (first + 1..most).take_while(fits).last().map_or(first + 1, |row| row + 1)
    }
}

/// Views, and the index of the first one.
struct NumberedViews<'v> {
    first: usize,
    views: &'v mut [InterpolatedView],
}

struct Buffers {
    block: wgpu::Buffer,
    starts: wgpu::Buffer,
    run_starts: wgpu::Buffer,
    runs: wgpu::Buffer,
    depths: wgpu::Buffer,
    lights: wgpu::Buffer,
    places: wgpu::Buffer,
    winners: wgpu::Buffer,
    pixels: wgpu::Buffer,
    fragments: wgpu::Buffer,
    wanted: wgpu::Buffer,
}

impl Buffers {
    /// Returns the buffer of a binding.
    fn named(&self, name: &str) -> Option<&wgpu::Buffer> {
        Some(match name {
            "block" => &self.block,
            "starts" => &self.starts,
            "run_starts" => &self.run_starts,
            "runs" => &self.runs,
            "depths" => &self.depths,
            "lights" => &self.lights,
            "places" => &self.places,
            "winners" => &self.winners,
            "pixels" => &self.pixels,
            "fragments" => &self.fragments,
            "wanted" => &self.wanted,
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

    fn eroded(&self, moves: &Moves) -> Result<u64> {
        eroded(self.gpu, moves)
    }
}

/// Adds highlights to the pixels marked `SHOWN_GLOSS`; `eyes` are the positions of the views.
fn add_highlights(
    gpu: &Gpu,
    buffers: &Buffers,
    workgroups: usize,
    (splits, eyes): (&SplitWords, &[f32]),
) -> Result<()> {
    let split_starts = gpu.filled("split_starts", &splits.starts)?;
    let eyes = gpu.filled("eyes", &words_of(eyes))?;
    let splits = gpu.filled("splits", &splits.splits)?;
    dispatch(gpu, &kernels::LINE_HIGHLIGHTS, workgroups, |name| match name {
        "split_starts" => Some(&split_starts),
        "splits" => Some(&splits),
        "eyes" => Some(&eyes),
        other => buffers.named(other),
    })
}

/// Stores scanlines in the views; returns the number of holes.
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

/// Computes [`Moves::eroded`] on a device (Epipolar 3.3.1).
fn eroded(gpu: &Gpu, moves: &Moves) -> Result<u64> {
    let at_once = (MOVES / moves.width.max(1)).max(1) * moves.width;
    let parts = moves.columns.chunks(at_once.max(1)).map(|part| eroded_rows(gpu, part, moves.width));
    parts.sum()
}

fn eroded_rows(gpu: &Gpu, moves: &[i32], width: usize) -> Result<u64> {
    let rows = moves.len() / width;
    let block = PixelRows { width: width as u32, rows: rows as u32, stride: width as u32, spare: 0 };
    let buffer = |label, words| gpu.buffer(label, words, wgpu::BufferUsages::empty());
    let block = gpu.filled("block", &words_of(&[block]))?;
    let edges = buffer("edges", moves.len())?;
    let eroded = buffer("eroded", rows)?;
    let moves = gpu.filled("moves", &words_of(moves))?;
    let named = |name: &str| match name {
        "block" => Some(&block),
        "moves" => Some(&moves),
        "edges" => Some(&edges),
        "eroded" => Some(&eroded),
        _ => None,
    };
    dispatch(gpu, &kernels::EROSION_EDGES, rows, named)?;
    dispatch(gpu, &kernels::EROSION, rows, named)?;
    Ok(gpu.read(&eroded, rows)?.into_iter().map(u64::from).sum())
}
