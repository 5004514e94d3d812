//! Surfaces that pixels show, found by ray tracing or from the triangles that a rasteriser draws (Epipolar 3.1 to 3.3).
//!
//! A drawing contains only triangle numbers. Hits are computed from these triangles with the same code as for traced rays, so
//! that distances and radiance are bit-exact wherever both methods find the same triangle. Triangle edges may differ by a
//! fraction of a pixel. A ray is traced if it misses the triangle that was drawn, or if [`MAX_DRAWN`] triangles were drawn at its
//! pixel.

use std::ops::Range;

use glam::DVec3;

use codec::error::Result;
use codec::monitor::Monitor;
use scene::capture::{PixelTracer, Viewpoint};
use scene::mesh::Ray;
use scene::{FirstHit, SceneAtTime};

/// Maximum number of triangles drawn behind each other. Pixels that reach it are traced.
pub const MAX_DRAWN: usize = 32;
/// Maximum size in bytes of the triangle numbers in memory.
const MAX_DRAWN_BYTES: usize = 256 << 20;

/// Rectangle of pixels of a flat image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PixelWindow {
    pub columns: Range<i32>,
    pub rows: Range<u32>,
}

/// Triangle numbers, counted from 1 over all meshes of a scene; 0 is no triangle. One list per layer, nearest first, each in
/// row-major order.
pub type TriangleLayers = Vec<Vec<u32>>;

/// Rasteriser of the triangles of a scene.
pub trait TriangleDrawing: Sync {
    /// Returns the triangles at one position within each pixel (0.5 is the centre), at most `max_layers` behind each other.
    /// Returns `None` if rays are to be traced instead.
    fn draw(
        &self,
        from: &Viewpoint,
        window: &PixelWindow,
        place: [f64; 2],
        max_layers: usize,
    ) -> Result<Option<TriangleLayers>>;
}

/// A scene, and the rasteriser of its triangles, if there is one.
#[derive(Clone, Copy)]
pub struct DrawnScene<'a> {
    pub scene: &'a SceneAtTime,
    pub drawing: Option<&'a dyn TriangleDrawing>,
}

impl<'a> From<&'a SceneAtTime> for DrawnScene<'a> {
    fn from(scene: &'a SceneAtTime) -> DrawnScene<'a> {
        DrawnScene { scene, drawing: None }
    }
}

/// Surfaces that the pixels of a window show.
pub struct PixelHits<'a> {
    scene: &'a SceneAtTime,
    drawn: Option<DrawnPixels>,
}

struct DrawnPixels {
    window: PixelWindow,
    /// Triangles at pixel centres.
    middles: TriangleLayers,
    /// For each sample, the nearest triangle at every pixel.
    samples: Vec<Vec<u32>>,
}

impl<'a> DrawnScene<'a> {
    /// Returns the number of scanlines whose triangles are drawn at once, for the given numbers of columns and of layers and
    /// samples.
    pub fn rows_at_once(&self, columns: usize, drawn: usize) -> u32 {
        let bytes = size_of::<u32>() * columns.max(1) * drawn.max(1);
        let rows = (MAX_DRAWN_BYTES / bytes) as u32 / PixelTracer::TILE * PixelTracer::TILE;
        if self.drawing.is_some() { rows.max(PixelTracer::TILE) } else { u32::MAX }
    }

    /// Draws a window if there is a rasteriser: `layers` layers at pixel centres, and the nearest triangles at `samples`.
    pub fn hits(
        &self,
        from: &Viewpoint,
        window: PixelWindow,
        layers: usize,
        samples: &[[f64; 2]],
        monitor: &dyn Monitor,
    ) -> Result<PixelHits<'a>> {
        let DrawnScene { scene, drawing } = *self;
        let drawn =
            drawing.map(|drawing| draw(drawing, from, window, (layers, samples), monitor)).transpose()?.flatten();
        Ok(PixelHits { scene, drawn })
    }
}

fn draw(
    drawing: &dyn TriangleDrawing,
    from: &Viewpoint,
    window: PixelWindow,
    (layers, samples): (usize, &[[f64; 2]]),
    monitor: &dyn Monitor,
) -> Result<Option<DrawnPixels>> {
    monitor.check()?;
    let Some(middles) = drawing.draw(from, &window, [0.5; 2], layers)? else { return Ok(None) };
    let mut nearest = Vec::new();
    for &place in samples {
        monitor.check()?;
        let Some(layers) = drawing.draw(from, &window, place, 1)? else { return Ok(None) };
        nearest.extend(layers.into_iter().take(1));
    }
    Ok(Some(DrawnPixels { window, middles, samples: nearest }))
}

