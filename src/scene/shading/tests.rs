use std::sync::Arc;

use glam::Vec3;

use super::*;
use crate::mesh::{AxisBox, Material as PlainMaterial, Mesh};
use crate::{
    Cone, Hit, Light, LightRays, Material, MeshMaterial, Object, Quad, SceneMesh, Shape, Sky, Sphere, Sun, Texture,
    Window, trace,
};

const SKY: Sky =
    Sky { horizon: DVec3::splat(0.5), zenith: DVec3::splat(0.5), ambient: DVec3::splat(0.25), ..Sky::NONE };

fn overhead() -> Light {
    Light { suns: vec![Sun { direction: DVec3::Y, radiance: DVec3::splat(2.0) }], lamps: vec![], sky: SKY }
}

fn white(shape: Shape) -> Object {
    Object::new(shape, Material::diffuse(Texture::Solid(DVec3::ONE)))
}

fn optical(shape: Shape, optics: Optics) -> Object {
    let mut object = white(shape);
    object.material.optics = optics;
    object
}

fn plain(plain: PlainMaterial) -> MeshMaterial {
    MeshMaterial { plain, ..MeshMaterial::default() }
}

fn painted(base_color: DVec3) -> MeshMaterial {
    plain(PlainMaterial { base_color, ..PlainMaterial::default() })
}

