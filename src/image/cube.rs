//! The six faces of a cube map and the directions of their pixels.
//!
//! Orientation is that of OpenGL cube maps, in a right-handed world with +Y up. Pixel (col, row), row 0 first in
//! the file: u = 2(col + 0.5)/N − 1, v = 2(row + 0.5)/N − 1, direction = forward + u·right + v·down.

use glam::DVec3;

/// What a stream looks through: one face of a cube map, or the single view of a perspective camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Face {
    /// +X
    Px = 0,
    /// −X
    Nx = 1,
    /// +Y (up)
    Py = 2,
    /// −Y
    Ny = 3,
    /// +Z
    Pz = 4,
    /// −Z
    Nz = 5,
    /// The only image of a perspective probe, or of a stream without a projection.
    View = 6,
}

impl Face {
    /// The six faces of a cube map, in the order of their numbers.
    pub const CUBE: [Face; 6] = [Face::Px, Face::Nx, Face::Py, Face::Ny, Face::Pz, Face::Nz];

    /// Two letters, as in file names: `px`, `nx`, `py`, `ny`, `pz`, `nz`; `view` for a perspective image.
    pub fn name(self) -> &'static str {
        match self {
            Face::Px => "px",
            Face::Nx => "nx",
            Face::Py => "py",
            Face::Ny => "ny",
            Face::Pz => "pz",
            Face::Nz => "nz",
            Face::View => "view",
        }
    }

    /// The face of that name, if there is one.
    pub fn from_name(name: &str) -> Option<Face> {
        Face::CUBE.into_iter().chain([Face::View]).find(|face| face.name() == name)
    }

    /// The face of that number (container.md 5), if there is one.
    pub fn from_index(index: u8) -> Option<Face> {
        Face::CUBE.into_iter().chain([Face::View]).find(|face| *face as u8 == index)
    }

    /// Forward, right and down of a cube face.
    ///
    /// [`Face::View`] answers as a camera that looks along −Z with +Y up.
    pub fn axes(self) -> [DVec3; 3] {
        match self {
            Face::Px => [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y],
            Face::Nx => [DVec3::NEG_X, DVec3::Z, DVec3::NEG_Y],
            Face::Py => [DVec3::Y, DVec3::X, DVec3::Z],
            Face::Ny => [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z],
            Face::Pz => [DVec3::Z, DVec3::X, DVec3::NEG_Y],
            Face::Nz => [DVec3::NEG_Z, DVec3::NEG_X, DVec3::NEG_Y],
            Face::View => [DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y],
        }
    }

    /// Direction, not normalised, of the centre of pixel (col, row) of a face of `size`×`size` pixels.
    pub fn direction(self, col: u32, row: u32, size: u32) -> DVec3 {
        let [forward, right, down] = self.axes();
        let (u, v) = (pixel_to_plane(col, size), pixel_to_plane(row, size));
        forward + u * right + v * down
    }
}

/// The coordinate in −1..1 on the image plane of the centre of a pixel.
pub fn pixel_to_plane(pixel: u32, size: u32) -> f64 {
    (2.0 * (f64::from(pixel) + 0.5)) / f64::from(size) - 1.0
}

/// The point (u, v), each in −1..1, on the image plane of the cube face that a direction goes through.
///
/// On an edge or corner the axis that comes first in X, Y, Z wins. The zero vector answers as +X would.
pub fn direction_to_face(direction: DVec3) -> (Face, f64, f64) {
    let size = direction.abs();
    let pick = |component: f64, positive: Face, negative: Face| if component < 0.0 { negative } else { positive };
    let face = if size.x >= size.y && size.x >= size.z {
        pick(direction.x, Face::Px, Face::Nx)
    } else if size.y >= size.z {
        pick(direction.y, Face::Py, Face::Ny)
    } else {
        pick(direction.z, Face::Pz, Face::Nz)
    };
    let [forward, right, down] = face.axes();
    let depth = direction.dot(forward);
    if depth > 0.0 { (face, direction.dot(right) / depth, direction.dot(down) / depth) } else { (Face::Px, 0.0, 0.0) }
}

