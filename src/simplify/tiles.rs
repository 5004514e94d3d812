//! The selected quad tiles: corners, drawing order, and intersections with rays.

use glam::DVec3;

use super::budgets::SelectedTiling;
use super::candidates::CandidateLevel;
use super::cost::{CostModel, TextureCoordinates};
use super::tile_plane::TilePlane;
use super::tree::{MAX_LEVEL, PlaneRect, TreeCell, direction, project};
use codec::image::Face;
use scene::mesh::{Bvh, Ray};

/// A quad tile: the part of a plane inside the dilated frustum of a tree cell (Seurat 4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadTile {
    pub cell: TreeCell,
    pub plane: TilePlane,
    /// Dilated square of the cell in the plane of the face. The centres of the corner texels of the texture lie at its corners.
    pub rect: PlaneRect,
    /// Number of columns and rows of quads that the tile is drawn as.
    pub divisions: [u32; 2],
}

impl QuadTile {
    /// Returns a point of the tile relative to the centre of the region, in metres.
    pub fn point(&self, at: [f64; 2]) -> DVec3 {
        let direction = direction(self.cell.face, at);
        direction * self.plane.hit(direction)
    }

    pub fn corners(&self) -> [DVec3; 4] {
        self.rect.corners().map(|corner| self.point(corner))
    }

    /// Returns the distance of a point along the axis of the tile's face, in metres.
    pub fn depth(&self, point: DVec3) -> f64 {
        let [forward, ..] = self.cell.face.axes();
        point.dot(forward)
    }

    /// Returns the position within the texture, 0 to 1 along each side, at which the triangles of the tile show a direction: that of
    /// their texture coordinates, so that what a texture shows stays in its place however coarsely a slanted tile is divided.
    fn texture_position(&self, [u, v]: [f64; 2], form: TileForm) -> [f64; 2] {
        let [least, most] = [self.rect.min, self.rect.max];
        let projective = [(u - least[0]) / (most[0] - least[0]), (v - least[1]) / (most[1] - least[1])];
        match form.coordinates {
            TextureCoordinates::Projective => projective,
            TextureCoordinates::Affine => self.affine_position(projective, form.sky_m).unwrap_or(projective),
        }
    }

    /// Converts a position in the plane of the face to affine texture coordinates; both are 0 to 1 along each side. Returns `None`
    /// where the tile has no finite corners.
    fn affine_position(&self, at: [f64; 2], sky_m: f64) -> Option<[f64; 2]> {
        let parts = self.divisions.map(f64::from);
        let first: [f64; 2] =
            std::array::from_fn(|axis| (at[axis] * parts[axis]).floor().clamp(0.0, parts[axis] - 1.0));
        let [x, y]: [f64; 2] = std::array::from_fn(|axis| at[axis] * parts[axis] - first[axis]);
        // Both triangles share the diagonal from the first corner.
        let corners = if x >= y {
            [([0.0, 0.0], 1.0 - x), ([1.0, 0.0], x - y), ([1.0, 1.0], y)]
        } else {
            [([0.0, 0.0], 1.0 - y), ([1.0, 1.0], x), ([0.0, 1.0], y - x)]
        };
        let (mut sum, mut weights) = ([0.0; 2], 0.0);
        for (corner, share) in corners {
            let corner: [f64; 2] = std::array::from_fn(|axis| (first[axis] + corner[axis]) / parts[axis]);
            let place = std::array::from_fn(|axis| {
                self.rect.min[axis] + corner[axis] * (self.rect.max[axis] - self.rect.min[axis])
            });
            // A share in the plane of the face is one on the tile times the depth of the corner.
            let ray = direction(self.cell.face, place);
            let weight = share / self.plane.hit(ray).min(sky_m / ray.abs().max_element());
            sum = [0, 1].map(|axis| sum[axis] + weight * corner[axis]);
            weights += weight;
        }
        (weights > 0.0).then(|| sum.map(|sum| sum / weights))
    }
}

