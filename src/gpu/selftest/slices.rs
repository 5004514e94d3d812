//! Inputs of the kernels of epipolar slices: random surfaces, in views of many widths, from sources at and around them; and
//! comparison of whole views of given sources.

use std::collections::HashMap;

use glam::DVec3;
use half::f16;

use crate::epipolar::GpuInterpolator;
use crate::epipolar::block::{LineWords, covered, places};
use crate::harness::Case;
use crate::render::agreement::Agreement;
use codec::error::Result;
use codec::math::random::Random;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use epipolar::backend::{Backend, Cpu};
use epipolar::coalesce::{Coalescing, LineRuns};
use epipolar::counters::Counters;
use epipolar::fill::picture;
use epipolar::interpolate::{Coverage, InterpolateSettings, InterpolatedView, Interpolator, Shader};
use epipolar::lines::Line;
use epipolar::slice::{Slice, Winner};
use epipolar::source::{Light, SourcePixel, SourceRow, SourceView};
use epipolar::views::{OutputViews, Spread};
use kernels::layout::{
    NONE, SHOWN_GLOSS, SHOWN_HOLE, SHOWN_OPTICAL, SLICE_COLUMNS, SLICE_WORKGROUP, SliceBlock, WINNER_AFTER,
    WINNER_BEFORE, WINNER_OWN, words_of,
};

/// Output views and their sources.
#[derive(Debug, Clone)]
pub struct InterpolationCase {
    pub label: String,
    pub views: OutputViews,
    pub sources: Vec<SourceView>,
    pub settings: InterpolateSettings,
}

/// Differences between views of a device and of the CPU.
#[derive(Debug, Clone, Default)]
pub struct InterpolationResult {
    /// Pixels with different colour or coverage, and differing counters; for views with highlights, also pixels outside the
    /// tolerance.
    pub mismatches: u64,
    pub first: Option<String>,
}

impl InterpolationResult {
    fn differ(&mut self, count: u64, place: impl FnOnce() -> String) {
        self.mismatches += count;
        if count > 0 {
            self.first.get_or_insert_with(place);
        }
    }
}

/// Interpolates all views on a device and on the CPU. Without highlights all bits must be equal; with highlights the views must
/// agree within tolerances.
pub fn run(on_device: &GpuInterpolator<'_>, case: &InterpolationCase) -> Result<InterpolationResult> {
    let mut result = InterpolationResult::default();
    let is_glossy = case.sources.iter().flat_map(|source| &source.rows).any(|row| !row.gloss.is_empty());
    let steady = on_both(on_device, case, &without_highlights(&case.sources), &mut result)?;
    for (view, [found, expected]) in steady.iter().enumerate() {
        for (pixel, (found, expected)) in pixels(found).iter().zip(pixels(expected)).enumerate() {
            let place = || format!("{}: view {view}, pixel {pixel} is {found:x?} and not {expected:x?}", case.label);
            result.differ(u64::from(*found != expected), place);
        }
    }
    let shown = if is_glossy { on_both(on_device, case, &case.sources, &mut result)? } else { Vec::new() };
    for (view, [found, expected]) in shown.iter().enumerate() {
        let [found, expected] = [picture(found)?, picture(expected)?];
        let agreement = Agreement::of_images(&found, &expected, [0; 2])?;
        result.differ(agreement.mismatches(), || format!("{}: view {view}: {agreement:?}", case.label));
    }
    Ok(result)
}

/// Interpolates on a device and on the CPU; the counters must be equal.
fn on_both(
    on_device: &GpuInterpolator<'_>,
    case: &InterpolationCase,
    sources: &[SourceView],
    result: &mut InterpolationResult,
) -> Result<Vec<[InterpolatedView; 2]>> {
    let of = Interpolator::new(&case.views, sources, case.settings);
    let all = 0..case.views.offsets_m.len();
    let (found, counted) = on_device.views(&of, all.clone(), &Silent)?;
    let (expected, mut counters) = Cpu.views(&of, all, &Silent)?;
    counters.threads = counted.threads;
    // A device processes fragments in no defined order, so these counters do not exist there.
    let pixels = case.views.size.iter().map(|&side| u64::from(side)).product::<u64>() * expected.len() as u64;
    (counters.depth_tests_won, counters.pixels_by_layer) = (pixels - counters.hole_pixels, Default::default());
    let differs = counted != counters || found.len() != expected.len();
    result.differ(u64::from(differs), || format!("{}: {counted:?} and not {counters:?}", case.label));
    Ok(found.into_iter().zip(expected).map(|(found, expected)| [found, expected]).collect())
}

