//! The image model: maps a position in an image to a direction, and a direction to a position.
//!
//! - Axes are right-handed with +Y up.
//! - Positions are in pixels from the upper left corner, x to the right, y down. The centre of pixel (col, row) is (col + 0.5,
//!   row + 0.5); an image of W×H pixels spans 0..=W by 0..=H.
//! - Cube faces and pinhole images are planar: a ray that meets the plane at distance 1 in (u, v) has the direction forward +
//!   u·right + v·down. The length of that vector is distance divided by planar depth.
//! - Cube face: u = 2x/W − 1, v = 2y/H − 1, axes of OpenGL cube maps ([`Face::axes`]).
//! - Pinhole: u = (x − cx)/fx, v = (y − cy)/fy, the camera looks along −Z. The principal point (cx, cy) may be off centre or
//!   outside the image (an off-axis frustum, as for the views of a light-field display).
//! - Equirectangular: longitude (2x/W − 1)π, latitude (0.5 − y/H)π, direction (sin lon cos lat, sin lat, −cos lon cos lat).
//!
//! [`super::texel_map`] computes the same in single precision; shaders/march/light_field.wgsl mirrors it.

use std::f64::consts::PI;

use glam::DVec3;

use super::cube::{Face, direction_to_face};

/// Projection of an image, with its width and height in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ImageProjection {
    CubeFace {
        /// The face; not [`Face::View`].
        face: Face,
        size: [u32; 2],
    },
    Pinhole {
        size: [u32; 2],
        /// fx, fy, cx, cy in pixels.
        intrinsics: [f64; 4],
    },
    Equirect {
        size: [u32; 2],
    },
}

impl ImageProjection {
    pub fn cube_face(face: Face, size: u32) -> ImageProjection {
        ImageProjection::CubeFace { face, size: [size; 2] }
    }

    /// Returns the projection of a face of a probe; `intrinsics` apply to [`Face::View`] only.
    pub fn of_face(face: Face, size: [u32; 2], intrinsics: [f64; 4]) -> ImageProjection {
        match face {
            Face::View => ImageProjection::Pinhole { size, intrinsics },
            face => ImageProjection::CubeFace { face, size },
        }
    }

    pub fn size(&self) -> [u32; 2] {
        match *self {
            Self::CubeFace { size, .. } | Self::Pinhole { size, .. } | Self::Equirect { size } => size,
        }
    }

    /// Returns forward, right and down of a planar image; `None` for equirectangular images.
    pub fn axes(&self) -> Option<[DVec3; 3]> {
        match *self {
            Self::CubeFace { face, .. } => Some(face.axes()),
            Self::Pinhole { .. } => Some(Face::View.axes()),
            Self::Equirect { .. } => None,
        }
    }

    /// Returns (u, v) of a position in a planar image; 0 for equirectangular images.
    pub fn plane(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match *self {
            Self::CubeFace { size: [width, height], .. } => {
                [(2.0 * x) / f64::from(width) - 1.0, (2.0 * y) / f64::from(height) - 1.0]
            }
            Self::Pinhole { intrinsics: [fx, fy, cx, cy], .. } => [(x - cx) / fx, (y - cy) / fy],
            Self::Equirect { .. } => [0.0; 2],
        }
    }

    /// Returns the position of (u, v) in a planar image; 0 for equirectangular images.
    pub fn position(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        match *self {
            Self::CubeFace { size: [width, height], .. } => {
                [(u + 1.0) * f64::from(width) / 2.0, (v + 1.0) * f64::from(height) / 2.0]
            }
            Self::Pinhole { intrinsics: [fx, fy, cx, cy], .. } => [u * fx + cx, v * fy + cy],
            Self::Equirect { .. } => [0.0; 2],
        }
    }

    /// Returns the direction of a position: of length 1 in equirectangular images, of planar depth 1 in planar ones.
    pub fn unproject(&self, at: [f64; 2]) -> DVec3 {
        let (Some([forward, right, down]), [u, v]) = (self.axes(), self.plane(at)) else {
            let [width, height] = self.size().map(f64::from);
            let lon = (2.0 * at[0] / width - 1.0) * PI;
            let lat = (0.5 - at[1] / height) * PI;
            return DVec3::new(lon.sin() * lat.cos(), lat.sin(), -lon.cos() * lat.cos());
        };
        forward + u * right + v * down
    }

