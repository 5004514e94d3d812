//! Mirrors and glass in rendered pictures, against captures of the scene (CALF 6.1).

use codec::container::ProbeEntry;
use codec::depth::DepthRange;
use codec::image::transfer::{EncodeTable, ToneMap, Transfer};
use codec::image::{DepthKind, Face, ImageProjection, TexelMap};
use codec::math::{Camera, Lens};
use codec::metrics::psnr::SquaredError;
use codec::monitor::Silent;
use codec::streams::convert::{color_codes, material_codes};
use glam::{DVec3, Vec3};
use render::march::active_views::ActiveViews;
use render::march::counters::Counters;
use render::march::intersect::intersect;
use render::march::ray::{Ray, Steps};
use render::march::render::{Rendered, render, render_plainly};
use render::march::settings::{Acceleration, Refinements, RenderSettings, SpecularMode};
use render::march::specular::normal::patch;
use render::march::specular::proxy::Proxies;
use render::march::specular::sphere_fit::SphereFit;
use render::march::synthetic::SyntheticProbe;
use render::rendered_image::{BackgroundFill, HoleFill};
use render::views::inverse_depth::InverseDepth;
use render::views::light_field::{ColorCoding, ColorTexels, FaceTexels, LightField, View};
use scene::capture::{Images, Pass, PassSettings, SamplePattern, Viewpoint, capture_view};
use scene::procedural::{DemoKind, DemoScene};
use scene::raycast::SceneAtTime;

/// Centre and radius in metres of the glass ball in the built-in scene.
const GLASS: (DVec3, f64) = (DVec3::new(0.1, 0.5, -0.5), 0.45);
/// Viewpoint between the balls and the wall behind the viewer.
const MIDDLE: DVec3 = DVec3::new(0.0, 0.6, 1.1);

fn scene() -> SceneAtTime {
    DemoScene::new(DemoKind::Mirrors).at(0.8)
}

fn capture(scene: &SceneAtTime, position: DVec3, face: Face, size: u32) -> Images {
    let samples = SamplePattern::new(4).unwrap();
    let passes = [Pass::Color, Pass::Depth, Pass::Material];
    let settings =
        PassSettings { passes: &passes, samples: &samples, depth: DepthKind::Distance, far_m: f64::INFINITY };
    let from = Viewpoint { position, orientation: None, projection: ImageProjection::cube_face(face, size) };
    capture_view(scene, &from, &settings, &Silent).unwrap()
}

/// Captures a light field with a probe at each position; colour is in 8-bit codes.
fn field(scene: &SceneAtTime, positions: &[DVec3], size: u32) -> LightField {
    let tone = ToneMap::default();
    let (coding, table) = (ColorCoding::Codes(tone), EncodeTable::new(&tone));
    let range = DepthRange::new(0.1, 10.0).unwrap();
    let inverse = InverseDepth::new(range, DepthKind::Distance);
    let view = |(probe, position): (usize, &DVec3)| {
        let entry = ProbeEntry {
            name: format!("{probe}"),
            position: position.to_array(),
            orientation: [0.0, 0.0, 0.0, 1.0],
            frames: [0, 0],
            intrinsics: [0.0; 4],
        };
        let mut view = View::new(probe, &entry, range).unwrap();
        for face in Face::CUBE {
            let images = capture(scene, *position, face, size);
            let mut texels =
                FaceTexels::unknown([size; 2], TexelMap::of_face(face, [size; 2], entry.intrinsics), coding);
            let depths = (0..).zip(images.depth.unwrap().into_data());
            texels.inverse_depth =
                depths.map(|(at, z)| inverse.of(range.code(z), &texels, at % size, at / size)).collect();
            let fourth = |[a, b, c]: [u8; 3]| [a, b, c, 0];
            let codes = color_codes(&images.color.unwrap(), &table).0;
            texels.color = ColorTexels::Codes(codes.into_data().into_iter().map(fourth).collect());
            let materials = material_codes(&images.material.unwrap()).unwrap();
            texels.material = Some(materials.into_data().into_iter().map(fourth).collect());
            texels.update_specular();
            view.faces[face as usize] = Some(texels);
        }
        view
    };
    LightField { views: positions.iter().enumerate().map(view).collect(), coding }
}

