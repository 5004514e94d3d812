//! Extends tiles over the gaps that eyes in the viewing region see between them.
//!
//! Takes tiles, which leave no gap as seen from the centre of the region, and returns tiles with larger rectangles, as far as
//! budgets allow. Tiles of neighbouring cells separate if their depths differ and the eye is not at the centre (Seurat 4.2
//! dilates all tiles by one width). The farther tile is extended, so that it continues behind the nearer one.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::budgets::{Use, add_cost, keeps};
use super::cost::{CostModel, ViewShares};
use super::tiles::{QuadTile, TileSet};
use super::tree::{PlaneRect, TreeCell, direction, project};
use codec::math::Camera;
use scene::mesh::Ray;

/// Maximum distance in pixels at which the border of a gap is searched.
const BORDER_PIXELS: i32 = 32;
/// Maximum length by which a tile is extended in the plane of a face: 11 degrees.
const MAX_LONGER: f64 = 0.2;
/// Maximum factor by which an extension increases the distance of a tile's farthest corner.
const MAX_FARTHER: f64 = 2.0;
/// Tree level of the squares for which it is stored whether the capture has a surface.
const SEEN_LEVEL: u32 = 5;

/// Directions from the centre of the region in which a capture has surfaces.
#[derive(Debug, Clone)]
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

    /// Returns the directions as bits.
    pub fn to_words(&self) -> impl Iterator<Item = u64> {
        let word = |bits: &[bool]| (0..).zip(bits).map(|(at, bit)| u64::from(*bit) << at).sum();
        self.0.chunks(64).map(word)
    }

    /// Reads the result of [`Self::to_words`]; `None` if the number of words is wrong.
    pub fn of_words(words: &[u64]) -> Option<SeenDirections> {
        let bits: Vec<bool> = words.iter().flat_map(|word| (0..64).map(move |at| word >> at & 1 == 1)).collect();
        (bits.len() == TreeCell::count(SEEN_LEVEL)).then_some(SeenDirections(bits))
    }
}

/// Budgets that extended tiles must keep.
#[derive(Debug)]
pub struct Account<'a> {
    pub model: &'a CostModel,
    pub shares: &'a ViewShares,
    pub used: Use,
    pub capacity: Use,
}

impl Account<'_> {
    /// Replaces the rectangle of a selected tile if the budgets are still kept.
    fn replace(&mut self, tile: &mut QuadTile, rect: PlaneRect) {
        let (face, plane) = (tile.cell.face, tile.plane);
        let shares = self.shares.of(tile.cell.level, tile.cell.index());
        let mut used = self.used;
        add_cost(&mut used, shares, &self.model.of_tile(face, tile.rect, plane), -1.0);
        add_cost(&mut used, shares, &self.model.of_tile(face, rect, plane), 1.0);
        if keeps(&used, &self.capacity) {
            self.used = used;
            (tile.rect, tile.divisions) = (rect, self.model.divisions(face, rect, plane));
        }
    }
}

/// A picture from the viewing region: for each pixel, in row-major order, whether it is covered.
#[derive(Debug, Clone)]
pub struct Coverage {
    /// Camera whose eye is relative to the centre of the region.
    pub camera: Camera,
    pub size: [u32; 2],
    pub covered: Vec<bool>,
}

/// A pixel that is not covered.
#[derive(Debug, Clone, Copy)]
struct GapPixel {
    at: [u32; 2],
    ray: Ray,
}

impl Coverage {
    fn ray(&self, [column, row]: [u32; 2]) -> Option<Ray> {
        let [width, height] = self.size.map(f64::from);
        let part = [(f64::from(column) + 0.5) / width, (f64::from(row) + 0.5) / height];
        Ray::new(self.camera.eye(), self.camera.direction(part))
    }

    fn gap_pixels(&self) -> impl Iterator<Item = GapPixel> {
        let pixels = (0..).zip(&self.covered).filter(|(_, covered)| !**covered);
        pixels.filter_map(|(at, _): (u32, &bool)| {
            let at = [at % self.size[0], at / self.size[0]];
            self.ray(at).map(|ray| GapPixel { at, ray })
        })
    }

    /// Marks gap pixels as covered if the predicate is true for their ray.
    pub fn cover(&mut self, is_excused: impl Fn(&Ray) -> bool) {
        let excused: Vec<[u32; 2]> = self.gap_pixels().filter(|gap| is_excused(&gap.ray)).map(|gap| gap.at).collect();
        for [column, row] in excused {
            self.covered[(row * self.size[0] + column) as usize] = true;
        }
    }

    /// Returns the rays of all pixels that are not covered.
    pub fn gaps(&self) -> impl Iterator<Item = Ray> {
        self.gap_pixels().map(|gap| gap.ray)
    }

