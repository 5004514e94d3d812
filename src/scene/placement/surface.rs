//! Points on the surfaces of a scene, uniform by area: samples for the integrals of CALF 4. Points that are adjacent in the list
//! are close in space.

use std::f64::consts::TAU;

use glam::DVec3;

use super::sequence;
use crate::mesh::AxisBox;
use crate::{Quad, SceneAtTime, Shape, Sphere, TurnedBox};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    pub point: DVec3,
    /// Unit normal, which points out of the solid or to the front of the triangle.
    pub normal: DVec3,
}

#[derive(Debug, Clone, Default)]
pub struct SurfacePoints {
    pub points: Vec<SurfacePoint>,
    /// Area that each point represents, in square metres.
    pub area_of_each: f64,
}

/// A part of the surface of known area.
enum Patch {
    Flat(Quad),
    Ball(Sphere),
    /// Indices of a mesh and of its triangle.
    Triangle {
        mesh: usize,
        triangle: usize,
    },
}

/// Samples `count` points, one in each of `count` strips of equal area. `first` is the index in [`sequence::in_cube`] of the
/// first point. Points in holes of textures are left out.
pub fn sample(scene: &SceneAtTime, count: usize, first: u64) -> SurfacePoints {
    let (patches, ends) = patches(scene);
    let area = ends.last().copied().unwrap_or(0.0);
    if !(area > 0.0 && area.is_finite()) {
        return SurfacePoints::default();
    }
    let place = |at: usize| {
        // Point 0 is the centre of the cube, which lies on the edge of a triangle.
        let within = sequence::in_cube(first + at as u64 + 1);
        let patch = ends.partition_point(|end| *end <= (at as f64 + within.x) / count as f64 * area);
        on_patch(scene, &patches[patch.min(patches.len() - 1)], within.y, within.z)
    };
    let mut points: Vec<SurfacePoint> = (0..count).filter_map(place).collect();
    sort_in_space(&mut points);
    SurfacePoints { points, area_of_each: area / count as f64 }
}

/// Returns all patches whose area is above 0, and their cumulative areas.
fn patches(scene: &SceneAtTime) -> (Vec<Patch>, Vec<f64>) {
    let mut patches = Vec::new();
    let mut ends = Vec::new();
    let mut sum = 0.0;
    let mut add = |patch: Patch, area: f64| {
        if area > 0.0 && area.is_finite() {
            sum += area;
            patches.push(patch);
            ends.push(sum);
        }
    };
    let mut flats = Vec::new();
    for object in &scene.objects {
        match &object.shape {
            Shape::Sphere(ball) => add(Patch::Ball(*ball), 2.0 * TAU * ball.radius * ball.radius),
            Shape::Quad(quad) => flats.push(*quad),
            Shape::AxisBox(solid) => flats.extend(sides(solid)),
            Shape::TurnedBox(solid) => flats.extend(turned_sides(solid)),
            // Parts of a fence that are inside each other are never visible.
            Shape::Fence(fence) => {
                let solids = fence.rails.into_iter().map(|rail| fence.rail(rail));
                flats.extend(
                    solids.chain((0..fence.posts).map(|post| fence.post(post))).flat_map(|solid| sides(&solid)),
                );
            }
        }
    }
    for quad in flats {
        add(Patch::Flat(quad), quad.u.cross(quad.v).length());
    }
    for (mesh, of_mesh) in scene.meshes.iter().enumerate() {
        for triangle in 0..of_mesh.mesh.triangles.len() {
            let [a, b, c] = of_mesh.mesh.corners(triangle);
            add(Patch::Triangle { mesh, triangle }, 0.5 * (b - a).cross(c - a).length());
        }
    }
    (patches, ends)
}

/// Returns the sides of a box, whose normals point outwards.
fn sides(solid: &AxisBox) -> [Quad; 6] {
    let size = solid.max - solid.min;
    let [x, y, z] = [DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z];
    [
        [solid.min, z, y],
        [solid.min + x, y, z],
        [solid.min, x, z],
        [solid.min + y, z, x],
        [solid.min, y, x],
        [solid.min + z, x, y],
    ]
    .map(|[corner, u, v]| Quad { corner, u, v })
}

fn turned_sides(solid: &TurnedBox) -> [Quad; 6] {
    let turned = |edge: DVec3| solid.to_world(edge);
    sides(&AxisBox { min: -solid.half, max: solid.half }).map(|Quad { corner, u, v }| Quad {
        corner: solid.center + turned(corner),
        u: turned(u),
        v: turned(v),
    })
}

/// Returns the point of a patch at two coordinates in 0..1, uniform by area; `None` in a hole.
fn on_patch(scene: &SceneAtTime, patch: &Patch, s: f64, t: f64) -> Option<SurfacePoint> {
    match *patch {
        Patch::Flat(Quad { corner, u, v }) => {
            Some(SurfacePoint { point: corner + s * u + t * v, normal: u.cross(v).try_normalize()? })
        }
        Patch::Ball(Sphere { center, radius }) => {
            let normal = sequence::around(s, 1.0 - 2.0 * t);
            Some(SurfacePoint { point: center + radius * normal, normal })
        }
        Patch::Triangle { mesh, triangle } => {
            let mesh = scene.meshes.get(mesh)?;
            let [a, b, c] = mesh.mesh.corners(triangle);
            // Mirrors the half of the square beyond the diagonal into the triangle.
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            let is_hole = mesh.is_hole(triangle, glam::DVec2::new(s, t));
            let normal = (b - a).cross(c - a).try_normalize()?;
            (!is_hole).then_some(SurfacePoint { point: a + s * (b - a) + t * (c - a), normal })
        }
    }
}

