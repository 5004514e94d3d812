//! Closes cracks: pixels that show nothing although the capture has a surface.
//!
//! Takes the textured mesh and pictures of it, and makes texels opaque. A place of a tile with both kinds of constraints counts
//! as neither (Seurat 5.1), so that a thin surface can vanish from all tiles.

use std::sync::Arc;

use super::capture::{Capture, CaptureImage};
use super::gaps::Coverage;
use super::quad_mesh::QuadMesh;
use super::raster::alpha::AlphaRaster;
use super::region::ViewingRegion;
use super::samples::{Background, PixelChoice, Sample, SampleRules};
use super::texture_sizes::Layout;
use super::tiles::TileSet;
use super::tree::project;
use codec::error::Result;
use codec::math::Camera;
use scene::mesh::Ray;

/// Alpha below which a pixel is a crack.
pub const CRACK_ALPHA: f32 = 0.5;
/// Alpha below which a pixel is translucent: 1 minus half a code.
pub const OPAQUE_ALPHA: f32 = 1.0 - 0.5 / 255.0;
/// Maximum number of texels around those at a crack that are also made opaque if the crack stays open.
const REACH: u32 = 2;

/// Minimum and maximum side in pixels of the pictures from eyes in the region.
const EYE_SIDES: [u32; 2] = [256, 512];

/// Tiles of a mesh, and the layout of their textures.
#[derive(Debug, Clone, Copy)]
pub struct PlacedTiles<'a> {
    pub tiles: &'a TileSet,
    pub layout: &'a Layout,
}

/// Number of pixels of one image of the capture that were closed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Closed {
    pub cracks: u64,
    /// Pixels that were more than half covered, in front of a background that covers everything.
    pub translucent: u64,
}

/// Returns the side in pixels of the pictures from eyes in the region: four times that of the largest image, within limits.
/// Cracks are narrower than the pixels of images: pictures of 256 pixels miss some of images of 128.
pub fn eye_side(capture: &Capture) -> u32 {
    let largest = capture.images.iter().flat_map(|image| image.size).max().unwrap_or(0);
    largest.saturating_mul(4).clamp(EYE_SIDES[0], EYE_SIDES[1])
}

/// Returns the picture of an image of the capture; `None` if the image has no camera or the picture no gap. Pixels whose rays
/// meet a tile count as covered.
pub fn picture(scene: &QuadMesh, region: &ViewingRegion, tiles: &TileSet, image: &CaptureImage) -> Option<Coverage> {
    let CaptureImage { camera: Some(camera), size, .. } = *image else { return None };
    let covered = covered(scene, &camera, size, CRACK_ALPHA);
    let mut picture = Coverage { camera: camera.moved(-region.middle), size, covered };
    picture.cover(|ray| tiles.is_crossed(ray));
    Some(picture).filter(|picture| picture.gaps().next().is_some())
}

/// Returns true for each pixel with at least this alpha, in row-major order.
pub(super) fn covered(scene: &QuadMesh, camera: &Camera, size: [u32; 2], wanted: f32) -> Vec<bool> {
    let mut raster = AlphaRaster::new(scene, camera, size);
    raster.draw(scene, wanted).iter().map(|alpha| *alpha >= wanted).collect()
}

/// Choice of the tile along a ray that is made opaque.
#[derive(Debug, Clone, Copy, PartialEq)]
enum TileChoice {
    /// The tile nearest to a surface at this distance, in metres.
    NearestTo(f64),
    Farthest,
    /// The rearmost tile in drawing order.
    First,
}

/// A ray that must end at a tile. The texels around its hit become opaque, and `reach` more on each side.
#[derive(Debug, Clone, Copy)]
struct Opening {
    ray: Ray,
    choice: TileChoice,
    reach: u32,
}

