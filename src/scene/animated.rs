//! A scene by its name: built in, or from a file.

use std::path::Path;

use super::model::Model;
use super::procedural::{DemoKind, DemoScene};
use super::raycast::SceneAtTime;
use crate::error::Result;

/// A scene that has a state at every time.
#[derive(Debug)]
pub enum Scene {
    /// Built in.
    Procedural(DemoScene),
    /// From a file of meshes.
    Model(Box<Model>),
}

impl Scene {
    /// Whether [`Self::open`] would take a text for a scene, by its name alone: one that is built in, or a file that ends
    /// in `.glb`, `.gltf` or `.obj`.
    pub fn is_named_by(text: &str) -> bool {
        let path = Path::new(text);
        let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
        let is_file = ending.is_some_and(|ending| ["glb", "gltf", "obj"].iter().any(|known| ending == *known));
        is_file || (!path.exists() && DemoKind::from_name(text).is_some())
    }

    /// Opens a built-in scene by its name ([`DemoKind::from_name`]), or a file. A file is meant where one of that name
    /// exists. Notes tell what was left out or replaced, a sentence each.
    ///
    /// # Errors
    /// As for [`Model::open`].
    pub fn open(text: &str) -> Result<(Scene, Vec<String>)> {
        let path = Path::new(text);
        if let (false, Some(kind)) = (path.exists(), DemoKind::from_name(text)) {
            return Ok((Scene::Procedural(DemoScene::new(kind)), Vec::new()));
        }
        let (model, notes) = Model::open(path)?;
        Ok((Scene::Model(Box::new(model)), notes))
    }

    /// Everything at `time_s` seconds. The same time gives the same bits.
    pub fn at(&self, time_s: f64) -> SceneAtTime {
        match self {
            Scene::Procedural(scene) => scene.at(time_s),
            Scene::Model(model) => model.at(time_s),
        }
    }

    /// Length of its animation in seconds, 0 where nothing moves.
    pub fn duration_s(&self) -> f64 {
        match self {
            Scene::Procedural(scene) => scene.duration_s(),
            Scene::Model(model) => model.duration_s(),
        }
    }
}
