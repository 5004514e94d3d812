//! Surface attributes at a hit, the same for shapes and triangles. Normals point to the side of the ray's origin, so the
//! visible side is lit.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::{FirstHit, HitSurface, MeshMaterial, Object, Optics, Phong, SceneAtTime, SceneMesh};
use crate::mesh::{ImageTexture, Intersection, Ray, TriangleHit};

#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    pub point: DVec3,
    /// Geometric unit normal.
    pub side: DVec3,
    /// Shading normal, unit length, less than 90° from `side`.
    pub normal: DVec3,
    /// True if the surface is seen from inside the solid.
    pub from_within: bool,
    pub albedo: DVec3,
    pub emission: DVec3,
    pub phong: Phong,
    pub optics: Optics,
    pub unlit: bool,
}

impl SceneAtTime {
    pub(super) fn surface(&self, ray: &Ray, hit: &FirstHit) -> Surface {
        match hit.surface {
            HitSurface::Object { index, normal } => {
                of_object(&self.objects[index], ray, &Intersection { distance: hit.distance, normal })
            }
            HitSurface::Mesh { index, at } => of_mesh(&self.meshes[index], ray, &at),
        }
    }
}

fn of_object(object: &Object, ray: &Ray, hit: &Intersection) -> Surface {
    let outward = hit.normal;
    let from_within = outward.dot(ray.direction()) > 0.0;
    let normal = if from_within { -outward } else { outward };
    let point = ray.at(hit.distance);
    let turn = object.texture_from_world;
    let (local_point, local_normal) = if turn == DQuat::IDENTITY {
        (point - object.anchor, normal)
    } else {
        (turn * (point - object.anchor), turn * normal)
    };
    Surface {
        point,
        side: normal,
        normal,
        from_within,
        albedo: object.material.texture.albedo(local_point, local_normal),
        emission: object.material.emission,
        phong: object.material.phong,
        optics: object.material.optics,
        unlit: false,
    }
}

fn of_mesh(scene_mesh: &SceneMesh, ray: &Ray, hit: &TriangleHit) -> Surface {
    let mesh = &scene_mesh.mesh;
    let corners = mesh.corners(hit.triangle);
    let outward = outward(&corners);
    let from_within = outward.dot(ray.direction()) > 0.0;
    let side = if from_within { -outward } else { outward };
    let [second, third] = hit.barycentric.to_array();
    let first = 1.0 - second - third;
    // Interpolated from the corners, because f64 is less precise at the end of a long ray.
    let point = first * corners[0] + second * corners[1] + third * corners[2];
    let normal = if mesh.normals.is_empty() {
        side
    } else {
        let [a, b, c] = mesh.triangles[hit.triangle].map(|corner| mesh.normals[corner as usize].as_dvec3());
        let between = (first * a + second * b + third * c).try_normalize().unwrap_or(side);
        if between.dot(side) < 0.0 { -between } else { between }
    };
    let absent = MeshMaterial::default();
    let material = scene_mesh.material(hit.triangle).unwrap_or(&absent);
    let uv = mesh.uv(hit.triangle, hit.barycentric);
    let textured = |color: DVec3, texture: &Option<Arc<ImageTexture>>| match texture {
        Some(texture) if color != DVec3::ZERO => color * texture.sample(uv).0,
        _ => color,
    };
    let mut painted = Surface {
        point,
        side,
        normal,
        from_within,
        albedo: textured(material.plain.base_color, &material.plain.base_texture),
        emission: textured(material.plain.emission, &material.plain.emissive_texture),
        phong: material.phong,
        optics: material.optics,
        unlit: material.plain.unlit,
    };
    if let Some(color) = mesh.color(hit.triangle, hit.barycentric) {
        painted.tint(color.truncate(), material.metal);
    }
    painted
}

impl Surface {
    /// Multiplies the base colour, which is also the highlight of a metal and the tint of optics.
    fn tint(&mut self, color: DVec3, metal: DVec3) {
        self.albedo *= color;
        self.phong.weight -= metal * (1.0 - color);
        if let Optics::Mirror { tint } | Optics::Glass { tint, .. } = &mut self.optics {
            *tint *= color;
        }
    }
}

/// Returns the geometric unit normal of the front side, for triangles of any size.
fn outward([a, b, c]: &[DVec3; 3]) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let size = ab.abs().max_element().max(ac.abs().max_element());
    let across = (ab / size).cross(ac / size);
    // The squared area of a very thin triangle underflows.
    let across = across / across.abs().max_element();
    across.try_normalize().unwrap_or(DVec3::Y)
}
