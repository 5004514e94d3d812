//! A mesh file as a volume.
//!
//! Enters: triangles without a border. Leaves: whether a point is inside, by the parity of crossings, and how far outside.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use super::sequence;
use super::triangle_tree::TriangleTree;
use crate::error::{Error, Result};
use crate::scene::{AxisBox, Mesh, MeshBvh, Model, Ray};

/// Rays that vote on whether a point is inside: an odd number.
const VOTES: usize = 5;

/// A closed mesh, at time 0 of its file.
#[derive(Debug, Clone)]
pub struct ClosedMesh {
    parts: Vec<MeshBvh>,
    tree: TriangleTree,
    bounds: AxisBox,
}

impl ClosedMesh {
    /// Reads a mesh file.
    ///
    /// # Errors
    /// When it cannot be read, is empty or has a border.
    pub fn open(path: &Path) -> Result<ClosedMesh> {
        let (model, _) = Model::open(path)?;
        let meshes = model.at(0.0).meshes().iter().map(|part| part.mesh().clone()).collect();
        Self::new(meshes).map_err(|error| error.in_file(path))
    }

    /// The volume of meshes. Every edge must have an even number of triangles; corners at the same place are one.
    ///
    /// # Errors
    /// When there is no triangle, or an edge with an odd number of them.
    pub fn new(meshes: Vec<Mesh>) -> Result<ClosedMesh> {
        let triangles: Vec<[DVec3; 3]> = meshes
            .iter()
            .flat_map(|mesh| (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)))
            .filter(|corners| corners.iter().all(|corner| corner.is_finite()))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        if triangles.is_empty() {
            return Err(Error::invalid("a region needs a closed mesh, and this has no triangles"));
        }
        let open = open_edges(&triangles);
        if open > 0 {
            return Err(Error::invalid(format!(
                "a region needs a closed mesh, and {open} edges of this one have an odd number of triangles; close its holes"
            )));
        }
        let corners = || triangles.iter().flatten();
        let bounds = AxisBox {
            min: corners().fold(DVec3::INFINITY, |min, corner| min.min(*corner)),
            max: corners().fold(DVec3::NEG_INFINITY, |max, corner| max.max(*corner)),
        };
        let parts = meshes.into_iter().map(MeshBvh::new).collect();
        Ok(ClosedMesh { parts, tree: TriangleTree::new(triangles), bounds })
    }

    /// A box around it.
    pub fn bounds(&self) -> AxisBox {
        self.bounds
    }

    /// Whether most of some rays cross it an odd number of times: a ray along an edge may be wrong, most are not.
    pub fn contains(&self, point: DVec3) -> bool {
        let inside_bounds = (point - self.bounds.min).min(self.bounds.max - point).min_element() >= 0.0;
        inside_bounds && (0..VOTES).filter(|&vote| self.crossings(point, vote) % 2 == 1).count() > VOTES / 2
    }

    fn crossings(&self, point: DVec3, vote: usize) -> usize {
        let Some(ray) = Ray::new(point, sequence::on_sphere(vote, VOTES)) else { return 0 };
        let along = |part: &MeshBvh| {
            let mut last = 0.0;
            let mut count = 0;
            // No more than there are triangles: two that are equally far count as one.
            while let Some(hit) = part.nearest(&ray, last).filter(|_| count < part.mesh().triangles.len()) {
                last = hit.distance;
                count += 1;
            }
            count
        };
        self.parts.iter().map(along).sum()
    }

    /// Metres to the nearest triangle, from inside or outside.
    pub fn surface_distance_m(&self, point: DVec3) -> f64 {
        self.tree.distance_m(point)
    }
}

/// Edges with an odd number of triangles.
fn open_edges(triangles: &[[DVec3; 3]]) -> usize {
    // −0 and 0 are one place.
    let key = |corner: DVec3| corner.to_array().map(|value| (value + 0.0).to_bits());
    let mut counts: HashMap<[[u64; 3]; 2], u32> = HashMap::new();
    for [a, b, c] in triangles.iter().map(|corners| corners.map(key)) {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *counts.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    counts.values().filter(|count| *count % 2 == 1).count()
}

#[cfg(test)]
mod tests {
    use super::super::sequence::in_cube;
    use super::*;

    /// A box of triangles, faces outwards.
    pub fn box_mesh(min: DVec3, max: DVec3) -> Mesh {
        let positions = AxisBox { min, max }.corners().to_vec();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let material_of = vec![0; triangles.len()];
        Mesh { positions, triangles, material_of, materials: vec![Default::default()].into(), ..Mesh::default() }
    }

    #[test]
    fn a_box_of_triangles_is_a_box() {
        let (min, max) = (DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 3.0, 3.0));
        let mesh = ClosedMesh::new(vec![box_mesh(min, max)]).unwrap();
        for point in (0..500).map(|at| in_cube(at) * 6.0 - 2.0) {
            let inside = (point - min).min(max - point).min_element() > 0.0;
            assert_eq!(mesh.contains(point), inside, "{point}");
            if !inside {
                let distance = (min - point).max(point - max).max(DVec3::ZERO).length();
                assert!((mesh.surface_distance_m(point) - distance).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_mesh_with_a_hole_or_without_triangles_is_refused() {
        let mut mesh = box_mesh(DVec3::ZERO, DVec3::ONE);
        mesh.triangles.pop();
        assert!(ClosedMesh::new(vec![mesh]).unwrap_err().to_string().contains("3 edges"));
        assert!(ClosedMesh::new(vec![]).unwrap_err().to_string().contains("no triangles"));
    }
}