    /// Returns the rays to the border of a gap on the four sides of one of its pixels.
    fn border(&self, [column, row]: [u32; 2]) -> impl Iterator<Item = Ray> {
        [[1, 0], [-1, 0], [0, 1], [0, -1]].into_iter().filter_map(move |[right, down]| {
            let beside = |step: i32| {
                let at = [column.checked_add_signed(step * right)?, row.checked_add_signed(step * down)?];
                (at[0] < self.size[0] && at[1] < self.size[1]).then_some(at)
            };
            let mut steps = (1..=BORDER_PIXELS).map_while(beside);
            self.ray(steps.find(|[x, y]| self.covered[(y * self.size[0] + x) as usize])?)
        })
    }

    /// Returns the size of a pixel in the plane at distance 1 from the eye.
    fn pixel_length(&self) -> f64 {
        2.0 * self.camera.half()[1] / f64::from(self.size[1])
    }
}

/// Extensions of the tiles beside gaps: the rectangle that would cover the gaps, and the number of gap pixels.
#[derive(Debug)]
pub struct Extensions<'a> {
    tiles: &'a TileSet,
    wanted: BTreeMap<u32, (PlaneRect, u32)>,
}

impl<'a> Extensions<'a> {
    pub fn new(tiles: &'a TileSet) -> Extensions<'a> {
        Extensions { tiles, wanted: BTreeMap::new() }
    }

    /// Adds the gaps of a picture. The result does not depend on the order of pictures.
    pub fn add(&mut self, picture: &Coverage) {
        let tiles = self.tiles;
        let gaps: Vec<GapPixel> = picture.gap_pixels().collect();
        let of_gap = |gap: &GapPixel| {
            let last = |ray: Ray| tiles.crossed(&ray).last().copied();
            let mut behind: Vec<(u32, f64)> = picture.border(gap.at).filter_map(last).collect();
            behind.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            let reaching = |tile: u32, margin: f64| reaching(&tiles.tiles[tile as usize], &gap.ray, margin);
            let first = |margin| behind.iter().find_map(|&(tile, _)| Some((tile, reaching(tile, margin)?)));
            let pixel = picture.pixel_length();
            first(pixel).or_else(|| first(0.5 * pixel))
        };
        let found: Vec<Option<(u32, PlaneRect)>> = gaps.par_iter().map(of_gap).collect();
        for (tile, rect) in found.into_iter().flatten() {
            let (joined, pixels) = self.wanted.entry(tile).or_insert((rect, 0));
            (*joined, *pixels) = (joined.join(rect), *pixels + 1);
        }
    }

    /// Extends the rectangles of tiles, which may be extended already, as far as budgets allow.
    pub fn extend(&self, extended: &mut [QuadTile], account: &mut Account<'_>) {
        let mut order: Vec<(u32, (PlaneRect, u32))> =
            self.wanted.iter().map(|(tile, wanted)| (*tile, *wanted)).collect();
        // Tiles that close the most gap pixels come first.
        order.sort_by_key(|&(tile, (_, pixels))| (std::cmp::Reverse(pixels), tile));
        for (at, (rect, _)) in order {
            let tile = &mut extended[at as usize];
            let rect = tile.rect.join(rect);
            if may_become(&self.tiles.tiles[at as usize], rect) {
                account.replace(tile, rect);
            }
        }
    }
}

/// Returns the rectangle of a tile that is extended to a ray and `margin` beyond it; `None` if the ray does not meet the plane
/// near the tile.
fn reaching(tile: &QuadTile, gap: &Ray, margin: f64) -> Option<PlaneRect> {
    let normal = tile.plane.0;
    let distance = (1.0 - normal.dot(gap.origin())) / normal.dot(gap.direction());
    let hit = gap.at(distance).is_finite().then(|| gap.at(distance)).filter(|_| distance > 0.0)?;
    let at = project(tile.cell.face, hit)?;
    let around = PlaneRect { min: at.map(|at| at - margin), max: at.map(|at| at + margin) };
    // Extends only the sides that the ray is beyond.
    let rect = PlaneRect {
        min: [0, 1].map(|axis| if at[axis] < tile.rect.min[axis] { around.min[axis] } else { tile.rect.min[axis] }),
        max: [0, 1].map(|axis| if at[axis] > tile.rect.max[axis] { around.max[axis] } else { tile.rect.max[axis] }),
    };
    may_become(tile, rect).then_some(rect)
}

/// Returns true if a rectangle is not much larger than that of a tile, and its corners are not much farther away.
fn may_become(tile: &QuadTile, rect: PlaneRect) -> bool {
    let is_near = (0..2).all(|axis| {
        tile.rect.min[axis] - rect.min[axis] <= MAX_LONGER && rect.max[axis] - tile.rect.max[axis] <= MAX_LONGER
    });
    let farthest = |rect: PlaneRect| {
        let along = rect.corners().map(|corner| tile.plane.hit(direction(tile.cell.face, corner)));
        along.into_iter().fold(0.0, f64::max)
    };
    let after = farthest(rect);
    is_near && after.is_finite() && after <= MAX_FARTHER * farthest(tile.rect)
}
