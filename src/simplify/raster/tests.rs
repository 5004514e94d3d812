use std::sync::Arc;

use glam::{DVec3, Vec2};
use half::f16;

use super::alpha::AlphaRaster;
use super::*;
use codec::math::Lens;
use codec::monitor::Silent;
use scene::mesh::{ImageTexture, Mesh, Wrap};

/// Adds a square of one colour that is perpendicular to the view, at a distance, and half as wide as the picture.
fn square(mesh: &mut Mesh, distance: f64, texel: f32) {
    let first = mesh.positions.len() as u32;
    for [x, y] in [[-0.5, 0.5], [0.5, 0.5], [0.5, -0.5], [-0.5, -0.5]] {
        mesh.positions.push(DVec3::new(x, y, -1.0) * distance);
        mesh.uvs.push(Vec2::new(texel, 0.5));
    }
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    mesh.material_of.extend([0, 0]);
}

fn scene(mesh: Mesh) -> QuadMesh {
    let pixels = vec![[255, 0, 0, 255], [0, 255, 0, 128]];
    let texture = ImageTexture { width: 2, height: 1, pixels, wrap: [Wrap::Clamp; 2] };
    QuadMesh { mesh, texture: Arc::new(texture), stq: Vec::new(), light: None, runs: Vec::new() }
}

/// Returns triangles of all sizes around the origin, beside and behind it, and a texture with all alphas.
fn crowd(count: u32) -> QuadMesh {
    let mut state = 7u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24)
    };
    let mut mesh = Mesh::default();
    for at in 0..count {
        let middle = 3.0 * DVec3::new(random() - 0.5, random() - 0.5, random() - 0.5);
        let reach = 0.05 + 2.0 * random().powi(3);
        for _ in 0..3 {
            mesh.positions.push(middle + reach * DVec3::new(random() - 0.5, random() - 0.5, random() - 0.5));
            mesh.uvs.push(Vec2::new(random() as f32, random() as f32));
        }
        mesh.triangles.push([3 * at, 3 * at + 1, 3 * at + 2]);
        mesh.material_of.push(0);
    }
    let mut code = || (256.0 * random()) as u8;
    let pixels = (0..16 * 16).map(|at| [code(), code(), code(), if at % 3 == 0 { code() } else { 255 }]).collect();
    let texture = ImageTexture { width: 16, height: 16, pixels, wrap: [Wrap::Clamp; 2] };
    QuadMesh { mesh, texture: Arc::new(texture), stq: Vec::new(), light: None, runs: Vec::new() }
}

fn camera(eye: DVec3, target: DVec3) -> Camera {
    Camera::look_at(eye, target, DVec3::Y, Lens::new(90.0)).unwrap()
}

fn settings(compositing: Compositing, samples: u32) -> DrawSettings {
    DrawSettings { size: [16, 16], compositing, samples }
}

#[test]
fn later_triangles_are_blended_over_earlier_ones() {
    let mut mesh = Mesh::default();
    // The nearer square comes first: order decides, not depth.
    square(&mut mesh, 1.0, 0.25);
    square(&mut mesh, 3.0, 0.75);
    let drawn = draw(&scene(mesh), &camera(DVec3::ZERO, DVec3::NEG_Z), [16, 16]);
    assert_eq!((drawn.fragments, drawn.max_fragments), (2 * 8 * 8, 2));
    let alpha = 128.0 / 255.0;
    for (at, pixel) in drawn.pixels.iter().enumerate() {
        let is_inside = [at % 16, at / 16].iter().all(|place| (4..12).contains(place));
        let wanted = if is_inside { [1.0 - alpha, alpha, 0.0, 1.0] } else { [0.0; 4] };
        assert!(pixel.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-5), "{at}: {pixel:?}");
    }
}

#[test]
fn homogeneous_texture_coordinates_are_those_of_the_plane_of_a_face() {
    // A quad that recedes from the eye, whose texture is a ramp over the picture.
    let mut mesh = Mesh::default();
    let corners = [([-1.0, 1.0], 1.0), ([1.0, 1.0], 4.0), ([1.0, -1.0], 4.0), ([-1.0, -1.0], 1.0)];
    for ([x, y], depth) in corners {
        mesh.positions.push(DVec3::new(x, y, -1.0) * depth);
        mesh.uvs.push(Vec2::new(0.5 + 0.25 * x as f32, 0.5));
    }
    (mesh.triangles, mesh.material_of) = (vec![[0, 1, 2], [0, 2, 3]], vec![0, 0]);
    let stq = mesh.uvs.iter().zip(corners).map(|(uv, (_, depth))| uv.extend(1.0) * depth as f32).collect();
    let pixels = vec![[0, 0, 0, 255], [255; 4]];
    let texture = ImageTexture { width: 2, height: 1, pixels, wrap: [Wrap::Clamp; 2] };
    let light = Some(vec![[f16::ZERO; 3], [f16::from_f32(8.0); 3]]);
    let mut scene = QuadMesh { mesh, texture: Arc::new(texture), stq, light, runs: Vec::new() };
    let error = |scene: &QuadMesh, draw: fn(&QuadMesh, &Camera, [u32; 2]) -> Drawn| {
        let drawn = draw(scene, &camera(DVec3::ZERO, DVec3::NEG_Z), [16, 16]);
        assert_eq!(drawn.fragments, 256);
        let wanted = |at: usize| 8.0 * ((at % 16) as f32 + 0.5) / 16.0;
        drawn.pixels.iter().enumerate().map(|(at, pixel)| (pixel[0] - wanted(at)).abs()).fold(0.0, f32::max)
    };
    assert!(error(&scene, draw) < 1e-4 && error(&scene, draw_plainly) < 1e-4, "{}", error(&scene, draw));
    scene.stq.clear();
    assert!(error(&scene, draw) > 1.0 && error(&scene, draw_plainly) > 1.0, "{}", error(&scene, draw));
}