/// Returns the corners of a box of 0.6 x 0.3 x 0.4 m around [`MIDDLE`].
fn corners() -> Vec<DVec3> {
    let corner = |at: u32| {
        let signs = [0, 1, 2].map(|axis| f64::from(at >> axis & 1) * 2.0 - 1.0);
        MIDDLE + DVec3::new(0.3, 0.15, 0.2) * DVec3::from_array(signs)
    };
    (0..8).map(corner).collect()
}

fn settings(size: u32, views: &ActiveViews<'_>, specular: SpecularMode) -> RenderSettings {
    RenderSettings {
        size: [size; 2],
        steps: Steps::new(256, views.near_m() / 10.0, views.far_m(), 8),
        samples: 1,
        holes: HoleFill::Blank,
        background: BackgroundFill::Opaque,
        specular,
        max_bounces: 4,
        acceleration: Acceleration::Pyramid,
        refinements: Refinements::ALL,
    }
}

/// Renders the view along -Z, where the balls are.
fn look(field: &LightField, eye: DVec3, size: u32, specular: SpecularMode) -> Rendered {
    let indices: Vec<usize> = (0..field.views.len()).collect();
    let views = ActiveViews::new(field, &indices, eye);
    let camera = Camera::look_at(eye, eye + DVec3::NEG_Z, DVec3::Y, Lens::new(90.0)).unwrap();
    render(&views, &camera, &settings(size, &views, specular), &Silent).unwrap()
}

/// Sets the material of all texels of a light field; `None` removes it.
fn with_material(mut field: LightField, material: Option<[u8; 4]>) -> LightField {
    for face in field.views.iter_mut().flat_map(|view| view.faces.iter_mut().flatten()) {
        face.material = material.map(|material| vec![material; face.inverse_depth.len()]);
        face.update_specular();
    }
    field
}

/// Returns the PSNR in dB of a picture, over the pixels whose material is `wanted`.
fn psnr(rendered: &Rendered, truth: &Images, wanted: impl Fn([f32; 3]) -> bool) -> f64 {
    let size = rendered.image.color.width();
    let table = EncodeTable::new(&ToneMap::default());
    let expected = color_codes(truth.color.as_ref().unwrap(), &table).0;
    let found = rendered.image.codes(ToneMap::default());
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for (at, &material) in (0..).zip(truth.material.as_ref().unwrap().data()) {
        if wanted(material) {
            let (x, y) = (at % size, at / size);
            a.extend(expected.get(x, y));
            // Faces of cube maps are mirror images of camera pictures.
            b.extend(found.get(size - 1 - x, y));
        }
    }
    SquaredError::of_u8(&a, &b).unwrap().psnr_db()
}

#[test]
fn mirrors_show_what_stands_around_them() {
    let (scene, size) = (scene(), 96);
    let field = field(&scene, &corners(), size);
    let truth = capture(&scene, MIDDLE, Face::Nz, size);
    let [plain, sent] = [SpecularMode::None, SpecularMode::Auto].map(|specular| look(&field, MIDDLE, size, specular));
    assert_eq!(plain.counters.secondary_rays, 0);
    assert!(sent.counters.secondary_rays > 500);
    assert_eq!(plain.image.alpha, sent.image.alpha);
    let gain = |wanted: fn([f32; 3]) -> bool| psnr(&sent, &truth, wanted) - psnr(&plain, &truth, wanted);
    let mirror = gain(|[reflect, refract, _]| reflect > 0.0 && refract == 0.0);
    let glass = gain(|[_, refract, _]| refract > 0.0);
    let both = gain(|[reflect, refract, _]| reflect + refract > 0.0);
    let neither = gain(|[reflect, refract, _]| reflect + refract == 0.0);
    assert!(mirror >= 8.0 && both >= 6.0, "mirror {mirror} dB, both {both} dB");
    assert!(glass >= 0.2, "glass {glass} dB");
    assert!(neither >= -0.1, "elsewhere {neither} dB");
}

