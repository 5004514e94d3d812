//! Material of a surface point: SampleMaterial of algorithm 4 (CALF 6.1).
//!
//! Takes active views and a surface point. Returns the weights of reflection and refraction and the index of refraction,
//! interpolated like colours.

use glam::Vec3;

use crate::march::ActiveViews;
use crate::march::interpolate::surface_texels;
use codec::streams::convert::IOR_RANGE;

/// A sum of weights up to this counts as 0: half a step of their 8-bit codes.
pub const MIN_WEIGHT: f32 = 0.5 / 255.0;
/// Minimum sum of weights at which a refractive material is clear glass, which follows Fresnel's equations.
pub const CLEAR: f32 = 0.95;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Weight of mirror reflection, 0 to 1.
    pub reflect: f32,
    /// Weight of refraction, 0 to 1; at most 1 together with `reflect`.
    pub refract: f32,
    /// Index of refraction, 1 to 3.
    pub ior: f32,
}

/// Interpolates the material of a surface point. None if no view has one, or its weights are 0.
pub fn surface_material(views: &ActiveViews<'_>, point: Vec3) -> Option<Material> {
    let (mut reflect, mut refract, mut ior, mut weights) = (0.0, 0.0, 0.0, 0.0);
    surface_texels(views, point, |texel| {
        let Some(material) = &texel.face.material else { return };
        let [mirror, glass, index, _] = material[texel.texel].map(|code| f32::from(code) / 255.0);
        reflect += texel.weight * mirror;
        refract += texel.weight * glass;
        ior += texel.weight * glass * index;
        weights += texel.weight;
    });
    if reflect + refract <= MIN_WEIGHT * weights {
        return None;
    }
    let ior = if refract > 0.0 { IOR_RANGE[0] + ior / refract * (IOR_RANGE[1] - IOR_RANGE[0]) } else { IOR_RANGE[0] };
    // Weights of a damaged file may sum to more than 1.
    let whole = weights.max(reflect + refract);
    Some(Material { reflect: reflect / whole, refract: refract / whole, ior })
}

impl Material {
    /// Returns the material at another angle, whose cosine with the normal is `cosine`. Clear glass was captured with Fresnel's
    /// weights for the direction of its probe, which are replaced by those for this angle.
    #[must_use]
    pub fn at_angle(self, cosine: f32) -> Material {
        let whole = self.reflect + self.refract;
        if self.refract == 0.0 || whole < CLEAR {
            return self;
        }
        let reflect = whole * fresnel(cosine, self.ior);
        Material { reflect, refract: whole - reflect, ..self }
    }
}

/// Returns the reflected fraction of unpolarised light that enters a material of index `ior`; `cosine` is that of the angle with
/// the normal.
pub fn fresnel(cosine: f32, ior: f32) -> f32 {
    let cosine = cosine.clamp(0.0, 1.0);
    let inside = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).max(0.0).sqrt();
    let across = (cosine - ior * inside) / (cosine + ior * inside);
    let along = (ior * cosine - inside) / (ior * cosine + inside);
    // Both are 0/0 at a grazing angle and an index of 1, which reflects nothing.
    let part = 0.5 * (across * across + along * along);
    if part.is_finite() { part.min(1.0) } else { 0.0 }
}
