//! Surfaces of revolution about a vertical axis, as triangles: bottles, pots, roofs.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::mesh::Mesh;

#[derive(Debug, Clone, Copy)]
pub(super) struct Lathe<'a> {
    /// Origin of the profile on the axis, metres.
    pub foot: DVec3,
    /// Radius and height of points from the bottom of the outside to the top, metres; a hollow body continues down its inside.
    pub profile: &'a [[f64; 2]],
    pub sides: Sides,
    /// Index of the material.
    pub material: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sides {
    /// A round body, with normals interpolated around it.
    Round(u32),
    /// Flat sides; four of them face ±X and ±Z.
    Flat(u32),
}

/// Cosine of the angle between two parts of a profile above which they share a normal.
const SMOOTH_COS: f64 = 0.75;

impl Lathe<'_> {
    /// Adds the triangles to a mesh.
    pub(super) fn add_to(&self, mesh: &mut Mesh) {
        let (count, start) = match self.sides {
            Sides::Round(count) => (count, 0.0),
            Sides::Flat(count) => (count, 0.5),
        };
        let parts: Vec<[DVec2; 2]> = self
            .profile
            .windows(2)
            .filter_map(|pair| Some([(*pair.first()?).into(), (*pair.last()?).into()]))
            .collect();
        let normals: Vec<DVec2> = parts.iter().map(|[from, to]| (*from - *to).perp().normalize_or_zero()).collect();
        for (at, ([low, high], own)) in parts.iter().zip(&normals).enumerate() {
            let shared = |other: Option<&DVec2>| match other {
                Some(other) if other.dot(*own) > SMOOTH_COS => (*other + *own).normalize_or_zero(),
                _ => *own,
            };
            let ends = [
                (*low, shared(at.checked_sub(1).and_then(|at| normals.get(at)))),
                (*high, shared(normals.get(at + 1))),
            ];
            for side in 0..count {
                let angle = |step: f64| TAU * (f64::from(side) + start + step) / f64::from(count);
                let corner = |step: f64, (point, normal): (DVec2, DVec2)| {
                    let turned = |v: DVec2, angle: f64| DVec3::new(v.x * angle.cos(), v.y, -v.x * angle.sin());
                    let facing = if matches!(self.sides, Sides::Flat(_)) { angle(0.5) } else { angle(step) };
                    (self.foot + turned(point, angle(step)), turned(normal, facing).as_vec3())
                };
                let [bottom, top] = ends;
                let first = mesh.positions.len() as u32;
                for (position, normal) in [corner(0.0, bottom), corner(1.0, bottom), corner(1.0, top), corner(0.0, top)]
                {
                    mesh.positions.push(position);
                    mesh.normals.push(normal);
                }
                let [a, b, c, d] = [first, first + 1, first + 2, first + 3];
                // At the axis a quadrilateral is a triangle.
                let halves = [(low.x > 0.0, [a, b, c]), (high.x > 0.0, [a, c, d])];
                for (_, triangle) in halves.into_iter().filter(|(has_area, _)| *has_area) {
                    mesh.triangles.push(triangle);
                    mesh.material_of.push(self.material);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SceneMesh;
    use crate::mesh::Ray;

    #[test]
    fn a_cone_is_closed_and_its_triangles_face_outwards() {
        for sides in [Sides::Round(24), Sides::Flat(4)] {
            let mut mesh = Mesh::default();
            let foot = DVec3::new(1.0, 2.0, 3.0);
            let profile = [[0.0, 0.0], [0.5, 0.0], [0.0, 1.0]];
            Lathe { foot, profile: &profile, sides, material: 0 }.add_to(&mut mesh);
            for (index, triangle) in mesh.triangles.iter().enumerate() {
                let [a, b, c] = mesh.corners(index);
                let across = (b - a).cross(c - a).normalize();
                assert!(across.dot(0.5 * (a + b) - foot - 0.3 * DVec3::Y) > 0.0, "{sides:?}: {index}");
                for &corner in triangle {
                    assert!(across.dot(mesh.normals[corner as usize].as_dvec3()) > 0.9, "{sides:?}: {index}");
                }
            }
            let solid = SceneMesh::new(mesh, [crate::MeshMaterial::default()].into());
            let through = Ray::new(foot + DVec3::new(-2.0, 0.5, 0.01), DVec3::X).unwrap();
            assert_eq!(solid.bvh.all(&through, 0.0..9.0).len(), 2, "{sides:?}");
            let down = Ray::new(foot + DVec3::new(0.05, 2.0, 0.02), DVec3::NEG_Y).unwrap();
            assert_eq!(solid.bvh.all(&down, 0.0..9.0).len(), 2, "{sides:?}");
        }
    }
}