/// Returns a square of two triangles, four metres wide, that faces up at a height.
fn square(height: f64, material: MeshMaterial) -> SceneMesh {
    let corner = |x: f64, z: f64| DVec3::new(x, height, z);
    let mesh = Mesh {
        positions: vec![corner(-2.0, -2.0), corner(-2.0, 2.0), corner(2.0, 2.0), corner(2.0, -2.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material_of: vec![0, 0],
        ..Mesh::default()
    };
    SceneMesh::new(mesh, [material].into())
}

fn with_mesh(objects: Vec<Object>, mesh: SceneMesh, light: Light) -> SceneAtTime {
    SceneAtTime::with_meshes(objects, vec![Arc::new(mesh)], light)
}

fn floor(height: f64) -> Shape {
    Shape::Quad(Quad { corner: DVec3::new(-2.0, height, -2.0), u: DVec3::Z * 4.0, v: DVec3::X * 4.0 })
}

fn counted(scene: &SceneAtTime, origin: DVec3, direction: DVec3) -> (Hit, u64) {
    let before = SECONDARY_RAYS.get();
    let hit = trace(scene, origin, direction);
    (hit, SECONDARY_RAYS.get() - before)
}

fn near(a: DVec3, b: DVec3) -> bool {
    (a - b).abs().max_element() < 1e-9
}

#[test]
fn a_square_of_triangles_is_lit_as_a_quad_is() {
    let ball = white(Shape::Sphere(Sphere { center: DVec3::new(0.3, 1.2, 0.2), radius: 0.4 }));
    let mut light = overhead();
    light.lamps = vec![Lamp {
        position: DVec3::new(1.0, 2.0, 0.5),
        radiance: DVec3::new(1.0, 0.7, 0.3),
        reach: f64::INFINITY,
        window: Window::Smooth,
        cone: Some(Cone { axis: DVec3::NEG_Y, cos_inner: 0.9, cos_outer: 0.5 }),
    }];
    let material = painted(DVec3::ONE);
    let triangles = with_mesh(vec![ball], square(0.0, material), light.clone());
    let quad = SceneAtTime::new(vec![white(floor(0.0)), ball], light);
    let mut distinct = std::collections::BTreeSet::new();
    for step in 0..400 {
        let target = DVec3::new(-1.9 + 0.19 * f64::from(step % 20), 0.0, -1.9 + 0.19 * f64::from(step / 20));
        let origin = DVec3::new(0.1, 3.0, -0.2);
        let [a, b] = [&triangles, &quad].map(|scene| trace(scene, origin, target - origin));
        assert!(near(a.color, b.color) && near(a.normal, b.normal), "{target}: {a:?} {b:?}");
        assert!((a.distance - b.distance).abs() < 1e-12);
        distinct.insert((a.color.x * 1e6) as i64);
    }
    // Shadows, cone and fall-off are all visible.
    assert!(distinct.len() > 50, "{}", distinct.len());
}

#[test]
fn meshes_keep_light_from_shapes_and_shapes_from_meshes() {
    let roof = square(1.0, MeshMaterial::default());
    let below = with_mesh(
        vec![white(Shape::Quad(Quad { corner: DVec3::new(-9.0, 0.0, -9.0), u: DVec3::Z * 18.0, v: DVec3::X * 18.0 }))],
        roof,
        overhead(),
    );
    let at = |x: f64| trace(&below, DVec3::new(x, 0.5, 0.0), DVec3::NEG_Y).color.x;
    assert!((at(1.9) - 0.25).abs() < 1e-12 && (at(2.1) - 2.25).abs() < 1e-12);
    let ball = white(Shape::Sphere(Sphere { center: DVec3::Y * 2.0, radius: 0.5 }));
    let above = with_mesh(vec![ball], square(0.0, MeshMaterial::default()), overhead());
    let at = |x: f64| trace(&above, DVec3::new(x, 0.5, 0.0), DVec3::NEG_Y).color.x;
    assert!((at(0.4) - 0.2).abs() < 1e-12 && (at(0.6) - 0.8 * 2.25).abs() < 1e-12);
}

#[test]
fn a_highlight_is_where_the_mirror_direction_meets_the_light() {
    let phong = Phong { weight: DVec3::splat(0.3), exponent: 20.0 };
    let material = MeshMaterial { phong, ..painted(DVec3::ZERO) };
    let scene = with_mesh(vec![], square(0.0, material), overhead());
    let straight = trace(&scene, DVec3::Y, DVec3::NEG_Y).color;
    assert!(near(straight, DVec3::splat(0.3 * (11.0 * 2.0 + 0.25))), "{straight}");
    // 45° off, almost only the ambient light from the mirror direction remains.
    let aslant = trace(&scene, DVec3::new(1.0, 1.0, 0.0), DVec3::new(-1.0, -1.0, 0.0)).color.x;
    let expected = 0.3 * (22.0 * 0.5_f64.sqrt().powi(20) + 0.25 * (0.7 + 0.3 * 0.5_f64.sqrt()));
    assert!((aslant - expected).abs() < 1e-9, "{aslant} {expected}");
}

#[test]
fn interpolated_normals_never_light_the_back() {
    let flat = square(0.0, painted(DVec3::ONE));
    let normals = vec![Vec3::new(0.8, 0.6, 0.0); 4];
    let mesh = SceneMesh::new(Mesh { normals, ..flat.mesh.clone() }, flat.materials.clone());
    // The sun is below the horizon of the square, but above that of its shading normals.
    let low = Sun { direction: DVec3::new(0.995, -0.0998, 0.0).normalize(), radiance: DVec3::ONE };
    let scene = with_mesh(vec![], mesh.clone(), Light { suns: vec![low], lamps: vec![], sky: Sky::NONE });
    let seen = trace(&scene, DVec3::Y, DVec3::NEG_Y);
    assert_eq!(seen.color, DVec3::ZERO);
    assert!(near(seen.normal, DVec3::new(0.8, 0.6, 0.0).normalize()) || (seen.normal.x - 0.8).abs() < 1e-6);
    // Seen from below, the normals are flipped.
    let scene = with_mesh(
        vec![],
        mesh,
        Light { suns: vec![Sun { direction: DVec3::NEG_Y, ..low }], lamps: vec![], sky: Sky::NONE },
    );
    let seen = trace(&scene, DVec3::NEG_Y, DVec3::Y);
    assert!((seen.color.x - 0.6).abs() < 1e-6 && seen.normal.y < 0.0);
}

#[test]
fn unlit_and_shining_surfaces_do_not_ask_for_light() {
    let unlit = plain(PlainMaterial { base_color: DVec3::new(0.1, 0.2, 0.3), unlit: true, ..PlainMaterial::default() });
    let scene = with_mesh(vec![], square(0.0, unlit), overhead());
    assert_eq!(trace(&scene, DVec3::Y, DVec3::NEG_Y).color, DVec3::new(0.1, 0.2, 0.3));
    let emission = DVec3::new(5.0, 4.0, 3.0);
    let shining = plain(PlainMaterial { base_color: DVec3::ZERO, emission, ..PlainMaterial::default() });
    let scene = with_mesh(vec![], square(0.0, shining), overhead());
    assert_eq!(trace(&scene, DVec3::Y, DVec3::NEG_Y).color, DVec3::new(5.0, 4.0, 3.0));
}

#[test]
fn rays_go_on_only_where_optics_call_for_it() {
    let mirror = Optics::Mirror { tint: DVec3::new(0.9, 0.8, 0.7) };
    let opaque = SceneAtTime::new(vec![white(floor(0.0))], overhead());
    assert_eq!(counted(&opaque, DVec3::Y, DVec3::NEG_Y).1, 0);
    let phong = Phong { weight: DVec3::splat(0.3), exponent: 20.0 };
    let glossy = with_mesh(vec![], square(0.0, MeshMaterial { phong, ..MeshMaterial::default() }), overhead());
    assert_eq!(counted(&glossy, DVec3::Y, DVec3::NEG_Y).1, 0);
    let one = SceneAtTime::new(vec![optical(floor(0.0), mirror)], overhead());
    let (hit, rays) = counted(&one, DVec3::Y, DVec3::new(0.1, -1.0, 0.0));
    assert_eq!((rays, hit.optics), (1, [1.0, 0.0, 1.0]));
    assert!(near(hit.color, 0.5 * DVec3::new(0.9, 0.8, 0.7)));
    // Between two mirrors, eight bounces and then the ambient light.
    let two = SceneAtTime::new(vec![optical(floor(0.0), mirror), optical(floor(1.0), mirror)], overhead());
    let (hit, rays) = counted(&two, DVec3::Y * 0.5, DVec3::NEG_Y);
    assert_eq!(rays, u64::from(MAX_BOUNCES));
    assert!(near(hit.color, 0.25 * DVec3::new(0.9, 0.8, 0.7).powf(9.0)), "{}", hit.color);
}

#[test]
fn a_mirror_shows_what_is_before_it() {
    let red = DVec3::new(0.8, 0.1, 0.1);
    let wall = Object::new(floor(2.0), Material::diffuse(Texture::Solid(red)));
    let mirror = MeshMaterial { optics: Optics::Mirror { tint: DVec3::ONE }, ..MeshMaterial::default() };
    let scene = with_mesh(vec![wall], square(0.0, mirror), overhead());
    let seen = trace(&scene, DVec3::Y, DVec3::new(0.3, -1.0, 0.1));
    let straight = trace(&scene, DVec3::Y, DVec3::Y);
    assert!(
        (seen.distance - 1.1_f64.sqrt()).abs() < 1e-12 && near(seen.color, straight.color),
        "{seen:?} {straight:?}"
    );
    assert_eq!((seen.normal, seen.object, straight.object), (DVec3::Y, None, Some(0)));
}

#[test]
fn fresnel_at_right_angles_at_the_limit_and_beyond_it() {
    let glass = Optics::Glass { ior: 1.5, tint: DVec3::ONE };
    let ball =
        SceneAtTime::new(vec![optical(Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 1.0 }), glass)], overhead());
    let hit = trace(&ball, DVec3::Z * 3.0, DVec3::NEG_Z);
    assert!((hit.optics[0] - 0.04).abs() < 1e-12 && (hit.optics[1] - 0.96).abs() < 1e-12 && hit.optics[2] == 1.5);
    // The surroundings emit uniformly and nothing is absorbed.
    assert!((hit.color.x - 0.5).abs() < 1e-3, "{}", hit.color);
    // From inside: at normal incidence the same reflectance as from outside, at a steep angle total reflection.
    let hit = trace(&ball, DVec3::ZERO, DVec3::NEG_Z);
    assert!((hit.optics[0] - 0.04).abs() < 1e-12);
    let hit = trace(&ball, DVec3::X * 0.9, DVec3::Y);
    assert_eq!(hit.optics, [1.0, 0.0, 1.5]);
    assert!(hit.color.is_finite());
    // At grazing incidence, nearly total reflection.
    let hit = trace(&ball, DVec3::new(0.999_999, 0.0, 3.0), DVec3::NEG_Z);
    assert!(hit.optics[0] > 0.9 && hit.optics[0] <= 1.0);
}

