//! Size in bytes of a mesh in binary glTF, plain and with `EXT_meshopt_compression`.
//!
//! The extension is not written: it would save 7 to 10% of a file, most of which is the texture, and readers without a decoder
//! could not open the file. Indices are coded as a sequence, because the order of triangles is the drawing order; attributes are
//! coded without filters, which would move corners.

use meshopt::{encode_index_sequence, encode_vertex_buffer_level};

use super::quad_mesh::QuadMesh;
use codec::error::{Error, Result};

/// Version of the extension's vertex codec, which has no levels.
const VERTEX_VERSION: i32 = 0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GeometryBytes {
    /// Bytes of positions, texture coordinates and indices.
    pub plain: u64,
    pub meshopt: u64,
}

impl GeometryBytes {
    pub fn of(quads: &QuadMesh) -> Result<GeometryBytes> {
        let mesh = &quads.mesh;
        let mut bytes = GeometryBytes { plain: 0, meshopt: 0 };
        bytes.add_attribute(&mesh.positions.iter().map(|at| at.as_vec3().to_array()).collect::<Vec<_>>())?;
        bytes.add_attribute(&mesh.uvs.iter().map(|uv| uv.to_array()).collect::<Vec<_>>())?;
        bytes.add_attribute(&quads.stq.iter().map(|stq| stq.to_array()).collect::<Vec<_>>())?;
        let indices = mesh.triangles.as_flattened();
        let index_bytes = if mesh.positions.len() <= usize::from(u16::MAX) { 2 } else { 4 };
        let coded = encode_index_sequence(indices, mesh.positions.len()).map_err(failed)?;
        bytes.add((index_bytes * indices.len()).next_multiple_of(4), coded.len());
        Ok(bytes)
    }

    fn add_attribute<const N: usize>(&mut self, values: &[[f32; N]]) -> Result<()> {
        if !values.is_empty() {
            let coded = encode_vertex_buffer_level(values, 0, Some(VERTEX_VERSION)).map_err(failed)?;
            self.add(size_of_val(values), coded.len());
        }
        Ok(())
    }

    fn add(&mut self, plain: usize, coded: usize) {
        self.plain += plain as u64;
        self.meshopt += coded.next_multiple_of(4) as u64;
    }
}

fn failed(error: meshopt::Error) -> Error {
    Error::invalid(format!("meshopt: {error}"))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DVec3, Vec2};
    use serde_json::{Value, json};

    use super::*;
    use crate::export::glb;
    use scene::mesh::{ImageTexture, Mesh, Wrap};

    /// Returns quads side by side.
    fn quads(count: u32) -> QuadMesh {
        let mut mesh = Mesh::default();
        for at in 0..4 * count {
            mesh.positions.push(DVec3::new(f64::from(at / 4), f64::from(at % 4), -2.0));
            mesh.uvs.push(Vec2::new(at as f32 / (4.0 * count as f32), 0.25));
        }
        mesh.triangles = (0..count).map(|at| 4 * at).flat_map(|a| [[a, a + 1, a + 2], [a, a + 2, a + 3]]).collect();
        mesh.material_of = vec![0; mesh.triangles.len()];
        let texture = ImageTexture { width: 1, height: 1, pixels: vec![[0; 4]], wrap: [Wrap::Clamp; 2] };
        QuadMesh { mesh, texture: Arc::new(texture), stq: Vec::new(), light: None, runs: Vec::new() }
    }

    #[test]
    fn plain_bytes_are_those_of_the_file_and_coded_ones_are_fewer() {
        // Meshes with 16-bit and with 32-bit indices.
        for count in [300, 17_000] {
            let quads = quads(count);
            let found = GeometryBytes::of(&quads).unwrap();
            let mut file = Vec::new();
            glb::write(&quads, json!({ "lightfold": {} }), None, &mut file).unwrap();
            let root = serde_json::to_value(gltf::Gltf::from_slice(&file).unwrap().document.as_json()).unwrap();
            let views = root["bufferViews"].as_array().unwrap();
            let of_geometry = views.iter().filter(|view| view.get("target").is_some_and(Value::is_number));
            let bytes = of_geometry.map(|view| view["byteLength"].as_u64().unwrap().next_multiple_of(4)).sum::<u64>();
            assert_eq!(found.plain, bytes);
            assert!(found.meshopt > 0 && 2 * found.meshopt < found.plain, "{found:?}");
        }
    }

    #[test]
    fn the_sequence_keeps_the_order_of_triangles() {
        let quads = quads(50);
        let indices = quads.mesh.triangles.as_flattened();
        let coded = encode_index_sequence(indices, quads.mesh.positions.len()).unwrap();
        let decoded: Vec<u32> = meshopt::decode_index_sequence(&coded, indices.len()).unwrap();
        assert_eq!(decoded, indices);
    }
}
