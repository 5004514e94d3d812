//! Scenes from mesh files: glTF, GLB and OBJ. Geometry that never moves is one mesh that all times share; moving geometry is a
//! separate mesh for each time.
//!
//! Microfacet lobes become Phong highlights (`materials`); lux and candela become the radiance of a white surface (`lights`).
//! Notes report what was ignored or replaced.

use std::path::Path;
use std::sync::Arc;

pub use self::options::Play;
use self::options::printable;
use self::stage::{Stage, Which};
use super::{Light, SceneAtTime, SceneMesh};
use crate::mesh::gltf::document;
use crate::mesh::{Mesh, folder};
use codec::error::{Error, Result};
use footage::account::Account;

pub mod animation;
mod deform;
mod gltf;
mod lights;
mod materials;
mod mtl;
mod obj;
mod options;
mod stage;

/// Maximum number of sentences about what is left out.
const MAX_NOTES: usize = 10_000;

#[derive(Debug, Default)]
pub struct Model {
    still: Vec<Arc<SceneMesh>>,
    light: Light,
    /// Moving parts; `None` for a static scene.
    motion: Option<Stage>,
    /// Number of times that each triangle was split into four.
    subdivisions: u32,
    /// Names in the order of the file; “animation N” for one without a name.
    pub animations: Vec<String>,
    /// Durations in seconds as stated by the file; `None` if it does not state one.
    pub durations_s: Vec<Option<f64>>,
    /// Digest of all files that were read, and of the names of missing ones.
    pub contents: String,
}

impl Model {
    /// Opens a file. The account has the nodes or objects, materials, lights, animations and files that are used, and what was ignored
    /// or replaced.
    pub fn open(path: &Path, play: Play) -> Result<(Model, Account)> {
        let mut account = Account::default();
        let model = Model::read(path, play, &mut account).map_err(|error| error.in_file(path))?;
        let more = account.left_out.len().saturating_sub(MAX_NOTES);
        account.left_out.truncate(MAX_NOTES);
        account.left_out.iter_mut().for_each(|note| *note = printable(note));
        let names = account.used.iter_mut().flat_map(|used| &mut used.names);
        names.for_each(|name| *name = printable(name));
        if more > 0 {
            account.left_out.push(format!("{more} more notes of this kind are omitted"));
        }
        Ok((model, account))
    }

    fn read(path: &Path, play: Play, account: &mut Account) -> Result<Model> {
        let bytes = folder::read(path)?;
        let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
        let first = text.iter().find(|byte| !byte.is_ascii_whitespace());
        if document::is_glb(&bytes) || first == Some(&b'{') {
            let gltf::Read { stage, animations, durations_s, contents } = gltf::read(&bytes, path, play, account)?;
            return Ok(Model { animations, durations_s, contents, ..Model::of_stage(stage, &mut account.left_out)? });
        }
        if extension.is_none_or(|extension| extension != "obj") {
            return Err(Error::unsupported("neither glTF nor GLB nor OBJ; save the scene as one of these"));
        }
        if let Play::Named(name) = play {
            let path = path.display();
            return Err(Error::Usage(format!("{path}: there is no animation “{name}”: OBJ files have no animations")));
        }
        let (mesh, contents) = obj::read(&bytes, path, account)?;
        if mesh.mesh.triangles.is_empty() {
            return Err(nothing());
        }
        Ok(Model { still: vec![Arc::new(mesh)], contents, ..Model::default() })
    }

    fn of_stage(stage: Stage, notes: &mut Vec<String>) -> Result<Model> {
        let fixed = stage.at(0.0, Which::Still);
        let moving = stage.at(0.0, Which::Moving);
        let mut left_out = fixed.left_out;
        left_out.add(moving.left_out);
        left_out.note(notes);
        let shown = fixed.mesh.triangles.len() + moving.mesh.triangles.len();
        if shown == 0 && !stage.is_moving {
            return Err(nothing());
        }
        let still = stage.scene_mesh(fixed.mesh).into_iter().collect();
        let motion = Some(stage).filter(|stage| stage.is_moving);
        Ok(Model { still, light: fixed.light, motion, ..Model::default() })
    }

    /// Splits each triangle into four, `times` times.
    pub fn subdivided(mut self, times: u32) -> Result<Model> {
        let finer = |mesh: &Arc<SceneMesh>| {
            subdivided(&mesh.mesh, times).map(|finer| Arc::new(SceneMesh::new(finer, mesh.materials.clone())))
        };
        (self.still, self.subdivisions) =
            (self.still.iter().map(finer).collect::<Result<_>>()?, self.subdivisions + times);
        // The moving part has the same number of triangles at every time.
        if let Some(stage) = &self.motion {
            subdivided(&stage.at(0.0, Which::Moving).mesh, self.subdivisions)?;
        }
        Ok(self)
    }

    /// True if the file has no light, so that [`Light::default`] is used.
    pub fn is_lit_by_default(&self) -> bool {
        self.light == Light::default()
    }

    /// Returns the length of the animation in seconds; 0 for a static scene.
    pub fn duration_s(&self) -> f64 {
        self.motion.as_ref().map_or(0.0, |stage| stage.animation.duration_s)
    }

    /// Returns the scene at a time; after the end of the animation, the scene at its end. Equal times give bit-identical
    /// scenes.
    pub fn at(&self, time_s: f64) -> SceneAtTime {
        let mut meshes = self.still.clone();
        let mut light = self.light.clone();
        if let Some(stage) = &self.motion {
            let time_s = if time_s.is_nan() { 0.0 } else { time_s };
            let shown = stage.at(time_s, Which::Moving);
            light = shown.light;
            // Does not fail: `subdivided` has checked the same number of triangles.
            let mesh = subdivided(&shown.mesh, self.subdivisions).unwrap_or(shown.mesh);
            meshes.extend(stage.scene_mesh(mesh));
        }
        SceneAtTime::with_meshes(Vec::new(), meshes, light)
    }
}

/// Maximum triangles of a subdivided mesh.
const MAX_SUBDIVIDED: u64 = 1 << 28;

fn subdivided(mesh: &Mesh, times: u32) -> Result<Mesh> {
    let count = (mesh.triangles.len() as u64).saturating_mul(4u64.saturating_pow(times));
    let too_many =
        || Error::Usage(format!("{count} triangles after `subdivide` {times}, at most {MAX_SUBDIVIDED} are supported"));
    if count > MAX_SUBDIVIDED {
        return Err(too_many());
    }
    let mut finer = mesh.clone();
    for _ in 0..times {
        finer = finer.subdivided().ok_or_else(too_many)?;
    }
    Ok(finer)
}

fn nothing() -> Error {
    Error::invalid("the scene has no triangles")
}
