//! Size and contents of a scene at time 0.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::Serialize;

use crate::{MeshMaterial, Scene, SceneAtTime};

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneSummary {
    pub bounds_m: Option<SceneBounds>,
    pub triangles: usize,
    /// Number of analytic shapes.
    pub objects: usize,
    /// Number of materials in use.
    pub materials: usize,
    /// Number of textures in use.
    pub textures: usize,
    /// Number of the scene's own suns.
    pub suns: usize,
    /// Number of the scene's own point and spot lights.
    pub lamps: usize,
    /// True if the scene has no light of its own, so that a sun and a sky are added.
    pub is_lit_by_default: bool,
    pub animations: Vec<AnimationSummary>,
}

/// Axis-aligned bounds in metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SceneBounds {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnimationSummary {
    /// Name in the file, with control characters replaced.
    pub name: Option<String>,
    /// `None` if the file does not state it.
    pub duration_s: Option<f64>,
}

impl Scene {
    pub fn summary(&self) -> SceneSummary {
        let scene = self.at(0.0);
        let is_lit_by_default = matches!(self, Scene::Model(model) if model.is_lit_by_default());
        let materials = materials(&scene);
        let images =
            materials.iter().flat_map(|material| [&material.plain.base_texture, &material.plain.emissive_texture]);
        let textures: BTreeSet<_> = images.flatten().map(Arc::as_ptr).collect();
        SceneSummary {
            bounds_m: scene.bounds.map(|bounds| SceneBounds { min: bounds.min.to_array(), max: bounds.max.to_array() }),
            triangles: scene.meshes.iter().map(|mesh| mesh.mesh.triangles.len()).sum(),
            objects: scene.objects.len(),
            materials: materials.len(),
            textures: textures.len(),
            suns: if is_lit_by_default { 0 } else { scene.light.suns.len() },
            lamps: if is_lit_by_default { 0 } else { scene.light.lamps.len() },
            is_lit_by_default,
            animations: self.animation_summaries(),
        }
    }

    fn animation_summaries(&self) -> Vec<AnimationSummary> {
        let printable = |name: &str| name.replace(char::is_control, "?");
        match self {
            Scene::Procedural(_) if self.duration_s() > 0.0 => {
                vec![AnimationSummary { name: None, duration_s: Some(self.duration_s()) }]
            }
            Scene::Procedural(_) => Vec::new(),
            Scene::Model(model) => {
                let named = model.animations.iter().zip(&model.durations_s);
                named
                    .map(|(name, length)| AnimationSummary { name: Some(printable(name)), duration_s: *length })
                    .collect()
            }
        }
    }
}

/// Returns the materials in use, without duplicates.
fn materials(scene: &SceneAtTime) -> Vec<&MeshMaterial> {
    let mut found = Vec::new();
    let mut known = BTreeSet::new();
    for mesh in &scene.meshes {
        let used: BTreeSet<u32> = mesh.mesh.material_of.iter().copied().collect();
        for material in used.into_iter().filter_map(|number| mesh.materials.get(number as usize)) {
            if known.insert(std::ptr::from_ref(material)) {
                found.push(material);
            }
        }
    }
    found
}