/// Texels are a few centimetres wide. A first step at 0.6 m is far beyond the region that the balls hide, so secondary rays must
/// also be sampled before it.
#[test]
fn mirrors_do_not_depend_on_where_steps_begin() {
    let (scene, size) = (scene(), 96);
    let field = field(&scene, &corners(), size);
    let truth = capture(&scene, MIDDLE, Face::Nz, size);
    let indices: Vec<usize> = (0..field.views.len()).collect();
    let views = ActiveViews::new(&field, &indices, MIDDLE);
    let camera = Camera::look_at(MIDDLE, MIDDLE + DVec3::NEG_Z, DVec3::Y, Lens::new(90.0)).unwrap();
    let mirror = |picture: &Rendered| psnr(picture, &truth, |[reflect, refract, _]| reflect > 0.0 && refract == 0.0);
    let look = |near_m: f32, specular| {
        let settings =
            RenderSettings { steps: Steps::new(256, near_m, views.far_m(), 8), ..settings(size, &views, specular) };
        mirror(&render(&views, &camera, &settings, &Silent).unwrap())
    };
    let [plain, near, far] = [(0.01, SpecularMode::None), (0.01, SpecularMode::Auto), (0.6, SpecularMode::Auto)]
        .map(|(near_m, specular)| look(near_m, specular));
    assert!(near >= plain + 8.0 && far >= near - 1.0, "{plain} dB without, {near} and {far} dB with effects");
}

#[test]
fn the_fast_form_is_the_plain_one() {
    let (scene, size) = (scene(), 32);
    let field = field(&scene, &corners(), size);
    let views = ActiveViews::new(&field, &[0, 3, 5, 6], MIDDLE);
    let camera = Camera::look_at(MIDDLE, MIDDLE + DVec3::NEG_Z, DVec3::Y, Lens::new(90.0)).unwrap();
    let settings = settings(size, &views, SpecularMode::Auto);
    let fast = render(&views, &camera, &settings, &Silent).unwrap();
    let plain = render_plainly(&views, &camera, &settings, &Silent).unwrap();
    assert!(plain.counters.secondary_rays > 0);
    let found = SquaredError::of_u8(
        fast.image.codes(ToneMap::default()).data().as_flattened(),
        plain.image.codes(ToneMap::default()).data().as_flattened(),
    );
    assert!(found.unwrap().psnr_db() >= 50.0);
}

#[test]
fn nothing_is_sent_on_where_nothing_calls_for_it() {
    let field = field(&scene(), &corners()[..2], 24);
    let none = look(&field, MIDDLE, 24, SpecularMode::None);
    let work = |picture: &Rendered| {
        let counters = picture.counters;
        [counters.secondary_rays, counters.normal_evals, counters.material_samples]
    };
    for material in [None, Some([0, 0, 64, 0])] {
        let field = with_material(field.clone(), material);
        let [auto, force] =
            [SpecularMode::Auto, SpecularMode::Force].map(|specular| look(&field, MIDDLE, 24, specular));
        assert_eq!(auto, none);
        assert_eq!(force.image, none.image);
        assert_eq!(work(&auto), [0; 3]);
        assert_eq!(work(&force)[..2], [0; 2]);
        assert_eq!(work(&force)[2] > 0, material.is_some());
    }
    assert!(work(&look(&field, MIDDLE, 24, SpecularMode::Auto)).iter().all(|&count| count > 0));
}

#[test]
fn light_is_neither_made_nor_without_end() {
    let field = field(&scene(), &corners()[..4], 16);
    // All texels have the same colour, so reflection and refraction must not change it.
    let alike = |material| {
        let mut field = with_material(field.clone(), Some(material));
        for face in field.views.iter_mut().flat_map(|view| view.faces.iter_mut().flatten()) {
            face.color = ColorTexels::Codes(vec![[120, 60, 200, 0]; face.inverse_depth.len()]);
        }
        field
    };
    // Facing mirrors, weights that add up to 2, glass of index 1, 1.5 and 3, and a mixture.
    for material in
        [[255, 0, 0, 0], [255, 255, 128, 0], [0, 255, 0, 0], [20, 235, 64, 0], [30, 225, 255, 0], [40, 50, 64, 0]]
    {
        let field = alike(material);
        let plain = look(&field, MIDDLE, 16, SpecularMode::None);
        let sent = look(&field, MIDDLE, 16, SpecularMode::Auto);
        assert!(sent.counters.secondary_rays > 0, "{material:?}");
        // At most four secondary rays per surface, over four bounces: 4 + 16 + 64 + 256 = 4 * 85.
        assert!(sent.counters.secondary_rays <= sent.counters.primary_rays * 4 * 85, "{material:?}");
        for (a, b) in sent.image.color.data().iter().flatten().zip(plain.image.color.data().iter().flatten()) {
            assert!(a.is_finite() && (a - b).abs() <= 1e-5, "{material:?}: {a} instead of {b}");
        }
    }
}