impl PlacedTiles<'_> {
    /// Closes the cracks of one image of the capture, and makes translucent pixels opaque if the sky covers everything.
    pub fn close_in_image(
        &self,
        capture: &mut Capture,
        image: usize,
        rules: &SampleRules<'_>,
        scene: &mut QuadMesh,
    ) -> Result<Closed> {
        let mut closed = Closed::default();
        let CaptureImage { camera: Some(camera), size, .. } = capture.images[image] else { return Ok(closed) };
        let wanted = if rules.background == Background::Sky { OPAQUE_ALPHA } else { CRACK_ALPHA };
        let mut raster = AlphaRaster::new(scene, &camera, size);
        // Nearly every image has such pixels, so its rays are read in parallel.
        let (_, rays) = rayon::join(|| raster.draw(scene, wanted).len(), || capture.rays(image));
        let rays = rays?;
        let mut samples: Option<Vec<Sample>> = None;
        // Texture coordinates of the mesh differ from those of tiles by up to half a texel, so that a crack may need a larger
        // reach.
        for reach in 0..=REACH {
            let pixels = raster.draw(scene, wanted);
            let open: Vec<u32> = (0..).zip(pixels).filter(|(_, alpha)| **alpha < wanted).map(|(at, _)| at).collect();
            if open.is_empty() {
                break;
            }
            // The open pixels of later passes are a subset of those of the first.
            if samples.is_none() {
                samples = Some(rules.of_rays(capture, image, &rays, PixelChoice::Listed(&open))?.0);
            }
            let alpha = |sample: &Sample| pixels[sample.pixel as usize];
            for sample in samples.iter().flatten().filter(|sample| sample.is_surface && alpha(sample) < wanted) {
                let along = sample.end - sample.origin;
                let Some(ray) = Ray::new(sample.origin, along) else { continue };
                let is_crack = alpha(sample) < CRACK_ALPHA;
                let choice = if is_crack { TileChoice::NearestTo(along.length()) } else { TileChoice::First };
                let is_closed = self.close(Opening { ray, choice, reach }, scene);
                let count = if is_crack { &mut closed.cracks } else { &mut closed.translucent };
                *count += u64::from(is_closed && reach == 0);
            }
        }
        Ok(closed)
    }

    /// Closes the cracks that pictures show, and returns their number.
    pub fn close_in_pictures(&self, pictures: &[Coverage], scene: &mut QuadMesh) -> u64 {
        let rays = pictures.iter().flat_map(Coverage::gaps);
        let openings = rays.map(|ray| Opening { ray, choice: TileChoice::Farthest, reach: 0 });
        openings.filter(|opening| self.close(*opening, scene)).count() as u64
    }

    /// Makes texels at the hit of a ray opaque. Returns true if the ray meets a tile.
    fn close(&self, Opening { ray, choice, reach }: Opening, scene: &mut QuadMesh) -> bool {
        let rank = |&(tile, distance): &(u32, f64)| match choice {
            TileChoice::NearestTo(metres) => (distance / metres - 1.0).abs(),
            TileChoice::Farthest => -distance,
            TileChoice::First => f64::from(tile),
        };
        let PlacedTiles { tiles, layout } = self;
        let crossed = tiles.crossed(&ray);
        let Some(&(tile, distance)) = crossed.iter().min_by(|a, b| rank(a).total_cmp(&rank(b))) else { return false };
        let quad = &tiles.tiles[tile as usize];
        let Some(at) = project(quad.cell.face, ray.at(distance)) else { return false };
        let place = layout.places[tile as usize];
        let last = f64::from(place.side - 1);
        let [x, y] = tiles.texture_position(tile, at).map(|at| (at.clamp(0.0, 1.0) * last) as u32);
        for row in y.saturating_sub(reach)..=(y + 1 + reach).min(place.side - 1) {
            for column in x.saturating_sub(reach)..=(x + 1 + reach).min(place.side - 1) {
                let texel = (place.corner[1] + row) * layout.size[0] + place.corner[0] + column;
                Arc::make_mut(&mut scene.texture).pixels[texel as usize][3] = u8::MAX;
            }
        }
        true
    }
}
