//! Merging of samples into one point cloud (Seurat 4.1).
//!
//! Enters: samples, image by image. Leaves: one point for each voxel that has any, with the number of its samples.
//!
//! Voxels are those of six grids in perspective: a face of the cube is divided into squares, and distance in steps of the same
//! relative size, so that voxels are about as long as they are wide. Reservoir sampling picks the sample of each voxel that has the least
//! random number; that number depends on the sample's place alone, so the order of work does not matter. Where there are more voxels than
//! the limit, all voxels grow to twice their size: which size is reached depends on the samples alone, too.
//!
//! Samples wait in a list until there are many, which are sorted by voxel and joined. Keys of voxels interleave the bits of column, row
//! and distance (Morton order): the voxels of a larger one follow each other, whatever its size, and one pass counts those of all sizes.

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
/// Steps of distance in an octave at the start: relative steps are as large as squares, 2 / 2^FINEST.
const STEPS_AN_OCTAVE: f64 = 0.5 * (1u64 << FINEST) as f64 * std::f64::consts::LN_2;

#[derive(Debug, Clone, Copy)]
struct Voxel {
    key: u64,
    point: MergedPoint,
}

/// The voxels while samples arrive.
#[derive(Debug)]
pub struct PointMerger {
    /// Those that are joined, in order, and those that wait.
    voxels: Vec<Voxel>,
    joined: usize,
    level: u32,
    max_points: usize,
}

impl PointMerger {
    /// A merger that keeps at most `max_points` points, unless its coarsest voxels are more.
    pub fn new(max_points: usize) -> PointMerger {
        PointMerger { voxels: Vec::new(), joined: 0, level: FINEST, max_points }
    }

    /// Adds samples: ends of rays relative to the middle of the region, which none of them is at.
    pub fn add(&mut self, ends: &[DVec3]) {
        for ends in ends.chunks(self.max_points.max(1)) {
            let bits = 3 * (FINEST - self.level);
            let of_job = |ends: &[DVec3]| {
                let mut voxels: Vec<Voxel> = Vec::with_capacity(ends.len());
                for &end in ends {
                    let key = voxel_key(end) >> bits;
                    let point = MergedPoint { position: end.as_vec3(), samples: 1 };
                    // Samples side by side often share a voxel.
                    match voxels.last_mut() {
                        Some(last) if last.key == key => last.point.join(point),
                        _ => voxels.push(Voxel { key, point }),
                    }
                }
                voxels
            };
            let jobs: Vec<_> = ends.par_chunks(SAMPLES_A_JOB).map(of_job).collect();
            jobs.iter().for_each(|voxels| self.voxels.extend(voxels));
            // As many wait as may be held.
            if self.voxels.len() - self.joined >= self.max_points {
                self.join();
            }
        }
    }

    /// Joins the samples of each voxel; voxels grow until there are few enough.
    fn join(&mut self) {
        self.voxels.par_sort_unstable_by_key(|voxel| voxel.key);
        let growth = self.growth();
        self.level -= growth;
        let mut count = 0;
        for at in 0..self.voxels.len() {
            let Voxel { key, point } = self.voxels[at];
            let key = key >> (3 * growth);
            if count > 0 && self.voxels[count - 1].key == key {
                self.voxels[count - 1].point.join(point);
            } else {
                self.voxels[count] = Voxel { key, point };
                count += 1;
            }
        }
        self.voxels.truncate(count);
        self.joined = count;
    }

    /// How often voxels, in order, have to grow.
    fn growth(&self) -> u32 {
        let most = self.level - COARSEST;
        // Voxels that differ from the one before them until all grew so often, and then not.
        let mut differ = [0; (FINEST - COARSEST + 2) as usize];
        for pair in self.voxels.windows(2) {
            let bits = u64::BITS - (pair[0].key ^ pair[1].key).leading_zeros();
            differ[bits.div_ceil(3).min(most + 1) as usize] += 1;
        }
        let count = |growth: u32| 1 + differ[growth as usize + 1..].iter().sum::<usize>();
        (0..most).find(|&growth| count(growth) <= self.max_points).unwrap_or(most)
    }

