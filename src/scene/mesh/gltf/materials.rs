//! Materials of a glTF file (glTF 2.0, section 3.9): metallic-roughness, and specular-glossiness converted to it.
//!
//! Textures of roughness, metalness and transmission are replaced by their means; normal and occlusion textures are ignored.

use glam::DVec3;
use gltf::Material;
use gltf::material::AlphaMode;
use gltf::texture::Info;

use super::buffers::Buffers;
use super::primitives::Coordinates;
use super::textures::{Textures, coordinates};
use crate::mesh::material::Material as PlainMaterial;

/// Alpha cutoff that replaces blending.
const BLEND_CUTOFF: f64 = 0.5;

/// A material, and the texture coordinates that it uses.
#[derive(Debug, Clone)]
pub struct Paint {
    pub material: PlainMaterial,
    /// Base colour times the mean of its texture, linear.
    pub mean_color: DVec3,
    /// `None` without textures.
    pub coordinates: Option<Coordinates>,
}

/// Reads all materials of a document; the default material at index 0 precedes them.
pub fn read_all(document: &gltf::Document, buffers: &mut Buffers, notes: &mut Vec<String>) -> Vec<Paint> {
    let mut textures = Textures::default();
    let plain = PlainMaterial::default();
    let mut all = vec![Paint { mean_color: plain.base_color, material: plain, coordinates: None }];
    all.extend(document.materials().map(|material| read(&material, buffers, &mut textures, notes)));
    notes.append(&mut textures.notes);
    note_left_out(document, notes);
    all
}

fn note_left_out(document: &gltf::Document, notes: &mut Vec<String>) {
    let normal = document.materials().filter(|material| material.normal_texture().is_some()).count();
    let occlusion = document.materials().filter(|material| material.occlusion_texture().is_some()).count();
    if normal + occlusion > 0 {
        notes.push(format!("normal maps of {normal} materials and occlusion maps of {occlusion} are ignored"));
    }
    let single = document.materials().filter(|material| material.index().is_some() && !material.double_sided()).count();
    if single > 0 && single < document.materials().count() {
        notes.push(format!("{single} materials are single-sided in the file; all are rendered double-sided"));
    }
}

fn read(material: &Material, buffers: &mut Buffers, textures: &mut Textures, notes: &mut Vec<String>) -> Paint {
    let number = material.index().unwrap_or(0);
    let name = material.name().map_or_else(|| format!("material {number}"), str::to_string);
    let surface = Surface::of(material);
    let base_texture = surface.base_info.as_ref().and_then(|info| textures.get(&info.texture(), buffers));
    let mean_color = surface.base * textures.means(surface.base_info.as_ref(), buffers)[0];
    let map = material.pbr_metallic_roughness().metallic_roughness_texture().filter(|_| surface.uses_maps);
    let maps = textures.means(map.as_ref(), buffers)[1];
    let (metallic, roughness) = (surface.metallic * maps.z, surface.roughness * maps.y);
    let transmission = material.transmission().map_or(0.0, |transmission| {
        let map = textures.means(transmission.transmission_texture().as_ref(), buffers)[1];
        unit(transmission.transmission_factor()) * map.x
    });
    let emissive_info = material.emissive_texture();
    let emissive_texture = emissive_info.as_ref().and_then(|info| textures.get(&info.texture(), buffers));

    let ior = material.ior().map_or(1.5, f64::from);
    let ior = if ior.is_finite() { ior.clamp(1.0, 100.0) } else { 1.5 };
    let strength = material.emissive_strength().map_or(1.0, f64::from).clamp(0.0, 1e6);
    let emission = DVec3::from_array(material.emissive_factor().map(unit)) * strength;

    let alpha_cutoff = match material.alpha_mode() {
        AlphaMode::Opaque => None,
        AlphaMode::Mask => Some(material.alpha_cutoff().map_or(0.5, f64::from)),
        AlphaMode::Blend => {
            notes.push(format!(
                "“{name}” uses alpha blending, which is not supported: alpha below {BLEND_CUTOFF} is transparent, the \
                rest opaque"
            ));
            Some(BLEND_CUTOFF)
        }
    };
    let base_coordinates = surface.base_info.as_ref().filter(|_| base_texture.is_some()).map(coordinates);
    let emissive_coordinates = emissive_info.as_ref().filter(|_| emissive_texture.is_some()).map(coordinates);
    if base_coordinates.zip(emissive_coordinates).is_some_and(|(one, other)| one != other) {
        notes.push(format!(
            "the emissive texture of “{name}” has its own texture coordinates, which are ignored: \
            those of the base colour are used"
        ));
    }
    Paint {
        material: PlainMaterial {
            name,
            base_color: surface.base,
            alpha: surface.alpha,
            base_texture,
            alpha_cutoff,
            is_blended: material.alpha_mode() == AlphaMode::Blend,
            metallic,
            roughness,
            specular: surface.specular,
            ior,
            transmission,
            emission,
            emissive_texture,
            unlit: material.unlit(),
        },
        mean_color,
        coordinates: base_coordinates.or(emissive_coordinates),
    }
}

/// Parameters that both material models share.
struct Surface<'a> {
    base: DVec3,
    alpha: f64,
    base_info: Option<Info<'a>>,
    metallic: f64,
    roughness: f64,
    /// Reflectance of a dielectric at normal incidence, if the file specifies it.
    specular: Option<DVec3>,
    /// True if metalness and roughness are multiplied by a texture.
    uses_maps: bool,
}

impl<'a> Surface<'a> {
    fn of(material: &Material<'a>) -> Surface<'a> {
        if let Some(glossy) = material.pbr_specular_glossiness() {
            let [r, g, b, alpha] = glossy.diffuse_factor().map(unit);
            return Surface {
                base: DVec3::new(r, g, b),
                alpha,
                base_info: glossy.diffuse_texture(),
                metallic: 0.0,
                roughness: 1.0 - unit(glossy.glossiness_factor()),
                specular: Some(DVec3::from_array(glossy.specular_factor().map(unit))),
                uses_maps: false,
            };
        }
        let rough = material.pbr_metallic_roughness();
        let [r, g, b, alpha] = rough.base_color_factor().map(unit);
        let specular = material.specular().map(|specular| {
            let ior = material.ior().map_or(1.5, f64::from).max(1.0);
            let color = DVec3::from_array(specular.specular_color_factor().map(f64::from));
            ((ior - 1.0) / (ior + 1.0)).powi(2) * color * unit(specular.specular_factor())
        });
        Surface {
            base: DVec3::new(r, g, b),
            alpha,
            base_info: rough.base_color_texture(),
            metallic: unit(rough.metallic_factor()),
            roughness: unit(rough.roughness_factor()),
            specular: specular.filter(|specular| specular.is_finite()),
            uses_maps: true,
        }
    }
}

/// Clamps a factor to 0..=1.
pub fn unit(value: f32) -> f64 {
    if value.is_finite() { f64::from(value).clamp(0.0, 1.0) } else { 0.0 }
}