    /// Returns the position of a direction of any length above 0. `None` if the direction is outside the image: behind a pinhole,
    /// beyond its edges, or on another face of the cube. Directions on edges and corners of the cube belong to the first axis in
    /// the order X, Y, Z.
    pub fn project(&self, direction: DVec3) -> Option<[f64; 2]> {
        let [width, height] = self.size().map(f64::from);
        match *self {
            Self::CubeFace { face, .. } => {
                let met = direction_to_face(direction);
                (met.face == face).then(|| self.position(met.plane))
            }
            Self::Pinhole { .. } => {
                let [forward, right, down] = Face::View.axes().map(|axis| direction.dot(axis));
                let [x, y] = self.position([right / forward, down / forward]);
                let is_inside = (0.0..=width).contains(&x) && (0.0..=height).contains(&y);
                (forward > 0.0 && is_inside).then_some([x, y])
            }
            Self::Equirect { .. } => {
                let lon = direction.x.atan2(-direction.z);
                let lat = direction.y.atan2(direction.x.hypot(direction.z));
                Some([(lon / PI + 1.0) * 0.5 * width, (0.5 - lat / PI) * height])
            }
        }
    }

    pub fn pixel_direction(&self, col: u32, row: u32) -> DVec3 {
        self.unproject(centre_of(col, row))
    }

    /// Returns distance divided by planar depth at the centre of a pixel: √(1 + u² + v²), and 1 in equirectangular images.
    pub fn ray_length_factor(&self, col: u32, row: u32) -> f64 {
        let [u, v] = self.plane(centre_of(col, row));
        (1.0 + u * u + v * v).sqrt()
    }
}

pub fn centre_of(col: u32, row: u32) -> [f64; 2] {
    [f64::from(col) + 0.5, f64::from(row) + 0.5]
}

impl Face {
    /// Returns the direction, of planar depth 1, of a pixel centre of a cube face of `size`×`size` pixels.
    pub fn direction(self, col: u32, row: u32, size: u32) -> DVec3 {
        ImageProjection::cube_face(self, size).pixel_direction(col, row)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn sizes() -> impl Strategy<Value = [u32; 2]> {
        [1u32..3000, 1u32..3000]
    }

    fn projections() -> impl Strategy<Value = ImageProjection> {
        let cube =
            (0usize..6, sizes()).prop_map(|(face, size)| ImageProjection::CubeFace { face: Face::CUBE[face], size });
        // Includes principal points outside the image.
        let pinhole =
            (sizes(), [0.05..5.0f64, 0.05..5.0f64], [-2.0..3.0f64, -2.0..3.0f64]).prop_map(|(size, focal, middle)| {
                let [width, height] = size.map(f64::from);
                let intrinsics = [focal[0] * width, focal[1] * height, middle[0] * width, middle[1] * height];
                ImageProjection::Pinhole { size, intrinsics }
            });
        prop_oneof![cube, pinhole, sizes().prop_map(|size| ImageProjection::Equirect { size })]
    }

    /// A position as a fraction of an image's side, including both ends.
    fn share() -> impl Strategy<Value = f64> {
        prop_oneof![8 => 0.0..=1.0f64, 1 => Just(0.0), 1 => Just(1.0), 1 => Just(0.5)]
    }

    proptest! {
        #[test]
        fn projecting_undoes_unprojecting(projection in projections(), at in [share(), share()], length in 1e-3..1e3f64) {
            let [width, height] = projection.size().map(f64::from);
            let at = [at[0] * width, at[1] * height];
            let direction = projection.unproject(at);
            if projection.axes().is_none() {
                prop_assert!((direction.length() - 1.0).abs() < 1e-12);
            }
            // Near the edge, rounding may assign a direction to the neighbouring image or to none.
            let inside = |[x, y]: [f64; 2]| x > 1e-9 * width && x < (1.0 - 1e-9) * width && y > 1e-9 * height && y < (1.0 - 1e-9) * height;
            match projection.project(direction * length) {
                None => prop_assert!(!inside(at) && projection.axes().is_some()),
                Some(found) => {
                    // At the poles all longitudes are the same direction, and positions 0 and W are the same longitude.
                    let cosine = (PI * (0.5 - at[1] / height)).cos();
                    let wraps = projection.axes().is_none();
                    let apart = |a: f64, b: f64, size: f64| {
                        let apart = (a - b).abs() / size;
                        if wraps { apart.min((1.0 - apart).abs()) } else { apart }
                    };
                    let tolerance = if wraps { 1e-12 / cosine.max(1e-12) } else { 1e-10 };
                    prop_assert!(apart(found[0], at[0], width) <= tolerance, "{found:?} {at:?}");
                    prop_assert!((found[1] - at[1]).abs() / height <= 1e-7, "{found:?} {at:?}");
                }
            }
        }

        #[test]
        fn unprojecting_undoes_projecting(projection in projections(), direction in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64], axis in 0usize..9) {
            let mut direction = DVec3::from_array(direction);
            // Project to an axis (a pole), an edge of the cube, or a corner.
            match axis {
                0..3 => direction = DVec3::AXES[axis] * direction.x,
                3 => direction.y = direction.x,
                4 => direction = DVec3::new(direction.x.signum(), direction.y.signum(), direction.z.signum()),
                // Longitude 180°.
                5 => (direction.x, direction.z) = (0.0, direction.z.abs()),
                _ => {}
            }
            prop_assume!(direction.length() > 1e-6);
            if let Some(at) = projection.project(direction) {
                let [width, height] = projection.size().map(f64::from);
                prop_assert!((0.0..=width).contains(&at[0]) && (0.0..=height).contains(&at[1]), "{at:?}");
                prop_assert!(projection.unproject(at).angle_between(direction) < 1e-7);
            }
        }

        #[test]
        fn a_cube_shows_every_direction_once(direction in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64]) {
            let direction = DVec3::from_array(direction);
            prop_assume!(direction != DVec3::ZERO);
            let shown = Face::CUBE.iter().filter(|face| ImageProjection::cube_face(**face, 64).project(direction).is_some());
            prop_assert_eq!(shown.count(), 1);
        }