    /// The points, voxels that are near each other following each other.
    pub fn finish(mut self) -> Vec<MergedPoint> {
        self.join();
        self.voxels.into_iter().map(|voxel| voxel.point).collect()
    }
}

impl MergedPoint {
    /// One of two points, for the samples of both.
    fn join(&mut self, other: MergedPoint) {
        let samples = self.samples.saturating_add(other.samples);
        if other.random() < self.random() {
            *self = other;
        }
        self.samples = samples;
    }

    /// A random number that depends on the place, which decides where two have the same.
    fn random(&self) -> (u64, [u32; 3]) {
        let bits = self.position.to_array().map(f32::to_bits);
        let [x, y, z] = bits.map(u64::from);
        (mix(mix(x << 32 | y) ^ z), bits)
    }
}

/// The finaliser of SplitMix64.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The voxel of a point at the start: its face, what distance has beyond FINEST bits, and the bits of distance, row and column in turns.
/// Without the last three bits it is the voxel of twice the size that holds it.
fn voxel_key(end: DVec3) -> u64 {
    let FacePoint { face, plane } = direction_to_face(end);
    let side = f64::from(1u32 << FINEST);
    let [column, row] = plane.map(|at| ((0.5 * (at + 1.0) * side) as u64).min((1 << FINEST) - 1));
    let depth = (octaves(end.abs().max_element().max(LEAST_M) / LEAST_M) * STEPS_AN_OCTAVE) as u64;
    let first = (face as u64) << 24 | depth >> FINEST;
    first << (3 * FINEST) | spread(depth & ((1 << FINEST) - 1)) << 2 | spread(row) << 1 | spread(column)
}

/// The logarithm to base 2 of a number that is at least 1, within 0.01; it grows with the number.
fn octaves(number: f64) -> f64 {
    const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;
    let bits = number.to_bits();
    let one = 1f64.to_bits();
    let part = f64::from_bits(bits & ((1 << MANTISSA) - 1) | one) - 1.0;
    ((bits >> MANTISSA) - (one >> MANTISSA)) as f64 + part + 0.34 * part * (1.0 - part)
}

/// Every bit of a number of at most 12 bits at three times its place.
fn spread(number: u64) -> u64 {
    let number = (number | number << 16) & 0xff00_00ff;
    let number = (number | number << 8) & 0xf_00f0_0f00_f00f;
    let number = (number | number << 4) & 0xc3_0c30_c30c_30c3;
    (number | number << 2) & 0x249_2492_4924_9249
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
    fn voxels_are_about_as_long_as_wide_and_grow_to_twice_their_size() {
        for number in (0..4000).map(|step| 1.0 + f64::from(step) * 0.37) {
            assert!((octaves(number) - number.log2()).abs() < 0.01, "{number}");
        }
        for at in 0..1 << FINEST {
            let bits = (0..u64::from(FINEST)).map(|bit| (at >> bit & 1) << (3 * bit));
            assert_eq!(spread(at), bits.sum::<u64>());
        }
        // Points 1 m before a face, side by side and behind each other.
        let count = |end: &dyn Fn(f64) -> DVec3, bits: u32| {
            let mut keys: Vec<u64> = (0..10_000).map(|at| voxel_key(end(f64::from(at) * 1e-4)) >> bits).collect();
            keys.dedup();
            keys.len() as f64
        };
        for level in 0..4 {
            let wanted = f64::from(1u32 << (FINEST - 1 - level));
            let columns = count(&|at| DVec3::new(1.0, at, -0.5), 3 * level);
            let depths = count(&|at| DVec3::new(1.0, 0.1, 0.1) * at.exp(), 3 * level);
            assert!((columns / wanted - 1.0).abs() < 0.01, "{columns} of {wanted}");
            assert!((depths / wanted - 1.0).abs() < 0.05, "{depths} of {wanted}");
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
