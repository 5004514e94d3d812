//! Builds the textures of all tiles from all samples (Seurat 5).

use rayon::prelude::*;

use super::constraints::{Constraint, ConstraintFinder, ConstraintKind, FreeSpace};
use super::samples::Sample;
use super::shading::{LightBuffer, ShortCuts};
use super::silhouettes::ConstraintBitmap;
use super::texture_filter::TextureFilter;
use super::tiles::TileSet;

/// Number of samples whose constraints one job finds.
const SAMPLES_A_JOB: usize = 4096;

/// Maximum number of samples whose constraints are in memory at once.
pub(super) const SAMPLES_AT_ONCE: usize = 1 << 17;

/// Textures of all tiles.
#[derive(Debug)]
pub struct TileTextures {
    pub textures: Vec<TileTexture>,
    /// Number of texels without a sample, whose colour was filled in, and number of tiles with such texels.
    pub filled_texels: u64,
    pub filled_tiles: u64,
}

/// A square texture in row-major order.
#[derive(Debug, Clone, PartialEq)]
pub struct TileTexture {
    pub side: usize,
    /// Linear RGB, not multiplied by coverage, and coverage.
    pub texels: Vec<[f32; 4]>,
    /// True if the coverage of all texels is 1.
    pub is_opaque: bool,
}

#[derive(Debug)]
struct Buffers {
    side: usize,
    light: LightBuffer,
    bitmap: ConstraintBitmap,
}

/// Textures while samples are added.
#[derive(Debug)]
pub struct TextureBuilder<'a> {
    tiles: &'a TileSet,
    solid_threshold: f64,
    buffers: Vec<Buffers>,
    /// Number of solid and of free-space constraints so far.
    pub solid: u64,
    pub free: u64,
    /// Number of samples along which there is no tile.
    pub uncovered: u64,
}

impl<'a> TextureBuilder<'a> {
    /// Creates textures with the given sides, in texels.
    pub fn new(tiles: &'a TileSet, sides: &[usize], solid_threshold: f64, filter: TextureFilter) -> TextureBuilder<'a> {
        let buffers = sides.iter().map(|&side| Buffers {
            side,
            light: LightBuffer::new(side, filter),
            bitmap: ConstraintBitmap::new(side),
        });
        TextureBuilder { tiles, solid_threshold, buffers: buffers.collect(), solid: 0, free: 0, uncovered: 0 }
    }

    /// Adds samples. Their rays are traced through free space.
    pub fn add(&mut self, samples: &[Sample]) {
        samples.chunks(SAMPLES_AT_ONCE).for_each(|samples| self.add_part(samples));
    }

    fn add_part(&mut self, samples: &[Sample]) {
        let (found, uncovered) = constraints_by_tile(self.tiles, self.solid_threshold, samples, FreeSpace::Trace);
        self.uncovered += uncovered;
        let solid = found.iter().filter(|constraint| constraint.kind() == ConstraintKind::Solid).count();
        self.solid += solid as u64;
        self.free += (found.len() - solid) as u64;
        for_each_tile(&found, &mut self.buffers, |buffers, constraint| {
            let at = constraint.texel(buffers.side);
            buffers.bitmap.add(at, constraint.kind());
            if let Some(sample) = constraint.sample {
                let Sample { color, weight, .. } = samples[sample as usize];
                buffers.light.add(at, color, weight);
            }
        });
    }

    /// Returns the textures. A tile without a free-space constraint has no silhouette; a tile without missing texels is not
    /// filled.
    pub fn finish(self, short_cuts: ShortCuts) -> TileTextures {
        let finish = |Buffers { side, light, bitmap }: Buffers| {
            let (mut texels, filled) = light.resolve(short_cuts);
            if !bitmap.is_opaque() || short_cuts == ShortCuts::Off {
                texels.iter_mut().zip(bitmap.coverage()).for_each(|(texel, coverage)| texel[3] = coverage);
            }
            let is_opaque = texels.iter().all(|texel| texel[3] >= 1.0);
            (TileTexture { side, texels, is_opaque }, filled as u64)
        };
        let finished: Vec<(TileTexture, u64)> = self.buffers.into_par_iter().map(finish).collect();
        TileTextures {
            filled_texels: finished.iter().map(|(_, filled)| filled).sum(),
            filled_tiles: finished.iter().filter(|(_, filled)| *filled > 0).count() as u64,
            textures: finished.into_iter().map(|(texture, _)| texture).collect(),
        }
    }
}

/// Adds constraints, which are sorted by tile, to the buffers of their tiles.
pub(super) fn for_each_tile<B: Send>(
    found: &[Constraint],
    buffers: &mut [B],
    add: impl Fn(&mut B, &Constraint) + Sync,
) {
    let runs: Vec<&[Constraint]> = found.chunk_by(|a, b| a.tile == b.tile).collect();
    buffers.par_iter_mut().enumerate().for_each(|(tile, buffer)| {
        if let Ok(run) = runs.binary_search_by_key(&(tile as u32), |run| run[0].tile) {
            runs[run].iter().for_each(|constraint| add(buffer, constraint));
        }
    });
}

/// Returns the constraints of samples, sorted by tile and then by sample, and the number of samples along which there is no tile.
pub(super) fn constraints_by_tile(
    tiles: &TileSet,
    solid_threshold: f64,
    samples: &[Sample],
    free_space: FreeSpace,
) -> (Vec<Constraint>, u64) {
    let find = |(job, samples): (usize, &[Sample])| {
        let mut finder = ConstraintFinder::new(tiles, solid_threshold);
        let (mut found, mut uncovered) = (Vec::new(), 0);
        for (at, sample) in samples.iter().enumerate() {
            let number = job * SAMPLES_A_JOB + at;
            uncovered += u64::from(!finder.add(sample, number as u32, free_space, &mut found));
        }
        (found, uncovered)
    };
    let jobs: Vec<(Vec<Constraint>, u64)> = samples.par_chunks(SAMPLES_A_JOB).enumerate().map(find).collect();
    let uncovered = jobs.iter().map(|(_, uncovered)| uncovered).sum();
    // Counting sort by tile.
    let all = || jobs.iter().flat_map(|(found, _)| found);
    let mut next = vec![0; tiles.tiles.len() + 1];
    all().for_each(|constraint| next[constraint.tile as usize + 1] += 1);
    (1..next.len()).for_each(|tile| next[tile] += next[tile - 1]);
    let none = Constraint { tile: 0, at: [0.0; 2], sample: None };
    let mut found = vec![none; next[tiles.tiles.len()]];
    for constraint in all() {
        let place = &mut next[constraint.tile as usize];
        found[*place] = *constraint;
        *place += 1;
    }
    (found, uncovered)
}
