//! Drawing cost of a tiling: triangles, area on the sphere, and share of the overdraw of each view (Seurat 4).

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::candidates::{CandidateLevel, Extent, Tiling};
use super::tile_plane::TilePlane;
use super::tree::{MAX_LEVEL, PlaneRect, TreeCell, direction};
use codec::image::Face;

/// F of Seurat 4: number of 90-degree views whose mean overdraw is bounded.
pub const VIEWS: usize = 126;
/// Maximum ratio of the depths of a part's ends along its columns or rows. With affine texture coordinates, its texels are up to a
/// quarter denser than projective ones at one end, and as much sparser at the other.
const MAX_DEPTH_RATIO: f64 = 1.5;
/// Maximum number of columns or rows that a tile is divided into. A tile with as many has so many triangles that it is not
/// selected.
pub const MAX_PARTS: u32 = 1024;
/// Solid angle of a 90-degree view, in steradians: that of a cube face, a sixth of the sphere.
const VIEW_AREA: f64 = 4.0 * PI / 6.0;

/// Fractions of cells that views see from the centre of the region, by level.
#[derive(Debug)]
pub struct ViewShares {
    levels: Vec<SparseShares>,
}

/// Shares of the cells of a level, in one list.
#[derive(Debug, Default)]
struct SparseShares {
    /// Index of the first entry of each cell.
    starts: Vec<u32>,
    /// View, and the fraction of the cell's solid angle that it sees.
    entries: Vec<(u8, f32)>,
}

impl ViewShares {
    /// Computes the shares of all cells of all levels. A cell of the last level is either visible as a whole or not at all.
    pub fn of_trees() -> ViewShares {
        let axes: Vec<[DVec3; 3]> = view_axes();
        let seen = |index: usize| -> Vec<(u8, f32)> {
            let rect = TreeCell::at(MAX_LEVEL, index);
            let face = rect.face;
            let rect = rect.rect(0.0);
            let middle = direction(face, [0, 1].map(|axis| 0.5 * (rect.min[axis] + rect.max[axis])));
            let sees = |[forward, right, down]: &[DVec3; 3]| {
                middle.dot(*forward) > middle.dot(*right).abs().max(middle.dot(*down).abs())
            };
            (0..VIEWS).filter(|&view| sees(&axes[view])).map(|view| (view as u8, 1.0)).collect()
        };
        let mut cells: Vec<Vec<(u8, f32)>> = (0..TreeCell::count(MAX_LEVEL)).into_par_iter().map(seen).collect();
        let mut levels = vec![SparseShares::new(&cells)];
        for level in (0..MAX_LEVEL).rev() {
            let joined = |index: usize| {
                let cell = TreeCell::at(level, index);
                let area = cell.rect(0.0).solid_angle();
                let mut sums = [0.0; VIEWS];
                for child in cell.children() {
                    let share = child.rect(0.0).solid_angle() / area;
                    for (view, of_child) in &cells[child.index()] {
                        sums[usize::from(*view)] += share * f64::from(*of_child);
                    }
                }
                (0..VIEWS).filter(|&view| sums[view] > 0.0).map(|view| (view as u8, sums[view] as f32)).collect()
            };
            cells = (0..TreeCell::count(level)).into_par_iter().map(joined).collect();
            levels.insert(0, SparseShares::new(&cells));
        }
        ViewShares { levels }
    }

    /// Returns the views that see a cell, and the fraction of the cell that each of them sees.
    pub fn of(&self, level: u32, cell: usize) -> &[(u8, f32)] {
        let SparseShares { starts, entries } = &self.levels[level as usize];
        &entries[starts[cell] as usize..starts[cell + 1] as usize]
    }
}

impl SparseShares {
    fn new(cells: &[Vec<(u8, f32)>]) -> SparseShares {
        let mut shares = SparseShares { starts: vec![0], entries: Vec::new() };
        for cell in cells {
            shares.entries.extend_from_slice(cell);
            shares.starts.push(shares.entries.len() as u32);
        }
        shares
    }
}

/// Returns forward, right and down of each view: the faces of the cube, then directions on a spiral.
pub(super) fn view_axes() -> Vec<[DVec3; 3]> {
    let spiral = VIEWS - 6;
    let golden = PI * (3.0 - 5f64.sqrt());
    let turned = (0..spiral).map(|at| {
        let y = 1.0 - (2.0 * at as f64 + 1.0) / spiral as f64;
        let (sin, cos) = (golden * at as f64).sin_cos();
        let radius = (1.0 - y * y).sqrt();
        let forward = DVec3::new(radius * cos, y, radius * sin);
        let right = forward.any_orthonormal_vector();
        [forward, right, forward.cross(right)]
    });
    Face::CUBE.into_iter().map(Face::axes).chain(turned).collect()
}

