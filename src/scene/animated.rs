//! A scene opened by name: a built-in scene, or a file.

use std::path::Path;

use super::{DemoKind, DemoScene, Model, Play, SceneAtTime};
use codec::error::{Error, Result};
use footage::account::Account;

const ENDINGS: [&str; 3] = ["glb", "gltf", "obj"];

#[derive(Debug)]
pub enum Scene {
    Procedural(DemoScene),
    Model(Box<Model>),
}

impl Scene {
    /// True if [`Self::open`] accepts a text as a scene because of its name alone.
    pub fn is_named_by(text: &str) -> bool {
        has_ending(text) || built_in(text).is_some()
    }

    /// Opens a built-in scene by its name, or a file. The account has what is used of the file, and what was ignored or replaced.
    pub fn open(text: &str, play: Play) -> Result<(Scene, Account)> {
        if let Some(kind) = built_in(text) {
            return match play {
                Play::Named(name) => Err(Error::Usage(format!(
                    "{text}: there is no animation “{name}”: the animation of a built-in scene has no name"
                ))),
                Play::All => {
                    let mut account = Account::default();
                    account.add("built-in scene", [text.to_owned()]);
                    Ok((Scene::Procedural(DemoScene::new(kind)), account))
                }
            };
        }
        let path = Path::new(text);
        if path.is_dir() || (!path.exists() && !has_ending(text)) {
            let what = if path.is_dir() { "a folder" } else { "no such file" };
            return Err(Error::Usage(format!(
                "{text}: {what}: a scene file (.glb, .gltf, .obj) or a built-in scene was expected: {}",
                DemoKind::ALL.map(DemoKind::name).join(", ")
            )));
        }
        let (model, account) = Model::open(path, play)?;
        Ok((Scene::Model(Box::new(model)), account))
    }

    /// Splits each triangle into four, `times` times. Fails for built-in scenes, which have no triangles, unless `times` is 0.
    pub fn subdivided(self, times: u32) -> Result<Scene> {
        match self {
            Scene::Model(model) => Ok(Scene::Model(Box::new(model.subdivided(times)?))),
            Scene::Procedural(_) if times > 0 => Err(Error::Usage(
                "`subdivide` does not apply to built-in scenes, which have no triangles: use a scene file".into(),
            )),
            Scene::Procedural(_) => Ok(self),
        }
    }

    /// Returns the scene at a time; equal times give bit-identical scenes.
    pub fn at(&self, time_s: f64) -> SceneAtTime {
        match self {
            Scene::Procedural(scene) => scene.at(time_s),
            Scene::Model(model) => model.at(time_s),
        }
    }

    /// Returns the length of the animation in seconds; 0 for a static scene.
    pub fn duration_s(&self) -> f64 {
        match self {
            Scene::Procedural(scene) => scene.duration_s(),
            Scene::Model(model) => model.duration_s(),
        }
    }

    /// Returns an identifier of the contents: the name of a built-in scene, or a digest of all files that were read.
    pub fn contents(&self) -> &str {
        match self {
            Scene::Procedural(scene) => scene.kind.name(),
            Scene::Model(model) => &model.contents,
        }
    }
}

fn has_ending(text: &str) -> bool {
    let ending = Path::new(text).extension().map(|ending| ending.to_ascii_lowercase());
    ending.is_some_and(|ending| ENDINGS.iter().any(|known| ending == *known))
}

/// An existing file takes precedence over the built-in scene of its name; a folder does not.
fn built_in(text: &str) -> Option<DemoKind> {
    let path = Path::new(text);
    DemoKind::from_name(text).filter(|_| !path.exists() || path.is_dir())
}
