//! Mesh files. The readers take paths, so each thread has a temporary file of each kind.

use std::path::Path;

use codec::math::{Camera, Lens};
use glam::DVec3;
use scene::mesh::budget::Budget;
use scene::{Model, Play, SceneMesh};
use simplify::raster::draw;
use simplify::read_glb::{QuadScene, read_glb};
use tempfile::NamedTempFile;

use super::{Judged, Verdict, judge};

thread_local! {
    static GLTF: NamedTempFile = new_file(".gltf");
    static OBJ: NamedTempFile = new_file(".obj");
    static MTL: (NamedTempFile, NamedTempFile) = painted();
}

/// Creates a temporary file, in memory if the system has `/dev/shm`.
fn new_file(suffix: &str) -> NamedTempFile {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    tempfile::Builder::new().prefix("fuzz").suffix(suffix).tempfile_in(folder).expect("a temporary file")
}

/// Creates a material file, and an OBJ file that references it.
fn painted() -> (NamedTempFile, NamedTempFile) {
    let (mtl, obj) = (new_file(".mtl"), new_file(".obj"));
    let name = mtl.path().file_name().and_then(|name| name.to_str()).expect("a name").to_string();
    let text = format!("mtllib {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n");
    std::fs::write(obj.path(), text).expect("the temporary file is written");
    (mtl, obj)
}

fn run(file: &NamedTempFile, bytes: &[u8]) -> Judged {
    std::fs::write(file.path(), bytes).expect("the temporary file is written");
    look(file.path())
}

fn look(path: &Path) -> Judged {
    let model = Model::open(path, Play::All);
    if let Ok((model, account)) = &model {
        if account.left_out.iter().any(|note| note.trim().is_empty()) {
            return Err("a note without words".into());
        }
        let duration = model.duration_s();
        if !duration.is_finite() {
            return Err(format!("an animation of {duration} s"));
        }
        for time in [0.0, duration / 3.0, f64::NAN] {
            let (scene, again) = (model.at(time), model.at(time));
            for (mesh, again) in scene.meshes.iter().zip(&again.meshes) {
                sound(mesh, again)?;
            }
        }
    }
    judge(&model)
}

/// Checks that a mesh is valid for ray casting, and that instantiating the model again gives the same mesh.
fn sound(mesh: &SceneMesh, again: &SceneMesh) -> Result<(), String> {
    let materials = mesh.materials.len();
    let (mesh, again) = (&mesh.mesh, &again.mesh);
    let count = mesh.positions.len();
    if mesh.positions != again.positions || mesh.triangles != again.triangles || mesh.normals != again.normals {
        return Err("placed twice, it is not the same".into());
    }
    if !mesh.positions.iter().all(|position| position.is_finite()) || !mesh.uvs.iter().all(|uv| uv.is_finite()) {
        return Err("a corner is not finite".into());
    }
    if !mesh.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-3) {
        return Err("a normal is not of length 1".into());
    }
    let fits = |others: usize| others == 0 || others == count;
    if !fits(mesh.normals.len()) || !fits(mesh.uvs.len()) || mesh.material_of.len() != mesh.triangles.len() {
        return Err("lists of one mesh differ in length".into());
    }
    let beyond = mesh.triangles.as_flattened().iter().any(|&corner| corner as usize >= count);
    if beyond || mesh.material_of.iter().any(|&material| material as usize >= materials) {
        return Err("a triangle leads to what is not there".into());
    }
    Ok(())
}

/// Reads a glTF or GLB file.
pub fn run_gltf(bytes: &[u8]) -> Judged {
    GLTF.with(|file| run(file, bytes))
}

/// Reads a simplified scene and, if it is valid, draws it.
pub fn run_quads(bytes: &[u8]) -> Judged {
    GLTF.with(|file| {
        std::fs::write(file.path(), bytes).expect("the temporary file is written");
        let read = read_glb(file.path());
        if let Ok(QuadScene { quads, .. }) = &read {
            let camera = Camera::look_at(DVec3::ZERO, DVec3::new(0.3, -0.1, -1.0), DVec3::Y, Lens::new(100.0));
            let drawn = draw(quads, &camera.map_err(|error| error.to_string())?, [5, 4]);
            if drawn.pixels.iter().flatten().any(|part| !(0.0..=1.001).contains(part)) {
                return Err(format!("a pixel is no colour: {:?}", drawn.pixels));
            }
        }
        judge(&read)
    })
}

/// Reads an OBJ file.
pub fn run_obj(bytes: &[u8]) -> Judged {
    OBJ.with(|file| run(file, bytes))
}

/// Reads the materials of an OBJ file. Materials that cannot be read are omitted, with a note instead of an error.
pub fn run_mtl(bytes: &[u8]) -> Judged {
    MTL.with(|(mtl, obj)| {
        std::fs::write(mtl.path(), bytes).expect("the temporary file is written");
        let refused = Model::open(obj.path(), Play::All)
            .is_ok_and(|(_, account)| account.left_out.iter().any(|note| note.starts_with("materials")));
        let judged = look(obj.path())?;
        Ok(if refused { Verdict::Refused } else { judged })
    })
}

/// Returns the maximum bytes used to read a mesh file: its budget, and as much again for parsing and for building bounding volume
/// hierarchies.
pub fn bound(bytes: &[u8]) -> u64 {
    Budget::allowance(bytes.len() as u64).saturating_mul(2)
}
