//! What a scene is made of, at its beginning where it moves.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::Serialize;

use crate::scene::{MeshMaterial, Scene, SceneAtTime};

/// Sizes and counts of a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneSummary {
    /// Axis-aligned bounds in metres.
    pub bounds_m: Option<SceneBounds>,
    /// Counts.
    #[serde(flatten)]
    pub counts: SceneCounts,
    /// Animations.
    pub animations: Vec<AnimationSummary>,
}

/// An axis-aligned box in metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SceneBounds {
    /// Least coordinates.
    pub min: [f64; 3],
    /// Greatest coordinates.
    pub max: [f64; 3],
}

/// How many there are of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SceneCounts {
    /// Triangles of all meshes.
    pub triangles: usize,
    /// Objects that are not meshes.
    pub objects: usize,
    /// Materials in use.
    pub materials: usize,
    /// Textures in use.
    pub textures: usize,
    /// Directional lights.
    pub suns: usize,
    /// Point and spot lights.
    pub lamps: usize,
}

/// An animation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnimationSummary {
    /// Name in the file, without control characters.
    pub name: Option<String>,
    /// Length in seconds, if known.
    pub duration_s: Option<f64>,
}

impl Scene {
    /// The summary.
    pub fn summary(&self) -> SceneSummary {
        let scene = self.at(0.0);
        let materials = materials(&scene);
        let images = materials.iter().flat_map(|material| [&material.base_texture, &material.emissive_texture]);
        let textures: BTreeSet<_> = images.flatten().map(Arc::as_ptr).collect();
        SceneSummary {
            bounds_m: scene
                .bounds()
                .map(|bounds| SceneBounds { min: bounds.min.to_array(), max: bounds.max.to_array() }),
            counts: SceneCounts {
                triangles: scene.meshes().iter().map(|mesh| mesh.mesh().triangles.len()).sum(),
                objects: scene.objects().len(),
                materials: materials.len(),
                textures: textures.len(),
                suns: scene.light().suns.len(),
                lamps: scene.light().lamps.len(),
            },
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
                let named = model.animations().iter().zip(model.durations_s());
                named
                    .map(|(name, length)| AnimationSummary { name: Some(printable(name)), duration_s: *length })
                    .collect()
            }
        }
    }
}

/// Materials of triangles, each once: moving and static meshes share one list.
fn materials(scene: &SceneAtTime) -> Vec<&MeshMaterial> {
    let mut found = Vec::new();
    let mut known = BTreeSet::new();
    for mesh in scene.meshes() {
        let used: BTreeSet<u32> = mesh.mesh().material_of.iter().copied().collect();
        for material in used.into_iter().filter_map(|number| mesh.materials().get(number as usize)) {
            if known.insert(std::ptr::from_ref(material)) {
                found.push(material);
            }
        }
    }
    found
}
