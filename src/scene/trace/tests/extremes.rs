//! Scenes of all sizes, cameras at difficult positions, grazing rays, and very distant surfaces.

use std::sync::Arc;

use glam::{DVec2, Vec2};

use super::*;
use crate::mesh::{AxisBox, Material as PlainMaterial, Mesh};
use crate::{
    Lamp, Light, Material, MeshMaterial, Object, Optics, Phong, Quad, SceneMesh, Shape, Sphere, Texture, TurnedBox,
    Window,
};

/// Returns a floor and a tent of triangles, a ball of each kind, a turned box, a sun and a lamp, scaled by `scale` and then
/// shifted.
fn scene(scale: f64, shift: DVec3) -> SceneAtTime {
    let put = |point: DVec3| scale * point + shift;
    let object = |shape: Shape, optics: Optics| {
        let mut object = Object::new(shape, Material::diffuse(Texture::Solid(DVec3::new(0.7, 0.5, 0.3))));
        object.material.optics = optics;
        object.material.phong = Phong { weight: DVec3::splat(0.2), exponent: 10.0 };
        object
    };
    let ball = |x: f64| Shape::Sphere(Sphere { center: put(DVec3::new(x, 0.5, -0.7)), radius: 0.4 * scale });
    let cube = TurnedBox {
        center: put(DVec3::new(0.2, 0.3, 0.8)),
        half: scale * DVec3::new(0.3, 0.3, 0.2),
        turn: DVec2::from_angle(0.4),
    };
    let objects = vec![
        object(ball(-1.0), Optics::Opaque),
        object(ball(0.0), Optics::Glass { ior: 1.5, tint: DVec3::splat(0.9) }),
        object(ball(1.0), Optics::Mirror { tint: DVec3::splat(0.9) }),
        object(Shape::TurnedBox(cube), Optics::Opaque),
    ];
    let corners = [
        [-3.0, 0.0, -3.0],
        [-3.0, 0.0, 3.0],
        [3.0, 0.0, 3.0],
        [3.0, 0.0, -3.0],
        [-1.6, 0.1, 0.2],
        [-0.7, 0.1, 0.3],
        [-1.1, 1.1, 1.0],
    ];
    let mesh = Mesh {
        positions: corners.map(|corner| put(corner.into())).to_vec(),
        uvs: vec![Vec2::ZERO; corners.len()],
        triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]],
        material_of: vec![0; 3],
        ..Mesh::default()
    };
    let lamp = Lamp {
        position: put(DVec3::new(0.4, 1.5, 0.2)),
        radiance: DVec3::splat(0.8 * scale * scale),
        reach: 5.0 * scale,
        window: Window::Punctual,
        cone: None,
    };
    let light = Light { lamps: vec![lamp], ..Light::default() };
    SceneAtTime::with_meshes(objects, vec![Arc::new(SceneMesh::new(mesh, [MeshMaterial::default()].into()))], light)
}

#[test]
fn the_picture_does_not_depend_on_the_size_or_the_place() {
    let plain = scene(1.0, DVec3::ZERO);
    for (scale, shift) in [
        (1e-6, DVec3::ZERO),
        (1e6, DVec3::ZERO),
        (1.0, DVec3::new(1e5, -2e5, 3e5)),
        (1e-6, DVec3::new(0.1, 0.0, 0.2)),
        (1e6, DVec3::splat(-1e9)),
    ] {
        let other = scene(scale, shift);
        let (mut hits, mut different) = (0, 0);
        let eye = DVec3::new(0.3, 1.4, 3.0);
        for row in 0..60 {
            for col in 0..80 {
                let direction = DVec3::new(-1.2 + 0.03 * f64::from(col), 0.3 - 0.02 * f64::from(row), -1.0);
                let a = trace(&plain, eye, direction);
                let b = trace(&other, scale * eye + shift, direction);
                hits += u32::from(a.distance.is_finite());
                let depth = (b.distance / scale / a.distance - 1.0).abs() < 1e-6 || a.distance == b.distance;
                let color = (a.color - b.color).abs().max_element() < 1e-4;
                different += u32::from(!(depth && color));
            }
        }
        // At an outline or the edge of a shadow the result may change sides.
        assert!(hits > 2000 && different <= 5, "{scale} {shift}: {different} of {hits}");
    }
}

#[test]
fn cameras_in_bad_places_see_something_finite() {
    let scene = scene(1.0, DVec3::ZERO);
    let places = [
        // On the floor, at its corner, on an edge of its triangles, and in its plane.
        DVec3::ZERO,
        DVec3::new(-3.0, 0.0, -3.0),
        DVec3::new(1.0, 0.0, 1.0),
        DVec3::new(9.0, 0.0, 0.0),
        // At the centres of the balls, on a ball, in the box.
        DVec3::new(-1.0, 0.5, -0.7),
        DVec3::new(0.0, 0.5, -0.7),
        DVec3::new(1.0, 0.5, -0.7),
        DVec3::new(0.0, 0.9, -0.7),
        DVec3::new(0.2, 0.3, 0.8),
        // At the lamp.
        DVec3::new(0.4, 1.5, 0.2),
    ];
    for place in places {
        for step in 0..500 {
            let (a, b) = (0.1 * f64::from(step), 0.037 * f64::from(step));
            for direction in [DVec3::new(a.cos(), b.sin(), a.sin()), DVec3::new(a.cos(), 0.0, a.sin()), DVec3::X] {
                let hit = trace(&scene, place, direction);
                assert!(hit.color.is_finite() && hit.color.min_element() >= 0.0, "{place} {direction}");
                assert!(hit.distance > 0.0 && hit.normal.is_finite());
            }
        }
    }
    // From the centre of the opaque ball every hit is at its radius.
    let inside = trace(&scene, DVec3::new(-1.0, 0.5, -0.7), DVec3::new(0.1, -0.8, 0.3));
    assert!((inside.distance - 0.4).abs() < 1e-12);
}

