//! Images that hold all six faces of a cube (crosses and strips), and images that hold both eyes of a stereo pair.
//!
//! ```text
//! cross 4:3          cross 3:4           strips 6:1, 1:6
//!     py                 py              px nx py ny pz nz
//!  nx pz px nz        nx pz px           (left to right, or top to bottom)
//!     ny                 ny
//!                        nz, turned by 180°
//! ```
//! All other faces have the orientation of [`Face::axes`], so that neighbours in a cross join seamlessly.

use super::cube::Face;
use super::plane::Plane;
use crate::error::{Error, Result};

/// Layout of the six faces; the orientation follows from the aspect ratio of the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaceLayout {
    /// An unfolded cube, 4:3 or 3:4.
    Cross,
    /// A row or column in the order px, nx, py, ny, pz, nz.
    Strip,
}

struct Cells {
    columns: u32,
    rows: u32,
    /// Column and row of each face, in the order of [`Face::CUBE`].
    places: [[u32; 2]; 6],
    /// The face that is rotated by 180°.
    turned: Option<Face>,
}

fn cells(layout: FaceLayout, width: u32, height: u32) -> Cells {
    let lying = width > height;
    let (columns, rows) = match layout {
        FaceLayout::Cross if lying => (4, 3),
        FaceLayout::Cross => (3, 4),
        FaceLayout::Strip if lying => (6, 1),
        FaceLayout::Strip => (1, 6),
    };
    let strip = [0, 1, 2, 3, 4, 5].map(|at| if lying { [at, 0] } else { [0, at] });
    let nz = if lying { [3, 1] } else { [1, 3] };
    match layout {
        FaceLayout::Cross => {
            let places = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], nz];
            Cells { columns, rows, places, turned: (!lying).then_some(Face::Nz) }
        }
        FaceLayout::Strip => Cells { columns, rows, places: strip, turned: None },
    }
}

/// Returns the side of a face in pixels. Fails if the image does not have the aspect ratio of the layout.
pub fn face_size(layout: FaceLayout, width: u32, height: u32) -> Result<u32> {
    let Cells { columns, rows, .. } = cells(layout, width, height);
    let size = width / columns;
    if size > 0
        && u64::from(size) * u64::from(columns) == u64::from(width)
        && u64::from(size) * u64::from(rows) == u64::from(height)
    {
        return Ok(size);
    }
    let shapes = match layout {
        FaceLayout::Cross => "a cube cross is 4:3 or 3:4",
        FaceLayout::Strip => "a cube strip is 6:1 or 1:6",
    };
    Err(Error::invalid(format!("{shapes}, this image is {width}x{height}")))
}

/// Arrangement of the images of both eyes in one image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "encode", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum StereoLayout {
    /// The left eye above the right eye.
    OverUnder,
    /// The left eye to the left of the right eye.
    SideBySide,
}

impl StereoLayout {
    /// Returns the name used in manifests.
    pub fn name(self) -> &'static str {
        if self == StereoLayout::OverUnder { "over-under" } else { "side-by-side" }
    }
}

/// An eye of a stereo image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "encode", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Eye {
    Left,
    Right,
}

/// Returns the size of the image of one eye; `None` if the side of the image is odd or 0.
pub fn eye_size(layout: StereoLayout, [width, height]: [u32; 2]) -> Option<[u32; 2]> {
    match layout {
        StereoLayout::OverUnder => (height % 2 == 0 && height > 0).then_some([width, height / 2]),
        StereoLayout::SideBySide => (width % 2 == 0 && width > 0).then_some([width / 2, height]),
    }
}

/// Returns the image of one eye.
pub fn cut_eye<T: Copy>(image: &Plane<T>, layout: StereoLayout, eye: Eye) -> Result<Plane<T>> {
    let [width, height] = [image.width(), image.height()];
    let size = eye_size(layout, [width, height])
        .ok_or_else(|| Error::invalid(format!("an image of {width}x{height} pixels cannot be halved for two eyes")))?;
    let origin = match (eye, layout) {
        (Eye::Left, _) => [0, 0],
        (Eye::Right, StereoLayout::OverUnder) => [0, size[1]],
        (Eye::Right, StereoLayout::SideBySide) => [size[0], 0],
    };
    Ok(image.cut(origin, size))
}