/// How tiles are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileForm {
    pub coordinates: TextureCoordinates,
    /// Half of the edge of the cube that corners are moved into, in metres: [`super::quad_mesh::QuadMesh::pull_in`].
    pub sky_m: f64,
}

impl TileForm {
    /// Tiles whose corners stay where they were fitted.
    pub fn as_fitted(coordinates: TextureCoordinates) -> TileForm {
        TileForm { coordinates, sky_m: f64::INFINITY }
    }
}

/// Tiles in drawing order, from back to front as seen from the centre of the region.
#[derive(Debug)]
pub struct TileSet {
    pub tiles: Vec<QuadTile>,
    form: TileForm,
    /// Tiles that overlap each cell of the last level.
    reach: Vec<Vec<u32>>,
    /// Maximum distance by which tiles extend over the edges of their faces.
    margin: f64,
    bvh: Bvh,
}

/// Intersection of a tile with a ray from the centre of the region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileHit {
    pub tile: u32,
    /// Position in the plane of the tile's face.
    pub at: [f64; 2],
    /// Distance of the tile divided by that of the sample.
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
        // Sorts by the distance of the tile's centre; ties are in the order of the trees.
        let distance = |tile: &QuadTile| {
            let middle = [0, 1].map(|axis| 0.5 * (tile.rect.min[axis] + tile.rect.max[axis]));
            tile.point(middle).length()
        };
        let mut order: Vec<(f64, QuadTile)> = tiles.into_iter().map(|tile| (distance(&tile), tile)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        TileSet::in_order(
            order.into_iter().map(|(_, tile)| tile).collect(),
            TileForm::as_fitted(model.texture_coordinates),
        )
    }

    /// Takes tiles in drawing order.
    pub fn in_order(tiles: Vec<QuadTile>, form: TileForm) -> TileSet {
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
        let bvh = bvh_of(&tiles, f64::INFINITY);
        let beyond = tiles.iter().flat_map(|tile| tile.rect.corners().concat()).map(|at| at.abs() - 1.0);
        TileSet { margin: beyond.fold(0.0, f64::max), tiles, form, reach, bvh }
    }

    /// Returns the same tiles, whose rays are traced to their corners as drawn.
    pub fn as_drawn(&self) -> TileSet {
        let bvh = bvh_of(&self.tiles, self.form.sky_m);
        TileSet { tiles: self.tiles.clone(), form: self.form, reach: self.reach.clone(), margin: self.margin, bvh }
    }

    /// Takes other tiles that are drawn in the same way.
    pub fn with(&self, tiles: Vec<QuadTile>) -> TileSet {
        TileSet::in_order(tiles, self.form)
    }

    /// Returns the position in the texture of a tile, 0 to 1 along each side, of a point in the plane of its face.
    pub fn texture_position(&self, tile: u32, at: [f64; 2]) -> [f64; 2] {
        self.tiles[tile as usize].texture_position(at, self.form)
    }

    /// Finds the tiles that the line from the centre through a point meets.
    pub fn along(&self, point: DVec3, hits: &mut Vec<TileHit>) {
        hits.clear();
        let TreeCell { face, .. } = TreeCell::containing(point, MAX_LEVEL);
        let Some([u, v]) = project(face, point) else { return };
        self.of_face(face, point, hits);
        // Tiles of other faces may extend over the edges.
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

    /// Returns the tiles that a ray meets, by distance: index of the tile, and metres along the ray.
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

    /// Returns true if a ray meets any tile.
    pub fn is_crossed(&self, ray: &Ray) -> bool {
        self.bvh.any(ray, 0.0..f64::INFINITY, |_| true)
    }
}

/// Returns the triangles of tiles for ray tests; corners outside of a cube are moved to it. `sky_m` is half of its edge.
fn bvh_of(tiles: &[QuadTile], sky_m: f64) -> Bvh {
    Bvh::new(tiles.iter().flat_map(|tile| {
        let [a, b, c, d] = tile.corners().map(|corner| corner * (sky_m / corner.abs().max_element()).min(1.0));
        [[a, b, c], [a, c, d]]
    }))
}