        #[test]
        fn planar_depth_is_along_the_axis(projection in projections(), pixel in [0u32..4000, 0u32..4000]) {
            if let Some([forward, ..]) = projection.axes() {
                let direction = projection.pixel_direction(pixel[0], pixel[1]);
                prop_assert!((direction.dot(forward) - 1.0).abs() < 1e-9 * direction.length());
                let factor = projection.ray_length_factor(pixel[0], pixel[1]);
                prop_assert!((direction.length() / factor - 1.0).abs() < 1e-12);
            } else {
                prop_assert_eq!(projection.ray_length_factor(pixel[0], pixel[1]), 1.0);
            }
        }
    }

    #[test]
    fn a_pinhole_of_90_degrees_is_a_cube_face() {
        let view = ImageProjection::Pinhole { size: [8, 8], intrinsics: [4.0; 4] };
        let face = ImageProjection::cube_face(Face::Nz, 8);
        for (col, row) in [(0, 0), (3, 1), (7, 7)] {
            assert_eq!(view.ray_length_factor(col, row), face.ray_length_factor(col, row));
            assert_eq!(view.plane(centre_of(col, row)), face.plane(centre_of(col, row)));
        }
        assert_eq!(ImageProjection::cube_face(Face::Px, 1).ray_length_factor(0, 0), 1.0);
        assert!((ImageProjection::cube_face(Face::Px, 1 << 20).ray_length_factor(0, 0) - 3f64.sqrt()).abs() < 1e-5);
    }

    #[test]
    fn a_pinhole_shows_nothing_behind_it_or_beyond_its_edges() {
        let view = ImageProjection::Pinhole { size: [64, 32], intrinsics: [40.0, 41.0, 70.0, 15.0] };
        assert_eq!(view.project(DVec3::NEG_Z), None, "the principal point lies outside");
        assert!(view.project(DVec3::new(-0.5, 0.0, -1.0)).is_some());
        assert_eq!(view.project(DVec3::new(-0.5, 0.0, 1.0)), None);
        assert_eq!(view.project(DVec3::ZERO), None);
        assert_eq!(view.project(DVec3::NAN), None);
    }
}
