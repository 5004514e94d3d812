//! Solid and free-space constraints of tiles (Seurat 5.1).
//!
//! Enters: a sample. Leaves: places on tiles that its surface covers, and places that its ray shows to be empty.

use glam::DVec3;

use super::samples::Sample;
use super::tiles::{TileHit, TileSet};
use super::tree::project;
use crate::mesh::Ray;

/// A place on a tile, 0 to 1 along each side of its texture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constraint {
    pub tile: u32,
    pub at: [f32; 2],
    /// Index of the sample whose colour it has; none for free space.
    pub sample: Option<u32>,
}

/// What a constraint says of its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConstraintKind {
    Solid,
    FreeSpace,
}

impl Constraint {
    pub fn kind(&self) -> ConstraintKind {
        if self.sample.is_some() { ConstraintKind::Solid } else { ConstraintKind::FreeSpace }
    }

    /// The place in texels of a square texture: 0 is the middle of the first one.
    pub fn texel(&self, side: usize) -> [f32; 2] {
        self.at.map(|at| at.clamp(0.0, 1.0) * (side - 1) as f32)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FreeSpace {
    /// Rays are traced.
    Trace,
    /// Solid constraints alone.
    Ignore,
}

/// Finds the constraints of samples; holds what is used again for each.
#[derive(Debug)]
pub struct ConstraintFinder<'a> {
    tiles: &'a TileSet,
    /// Relative distance to a sample within which a tile counts as its surface.
    solid_threshold: f64,
    hits: Vec<TileHit>,
    free: Vec<(u32, [f64; 2])>,
}

impl<'a> ConstraintFinder<'a> {
    pub fn new(tiles: &'a TileSet, solid_threshold: f64) -> ConstraintFinder<'a> {
        ConstraintFinder { tiles, solid_threshold, hits: Vec::new(), free: Vec::new() }
    }

    /// Adds the constraints of a sample; answers whether there is a tile along the line from the middle through its end.
    pub fn add(&mut self, sample: &Sample, number: u32, free_space: FreeSpace, out: &mut Vec<Constraint>) -> bool {
        self.tiles.along(sample.end, &mut self.hits);
        let beside = |hit: &TileHit| (hit.relative - 1.0).abs();
        // Of tiles at one distance, that which is drawn last.
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
        let at = self.tiles.tiles[tile as usize].texture_position(at).map(|at| at as f32);
        Constraint { tile, at, sample }
    }

    /// Tiles that are drawn over the primary one, and that the sample's own ray meets elsewhere than at its end; all of them where the
    /// ray has no surface.
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
