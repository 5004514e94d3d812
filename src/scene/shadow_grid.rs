//! Shadow casters of a sun, in a grid perpendicular to its direction.

use glam::{DVec2, DVec3};

use super::object::Object;

#[derive(Debug, Clone)]
pub(super) struct ShadowGrid {
    /// Two axes perpendicular to the sun's direction.
    axes: [DVec3; 2],
    /// Minimum coordinates of all casters, and cells per metre, along these axes.
    min: DVec2,
    per_metre: DVec2,
    /// Indices of objects per cell, row-major.
    shafts: Vec<Vec<usize>>,
}

impl ShadowGrid {
    /// Cells along each axis.
    const SIDE: usize = 48;

    pub(super) fn new(objects: &[Object], sun: DVec3) -> Self {
        // As close to X as possible: the shadows of long beams along X then cover few cells.
        let first = (DVec3::X - sun.x * sun).try_normalize().unwrap_or(DVec3::Y);
        let axes = [first, sun.cross(first)];
        let flat = |point: DVec3| DVec2::new(point.dot(axes[0]), point.dot(axes[1]));
        let caster = |(index, object): (usize, &Object)| {
            let corners = object.is_occluder().then(|| object.bounds.corners().map(flat))?;
            // A margin of 1e-5 m for rounding and the offset of shadow rays.
            let low = corners.into_iter().fold(DVec2::INFINITY, DVec2::min) - 1e-5;
            Some((index, low, corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max) + 1e-5))
        };
        let casters: Vec<(usize, DVec2, DVec2)> = objects.iter().enumerate().filter_map(caster).collect();
        let min = casters.iter().fold(DVec2::INFINITY, |min, (_, low, _)| min.min(*low));
        let max = casters.iter().fold(DVec2::NEG_INFINITY, |max, (_, _, high)| max.max(*high));
        let (per_metre, shafts) = (Self::SIDE as f64 / (max - min), vec![Vec::new(); Self::SIDE * Self::SIDE]);
        let mut grid = ShadowGrid { axes, min, per_metre, shafts };
        for (index, low, high) in casters {
            let (from, to) = (grid.shaft(low), grid.shaft(high));
            for row in from[1]..=to[1] {
                for column in from[0]..=to[0] {
                    grid.shafts[row * Self::SIDE + column].push(index);
                }
            }
        }
        grid
    }

    /// Returns column and row of the cell of a point. The casts saturate and map NaN (a grid without casters) to 0, so points
    /// outside the grid use a border cell, whose casters are tested needlessly.
    fn shaft(&self, flat: DVec2) -> [usize; 2] {
        ((flat - self.min) * self.per_metre).to_array().map(|at| (at as usize).min(Self::SIDE - 1))
    }

    /// Returns the indices of the objects that may occlude the sun at `point`.
    pub(super) fn casters(&self, point: DVec3) -> &[usize] {
        let [column, row] = self.shaft(DVec2::new(point.dot(self.axes[0]), point.dot(self.axes[1])));
        &self.shafts[row * Self::SIDE + column]
    }
}
