//! Merging of samples into one point cloud (Seurat 4.1).
//!
//! Enters: samples, image by image. Leaves: one point for each voxel that has any, with the number of its samples.
//!
//! Voxels are those of six grids in perspective: a face of the cube is divided into squares, and distance in steps of the same
//! relative size, so that voxels are about as long as they are wide. Reservoir sampling picks the sample of each voxel that
//! has the least random number; that number depends on the sample's place and its number in the input, so the order of work does not
//! matter, and the order of images does. Where there are more voxels than the limit, all voxels grow to twice their size: which size is reached depends on the samples alone, too.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::image::cube::{FacePoint, direction_to_face};

/// A point of the merged cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MergedPoint {
    /// Relative to the middle of the viewing region, metres.
    pub position: Vec3,
    /// Samples that it stands for.
    pub samples: u32,
}

/// Squares of a face's side at the start: 2^FINEST.
const FINEST: u32 = 11;
/// And where they do not grow any more.
const COARSEST: u32 = 6;
/// Samples that one job finds the voxels of.
const SAMPLES_A_JOB: usize = 4096;
/// Voxels whose nearest face is nearer than this, in metres, are one: logarithms of distances stay finite.
const LEAST_M: f64 = 1e-9;

#[derive(Debug, Clone, Copy)]
struct Voxel {
    /// Random number of the sample that stands for it.
    random: u64,
    position: Vec3,
    samples: u32,
}

type Voxels = HashMap<u64, Voxel, BuildHasherDefault<KeyHasher>>;

/// Hashes of keys: samples come row by row, and those side by side are looked up side by side.
#[derive(Debug, Default)]
struct KeyHasher(u64);

impl std::hash::Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = mix(self.0 ^ u64::from(byte));
        }
    }

    /// Blocks of 16 columns and 4 distances are spread; in a block the last bits, which say where a table begins to look, and the first
    /// ones, by which it tells keys apart, are those of the voxel.
    fn write_u64(&mut self, key: u64) {
        let (column, distance) = (key & 0xf, key >> 40 & 0x3);
        let block = mix((key >> 42) << 36 | (key >> 4 & 0xf_ffff_ffff));
        self.0 = (block & !0xf | (column ^ (5 * distance)) & 0xf) ^ (column << 57) ^ (distance << 61);
    }
}

/// The finaliser of SplitMix64.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The grids while samples arrive.
#[derive(Debug)]
pub struct PointMerger {
    /// By face.
    grids: [Voxels; 6],
    level: u32,
    max_points: usize,
    samples: u64,
}

impl PointMerger {
    /// A merger that keeps at most `max_points` points, unless its coarsest voxels are more.
    pub fn new(max_points: usize) -> PointMerger {
        PointMerger { grids: Default::default(), level: FINEST, max_points, samples: 0 }
    }

    /// Adds samples: ends of rays relative to the middle of the region, which none of them is at.
    pub fn add(&mut self, ends: &[DVec3]) {
        let first = self.samples;
        self.samples += ends.len() as u64;
        let level = self.level;
        let keyed = |(job, ends): (usize, &[DVec3])| {
            let mut of_faces: [Vec<(u64, Voxel)>; 6] = Default::default();
            for (number, &end) in (first + (job * SAMPLES_A_JOB) as u64..).zip(ends) {
                let (face, key) = voxel_key(end, level);
                let bits = end.to_array().map(f64::to_bits);
                let place = bits[0] ^ bits[1].rotate_left(21) ^ bits[2].rotate_left(42);
                let voxel = Voxel { random: mix(number ^ mix(place)), position: end.as_vec3(), samples: 1 };
                of_faces[face].push((key, voxel));
            }
            of_faces
        };
        let jobs: Vec<_> = ends.par_chunks(SAMPLES_A_JOB).enumerate().map(keyed).collect();
        (self.grids.par_iter_mut().enumerate()).for_each(|(face, grid)| {
            jobs.iter().flat_map(|of_faces| &of_faces[face]).for_each(|(key, voxel)| join(grid, *key, *voxel));
        });
        while self.point_count() > self.max_points && self.level > COARSEST {
            self.level -= 1;
            for grid in &mut self.grids {
                let mut coarser = Voxels::default();
                for (key, voxel) in std::mem::take(grid) {
                    join(&mut coarser, coarser_key(key), voxel);
                }
                *grid = coarser;
            }
        }
    }

