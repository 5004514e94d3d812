//! Overdraw of a tiling, measured on pictures of it from the viewing region (Seurat 4).
//!
//! Selection adds up estimates, in which each tile is seen from the eye that sees it largest. No eye sees all tiles like that: the sum is
//! 1.5 to 2.2 times the overdraw of pictures.

use glam::DVec3;
use rayon::prelude::*;

use super::cost::{VIEWS, view_axes};
use super::quad_mesh::QuadMesh;
use super::raster::overdraw;
use super::tiles::TileSet;
use super::tree::TreeCell;
use codec::error::Result;
use codec::image::Face;
use codec::math::{Camera, Lens};

/// Tree level whose cells are the pixels of the measured pictures: 64x64 a face.
const PIXEL_LEVEL: u32 = 6;
/// Number of rays in each row and column of a view.
const VIEW_SIDE: u32 = 32;

/// Overdraw of each view.
pub type ViewOverdraw = [f64; VIEWS];

/// Measures the mean overdraw of all views from several eyes.
#[derive(Debug)]
pub struct OverdrawMeter {
    /// Eyes relative to the centre of the region.
    eyes: Vec<DVec3>,
    /// Indices of the pixels that each view sees.
    views: Vec<Vec<u32>>,
}

impl OverdrawMeter {
    pub fn new(eyes: Vec<DVec3>) -> OverdrawMeter {
        let pixels = |[forward, right, down]: [DVec3; 3]| -> Vec<u32> {
            let at = |step: u32| (2.0 * f64::from(step) + 1.0) / f64::from(VIEW_SIDE) - 1.0;
            let ray = |index: u32| forward + at(index % VIEW_SIDE) * right + at(index / VIEW_SIDE) * down;
            let pixel = |index: u32| TreeCell::containing(ray(index), PIXEL_LEVEL).index() as u32;
            (0..VIEW_SIDE * VIEW_SIDE).map(pixel).collect()
        };
        OverdrawMeter { eyes, views: view_axes().into_iter().map(pixels).collect() }
    }

    /// Returns for each view its mean number of tiles per pixel, from the eye with the most.
    ///
    /// # Errors
    /// Those of [`Camera::with_axes`].
    pub fn measure(&self, tiles: &TileSet) -> Result<ViewOverdraw> {
        let shapes = QuadMesh::of_shapes(tiles);
        let from = |&eye: &DVec3| -> Result<ViewOverdraw> {
            let mut counts = Vec::with_capacity(TreeCell::count(PIXEL_LEVEL));
            for face in Face::CUBE {
                let camera = Camera::with_axes(eye, face.axes(), Lens::new(90.0))?;
                counts.extend_from_slice(overdraw(&shapes, &camera, [1 << PIXEL_LEVEL; 2])?.data());
            }
            Ok(std::array::from_fn(|view| {
                let pixels = &self.views[view];
                pixels.iter().map(|&pixel| f64::from(counts[pixel as usize])).sum::<f64>() / pixels.len() as f64
            }))
        };
        let of_eyes: Vec<ViewOverdraw> = self.eyes.par_iter().map(from).collect::<Result<_>>()?;
        Ok(std::array::from_fn(|view| of_eyes.iter().map(|views| views[view]).fold(0.0, f64::max)))
    }
}

/// Returns the overdraw of the view with the most.
pub fn peak(views: &ViewOverdraw) -> f64 {
    views.iter().copied().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::TextureCoordinates;
    use crate::tile_plane::TilePlane;
    use crate::tiles::{QuadTile, TileForm};

    fn cube(layers: &[f64]) -> TileSet {
        let tile = |cell: TreeCell, metres: f64| {
            let [forward, ..] = cell.face.axes();
            QuadTile { cell, plane: TilePlane(forward / metres), rect: cell.rect(0.0), divisions: [1, 1] }
        };
        let of = |&metres: &f64| TreeCell::ROOTS.map(|cell| tile(cell, metres));
        TileSet::in_order(layers.iter().flat_map(of).collect(), TileForm::as_fitted(TextureCoordinates::Affine))
    }

    #[test]
    fn layers_are_counted_in_all_views() {
        let meter = OverdrawMeter::new(vec![DVec3::ZERO, DVec3::new(0.5, 0.2, -0.3)]);
        assert!(meter.measure(&cube(&[2.0])).unwrap().iter().all(|mean| *mean == 1.0));
        assert!(meter.measure(&cube(&[9.0, 5.0, 2.0])).unwrap().iter().all(|mean| *mean == 3.0));
    }

    #[test]
    fn what_an_eye_sees_larger_counts_more() {
        // One side only: a quad at 1 m, which fills a quarter of the view from 1 m behind the centre.
        let one = cube(&[1.0]).tiles[0];
        let tiles = TileSet::in_order(vec![one], TileForm::as_fitted(TextureCoordinates::Affine));
        let [forward, ..] = one.cell.face.axes();
        // The first view is that of the first face.
        let of = |eyes: Vec<DVec3>| OverdrawMeter::new(eyes).measure(&tiles).unwrap();
        assert_eq!((of(vec![DVec3::ZERO])[0], of(vec![-forward])[0]), (1.0, 0.25));
        assert_eq!(peak(&of(vec![-forward, DVec3::ZERO])), 1.0);
    }
}
