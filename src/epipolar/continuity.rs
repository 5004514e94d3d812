//! Continuity test: which neighbouring pixels of a scanline show the same surface.
//!
//! The inverse distance of a plane is linear along a scanline. Two neighbours belong to one surface if their inverse distances
//! differ little, or if they lie on a straight line with that of the next pixel on either side. Slanted and curved surfaces are
//! therefore closed at any angle, and edges stay open. A surface behind others changes its layer wherever an occluder begins or
//! ends; [`Surfaces`] follows it through all layers.

use super::source::SourcePixel;

/// Maximum deviation of a surface from a plane, in columns between the two views that are farthest apart.
const TOLERANCE_COLUMNS: f64 = 1.0;

/// Continuity test of neighbouring pixels by their inverse distances.
#[derive(Debug, Clone, Copy)]
pub struct Continuity {
    /// Maximum difference of inverse distances, 1/m.
    tolerance: f64,
}

impl Continuity {
    /// `columns` is the number of columns by which a surface at 1 m moves between the two views that are farthest apart: focal
    /// length in pixels times metres.
    pub fn new(columns: f64) -> Continuity {
        Continuity { tolerance: TOLERANCE_COLUMNS / columns }
    }

    /// Returns true if a pixel and the next one show the same surface. Takes the inverse distances of the pixel before, of both
    /// pixels, and of the pixel after: 0 for the background, `None` where there is no pixel.
    pub fn joins(&self, before: Option<f64>, [here, next]: [f64; 2], after: Option<f64>) -> bool {
        let is_small = |difference: f64| difference.abs() <= self.tolerance;
        // The background does not join any surface.
        if (here == 0.0) != (next == 0.0) {
            return false;
        }
        let on_line = |a: Option<f64>, b: f64, c: f64| a.is_some_and(|a| a > 0.0 && is_small(a - 2.0 * b + c));
        is_small(next - here) || on_line(before, here, next) || on_line(after, next, here)
    }
}

/// Index that stands for no pixel.
const NONE: u32 = u32::MAX;

/// Pixels of a scanline of a source view, linked into surfaces.
#[derive(Debug)]
pub struct Surfaces {
    /// For each pixel, the next pixel to the right on the same surface, or [`NONE`].
    right: Vec<u32>,
    /// For each pixel, true if a pixel to the left links to it.
    pub has_left: Vec<bool>,
}

/// Pixels grouped by column, from near to far within a column.
struct Columns<'a> {
    pixels: &'a [SourcePixel],
    order: Vec<u32>,
    starts: Vec<u32>,
}

impl<'a> Columns<'a> {
    /// Takes pixels sorted by layer, then by column.
    fn new(pixels: &'a [SourcePixel]) -> Columns<'a> {
        let ends = pixels
            .iter()
            .fold((i32::MAX, i32::MIN), |(first, last), pixel| (first.min(pixel.column), last.max(pixel.column)));
        let count = if pixels.is_empty() { 0 } else { (ends.1 - ends.0) as usize + 1 };
        let index = |pixel: &SourcePixel| (pixel.column - ends.0) as usize;
        let mut starts = vec![0; count + 1];
        pixels.iter().for_each(|pixel| starts[index(pixel) + 1] += 1);
        (0..count).for_each(|at| starts[at + 1] += starts[at]);
        let (mut next, mut order) = (starts.clone(), vec![NONE; pixels.len()]);
        for (at, pixel) in (0..).zip(pixels) {
            let place = &mut next[index(pixel)];
            order[*place as usize] = at;
            *place += 1;
        }
        Columns { pixels, order, starts }
    }

    fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the pixels of a column; empty beyond the last column.
    fn of(&self, column: usize) -> &[u32] {
        match self.starts.get(column..column + 2) {
            Some(&[from, to]) => &self.order[from as usize..to as usize],
            _ => &[],
        }
    }

    fn inverse(&self, pixel: u32) -> f64 {
        f64::from(self.pixels[pixel as usize].depth_m).recip()
    }

    /// Returns the pixel of a column whose inverse distance is closest to `inverse`.
    fn nearest(&self, column: usize, inverse: f64) -> Option<u32> {
        let apart = |pixel: &u32| (self.inverse(*pixel) - inverse).abs();
        self.of(column).iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)))
    }
}

