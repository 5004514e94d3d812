//! The six faces of an OpenGL cube map in a right-handed world with +Y up: names, axes, and the face that a direction intersects.
//! [`super::projection`] computes the directions of pixels.

use glam::DVec3;

/// One face of a cube map, or the single view of a perspective camera.
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
    /// The six faces of a cube map, in the order of their indices.
    pub const CUBE: [Face; 6] = [Face::Px, Face::Nx, Face::Py, Face::Ny, Face::Pz, Face::Nz];

    /// Returns the name used in file names: `px`, `nx`, `py`, `ny`, `pz`, `nz`; `view` for a perspective image.
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

    /// Returns the face with that name, or `None`.
    pub fn from_name(name: &str) -> Option<Face> {
        Face::CUBE.into_iter().chain([Face::View]).find(|face| face.name() == name)
    }

    /// Returns the face with that index (container.md 5), or `None`.
    pub fn from_index(index: u8) -> Option<Face> {
        Face::CUBE.into_iter().chain([Face::View]).find(|face| *face as u8 == index)
    }

    /// Returns the unit vectors forward, right and down. [`Face::View`] looks along −Z with +Y up.
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
}

/// Intersection of a direction with a cube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacePoint {
    pub face: Face,
    /// u and v in the plane of the face at distance 1, each in −1..1.
    pub plane: [f64; 2],
}

/// Returns the point of the cube that a direction of any length intersects. On an edge or corner the first axis in the order X,
/// Y, Z is chosen. The zero vector gives the centre of +X.
pub fn direction_to_face(direction: DVec3) -> FacePoint {
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
    if depth > 0.0 {
        FacePoint { face, plane: [direction.dot(right) / depth, direction.dot(down) / depth] }
    } else {
        FacePoint { face: Face::Px, plane: [0.0; 2] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_those_of_opengl() {
        // Major axis, then the axes of s and t, as in the cube map selection table of the OpenGL specification.
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
            // Cube maps are viewed from outside: every face is mirrored, unlike a camera image.
            assert_eq!(axes[1].cross(axes[2]), -axes[0], "{face:?}");
        }
    }

    #[test]
    fn seams_meet() {
        // A step across an edge of a face reaches another face, near its edge.
        let size = 16;
        for face in Face::CUBE {
            let [forward, right, down] = face.axes();
            for step in 0..size {
                let t = (2.0 * f64::from(step) + 1.0) / f64::from(size) - 1.0;
                let beyond = 1.0 + 1.0 / f64::from(size);
                for (u, v) in [(beyond, t), (-beyond, t), (t, beyond), (t, -beyond)] {
                    let FacePoint { face: next, plane: [nu, nv] } = direction_to_face(forward + u * right + v * down);
                    assert_ne!(next, face);
                    let edge = nu.abs().max(nv.abs());
                    assert!(edge > 1.0 - 2.0 / f64::from(size) && edge <= 1.0, "{face:?} -> {next:?} {nu} {nv}");
                }
            }
        }
    }
}