/// Returns the column or row of the last level's cell at a coordinate, or of the nearest cell if the coordinate is outside of the
/// face.
fn leaf_place(at: f64) -> u32 {
    let side = 1u32 << MAX_LEVEL;
    ((0.5 * (at + 1.0) * f64::from(side)) as u32).min(side - 1)
}

fn leaf_index(face: Face, [u, v]: [f64; 2]) -> usize {
    TreeCell { face, level: MAX_LEVEL, column: leaf_place(u), row: leaf_place(v) }.index()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    /// A floor below the centre, from 0.5 to 8 m ahead of it.
    fn floor(divisions: [u32; 2]) -> QuadTile {
        let rect = PlaneRect { min: [-0.5, 0.125], max: [0.5, 2.0] };
        QuadTile { cell: TreeCell::ROOTS[5], plane: TilePlane(DVec3::new(0.0, -1.0, 0.0)), rect, divisions }
    }

    #[test]
    fn affine_positions_are_those_that_triangles_show() {
        for divisions in [[1, 1], [2, 3], [1, 16]] {
            let tile = floor(divisions);
            let parts = divisions.map(f64::from);
            let place = |at: [f64; 2]| {
                let share = [0, 1].map(|axis| at[axis] / parts[axis]);
                let plane: [f64; 2] = std::array::from_fn(|axis| {
                    tile.rect.min[axis] + share[axis] * (tile.rect.max[axis] - tile.rect.min[axis])
                });
                (tile.point(plane), DVec2::from_array(share))
            };
            for step in 0..divisions[0] * divisions[1] {
                let first = [step % divisions[0], step / divisions[0]].map(f64::from);
                let corner = |x: f64, y: f64| place([first[0] + x, first[1] + y]);
                for [b, c] in [[corner(1.0, 0.0), corner(1.0, 1.0)], [corner(1.0, 1.0), corner(0.0, 1.0)]] {
                    let a = corner(0.0, 0.0);
                    let weights = [0.25, 0.6, 0.15];
                    let point = weights[0] * a.0 + weights[1] * b.0 + weights[2] * c.0;
                    let expected = weights[0] * a.1 + weights[1] * b.1 + weights[2] * c.1;
                    let at = project(tile.cell.face, point).unwrap();
                    let found =
                        DVec2::from_array(tile.texture_position(at, TileForm::as_fitted(TextureCoordinates::Affine)));
                    assert!((found - expected).length() < 1e-9, "{divisions:?}, part {step}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn positions_are_equal_at_corners_and_projective_ones_linear_in_the_face() {
        let tile = floor([1, 1]);
        for (corner, expected) in tile.rect.corners().into_iter().zip([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        {
            for coordinates in [TextureCoordinates::Affine, TextureCoordinates::Projective] {
                assert_eq!(tile.texture_position(corner, TileForm::as_fitted(coordinates)), expected);
            }
        }
        let middle = [0.0, 1.0625];
        assert_eq!(tile.texture_position(middle, TileForm::as_fitted(TextureCoordinates::Projective)), [0.5, 0.5]);
        let [_, y] = tile.texture_position(middle, TileForm::as_fitted(TextureCoordinates::Affine));
        // The middle of the picture is nearer than that of the floor.
        assert!(y > 0.9, "{y}");
        // With all corners at one depth nothing is slanted: x is 0.5 and y the part of the side.
        let cut = TileForm { coordinates: TextureCoordinates::Affine, sky_m: 1e-3 };
        let near = QuadTile { rect: PlaneRect { min: [-0.5, 0.125], max: [0.5, 1.0] }, ..tile };
        let [x, y] = near.texture_position([0.0, 0.5625], cut);
        assert!((x - 0.5).abs() < 1e-12 && (y - 0.5).abs() < 1e-12, "{x} {y}");
    }
}
