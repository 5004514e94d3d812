//! The image model in single precision, as renderers evaluate it per ray.
//!
//! Follows the conventions of [`super::projection`]; positions differ by less than 10⁻⁶ of the side of the image (tested).
//! `march::packet` and shaders/march/light_field.wgsl perform the same operations in the same order.

use glam::Vec3;

use super::cube::Face;

/// Map from (u, v) to a position in a planar image: `[u, v] · scale + centre`, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TexelMap {
    /// Pixels per unit of u and v.
    pub scale: [f32; 2],
    /// Position of u = v = 0, in pixels.
    pub centre: [f32; 2],
}

impl TexelMap {
    /// Returns the map of a face of a probe, as [`ImageProjection::of_face`](super::ImageProjection::of_face) does.
    pub fn of_face(face: Face, size: [u32; 2], intrinsics: [f64; 4]) -> TexelMap {
        match face {
            Face::View => {
                let [fx, fy, cx, cy] = intrinsics.map(|value| value as f32);
                TexelMap { scale: [fx, fy], centre: [cx, cy] }
            }
            _ => TexelMap::cube_face(size),
        }
    }

    pub fn cube_face(size: [u32; 2]) -> TexelMap {
        let half = size.map(|pixels| pixels as f32 / 2.0);
        TexelMap { scale: half, centre: half }
    }

    pub fn plane(&self, at: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|axis| (at[axis] - self.centre[axis]) / self.scale[axis])
    }

    pub fn position(&self, plane: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|axis| plane[axis] * self.scale[axis] + self.centre[axis])
    }

    pub fn ray_length_factor(&self, col: u32, row: u32) -> f32 {
        let [u, v] = self.plane([col, row].map(|at| at as f32 + 0.5));
        (1.0 + u * u + v * v).sqrt()
    }

    /// Returns the direction, of planar depth 1, of a position in the image of a face.
    pub fn direction(&self, face: Face, at: [f32; 2]) -> Vec3 {
        let [forward, right, down] = face.axes().map(|axis| axis.as_vec3());
        let [u, v] = self.plane(at);
        forward + u * right + v * down
    }
}

/// A point relative to a probe, projected to the image plane of the face that contains it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarPoint {
    /// Index of the face ([`Face`]).
    pub face: usize,
    pub plane: [f32; 2],
    /// Depth along the axis of the face, in the unit of the point.
    pub planar: f32,
}

impl PlanarPoint {
    /// Projects a point to a cube, as [`super::cube::direction_to_face`] does.
    pub fn on_cube(x: Vec3) -> PlanarPoint {
        let size = x.abs();
        let (face, planar, [u, v]) = if size.x >= size.y && size.x >= size.z {
            if x.x < 0.0 { (1, size.x, [x.z, -x.y]) } else { (0, size.x, [-x.z, -x.y]) }
        } else if size.y >= size.z {
            if x.y < 0.0 { (3, size.y, [x.x, -x.z]) } else { (2, size.y, [x.x, x.z]) }
        } else if x.z < 0.0 {
            (5, size.z, [-x.x, -x.y])
        } else {
            (4, size.z, [x.x, -x.y])
        };
        let inverse = 1.0 / planar;
        PlanarPoint { face, plane: [u * inverse, v * inverse], planar }
    }

    /// Projects a point to a pinhole image; `None` if it is behind the camera.
    pub fn in_view(x: Vec3) -> Option<PlanarPoint> {
        let inverse = 1.0 / -x.z;
        let plane = [x.x * inverse, -x.y * inverse];
        (x.z < 0.0).then_some(PlanarPoint { face: Face::View as usize, plane, planar: -x.z })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::*;
    use crate::image::cube::direction_to_face;
    use crate::image::projection::ImageProjection;

    fn coordinate() -> impl Strategy<Value = f32> {
        prop_oneof![6 => -100.0..100.0f32, 1 => Just(1.0), 1 => Just(-1.0), 1 => Just(0.0)]
    }

    proptest! {
        #[test]
        fn faces_are_those_of_the_model(x in [coordinate(), coordinate(), coordinate()]) {
            let x = Vec3::from_array(x);
            prop_assume!(x != Vec3::ZERO);
            let (found, expected) = (PlanarPoint::on_cube(x), direction_to_face(x.as_dvec3()));
            prop_assert_eq!(found.face, expected.face as usize);
            prop_assert_eq!(found.planar, x.abs().max_element());
            for axis in 0..2 {
                prop_assert!((f64::from(found.plane[axis]) - expected.plane[axis]).abs() < 2e-7);
            }
        }

        #[test]
        fn positions_are_those_of_the_model(
            size in [1u32..8192, 1u32..8192],
            focal in [0.1..4.0f32, 0.1..4.0f32],
            middle in [-1.0..2.0f32, -1.0..2.0f32],
            at in [0.0..=1.0f64, 0.0..=1.0f64],
        ) {
            let sides = size.map(|side| side as f32);
            let intrinsics = [focal[0] * sides[0], focal[1] * sides[1], middle[0] * sides[0], middle[1] * sides[1]].map(f64::from);
            for face in [Face::Ny, Face::View] {
                let projection = ImageProjection::of_face(face, size, intrinsics);
                let map = TexelMap::of_face(face, size, intrinsics);
                let exact = [at[0] * f64::from(size[0]), at[1] * f64::from(size[1])];
                let direction: DVec3 = projection.unproject(exact);
                let point = match face {
                    Face::View => PlanarPoint::in_view(direction.as_vec3()),
                    _ => Some(PlanarPoint::on_cube(direction.as_vec3())),
                };
                // On an edge of the cube, rounding may assign a point to the neighbouring face.
                let Some(point) = point.filter(|point| point.face == face as usize) else { continue };
                let found = map.position(point.plane);
                // The rounding error grows with the distance from the principal point.
                for axis in 0..2 {
                    let error = (f64::from(found[axis]) - exact[axis]).abs() / f64::from(size[axis]);
                    prop_assert!(error < 1e-6, "{error} {found:?} {exact:?}");
                }
                let (col, row) = (exact[0] as u32, exact[1] as u32);
                let factor = projection.ray_length_factor(col, row);
                prop_assert!((f64::from(map.ray_length_factor(col, row)) / factor - 1.0).abs() < 3e-6);
                let way = map.direction(face, [col as f32 + 0.5, row as f32 + 0.5]).as_dvec3();
                prop_assert!(way.angle_between(projection.pixel_direction(col, row)) < 3e-6);
            }
        }
    }
}
