use glam::DVec3;
use half::f16;

use super::*;
use crate::{DemoKind, DemoScene, SceneAtTime, trace};
use codec::error::{Error, Result};
use codec::image::{ColorPlane, DepthKind, DepthPlane, Face, ImageProjection};
use codec::monitor::Silent;

/// Captures a face of the cube map at a position, with [`COLOR_SAMPLES`] samples. Depth is the distance in metres along the ray
/// through the pixel's centre, `+inf` for the background.
pub(crate) fn capture_face(
    scene: &SceneAtTime,
    position: DVec3,
    face: Face,
    size: u32,
) -> Result<(ColorPlane, DepthPlane)> {
    let samples = SamplePattern::new(COLOR_SAMPLES)?;
    let passes = [Pass::Color, Pass::Depth];
    let settings =
        PassSettings { passes: &passes, samples: &samples, depth: DepthKind::Distance, far_m: f64::INFINITY };
    let from = Viewpoint { position, orientation: None, projection: ImageProjection::cube_face(face, size) };
    let images = capture_view(scene, &from, &settings, &Silent)?;
    images.color.zip(images.depth).ok_or_else(|| Error::invalid("a face without colour and depth"))
}

#[test]
fn thread_count_does_not_matter() {
    let demo = DemoScene::new(DemoKind::Courtyard);
    let (probe, _) = demo.probe_region();
    let captures = [1, 2, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| capture_face(&demo.at(0.5), probe, Face::Nx, 100).unwrap())
    });
    assert_eq!(captures[0], captures[1]);
    assert_eq!(captures[0], captures[2]);
}

#[test]
fn culling_and_shafts_change_nothing() {
    let demo = DemoScene::new(DemoKind::Courtyard);
    let scene = demo.at(1.3);
    // From the middle, from outside the region, and from above the scene.
    for position in [DVec3::new(0.1, 1.4, 0.2), DVec3::new(-3.0, 1.0, 3.0), DVec3::new(-1.0, 9.0, 0.0)] {
        for face in Face::CUBE {
            let size = 37;
            let (color, depth) = capture_face(&scene, position, face, size).unwrap();
            for row in 0..size {
                for col in 0..size {
                    let hit = trace(&scene, position, face.direction(col, row, size));
                    assert_eq!(depth.get(col, row), hit.distance as f32, "{face:?} {col} {row}");
                    let mean = (0..16).fold(DVec3::ZERO, |sum, k| {
                        let (x, y) = (col * 4 + k % 4, row * 4 + k / 4);
                        sum + trace(&scene, position, face.direction(x, y, size * 4)).color
                    }) / 16.0;
                    assert_eq!(color.get(col, row), mean.to_array().map(f16::from_f64), "{face:?} {col} {row}");
                }
            }
        }
    }
}

#[test]
fn depth_is_distance_not_planar() {
    let demo = DemoScene::new(DemoKind::Courtyard);
    let (probe, _) = demo.probe_region();
    let (_, depth) = capture_face(&demo.at(0.0), probe, Face::Ny, 64).unwrap();
    // The ground is 1.5 m below; the ray through pixel (20, 30) is longer.
    let (u, v) = (2.0 * 20.5 / 64.0 - 1.0, 2.0 * 30.5 / 64.0 - 1.0);
    let expected = 1.5 * f64::sqrt(1.0 + u * u + v * v);
    assert!((f64::from(depth.get(20, 30)) - expected).abs() < 1e-6);
}

#[test]
fn sizes_and_positions_are_checked() {
    let scene = DemoScene::new(DemoKind::Courtyard).at(0.0);
    assert!(capture_face(&scene, DVec3::ZERO, Face::Px, 0).is_err());
    assert!(capture_face(&scene, DVec3::ZERO, Face::Px, MAX_FACE_SIZE + 1).is_err());
    assert!(capture_face(&scene, DVec3::NAN, Face::Px, 4).is_err());
    for size in [1, 3, 17] {
        let (color, depth) = capture_face(&scene, DVec3::Y, Face::View, size).unwrap();
        assert_eq!((color.width(), depth.height()), (size, size));
    }
}
