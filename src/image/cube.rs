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
            Face::Nz | Face::View => [DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y],
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