/// Energy and costs of a tiling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TilingCost {
    /// Sum of equation 2.
    pub energy: f64,
    pub triangles: f64,
    /// Area in units of the whole sphere.
    pub area: f64,
    /// Solid angle from the worst points of the region, in units of the solid angle of a view.
    pub worst_area: f64,
}

/// Mapping of textures to tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextureCoordinates {
    /// Affine on each triangle. Tiles are divided by depth, so that texels are spread evenly.
    Affine,
    /// Homogeneous (Seurat 5). Tiles are not divided.
    Projective,
}

/// Inputs of the cost computation.
#[derive(Debug, Clone)]
pub struct CostModel {
    pub extent: Extent,
    /// Points of the region's border, relative to the centre of the region.
    pub eyes: Vec<DVec3>,
    pub texture_coordinates: TextureCoordinates,
}

impl CostModel {
    /// Computes the costs of all tilings, by level and cell.
    pub fn costs(&self, levels: &[CandidateLevel]) -> Vec<Vec<Vec<TilingCost>>> {
        let of_level = |level: &CandidateLevel| -> Vec<Vec<TilingCost>> {
            let of_cell = |(index, tilings): (usize, &Vec<Tiling>)| {
                let cell = TreeCell::at(level.level, index);
                let rect = self.extent.dilated(cell);
                let cost = |tiling: &Tiling| {
                    let tiles = tiling.planes.iter().map(|&plane| self.of_tile(cell.face, rect, plane));
                    let nothing = TilingCost { energy: tiling.energy, triangles: 0.0, area: 0.0, worst_area: 0.0 };
                    tiles.fold(nothing, |sum, tile| TilingCost {
                        energy: sum.energy,
                        triangles: sum.triangles + tile.triangles,
                        area: sum.area + tile.area,
                        worst_area: sum.worst_area + tile.worst_area,
                    })
                };
                tilings.iter().map(cost).collect()
            };
            level.tilings.par_iter().enumerate().map(of_cell).collect()
        };
        levels.iter().map(of_level).collect()
    }

    /// Computes the cost of one tile, with an energy of 0.
    pub fn of_tile(&self, face: Face, rect: PlaneRect, plane: TilePlane) -> TilingCost {
        let [columns, rows] = self.divisions(face, rect, plane);
        TilingCost {
            energy: 0.0,
            triangles: f64::from(2 * columns * rows),
            area: rect.solid_angle() / (4.0 * PI),
            worst_area: self.worst_area(face, rect, plane) / VIEW_AREA,
        }
    }

    /// Returns the numbers of columns and rows that a tile is divided into for affine texture coordinates.
    pub fn divisions(&self, face: Face, rect: PlaneRect, plane: TilePlane) -> [u32; 2] {
        if self.texture_coordinates == TextureCoordinates::Projective {
            return [1, 1];
        }
        let corners = rect.corners().map(|corner| plane.hit(direction(face, corner)));
        let along = |pairs: [[usize; 2]; 2]| {
            let ratios = pairs.map(|[a, b]| (corners[a] / corners[b]).max(corners[b] / corners[a]));
            // Inverse depths are linear in the plane of the face, so that the part at the far end has the largest ratio.
            let parts = ((ratios[0].max(ratios[1]) - 1.0) / (MAX_DEPTH_RATIO - 1.0)).ceil();
            // Without a depth at both ends, the tile has too many triangles to be selected.
            if parts.is_finite() { (parts as u32).clamp(1, MAX_PARTS) } else { MAX_PARTS }
        };
        [along([[0, 1], [3, 2]]), along([[0, 3], [1, 2]])]
    }

    /// Returns the maximum solid angle of a tile from the points of the region, in steradians; `+inf` if the ray of a corner
    /// misses the plane.
    fn worst_area(&self, face: Face, rect: PlaneRect, plane: TilePlane) -> f64 {
        let corners = rect.corners().map(|corner| {
            let direction = direction(face, corner);
            direction * plane.hit(direction)
        });
        if corners.iter().any(|corner| !corner.is_finite()) {
            return f64::INFINITY;
        }
        let from = |eye: &DVec3| {
            let [a, b, c, d] = corners.map(|corner| corner - eye);
            triangle_solid_angle([a, b, c]) + triangle_solid_angle([a, c, d])
        };
        self.eyes.iter().map(from).fold(0.0, f64::max)
    }
}

/// Returns the solid angle of a triangle as seen from the origin.
///
/// Based on: Van Oosterom and Strackee, *The solid angle of a plane triangle*, 1983.
fn triangle_solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let [la, lb, lc] = [a.length(), b.length(), c.length()];
    let volume = a.dot(b.cross(c)).abs();
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * volume.atan2(denominator)
}
