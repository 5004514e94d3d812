//! Atlases of normals and material, with the layout of the colour atlas (Seurat 5.2 covers only colour).
//!
//! Takes the tiles, the layout of their textures, and a capture with normals or material. Returns a value for each texel,
//! filtered and filled like colour.

use rayon::prelude::*;

use super::capture::{Capture, Surfaces};
use super::constraints::FreeSpace;
use super::samples::{PixelChoice, Sample, SampleRules};
use super::shading::{LightBuffer, ShortCuts};
use super::texture_filter::TextureFilter;
use super::texture_sizes::Layout;
use super::textures::{constraints_by_tile, for_each_tile};
use super::tiles::TileSet;
use codec::error::{Error, Result};
use codec::image::{MaterialPlane, NormalPlane, Plane};
use codec::monitor::Monitor;

/// Atlases other than that of colour.
#[derive(Debug, Default)]
pub struct SurfaceAtlas {
    pub normal: Option<NormalPlane>,
    /// Weights of reflection and refraction, and index of refraction.
    pub material: Option<MaterialPlane>,
}

/// Tiles, the layout of their textures, and the parameters of filtering.
#[derive(Debug, Clone, Copy)]
pub struct TexturedTiles<'a> {
    pub tiles: &'a TileSet,
    pub layout: &'a Layout,
    /// Relative distance to a sample within which a tile counts as the sample's surface.
    pub solid_threshold: f64,
    pub filter: TextureFilter,
}

/// Fails if the capture has neither normals nor material.
pub fn check(capture: &mut Capture) -> Result<()> {
    match capture.surfaces(0)? {
        Surfaces { normal: None, material: None } => {
            Err(Error::Usage("`gbuffer` needs a capture with normals or material, and this has neither".into()))
        }
        _ => Ok(()),
    }
}

/// One buffer per tile.
type Buffers = Vec<LightBuffer>;

impl TexturedTiles<'_> {
    /// Builds the atlases. Reads all images once more.
    pub fn surfaces(&self, capture: &mut Capture, rules: &SampleRules, monitor: &dyn Monitor) -> Result<SurfaceAtlas> {
        let (mut normals, mut materials): (Option<Buffers>, Option<Buffers>) = (None, None);
        for image in 0..capture.images.len() {
            monitor.check()?;
            let Surfaces { normal, material } = capture.surfaces(image)?;
            let (samples, _) = rules.samples(capture, image, PixelChoice::Every(1))?;
            for (plane, buffers) in [(normal, &mut normals), (material, &mut materials)] {
                if let Some(plane) = plane {
                    self.add(&samples, &plane, buffers.get_or_insert_with(|| self.buffers()));
                }
            }
        }
        let mut normal = normals.map(|buffers| self.atlas(buffers)).transpose()?;
        for normal in normal.iter_mut().flat_map(Plane::data_mut) {
            *normal = glam::Vec3::from_array(*normal).normalize_or_zero().to_array();
        }
        Ok(SurfaceAtlas { normal, material: materials.map(|buffers| self.atlas(buffers)).transpose()? })
    }

    fn buffers(&self) -> Buffers {
        self.layout.places.iter().map(|place| LightBuffer::new(place.side as usize, self.filter)).collect()
    }

    fn add(&self, samples: &[Sample], values: &Plane<[f32; 3]>, buffers: &mut Buffers) {
        let (found, _) = constraints_by_tile(self.tiles, self.solid_threshold, samples, FreeSpace::Ignore);
        for_each_tile(&found, buffers, |buffer, constraint| {
            let Some(sample) = constraint.sample else { return };
            let value = values.data()[samples[sample as usize].pixel as usize];
            buffer.add(constraint.texel(buffer.side()), value, 1.0);
        });
    }

    fn atlas(&self, buffers: Buffers) -> Result<Plane<[f32; 3]>> {
        let [width, height] = self.layout.size;
        let mut texels = vec![[0.0; 3]; width as usize * height as usize];
        let resolved: Vec<Vec<[f32; 4]>> =
            buffers.into_par_iter().map(|buffer| buffer.resolve(ShortCuts::Taken).0).collect();
        for (place, tile) in self.layout.places.iter().zip(resolved) {
            for (row, values) in (0..).zip(tile.chunks_exact(place.side as usize)) {
                let first = (place.corner[1] + row) as usize * width as usize + place.corner[0] as usize;
                for (texel, &[x, y, z, _]) in texels[first..].iter_mut().zip(values) {
                    *texel = [x, y, z];
                }
            }
        }
        Plane::new(width, height, texels)
    }
}
