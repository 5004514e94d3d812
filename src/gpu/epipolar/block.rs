//! Data of epipolar slices, as words that kernels read and write.

use std::ops::Range;

use half::f16;
use rayon::prelude::*;

use epipolar::coalesce::{LineRuns, Run};
use epipolar::interpolate::{Coverage, Interpolator};
use epipolar::source::{Light, SourcePixel};
use kernels::layout::{
    LIGHT_GLOSS, LIGHT_TRACED, LineLight, RUN_FIRST, RUN_JOINS, RUN_LENGTH_BITS, SHOWN_HOLE, SHOWN_OPTICAL, SlicePlace,
    SliceRun, words_of,
};
use kernels::pictures::{pack_halves, unpack_halves};

/// Lines of some scanlines, and their runs.
#[derive(Debug, Default)]
pub struct LineWords {
    /// Index of each scanline's first line, then the total.
    pub starts: Vec<u32>,
    /// Index of each scanline's first run, then the total.
    pub run_starts: Vec<u32>,
    /// Words of [`SliceRun`]s.
    pub runs: Vec<u32>,
    /// Bits of the planar distance of each line.
    pub depths: Vec<u32>,
    /// Words of [`LineLight`]s.
    pub lights: Vec<u32>,
}

impl LineWords {
    /// Converts consecutive scanlines, starting at `first_row`.
    pub fn new(of: &Interpolator<'_>, first_row: usize, rows: &[&LineRuns]) -> LineWords {
        let words = |(at, of_row): (usize, &&LineRuns)| {
            let lights = of_row.lines.iter().map(|line| light_of(of.source_pixel(first_row + at, line)));
            let lights: Vec<LineLight> = lights.collect();
            [words_of(&of_row.runs.iter().map(slice_run).collect::<Vec<_>>()), words_of(&lights)]
        };
        let words: Vec<[Vec<u32>; 2]> = rows.par_iter().enumerate().map(words).collect();
        let mut all = LineWords { starts: vec![0], run_starts: vec![0], ..LineWords::default() };
        for (of_row, [runs, lights]) in rows.iter().zip(words) {
            all.depths.extend(of_row.lines.iter().map(|line| line.depth));
            all.runs.extend(runs);
            all.lights.extend(lights);
            all.starts.push(all.depths.len() as u32);
            all.run_starts.push((all.runs.len() / SliceRun::WORDS) as u32);
        }
        all
    }
}

fn slice_run(run: &Run) -> SliceRun {
    let flag = |is_set: bool, bit: u32| if is_set { bit } else { 0 };
    let flags = flag(run.joins_next, RUN_JOINS) | flag(run.is_first, RUN_FIRST);
    SliceRun {
        column: run.column,
        disparity: run.disparity,
        first: run.first,
        flags: u32::from(run.source) | flags | run.length << RUN_LENGTH_BITS,
    }
}

fn light_of(pixel: &SourcePixel) -> LineLight {
    let kind = match pixel.light {
        Light::Steady => 0,
        Light::Gloss(_) => LIGHT_GLOSS,
        Light::Traced => LIGHT_TRACED,
    };
    let [[steady_rg, steady_b], [own_rg, own_b]] = [pixel.steady, pixel.own].map(|light| pack_halves(bits(light)));
    LineLight { steady_rg, steady_b: steady_b | kind << 16, own_rg, own_b }
}

fn bits(light: [f16; 3]) -> [u16; 3] {
    light.map(f16::to_bits)
}

/// Returns the offsets of some views from each source, ordered by source.
pub fn places(of: &Interpolator<'_>, views: Range<usize>) -> Vec<SlicePlace> {
    let place = |(source, view): (usize, usize)| {
        let place = of.space.place(source, view);
        SlicePlace { place, bias: of.space.bias_at(place) }
    };
    (0..of.sources.len()).flat_map(|source| views.clone().map(move |view| (source, view))).map(place).collect()
}

/// Returns the linear RGB of a pixel.
pub fn color_of(pixel: [u32; 2]) -> [f16; 3] {
    unpack_halves(pixel).map(f16::from_bits)
}

pub fn coverage_of([_, rest]: [u32; 2]) -> Coverage {
    match rest >> 16 {
        SHOWN_HOLE => Coverage::Hole,
        SHOWN_OPTICAL => Coverage::Optical,
        _ => Coverage::Covered,
    }
}

/// Returns the words of a covered pixel without a pending highlight.
pub fn covered(color: [f16; 3]) -> [u32; 2] {
    pack_halves(bits(color))
}