/// What planar depth (Z along the viewing axis) at pixel (col, row) of a cube face of `size`×`size` pixels is to be
/// multiplied with to get the distance from the centre: √(1 + u² + v²), in 1..√3.
pub fn distance_from_planar(col: u32, row: u32, size: u32) -> f64 {
    let (u, v) = (pixel_to_plane(col, size), pixel_to_plane(row, size));
    (1.0 + u * u + v * v).sqrt()
}

/// The same factor for a perspective image with `intrinsics` fx, fy, cx, cy in pixels.
///
/// The centre of pixel (col, row) is at (col + 0.5, row + 0.5), so that the middle of an image of width w is cx = w/2.
pub fn distance_from_planar_view(col: u32, row: u32, intrinsics: [f64; 4]) -> f64 {
    let [fx, fy, cx, cy] = intrinsics;
    let u = (f64::from(col) + 0.5 - cx) / fx;
    let v = (f64::from(row) + 0.5 - cy) / fy;
    (1.0 + u * u + v * v).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_those_of_opengl() {
        // Major axis, then the axes of s and t, as the cube map selection table of the OpenGL specification has them.
        let table = [
            (Face::Px, [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y]),
            (Face::Nx, [DVec3::NEG_X, DVec3::Z, DVec3::NEG_Y]),
            (Face::Py, [DVec3::Y, DVec3::X, DVec3::Z]),
            (Face::Ny, [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z]),
            (Face::Pz, [DVec3::Z, DVec3::X, DVec3::NEG_Y]),
            (Face::Nz, [DVec3::NEG_Z, DVec3::NEG_X, DVec3::NEG_Y]),
        ];
        for (face, axes) in table {
            assert_eq!(face.axes(), axes, "{face:?}");
            // Cube maps are seen from outside: every face is mirrored, unlike a camera's image.
            assert_eq!(axes[1].cross(axes[2]), -axes[0], "{face:?}");
        }
    }

    #[test]
    fn directions_come_back_to_their_pixel() {
        for size in [1u32, 2, 3, 64] {
            for face in Face::CUBE {
                for (row, col) in (0..size).flat_map(|row| (0..size).map(move |col| (row, col))) {
                    let (found, u, v) = direction_to_face(face.direction(col, row, size) * 7.5);
                    assert_eq!(found, face);
                    assert!((u - pixel_to_plane(col, size)).abs() < 1e-12);
                    assert!((v - pixel_to_plane(row, size)).abs() < 1e-12);
                }
            }
        }
        assert_eq!(direction_to_face(DVec3::ZERO), (Face::Px, 0.0, 0.0));
    }

    #[test]
    fn seams_meet() {
        // A step across any edge of any face lands on a neighbour, at that neighbour's edge.
        let size = 16;
        for face in Face::CUBE {
            let [forward, right, down] = face.axes();
            for step in 0..size {
                let t = pixel_to_plane(step, size);
                let beyond = 1.0 + 1.0 / f64::from(size);
                for (u, v) in [(beyond, t), (-beyond, t), (t, beyond), (t, -beyond)] {
                    let (next, nu, nv) = direction_to_face(forward + u * right + v * down);
                    assert_ne!(next, face);
                    let edge = nu.abs().max(nv.abs());
                    assert!(edge > 1.0 - 2.0 / f64::from(size) && edge <= 1.0, "{face:?} -> {next:?} {nu} {nv}");
                }
            }
        }
    }

    #[test]
    fn planar_factors() {
        assert_eq!(distance_from_planar(0, 0, 1), 1.0);
        assert!((distance_from_planar(0, 0, 1 << 20) - 3f64.sqrt()).abs() < 1e-5);
        // 90 degrees across is the same picture as a cube face.
        for (col, row) in [(0, 0), (3, 1), (7, 7)] {
            let view = distance_from_planar_view(col, row, [4.0, 4.0, 4.0, 4.0]);
            assert!((view - distance_from_planar(col, row, 8)).abs() < 1e-15);
        }
    }
}
