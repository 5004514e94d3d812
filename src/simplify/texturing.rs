//! Conversion of tiles to a textured mesh: constraints and colour of all samples, textures, and one atlas (Seurat 5).

use std::time::{Duration, Instant};

use super::capture::Capture;
use super::quad_mesh::{AtlasLight, MeshForm, QuadMesh};
use super::region::ViewingRegion;
use super::samples::{PixelChoice, SampleRules};
use super::settings::Settings;
use super::shading::ShortCuts;
use super::texture_filter::TextureFilter;
use super::texture_sizes::{BLOCK, Layout, Sizing, layout};
use super::textures::{TextureBuilder, TileTextures};
use super::tiles::{QuadTile, TileSet};
use codec::error::{Error, Result};
use codec::monitor::Monitor;

/// Least relative distance to a sample within which a tile counts as the sample's surface (Seurat 5.1): that of depth errors if they are
/// larger.
const SOLID_THRESHOLD: f64 = 0.01;
/// Maximum side of a tile's texture, in texels.
const LARGEST_SIDE: f64 = 8192.0;

/// Parameters of texturing.
#[derive(Debug, Clone, Copy)]
pub struct Texturing<'a> {
    pub rules: SampleRules<'a>,
    /// Relative distance to a sample within which a tile counts as the sample's surface.
    pub solid_threshold: f64,
    /// Pixels of every `pixel_step`-th column and row are sampled.
    pub pixel_step: u32,
    /// Texels per unit of a face's plane.
    pub texels_per_unit: f64,
    pub form: MeshForm,
    /// Maximum side of the atlas, in texels.
    pub atlas: u32,
    pub sizing: Sizing,
    pub filter: TextureFilter,
    pub short_cuts: ShortCuts,
}

/// A textured mesh, and the layout of its tiles' textures.
#[derive(Debug)]
pub struct Textured {
    pub scene: QuadMesh,
    pub layout: Layout,
    pub solid_constraints: u64,
    pub free_space_constraints: u64,
    /// Number of samples along which there is no tile.
    pub uncovered_samples: u64,
    pub opaque_tiles: u64,
    pub filled_texels: u64,
    pub filled_tiles: u64,
    /// Durations of constraints, textures and atlas.
    pub durations: [Duration; 3],
}

impl<'a> Texturing<'a> {
    /// Returns the parameters for a capture.
    pub fn new(capture: &Capture, settings: &Settings, region: &'a ViewingRegion) -> Texturing<'a> {
        let light = if settings.short_cuts == ShortCuts::Taken { settings.light } else { AtlasLight::HalfFloats };
        Texturing {
            rules: SampleRules {
                region,
                background: settings.background,
                inside: settings.inside,
                baked: settings.baked,
            },
            solid_threshold: capture.relative_depth_error.unwrap_or(0.0).max(SOLID_THRESHOLD),
            pixel_step: 1,
            texels_per_unit: settings.texels_per_unit(capture),
            form: MeshForm { middle: region.middle, coordinates: settings.texture_coordinates, light },
            atlas: settings.atlas,
            sizing: settings.sizing,
            filter: settings.texture_filter,
            short_cuts: settings.short_cuts,
        }
    }

    /// Returns the parameters for textures of half the size, from a quarter of the samples.
    pub fn coarse(self) -> Self {
        Texturing { texels_per_unit: 0.5 * self.texels_per_unit, pixel_step: 2, ..self }
    }

    /// Builds the textured mesh. Reads all samples once.
    pub fn run(&self, tiles: &TileSet, capture: &mut Capture, monitor: &dyn Monitor) -> Result<Textured> {
        let begun = Instant::now();
        let sides = self.sides(tiles);
        let mut builder = TextureBuilder::new(tiles, &sides, self.solid_threshold, self.filter);
        self.rules.of_all_images(capture, PixelChoice::Every(self.pixel_step), monitor, |samples, _| {
            builder.add(&samples);
        })?;
        let (solid_constraints, free_space_constraints, uncovered_samples) =
            (builder.solid, builder.free, builder.uncovered);
        let constrained = begun.elapsed();
        let TileTextures { textures, filled_texels, filled_tiles } = builder.finish(self.short_cuts);
        let shaded = begun.elapsed();
        let layout = layout(&textures, self.atlas, self.sizing, monitor)?;
        let opaque_tiles = textures.iter().filter(|texture| texture.is_opaque).count() as u64;
        let scene = QuadMesh::new(tiles, textures, &layout, &self.form);
        if !scene.mesh.positions.iter().all(|position| position.is_finite()) {
            return Err(Error::Usage(
                "surfaces lie too far away, or too near to the middle of the region, for the single precision of a mesh".into(),
            ));
        }
        Ok(Textured {
            scene,
            layout,
            solid_constraints,
            free_space_constraints,
            uncovered_samples,
            opaque_tiles,
            filled_texels,
            filled_tiles,
            durations: [constrained, shaded - constrained, begun.elapsed() - shaded],
        })
    }

    /// Returns the side of each tile's texture, in texels.
    pub fn sides(&self, tiles: &TileSet) -> Vec<usize> {
        tiles.tiles.iter().map(|tile| self.side(tile)).collect()
    }

    fn side(&self, tile: &QuadTile) -> usize {
        let texels = (tile.rect.longer_side() * self.texels_per_unit).ceil().min(LARGEST_SIDE) as usize + 1;
        texels.next_multiple_of(BLOCK)
    }
}

/// Returns a note if the depth of a capture has errors that are unknown or above what a tile takes for its surface by default.
pub fn depth_note(capture: &Capture) -> Option<String> {
    match capture.relative_depth_error {
        Some(error) if error <= SOLID_THRESHOLD => None,
        Some(error) => Some(format!(
            "the depth of the container has errors up to {:.2}%: a tile within that distance of a sample counts as its surface, instead \
            of {:.0}%",
            100.0 * error,
            100.0 * SOLID_THRESHOLD
        )),
        None => Some("the depth of the container has no error bound".into()),
    }
}
