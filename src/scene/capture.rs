//! A scene seen through one face of a cube map, as a renderer would write it.
//!
//! Enters: a frozen scene, a position, a face, a size. Leaves: colour averaged over each pixel, and depth through its
//! centre. The two disagree at edges by design: so does the footage of every renderer.

use glam::DVec3;
use half::f16;
use rayon::prelude::*;

use super::primitive::Ray;
use super::raycast::SceneAtTime;
use crate::error::{Error, Result};
use crate::image::{ColorPlane, DepthPlane, Face};

/// Colour is the mean of this many by this many rays, at the centres of a regular grid inside the pixel.
pub const COLOR_SAMPLES_PER_SIDE: u32 = 4;
/// Largest face, in pixels a side: 16,384² colours and depths are 2.5 GiB.
pub const MAX_FACE_SIZE: u32 = 16_384;

/// Side in pixels of the squares for which the objects in view are gathered once.
const TILE: u32 = 16;

/// Captures `face` of the cube map at `position`: `size`×`size` pixels.
///
/// Colour is linear radiance rounded to half floats. Depth is the Euclidean distance in metres along the ray through
/// the pixel's centre, `+inf` where there is nothing. The result does not depend on the number of threads.
///
/// # Errors
/// If `size` is 0 or above [`MAX_FACE_SIZE`], or the position is not finite.
pub fn capture_face(scene: &SceneAtTime, position: DVec3, face: Face, size: u32) -> Result<(ColorPlane, DepthPlane)> {
    if size == 0 || size > MAX_FACE_SIZE {
        return Err(Error::Usage(format!("a face has 1 to {MAX_FACE_SIZE} pixels a side, not {size}")));
    }
    if !position.is_finite() {
        return Err(Error::Usage(format!("a probe's position must be finite, not {position}")));
    }
    let mut color = ColorPlane::filled(size, size, [f16::ZERO; 3]);
    let mut depth = DepthPlane::filled(size, size, f32::INFINITY);
    let band = (size * TILE) as usize;
    let bands = color.data_mut().par_chunks_mut(band).zip(depth.data_mut().par_chunks_mut(band));
    let view = View { scene, position, face, size };
    bands.enumerate().for_each(|(index, (color, depth))| view.capture_band(index as u32 * TILE, color, depth));
    Ok((color, depth))
}

/// What all pixels of a face share.
struct View<'a> {
    scene: &'a SceneAtTime,
    position: DVec3,
    face: Face,
    size: u32,
}

impl View<'_> {
    /// Rows `top..` of the face, as many as the slices hold.
    fn capture_band(&self, top: u32, color: &mut [[f16; 3]], depth: &mut [f32]) {
        let width = self.size as usize;
        let rows = (depth.len() / width) as u32;
        for left in (0..self.size).step_by(TILE as usize) {
            let right = (left + TILE).min(self.size);
            let candidates = self.in_view([left, top], [right, top + rows]);
            for row in 0..rows {
                for col in left..right {
                    let pixel = row as usize * width + col as usize;
                    color[pixel] = self.color(col, top + row, &candidates);
                    depth[pixel] = self.depth(col, top + row, &candidates);
                }
            }
        }
    }

    /// Mean radiance of a pixel.
    fn color(&self, col: u32, row: u32, candidates: &[usize]) -> [f16; 3] {
        let per_side = COLOR_SAMPLES_PER_SIDE;
        let mut sum = DVec3::ZERO;
        for j in 0..per_side {
            for i in 0..per_side {
                // A pixel of a face `per_side` times as fine.
                let ray = self.ray(col * per_side + i, row * per_side + j, self.size * per_side);
                sum += self.scene.look(&ray, candidates.iter().copied()).color;
            }
        }
        (sum / f64::from(per_side * per_side)).to_array().map(f16::from_f64)
    }

    /// Distance through the centre of a pixel.
    fn depth(&self, col: u32, row: u32, candidates: &[usize]) -> f32 {
        let ray = self.ray(col, row, self.size);
        let first = self.scene.first_hit(&ray, candidates.iter().copied());
        first.map_or(f32::INFINITY, |hit| hit.distance as f32)
    }

    fn ray(&self, col: u32, row: u32, size: u32) -> Ray {
        // Every direction on a face has a length between 1 and √3.
        Ray::from_unit(self.position, self.face.direction(col, row, size).normalize())
    }

    /// Indices, in order, of the objects that pixels `from..to` may see: those whose bounding box is not wholly on the
    /// outer side of one of the five planes of the pixels' pyramid.
    fn in_view(&self, from: [u32; 2], to: [u32; 2]) -> Vec<usize> {
        let [forward, right, down] = self.face.axes();
        let plane = |pixel: u32| 2.0 * f64::from(pixel) / f64::from(self.size) - 1.0;
        // Normals that point inwards; every plane goes through the camera.
        let planes = [
            forward,
            right - plane(from[0]) * forward,
            plane(to[0]) * forward - right,
            down - plane(from[1]) * forward,
            plane(to[1]) * forward - down,
        ];
        let visible = |index: &usize| {
            let corners = self.scene.objects()[*index].bounds().corners().map(|corner| corner - self.position);
            // The millionth of a metre is for rounding: one object too many costs time, one too few an image.
            !planes.iter().any(|normal| corners.iter().all(|corner| corner.dot(*normal) < -1e-6))
        };
        (0..self.scene.objects().len()).filter(visible).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DemoKind, DemoScene, trace};

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
        // From the middle, from outside the region, from above everything.
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
}
