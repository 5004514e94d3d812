//! Converts metallic-roughness materials to those of the ray caster: Lambert and Phong, mirror or clear glass.
//!
//! A microfacet lobe of roughness r (α = r²) is about as wide as a Blinn lobe of exponent 2/α² − 2 over the half vector. The
//! angle to the mirror direction is twice the angle to the half vector, so Phong's exponent is a quarter of that: (2/α² − 2)/4,
//! at least 1. A metal reflects its base colour and has no diffuse part.

use glam::DVec3;

use crate::mesh::Material;
use crate::mesh::gltf::materials::Paint;
use crate::mesh_scene::{MeshMaterial, Optics, Phong};

/// Minimum metalness and maximum roughness of a mirror.
const MIRROR_METALLIC: f64 = 0.95;
const MIRROR_ROUGHNESS: f64 = 0.05;
/// Minimum transmission of glass.
const GLASS_TRANSMISSION: f64 = 0.5;
/// Maximum exponent of a highlight: narrower ones fall between the rays.
const MAX_EXPONENT: f64 = 1e4;

pub fn shaded(paint: Paint) -> MeshMaterial {
    let Paint { material, mean_color, .. } = paint;
    let optics = if material.unlit {
        Optics::Opaque
    } else if material.transmission >= GLASS_TRANSMISSION {
        Optics::Glass { ior: material.ior, tint: mean_color }
    } else if material.metallic >= MIRROR_METALLIC && material.roughness <= MIRROR_ROUGHNESS {
        Optics::Mirror { tint: mean_color }
    } else {
        Optics::Opaque
    };
    let is_opaque = optics == Optics::Opaque;
    let base_color = match optics {
        Optics::Opaque if material.unlit => material.base_color,
        Optics::Opaque => material.base_color * (1.0 - material.metallic),
        _ => DVec3::ZERO,
    };
    let (mut phong, mut metal) = (Phong::default(), DVec3::ZERO);
    if is_opaque && !material.unlit {
        let alpha = material.roughness * material.roughness;
        let exponent = ((2.0 / (alpha * alpha) - 2.0) / 4.0).clamp(1.0, MAX_EXPONENT);
        let of_ior = || DVec3::splat(((material.ior - 1.0) / (material.ior + 1.0)).powi(2));
        let reflectance = material.specular.unwrap_or_else(of_ior);
        let weight = reflectance * (1.0 - material.metallic) + mean_color * material.metallic;
        let weight = weight.clamp(DVec3::ZERO, DVec3::ONE);
        phong = Phong { weight, exponent };
        metal = (mean_color * material.metallic).clamp(DVec3::ZERO, weight);
    }
    MeshMaterial { plain: Material { base_color, ..material }, phong, metal, optics }
}