#[test]
fn triangles_are_seen_from_both_sides_and_not_behind_the_eye() {
    let mut mesh = Mesh::default();
    square(&mut mesh, 2.0, 0.25);
    let scene = scene(mesh);
    for draw in [draw, draw_plainly] {
        let seen = |eye: DVec3, target: DVec3| draw(&scene, &camera(eye, target), [16, 16]).fragments;
        assert_eq!(seen(DVec3::ZERO, DVec3::Z), 0);
        assert_eq!(seen(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO), 64);
        // An eye so near that part of the square is behind it, and an eye in the plane of the square.
        assert!(seen(DVec3::new(0.0, 0.3, -1.999), DVec3::new(0.0, 0.2, -2.1)) > 128);
        assert_eq!(seen(DVec3::new(0.0, 0.0, -2.0), DVec3::new(1.0, 0.0, -2.0)), 0);
    }
}

#[test]
fn the_two_triangles_of_a_square_share_no_pixel_and_leave_none() {
    let mut mesh = Mesh::default();
    square(&mut mesh, 2.0, 0.25);
    let scene = scene(mesh);
    for step in 0..20 {
        let turn = f64::from(step) * 0.31;
        let eye = DVec3::new(0.3 * turn.cos(), 0.3 * turn.sin(), 0.1);
        let drawn = draw(&scene, &camera(eye, DVec3::new(0.01, 0.02, -2.0)), [61, 61]);
        // Only the corners lie exactly on the diagonal.
        assert!(drawn.max_fragments == 1, "{step}");
        assert_eq!(drawn.fragments, drawn.pixels.iter().filter(|pixel| pixel[3] > 0.0).count() as u64);
    }
}

#[test]
fn spans_give_the_picture_of_single_fragments() {
    let scene = crowd(600);
    for (step, size) in [[64, 48], [33, 70], [1, 1], [129, 5]].into_iter().enumerate() {
        let turn = 1.7 * step as f64;
        let eye = DVec3::new(0.2 * turn.sin(), 0.13, 0.1 * turn);
        let camera = camera(eye, eye + DVec3::new(turn.cos(), 0.21, turn.sin()));
        let camera = camera.with_aspect(f64::from(size[0]) / f64::from(size[1]));
        let (found, wanted) = (draw(&scene, &camera, size), draw_plainly(&scene, &camera, size));
        assert_eq!((found.fragments, found.max_fragments), (wanted.fragments, wanted.max_fragments), "{size:?}");
        assert!(size == [1, 1] || wanted.max_fragments > 1, "{size:?}: {wanted:?}");
        for (at, (found, wanted)) in found.pixels.iter().zip(&wanted.pixels).enumerate() {
            assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 4e-5), "{size:?} {at}: {found:?} {wanted:?}");
        }
    }
}

