//! Rays against meshes.
//!
//! Enters: a [`Mesh`]. Leaves: the nearest triangle along a ray, or whether there is any.

use glam::{DVec2, DVec3};

use super::mesh::Mesh;
use super::primitive::Ray;

/// Where a ray meets a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshHit {
    /// Metres along the ray.
    pub distance: f64,
    /// Index of the triangle; the lowest of those that are equally near.
    pub triangle: usize,
    /// Weights of its second and third corner.
    pub barycentric: DVec2,
}

/// A mesh that rays can be asked of.
#[derive(Debug, Clone)]
pub struct MeshBvh {
    mesh: Mesh,
}

impl MeshBvh {
    /// Builds the tree. Triangles that are not finite, or have no area, are never met.
    pub fn new(mesh: Mesh) -> MeshBvh {
        MeshBvh { mesh }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The nearest triangle beyond `min_distance` along the ray, from either side.
    pub fn nearest(&self, ray: &Ray, min_distance: f64) -> Option<MeshHit> {
        let mut best: Option<MeshHit> = None;
        for triangle in 0..self.mesh.triangles.len() {
            let Some((distance, barycentric)) = meet(self.mesh.corners(triangle), ray) else { continue };
            if distance > min_distance && best.is_none_or(|best| distance < best.distance) {
                best = Some(MeshHit { distance, triangle, barycentric });
            }
        }
        best
    }

    /// Whether any triangle lies between `min_distance` and `max_distance` along the ray.
    pub fn occluded(&self, ray: &Ray, min_distance: f64, max_distance: f64) -> bool {
        self.nearest(ray, min_distance).is_some_and(|hit| hit.distance < max_distance)
    }
}

fn meet([a, b, c]: [DVec3; 3], ray: &Ray) -> Option<(f64, DVec2)> {
    let (ab, ac) = (b - a, c - a);
    let across = ray.direction().cross(ac);
    let volume = ab.dot(across);
    let from = ray.origin() - a;
    let u = from.dot(across) / volume;
    let turned = from.cross(ab);
    let v = ray.direction().dot(turned) / volume;
    let distance = ac.dot(turned) / volume;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some((distance, DVec2::new(u, v)))
}