#[test]
fn a_pane_moves_what_is_behind_it_aside_by_snells_law() {
    let glass = Optics::Glass { ior: 1.5, tint: DVec3::ONE };
    let pane = AxisBox { min: DVec3::new(-50.0, 1.0, -50.0), max: DVec3::new(50.0, 2.0, 50.0) };
    let pane = optical(Shape::AxisBox(pane), glass);
    let light = Light { suns: vec![], lamps: vec![], sky: Sky::NONE };
    // The spot seen through the pane is red where the refracted ray hits it.
    let (sin, cos) = 40.0_f64.to_radians().sin_cos();
    let inside = (sin / 1.5).asin();
    let lands = (sin / cos) * 2.0 + inside.tan();
    let spot = |from: f64| {
        let quad = Quad { corner: DVec3::new(from, 0.0, -1.0), u: DVec3::Z * 2.0, v: DVec3::X * 0.01 };
        let mut spot = white(Shape::Quad(quad));
        spot.material.emission = DVec3::X;
        let scene = SceneAtTime::new(vec![pane, spot], light.clone());
        trace(&scene, DVec3::Y * 3.0, DVec3::new(sin, -cos, 0.0)).color.x
    };
    assert!(spot(lands - 0.005) > 0.8 && spot(lands + 0.001) < 0.2 && spot(lands - 0.011) < 0.2);
}