#[test]
fn normals_are_those_of_the_ball() {
    let field = field(&scene(), &corners(), 96);
    let indices: Vec<usize> = (0..8).collect();
    let views = ActiveViews::new(&field, &indices, MIDDLE);
    let to_eye = (MIDDLE - GLASS.0).normalize();
    let (mut angles, mut errors) = (Vec::new(), Vec::new());
    for at in 0..64 {
        let [x, y] = [at % 8, at / 8].map(|at| (f64::from(at) - 3.5) / 7.0);
        let normal = (to_eye + DVec3::new(x, y, 0.0)).normalize();
        let point = (GLASS.0 + GLASS.1 * normal - MIDDLE).as_vec3();
        let Some(found) = patch(&views, point) else { continue };
        assert!((found.normal.length() - 1.0).abs() < 1e-5);
        angles.push(found.normal.angle_between(normal.as_vec3()).to_degrees());
        errors.extend(found.curvature.map(|curvature| (f64::from(curvature) * GLASS.1 - 1.0).abs()));
    }
    angles.sort_by(f32::total_cmp);
    errors.sort_by(f64::total_cmp);
    assert!(angles.len() > 40 && errors.len() > 40, "{} normals, {} of them bent", angles.len(), errors.len());
    let middle = (angles[angles.len() / 2], errors[errors.len() / 2]);
    assert!(middle.0 < 0.8 && angles[angles.len() - 1] < 3.0, "degrees: {angles:?}");
    assert!(middle.1 < 0.05, "parts of the curvature: {errors:?}");
}

/// The fitted sphere has the centre and radius of the ball. In the environment around its centre, walls have their true
/// distances, also behind the ball, where no probe sees them.
#[test]
fn balls_of_glass_are_known_as_wholes() {
    let field = field(&scene(), &corners(), 96);
    let indices: Vec<usize> = (0..8).collect();
    let views = ActiveViews::new(&field, &indices, MIDDLE);
    let glass = Proxies::of(&SphereFit, &views, &Silent).unwrap();
    let [found] = &glass.proxies[..] else { panic!("one sphere expected: {:?}", glass.proxies.len()) };
    assert!(found.sphere.centre.distance((GLASS.0 - MIDDLE).as_vec3()) < 1e-3, "{:?}", found.sphere);
    assert!((f64::from(found.sphere.radius_m) - GLASS.1).abs() < 1e-3 && (found.ior - 1.5).abs() < 0.01, "{found:?}");
    let around = glass.environments();
    let (mut errors, steps) = (Vec::new(), Steps::new(256, 0.02, 10.0, 8));
    for at in 0..63 {
        let [x, y] = [at % 9, at / 9].map(|at| (f64::from(at) - 4.0) / 10.0);
        let direction = DVec3::new(x, y - 0.4, -1.0).normalize();
        // Distances from the centre of the ball to the walls of the scene's room, per axis.
        let walls = [DVec3::new(-2.0, 0.0, -2.0), DVec3::new(2.0, 3.0, 2.0)].map(|wall| (wall - GLASS.0) / direction);
        let expected_m = walls[0].max(walls[1]).min_element();
        let ray = Ray { origin: found.sphere.centre, direction: direction.as_vec3() };
        let hit = intersect(Acceleration::Pyramid, &around[0], &ray, &steps, &mut Counters::default());
        errors.push((f64::from(hit.unwrap()) / expected_m).ln().abs());
    }
    errors.sort_by(f64::total_cmp);
    assert!(errors[errors.len() / 2] < 0.02 && errors[errors.len() * 9 / 10] < 0.1, "{errors:?}");
}

#[test]
fn planes_have_exact_normals_and_are_flat() {
    let field = field(&scene(), &corners()[..1], 48);
    let views = ActiveViews::new(&field, &[0], MIDDLE);
    // The wall behind the eye, 2 m from the centre of the room.
    let wall = patch(&views, (DVec3::new(0.2, 1.2, 2.0) - MIDDLE).as_vec3()).unwrap();
    assert!(wall.normal.distance(Vec3::NEG_Z) < 2e-3, "{}", wall.normal);
    assert!(wall.curvature.unwrap().abs() < 0.05);
    // No view has a surface near this point.
    assert_eq!(patch(&views, Vec3::new(0.0, 0.0, -0.1)), None);
}

/// Function from a direction to the distance in metres, colour and material that a probe sees in it.
type Sight<'a> = &'a dyn Fn(DVec3) -> (f64, [u8; 3], [u8; 4]);

