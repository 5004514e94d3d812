//! A closed mesh as a volume.
//!
//! A point is inside if its winding number is not 0. Shells that overlap, touch or coincide therefore form their union, and a
//! shell turned inwards inside another one is a cavity. The triangles must traverse each edge equally often in both directions.
//! `SampledScene::is_free` uses no winding number, because scenes have open meshes.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use super::sequence;
use crate::mesh::{AxisBox, Bvh, Mesh, Ray};
use crate::{Model, Play};
use codec::error::{Error, Result};

/// Number of rays that vote on whether a point is inside: an odd number, because a ray along an edge may give a wrong result.
const VOTES: usize = 5;
/// Thickness of the surface, as a fraction of the diagonal of the bounds.
const BORDER: f64 = 1e-12;

/// A closed mesh, at time 0 of its file.
#[derive(Debug, Clone)]
pub struct ClosedMesh {
    triangles: Vec<[DVec3; 3]>,
    pub bvh: Bvh,
    pub bounds: AxisBox,
}

impl ClosedMesh {
    pub fn open(path: &Path) -> Result<ClosedMesh> {
        let (model, _) = Model::open(path, Play::All)?;
        let meshes = model.at(0.0).meshes.iter().map(|part| part.mesh.clone()).collect();
        Self::new(meshes).map_err(|error| error.in_file(path))
    }

    /// Creates the union of the shells of all meshes; equal corners are merged. Fails if there are no triangles, or if an edge is
    /// open or its triangles have inconsistent orientations.
    pub fn new(meshes: Vec<Mesh>) -> Result<ClosedMesh> {
        let triangles: Vec<[DVec3; 3]> = meshes
            .iter()
            .flat_map(|mesh| (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)))
            .filter(|corners| corners.iter().all(|corner| corner.is_finite()))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        let Some(bounds) = AxisBox::around(triangles.iter().flatten().copied()) else {
            return Err(Error::invalid("a region needs a closed mesh, and this mesh has no triangles"));
        };
        let (open, turned) = wrong_edges(&triangles);
        if open > 0 {
            return Err(Error::invalid(format!(
                "a region needs a closed mesh, and {open} edges of this one have an odd number of triangles; close its holes"
            )));
        }
        if turned > 0 {
            return Err(Error::invalid(format!(
                "a region needs a mesh whose faces all point outwards, and at {turned} edges of this one neighbours \
                point to different sides: flip them"
            )));
        }
        let bvh = Bvh::new(triangles.iter().copied());
        Ok(ClosedMesh { triangles, bvh, bounds })
    }

    /// Returns true if the winding number of the point is not 0, or if the point is on the surface.
    pub fn contains(&self, point: DVec3) -> bool {
        if !self.bounds.contains(point) {
            return false;
        }
        let border_m = BORDER * (self.bounds.max - self.bounds.min).length();
        let votes = (0..VOTES).filter(|&vote| {
            let ray = Ray::new(point, sequence::on_sphere(vote, VOTES));
            ray.is_some_and(|ray| self.winding(&ray, border_m) != Some(0))
        });
        votes.count() > VOTES / 2
    }

    /// Returns the winding number of the ray's origin; `None` if a triangle is within `border_m`. Coincident triangles are
    /// counted separately.
    fn winding(&self, ray: &Ray, border_m: f64) -> Option<i64> {
        let mut winding = 0;
        for hit in self.bvh.all(ray, -2.0 * border_m..f64::INFINITY) {
            if hit.distance.abs() <= border_m {
                return None;
            }
            if hit.distance > 0.0 {
                let [a, b, c] = self.triangles[hit.triangle];
                winding += if (b - a).cross(c - a).dot(ray.direction()) > 0.0 { 1 } else { -1 };
            }
        }
        Some(winding)
    }
}

