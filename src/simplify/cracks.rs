//! Closes cracks: pixels of the capture through which nothing is seen, though it has a surface there.
//!
//! Enters: the textured mesh, and a sample whose pixel is a crack. Leaves: texels of the tile nearest to the surface, opaque.
//! Places of a tile with both kinds of constraints have neither (Seurat 5.1), so that a thin surface can vanish from all tiles.

use std::sync::Arc;

use super::quad_mesh::QuadMesh;
use super::samples::Sample;
use super::texture_sizes::Layout;
use super::tiles::TileSet;
use super::tree::project;
use crate::mesh::Ray;

/// A pixel of less alpha is a crack.
pub const CRACK_ALPHA: f32 = 0.5;

/// Makes the texels opaque that the ray of a sample passes between, and `reach` more on each side, of the tile that it meets nearest to
/// its end. Answers whether it meets one.
pub fn close((sample, reach): (&Sample, u32), tiles: &TileSet, layout: &Layout, scene: &mut QuadMesh) -> bool {
    let along = sample.end - sample.origin;
    let Some(ray) = Ray::new(sample.origin, along) else { return false };
    let beside = |distance: f64| (distance / along.length() - 1.0).abs();
    let crossed = tiles.crossed(&ray);
    let Some(&(tile, distance)) = crossed.iter().min_by(|a, b| beside(a.1).total_cmp(&beside(b.1))) else {
        return false;
    };
    let quad = &tiles.tiles[tile as usize];
    let Some(at) = project(quad.cell.face, ray.at(distance)) else { return false };
    let place = layout.places[tile as usize];
    let last = f64::from(place.side - 1);
    let [x, y] = quad.texture_position(at).map(|at| (at.clamp(0.0, 1.0) * last) as u32);
    for row in y.saturating_sub(reach)..=(y + 1 + reach).min(place.side - 1) {
        for column in x.saturating_sub(reach)..=(x + 1 + reach).min(place.side - 1) {
            let texel = (place.corner[1] + row) * layout.size[0] + place.corner[0] + column;
            Arc::make_mut(&mut scene.texture).pixels[texel as usize][3] = u8::MAX;
        }
    }
    true
}