/// Returns a synthetic probe with the distances, colours and materials of `sight`, as linear codes.
fn made(position: DVec3, size: u32, sight: Sight<'_>) -> View {
    let mut view = SyntheticProbe::new(position, size).cube(CODES, &|to| {
        let (distance_m, color, _) = sight(to);
        Some((distance_m, color))
    });
    for face in Face::CUBE {
        let Some(texels) = &mut view.faces[face as usize] else { continue };
        let [forward, right, down] = face.axes();
        let material = |at: u32| {
            let [u, v] = [at % size, at / size].map(|at| (f64::from(at) + 0.5) / f64::from(size) * 2.0 - 1.0);
            sight((forward + u * right + v * down).normalize()).2
        };
        texels.material = Some((0..size * size).map(material).collect());
        texels.update_specular();
    }
    view
}

const CODES: ColorCoding = ColorCoding::Codes(ToneMap { transfer: Transfer::Linear, exposure_ev: 0.0 });

/// Returns the distance in metres to the nearest wall of a 4 m cube around the origin, seen from inside, and the point on the
/// wall.
fn wall(eye: DVec3, direction: DVec3) -> (f64, DVec3) {
    let distance_m = ((2.0 * direction.signum() - eye) / direction).min_element();
    (distance_m, eye + distance_m * direction)
}

fn color_of(at: DVec3) -> [u8; 3] {
    at.to_array().map(|at| (128.0 + 100.0 * (0.7 * at).sin()).round() as u8)
}

fn code_error(picture: &Rendered, size: u32, expected: impl Fn(u32, u32) -> Option<[u8; 3]>) -> f64 {
    let (mut errors, mut count) = (0.0, 0.0);
    for (at, light) in (0..).zip(picture.image.color.data()) {
        let Some(expected) = expected(at % size, at / size) else { continue };
        for (light, code) in light.iter().zip(expected) {
            errors += (f64::from(*light) * 255.0 - f64::from(code)).abs();
            count += 1.0;
        }
    }
    assert!(count > 100.0);
    errors / count
}

fn pixel_direction(camera: &Camera, size: u32, x: u32, y: u32) -> DVec3 {
    camera.direction([x, y].map(|at| (f64::from(at) + 0.5) / f64::from(size)))
}

/// Two facing walls are mirrors; the visible point after up to four reflections follows from geometry.
#[test]
fn mirrors_that_face_each_other_show_places_in_order() {
    let sight = |to: DVec3| {
        let at = wall(DVec3::ZERO, to).1;
        (at.length(), color_of(at), if at.z.abs() > 1.999 { [255, 0, 0, 0] } else { [0; 4] })
    };
    let (field, size) = (LightField { views: vec![made(DVec3::ZERO, 128, &sight)], coding: CODES }, 32);
    let eye = DVec3::new(0.3, 0.2, 0.1);
    let views = ActiveViews::new(&field, &[0], eye);
    let camera = Camera::look_at(eye, eye + DVec3::new(0.2, 0.1, -1.0), DVec3::Y, Lens::new(60.0)).unwrap();
    let expected = |x: u32, y: u32| {
        let (mut at, mut direction) = (eye, pixel_direction(&camera, size, x, y));
        for _ in 0..=4 {
            at = wall(at, direction).1;
            if at.z.abs() < 1.999 {
                break;
            }
            direction.z = -direction.z;
        }
        Some(color_of(at))
    };
    let errors = [SpecularMode::None, SpecularMode::Auto].map(|specular| {
        let settings =
            RenderSettings { steps: Steps::new(1024, 0.01, views.far_m(), 8), ..settings(size, &views, specular) };
        code_error(&render(&views, &camera, &settings, &Silent).unwrap(), size, expected)
    });
    assert!(errors[0] > 20.0 && errors[1] < 4.0, "codes off without and with effects: {errors:?}");
}

