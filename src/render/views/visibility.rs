//! Units of an image that cameras see, found by testing all units or by descending a quadtree (CALF 6.2, table 4).
//!
//! The leaves of the quadtree are the units, its inner nodes are squares of 2 × 2, 4 × 4, … units, and its root is the whole
//! image. The frustum of a node contains those of its children, so a camera that misses the node misses all of them. Beyond the
//! paper, a camera that sees all directions of a node sees all its units without further tests.

use crate::views::FaceImage;
use codec::math::{Sight, Viewer};

/// Division of an image into units, which are numbered row by row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitGrid {
    /// Width and height of the image in pixels.
    pub size: [u32; 2],
    /// Width and height of a unit in pixels; units in the last column and row are cut off at the image's edge.
    pub unit: [u32; 2],
}

impl UnitGrid {
    /// Returns the number of columns and rows of units.
    pub fn shape(&self) -> [u32; 2] {
        [self.size[0].div_ceil(self.unit[0]), self.size[1].div_ceil(self.unit[1])]
    }

    /// Returns the pixel (column, row) at which a unit starts, or at which the image ends.
    fn pixel(&self, at: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|axis| at[axis].saturating_mul(self.unit[axis]).min(self.size[axis]))
    }
}

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Culled {
    /// For each unit, the index of the first camera that sees it, if any.
    pub seen_by: Vec<Option<u32>>,
    /// Number of tests of a node or unit against a camera.
    pub tests: u64,
}

impl Culled {
    /// Returns the number of tests that [`cull_all`] makes for the same result with this number of cameras.
    pub fn regular_tests(&self, cameras: usize) -> u64 {
        self.seen_by.iter().map(|first| first.map_or(cameras as u64, |first| u64::from(first) + 1)).sum()
    }
}

/// Tests each unit against the cameras in order, up to the first that sees it.
pub fn cull_all(image: &FaceImage, grid: UnitGrid, cameras: &[Viewer]) -> Culled {
    let [columns, rows] = grid.shape();
    let mut culled = Culled::default();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let frustum = image.frustum(grid.pixel([column, row]), grid.pixel([column + 1, row + 1]));
        let mut first = None;
        for (at, camera) in (0..).zip(cameras) {
            culled.tests += 1;
            if camera.sight(&frustum) != Sight::Missed {
                first = Some(at);
                break;
            }
        }
        culled.seen_by.push(first);
    }
    culled
}

/// Returns the same result as [`cull_all`] with fewer tests, by descending the quadtree.
///
/// A node is also tested up to the first camera that sees it. Its children are tested against this camera and those after it; the
/// cameras before it miss all children.
pub fn cull(image: &FaceImage, grid: UnitGrid, cameras: &[Viewer]) -> Culled {
    let [columns, rows] = grid.shape();
    let units = columns as usize * rows as usize;
    let mut descent = Descent { image, grid, cameras, culled: Culled { seen_by: vec![None; units], tests: 0 } };
    let level = columns.max(rows).next_power_of_two().trailing_zeros();
    descent.visit(Node { level, at: [0, 0] }, 0);
    descent.culled
}

/// A square of 2^level × 2^level units, at position `at` (column, row) of its level.
#[derive(Clone, Copy)]
struct Node {
    level: u32,
    at: [u32; 2],
}

struct Descent<'a> {
    image: &'a FaceImage,
    grid: UnitGrid,
    cameras: &'a [Viewer],
    culled: Culled,
}

impl Descent<'_> {
    /// Tests a node against the cameras from `first` on.
    fn visit(&mut self, node: Node, first: usize) {
        let shape = self.grid.shape();
        let start = node.at.map(|at| at << node.level);
        let end = [0, 1].map(|axis| (start[axis] + (1 << node.level)).min(shape[axis]));
        let frustum = self.image.frustum(self.grid.pixel(start), self.grid.pixel(end));
        for (at, camera) in self.cameras.iter().enumerate().skip(first) {
            self.culled.tests += 1;
            match camera.sight(&frustum) {
                Sight::Missed => {}
                Sight::Partly if node.level > 0 => return self.visit_children(node, at),
                Sight::Partly | Sight::Inside => return self.mark(start, end, at as u32),
            }
        }
    }

    fn visit_children(&mut self, node: Node, first: usize) {
        let shape = self.grid.shape();
        let level = node.level - 1;
        for child in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let at = [0, 1].map(|axis| 2 * node.at[axis] + child[axis]);
            if at[0] << level < shape[0] && at[1] << level < shape[1] {
                self.visit(Node { level, at }, first);
            }
        }
    }

    fn mark(&mut self, start: [u32; 2], end: [u32; 2], camera: u32) {
        let columns = self.grid.shape()[0] as usize;
        for row in start[1] as usize..end[1] as usize {
            self.culled.seen_by[row * columns..][start[0] as usize..end[0] as usize].fill(Some(camera));
        }
    }
}
