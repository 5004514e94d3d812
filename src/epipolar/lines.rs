//! Pixels of source views as lines in epipolar space, in integers (Epipolar 3.3.2).
//!
//! A line has a column in its own view, in 1/256 pixels, and a disparity: the number of columns by which it moves from the first
//! output view to the last, in 1/4096 pixels. In another view it moves by a fraction of its disparity: the position of the view
//! relative to the line's source, in units of 2^-24 of the baseline. The CPU and devices compute columns and keys from these
//! integers alone.

use super::continuity::{Continuity, Surfaces};
use super::source::{SourcePixel, SourceView};
use super::views::OutputViews;

/// Number of fractional bits of columns.
pub const COLUMN_BITS: u32 = 8;
const DISPARITY_BITS: u32 = 12;
const PLACE_BITS: u32 = 24;
/// Maximum number of columns that a line moves. A larger move leaves every image.
const MAX_COLUMNS: f64 = (1 << (30 - DISPARITY_BITS)) as f64;
/// Maximum move of a line in 1/256 pixels, such that sums and differences of columns fit 32 bits.
const MAX_MOVED: i64 = 1 << 29;
/// Maximum distance between a source and a view, in baselines.
const MAX_PLACE: f64 = 64.0;
/// Tangent of the steepest slant, measured from the scanline, at which a surface still fills pixels.
pub const STEEPEST: f64 = 6.0;

/// A source pixel as a line in epipolar space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line {
    /// Column of the pixel's centre in its own view, in 1/256 pixels.
    pub column: i32,
    /// Disparity in 1/4096 pixels over the baseline.
    pub disparity: i32,
    /// Bits of the planar distance as an `f32`; they increase with the distance.
    pub depth: u32,
    /// Index of the pixel in [`super::source::SourceRow::pixels`] of its source.
    pub pixel: u32,
    pub source: u16,
    /// True if the next line shows the next pixel of the same surface.
    pub joins_next: bool,
    /// True if the line belongs to the first layer.
    pub is_first: bool,
}

/// Positions of sources and views along the baseline, and the bias of keys.
#[derive(Debug, Clone)]
pub struct LineSpace {
    /// For each source and view, the distance of the view to the right of the source, in 2^-24 of the baseline.
    places: Vec<Vec<i32>>,
    continuity: Continuity,
    /// A surface has a disparity of `at_infinity - scale / depth_m`, in 1/4096 pixels over the baseline.
    scale: f64,
    at_infinity: f64,
    /// Added to the key of a line in a view that is one baseline away from the line's source.
    bias: u32,
}

/// Returns the columns, in 1/256 pixels, by which a line with this disparity has moved at a relative position: their product,
/// rounded to nearest, halves up.
///
/// Devices compute the product from two 32-bit limbs.
pub fn moved(disparity: i32, place: i32) -> i32 {
    const SHIFT: u32 = DISPARITY_BITS - COLUMN_BITS + PLACE_BITS;
    let columns = (i64::from(disparity) * i64::from(place) + (1 << (SHIFT - 1))) >> SHIFT;
    columns.clamp(-MAX_MOVED, MAX_MOVED) as i32
}

impl LineSpace {
    /// Takes the positions of the sources in metres to the right of the middle of the views.
    pub fn new(views: &OutputViews, source_offsets_m: &[f64]) -> LineSpace {
        let baseline_m = views.baseline_m();
        let place = |source_m: f64, view_m: f64| {
            let place = if baseline_m > 0.0 { (view_m - source_m) / baseline_m } else { 0.0 };
            (place.clamp(-MAX_PLACE, MAX_PLACE) * f64::from(1 << PLACE_BITS)).round() as i32
        };
        let places = source_offsets_m
            .iter()
            .map(|&source_m| views.offsets_m.iter().map(|&view_m| place(source_m, view_m)).collect())
            .collect();
        let columns = views.focal_pixels() * baseline_m;
        // Another source's sample of the same surface may differ in depth by up to half a pixel times the slant. The bias of a
        // key increases with the distance between view and source.
        let bias = (STEEPEST * 0.5 / views.focal_pixels()).min(0.5);
        let units = f64::from(1 << DISPARITY_BITS);
        LineSpace {
            places,
            continuity: Continuity::new(columns),
            scale: columns * units,
            at_infinity: columns / views.focus_m * units,
            bias: (bias * f64::from(1 << 23)) as u32,
        }
    }

    /// Returns the position of a view relative to a source, in 2^-24 of the baseline.
    pub fn place(&self, source: usize, view: usize) -> i32 {
        self.places[source][view]
    }

