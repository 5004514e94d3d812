//! Triangles and what they are painted with, as every kind of mesh file is brought into.
//!
//! Enters: nothing; these are plain data, in world space, metres, at one moment. [`super::bvh::MeshBvh`] makes them
//! visible to rays, [`super::model`] reads them from files.

use std::sync::Arc;

use glam::{DVec2, DVec3, DVec4, Vec2, Vec3, Vec4};

use super::texture::ImageTexture;

/// Triangles in the world at one moment.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Corners, metres. Triangles with a corner that is not finite are left out of rays and samples.
    pub positions: Vec<DVec3>,
    /// Shading normal of each corner, of any length above 0; empty where triangles are flat.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of each corner, (0, 0) the top left of an image; empty where there are none.
    pub uvs: Vec<Vec2>,
    /// Colour and alpha of each corner, linear, 0..=1, multiplied with the base colour and its alpha; empty where there are
    /// none.
    pub colors: Vec<Vec4>,
    /// Corners of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Self::materials`] of each triangle.
    pub material_of: Vec<u32>,
    /// What the triangles are painted with.
    pub materials: Arc<[MeshMaterial]>,
}

/// A part of the light that leaves a surface by mirror reflection or refraction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Optics {
    /// None.
    #[default]
    Opaque,
    /// All of it is reflected, times this tint (linear, 0..=1).
    Mirror {
        /// Reflectance.
        tint: DVec3,
    },
    /// Clear glass: reflected and refracted by Fresnel's equations.
    Glass {
        /// Index of refraction, 1 or more.
        ior: f64,
        /// What is left of light that passes (linear, 0..=1).
        tint: DVec3,
    },
}

/// A highlight by Phong's model, normalised: `weight · (n + 2)/2 · cosⁿ` of the angle to the mirror direction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Phong {
    /// Linear, 0..=1; zero for a matt surface.
    pub weight: DVec3,
    /// n, at least 1.
    pub exponent: f64,
}

/// What triangles are painted with.
#[derive(Debug, Clone)]
pub struct MeshMaterial {
    /// Name in the file, for notes.
    pub name: String,
    /// Diffuse albedo, linear, multiplied with the texture's.
    pub base_color: DVec3,
    /// Texture of the albedo.
    pub base_texture: Option<Arc<ImageTexture>>,
    /// Where alpha times the texture's lies below this, there is a hole; `None` for no holes.
    pub alpha_cutoff: Option<f64>,
    /// Alpha, multiplied with the texture's.
    pub alpha: f64,
    /// Radiance given off, linear, multiplied with the texture's.
    pub emission: DVec3,
    /// Texture of the emission.
    pub emissive_texture: Option<Arc<ImageTexture>>,
    /// Highlight.
    pub phong: Phong,
    /// The part of its weight that is the base colour of a metal, and takes the colours of corners as that does.
    pub metal: DVec3,
    /// Mirror or glass.
    pub optics: Optics,
    /// Whether it shines with its colour whatever the light.
    pub unlit: bool,
}

impl Default for MeshMaterial {
    /// Matt, 80% grey.
    fn default() -> Self {
        MeshMaterial {
            name: String::new(),
            base_color: DVec3::splat(0.8),
            base_texture: None,
            alpha_cutoff: None,
            alpha: 1.0,
            emission: DVec3::ZERO,
            emissive_texture: None,
            phong: Phong::default(),
            metal: DVec3::ZERO,
            optics: Optics::Opaque,
            unlit: false,
        }
    }
}

impl Mesh {
    /// Corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|corner| self.positions[corner as usize])
    }

    /// Texture coordinates at barycentric coordinates (weights of the second and third corner); (0, 0) without any.
    pub fn uv(&self, triangle: usize, at: DVec2) -> DVec2 {
        if self.uvs.is_empty() {
            return DVec2::ZERO;
        }
        let [a, b, c] = self.triangles[triangle].map(|corner| self.uvs[corner as usize].as_dvec2());
        a + at.x * (b - a) + at.y * (c - a)
    }

    /// Colour and alpha between the corners, as [`Self::uv`]; `None` without any.
    pub fn color(&self, triangle: usize, at: DVec2) -> Option<DVec4> {
        if self.colors.is_empty() {
            return None;
        }
        let [a, b, c] = self.triangles[triangle].map(|corner| self.colors[corner as usize].as_dvec4());
        Some(a + at.x * (b - a) + at.y * (c - a))
    }

    /// Whether the triangle's material has a hole there, at barycentric coordinates as for [`Self::uv`].
    pub fn is_hole(&self, triangle: usize, at: DVec2) -> bool {
        let material = self.material_of.get(triangle).and_then(|&index| self.materials.get(index as usize));
        let Some((material, cutoff)) = material.and_then(|material| Some((material, material.alpha_cutoff?))) else {
            return false;
        };
        let mut alpha = material.alpha;
        if let Some(texture) = &material.base_texture {
            alpha *= texture.sample(self.uv(triangle, at)).1;
        }
        if let Some(color) = self.color(triangle, at) {
            alpha *= color.w;
        }
        alpha < cutoff
    }
}
