//! Metallic-roughness materials (glTF 2.0, section 3.9).

use std::sync::Arc;

use glam::DVec3;

use super::texture::ImageTexture;

/// A metallic-roughness material. Colours are linear Rec. 709; factors are in 0..=1 unless another range is given.
#[derive(Debug, Clone)]
pub struct Material {
    pub name: String,
    /// Multiplied by the texture.
    pub base_color: DVec3,
    /// Multiplied by the alpha of the texture.
    pub alpha: f64,
    pub base_texture: Option<Arc<ImageTexture>>,
    /// Surfaces with an alpha below this are holes; `None` for an opaque material.
    pub alpha_cutoff: Option<f64>,
    /// True if a rasteriser blends it by its alpha; rays treat alpha below the cutoff as a hole.
    pub is_blended: bool,
    /// Constant over the surface: the mean of a texture.
    pub metallic: f64,
    /// Constant, as [`Self::metallic`].
    pub roughness: f64,
    /// Reflectance of a dielectric at normal incidence; `None` if it follows from the index of refraction.
    pub specular: Option<DVec3>,
    /// Index of refraction, 1..=100.
    pub ior: f64,
    /// Fraction of light that passes through the surface; constant, as [`Self::metallic`].
    pub transmission: f64,
    /// Radiance, at least 0; multiplied by the texture.
    pub emission: DVec3,
    pub emissive_texture: Option<Arc<ImageTexture>>,
    /// True if it shows its base colour without shading.
    pub unlit: bool,
}

impl Default for Material {
    /// Returns a matte 80% grey.
    fn default() -> Self {
        Material {
            name: String::new(),
            base_color: DVec3::splat(0.8),
            alpha: 1.0,
            base_texture: None,
            alpha_cutoff: None,
            is_blended: false,
            metallic: 0.0,
            roughness: 1.0,
            specular: Some(DVec3::ZERO),
            ior: 1.5,
            transmission: 0.0,
            emission: DVec3::ZERO,
            emissive_texture: None,
            unlit: false,
        }
    }
}
