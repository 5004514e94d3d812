//! Extends the tiles of a selection over gaps, which are found in pictures of the tiles with textures of half the size.

use glam::DVec3;
use rayon::prelude::*;

use super::budgeted::BudgetedTiles;
use super::capture::Capture;
use super::cost::{CostModel, ViewShares};
use super::cracks::{self, CRACK_ALPHA};
use super::gaps::{Account, Coverage, Extensions, SeenDirections};
use super::memory::check_textures;
use super::overdraw::{OverdrawMeter, peak};
use super::quad_mesh::QuadMesh;
use super::region::ViewingRegion;
use super::samples::Background;
use super::selection::Selection;
use super::settings::Settings;
use super::shading::ShortCuts;
use super::texturing::Texturing;
use super::tiles::TileSet;
use codec::error::Result;
use codec::image::Face;
use codec::math::{Camera, Lens};
use codec::monitor::Monitor;

/// Parts of the overdraw that a selection leaves up to which tiles are extended, tried in this order: what is measured of extended
/// tiles may be more than what their estimates add up to.
const SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.0];

/// The viewing region, and where it has surfaces around it.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'a> {
    pub region: &'a ViewingRegion,
    pub seen: &'a SeenDirections,
    pub background: Background,
    /// Side in pixels of the pictures from eyes in the region.
    pub eye_side: u32,
}

impl Surroundings<'_> {
    /// Returns pictures of all directions from eyes in the region. Pixels with at least this alpha count as covered.
    ///
    /// Unless there is a surface in all directions, a gap cannot be distinguished from empty space, and there are no pictures.
    pub fn pictures(&self, scene: &QuadMesh, alpha: f32, monitor: &dyn Monitor) -> Result<Vec<Coverage>> {
        let eyes = if self.background == Background::Sky { self.region.eyes() } else { Vec::new() };
        let each = eyes.par_iter().map(|&eye| {
            monitor.check()?;
            Face::CUBE.into_iter().map(|face| self.picture(scene, (eye, face), alpha)).collect::<Result<Vec<_>>>()
        });
        Ok(each.collect::<Result<Vec<_>>>()?.concat())
    }

    /// Returns the picture of a face of the cube around an eye. Directions without surfaces count as covered.
    fn picture(&self, scene: &QuadMesh, (eye, face): (DVec3, Face), alpha: f32) -> Result<Coverage> {
        let camera = |eye: DVec3| Camera::with_axes(eye, face.axes(), Lens::new(90.0));
        let size = [self.eye_side; 2];
        let covered = cracks::covered(scene, &camera(self.region.middle + eye)?, size, alpha);
        let mut picture = Coverage { camera: camera(eye)?, size, covered };
        picture.cover(|ray| !self.seen.contains(ray.direction()));
        Ok(picture)
    }
}

/// Inputs of the extension.
pub struct Extender<'a> {
    pub texturing: Texturing<'a>,
    pub surroundings: Surroundings<'a>,
    pub model: &'a CostModel,
    pub shares: &'a ViewShares,
    pub meter: &'a OverdrawMeter,
    pub settings: &'a Settings,
}

/// Tiles of a selection, extended over gaps as far as budgets allow.
pub struct ExtendedTiles {
    pub selection: Selection,
    pub tiles: TileSet,
    /// Triangles, area in spheres, and the measured overdraw of the view with the most.
    pub used: [f64; 3],
    /// Number of extended tiles.
    pub count: u64,
    /// Fraction of the rays from eyes in the region that meet no surface that a camera has seen, before tiles are extended; `None`
    /// without a sky.
    pub unsupported: Option<f64>,
}

impl Extender<'_> {
    /// Extends tiles. Reads a quarter of all samples.
    pub fn extend(
        &self,
        BudgetedTiles { selection, tiles, capacity }: BudgetedTiles,
        capture: &mut Capture,
        monitor: &dyn Monitor,
    ) -> Result<ExtendedTiles> {
        check_textures(capture, &self.texturing.sides(&tiles), self.settings)?;
        let mut coarse = self.texturing.coarse().run(&tiles, capture, monitor)?;
        if self.settings.short_cuts == ShortCuts::Off {
            coarse.scene.runs.clear();
        }
        let [mut seen_by_cameras, mut seen_by_eyes] = [(); 2].map(|()| Extensions::new(&tiles));
        let pictures = self.surroundings.pictures(&coarse.scene, CRACK_ALPHA, monitor)?;
        pictures.iter().for_each(|picture| seen_by_eyes.add(picture));
        let gaps = pictures.iter().map(|picture| picture.gaps().count()).sum::<usize>() as f64;
        let pixels: usize = pictures.iter().map(|picture| picture.covered.len()).sum();
        let unsupported = (pixels > 0).then(|| gaps / pixels as f64);
        drop(pictures);
        let of_image = |image| {
            monitor.check()?;
            Ok(cracks::picture(&coarse.scene, self.surroundings.region, &tiles, image))
        };
        // Few pictures at once, because each has the pixels of an image.
        for images in capture.images.chunks(rayon::current_num_threads()) {
            let pictures: Vec<_> = images.par_iter().map(of_image).collect::<Result<_>>()?;
            pictures.iter().flatten().for_each(|picture| seen_by_cameras.add(picture));
        }
        drop(coarse);
        for share in SHARES {
            let mut capacity = capacity;
            for (capacity, used) in capacity.iter_mut().zip(&selection.used).skip(2) {
                *capacity = used + share * (*capacity - used);
            }
            let mut account = Account { model: self.model, shares: self.shares, used: selection.used, capacity };
            let mut extended = tiles.tiles.clone();
            // Gaps of cameras come first: images of the capture must not have cracks.
            seen_by_cameras.extend(&mut extended, &mut account);
            seen_by_eyes.extend(&mut extended, &mut account);
            let count = extended.iter().zip(&tiles.tiles).filter(|(after, before)| after.rect != before.rect).count();
            let extended = tiles.with(extended);
            let overdraw = peak(&self.meter.measure(&extended)?);
            if overdraw <= self.settings.budgets.peak_overdraw {
                let used = [account.used[0], account.used[1], overdraw];
                return Ok(ExtendedTiles { selection, tiles: extended, used, count: count as u64, unsupported });
            }
        }
        let used = [selection.used[0], selection.used[1], peak(&self.meter.measure(&tiles)?)];
        Ok(ExtendedTiles { selection, tiles, used, count: 0, unsupported })
    }
}
