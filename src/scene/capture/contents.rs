//! What a file of meshes came to, told apart from what it may come to later.
//!
//! Enters: a scene. Leaves: a number that changes when corners, textures, paint or light do. A file's own bytes do not say
//! it all where it names others.

use std::hash::{DefaultHasher, Hasher};
use std::sync::Arc;

use crate::scene::animated::Scene;
use crate::scene::mesh::{Mesh, MeshMaterial};
use crate::scene::raycast::SceneAtTime;
use crate::scene::texture::ImageTexture;

/// A hash of what meshes and lights there are at the beginning, in the middle and at the end of the animation.
pub fn hash_of_scene(scene: &Scene) -> u64 {
    let mut hasher = DefaultHasher::new();
    let duration_s = scene.duration_s();
    let times = if duration_s > 0.0 { vec![0.0, 0.5 * duration_s, duration_s] } else { vec![0.0] };
    for time_s in times {
        hash_moment(&mut hasher, &scene.at(time_s));
    }
    hasher.finish()
}

fn hash_moment(hasher: &mut DefaultHasher, moment: &SceneAtTime) {
    hasher.write(format!("{:?}", moment.light()).as_bytes());
    hasher.write_usize(moment.meshes().len());
    for mesh in moment.meshes() {
        hash_mesh(hasher, mesh.mesh());
    }
}

fn hash_mesh(hasher: &mut DefaultHasher, mesh: &Mesh) {
    let Mesh { positions, normals, uvs, colors, triangles, material_of, materials } = mesh;
    let corners = [positions.len(), normals.len(), uvs.len(), colors.len()];
    for count in corners.into_iter().chain([triangles.len(), material_of.len(), materials.len()]) {
        hasher.write_usize(count);
    }
    positions.iter().flat_map(|at| at.to_array()).for_each(|value| hasher.write_u64(value.to_bits()));
    normals.iter().flat_map(|at| at.to_array()).for_each(|value| hasher.write_u32(value.to_bits()));
    uvs.iter().flat_map(|at| at.to_array()).for_each(|value| hasher.write_u32(value.to_bits()));
    colors.iter().flat_map(|at| at.to_array()).for_each(|value| hasher.write_u32(value.to_bits()));
    triangles.iter().flatten().chain(material_of).for_each(|index| hasher.write_u32(*index));
    materials.iter().for_each(|material| hash_material(hasher, material));
}

fn hash_material(hasher: &mut DefaultHasher, material: &MeshMaterial) {
    // Textures are told by their pixels; all else is short enough for words.
    let plain = MeshMaterial { base_texture: None, emissive_texture: None, ..material.clone() };
    hasher.write(format!("{plain:?}").as_bytes());
    hash_texture(hasher, material.base_texture.as_ref());
    hash_texture(hasher, material.emissive_texture.as_ref());
}

fn hash_texture(hasher: &mut DefaultHasher, texture: Option<&Arc<ImageTexture>>) {
    let Some(texture) = texture else { return hasher.write_u8(0) };
    hasher.write(format!("{} {} {:?}", texture.width, texture.height, texture.wrap).as_bytes());
    hasher.write(texture.pixels.as_flattened());
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec2, Vec4};

    use super::*;
    use crate::scene::raycast::Light;
    use crate::scene::{MeshBvh, Wrap};

    fn hash(change: impl FnOnce(&mut Mesh, &mut MeshMaterial, &mut ImageTexture)) -> u64 {
        let mut texture = ImageTexture { width: 1, height: 2, pixels: vec![[1, 2, 3, 4]; 2], wrap: [Wrap::Repeat; 2] };
        let mut material = MeshMaterial::default();
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            uvs: vec![Vec2::ZERO; 3],
            triangles: vec![[0, 1, 2]],
            material_of: vec![0],
            ..Mesh::default()
        };
        change(&mut mesh, &mut material, &mut texture);
        mesh.materials = [MeshMaterial { base_texture: Some(Arc::new(texture)), ..material }].into();
        let moment = SceneAtTime::with_meshes(Vec::new(), vec![Arc::new(MeshBvh::new(mesh))], Light::default());
        let mut hasher = DefaultHasher::new();
        hash_moment(&mut hasher, &moment);
        hasher.finish()
    }

    #[test]
    fn every_change_is_told() {
        let mut hashes = vec![
            hash(|_, _, _| ()),
            hash(|mesh, _, _| mesh.positions[1].x = 1.5),
            hash(|mesh, _, _| mesh.uvs[2].y = 0.5),
            hash(|mesh, _, _| mesh.triangles[0] = [0, 2, 1]),
            hash(|mesh, _, _| mesh.colors = vec![Vec4::ONE; 3]),
            hash(|_, material, _| material.alpha = 0.5),
            hash(|_, material, _| material.name = "b".into()),
            hash(|_, _, texture| texture.pixels[1][2] = 9),
            hash(|_, _, texture| texture.wrap[1] = Wrap::Clamp),
        ];
        assert_eq!(hashes[0], hash(|_, _, _| ()));
        hashes.sort_unstable();
        hashes.dedup();
        assert_eq!(hashes.len(), 9);
    }
}