#[test]
fn the_nearest_shows_through_a_z_buffer_in_any_order() {
    let camera = camera(DVec3::ZERO, DVec3::NEG_Z);
    let shown = |distances: [f64; 2], samples: u32| {
        let mut mesh = Mesh::default();
        square(&mut mesh, distances[0], 0.0);
        square(&mut mesh, distances[1], 1.0);
        let settings = settings(Compositing::ZBuffer, samples);
        let drawn = draw_picture(&scene(mesh), &camera, &settings, &Silent).unwrap();
        assert_eq!(drawn.fragments, 2 * 8 * 8 * u64::from(samples * samples));
        drawn.pixels[16 * 8 + 8]
    };
    // The first square is opaque red; the second, with an alpha of 1/2, covers half of the samples.
    for samples in [2, 4] {
        assert_eq!(shown([1.0, 3.0], samples), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(shown([3.0, 1.0], samples), [0.5, 0.5, 0.0, 1.0]);
        assert_eq!(shown([2.0, 2.0], samples), [0.5, 0.5, 0.0, 1.0]);
    }
    assert_eq!(shown([3.0, 1.0], 1), [0.0, 1.0, 0.0, 1.0]);
}

#[test]
fn thresholds_of_samples_are_spread_evenly() {
    for samples in 1..=16 {
        let all = settings(Compositing::ZBuffer, samples).samples();
        let mut thresholds: Vec<f32> = all.iter().map(|sample| sample.threshold).collect();
        thresholds.sort_by(f32::total_cmp);
        let count = f64::from(samples * samples);
        let wanted: Vec<f32> = (0..samples * samples).map(|at| ((f64::from(at) + 0.5) / count) as f32).collect();
        assert_eq!(thresholds, wanted);
    }
    assert_eq!(settings(Compositing::Painter, 1).samples(), [Sample { offset: [0.5, 0.5], threshold: 0.5 }]);
}

#[test]
fn more_samples_smooth_edges() {
    let mut mesh = Mesh::default();
    square(&mut mesh, 2.0, 0.25);
    let scene = scene(mesh);
    let turned = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::new(0.3, 1.0, 0.0), Lens::new(90.0)).unwrap();
    let alphas = |samples: u32| -> Vec<f32> {
        let drawn = draw_picture(&scene, &turned, &settings(Compositing::Painter, samples), &Silent).unwrap();
        drawn.pixels.iter().map(|pixel| pixel[3]).collect()
    };
    let partial = |alphas: &[f32]| alphas.iter().filter(|&&alpha| alpha > 0.0 && alpha < 1.0).count();
    assert_eq!(partial(&alphas(1)), 0);
    assert!(partial(&alphas(4)) > 16);
    assert!((alphas(4).iter().sum::<f32>() - 64.0).abs() < 1.0);
}

#[test]
fn near_and_far_of_the_camera_cut_triangles() {
    // A floor from below the eye to the horizon.
    let mut mesh = Mesh::default();
    for at in [[-50.0, -1.0, 50.0], [50.0, -1.0, 50.0], [50.0, -1.0, -50.0], [-50.0, -1.0, -50.0]] {
        mesh.positions.push(DVec3::from(at));
        mesh.uvs.push(Vec2::ZERO);
    }
    mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
    mesh.material_of = vec![0; 2];
    let scene = scene(mesh);
    let rows = |near_m: f64, far_m: f64| -> Vec<usize> {
        let lens = Lens { near_m, far_m, ..Lens::new(90.0) };
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
        let drawn = draw(&scene, &camera, [8, 64]);
        (0..64).filter(|row| drawn.pixels[8 * row + 3][3] > 0.0).collect()
    };
    // A row v below the centre sees the floor at depth 1 / v.
    let depth = |row: usize| 1.0 / ((row as f64 + 0.5) / 32.0 - 1.0);
    let wanted = |near_m: f64, far_m: f64| -> Vec<usize> {
        (32..64).filter(|&row| depth(row) >= near_m && depth(row) <= far_m.min(50.0)).collect()
    };
    for (near_m, far_m) in [(0.0, f64::INFINITY), (2.0, f64::INFINITY), (0.0, 3.0), (1.5, 4.0), (60.0, 70.0)] {
        assert_eq!(rows(near_m, far_m), wanted(near_m, far_m), "{near_m} {far_m}");
    }
}

#[test]
fn light_of_pictures_is_straight_or_over_black() {
    let drawn = Drawn { pixels: vec![[0.25, 0.5, 0.0, 0.5], [0.0; 4]], fragments: 1, max_fragments: 1 };
    let image = drawn.image([2, 1]).unwrap();
    assert_eq!(image.color.data(), [[0.5, 1.0, 0.0], [0.0; 3]]);
    assert_eq!(drawn.over_black([2, 1]).unwrap().color.data(), [[0.25, 0.5, 0.0], [0.0; 3]]);
    assert_eq!(image.alpha.data(), [0.5, 0.0]);
}

#[test]
fn alpha_alone_is_that_of_pictures_up_to_what_is_enough() {
    let mut crowd = crowd(300);
    for enough in [0.5, 0.998] {
        for (eye, target) in [(DVec3::ZERO, DVec3::X), (DVec3::new(0.5, 2.0, 0.1), DVec3::ZERO)] {
            let (camera, size) = (camera(eye, target), [45, 37]);
            let mut raster = AlphaRaster::new(&crowd, &camera, size);
            // Draws again after texels became opaque: rows without a change are kept.
            for _ in 0..2 {
                let found = raster.draw(&crowd, enough).to_vec();
                let drawn = draw(&crowd, &camera, size);
                for (at, (found, pixel)) in found.iter().zip(&drawn.pixels).enumerate() {
                    let is_same = if pixel[3] < enough { *found == pixel[3] } else { *found >= enough };
                    assert!(is_same, "{at}: {found} {pixel:?}");
                }
                let open = drawn.pixels.iter().filter(|pixel| pixel[3] < enough).count();
                assert!(open > 20 && open < drawn.pixels.len() - 20, "{open}");
                Arc::make_mut(&mut crowd.texture).pixels.iter_mut().step_by(7).for_each(|texel| texel[3] = u8::MAX);
            }
        }
    }
}
