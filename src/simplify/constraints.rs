//! Solid and free-space constraints of tiles (Seurat 5.1).
//!
//! Takes a sample, and returns the places on tiles that its surface covers, and those that its ray shows to be empty.

use glam::DVec3;

use super::samples::Sample;
use super::tiles::{TileHit, TileSet};
use super::tree::project;
use scene::mesh::Ray;

/// A constraint at a place on a tile, 0 to 1 along each side of the tile's texture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constraint {
    pub tile: u32,
    pub at: [f32; 2],
    /// Index of the sample that gives the colour; `None` for free space.
    pub sample: Option<u32>,
}

/// Kind of a constraint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConstraintKind {
    Solid,
    FreeSpace,
}

impl Constraint {
    pub fn kind(&self) -> ConstraintKind {
        if self.sample.is_some() { ConstraintKind::Solid } else { ConstraintKind::FreeSpace }
    }

    /// Returns the place in texels of a square texture; 0 is the centre of the first texel.
    pub fn texel(&self, side: usize) -> [f32; 2] {
        self.at.map(|at| at.clamp(0.0, 1.0) * (side - 1) as f32)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FreeSpace {
    /// Rays are traced through free space.
    Trace,
    /// Only solid constraints are found, except for samples without a surface.
    Ignore,
}

/// Search for the constraints of samples, with buffers that are reused.
#[derive(Debug)]
pub struct ConstraintFinder<'a> {
    tiles: &'a TileSet,
    /// Relative distance to a sample within which a tile counts as the sample's surface.
    solid_threshold: f64,
    hits: Vec<TileHit>,
    free: Vec<(u32, [f64; 2])>,
}

impl<'a> ConstraintFinder<'a> {
    pub fn new(tiles: &'a TileSet, solid_threshold: f64) -> ConstraintFinder<'a> {
        ConstraintFinder { tiles, solid_threshold, hits: Vec::new(), free: Vec::new() }
    }

    /// Adds the constraints of a sample. Returns false if the sample has a surface, but no tile lies along the line from the
    /// centre of the region through the sample's end.
    pub fn add(&mut self, sample: &Sample, number: u32, free_space: FreeSpace, out: &mut Vec<Constraint>) -> bool {
        self.tiles.along(sample.end, &mut self.hits);
        let beside = |hit: &TileHit| (hit.relative - 1.0).abs();
        // Of several tiles at the same distance, the one that is drawn last.
        let nearest = |a: &&TileHit, b: &&TileHit| beside(a).total_cmp(&beside(b)).then(b.tile.cmp(&a.tile));
        self.free.clear();
        if !sample.is_surface {
            self.trace(sample, None);
            out.extend(self.free.iter().map(|&(tile, at)| self.constraint(at, tile, None)));
            return true;
        }
        let Some(primary) = self.hits.iter().min_by(nearest).copied() else { return false };
        if free_space == FreeSpace::Trace {
            self.trace(sample, Some(primary.tile));
        }
        for hit in &self.hits {
            let is_solid = hit.tile == primary.tile || beside(hit) < self.solid_threshold;
            if is_solid && !self.free.iter().any(|(tile, _)| *tile == hit.tile) {
                out.push(self.constraint(hit.at, hit.tile, Some(number)));
            }
        }
        out.extend(self.free.iter().map(|&(tile, at)| self.constraint(at, tile, None)));
        true
    }

    fn constraint(&self, at: [f64; 2], tile: u32, sample: Option<u32>) -> Constraint {
        let at = self.tiles.texture_position(tile, at).map(|at| at as f32);
        Constraint { tile, at, sample }
    }

    /// Finds the tiles that are drawn over the primary tile and that the sample's own ray meets elsewhere than at its end. If the
    /// ray has no surface, finds all tiles that it meets.
    fn trace(&mut self, sample: &Sample, primary: Option<u32>) {
        let along = sample.end - sample.origin;
        let length = along.length();
        let Some(ray) = Ray::new(sample.origin, along) else { return };
        for (tile, distance) in self.tiles.crossed(&ray) {
            if primary.is_some_and(|primary| tile <= primary || (distance / length - 1.0).abs() <= self.solid_threshold)
            {
                continue;
            }
            let at: DVec3 = ray.at(distance);
            if let Some(at) = project(self.tiles.tiles[tile as usize].cell.face, at) {
                self.free.push((tile, at));
            }
        }
    }
}
