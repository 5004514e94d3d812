//! Writes a scene as Wavefront OBJ, in the form of the released Seurat: homogeneous texture coordinates are `vt s t q`, affine
//! ones `vt u v`. Both have their origin in the bottom left corner of the image.

use std::fmt::Write;

use super::scene::Scene;

/// Name of the material in both files.
const MATERIAL: &str = "quads";

pub fn bytes(scene: &Scene, materials: &str) -> Vec<u8> {
    let quads = scene.quads;
    let mut text =
        String::from("# Triangles are in drawing order, from back to front: blend them, without depth test.\n");
    let [min, max] = [scene.region.middle - scene.region.half, scene.region.middle + scene.region.half];
    // Writing to a string cannot fail.
    let _ =
        writeln!(text, "# Viewing region in metres: {} {} {} to {} {} {}", min.x, min.y, min.z, max.x, max.y, max.z);
    let _ = writeln!(text, "mtllib {materials}");
    for position in &quads.mesh.positions {
        let at = position.as_vec3();
        let _ = writeln!(text, "v {} {} {}", at.x, at.y, at.z);
    }
    for stq in &quads.stq {
        let _ = writeln!(text, "vt {} {} {}", stq.x, stq.z - stq.y, stq.z);
    }
    if quads.stq.is_empty() {
        for uv in &quads.mesh.uvs {
            let _ = writeln!(text, "vt {} {}", uv.x, 1.0 - uv.y);
        }
    }
    let _ = writeln!(text, "usemtl {MATERIAL}");
    for corners in &quads.mesh.triangles {
        let [a, b, c] = corners.map(|corner| corner + 1);
        let _ = writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}");
    }
    text.into_bytes()
}

/// Returns the material library: the unlit colour of the texture. Viewers take alpha from the same image.
pub fn material(texture: &str) -> Vec<u8> {
    format!("newmtl {MATERIAL}\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nillum 0\nmap_Kd {texture}\n").into_bytes()
}
