//! Scenes from mesh files: glTF, GLB and OBJ.
//!
//! Enters: the path of a file. Leaves: a [`Model`], which has a state at every time. `gltf` and `obj` read a kind of file
//! each, `assembly` makes one mesh of what they read.

use std::path::Path;
use std::sync::Arc;

use super::bvh::MeshBvh;
use super::raycast::{Light, SceneAtTime};
use crate::error::{Error, Result};

mod assembly;
mod budget;
mod buffers;
mod document;
mod folder;
mod gltf;
mod lights;
mod materials;
mod mtl;
mod nodes;
mod obj;
mod pictures;
mod primitives;
mod textures;

/// A scene read from a file of meshes: glTF, GLB or OBJ.
#[derive(Debug)]
pub struct Model {
    still: Vec<Arc<MeshBvh>>,
    light: Light,
}

impl Model {
    /// Reads the file, and what it names. Notes tell what was left out or replaced, a sentence each.
    ///
    /// # Errors
    /// When it cannot be read or is not such a file, asks for what is not known here, or shows no triangles.
    pub fn open(path: &Path) -> Result<(Model, Vec<String>)> {
        let mut notes = Vec::new();
        let model = Model::read(path, &mut notes).map_err(|error| error.in_file(path))?;
        Ok((model, notes))
    }

    fn read(path: &Path, notes: &mut Vec<String>) -> Result<Model> {
        let bytes = folder::read(path)?;
        let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
        let first = bytes.iter().find(|byte| !byte.is_ascii_whitespace() && !b"\xef\xbb\xbf".contains(byte));
        let (mesh, light) = if document::is_glb(&bytes) || first == Some(&b'{') {
            let stage = gltf::Stage::read(&bytes, path, notes)?;
            stage.still(notes)?
        } else if extension.is_some_and(|extension| extension == "obj") {
            (obj::read(&bytes, path, notes)?, Light::default())
        } else {
            return Err(Error::unsupported("neither glTF nor GLB nor OBJ: save the scene as one of these"));
        };
        if mesh.triangles.is_empty() {
            return Err(Error::invalid("the scene shows no triangles"));
        }
        Ok(Model { still: vec![Arc::new(MeshBvh::new(mesh))], light })
    }

    /// Length of its animation in seconds, 0 where nothing moves.
    pub fn duration_s(&self) -> f64 {
        0.0
    }

    /// The scene at `time_s` seconds.
    pub fn at(&self, _time_s: f64) -> SceneAtTime {
        SceneAtTime::with_meshes(Vec::new(), self.still.clone(), self.light.clone())
    }
}

#[cfg(test)]
mod smoke {
    use super::*;
    #[test]
    fn real_meshes() {
        for name in ["sponza.glb", "dragon.glb", "bunny.obj"] {
            let path = format!("/work/shared/data/meshes/{name}");
            let start = std::time::Instant::now();
            let (model, notes) = Model::open(Path::new(&path)).unwrap();
            let mesh = model.still[0].mesh();
            let low = mesh.positions.iter().fold(glam::DVec3::INFINITY, |a, p| a.min(*p));
            let high = mesh.positions.iter().fold(glam::DVec3::NEG_INFINITY, |a, p| a.max(*p));
            println!(
                "{name} {} triangles {} corners {} normals {} uvs {} materials {low} {high} {:?} {notes:?}",
                mesh.triangles.len(),
                mesh.positions.len(),
                mesh.normals.len(),
                mesh.uvs.len(),
                mesh.materials.len(),
                start.elapsed()
            );
        }
    }
}
