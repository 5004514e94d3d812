//! Settings of simplification.

use super::budgets::Budgets;
use super::capture::Capture;
use super::cost::TextureCoordinates;
use super::energy::EnergyKind;
use super::quad_mesh::AtlasLight;
use super::samples::{Background, BakedLight, Inside};
use super::shading::ShortCuts;
use super::texture_filter::TextureFilter;
use super::texture_sizes::Sizing;
use codec::effort::Effort;
use codec::memory::Budget;
use scene::placement::Region;

/// Maximum number of texels of all tiles before reduction, as a multiple of those of the atlas.
const TEXELS_BEFORE_ATLAS: f64 = 2.0;
/// Number of texels per pixel of the capture along one axis, at least and at most. With only one, texels would blur again what pixels
/// have already blurred.
const TEXELS_ACROSS_PIXEL: [f64; 2] = [1.5, 3.0];
/// Number of samples that a texel should have, so that the noise of a single one does not become texture.
const SAMPLES_A_TEXEL: f64 = 2.0;
/// Maximum area that tiles cover in practice, in spheres, whatever the budget.
const MAX_AREA: f64 = 64.0;

/// Cells that get tilings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TilingKind {
    /// All cells of the trees.
    Quadtree,
    /// Cells of one level.
    Uniform,
}

#[derive(Debug, Clone)]
pub struct Settings {
    pub budgets: Budgets,
    /// Maximum side of the atlas, in texels.
    pub atlas: u32,
    /// Texels per degree at the centre of a cube face; `None` for 1.5 to 3 times the pixels of the capture, by its number of cameras.
    pub pixels_per_degree: Option<f64>,
    /// Viewing region; `None` for the box around the cameras.
    pub region: Option<Region>,
    pub background: Background,
    pub inside: Inside,
    pub baked: BakedLight,
    pub effort: Effort,
    pub energy: EnergyKind,
    pub tiling: TilingKind,
    pub sizing: Sizing,
    pub texture_filter: TextureFilter,
    pub texture_coordinates: TextureCoordinates,
    pub light: AtlasLight,
    pub surfaces: SurfaceAtlases,
    pub short_cuts: ShortCuts,
    pub memory: Budget,
}

/// Atlases other than that of colour.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SurfaceAtlases {
    #[default]
    None,
    /// Normals and material, if the capture has them.
    GBuffer,
}

impl Default for Settings {
    /// Returns the settings of the paper: 72,000 triangles, area 3, peak overdraw 5, an atlas of 4096.
    fn default() -> Settings {
        Settings {
            budgets: Budgets { triangles: 72_000.0, area: 3.0, peak_overdraw: 5.0 },
            atlas: 4096,
            pixels_per_degree: None,
            region: None,
            background: Background::Sky,
            inside: Inside::Refuse,
            baked: BakedLight::Mean,
            effort: Effort::Normal,
            energy: EnergyKind::Picture,
            tiling: TilingKind::Quadtree,
            sizing: Sizing::Adaptive,
            texture_filter: TextureFilter::Gaussian,
            texture_coordinates: TextureCoordinates::Affine,
            light: AtlasLight::Codes,
            surfaces: SurfaceAtlases::None,
            short_cuts: ShortCuts::Taken,
            memory: Budget::UNLIMITED,
        }
    }
}

impl Settings {
    /// Returns the number of texels per unit of a cube face's plane. It is limited so that all tiles together have at most
    /// `TEXELS_BEFORE_ATLAS` times the texels of the atlas if they cover the whole area budget.
    pub fn texels_per_unit(&self, capture: &Capture) -> f64 {
        let [least, most] = TEXELS_ACROSS_PIXEL;
        let across = (capture.eye_count() as f64 / SAMPLES_A_TEXEL).sqrt().clamp(least, most);
        let wanted = self.pixels_per_degree.map_or_else(|| across * capture.pixels_per_unit(), f64::to_degrees);
        let texels = TEXELS_BEFORE_ATLAS * f64::from(self.atlas).powi(2);
        wanted.min((texels / (4.0 * std::f64::consts::PI * self.budgets.area.min(MAX_AREA))).sqrt())
    }
}
