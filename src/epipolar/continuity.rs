//! Which neighbours on a scanline show one surface.
//!
//! A plane's inverse distance is linear along a scanline. Two neighbours are taken for one surface where their inverse distances differ
//! little, or lie on the line through those of the next pixel on either side: so slanted and curved surfaces are closed at any angle, and
//! edges stay open.

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
