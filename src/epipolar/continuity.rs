//! Which neighbours on a scanline show one surface.
//!
//! A plane's inverse distance is linear along a scanline. Two neighbours are taken for one surface where their inverse distances differ
//! little, or lie on the line through those of the next pixel on either side: so slanted and curved surfaces are closed at any angle, and
//! edges stay open. Behind others, a surface changes its layer wherever they begin or end: [`Surfaces`] follows it through all layers.

use super::source::SourcePixel;

/// Columns, between the two views that are farthest apart, by which one surface may differ from a plane.
const TOLERANCE_COLUMNS: f64 = 1.0;

/// Judges neighbours by their inverse distances.
#[derive(Debug, Clone, Copy)]
pub struct Continuity {
    /// Largest difference of inverse distances, 1/m.
    tolerance: f64,
}

impl Continuity {
    /// `columns` is how far a surface at 1 m moves between the two views that are farthest apart: focal pixels times metres.
    pub fn new(columns: f64) -> Continuity {
        Continuity { tolerance: TOLERANCE_COLUMNS / columns }
    }

    /// Whether a pixel and the next one show one surface, given the inverse distances of the pixel before, of both, and of the pixel
    /// after: 0 for the background, `None` where there is no pixel.
    pub fn joins(&self, before: Option<f64>, [here, next]: [f64; 2], after: Option<f64>) -> bool {
        let is_small = |difference: f64| difference.abs() <= self.tolerance;
        // The sky is no surface's neighbour.
        if (here == 0.0) != (next == 0.0) {
            return false;
        }
        let on_line = |a: Option<f64>, b: f64, c: f64| a.is_some_and(|a| a > 0.0 && is_small(a - 2.0 * b + c));
        is_small(next - here) || on_line(before, here, next) || on_line(after, next, here)
    }
}

/// No pixel.
const NONE: u32 = u32::MAX;

/// The pixels of a scanline of a source view, joined in surfaces.
#[derive(Debug)]
pub struct Surfaces {
    /// By pixel, the next one to the right of its surface, or [`NONE`].
    right: Vec<u32>,
    /// By pixel, whether it is the next one of another.
    pub has_left: Vec<bool>,
}

/// Pixels by column, those of a column from the nearest on.
struct Columns<'a> {
    pixels: &'a [SourcePixel],
    order: Vec<u32>,
    starts: Vec<u32>,
}

impl<'a> Columns<'a> {
    /// Of pixels by layer, then by column.
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

    /// None beyond the last column.
    fn of(&self, column: usize) -> &[u32] {
        match self.starts.get(column..column + 2) {
            Some(&[from, to]) => &self.order[from as usize..to as usize],
            _ => &[],
        }
    }

    fn inverse(&self, pixel: u32) -> f64 {
        f64::from(self.pixels[pixel as usize].depth_m).recip()
    }

    /// The pixel of a column whose inverse distance is the nearest to one.
    fn nearest(&self, column: usize, inverse: f64) -> Option<u32> {
        let apart = |pixel: &u32| (self.inverse(*pixel) - inverse).abs();
        self.of(column).iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)))
    }
}

impl Surfaces {
    /// Of pixels by layer, then by column. Each joins one on either side at most: the one of its own layer if it shows the same surface,
    /// else that with the nearest inverse distance if this is mutual. So what is culled behind a layer does not change how it is joined.
    pub fn new(pixels: &[SourcePixel], continuity: Continuity) -> Surfaces {
        let columns = Columns::new(pixels);
        let mut surfaces = Surfaces { right: vec![NONE; pixels.len()], has_left: vec![false; pixels.len()] };
        // By pixel, that which it is the next one of.
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

    /// The next pixel of a pixel's surface.
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
        // Without a baseline all is one surface, and nothing moves.
        assert!(Continuity::new(0.0).joins(None, [0.3, 0.5], None));
    }
}
