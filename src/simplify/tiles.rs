//! The selected quad tiles: corners, drawing order, and what rays meet.

use glam::DVec3;

use super::candidates::CandidateLevel;
use super::cost::CostModel;
use super::fit::TilePlane;
use super::selection::SelectedTiling;
use super::tree::{MAX_LEVEL, PlaneRect, TreeCell, direction, project};
use crate::image::Face;
use crate::mesh::{Bvh, Ray};

/// A quad tile: the part of a plane inside the dilated frustum of a tree cell (Seurat 4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadTile {
    pub cell: TreeCell,
    pub plane: TilePlane,
    /// Its square in the plane of the face, dilated. Corners of its texture are texel centres at the corners of it.
    pub rect: PlaneRect,
    /// Columns and rows of quads that it is drawn as.
    pub divisions: [u32; 2],
}

impl QuadTile {
    /// A point of the tile, relative to the middle of the region, metres.
    pub fn point(&self, at: [f64; 2]) -> DVec3 {
        let direction = direction(self.cell.face, at);
        direction * self.plane.hit(direction)
    }

    pub fn corners(&self) -> [DVec3; 4] {
        self.rect.corners().map(|corner| self.point(corner))
    }

    /// Distance of a point along the axis of the tile's face, metres.
    pub fn depth(&self, point: DVec3) -> f64 {
        let [forward, ..] = self.cell.face.axes();
        point.dot(forward)
    }

    /// Position within the texture, 0 to 1 along each side.
    pub fn texture_position(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [least, most] = [self.rect.min, self.rect.max];
        [(u - least[0]) / (most[0] - least[0]), (v - least[1]) / (most[1] - least[1])]
    }
}

/// The tiles in drawing order, from back to front, seen from the middle of the region.
#[derive(Debug)]
pub struct TileSet {
    pub tiles: Vec<QuadTile>,
    /// Tiles that reach into each cell of the last level.
    reach: Vec<Vec<u32>>,
    /// What tiles reach over the edges of their faces, at most.
    margin: f64,
    bvh: Bvh,
}

/// Where a ray from the middle meets a tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileHit {
    pub tile: u32,
    /// In the plane of the tile's face.
    pub at: [f64; 2],
    /// Distance of the tile over that of the sample.
    pub relative: f64,
}

impl TileSet {
    pub fn new(selected: &[SelectedTiling], levels: &[CandidateLevel], model: &CostModel) -> TileSet {
        let first = levels.first().map_or(0, |level| level.level);
        let mut tiles = Vec::new();
        for SelectedTiling { cell, tiling } in selected {
            let rect = model.extent.dilated(*cell);
            for &plane in &levels[(cell.level - first) as usize].tilings[cell.index()][*tiling].planes {
                let divisions = model.divisions(cell.face, rect, plane);
                tiles.push(QuadTile { cell: *cell, plane, rect, divisions });
            }
        }
        // By the distance of the middle of the tile; ties in the order of the trees.
        let distance = |tile: &QuadTile| {
            let middle = [0, 1].map(|axis| 0.5 * (tile.rect.min[axis] + tile.rect.max[axis]));
            tile.point(middle).length()
        };
        let mut order: Vec<(f64, QuadTile)> = tiles.into_iter().map(|tile| (distance(&tile), tile)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        TileSet::in_order(order.into_iter().map(|(_, tile)| tile).collect())
    }

    /// Tiles in their drawing order.
    pub fn in_order(tiles: Vec<QuadTile>) -> TileSet {
        let mut reach = vec![Vec::new(); TreeCell::count(MAX_LEVEL)];
        for (tile, at) in tiles.iter().zip(0u32..) {
            let leaf = |corner: [f64; 2]| corner.map(leaf_place);
            let ([left, top], [right, bottom]) = (leaf(tile.rect.min), leaf(tile.rect.max));
            for row in top..=bottom {
                for column in left..=right {
                    reach[TreeCell { level: MAX_LEVEL, column, row, ..tile.cell }.index()].push(at);
                }
            }
        }
        let bvh = Bvh::new(tiles.iter().flat_map(|tile| {
            let [a, b, c, d] = tile.corners();
            [[a, b, c], [a, c, d]]
        }));
        let beyond = tiles.iter().flat_map(|tile| tile.rect.corners().concat()).map(|at| at.abs() - 1.0);
        TileSet { margin: beyond.fold(0.0, f64::max), tiles, reach, bvh }
    }

    /// Tiles that the line from the middle through a point meets.
    pub fn along(&self, point: DVec3, hits: &mut Vec<TileHit>) {
        hits.clear();
        let TreeCell { face, .. } = TreeCell::containing(point, MAX_LEVEL);
        let Some([u, v]) = project(face, point) else { return };
        self.of_face(face, point, hits);
        // Tiles of other faces reach over their edges.
        if u.abs().max(v.abs()) > 1.0 - 2.0 * self.margin {
            for other in Face::CUBE.into_iter().filter(|&other| other != face) {
                self.of_face(other, point, hits);
            }
        }
    }

    fn of_face(&self, face: Face, point: DVec3, hits: &mut Vec<TileHit>) {
        let Some(at) = project(face, point) else { return };
        if at.iter().any(|at| at.abs() > 1.0 + self.margin) {
            return;
        }
        for &tile in &self.reach[leaf_index(face, at)] {
            let QuadTile { plane, rect, .. } = &self.tiles[tile as usize];
            if rect.contains(at) {
                hits.push(TileHit { tile, at, relative: plane.hit(point) });
            }
        }
    }

    /// Tiles that a ray meets after the first, by distance: number of the tile, metres along the ray.
    pub fn crossed(&self, ray: &Ray) -> Vec<(u32, f64)> {
        let mut hits: Vec<(u32, f64)> = self
            .bvh
            .all(ray, 0.0..f64::INFINITY)
            .into_iter()
            .map(|hit| (hit.triangle as u32 / 2, hit.distance))
            .collect();
        hits.dedup_by_key(|hit| hit.0);
        hits
    }

    /// Whether a ray meets any.
    pub fn is_crossed(&self, ray: &Ray) -> bool {
        self.bvh.any(ray, 0.0..f64::INFINITY, |_| true)
    }
}

/// Column or row of the cell of the last level at a coordinate; of the nearest one outside of the face.
fn leaf_place(at: f64) -> u32 {
    let side = 1u32 << MAX_LEVEL;
    ((0.5 * (at + 1.0) * f64::from(side)) as u32).min(side - 1)
}

fn leaf_index(face: Face, [u, v]: [f64; 2]) -> usize {
    TreeCell { face, level: MAX_LEVEL, column: leaf_place(u), row: leaf_place(v) }.index()
}