#[test]
fn hits_at_the_end_of_the_world_are_finite_or_infinite() {
    for far in [1e9, 1e15, 1e30, 1e60, 1e120, 1e300] {
        let quad = Quad { corner: DVec3::new(-far, -far, -far), u: DVec3::X * 2.0 * far, v: DVec3::Y * 2.0 * far };
        let mut mesh = Mesh {
            positions: vec![DVec3::new(-far, -far, far), DVec3::new(far, -far, far), DVec3::new(0.0, far, far)],
            triangles: vec![[0, 1, 2]],
            material_of: vec![0],
            ..Mesh::default()
        };
        let shapes = [
            Shape::Quad(quad),
            Shape::Sphere(Sphere { center: DVec3::X * far, radius: 0.5 * far }),
            Shape::AxisBox(AxisBox { min: DVec3::splat(-1.5 * far), max: DVec3::new(-1.2 * far, far, far) }),
        ];
        let white = Material::diffuse(Texture::Solid(DVec3::ONE));
        let objects = shapes.map(|shape| Object::new(shape, white)).to_vec();
        mesh.positions.push(DVec3::NAN);
        mesh.triangles.push([0, 1, 3]);
        mesh.material_of.push(0);
        let scene = SceneAtTime::with_meshes(
            objects,
            vec![Arc::new(SceneMesh::new(mesh, [MeshMaterial::default()].into()))],
            Light::default(),
        );
        let mut met = 0;
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for direction in [axis, -axis, axis + DVec3::splat(0.01)] {
                let hit = trace(&scene, DVec3::ZERO, direction);
                assert!(!hit.distance.is_nan() && !hit.color.is_nan() && !hit.normal.is_nan(), "{far} {direction}");
                met += u32::from(hit.distance.is_finite());
            }
        }
        assert!(met >= 3 || far > 1e100, "{far}: {met}");
    }
}

#[test]
fn rays_in_the_plane_of_a_wall_and_along_its_edge_see_past_it() {
    let scene = scene(1.0, DVec3::ZERO);
    // In the plane of the floor the floor is not hit; the box that stands on it is.
    let along = trace(&scene, DVec3::new(-5.0, 0.0, -2.5), DVec3::X);
    assert_eq!(along.distance, f64::INFINITY);
    let diagonal = trace(&scene, DVec3::new(-4.0, 0.0, -4.0), DVec3::new(1.0, 0.0, 1.0));
    assert!(diagonal.object.is_some() || diagonal.distance == f64::INFINITY);
    // Straight down on the edge that two triangles share, on corners, and on the rim.
    for at in [DVec3::new(1.7, 0.0, 1.7), DVec3::new(-3.0, 0.0, -3.0), DVec3::new(3.0, 0.0, 0.4)] {
        assert_eq!(trace(&scene, at + DVec3::Y, DVec3::NEG_Y).distance, 1.0, "{at}");
    }
}

#[test]
fn of_coplanar_things_shapes_come_first_and_then_the_lower_index() {
    let square = |color: f64| {
        let positions = vec![DVec3::ZERO, DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::X];
        let plain = PlainMaterial { base_color: DVec3::splat(color), unlit: true, ..PlainMaterial::default() };
        let material = MeshMaterial { plain, ..MeshMaterial::default() };
        let mesh =
            Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], material_of: vec![0; 2], ..Mesh::default() };
        Arc::new(SceneMesh::new(mesh, [material].into()))
    };
    let look = |scene: &SceneAtTime| trace(scene, DVec3::new(0.25, 1.0, 0.5), DVec3::NEG_Y);
    let two = SceneAtTime::with_meshes(vec![], vec![square(0.25), square(0.5)], Light::default());
    assert_eq!(look(&two).color, DVec3::splat(0.25));
    let quad = Shape::Quad(Quad { corner: DVec3::ZERO, u: DVec3::Z, v: DVec3::X });
    let objects = vec![Object::new(quad, Material::diffuse(Texture::Solid(DVec3::ONE)))];
    let three = SceneAtTime::with_meshes(objects, vec![square(0.25)], Light::default());
    assert_eq!(look(&three).object, Some(0));
    assert_eq!(look(&SceneAtTime::with_meshes(vec![], vec![square(0.5)], Light::default())).optics, OPAQUE);
}

#[test]
fn sight_of_points_on_triangles_from_anywhere() {
    for (scale, shift) in [(1.0, DVec3::ZERO), (1e-6, DVec3::ZERO), (1e6, DVec3::ZERO), (1.0, DVec3::splat(1e6))] {
        let scene = scene(scale, shift);
        let put = |x: f64, y: f64, z: f64| scale * DVec3::new(x, y, z) + shift;
        assert!(scene.sees(put(2.0, 1.0, 2.0), put(2.5, 0.0, 1.0)), "{scale}");
        assert!(!scene.sees(put(2.0, 1.0, 2.0), put(2.5, -0.1, 1.0)));
        // A ball hides what is behind it, even a glass ball, and its own far side.
        assert!(!scene.sees(put(0.0, 0.5, 1.0e-3), put(0.0, 0.5, -2.0)));
        assert!(!scene.sees(put(0.0, 0.5, 1.0e-3), put(0.0, 0.5, -1.1)));
        assert!(scene.sees(put(0.0, 0.5, 1.0e-3), put(0.0, 0.5, -0.3)));
        // Both points are on the floor, at a low angle, and visible to each other.
        assert!(scene.sees(put(2.0, 0.0, 2.0), put(2.5, 0.0, -2.0)));
    }
}