    pub fn point_count(&self) -> usize {
        self.grids.iter().map(Voxels::len).sum()
    }

    /// The points in the order of faces and voxels.
    pub fn finish(self) -> Vec<MergedPoint> {
        let mut points = Vec::with_capacity(self.point_count());
        for grid in self.grids {
            let mut voxels: Vec<(u64, Voxel)> = grid.into_iter().collect();
            voxels.sort_unstable_by_key(|(key, _)| *key);
            points.extend(
                voxels.into_iter().map(|(_, Voxel { position, samples, .. })| MergedPoint { position, samples }),
            );
        }
        points
    }
}

fn join(grid: &mut Voxels, key: u64, voxel: Voxel) {
    let held = grid.entry(key).or_insert(Voxel { samples: 0, random: u64::MAX, ..voxel });
    let is_chosen = (voxel.random, voxel.position.to_array().map(f32::to_bits))
        < (held.random, held.position.to_array().map(f32::to_bits));
    let samples = held.samples.saturating_add(voxel.samples);
    if is_chosen || held.samples == 0 {
        *held = voxel;
    }
    held.samples = samples;
}

/// Face and voxel of a point: 20 bits each for column and row, 24 for distance.
fn voxel_key(end: DVec3, level: u32) -> (usize, u64) {
    let FacePoint { face, plane } = direction_to_face(end);
    let side = f64::from(1u32 << level);
    let [column, row] = plane.map(|at| ((0.5 * (at + 1.0) * side) as u64).min((1 << level) - 1));
    let [forward, ..] = face.axes();
    let octave = (end.dot(forward).max(LEAST_M) / LEAST_M).ln();
    let depth = (octave * 0.5 * side) as u64;
    (face as usize, depth.min(0xff_ffff) << 40 | row << 20 | column)
}

/// The voxel of twice the size that holds a voxel.
fn coarser_key(key: u64) -> u64 {
    let [depth, row, column] = [key >> 40, key >> 20 & 0xf_ffff, key & 0xf_ffff].map(|at| at / 2);
    depth << 40 | row << 20 | column
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    /// Points on a wall, so dense that many share a voxel.
    fn wall(count: usize) -> Vec<DVec3> {
        let mut random = Random::new(5);
        let mut unit = || f64::from(random.word()) / f64::from(u32::MAX) - 0.5;
        (0..count).map(|_| DVec3::new(2.0, 0.3 * unit(), 0.3 * unit())).collect()
    }

    fn merged(samples: &[DVec3], most: usize, at_once: usize) -> Vec<MergedPoint> {
        let mut merger = PointMerger::new(most);
        samples.chunks(at_once).for_each(|samples| merger.add(samples));
        merger.finish()
    }

    #[test]
    fn counts_add_up_and_do_not_depend_on_how_samples_arrive() {
        let samples = wall(40_000);
        for most in [100_000, 3000] {
            let points = merged(&samples, most, samples.len());
            assert!(points.len() <= most, "{}", points.len());
            assert_eq!(points.iter().map(|point| u64::from(point.samples)).sum::<u64>(), 40_000);
            assert_eq!(points, merged(&samples, most, 777));
            // Each is one of the samples.
            assert!(points.iter().all(|point| samples.iter().any(|sample| sample.as_vec3() == point.position)));
        }
    }

    #[test]
    fn any_sample_of_a_voxel_may_stand_for_it() {
        // The first sample of each voxel would lie on the near side of a voxel that is filled from there.
        let samples: Vec<DVec3> = (0..4000).map(|at| DVec3::new(1.0003 + f64::from(at) * 1e-8, 1e-4, 1e-4)).collect();
        let points = merged(&samples, 1000, samples.len());
        let [point] = points[..] else { panic!("one voxel, not {}", points.len()) };
        assert!(point.position.x > 1.0003 + 4e-7, "{}", point.position.x);
    }
}