fn wrong_edges(triangles: &[[DVec3; 3]]) -> (usize, usize) {
    // Adding 0 turns −0 into 0.
    let key = |corner: DVec3| corner.to_array().map(|value| (value + 0.0).to_bits());
    let mut edges: HashMap<[[u64; 3]; 2], i64> = HashMap::new();
    for [a, b, c] in triangles.iter().map(|corners| corners.map(key)) {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *edges.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
    }
    let open = edges.values().filter(|sum| *sum % 2 != 0).count();
    let turned = edges.values().filter(|sum| **sum != 0).count() - open;
    (open, turned)
}

#[cfg(test)]
mod tests {
    use super::super::sequence::in_cube;
    use super::*;

    /// A box of triangles whose faces point outwards.
    pub fn box_mesh(min: DVec3, max: DVec3) -> Mesh {
        let positions = AxisBox { min, max }.corners().to_vec();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let material_of = vec![0; triangles.len()];
        Mesh { positions, triangles, material_of, ..Mesh::default() }
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
                assert!((mesh.bvh.distance_m(point) - distance).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn shells_that_overlap_touch_or_lie_in_one_place_are_their_union() {
        let boxes = |corners: &[[f64; 2]]| {
            let mesh = |&[from, to]: &[f64; 2]| box_mesh(DVec3::new(from, 0.0, 0.0), DVec3::new(to, 1.0, 1.0));
            ClosedMesh::new(corners.iter().map(mesh).collect()).unwrap()
        };
        let sets: [&[[f64; 2]]; 4] = [
            &[[0.0, 2.0], [1.0, 3.0]],
            &[[0.0, 1.0], [1.0, 3.0]],
            &[[0.0, 3.0], [0.0, 3.0]],
            &[[0.0, 3.0], [0.0, 3.0], [1.0, 2.0], [1.0, 2.0]],
        ];
        for set in sets {
            let mesh = boxes(set);
            for point in (0..400).map(|at| in_cube(at) * DVec3::new(5.0, 2.0, 2.0) - DVec3::new(1.0, 0.5, 0.5)) {
                let inside = point.min(DVec3::new(3.0, 1.0, 1.0) - point).min_element() > 0.0;
                assert_eq!(mesh.contains(point), inside, "{set:?} {point}");
            }
            // Points on the wall that two of the boxes share, and on the outer wall.
            assert!(
                mesh.contains(DVec3::new(1.0, 0.37, 0.52)) && mesh.contains(DVec3::new(3.0, 0.37, 0.52)),
                "{set:?}"
            );
        }
    }

    #[test]
    fn a_shell_turned_inwards_is_a_cavity_and_one_turned_as_a_whole_is_a_volume() {
        let turned = |min: f64, max: f64| {
            let mut mesh = box_mesh(DVec3::splat(min), DVec3::splat(max));
            mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
            mesh
        };
        let cavity = ClosedMesh::new(vec![box_mesh(DVec3::ZERO, DVec3::splat(3.0)), turned(1.0, 2.0)]).unwrap();
        let at = |mesh: &ClosedMesh, x: f64| mesh.contains(DVec3::new(x, 1.3, 1.6));
        assert_eq!([0.5, 1.5, 2.5].map(|x| at(&cavity, x)), [true, false, true]);
        let alone = ClosedMesh::new(vec![turned(0.0, 3.0)]).unwrap();
        assert_eq!([-0.5, 1.5, 3.5].map(|x| at(&alone, x)), [false, true, false]);
        // If one face is turned against its neighbours, the inside is not defined.
        let mut one = box_mesh(DVec3::ZERO, DVec3::ONE);
        one.triangles[3].swap(0, 1);
        assert!(ClosedMesh::new(vec![one]).unwrap_err().to_string().contains("3 edges"));
    }

    #[test]
    fn a_mesh_with_a_hole_or_without_triangles_is_refused() {
        let mut mesh = box_mesh(DVec3::ZERO, DVec3::ONE);
        mesh.triangles.pop();
        assert!(ClosedMesh::new(vec![mesh]).unwrap_err().to_string().contains("3 edges"));
        assert!(ClosedMesh::new(vec![]).unwrap_err().to_string().contains("no triangles"));
    }
}
