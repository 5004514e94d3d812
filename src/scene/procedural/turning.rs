//! A knotted tube that rotates about the vertical in empty space: a mesh with normals.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::parts::{Definition, rgb};
use crate::mesh::{Material, Mesh};
use crate::{Light, MeshMaterial, Object, Phong, SceneAtTime, SceneMesh, Sky, Sun};

pub(super) const SCENE: Definition =
    Definition { name: "object", region: (DVec3::new(0.0, 0.2, 1.4), DVec3::new(0.5, 0.3, 0.2)), fixed: Vec::new, at };

/// Number of points along the tube, and around it.
const ALONG: u32 = 240;
const AROUND: u32 = 24;
/// Radius of the tube, metres.
const TUBE: f64 = 0.11;

fn at(phase: f64, objects: Vec<Object>) -> SceneAtTime {
    let sun = |direction: DVec3, radiance: DVec3| Sun { direction: direction.normalize(), radiance };
    let light = Light {
        suns: vec![
            sun(DVec3::new(0.6, 0.8, 0.7), rgb(1.8, 1.65, 1.4)),
            sun(DVec3::new(-0.9, 0.1, 0.5), rgb(0.2, 0.3, 0.5)),
        ],
        lamps: vec![],
        sky: Sky { ambient: rgb(0.12, 0.13, 0.15), ..Sky::NONE },
    };
    let painted = |base_color: DVec3| MeshMaterial {
        plain: Material { base_color, ..Material::default() },
        phong: Phong { weight: DVec3::splat(0.2), exponent: 50.0 },
        ..MeshMaterial::default()
    };
    let materials = [painted(rgb(0.5, 0.2, 0.09)), painted(rgb(0.6, 0.57, 0.5))];
    let mesh = SceneMesh::new(knot(&DQuat::from_rotation_y(TAU * phase)), materials.into());
    SceneAtTime::with_meshes(objects, vec![Arc::new(mesh)], light)
}

/// Returns a rotated trefoil knot; of every sixteen rings the first four have another colour.
fn knot(turn: &DQuat) -> Mesh {
    let middle = |t: f64| {
        let radius = 0.3 + 0.15 * (3.0 * t).cos();
        DVec3::new(radius * (2.0 * t).cos(), 0.22 * (3.0 * t).sin(), radius * (2.0 * t).sin())
    };
    let mut mesh = Mesh::default();
    for ring in 0..ALONG {
        let t = TAU * f64::from(ring) / f64::from(ALONG);
        let at = middle(t);
        let forward = (middle(t + 1e-4) - middle(t - 1e-4)).normalize();
        let side = forward.cross(DVec3::Y).normalize();
        let up = side.cross(forward);
        for step in 0..AROUND {
            let (sin, cos) = (TAU * f64::from(step) / f64::from(AROUND)).sin_cos();
            let normal = cos * side + sin * up;
            mesh.positions.push(*turn * (at + TUBE * normal));
            mesh.normals.push((*turn * normal).as_vec3());
            let corner = |ring: u32, step: u32| ring % ALONG * AROUND + step % AROUND;
            let [a, b, c, d] =
                [corner(ring, step), corner(ring + 1, step), corner(ring + 1, step + 1), corner(ring, step + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
            mesh.material_of.extend([u32::from(ring % 16 < 4); 2]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_turn_outwards_as_normals_do() {
        let mesh = knot(&DQuat::from_rotation_y(0.7));
        assert_eq!(mesh.triangles.len(), 2 * (ALONG * AROUND) as usize);
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(index);
            let normal = mesh.normals[triangle[0] as usize].as_dvec3();
            assert!((b - a).cross(c - a).normalize().dot(normal) > 0.8, "{index}");
        }
    }
}