/// A glass ball of index 1 is invisible: the renderer shows the wall behind it, which other probes see.
#[test]
fn glass_of_index_one_is_not_there() {
    let (ball, radius_m) = (DVec3::new(0.1, 0.0, -0.8), 0.4);
    let hit = |eye: DVec3, to: DVec3| {
        let along = to.dot(eye - ball);
        let squared = along * along - ((eye - ball).length_squared() - radius_m * radius_m);
        (squared > 0.0 && along < 0.0).then(|| -along - squared.sqrt())
    };
    let position = |at: u32| {
        let sign = |axis: u32| f64::from(at >> axis & 1) * 2.0 - 1.0;
        ball + 0.9 * DVec3::new(sign(0), sign(1), sign(2))
    };
    let view = |at: u32| {
        let position = position(at);
        made(position, 96, &|to| match hit(position, to) {
            Some(distance_m) => (distance_m, [0; 3], [0, 255, 0, 0]),
            None => {
                let (distance_m, at) = wall(position, to);
                (distance_m, color_of(at), [0; 4])
            }
        })
    };
    let field = LightField { views: (0..8).map(view).collect(), coding: CODES };
    let (eye, size) = (DVec3::new(0.2, 0.1, 0.7), 48);
    let views = ActiveViews::new(&field, &[0, 1, 2, 3, 4, 5, 6, 7], eye);
    let camera = Camera::look_at(eye, ball, DVec3::Y, Lens::new(40.0)).unwrap();
    // Pixels well inside the outline of the ball, which is one or two texels wide.
    let expected = |x: u32, y: u32| {
        let direction = pixel_direction(&camera, size, x, y);
        let inside = (ball - eye).cross(direction).length() < 0.8 * radius_m;
        inside.then(|| color_of(wall(eye, direction).1))
    };
    let errors = [SpecularMode::None, SpecularMode::Auto].map(|specular| {
        let settings = settings(size, &views, specular);
        code_error(&render(&views, &camera, &settings, &Silent).unwrap(), size, expected)
    });
    assert!(errors[0] > 60.0 && errors[1] < 8.0, "codes off without and with effects: {errors:?}");
}

/// A glass ball mainly shows the surfaces that it hides. Other probes see these through the ball as well, from other positions.
#[test]
fn glass_shows_what_it_hides() {
    let (ball, radius_m, ior) = (DVec3::new(0.1, 0.0, -0.8), 0.4, 1.5);
    let paint = |at: DVec3| at.to_array().map(|at| (128.0 + 100.0 * (5.0 * at).sin()).round() as u8);
    let bend = |direction: DVec3, normal: DVec3, ratio: f64| {
        let cosine = -direction.dot(normal);
        ratio * direction + (ratio * cosine - (1.0 - ratio * ratio * (1.0 - cosine * cosine)).sqrt()) * normal
    };
    // The ray passes the ball, or is refracted through it. The reflection, which is strong at the outline, is ignored.
    let sight = |eye: DVec3, to: DVec3| {
        let along = to.dot(eye - ball);
        let squared = along * along - ((eye - ball).length_squared() - radius_m * radius_m);
        if squared <= 0.0 || along > 0.0 {
            let (distance_m, at) = wall(eye, to);
            return (distance_m, paint(at), [0; 4]);
        }
        let distance_m = -along - squared.sqrt();
        let entry = eye + distance_m * to;
        let inside = bend(to, (entry - ball) / radius_m, 1.0 / ior);
        let end = entry - 2.0 * inside.dot(entry - ball) * inside;
        let out = bend(inside, (ball - end) / radius_m, ior);
        (distance_m, paint(wall(end, out).1), [0, 255, 64, 0])
    };
    let view = |at: u32| {
        let sign = |axis: u32| f64::from(at >> axis & 1) * 2.0 - 1.0;
        let position = DVec3::new(0.2 + 0.55 * sign(0), 0.1 + 0.55 * sign(1), 0.7);
        made(position, 96, &|to| sight(position, to))
    };
    let field = LightField { views: (0..4).map(view).collect(), coding: CODES };
    let (eye, size) = (DVec3::new(0.2, 0.1, 0.7), 48);
    let views = ActiveViews::new(&field, &[0, 1, 2, 3], eye);
    let camera = Camera::look_at(eye, ball, DVec3::Y, Lens::new(40.0)).unwrap();
    // Pixels with little reflection, which `sight` ignores.
    let expected = |x: u32, y: u32| {
        let direction = pixel_direction(&camera, size, x, y);
        let inside = (ball - eye).cross(direction).length() < 0.6 * radius_m;
        inside.then(|| sight(eye, direction).1)
    };
    let errors = [SpecularMode::None, SpecularMode::Auto].map(|specular| {
        let settings = settings(size, &views, specular);
        code_error(&render(&views, &camera, &settings, &Silent).unwrap(), size, expected)
    });
    assert!(errors[1] < 11.0 && errors[1] < 0.7 * errors[0], "codes off without and with effects: {errors:?}");
}
