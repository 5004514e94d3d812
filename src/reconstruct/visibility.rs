//! Which units of an image cameras see, by testing all or by descending a quadtree (CALF 6.2, table 4).
//!
//! The quadtree's leaves are the units, its inner nodes squares of 2 × 2, 4 × 4, … of them, its root the whole image.
//! A node's frustum holds those of its children, so a camera that misses it misses them all. Beyond the paper, a
//! camera that looks along all directions of a node sees all its units, and asks no further either.

use crate::math::{Sight, Viewer};
use crate::reconstruct::face_image::FaceImage;

/// How an image is cut into units, which are numbered row by row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitGrid {
    /// Width and height of the image in pixels.
    pub size: [u32; 2],
    /// Width and height of a unit in pixels; those in the last column and row are cut off at the image's edge.
    pub unit: [u32; 2],
}

impl UnitGrid {
    /// Columns and rows of units.
    pub fn shape(&self) -> [u32; 2] {
        [self.size[0].div_ceil(self.unit[0]), self.size[1].div_ceil(self.unit[1])]
    }

    /// Pixel (column, row) at which a unit starts, or the image ends.
    fn pixel(&self, at: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|axis| at[axis].saturating_mul(self.unit[axis]).min(self.size[axis]))
    }
}

/// What cameras see of an image.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Culled {
    /// For each unit, the indices of the cameras that see it, in order.
    pub seen_by: Vec<Vec<u32>>,
    /// Tests of a node or unit against a camera.
    pub tests: u64,
}

/// Tests each unit against each camera.
pub fn cull_all(image: &FaceImage, grid: UnitGrid, cameras: &[Viewer]) -> Culled {
    let [columns, rows] = grid.shape();
    let mut culled = Culled::default();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let frustum = image.frustum(grid.pixel([column, row]), grid.pixel([column + 1, row + 1]));
        let sees = |(at, camera): (u32, &Viewer)| (camera.sight(&frustum) != Sight::Missed).then_some(at);
        culled.tests += cameras.len() as u64;
        culled.seen_by.push((0..).zip(cameras).filter_map(sees).collect());
    }
    culled
}

/// Finds the same with fewer tests, by descending the quadtree.
pub fn cull(image: &FaceImage, grid: UnitGrid, cameras: &[Viewer]) -> Culled {
    let [columns, rows] = grid.shape();
    let units = columns as usize * rows as usize;
    let mut descent = Descent { image, grid, cameras, culled: Culled { seen_by: vec![Vec::new(); units], tests: 0 } };
    let level = columns.max(rows).next_power_of_two().trailing_zeros();
    let all: Vec<u32> = (0..).take(cameras.len()).collect();
    descent.visit(Node { level, at: [0, 0] }, &all);
    let mut culled = descent.culled;
    culled.seen_by.iter_mut().for_each(|cameras| cameras.sort_unstable());
    culled
}

/// A square of 2^level × 2^level units, the `at`-th of its level (column, row).
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
    /// Tests a node against the cameras that its parent left.
    fn visit(&mut self, node: Node, cameras: &[u32]) {
        let shape = self.grid.shape();
        let first = node.at.map(|at| at << node.level);
        let end = [0, 1].map(|axis| (first[axis] + (1 << node.level)).min(shape[axis]));
        let frustum = self.image.frustum(self.grid.pixel(first), self.grid.pixel(end));
        let mut left = Vec::new();
        for &camera in cameras {
            self.culled.tests += 1;
            match self.cameras[camera as usize].sight(&frustum) {
                Sight::Missed => {}
                Sight::Partly if node.level > 0 => left.push(camera),
                Sight::Partly | Sight::Inside => self.mark(first, end, camera),
            }
        }
        if left.is_empty() {
            return;
        }
        for child in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let at = [0, 1].map(|axis| 2 * node.at[axis] + child[axis]);
            let level = node.level - 1;
            if at[0] << level < shape[0] && at[1] << level < shape[1] {
                self.visit(Node { level, at }, &left);
            }
        }
    }

    fn mark(&mut self, first: [u32; 2], end: [u32; 2], camera: u32) {
        let columns = self.grid.shape()[0] as usize;
        for row in first[1] as usize..end[1] as usize {
            let of_row = row * columns + first[0] as usize..row * columns + end[0] as usize;
            self.culled.seen_by[of_row].iter_mut().for_each(|seen_by| seen_by.push(camera));
        }
    }
}