fn without_highlights(sources: &[SourceView]) -> Vec<SourceView> {
    let mut sources = sources.to_vec();
    for row in sources.iter_mut().flat_map(|source| &mut source.rows) {
        row.gloss.clear();
        for pixel in &mut row.pixels {
            pixel.light = if pixel.light == Light::Traced { Light::Traced } else { Light::Steady };
        }
    }
    sources
}

fn pixels(view: &InterpolatedView) -> Vec<([u16; 3], Coverage)> {
    let bits = view.color.data().iter().map(|light| light.map(f16::to_bits));
    bits.zip(view.coverage.data().iter().copied()).collect()
}

/// Widths and numbers of views: one, odd, and around the size of a workgroup.
const SIZES: [(u32, u32); 12] = [
    (1, 1),
    (1, 9),
    (3, 2),
    (33, 5),
    (255, 3),
    (256, 1),
    (257, 2),
    (1023, 2),
    (1024, 3),
    (1025, 2),
    (2600, 3),
    (480, 40),
];
const ROWS: usize = 7;

/// Creates random sources for each size; one row is empty. The last case has many lines.
fn inputs(seed: u64) -> Vec<InterpolationCase> {
    let mut random = Random::new(seed);
    let case = |(at, &(width, count)): (usize, &(u32, u32))| -> Result<InterpolationCase> {
        let baseline_m = [0.5, 0.0, 3.0, 0.02][at % 4];
        let focus_m = if at % 3 == 0 { f64::INFINITY } else { 2.5 };
        let views = views([width, ROWS as u32], count, baseline_m, focus_m)?;
        // At the views, between them, and beyond them.
        let offsets_m = [0.5, -0.5, 0.1, -7.0, 90.0].map(|part: f64| part * baseline_m.max(0.01));
        let sources = (0..at % 5 + usize::from(at == 11)).map(|source| {
            let rows = (0..ROWS).map(|row| if row == 3 { SourceRow::default() } else { row_of(width, &mut random) });
            SourceView { offset_m: offsets_m[source], rows: rows.collect(), layers: 3 }
        });
        let sources = sources.collect();
        let settings = InterpolateSettings {
            coalesce: [Coalescing::Off, Coalescing::Disparity(0.7)][at % 2],
            ..InterpolateSettings::default()
        };
        Ok(InterpolationCase { label: format!("{count} views, {width} wide"), views, sources, settings })
    };
    SIZES.iter().enumerate().map(case).filter_map(Result::ok).collect()
}

fn views(size: [u32; 2], count: u32, baseline_m: f64, focus_m: f64) -> Result<OutputViews> {
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, Lens::new(20.0))?;
    let camera = camera.with_aspect(f64::from(size[0]) / f64::from(size[1]));
    OutputViews::new(camera, size, count, Spread::Baseline(baseline_m), focus_m)
}

