//! Reader of the binary glTF that [`super::export`] writes.

use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use super::quad_mesh::QuadMesh;
use codec::error::{Error, Result};
use scene::mesh::budget::Budget;
use scene::mesh::folder::{self, Folder};
use scene::mesh::gltf::buffers::Buffers;
use scene::mesh::gltf::document::{self, Parsed};
use scene::mesh::gltf::{materials, primitives};
use scene::mesh::{Material, Mesh};

/// A simplified scene read from a file.
#[derive(Debug)]
pub struct QuadScene {
    pub quads: QuadMesh,
    /// Frame of the dataset that the scene shows.
    pub frame: u32,
}

/// Reads a scene. Triangles keep the order of the file, which is the drawing order.
///
/// Fails for glTF that was not written by simplification, and for damaged files.
pub fn read_glb(path: &Path) -> Result<QuadScene> {
    let bytes = folder::read(path)?;
    read(&bytes, Folder::of(path)).map_err(|error| error.in_file(path))
}

/// Checks that a binary glTF file was written by simplification, without reading its geometry. Damaged files pass.
pub fn check_glb(path: &Path) -> Result<()> {
    let bytes = folder::read(path)?;
    // Viewers report damaged files.
    let Ok(parsed) = document::parse(&bytes) else { return Ok(()) };
    own_extras(&parsed).map(drop).map_err(|error| error.in_file(path))
}

/// Returns what simplification wrote into the extras of a document.
fn own_extras(Parsed { document, .. }: &Parsed) -> Result<Value> {
    let stored = document.as_json().extras.as_ref();
    let extras: Option<Value> = stored.and_then(|extras| serde_json::from_str(extras.get()).ok());
    let own = extras.as_ref().and_then(|extras| extras.get("lightfold")).filter(|own| own.is_object());
    own.cloned().ok_or_else(|| foreign("its extras were not written by lightfold"))
}

fn read(bytes: &[u8], folder: Folder) -> Result<QuadScene> {
    if !document::is_glb(bytes) {
        return Err(foreign("it is not a binary glTF file (.glb)"));
    }
    let parsed = document::parse(bytes)?;
    let own = own_extras(&parsed)?;
    let Parsed { document, blob, .. } = parsed;
    let root = document.as_json();
    let frame = own.get("frame").map_or(Some(0), |frame| frame.as_u64().and_then(|frame| u32::try_from(frame).ok()));
    let frame = frame.ok_or_else(|| Error::invalid("extras.lightfold.frame: the number of a frame was expected"))?;
    let runs = own.get(RUNS).map_or(Some(Vec::new()), |runs| serde_json::from_value::<Vec<u32>>(runs.clone()).ok());
    if document.nodes().any(|node| node.mesh().is_some() && node.transform().matrix() != IDENTITY) {
        return Err(foreign("a node moves its mesh"));
    }
    let mut buffers = Buffers::new(root, blob, folder, Budget::new(bytes.len() as u64));
    let mut notes = Vec::new();
    let paints = materials::read_all(&document, &mut buffers, &mut notes);
    let (mut mesh, mut stq) = (Mesh::default(), Vec::new());
    let mut texture = None;
    for primitive in document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>()) {
        // The list starts with the default material.
        let number = primitive.material().index().map_or(0, |index| index + 1);
        let Some(paint) = paints.get(number) else { continue };
        let Material { base_texture: Some(own), unlit: true, .. } = &paint.material else {
            let notes: String = notes.iter().map(|note| format!("; {note}")).collect();
            return Err(Error::invalid(format!("a primitive has no atlas as the texture of an unlit material{notes}")));
        };
        let atlas = texture.get_or_insert_with(|| own.clone());
        if !Arc::ptr_eq(atlas, own) {
            return Err(Error::invalid("its primitives have different atlases, where one was expected"));
        }
        let Some(part) = primitives::read(&primitive, 0, paint.coordinates, &mut buffers)? else {
            return Err(Error::invalid("it has points or lines, where triangles were expected"));
        };
        append(&mut mesh, &part)?;
        stq.extend(primitives::application_vectors(&primitive, HOMOGENEOUS, &mut buffers)?);
    }
    if !stq.is_empty() && stq.len() != mesh.positions.len() || !stq.iter().all(|stq| stq.is_finite()) {
        return Err(Error::invalid(format!("_{HOMOGENEOUS}: finite numbers for each corner were expected")));
    }
    let texture = texture.ok_or_else(|| Error::invalid("it has no triangles"))?;
    let count = mesh.triangles.len();
    let is_whole =
        |runs: &Vec<u32>| runs.is_empty() || runs.iter().map(|&run| u64::from(run)).sum::<u64>() == count as u64;
    let runs = runs.filter(is_whole).ok_or_else(|| {
        Error::invalid(format!("extras.lightfold.{RUNS}: lengths that add up to {count} triangles were expected"))
    })?;
    Ok(QuadScene { quads: QuadMesh { mesh, texture, stq, light: None, runs }, frame })
}

/// Key of the lengths of runs of triangles, alternately blended and opaque.
const RUNS: &str = "runs_blended_opaque";
/// Name of the attribute of homogeneous texture coordinates, without its underscore.
const HOMOGENEOUS: &str = "TEXCOORD_STQ";
const IDENTITY: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

fn foreign(why: &str) -> Error {
    Error::unsupported(format!(
        "{why}: a scene of lightfold simplify was expected; lightfold capture renders other meshes as datasets"
    ))
}

