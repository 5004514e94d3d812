//! Writes a scene as binary glTF: one unlit, blended, double-sided primitive whose triangles are in drawing order.

use std::io::Write;

use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use crate::budgets::Budgets;
use crate::cost::TextureCoordinates;
use crate::gbuffer::SurfaceAtlas;
use crate::quad_mesh::QuadMesh;
use crate::region::ViewingRegion;
use codec::error::Result;
use codec::math::{Camera, Lens};
use scene::mesh::Material;
use scene::mesh::gltf::write::{self, Additions};

/// glTF has no homogeneous texture coordinates, so they are an application-specific attribute. TEXCOORD_0 is written, too,
/// because the Khronos validator reports a textured primitive without it.
const HOMOGENEOUS: &str = "_TEXCOORD_STQ";

/// Vertical field of view of the camera in degrees.
const FOV_Y_DEG: f64 = 60.0;
/// Near plane of the camera, as a fraction of the distance of the nearest corner, and far plane, in distances of the farthest.
const NEAR_PART: f64 = 0.1;
const FAR_PART: f64 = 2.0;
/// Minimum length of the mean direction of triangles; below it they are on all sides.
const MIN_DIRECTION: f64 = 0.3;
/// Maximum height of the viewing direction, as a sine, above which +Y is no up direction.
const MAX_HEIGHT: f64 = 0.999;

/// Input of the file writers: a scene, and the metadata that files store with it.
#[derive(Debug)]
pub struct Scene<'a> {
    pub quads: &'a QuadMesh,
    pub region: &'a ViewingRegion,
    pub budgets: &'a Budgets,
    /// Frame of the capture.
    pub frame: u32,
    /// Maximum side of the atlas, in texels.
    pub atlas: u32,
    pub coordinates: TextureCoordinates,
    pub surfaces: Option<&'a SurfaceAtlas>,
}

/// Writes the mesh. `extras` is stored as the extras of the file.
pub fn write(quads: &QuadMesh, extras: Value, camera: Option<Camera>, out: &mut dyn Write) -> Result<()> {
    let material = Material {
        name: "quads".into(),
        base_color: DVec3::ONE,
        base_texture: Some(quads.texture.clone()),
        is_blended: true,
        specular: None,
        unlit: true,
        ..Material::default()
    };
    let stq: &[(&str, &[Vec3])] = &[(HOMOGENEOUS, &quads.stq)];
    let attributes = if quads.stq.is_empty() { &[] } else { stq };
    let additions = Additions { extras: Some(extras), attributes, camera };
    write::glb(std::slice::from_ref(&quads.mesh), &[material], &additions, out)
}

/// Returns the bytes of the file. `textures` are the names of files with the same texture.
pub fn bytes(scene: &Scene, textures: &[&str]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write(scene.quads, extras(scene, textures), Some(camera(scene)?), &mut bytes)?;
    Ok(bytes)
}

/// Returns a camera at the centre of the viewing region, which looks at the middle of the triangles.
fn camera(scene: &Scene) -> Result<Camera> {
    let (mesh, eye) = (&scene.quads.mesh, scene.region.middle);
    let distances_m = || mesh.positions.iter().map(|&position| position.distance(eye));
    let (mut sum, mut all) = (DVec3::ZERO, 0.0);
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize] - eye);
        let middle = (a + b + c) / 3.0;
        // About the solid angle.
        let seen = (b - a).cross(c - a).dot(middle).abs() / middle.length().powi(3);
        if seen.is_finite() {
            sum += seen * middle.normalize_or_zero();
            all += seen;
        }
    }
    let is_around = sum.length() < MIN_DIRECTION * all;
    let forward = if is_around { DVec3::NEG_Z } else { sum.normalize_or(DVec3::NEG_Z) };
    let up = if forward.y.abs() > MAX_HEIGHT { DVec3::NEG_Z } else { DVec3::Y };
    let lens = Lens {
        near_m: NEAR_PART * distances_m().fold(f64::INFINITY, f64::min),
        far_m: FAR_PART * distances_m().fold(0.0, f64::max),
        ..Lens::new(FOV_Y_DEG)
    };
    Camera::look_at(eye, eye + forward, up, lens)
}

fn extras(scene: &Scene, textures: &[&str]) -> Value {
    let corners = [scene.region.middle - scene.region.half, scene.region.middle + scene.region.half];
    let coordinates = match scene.coordinates {
        TextureCoordinates::Affine => "affine",
        TextureCoordinates::Projective => {
            "projective: s/q and t/q of _TEXCOORD_STQ; TEXCOORD_0 is right at the corners alone"
        }
    };
    let mut extras = json!({
        "frame": scene.frame,
        "viewing_region_m": corners.map(|corner| corner.to_array()),
        "triangles": scene.budgets.triangles,
        "projected_area": scene.budgets.area,
        "peak_overdraw": scene.budgets.peak_overdraw,
        "atlas": scene.atlas,
        "drawing_order": "back to front, as stored; blend without depth test, without culling, and without sorting",
        "texture_coordinates": coordinates,
        "alpha": "straight",
        // Lengths of runs of triangles, alternately blended and opaque.
        "runs_blended_opaque": scene.quads.runs,
        "three_js": { "material.forceSinglePass": true, "renderer.sortObjects": false },
    });
    if !textures.is_empty() {
        extras["textures"] = json!(textures);
    }
    json!({ "lightfold": extras })
}
