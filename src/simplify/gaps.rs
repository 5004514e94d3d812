//! Extends tiles over gaps that eyes in the viewing region see between them.
//!
//! Enters: the tiles, which leave no gap from the middle of the region. Leaves: tiles with larger rectangles, as budgets allow.
//! Tiles of cells side by side part where their depths differ and the eye is not in the middle (Seurat 4.2 dilates all tiles by one width).
//! The farther one is extended: it goes on behind the nearer one.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::cost::{CostModel, ViewShares};
use super::selection::{Use, add_cost, keeps};
use super::tiles::{QuadTile, TileSet};
use super::tree::{PlaneRect, TreeCell, direction, project};
use crate::image::Face;
use crate::mesh::Ray;

/// Pixels of a side of the pictures.
pub const SIDE: u32 = 256;
/// Pixels beside a gap within which its border is looked for.
const BORDER_PIXELS: i32 = 32;
/// Length in the plane of a face by which a tile is extended, at most: 11 degrees.
const MOST_LONGER: f64 = 0.2;
/// Largest factor by which that changes the distance of a tile's farthest corner.
const MOST_FARTHER: f64 = 2.0;
/// Squares of a cube face's side within which a capture saw something or not.
const SEEN_LEVEL: u32 = 5;

/// The directions from the middle of the region in which a capture has surfaces.
#[derive(Debug)]
pub struct SeenDirections(Vec<bool>);

impl SeenDirections {
    pub fn new(points: impl Iterator<Item = DVec3>) -> SeenDirections {
        let mut seen = vec![false; TreeCell::count(SEEN_LEVEL)];
        points.for_each(|point| seen[TreeCell::containing(point, SEEN_LEVEL).index()] = true);
        SeenDirections(seen)
    }

    pub fn contains(&self, direction: DVec3) -> bool {
        self.0[TreeCell::containing(direction, SEEN_LEVEL).index()]
    }
}

/// The budgets that extended tiles keep.
#[derive(Debug)]
pub struct Account<'a> {
    pub model: &'a CostModel,
    pub shares: &'a ViewShares,
    pub used: Use,
    pub capacity: Use,
}

impl Account<'_> {
    /// Replaces the rectangle of a tile where the budgets are still kept.
    fn replace(&mut self, tile: &mut QuadTile, rect: PlaneRect) -> bool {
        let (face, plane) = (tile.cell.face, tile.plane);
        let shares = self.shares.of(tile.cell.level, tile.cell.index());
        let mut used = self.used;
        add_cost(&mut used, shares, &self.model.of_tile(face, tile.rect, plane), -1.0);
        add_cost(&mut used, shares, &self.model.of_tile(face, rect, plane), 1.0);
        let is_kept = keeps(&used, &self.capacity);
        if is_kept {
            self.used = used;
            (tile.rect, tile.divisions) = (rect, self.model.divisions(face, rect, plane));
        }
        is_kept
    }
}

/// A picture of a cube face from an eye, relative to the middle of the region: whether each pixel is covered, row by row.
#[derive(Debug, Clone)]
pub struct Coverage {
    pub eye: DVec3,
    pub face: Face,
    pub covered: Vec<bool>,
}

impl Coverage {
    fn ray(&self, [column, row]: [i32; 2]) -> Option<Ray> {
        let plane = [column, row].map(|at| (f64::from(at) + 0.5) * 2.0 / f64::from(SIDE) - 1.0);
        Ray::new(self.eye, direction(self.face, plane))
    }

    /// Pixels that are not covered, and their rays, in directions in which there are surfaces.
    fn gap_pixels(&self, seen: &SeenDirections) -> impl Iterator<Item = ([i32; 2], Ray)> {
        let pixels = (0..(SIDE * SIDE) as i32).zip(&self.covered).filter(|(_, covered)| !**covered);
        pixels.filter_map(|(at, _)| {
            let pixel = [at % SIDE as i32, at / SIDE as i32];
            let ray = self.ray(pixel).filter(|ray| seen.contains(ray.direction()))?;
            Some((pixel, ray))
        })
    }

    pub fn gaps(&self, seen: &SeenDirections) -> impl Iterator<Item = Ray> {
        self.gap_pixels(seen).map(|(_, ray)| ray)
    }

