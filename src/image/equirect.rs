//! Equirectangular images resampled to cube faces: colour filtered, depth by its nearest sample.
//!
//! lon = (2(col + 0.5)/W − 1)π, lat = (0.5 − (row + 0.5)/H)π, direction = (sin lon cos lat, sin lat, −cos lon cos lat).

use std::f64::consts::PI;

use glam::DVec3;
use half::f16;

use super::cube::Face;
use super::plane::{ColorPlane, DepthPlane, Plane};
use crate::error::{Error, Result};

/// Lookups along each side of a cube pixel.
const SUPERSAMPLES: u32 = 4;

/// Continuous position, in pixels, of a direction in an equirectangular image: x in 0..=W, y in 0..=H.
pub fn position(direction: DVec3, width: u32, height: u32) -> (f64, f64) {
    let lon = direction.x.atan2(-direction.z);
    let lat = direction.y.atan2(direction.x.hypot(direction.z));
    ((lon / PI + 1.0) * 0.5 * f64::from(width), (0.5 - lat / PI) * f64::from(height))
}

/// Direction, of length 1, of the centre of pixel (col, row).
pub fn direction(col: u32, row: u32, width: u32, height: u32) -> DVec3 {
    let lon = (2.0 * (f64::from(col) + 0.5) / f64::from(width) - 1.0) * PI;
    let lat = (0.5 - (f64::from(row) + 0.5) / f64::from(height)) * PI;
    DVec3::new(lon.sin() * lat.cos(), lat.sin(), -lon.cos() * lat.cos())
}

/// Where each pixel of a cube face finds its samples in equirectangular images of one size.
///
/// Building it costs far more than using it, so it is built once for all frames. It takes about 100 bytes for each
/// pixel of the face.
#[derive(Debug, Clone)]
pub struct FaceMap {
    size: u32,
    width: u32,
    height: u32,
    /// First tap of each pixel, and one past the last.
    starts: Vec<u32>,
    /// Source pixel and weight; the weights of one pixel add up to 1.
    taps: Vec<(u32, f32)>,
    nearest: Vec<u32>,
}

impl FaceMap {
    /// Plans a face of `size`×`size` pixels cut from images of `width`×`height`.
    ///
    /// # Errors
    /// When a side is 0, or so large that a plan cannot address the pixels.
    pub fn new(face: Face, size: u32, width: u32, height: u32) -> Result<FaceMap> {
        let most = 16 * u64::from(size) * u64::from(size) * 4;
        if size == 0 || width == 0 || height == 0 {
            return Err(Error::invalid("an image without pixels cannot be resampled"));
        }
        if most > u64::from(u32::MAX) || u64::from(width) * u64::from(height) > u64::from(u32::MAX) {
            return Err(Error::unsupported(format!(
                "resampling {width}x{height} pixels to faces of {size} is too large"
            )));
        }
        let [forward, right, down] = face.axes();
        let mut map = FaceMap { size, width, height, starts: vec![0], taps: Vec::new(), nearest: Vec::new() };
        let mut pixel: Vec<(u32, f64)> = Vec::new();
        for (row, col) in (0..size).flat_map(|row| (0..size).map(move |col| (row, col))) {
            pixel.clear();
            for (j, i) in (0..SUPERSAMPLES).flat_map(|j| (0..SUPERSAMPLES).map(move |i| (j, i))) {
                let at = |pixel: u32, sub: u32| {
                    let offset = (f64::from(sub) + 0.5) / f64::from(SUPERSAMPLES);
                    2.0 * (f64::from(pixel) + offset) / f64::from(size) - 1.0
                };
                map.add_bilinear(forward + at(col, i) * right + at(row, j) * down, &mut pixel);
            }
            pixel.sort_by_key(|tap| tap.0);
            let scale = 1.0 / f64::from(SUPERSAMPLES * SUPERSAMPLES);
            for taps in pixel.chunk_by(|a, b| a.0 == b.0) {
                let weight = taps.iter().map(|tap| tap.1).sum::<f64>() * scale;
                if weight > 0.0 {
                    map.taps.push((taps[0].0, weight as f32));
                }
            }
            map.starts.push(map.taps.len() as u32);
            let (x, y) = position(face.direction(col, row, size), width, height);
            map.nearest.push((y as u32).min(height - 1) * width + x as u32 % width);
        }
        Ok(map)
    }