/// Creates a row with three layers of surfaces: flat, slanted, at an extreme distance, or missing.
fn row_of(width: u32, random: &mut Random) -> SourceRow {
    const EXTREMES: [f32; 5] = [f32::MIN_POSITIVE, 1e-6, 1e12, f32::MAX, f32::INFINITY];
    let mut pixels = Vec::new();
    for layer in 0..3 {
        let (mut column, end) = (-(width as i32) / 2, width as i32 * 3 / 2 + 1);
        while column < end {
            let length = 1 + random.below(1 + width.min(90)) as i32;
            let near = 0.4 + random.below(1000) as f32 / 300.0;
            let slope = if random.one_in(2) { random.below(1000) as f32 / 9e3 } else { 0.0 };
            let extreme = random.one_in(6).then(|| random.pick(&EXTREMES)).flatten();
            if layer == 0 || random.one_in(3) {
                let pixel = |at: i32, random: &mut Random| SourcePixel {
                    column: column + at,
                    depth_m: extreme.unwrap_or(1.0 / (1.0 / near + slope * at as f32)),
                    layer,
                    light: [Light::Steady, Light::Steady, Light::Gloss(0), Light::Traced][random.below(4) as usize],
                    steady: half_floats(random),
                    own: half_floats(random),
                };
                pixels.extend((0..length.min(end - column)).map(|at| pixel(at, random)));
            }
            column += length;
        }
    }
    SourceRow { pixels, gloss: Vec::new() }
}

fn half_floats(random: &mut Random) -> [f16; 3] {
    std::array::from_fn(|_| f16::from_bits(random.word() as u16))
}

/// The winner of a pixel, and its two words.
struct Expected {
    winner: Option<Winner>,
    words: [u32; 2],
}