impl PixelHits<'_> {
    /// Returns all surfaces at the centre of a pixel, as [`SceneAtTime::all_hits`] does.
    pub fn all(&self, pixel: [i32; 2], ray: &Ray, candidates: &[usize]) -> Vec<FirstHit> {
        let candidates = candidates.iter().copied();
        let Some(drawn) = &self.drawn else { return self.scene.all_hits(ray, candidates) };
        let at = drawn.index(pixel);
        let numbers: Vec<u32> = drawn.middles.iter().map(|layer| layer[at]).take_while(|number| *number > 0).collect();
        // The ray is traced if it misses one of the drawn triangles, or if there may be more triangles than were drawn.
        let met = numbers.iter().map(|&number| self.scene.hit_of_triangle(ray, number as usize - 1));
        let (Some(met), true) = (met.collect::<Option<Vec<_>>>(), numbers.len() < MAX_DRAWN) else {
            return self.scene.all_hits(ray, candidates);
        };
        let solid = met.into_iter().filter(|(_, is_hole)| !is_hole).map(|(hit, _)| hit);
        self.scene.with_objects(solid, ray, candidates)
    }

    /// Returns the nearest surface at the centre of a pixel, as [`SceneAtTime::first_hit`] does.
    pub fn nearest(&self, pixel: [i32; 2], ray: &Ray, candidates: &[usize]) -> Option<FirstHit> {
        self.first_of(pixel, self.drawn.as_ref().and_then(|drawn| drawn.middles.first()), ray, candidates)
    }

    /// Returns the nearest surface at a sample of a pixel.
    pub fn first(&self, pixel: [i32; 2], sample: usize, ray: &Ray, candidates: &[usize]) -> Option<FirstHit> {
        self.first_of(pixel, self.drawn.as_ref().and_then(|drawn| drawn.samples.get(sample)), ray, candidates)
    }

    fn first_of(&self, pixel: [i32; 2], layer: Option<&Vec<u32>>, ray: &Ray, candidates: &[usize]) -> Option<FirstHit> {
        let candidates = candidates.iter().copied();
        let Some((drawn, layer)) = self.drawn.as_ref().zip(layer) else { return self.scene.first_hit(ray, candidates) };
        match layer[drawn.index(pixel)] {
            0 => self.scene.with_objects(None, ray, candidates).into_iter().next(),
            number => match self.scene.hit_of_triangle(ray, number as usize - 1) {
                Some((hit, false)) => self.scene.with_objects(Some(hit), ray, candidates).into_iter().next(),
                _ => self.scene.first_hit(ray, candidates),
            },
        }
    }
}

impl DrawnPixels {
    fn index(&self, [column, row]: [i32; 2]) -> usize {
        let PixelWindow { columns, rows } = &self.window;
        (row - rows.start as i32) as usize * columns.len() + (column - columns.start) as usize
    }
}

impl PixelWindow {
    /// Returns the tangents of the window's edges: left and right, then top and bottom.
    pub fn tangents(&self, from: &Viewpoint) -> [[f64; 2]; 2] {
        let corner = |column: i32, row: u32| from.projection.plane([f64::from(column), f64::from(row)]);
        let [left, top] = corner(self.columns.start, self.rows.start);
        let [right, bottom] = corner(self.columns.end, self.rows.end);
        [[left, right], [top, bottom]]
    }

    pub fn size(&self) -> [u32; 2] {
        [self.columns.len() as u32, self.rows.len() as u32]
    }
}

/// Returns the world-space unit vectors forward, right and down; `None` for a panorama.
pub fn axes(from: &Viewpoint) -> Option<[DVec3; 3]> {
    from.projection.axes().map(|axes| axes.map(|axis| from.turned(axis)))
}

/// A pixel that shows a surface, of a layer behind the first (Epipolar 3.3.2): its index in row-major order, and its value. Most
/// pixels of such a layer are empty, so that a device that draws layers transfers only a compacted list of the others.
pub type ActivePixel = [u32; 2];

/// Returns the number of active pixels in each row; a value of 0 is an empty pixel.
pub fn active_counts(shown: &[u32], width: usize) -> Vec<u32> {
    shown.chunks(width.max(1)).map(|row| row.iter().filter(|shown| **shown != 0).count() as u32).collect()
}

/// Returns the active pixels in order.
pub fn compact(shown: &[u32]) -> Vec<ActivePixel> {
    (0..).zip(shown).filter(|(_, shown)| **shown != 0).map(|(pixel, shown)| [pixel, *shown]).collect()
}

/// Writes active pixels into an empty picture. Pixels beyond its end are ignored.
pub fn spread(active: &[ActivePixel], picture: &mut [u32]) {
    for &[pixel, shown] in active {
        if let Some(at) = picture.get_mut(pixel as usize) {
            *at = shown;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_compacted_comes_back() {
        let shown = [0, 7, 0, 0, 0, 0, 3, 4, 0];
        assert_eq!(active_counts(&shown, 3), [1, 0, 2]);
        let active = compact(&shown);
        assert_eq!(active, [[1, 7], [6, 3], [7, 4]]);
        let mut again = [0; 9];
        spread(&active, &mut again);
        assert_eq!(again, shown);
        assert!(compact(&[]).is_empty() && active_counts(&[], 0).is_empty());
        spread(&[[9, 1]], &mut again);
        assert_eq!(again, shown);
    }
}