/// Sorts points along a Morton curve of 1024 cells along each axis.
fn sort_in_space(points: &mut [SurfacePoint]) {
    let Some(AxisBox { min, max }) = AxisBox::around(points.iter().map(|at| at.point)) else { return };
    let side = (max - min).max_element().max(f64::MIN_POSITIVE);
    let code = |at: &SurfacePoint| {
        let cells = ((at.point - min) / side * 1023.0).to_array().map(|along| along as u64);
        (0..10).fold(0, |code, bit| {
            code | (0..3).fold(0, |cell, axis| cell | (cells[axis] >> bit & 1) << (3 * bit + axis))
        })
    };
    // The sort is stable: points of one cell stay in the order of strips.
    points.sort_by_cached_key(code);
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::mesh::{Material as PlainMaterial, Mesh, Ray};
    use crate::{DemoKind, DemoScene, Light, Material, MeshMaterial, Object, SceneMesh, Texture};

    fn scene(shapes: Vec<Shape>) -> SceneAtTime {
        let paint = Material::diffuse(Texture::Solid(DVec3::ONE));
        SceneAtTime::new(shapes.into_iter().map(|shape| Object::new(shape, paint)).collect(), Light::default())
    }

    #[test]
    fn points_lie_where_the_area_is() {
        let ball = Sphere { center: DVec3::new(9.0, 0.0, 0.0), radius: 1.0 };
        let solid = AxisBox { min: DVec3::ZERO, max: DVec3::new(1.0, 2.0, 3.0) };
        let found = sample(&scene(vec![Shape::Sphere(ball), Shape::AxisBox(solid)]), 4000, 0);
        assert!((found.area_of_each * 4000.0 - (2.0 * TAU + 22.0)).abs() < 1e-9);
        let on_ball = found.points.iter().filter(|at| at.point.x > 2.0).count() as f64;
        assert!((on_ball / 4000.0 - 2.0 * TAU / (2.0 * TAU + 22.0)).abs() < 0.001, "{on_ball}");
        for at in &found.points {
            assert!((at.normal.length() - 1.0).abs() < 1e-12);
            // The normal points outwards: the space above a surface point is empty.
            let outside = at.point + 1e-6 * at.normal;
            let in_box = (outside - solid.min).min(solid.max - outside).min_element() > 0.0;
            assert!(!in_box && outside.distance(ball.center) > 1.0, "{at:?}");
        }
    }

    #[test]
    fn every_shape_has_its_points_on_its_surface() {
        let found = DemoScene::new(DemoKind::Courtyard).at(0.7);
        for object in &found.objects {
            let alone = scene(vec![object.shape]);
            let mut met = 0;
            let points = sample(&alone, 200, 5).points;
            for at in &points {
                let ray = Ray::new(at.point + 0.01 * at.normal, -at.normal).unwrap();
                let Some(hit) = object.shape.intersect(&ray, 0.0) else { continue };
                met += 1;
                // Posts and rails of a fence intersect each other.
                let fits = (hit.distance - 0.01).abs() < 1e-9 || matches!(object.shape, Shape::Fence(_));
                assert!(fits, "{:?} {at:?} {hit:?}", object.shape);
            }
            assert!(met == points.len() && met > 150, "{:?}: {met} of {}", object.shape, points.len());
        }
    }

    #[test]
    fn neighbours_in_the_list_are_neighbours_in_space() {
        let floor = Quad { corner: DVec3::ZERO, u: DVec3::X, v: DVec3::Z };
        let points = sample(&scene(vec![Shape::Quad(floor)]), 1024, 0).points;
        let mean = points.windows(2).map(|pair| pair[0].point.distance(pair[1].point)).sum::<f64>() / 1023.0;
        assert!(mean < 0.06, "{mean}");
    }

    #[test]
    fn holes_and_triangles_without_area_have_no_points() {
        let triangles = vec![[0, 1, 2], [0, 1, 1], [0, 1, 3]];
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NAN];
        let solid = MeshMaterial::default();
        let plain = PlainMaterial { alpha: 0.2, alpha_cutoff: Some(0.5), ..PlainMaterial::default() };
        let hole = MeshMaterial { plain, ..MeshMaterial::default() };
        for (material, expected) in [(solid, 50), (hole, 0)] {
            let mesh = Mesh {
                positions: positions.clone(),
                triangles: triangles.clone(),
                material_of: vec![0; 3],
                ..Mesh::default()
            };
            let scene = SceneAtTime::with_meshes(
                vec![],
                vec![Arc::new(SceneMesh::new(mesh, [material].into()))],
                Light::default(),
            );
            let found = sample(&scene, 50, 0);
            assert_eq!(found.points.len(), expected);
            assert!(found.points.iter().all(|at| at.point.x + at.point.y <= 1.0 && at.normal == DVec3::Z));
        }
        assert!(sample(&scene(vec![]), 50, 0).points.is_empty());
    }
}