/// Returns the six faces, in the order of [`Face::CUBE`].
pub fn cut_faces<T: Copy>(image: &Plane<T>, layout: FaceLayout) -> Result<Vec<Plane<T>>> {
    let size = face_size(layout, image.width(), image.height())?;
    let Cells { places, turned, .. } = cells(layout, image.width(), image.height());
    let cut = |face: Face| {
        let [column, row] = places[face as usize];
        Plane::from_fn(size, size, |x, y| {
            let (x, y) = if turned == Some(face) { (size - 1 - x, size - 1 - y) } else { (x, y) };
            image.get(column * size + x, row * size + y)
        })
    };
    Ok(Face::CUBE.into_iter().map(cut).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_in_a_cross_join() {
        // Each pixel holds its direction. In a cross, directions of neighbouring pixels differ little, also across the edge of
        // two faces.
        let size = 8;
        for (layout, columns, rows) in [(FaceLayout::Cross, 4, 3), (FaceLayout::Cross, 3, 4)] {
            let mut image = Plane::filled(columns * size, rows * size, None);
            let Cells { places, turned, .. } = cells(layout, image.width(), image.height());
            for face in Face::CUBE {
                let [column, row] = places[face as usize];
                for (y, x) in (0..size).flat_map(|y| (0..size).map(move |x| (y, x))) {
                    let (px, py) = if turned == Some(face) { (size - 1 - x, size - 1 - y) } else { (x, y) };
                    let at = ((row * size + py) * columns * size + column * size + px) as usize;
                    image.data_mut()[at] = Some(face.direction(x, y, size).normalize());
                }
            }
            let mut joined = 0;
            for y in 0..image.height() {
                for x in 1..image.width() {
                    // The lower nz of a 3:4 cross has no horizontal neighbour; all neighbours must join.
                    if let (Some(a), Some(b)) = (image.get(x - 1, y), image.get(x, y)) {
                        assert!(a.distance(b) < 0.3, "{columns}: {x},{y}");
                        joined += 1;
                    }
                }
            }
            for y in 1..image.height() {
                for x in 0..image.width() {
                    if let (Some(a), Some(b)) = (image.get(x, y - 1), image.get(x, y)) {
                        assert!(a.distance(b) < 0.3, "{columns}: {x},{y}");
                        joined += 1;
                    }
                }
            }
            assert!(joined > 0);
            let faces = cut_faces(&image, layout).unwrap();
            for (face, plane) in Face::CUBE.into_iter().zip(&faces) {
                assert_eq!(plane.get(3, 5), Some(face.direction(3, 5, size).normalize()), "{face:?}");
            }
        }
    }

    #[test]
    fn eyes_are_halves() {
        let image = Plane::from_fn(4, 2, |x, y| 10 * y + x);
        let cut = |layout, eye| cut_eye(&image, layout, eye).unwrap().into_data();
        assert_eq!(cut(StereoLayout::OverUnder, Eye::Left), [0, 1, 2, 3]);
        assert_eq!(cut(StereoLayout::OverUnder, Eye::Right), [10, 11, 12, 13]);
        assert_eq!(cut(StereoLayout::SideBySide, Eye::Left), [0, 1, 10, 11]);
        assert_eq!(cut(StereoLayout::SideBySide, Eye::Right), [2, 3, 12, 13]);
        assert!(cut_eye(&Plane::filled(3, 3, 0), StereoLayout::OverUnder, Eye::Left).is_err());
    }

    #[test]
    fn strips_and_shapes() {
        for (width, height) in [(6, 1), (1, 6)] {
            let faces = cut_faces(&Plane::from_fn(width, height, |x, y| x + y), FaceLayout::Strip).unwrap();
            assert_eq!(faces.iter().map(|face| face.get(0, 0)).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
        }
        for (width, height) in [(0, 0), (1, 1), (4, 4), (8, 3), (5, 4), (1 << 31, 3)] {
            assert!(face_size(FaceLayout::Cross, width, height).is_err());
        }
        assert!(face_size(FaceLayout::Strip, 12, 1).is_err());
        assert_eq!(face_size(FaceLayout::Cross, 9, 12).unwrap(), 3);
    }
}