/// Appends triangles to a mesh.
fn append(mesh: &mut Mesh, part: &primitives::Geometry) -> Result<()> {
    let count = part.positions.len();
    if part.uvs.len() != count {
        return Err(Error::invalid(format!("{} texture coordinates for {count} corners", part.uvs.len())));
    }
    let faulty = (0..count).find(|&at| !part.positions[at].is_finite() || !part.uvs[at].is_finite());
    if let Some(at) = faulty {
        let (position, uv) = (part.positions[at], part.uvs[at]);
        return Err(Error::invalid(format!(
            "corner {at} at {position} with coordinates {uv}: finite numbers were expected"
        )));
    }
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(part.positions.iter().map(|at| at.as_dvec3()));
    mesh.uvs.extend(&part.uvs);
    mesh.triangles.extend(part.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
    mesh.material_of.resize(mesh.triangles.len(), 0);
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec2, Vec3};
    use serde_json::json;

    use super::*;
    use crate::export::glb;
    use scene::mesh::gltf::write::{self, Additions};
    use scene::mesh::{ImageTexture, Wrap};

    fn scene() -> QuadMesh {
        let mut mesh = Mesh::default();
        for at in 0..24u32 {
            mesh.positions.push(DVec3::new(f64::from(at), 0.5 * f64::from(at % 5), -2.0));
            mesh.uvs.push(Vec2::new(at as f32 / 32.0, 0.25));
        }
        // The triangles are not in the order of the corners.
        mesh.triangles = (0..8).map(|at| [0, 1, 2].map(|corner| (3 * (at * 5 % 8) + corner) as u32)).collect();
        mesh.material_of = vec![0; 8];
        let pixels = (0..12).map(|at| [at, 10 * at, 255 - at, 20 * at]).collect();
        let texture = Arc::new(ImageTexture { width: 4, height: 3, pixels, wrap: [Wrap::Clamp; 2] });
        QuadMesh { mesh, texture, stq: Vec::new(), light: None, runs: Vec::new() }
    }

    fn written(extras: Value) -> Vec<u8> {
        let mut bytes = Vec::new();
        glb::write(&scene(), extras, None, &mut bytes).unwrap();
        bytes
    }

    fn read(bytes: &[u8]) -> Result<QuadScene> {
        super::read(bytes, Folder::of(Path::new("a.glb")))
    }

    #[test]
    fn what_is_written_is_read_again_in_order() {
        let found = read(&written(json!({ "lightfold": { "frame": 7 } }))).unwrap();
        assert_eq!((found.frame, &found.quads.mesh), (7, &scene().mesh));
        assert_eq!(found.quads.texture.pixels, scene().texture.pixels);
        let plain = read(&written(json!({ "lightfold": {} }))).unwrap();
        assert_eq!((plain.frame, plain.quads.runs), (0, vec![]));
        let found = read(&written(json!({ "lightfold": { RUNS: [0, 5, 3] } }))).unwrap();
        assert_eq!(found.quads.runs, [0, 5, 3]);
        let mut projective = scene();
        projective.stq = (0..24).map(|at| Vec3::splat(1.0 + at as f32)).collect();
        let mut bytes = Vec::new();
        glb::write(&projective, json!({ "lightfold": {} }), None, &mut bytes).unwrap();
        assert_eq!(read(&bytes).unwrap().quads.stq, projective.stq);
        projective.stq[3].z = f32::NAN;
        bytes.clear();
        glb::write(&projective, json!({ "lightfold": {} }), None, &mut bytes).unwrap();
        assert!(read(&bytes).unwrap_err().to_string().contains("_TEXCOORD_STQ"));
    }

    #[test]
    fn gltf_from_elsewhere_is_refused() {
        let said = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        assert!(said(&written(json!({ "other": {} }))).contains("capture"));
        assert!(said(b"{\"asset\": {\"version\": \"2.0\"}}").contains("capture"));
        assert!(said(&written(json!({ "lightfold": { "frame": -1 } }))).contains("extras.lightfold.frame"));
        for runs in [json!([4, 5]), json!([-1, 9]), json!("all"), json!([4_294_967_295_u32, 9])] {
            let said = said(&written(json!({ "lightfold": { RUNS: runs } })));
            assert!(said.contains("runs_blended_opaque: lengths that add up to 8 triangles"), "{said}");
        }
        let own = Additions { extras: Some(json!({ "lightfold": {} })), attributes: &[], camera: None };
        let mut bytes = Vec::new();
        write::glb(&[scene().mesh], &[Material::default()], &own, &mut bytes).unwrap();
        assert!(said(&bytes).contains("no atlas"));
        let mut broken = scene();
        broken.mesh.positions[5].y = f64::INFINITY;
        bytes.clear();
        glb::write(&broken, json!({ "lightfold": {} }), None, &mut bytes).unwrap();
        assert!(said(&bytes).contains("corner 5"), "{}", said(&bytes));
        bytes.clear();
        write::glb(&[], &[], &own, &mut bytes).unwrap();
        assert!(said(&bytes).contains("no triangles"));
    }

    #[test]
    fn damaged_files_are_errors() {
        let bytes = written(json!({ "lightfold": {} }));
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
        // Changes every byte: the file is rejected, or it is read and drawn.
        let camera =
            codec::math::Camera::look_at(DVec3::ZERO, DVec3::X, DVec3::Y, codec::math::Lens::new(90.0)).unwrap();
        let mut read_again = 0;
        for at in 0..bytes.len() {
            let mut other = bytes.clone();
            other[at] ^= 0x41;
            if let Ok(found) = read(&other) {
                read_again += 1;
                crate::raster::draw(&found.quads, &camera, [4, 4]);
            }
        }
        assert!(read_again > 0);
    }
}
