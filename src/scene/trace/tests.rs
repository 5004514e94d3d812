mod extremes;

use super::*;
use crate::mesh::AxisBox;
use crate::{CastsShadow, Lamp, Light, Material, Object, Quad, Shape, Sky, Sphere, Sun, Texture, Window};

const SKY: Sky = Sky { horizon: DVec3::splat(0.5), zenith: DVec3::ONE, ambient: DVec3::splat(0.1), ..Sky::NONE };

fn white(shape: Shape) -> Object {
    Object::new(shape, Material::diffuse(Texture::Solid(DVec3::ONE)))
}

/// A floor at y = 0, a ball of radius 1 above its middle, the sun overhead, a lamp low at x = 4.
fn scene() -> SceneAtTime {
    let floor = Quad { corner: DVec3::new(-9.0, 0.0, -9.0), u: DVec3::Z * 18.0, v: DVec3::X * 18.0 };
    let objects = vec![white(Shape::Quad(floor)), white(Shape::Sphere(Sphere { center: DVec3::Y * 3.0, radius: 1.0 }))];
    let light = Light {
        suns: vec![Sun { direction: DVec3::Y, radiance: DVec3::splat(2.0) }],
        lamps: vec![Lamp {
            position: DVec3::new(4.0, 1.0, 0.0),
            radiance: DVec3::ONE,
            reach: 2.0,
            window: Window::Smooth,
            cone: None,
        }],
        sky: SKY,
    };
    SceneAtTime::new(objects, light)
}

fn floor_at(x: f64, z: f64) -> DVec3 {
    let from = DVec3::new(x + 3.0, 1.5, z);
    let hit = trace(&scene(), from, DVec3::new(x, 0.0, z) - from);
    assert_eq!(hit.object, Some(0));
    hit.color
}

#[test]
fn sun_shadow_and_ambient() {
    assert!((floor_at(-2.0, 0.0) - 2.1).abs().max_element() < 1e-12);
    assert!((floor_at(-0.9, 0.0) - 0.1).abs().max_element() < 1e-12);
    // The shadow's edge is the ball's outline, from both sides.
    assert!(floor_at(-1.001, 0.0).x > 2.0 && floor_at(-0.999, 0.0).x < 0.2);
    // The floor's far corners are outside the grid cells of all casters.
    assert!(floor_at(-8.9, 8.9).x > 2.0);
}

#[test]
fn lamp_reaches_just_so_far() {
    // Directly below: 1 m, window (1 − 1/4)².
    assert!((floor_at(4.0, 0.0).x - (2.1 + 0.5625)).abs() < 1e-5);
    assert_eq!(floor_at(4.0, 1.8), floor_at(-4.0, 1.8));
}

#[test]
fn sphere_is_lit_above_and_dark_below() {
    let above = trace(&scene(), DVec3::Y * 8.0, DVec3::NEG_Y);
    assert_eq!((above.distance, above.object, above.normal), (4.0, Some(1), DVec3::Y));
    assert!((above.color.x - 2.1).abs() < 1e-12);
    let below = trace(&scene(), DVec3::Y * 0.5, DVec3::Y);
    assert!((below.color.x - 0.04).abs() < 1e-12);
}

#[test]
fn nothing_is_infinite_and_sky_coloured() {
    let up = trace(&scene(), DVec3::new(5.0, 5.0, 5.0), DVec3::Y);
    assert_eq!((up.distance, up.color, up.object), (f64::INFINITY, DVec3::ONE, None));
    let side = trace(&scene(), DVec3::new(5.0, 5.0, 5.0), DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(side.color, SKY.horizon);
    for (origin, direction) in [(DVec3::NAN, DVec3::X), (DVec3::ZERO, DVec3::ZERO), (DVec3::ZERO, DVec3::NAN)] {
        assert_eq!(trace(&scene(), origin, direction).distance, f64::INFINITY);
    }
}

#[test]
fn points_see_each_other_unless_something_lies_between() {
    let scene = scene();
    let (top, bottom) = (DVec3::Y * 4.0, DVec3::Y * 2.0);
    assert!(scene.sees(DVec3::Y * 8.0, top) && scene.sees(top, DVec3::Y * 8.0));
    assert!(!scene.sees(top + 0.1 * DVec3::Y, bottom) && !scene.sees(DVec3::Y * 8.0, bottom));
    assert!(!scene.sees(DVec3::Y * 8.0, DVec3::ZERO) && scene.sees(DVec3::ZERO, bottom));
    // Through the floor, along it, and past its edge.
    assert!(!scene.sees(DVec3::new(3.0, 1.0, 0.0), DVec3::new(3.0, -1.0, 0.0)));
    assert!(scene.sees(DVec3::new(3.0, 0.0, 0.0), DVec3::new(-5.0, 0.0, 1.0)));
    assert!(scene.sees(DVec3::new(9.1, 1.0, 0.0), DVec3::new(9.1, -1.0, 0.0)));
    assert!(scene.sees(top, top) && !scene.sees(DVec3::NAN, top) && !scene.sees(top, DVec3::INFINITY));
    assert_eq!(scene.bounds, Some(AxisBox { min: DVec3::new(-9.0, 0.0, -9.0), max: DVec3::new(9.0, 4.0, 9.0) }));
    assert_eq!(SceneAtTime::new(vec![], scene.light.clone()).bounds, None);
}

#[test]
fn an_empty_scene_is_sky() {
    let empty = SceneAtTime::new(vec![], scene().light.clone());
    assert_eq!(trace(&empty, DVec3::ZERO, DVec3::Z).color, SKY.horizon);
    // A scene without shadow casters is lit everywhere.
    let mut floor = scene().objects[0];
    floor.casts_shadow = CastsShadow::No;
    let bare = SceneAtTime::new(vec![floor], scene().light.clone());
    assert!((trace(&bare, DVec3::Y, DVec3::new(0.1, -1.0, 0.0)).color.x - 2.1).abs() < 1e-12);
}
