//! Scenes from mesh files.

use std::path::Path;

use super::raycast::SceneAtTime;
use crate::error::{Error, Result};

/// A scene read from a file of meshes: glTF, GLB or OBJ.
#[derive(Debug)]
pub struct Model {}

impl Model {
    /// Reads the file, and what it names. Notes tell what was left out or replaced, a sentence each.
    ///
    /// # Errors
    /// When it cannot be read or is not such a file.
    pub fn open(path: &Path) -> Result<(Model, Vec<String>)> {
        Err(Error::Usage(format!("{}: not yet", path.display())))
    }

    /// Length of its animation in seconds, 0 where nothing moves.
    pub fn duration_s(&self) -> f64 {
        0.0
    }

    /// The scene at `time_s` seconds.
    pub fn at(&self, _time_s: f64) -> SceneAtTime {
        SceneAtTime::new(Vec::new(), super::raycast::Light::default())
    }
}