    /// Rays to the border of a gap on the four sides of a pixel of it.
    fn border(&self, [column, row]: [i32; 2]) -> impl Iterator<Item = Ray> {
        let side = SIDE as i32;
        [[1, 0], [-1, 0], [0, 1], [0, -1]].into_iter().filter_map(move |[right, down]| {
            let beside = |step: i32| [column + step * right, row + step * down];
            let inside = |at: &[i32; 2]| at.iter().all(|at| (0..side).contains(at));
            let mut steps = (1..=BORDER_PIXELS).map(beside).take_while(inside);
            self.ray(steps.find(|[x, y]| self.covered[(y * side + x) as usize])?)
        })
    }
}

/// Extends tiles where pictures show a gap in a direction in which there are surfaces. Answers the tiles, unless none was extended, and
/// how many were.
pub fn extend(
    tiles: &TileSet,
    pictures: &[Coverage],
    seen: &SeenDirections,
    account: &mut Account<'_>,
) -> Option<(TileSet, u64)> {
    let mut order: Vec<(u32, (PlaneRect, u32))> = wanted_rects(tiles, pictures, seen).into_iter().collect();
    // Those that close most come first.
    order.sort_by_key(|&(tile, (_, pixels))| (std::cmp::Reverse(pixels), tile));
    let mut changed = tiles.tiles.clone();
    let kept = order.iter().filter(|(tile, (rect, _))| account.replace(&mut changed[*tile as usize], *rect)).count();
    (kept > 0).then(|| (TileSet::in_order(changed), kept as u64))
}

/// By tile, the rectangle that covers the gaps beside it, and their pixels.
fn wanted_rects(tiles: &TileSet, pictures: &[Coverage], seen: &SeenDirections) -> BTreeMap<u32, (PlaneRect, u32)> {
    let of_picture = |picture: &Coverage| {
        let mut found = Vec::new();
        for (pixel, gap) in picture.gap_pixels(seen) {
            let last = |ray: Ray| tiles.crossed(&ray).last().copied();
            let mut behind: Vec<(u32, f64)> = picture.border(pixel).filter_map(last).collect();
            behind.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            found.extend(
                behind.iter().find_map(|&(tile, _)| Some((tile, extended(&tiles.tiles[tile as usize], &gap)?))),
            );
        }
        found
    };
    let found: Vec<Vec<(u32, PlaneRect)>> = pictures.par_iter().map(of_picture).collect();
    let mut wanted = BTreeMap::new();
    for (tile, rect) in found.into_iter().flatten() {
        let (joined, pixels) = wanted.entry(tile).or_insert((rect, 0));
        (*joined, *pixels) = (joined.join(rect), *pixels + 1);
    }
    wanted
}

/// The rectangle of a tile that reaches to a ray and a pixel farther; none where the plane is not met near the tile.
fn extended(tile: &QuadTile, gap: &Ray) -> Option<PlaneRect> {
    let normal = tile.plane.0;
    let distance = (1.0 - normal.dot(gap.origin())) / normal.dot(gap.direction());
    let hit = gap.at(distance).is_finite().then(|| gap.at(distance)).filter(|_| distance > 0.0)?;
    let at = project(tile.cell.face, hit)?;
    let margin = 2.0 / f64::from(SIDE);
    let around = PlaneRect { min: at.map(|at| at - margin), max: at.map(|at| at + margin) };
    // Only the sides that the ray is beyond.
    let rect = PlaneRect {
        min: [0, 1].map(|axis| if at[axis] < tile.rect.min[axis] { around.min[axis] } else { tile.rect.min[axis] }),
        max: [0, 1].map(|axis| if at[axis] > tile.rect.max[axis] { around.max[axis] } else { tile.rect.max[axis] }),
    };
    let most = MOST_LONGER;
    let is_near =
        (0..2).all(|axis| tile.rect.min[axis] - rect.min[axis] <= most && rect.max[axis] - tile.rect.max[axis] <= most);
    let farthest = |rect: PlaneRect| {
        let along = rect.corners().map(|corner| tile.plane.hit(direction(tile.cell.face, corner)));
        along.into_iter().fold(0.0, |most: f64, at| if at > 0.0 { most.max(at) } else { f64::INFINITY })
    };
    (is_near && farthest(rect) <= MOST_FARTHER * farthest(tile.rect)).then_some(rect)
}
