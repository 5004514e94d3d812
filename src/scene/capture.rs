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
        let nearest = self.scene.nearest(&ray, candidates.iter().copied());
        nearest.map_or(f32::INFINITY, |(_, hit)| hit.distance as f32)
    }

    fn ray(&self, col: u32, row: u32, size: u32) -> Ray {
        // Every direction on a face has a length between 1 and √3.
        Ray { origin: self.position, direction: self.face.direction(col, row, size).normalize() }
    }

    /// Indices, in order, of the objects that pixels `from..to` may see: those whose bounding ball touches the cone
    /// around the pixels.
    fn in_view(&self, from: [u32; 2], to: [u32; 2]) -> Vec<usize> {
        let [forward, right, down] = self.face.axes();
        let corner = |x: u32, y: u32| {
            let [u, v] = [x, y].map(|edge| 2.0 * f64::from(edge) / f64::from(self.size) - 1.0);
            (forward + u * right + v * down).normalize()
        };
        let corners = [corner(from[0], from[1]), corner(to[0], from[1]), corner(from[0], to[1]), corner(to[0], to[1])];
        let axis = corners.iter().sum::<DVec3>().normalize();
        // A cone of less than 90° that holds the corners of a flat convex polygon holds the polygon.
        let half_angle = corners.iter().map(|corner| angle(axis, *corner)).fold(0.0, f64::max);
        let touches = |index: &usize| {
            let ball = self.scene.objects[*index].bounds();
            let to_center = ball.center - self.position;
            let distance = to_center.length();
            // The millionth is for rounding; one object too many costs time, one too few an image.
            distance <= ball.radius * (1.0 + 1e-6)
                || angle(axis, to_center / distance) <= half_angle + (ball.radius / distance).min(1.0).asin() + 1e-6
        };
        (0..self.scene.objects.len()).filter(touches).collect()
    }
}

/// Angle between two directions of length 1, in radians, without the arc cosine's loss near 0.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
