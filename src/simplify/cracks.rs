//! Closes cracks: pixels through which nothing is seen, though there is a surface.
//!
//! Enters: the textured mesh, and pictures of it. Leaves: texels that are opaque. Places of a tile with both kinds of constraints have
//! neither (Seurat 5.1), so that a thin surface can vanish from all tiles.

use std::sync::Arc;

use glam::DVec3;

use super::capture::{Capture, CaptureImage};
use super::gaps::{self, Coverage, SeenDirections};
use super::quad_mesh::QuadMesh;
use super::raster::{Drawn, draw};
use super::region::ViewingRegion;
use super::samples::{Sample, SampleRules};
use super::texture_sizes::Layout;
use super::tiles::TileSet;
use super::tree::project;
use crate::error::Result;
use crate::image::Face;
use crate::math::{Camera, Lens};
use crate::mesh::Ray;

/// A pixel of less alpha is a crack.
pub const CRACK_ALPHA: f32 = 0.5;
/// Texels beside those around a crack that are made opaque, too, where it stays open.
const REACH: u32 = 2;

/// The tiles of a mesh, and where their textures lie.
pub type Placed<'a> = (&'a TileSet, &'a Layout);

/// Closes the cracks of one image of the capture; answers their number.
pub fn close_in_image(
    capture: &mut Capture,
    image: usize,
    rules: &SampleRules<'_>,
    placed: Placed<'_>,
    scene: &mut QuadMesh,
) -> Result<u64> {
    let CaptureImage { camera: Some(camera), size, .. } = capture.images[image] else { return Ok(0) };
    let mut closed = 0;
    // Texture coordinates of the mesh differ from those of tiles by up to half a texel.
    for reach in 0..=REACH {
        let Drawn { pixels, .. } = draw(scene, &camera, size);
        if pixels.iter().all(|pixel| pixel[3] >= CRACK_ALPHA) {
            break;
        }
        let (samples, _) = rules.samples(capture, image)?;
        let is_crack = |sample: &&Sample| sample.is_surface && pixels[sample.pixel as usize][3] < CRACK_ALPHA;
        for sample in samples.iter().filter(is_crack) {
            let along = sample.end - sample.origin;
            let Some(ray) = Ray::new(sample.origin, along) else { continue };
            closed += u64::from(close((&ray, along.length(), reach), placed, scene));
        }
    }
    Ok(closed)
}

/// Pictures of all directions from an eye in the region.
pub fn pictures(scene: &QuadMesh, region: &ViewingRegion, eye: DVec3) -> Result<Vec<Coverage>> {
    let picture = |face: Face| {
        let camera = Camera::with_axes(region.middle + eye, face.axes(), Lens::new(90.0))?;
        let drawn = draw(scene, &camera, [gaps::SIDE; 2]);
        Ok(Coverage { eye, face, covered: drawn.pixels.iter().map(|pixel| pixel[3] >= CRACK_ALPHA).collect() })
    };
    Face::CUBE.into_iter().map(picture).collect()
}

/// Closes cracks that an eye in the region sees in directions in which there are surfaces; answers their number.
pub fn close_in_pictures(
    pictures: &[Coverage],
    seen: &SeenDirections,
    placed: Placed<'_>,
    scene: &mut QuadMesh,
) -> u64 {
    let rays = pictures.iter().flat_map(|picture| picture.gaps(seen));
    rays.filter(|ray| close((ray, f64::INFINITY, 0), placed, scene)).count() as u64
}

/// Makes the texels opaque that a ray passes between, and `reach` more on each side: of the tile that it meets nearest to a surface at
/// `distance_m`, or of the farthest one where that is infinite. Answers whether it meets one.
pub fn close((ray, distance_m, reach): (&Ray, f64, u32), (tiles, layout): Placed<'_>, scene: &mut QuadMesh) -> bool {
    let crossed = tiles.crossed(ray);
    let beside = |distance: f64| if distance_m.is_finite() { (distance / distance_m - 1.0).abs() } else { -distance };
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
