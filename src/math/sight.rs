//! Whether a camera sees anything of what a probe's pixels may show (CALF 6.2).
//!
//! Pixels show surfaces between near and far, which lie in a frustum, and the background, which lies in its
//! directions. So a frustum is seen where it has a point in common with the camera's, or a direction. An answer of no
//! is proved; an answer of yes is rarely given in vain.

use super::frustum::Frustum;
use super::separation::{directions_apart, volumes_apart};

/// Directions within this angle of a camera's own count as seen, in radians: a fiftieth of an arc second.
///
/// It also keeps what two endless frusta can have in common within 1 / `MARGIN` times the distance of their tips.
const MARGIN: f64 = 1e-7;

/// What a camera sees of a frustum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    Missed,
    /// A part, or a part of its directions; now and then nothing.
    Partly,
    /// All its directions, and so something of each frustum inside it that has the same tip.
    Inside,
}

/// A camera's frustum, ready to be compared with many others.
#[derive(Debug, Clone, PartialEq)]
pub struct Viewer {
    frustum: Frustum,
    /// The same with a margin around it, where it is not nearly a half space.
    wide: Option<Frustum>,
}

impl Viewer {
    /// A viewer that sees this frustum, and the background in all its directions.
    pub fn new(frustum: Frustum) -> Viewer {
        let wide = if frustum.is_sound() { frustum.widened(MARGIN) } else { None };
        Viewer { frustum, wide }
    }

    /// What it sees of a frustum and of the background behind it. [`Sight::Missed`] is certain.
    ///
    /// Frusta that are a little apart count as seen: by a part in 10¹³ of the lengths involved, which between two
    /// endless ones are 2 / `MARGIN` times the distance of their tips, so about 2 · 10⁻⁶ of that distance.
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

    /// Whether no point is common, where no direction is.
    fn is_apart(&self, volume: &Frustum) -> bool {
        let between_m = self.frustum.apex.distance(volume.apex);
        if between_m == 0.0 {
            // Two pyramids from one tip, in other directions.
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