impl Surfaces {
    /// Takes pixels sorted by layer, then by column. Each pixel joins at most one pixel on either side: the one of its own layer
    /// if both show the same surface, otherwise the one with the nearest inverse distance if that choice is mutual. Culling
    /// behind a layer therefore does not change the links within the layer.
    pub fn new(pixels: &[SourcePixel], continuity: Continuity) -> Surfaces {
        let columns = Columns::new(pixels);
        let mut surfaces = Surfaces { right: vec![NONE; pixels.len()], has_left: vec![false; pixels.len()] };
        // For each pixel, the pixel whose right neighbour it is.
        let mut left = vec![NONE; pixels.len()];
        for column in 1..columns.count() {
            let joins = |here: u32, next: u32, left: &[u32]| {
                let ends = [here, next].map(|pixel| columns.inverse(pixel));
                let before = Some(left[here as usize]).filter(|&before| before != NONE).or_else(|| {
                    let on_line = 2.0 * ends[0] - ends[1];
                    column.checked_sub(2).and_then(|before| columns.nearest(before, on_line))
                });
                let after = columns.nearest(column + 1, 2.0 * ends[1] - ends[0]);
                let [before, after] = [before, after].map(|pixel| pixel.map(|pixel| columns.inverse(pixel)));
                continuity.joins(before, ends, after)
            };
            let (here, next) = (columns.of(column - 1), columns.of(column));
            let mutual = |pixel: u32| {
                let other = columns.nearest(column, columns.inverse(pixel))?;
                (columns.nearest(column - 1, columns.inverse(other)) == Some(pixel)).then_some(other)
            };
            let of_layer = |pixel: u32| {
                let layer = pixels[pixel as usize].layer;
                next.iter().copied().find(|&other| pixels[other as usize].layer == layer)
            };
            let pairs = [&of_layer as &dyn Fn(u32) -> Option<u32>, &mutual];
            for pair in pairs {
                for &pixel in here {
                    let is_free = |other: &u32| surfaces.right[pixel as usize] == NONE && left[*other as usize] == NONE;
                    if let Some(other) = pair(pixel).filter(is_free).filter(|&other| joins(pixel, other, &left)) {
                        surfaces.right[pixel as usize] = other;
                        left[other as usize] = pixel;
                    }
                }
            }
        }
        surfaces.has_left = left.iter().map(|&pixel| pixel != NONE).collect();
        surfaces
    }

    /// Returns the next pixel to the right on the surface of a pixel.
    pub fn right(&self, pixel: usize) -> Option<usize> {
        Some(self.right[pixel]).filter(|&right| right != NONE).map(|right| right as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_join_at_any_slant_and_edges_do_not() {
        let continuity = Continuity::new(200.0);
        // Inverse distances of a steep plane, and of a step.
        let steep = |at: f64| 0.3 + 0.05 * at;
        assert!(continuity.joins(Some(steep(0.0)), [steep(1.0), steep(2.0)], None));
        assert!(continuity.joins(None, [steep(1.0), steep(2.0)], Some(steep(3.0))));
        assert!(!continuity.joins(Some(0.3), [0.3, 0.5], Some(0.5)));
        assert!(!continuity.joins(None, [0.3, 0.5], None));
        assert!(continuity.joins(None, [0.3, 0.304], None));
        assert!(continuity.joins(None, [0.0, 0.0], None));
        assert!(!continuity.joins(None, [0.0, 0.001], None));
        // Without a baseline nothing moves, and all pixels count as one surface.
        assert!(Continuity::new(0.0).joins(None, [0.3, 0.5], None));
    }
}