    /// Returns the bias of a key at a relative position, as a fraction of the distance in units of 2^-23.
    pub fn bias_at(&self, place: i32) -> u32 {
        ((u64::from(self.bias) * u64::from(place.unsigned_abs())) >> PLACE_BITS) as u32
    }

    /// Returns a depth behind which all lines, of any source, show another surface than a line of the given depth.
    pub fn behind(&self, depth: u32) -> u32 {
        depth.saturating_add(2 * self.bias)
    }

    fn disparity(&self, depth_m: f32) -> i32 {
        let most = MAX_COLUMNS * f64::from(1 << DISPARITY_BITS);
        (self.at_infinity - self.scale / f64::from(depth_m)).clamp(-most, most).round() as i32
    }

    /// Returns the lines of a scanline of all sources, in the order of sources. The lines of a source are sorted by surface, from
    /// left to right.
    pub fn lines<'s>(&self, sources: impl IntoIterator<Item = &'s SourceView>, row: usize) -> Vec<Line> {
        let of = |(source, view): (usize, &SourceView)| self.lines_of(source as u16, &view.rows[row].pixels);
        sources.into_iter().enumerate().flat_map(of).collect()
    }

    fn lines_of(&self, source: u16, pixels: &[SourcePixel]) -> Vec<Line> {
        let chains = Surfaces::new(pixels, self.continuity);
        let mut lines = Vec::with_capacity(pixels.len());
        for head in (0..pixels.len()).filter(|&at| !chains.has_left[at]) {
            let mut here = Some(head);
            while let Some(at) = here {
                here = chains.right(at);
                let pixel = &pixels[at];
                lines.push(Line {
                    column: (pixel.column << COLUMN_BITS) + (1 << (COLUMN_BITS - 1)),
                    disparity: self.disparity(pixel.depth_m),
                    depth: pixel.depth_m.to_bits(),
                    pixel: at as u32,
                    source,
                    joins_next: here.is_some(),
                    is_first: pixel.layer == 0,
                });
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use half::f16;

    use super::*;
    use crate::coalesce::{Coalescing, LineRuns};
    use crate::counters::Counters;
    use crate::slice::Slice;
    use crate::source::{Light, SourceRow};
    use crate::views::Spread;
    use codec::math::{Camera, Lens};

    #[test]
    fn a_surface_behind_leaves_has_no_pinholes() {
        // A curtain in front of a wall, slanted so that the last view sees it twice as wide; leaves hide every third pixel of it.
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, Lens::new(60.0)).unwrap();
        let views =
            OutputViews::new(camera.with_aspect(2.0), [64, 32], 3, Spread::Baseline(0.5), f64::INFINITY).unwrap();
        let pixel = |column: i32, depth_m: f32, layer: u8| {
            let black = [f16::ZERO; 3];
            SourcePixel { column, depth_m, layer, light: Light::Steady, steady: black, own: black }
        };
        let curtain = |column: i32| (2.0 - f64::from(column - 34) * 0.04).recip() as f32;
        let is_leaf = |column: i32| column % 3 == 1;
        // No part of the curtain moves across the left border.
        let columns = 34..64;
        let mut pixels: Vec<SourcePixel> =
            columns.clone().map(|at| pixel(at, if is_leaf(at) { 0.3 } else { curtain(at) }, 0)).collect();
        pixels.extend(columns.clone().map(|at| pixel(at, if is_leaf(at) { curtain(at) } else { 9.0 }, 1)));
        pixels.extend(columns.filter(|&at| is_leaf(at)).map(|at| pixel(at, 9.0, 2)));
        let row = SourceRow { pixels, gloss: Vec::new() };
        let source = SourceView::of_rows(-0.25, vec![row]);
        let space = LineSpace::new(&views, &[-0.25]);
        let runs = LineRuns::new(space.lines([&source], 0), Coalescing::Off);
        let (lines, mut slice) = (&runs.lines, Slice::new(&space, &runs, 64));
        let shown: Vec<f32> = slice
            .view(2, &mut Counters::default())
            .map(|winner| winner.map_or(0.0, |winner| f32::from_bits(lines[winner.line as usize].depth)))
            .collect();
        let is_curtain = |depth_m: &f32| (0.4..3.0).contains(depth_m);
        let first = shown.iter().position(is_curtain).unwrap();
        let last = shown.iter().rposition(is_curtain).unwrap();
        assert!(last - first > 35, "{shown:?}");
        let through = shown[first..last].iter().filter(|depth_m| **depth_m > 3.0).count();
        assert_eq!(through, 0, "{shown:?}");
    }
}