/// Calls `of_pixel` for all pixels of all views in the order of the kernels, with the CPU's winners. Returns the kernels'
/// input, the number of pixels that the lines of each scanline cover, and the number of pixels.
fn dispatch(
    input: &InterpolationCase,
    mut of_pixel: impl FnMut(&Interpolator<'_>, (usize, usize), &[Line], &Expected),
) -> (HashMap<&'static str, Vec<u32>>, Vec<u32>, u64) {
    let of = Interpolator::new(&input.views, &input.sources, input.settings);
    let lines: Vec<LineRuns> = (0..ROWS).map(|row| of.lines(row).0).collect();
    let words = LineWords::new(&of, 0, &lines.iter().collect::<Vec<_>>());
    let count = input.views.offsets_m.len();
    let [width, rows] = input.views.size;
    let mut fragments = Vec::new();
    for (row, runs) in lines.iter().enumerate() {
        let (lines, mut slice) = (&runs.lines, Slice::new(&of.space, runs, width));
        for view in 0..count {
            let mut counters = Counters::default();
            for winner in slice.view(view, &mut counters) {
                let line = winner.map(|winner| &lines[winner.line as usize]);
                let is_own =
                    line.is_some_and(|line| line.is_first && of.space.place(usize::from(line.source), view) == 0);
                of_pixel(&of, (row, view), lines, &Expected { winner, words: words_of_winner(winner, is_own) });
            }
            fragments.push(counters.fragments as u32);
        }
    }
    let block = SliceBlock { width, rows, views: count as u32, spare: 0 };
    let buffers = [
        ("block", words_of(&[block])),
        ("starts", words.starts),
        ("run_starts", words.run_starts),
        ("runs", words.runs),
        ("depths", words.depths),
        ("lights", words.lights),
        ("places", words_of(&places(&of, 0..count))),
    ];
    (buffers.into(), fragments, u64::from(width * rows) * count as u64)
}

fn words_of_winner(winner: Option<Winner>, is_own: bool) -> [u32; 2] {
    let Some(Winner { line, beside, weight }) = winner else { return [NONE, 0] };
    let side = match beside {
        _ if beside == line + 1 => WINNER_AFTER,
        _ if beside + 1 == line => WINNER_BEFORE,
        _ => 0,
    };
    [line, u32::from(weight) | side | if is_own { WINNER_OWN } else { 0 }]
}

pub(super) fn winners(seed: u64) -> Vec<Case> {
    let case = |input: InterpolationCase| {
        let mut winners = Vec::new();
        let (mut buffers, fragments, pixels) = dispatch(&input, |_, _, _, expected| winners.extend(expected.words));
        buffers.insert("winners", vec![0xdead_beef; winners.len()]);
        buffers.insert("fragments", vec![0; fragments.len()]);
        let groups = fragments.len() as u32 * input.views.size[0].div_ceil(SLICE_COLUMNS);
        Case {
            label: input.label,
            buffers,
            invocations: groups * SLICE_WORKGROUP,
            passes: 0,
            inputs: fragments.len() as u64,
            expected: vec![("winners", winners), ("fragments", fragments)],
            pixels,
        }
    };
    inputs(seed).into_iter().map(case).collect()
}

pub(super) fn light(seed: u64) -> Vec<Case> {
    let case = |input: InterpolationCase| {
        let (mut winners, mut shown, mut glossy) = (Vec::new(), Vec::new(), Vec::new());
        let (mut buffers, fragments, pixels) = dispatch(&input, |of, (row, view), lines, expected| {
            winners.extend(expected.words);
            let pixel = pixel_of(of, (row, view), lines, expected);
            shown.extend(pixel);
            if pixel[1] >> 16 == SHOWN_GLOSS {
                let shown = expected.winner.iter().flat_map(|winner| [winner.line, winner.beside]);
                glossy.extend(shown.filter(|&line| is_gloss(of, row, &lines[line as usize])).map(|line| (row, line)));
            }
        });
        let starts = &buffers["starts"];
        let mut wanted = vec![0; starts[ROWS].div_ceil(32) as usize];
        for (row, line) in glossy {
            let line = starts[row] + line;
            wanted[line as usize / 32] |= 1 << (line % 32);
        }
        buffers.insert("wanted", vec![0; wanted.len()]);
        buffers.insert("winners", winners);
        buffers.insert("pixels", vec![0xdead_beef; shown.len()]);
        Case {
            label: input.label,
            buffers,
            invocations: pixels as u32,
            passes: 0,
            inputs: fragments.len() as u64,
            expected: vec![("pixels", shown), ("wanted", wanted)],
            pixels,
        }
    };
    inputs(seed).into_iter().map(case).collect()
}

fn is_gloss(of: &Interpolator<'_>, row: usize, line: &Line) -> bool {
    matches!(of.source_pixel(row, line).light, Light::Gloss(_))
}

/// Returns the words of a pixel. Its scanline has an empty gloss list, so the CPU adds no highlight.
fn pixel_of(of: &Interpolator<'_>, (row, view): (usize, usize), lines: &[Line], expected: &Expected) -> [u32; 2] {
    let (color, coverage) = Shader::new(of, lines, row).pixel(expected.winner, view);
    let is_own = expected.words[1] & WINNER_OWN != 0;
    let lines = expected.winner.iter().flat_map(|winner| [winner.line, winner.beside]).map(|at| &lines[at as usize]);
    let [low, high] = covered(color);
    let kind = match coverage {
        Coverage::Hole => SHOWN_HOLE,
        Coverage::Optical => SHOWN_OPTICAL,
        Coverage::Covered if !is_own && lines.into_iter().any(|line| is_gloss(of, row, line)) => SHOWN_GLOSS,
        Coverage::Covered => 0,
    };
    [low, high | kind << 16]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selftest::SEED;

    #[test]
    fn inputs_have_all_kinds_of_winners_and_pixels() {
        let words = |cases: Vec<Case>| -> Vec<[u32; 2]> {
            cases.iter().flat_map(|case| case.expected[0].1.as_chunks().0.to_vec()).collect()
        };
        let winners = words(winners(SEED));
        let count = |is: &dyn Fn(u32) -> bool| winners.iter().filter(|[line, rest]| *line != NONE && is(*rest)).count();
        assert!(winners.iter().filter(|[line, _]| *line == NONE).count() > 1000);
        for flag in [WINNER_AFTER, WINNER_BEFORE, WINNER_OWN] {
            assert!(count(&|rest| rest & flag != 0) > 1000, "{flag}");
        }
        let weights: std::collections::BTreeSet<u32> = winners.iter().map(|[_, rest]| rest & 0xff).collect();
        assert!(weights.len() > 200, "{weights:?}");
        let pixels = words(light(SEED));
        for kind in [0, SHOWN_HOLE, SHOWN_OPTICAL, SHOWN_GLOSS] {
            assert!(pixels.iter().filter(|[_, rest]| rest >> 16 == kind).count() > 1000, "{kind}");
        }
    }
}