#[test]
fn a_glass_ball_bends_rays_twice_towards_its_axis() {
    let glass = Optics::Glass { ior: 1.5, tint: DVec3::ONE };
    let ball = optical(Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 1.0 }), glass);
    for height in [0.0_f64, 0.3, -0.6, 0.85] {
        let (outside, inside) = (height.asin(), (height / 1.5).asin());
        let leaves = 2.0 * inside - outside;
        let lands = leaves.sin() - (2.0 * (outside - inside)).tan() * (3.0 - leaves.cos());
        let spot = |from: f64| {
            let quad = Quad { corner: DVec3::new(3.0, from, -1.0), u: DVec3::Z * 2.0, v: DVec3::Y * 0.01 };
            let mut spot = white(Shape::Quad(quad));
            spot.material.emission = DVec3::X;
            let light = Light { suns: vec![], lamps: vec![], sky: Sky::NONE };
            trace(&SceneAtTime::new(vec![ball, spot], light), DVec3::new(-5.0, height, 0.0), DVec3::X).color.x
        };
        assert!(spot(lands - 0.005) > 0.6, "{height}: {}", spot(lands - 0.005));
        assert!(spot(lands + 0.001) < 0.1 && spot(lands - 0.011) < 0.1, "{height}");
    }
}

#[test]
fn glass_lets_light_through_and_mirrors_do_not() {
    let below = |optics: Optics| {
        let scene = SceneAtTime::new(vec![white(floor(0.0)), optical(floor(1.0), optics)], overhead());
        let meshes = with_mesh(
            vec![white(floor(0.0))],
            square(1.0, MeshMaterial { optics, ..MeshMaterial::default() }),
            overhead(),
        );
        [scene, meshes].map(|scene| trace(&scene, DVec3::Y * 0.5, DVec3::new(0.1, -1.0, 0.0)).color.x)
    };
    assert_eq!(below(Optics::Glass { ior: 1.5, tint: DVec3::ONE }), [2.25; 2]);
    assert_eq!(below(Optics::Mirror { tint: DVec3::ONE }), [0.25; 2]);
}

#[test]
fn indices_that_make_no_sense_give_no_nan() {
    for ior in [0.0, 1.0, 0.5, -3.0, f64::NAN, f64::INFINITY] {
        let glass = Optics::Glass { ior, tint: DVec3::ONE };
        let ball = Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 1.0 });
        let scene = SceneAtTime::new(vec![optical(ball, glass)], overhead());
        for x in [0.0, 0.5, 0.999_999_999] {
            assert!(trace(&scene, DVec3::new(x, 0.0, 3.0), DVec3::NEG_Z).color.is_finite(), "{ior} {x}");
        }
    }
    let bent = Surface {
        point: DVec3::ZERO,
        side: DVec3::Y,
        normal: DVec3::new(0.999, 0.04, 0.0).normalize(),
        from_within: false,
        albedo: DVec3::ZERO,
        emission: DVec3::ZERO,
        phong: Phong::default(),
        optics: Optics::Mirror { tint: DVec3::ONE },
        unlit: false,
    };
    // The shading normal is not used if the reflection would enter the surface.
    assert_eq!(bent.optical_normal(DVec3::new(-0.1, -1.0, 0.0).normalize()), DVec3::Y);
}

#[test]
fn surfaces_nearby_occlude_ambient_light_and_shadows_can_be_left_out() {
    let ball = white(Shape::Sphere(Sphere { center: DVec3::new(0.0, 0.21, 0.0), radius: 0.2 }));
    let ground = white(Shape::Quad(Quad { corner: DVec3::new(-2.0, 0.0, -2.0), u: DVec3::Z * 4.0, v: DVec3::X * 4.0 }));
    let scene = SceneAtTime::new(vec![ground, ball], overhead());
    let at = |scene: &SceneAtTime, x: f64| trace(scene, DVec3::new(x, 1.0, 0.5), DVec3::new(0.0, -2.0, -1.0)).color.x;
    let rays = |shadows, occlusion| scene.clone().with_light_rays(LightRays { shadows, occlusion });
    let [plain, occluded] = [at(&scene, 0.25), at(&rays(true, 64), 0.25)];
    assert!(occluded < 0.98 * plain, "{occluded} {plain}");
    // Nothing is occluded a tenth of the scene's diagonal away from the ball.
    assert_eq!(at(&rays(true, 64), 1.5), at(&scene, 1.5));
    // Under the ball, in the shadow of the sun.
    let below = |scene: &SceneAtTime| trace(scene, DVec3::new(0.19, 0.05, 0.0), DVec3::NEG_Y).color.x;
    assert!(below(&rays(false, 0)) > 2.0 * below(&scene), "{} {}", below(&rays(false, 0)), below(&scene));
    assert_eq!(rays(true, 0).light_rays, LightRays::default());
}
