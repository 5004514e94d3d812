//! Quadtrees over the faces of a cube around the centre of the viewing region (Seurat 4).
//!
//! A tree cell is a square of a face; the rays from the centre through it form a frustum. Coordinates in a face are those of its
//! plane at distance 1, from −1 to 1, as returned by [`codec::image::cube::direction_to_face`].

use glam::DVec3;

use codec::image::Face;
use codec::image::cube::{FacePoint, direction_to_face};

/// Finest level of the trees: cells of 1/128 of a face, 0.9 degrees.
pub const MAX_LEVEL: u32 = 7;

/// A square of a cube face. `column` and `row` count the squares of its level, which has 2^level squares a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TreeCell {
    pub face: Face,
    pub level: u32,
    pub column: u32,
    pub row: u32,
}

/// A rectangle in the plane of a face: minimum u and v, maximum u and v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneRect {
    pub min: [f64; 2],
    pub max: [f64; 2],
}

impl TreeCell {
    pub const ROOTS: [TreeCell; 6] =
        [root(Face::Px), root(Face::Nx), root(Face::Py), root(Face::Ny), root(Face::Pz), root(Face::Nz)];

    /// Returns the cell of a level that contains a direction of any length.
    pub fn containing(direction: DVec3, level: u32) -> TreeCell {
        let FacePoint { face, plane } = direction_to_face(direction);
        let side = 1 << level;
        let [column, row] = plane.map(|at| ((0.5 * (at + 1.0) * f64::from(side)) as u32).min(side - 1));
        TreeCell { face, level, column, row }
    }

    /// Returns the four cells of the next level: rows from the top, from left to right.
    pub fn children(self) -> [TreeCell; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, below]| TreeCell {
            face: self.face,
            level: self.level + 1,
            column: 2 * self.column + right,
            row: 2 * self.row + below,
        })
    }

    /// Returns true if the other cell is this one or lies in it.
    pub fn contains(self, other: TreeCell) -> bool {
        let above = other.level.checked_sub(self.level);
        let at = [(self.column, other.column), (self.row, other.row)];
        self.face == other.face && above.is_some_and(|above| at.iter().all(|(mine, other)| other >> above == *mine))
    }

    /// Returns the index among the cells of all faces of the level.
    pub fn index(self) -> usize {
        let side = 1 << self.level;
        ((self.face as usize) * side + self.row as usize) * side + self.column as usize
    }

    /// Returns the cell of an index.
    pub fn at(level: u32, index: usize) -> TreeCell {
        let side = 1usize << level;
        let face = Face::CUBE[(index / (side * side)).min(5)];
        TreeCell { face, level, column: (index % side) as u32, row: (index / side % side) as u32 }
    }

    /// Returns the number of cells of all faces of a level.
    pub fn count(level: u32) -> usize {
        6 << (2 * level)
    }

    /// Returns the side of the cell in the plane of its face.
    pub fn side(self) -> f64 {
        2.0 / f64::from(1u32 << self.level)
    }

    /// Returns the square of the cell, enlarged on each side by `margin` in the plane of its face.
    pub fn rect(self, margin: f64) -> PlaneRect {
        let side = self.side();
        let least = [self.column, self.row].map(|at| f64::from(at) * side - 1.0);
        PlaneRect { min: least.map(|at| at - margin), max: least.map(|at| at + side + margin) }
    }
}

const fn root(face: Face) -> TreeCell {
    TreeCell { face, level: 0, column: 0, row: 0 }
}

impl PlaneRect {
    /// Returns the corners in clockwise order: left to right at the top, then right to left at the bottom.
    pub fn corners(self) -> [[f64; 2]; 4] {
        let ([left, top], [right, bottom]) = (self.min, self.max);
        [[left, top], [right, top], [right, bottom], [left, bottom]]
    }

    pub fn contains(self, [u, v]: [f64; 2]) -> bool {
        (self.min[0]..=self.max[0]).contains(&u) && (self.min[1]..=self.max[1]).contains(&v)
    }

    pub fn longer_side(self) -> f64 {
        (self.max[0] - self.min[0]).max(self.max[1] - self.min[1])
    }

    /// Returns the smallest rectangle around both.
    pub fn join(self, other: PlaneRect) -> PlaneRect {
        PlaneRect {
            min: [0, 1].map(|axis| self.min[axis].min(other.min[axis])),
            max: [0, 1].map(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    /// Returns the solid angle of the rectangle in steradians, as seen from the centre of the cube.
    pub fn solid_angle(self) -> f64 {
        let corner = |u: f64, v: f64| (u * v).atan2((u * u + v * v + 1.0).sqrt());
        let ([left, top], [right, bottom]) = (self.min, self.max);
        corner(right, bottom) - corner(left, bottom) - corner(right, top) + corner(left, top)
    }
}

/// Returns the direction through a point of a face; its component along the face's axis is 1.
pub fn direction(face: Face, [u, v]: [f64; 2]) -> DVec3 {
    let [forward, right, down] = face.axes();
    forward + u * right + v * down
}

/// Returns the point at which a direction meets the plane of a face; `None` if it leads away from the face.
pub fn project(face: Face, direction: DVec3) -> Option<[f64; 2]> {
    let [forward, right, down] = face.axes();
    let depth = direction.dot(forward);
    (depth > 0.0).then(|| [direction.dot(right) / depth, direction.dot(down) / depth])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_partition_the_sphere() {
        for level in [0, 3] {
            let cells = (0..TreeCell::count(level)).map(|index| TreeCell::at(level, index));
            let mut sum = 0.0;
            for cell in cells {
                assert_eq!(TreeCell::at(level, cell.index()), cell);
                let rect = cell.rect(0.0);
                sum += rect.solid_angle();
                let middle = [0, 1].map(|axis| 0.5 * (rect.min[axis] + rect.max[axis]));
                assert_eq!(TreeCell::containing(direction(cell.face, middle), level), cell);
                for child in cell.children() {
                    let [inner, outer] = [child.rect(0.0), cell.rect(0.0)];
                    assert!(outer.contains(inner.min) && outer.contains(inner.max));
                }
            }
            assert!((sum - 4.0 * std::f64::consts::PI).abs() < 1e-12, "{sum}");
        }
    }
}
