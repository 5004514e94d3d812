//! Visibility of a probe's pixels from a camera (CALF 6.2).
//!
//! Pixels show surfaces between near and far, which lie in a frustum, or the background, which is seen in the directions of
//! the frustum. A frustum is visible if it shares a point or a direction with the frustum of the camera. [`Sight::Missed`] is
//! proved; the other results are conservative.

use super::frustum::Frustum;
use super::separation::{directions_apart, volumes_apart};

/// Directions within this angle of the camera's, in radians, count as visible: a fiftieth of an arc second.
///
/// It also limits the intersection of two infinite frusta to 1 / `MARGIN` times the distance of their apexes.
const MARGIN: f64 = 1e-7;

/// Visibility of a frustum from a camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    Missed,
    /// A part of the frustum or of its directions may be visible.
    Partly,
    /// All its directions are visible, and so is a part of each frustum inside it with the same apex.
    Inside,
}

/// A camera's frustum, prepared for many tests.
#[derive(Debug, Clone, PartialEq)]
pub struct Viewer {
    frustum: Frustum,
    /// The frustum widened by [`MARGIN`]; `None` if it is unsound or nearly a half space.
    wide: Option<Frustum>,
}

impl Viewer {
    /// Prepares a frustum, which also sees the background in all its directions.
    pub fn new(frustum: Frustum) -> Viewer {
        let wide = if frustum.is_sound() { frustum.widened(MARGIN) } else { None };
        Viewer { frustum, wide }
    }

    /// Visibility of a frustum and of the background behind it. [`Sight::Missed`] is certain.
    ///
    /// Frusta with a gap of less than 10⁻¹³ of the lengths involved count as visible. For two infinite frusta these lengths
    /// are 2 / `MARGIN` times the distance of their apexes, so that the gap is about 2 · 10⁻⁶ of that distance.
    pub fn sight(&self, volume: &Frustum) -> Sight {
        let Some(wide) = self.wide.as_ref().filter(|_| volume.is_sound()) else { return Sight::Partly };
        if volume.rays.iter().all(|ray| self.frustum.contains_direction(*ray)) {
            return Sight::Inside;
        }
        if !directions_apart(wide, volume) || !self.is_apart(volume) {
            return Sight::Partly;
        }
        Sight::Missed
    }

    /// True if the frusta share no point. They must share no direction.
    fn is_apart(&self, volume: &Frustum) -> bool {
        let between_m = self.frustum.apex.distance(volume.apex);
        if between_m == 0.0 {
            // The apex is the same, and no direction is shared.
            return true;
        }
        let farthest = |frustum: &Frustum| frustum.depth_m[1] * frustum.reach;
        let far_m = match [farthest(&self.frustum), farthest(volume)] {
            [f64::INFINITY, f64::INFINITY] => [2.0 * between_m / MARGIN; 2],
            [f64::INFINITY, volume_m] => [volume_m + between_m, volume.depth_m[1]],
            [viewer_m, f64::INFINITY] => [self.frustum.depth_m[1], viewer_m + between_m],
            _ => [self.frustum.depth_m[1], volume.depth_m[1]],
        };
        volumes_apart(&self.frustum, volume, far_m)
    }
}

#[cfg(test)]
mod tests;
