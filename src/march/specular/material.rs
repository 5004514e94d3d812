//! What a surface does with light in a point: SampleMaterial of algorithm 4 (CALF 6.1).
//!
//! Enters: active views and a point on a surface. Leaves: the weights of reflection and refraction and the index of
//! refraction, interpolated as colours are.

use glam::Vec3;

use crate::march::active_views::ActiveViews;
use crate::march::interpolate::{DEPTH_EPSILON, Taps, image_of, log_difference};
use crate::streams::convert::IOR_RANGE;

/// Weights that add up to less than this are none: half a step of the 8 bits that they come in.
pub const LEAST_WEIGHT: f32 = 0.5 / 255.0;
/// What sends on so much of its light, and refracts any of it, is clear glass, and shares it out by Fresnel's equations.
pub const CLEAR: f32 = 0.95;

/// What a surface does with light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// The part that it reflects as a mirror does, 0 to 1.
    pub reflect: f32,
    /// The part that it refracts, 0 to 1; at most 1 together with `reflect`.
    pub refract: f32,
    /// Index of refraction, 1 to 3.
    pub ior: f32,
}

/// What views know of the material of a surface in a point, `point` in metres from the eye. None where no view has any,
/// and where its weights are 0.
pub fn surface_material(views: &ActiveViews<'_>, camera_weights: &[f32], point: Vec3) -> Option<Material> {
    let (mut reflect, mut refract, mut ior, mut weights) = (0.0, 0.0, 0.0, 0.0);
    for (view, camera_weight) in views.views.iter().zip(camera_weights) {
        let Some((face, at)) = image_of(view, view.local(point)) else { continue };
        let Some(material) = &face.material else { continue };
        let taps = Taps::around(at.at, face);
        for (texel, weight) in taps.texels.into_iter().zip(taps.weights) {
            if let Some(difference) = log_difference(face.inverse_depth[texel], at.inverse_depth) {
                let weight = weight * camera_weight / (difference + DEPTH_EPSILON);
                let [mirror, glass, index, _] = material[texel].map(|code| f32::from(code) / 255.0);
                reflect += weight * mirror;
                refract += weight * glass;
                ior += weight * glass * index;
                weights += weight;
            }
        }
    }
    if reflect + refract <= LEAST_WEIGHT * weights {
        return None;
    }
    // Indices of what does not refract mean nothing.
    let ior = if refract > 0.0 { IOR_RANGE[0] + ior / refract * (IOR_RANGE[1] - IOR_RANGE[0]) } else { IOR_RANGE[0] };
    // Hostile weights may add up to more than 1.
    let whole = weights.max(reflect + refract);
    Some(Material { reflect: reflect / whole, refract: refract / whole, ior })
}

impl Material {
    /// The same as it is seen at another angle, whose cosine with the normal is `cosine`.
    ///
    /// Clear glass was captured with Fresnel's weights for the direction of its probe; they are those of the ray instead.
    /// All other weights are left as they are.
    #[must_use]
    pub fn towards(self, cosine: f32) -> Material {
        let whole = self.reflect + self.refract;
        if self.refract == 0.0 || whole < CLEAR {
            return self;
        }
        let reflect = whole * fresnel(cosine, self.ior);
        Material { reflect, refract: whole - reflect, ..self }
    }
}

/// The reflected part of unpolarised light on its way into a material of index `ior`, `cosine` with the normal.
pub fn fresnel(cosine: f32, ior: f32) -> f32 {
    let cosine = cosine.clamp(0.0, 1.0);
    let inside = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).max(0.0).sqrt();
    let across = (cosine - ior * inside) / (cosine + ior * inside);
    let along = (ior * cosine - inside) / (ior * cosine + inside);
    // Both are 0 over 0 at a grazing angle to an index of 1, which reflects nothing.
    let part = 0.5 * (across * across + along * along);
    if part.is_finite() { part.min(1.0) } else { 0.0 }
}