    /// Adds the four pixels around a direction. Columns wrap; beyond a pole the picture goes on half a turn away.
    fn add_bilinear(&self, direction: DVec3, pixel: &mut Vec<(u32, f64)>) {
        let (x, y) = position(direction, self.width, self.height);
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        for (dy, wy) in [(0i64, 1.0 - fy), (1, fy)] {
            for (dx, wx) in [(0i64, 1.0 - fx), (1, fx)] {
                let (mut col, mut row) = (left as i64 + dx, top as i64 + dy);
                let (width, height) = (i64::from(self.width), i64::from(self.height));
                if row < 0 || row >= height {
                    row = if row < 0 { -1 - row } else { 2 * height - 1 - row };
                    col += width / 2;
                }
                let index = row.clamp(0, height - 1) * width + col.rem_euclid(width);
                pixel.push((index as u32, wx * wy));
            }
        }
    }

    fn check(&self, width: u32, height: u32) -> Result<()> {
        if (width, height) == (self.width, self.height) {
            return Ok(());
        }
        Err(Error::invalid(format!("the image is {width}x{height}, expected {}x{}", self.width, self.height)))
    }
}

/// Filtered colour of a face: 4×4 bilinear lookups a pixel, weighted equally.
///
/// # Errors
/// When the image is not of the size that the map was made for.
pub fn resample_color(image: &ColorPlane, map: &FaceMap) -> Result<ColorPlane> {
    map.check(image.width(), image.height())?;
    let data = image.data();
    let pixels = map.starts.windows(2).map(|range| {
        let mut sum = [0f32; 3];
        for &(index, weight) in &map.taps[range[0] as usize..range[1] as usize] {
            for (sum, component) in sum.iter_mut().zip(data[index as usize]) {
                *sum += weight * component.to_f32();
            }
        }
        sum.map(f16::from_f32)
    });
    Plane::new(map.size, map.size, pixels.collect())
}

/// Depth of a face: the sample nearest to the direction of each pixel's centre, so that two surfaces never mix.
///
/// # Errors
/// As for [`resample_color`].
pub fn resample_depth(image: &DepthPlane, map: &FaceMap) -> Result<DepthPlane> {
    resample_nearest(image, map)
}

/// Any other pixels, by nearest sample.
///
/// # Errors
/// As for [`resample_color`].
pub fn resample_nearest<T: Copy>(image: &Plane<T>, map: &FaceMap) -> Result<Plane<T>> {
    map.check(image.width(), image.height())?;
    Plane::new(map.size, map.size, map.nearest.iter().map(|&index| image.data()[index as usize]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_undo_directions() {
        for (width, height) in [(1, 1), (2, 1), (7, 3), (64, 32)] {
            for (row, col) in (0..height).flat_map(|row| (0..width).map(move |col| (row, col))) {
                let (x, y) = position(direction(col, row, width, height), width, height);
                assert!((y - f64::from(row) - 0.5).abs() < 1e-9);
                // At odd heights the middle row of a pole-free image still has a longitude.
                assert!((x - f64::from(col) - 0.5).abs() < 1e-9, "{width}x{height} {col},{row} {x}");
            }
        }
    }

    #[test]
    fn faces_see_their_own_direction() {
        let (width, height, size) = (512, 256, 64);
        let code = |d: DVec3| [d.x, d.y, d.z].map(f16::from_f64);
        let image = Plane::from_fn(width, height, |x, y| code(direction(x, y, width, height)));
        let depth = Plane::from_fn(width, height, |x, y| (y * width + x) as f32);
        for face in Face::CUBE {
            let map = FaceMap::new(face, size, width, height).unwrap();
            let faces = resample_color(&image, &map).unwrap();
            let near = resample_depth(&depth, &map).unwrap();
            for (row, col) in (0..size).flat_map(|row| (0..size).map(move |col| (row, col))) {
                let expected = face.direction(col, row, size).normalize();
                let got = faces.get(col, row).map(f16::to_f64);
                assert!(DVec3::from_array(got).distance(expected) < 0.004, "{face:?} {col},{row}");
                let index = near.get(col, row) as u32;
                let there = direction(index % width, index / width, width, height);
                // Half a pixel's diagonal.
                assert!(there.angle_between(expected) < 0.0088, "{face:?} {col},{row}");
            }
        }
    }

    #[test]
    fn tiny_images() {
        for (width, height) in [(1, 1), (3, 1), (3, 2), (1, 4)] {
            let image = Plane::filled(width, height, [f16::from_f32(2.5); 3]);
            for face in Face::CUBE {
                let map = FaceMap::new(face, 3, width, height).unwrap();
                let out = resample_color(&image, &map).unwrap();
                assert!(out.data().iter().all(|pixel| *pixel == [f16::from_f32(2.5); 3]));
                assert!(resample_color(&Plane::filled(9, 9, [f16::ZERO; 3]), &map).is_err());
            }
        }
        assert!(FaceMap::new(Face::Px, 0, 4, 2).is_err());
        assert!(FaceMap::new(Face::Px, 60_000, 4, 2).is_err());
    }
}
