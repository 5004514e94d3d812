//! Merging of samples into one point cloud (Seurat 4.1).
//!
//! Takes samples image by image, and returns one point for each voxel that contains samples, with their number.
//!
//! Voxels belong to six perspective grids: each face of the cube is divided into squares, and distance into steps of the same
//! relative size, so that voxels are about as long as they are wide. Reservoir sampling selects the sample of each voxel that has
//! the smallest random number. That number depends on the sample's position and its index in the input, so the result depends on
//! the order of images, but not on the order of work. If there are more voxels than the limit, all voxels grow to twice their
//! size; the final size also depends on the samples alone.
//!
//! Up to `WAITING` samples are collected, then sorted by voxel, and merged with the existing voxels, which are in the same order.

use std::iter::Peekable;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use codec::image::cube::{FacePoint, direction_to_face};

/// Maximum number of points that samples are merged into.
pub const MAX_POINTS: usize = 1_500_000;

/// A point of the merged cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MergedPoint {
    /// Position relative to the centre of the viewing region, in metres.
    pub position: Vec3,
    /// Number of samples that the point represents.
    pub samples: u32,
    /// Sum of the contrasts of these samples.
    pub contrast: f64,
}

/// Contrasts are added as multiples of this part of 1, so that sums do not depend on their order.
const CONTRAST_STEPS: f64 = (1 << 24) as f64;

/// Initial number of squares along a face's side, as a power of two.
const FINEST: u32 = 11;
/// Number of squares, as a power of two, at which voxels stop growing.
const COARSEST: u32 = 6;
/// Number of samples that one job assigns to voxels.
const SAMPLES_A_JOB: usize = 4096;
/// Number of samples that are collected before they are merged; fewer if fewer points are kept.
pub(super) const WAITING: usize = 1 << 19;
pub(super) const VOXEL_BYTES: u64 = size_of::<Voxel>() as u64;
/// Distances below this, in metres, are not distinguished, so that logarithms stay finite.
const MIN_M: f64 = 1e-9;

/// Layout of a key: the face, 21 bits of distance, and 20 bits each of row and column.
const FACE_SHIFT: u32 = 61;
const DISTANCE_SHIFT: u32 = 40;
const ROW_SHIFT: u32 = 20;

#[derive(Debug, Clone, Copy)]
struct Voxel {
    key: u64,
    /// Random number of the sample that represents the voxel.
    random: u64,
    position: Vec3,
    samples: u32,
    contrast: u64,
}

impl Voxel {
    /// Merges samples of the same voxel.
    fn join(&mut self, other: Voxel) {
        let rank = |of: &Voxel| (of.random, of.position.to_array().map(f32::to_bits));
        let samples = self.samples.saturating_add(other.samples);
        let contrast = self.contrast.saturating_add(other.contrast);
        if rank(&other) < rank(self) {
            *self = other;
        }
        (self.samples, self.contrast) = (samples, contrast);
    }
}

/// Applies the finaliser of SplitMix64.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Voxels, to which samples are added.
#[derive(Debug)]
pub struct PointMerger {
    /// Voxels that contain samples, sorted by key.
    voxels: Vec<Voxel>,
    /// Voxels that are not merged yet, in no particular order.
    waiting: Vec<Voxel>,
    level: u32,
    max_points: usize,
    samples: u64,
}

impl PointMerger {
    /// Creates a merger that returns at most `max_points` points, unless the coarsest grid has more.
    pub fn new(max_points: usize) -> PointMerger {
        PointMerger { voxels: Vec::new(), waiting: Vec::new(), level: FINEST, max_points, samples: 0 }
    }

    /// Adds samples, given as ends of rays relative to the centre of the region, and contrasts. No end may be at the centre.
    pub fn add(&mut self, ends: &[(DVec3, f32)]) {
        // In parts, so that an image takes no more memory than the waiting samples.
        ends.chunks(WAITING).for_each(|ends| self.add_part(ends));
    }

    fn add_part(&mut self, ends: &[(DVec3, f32)]) {
        let (first, level) = (self.samples, self.level);
        self.samples += ends.len() as u64;
        let of_job = |(job, ends): (usize, &[(DVec3, f32)])| {
            let mut voxels: Vec<Voxel> = Vec::with_capacity(ends.len());
            for (number, &(end, contrast)) in (first + (job * SAMPLES_A_JOB) as u64..).zip(ends) {
                let bits = end.to_array().map(f64::to_bits);
                let place = bits[0] ^ bits[1].rotate_left(21) ^ bits[2].rotate_left(42);
                let random = mix(number ^ mix(place));
                let contrast = (f64::from(contrast) * CONTRAST_STEPS) as u64;
                let key = voxel_key(end, level);
                push(&mut voxels, Voxel { key, random, position: end.as_vec3(), samples: 1, contrast });
            }
            voxels
        };
        let jobs: Vec<Vec<Voxel>> = ends.par_chunks(SAMPLES_A_JOB).enumerate().map(of_job).collect();
        jobs.into_iter().for_each(|voxels| self.waiting.extend(voxels));
        if self.waiting.len() >= WAITING.min(self.max_points) {
            self.merge();
        }
    }

    /// Merges the waiting voxels. Then all voxels grow until there are few enough.
    fn merge(&mut self) {
        sort_and_join(&mut self.waiting);
        if self.voxels.is_empty() {
            std::mem::swap(&mut self.voxels, &mut self.waiting);
        } else {
            self.voxels = in_order(std::mem::take(&mut self.voxels), &self.waiting);
            self.waiting.clear();
        }
        while self.voxels.len() > self.max_points && self.level > COARSEST {
            self.level -= 1;
            self.voxels.iter_mut().for_each(|voxel| voxel.key = coarser_key(voxel.key));
            sort_and_join(&mut self.voxels);
        }
    }

    /// Returns the points, sorted by face and voxel.
    pub fn finish(mut self) -> Vec<MergedPoint> {
        self.merge();
        let point = |&Voxel { position, samples, contrast, .. }: &Voxel| MergedPoint {
            position,
            samples,
            contrast: contrast as f64 / CONTRAST_STEPS,
        };
        self.voxels.iter().map(point).collect()
    }
}

/// Appends a voxel, or merges it with the last one if both are the same.
fn push(voxels: &mut Vec<Voxel>, voxel: Voxel) {
    match voxels.last_mut() {
        Some(last) if last.key == voxel.key => last.join(voxel),
        _ => voxels.push(voxel),
    }
}

fn sort_and_join(voxels: &mut Vec<Voxel>) {
    voxels.par_sort_unstable_by_key(|voxel| voxel.key);
    voxels.dedup_by(|next, last| {
        let is_same = next.key == last.key;
        if is_same {
            last.join(*next);
        }
        is_same
    });
}

/// Merges two lists that are sorted by key, with each voxel once.
fn in_order(a: Vec<Voxel>, b: &[Voxel]) -> Vec<Voxel> {
    let mut voxels = Vec::with_capacity(a.len() + b.len());
    let (mut a, mut b) = (a.into_iter().peekable(), b.iter().copied().peekable());
    while let Some(voxel) = next_of(&mut a, &mut b) {
        push(&mut voxels, voxel);
    }
    voxels
}

fn next_of(
    a: &mut Peekable<impl Iterator<Item = Voxel>>,
    b: &mut Peekable<impl Iterator<Item = Voxel>>,
) -> Option<Voxel> {
    match (a.peek(), b.peek()) {
        (Some(of_a), Some(of_b)) if of_b.key < of_a.key => b.next(),
        (Some(_), _) => a.next(),
        (None, _) => b.next(),
    }
}

fn voxel_key(end: DVec3, level: u32) -> u64 {
    let FacePoint { face, plane } = direction_to_face(end);
    let side = f64::from(1u32 << level);
    let [column, row] = plane.map(|at| ((0.5 * (at + 1.0) * side) as u64).min((1 << level) - 1));
    let [forward, ..] = face.axes();
    let octave = (end.dot(forward).max(MIN_M) / MIN_M).ln();
    let distance = ((octave * 0.5 * side) as u64).min((1 << (FACE_SHIFT - DISTANCE_SHIFT)) - 1);
    (face as u64) << FACE_SHIFT | distance << DISTANCE_SHIFT | row << ROW_SHIFT | column
}

/// Returns the key of the voxel of twice the size that contains a voxel.
fn coarser_key(key: u64) -> u64 {
    let (face, place) = (key >> FACE_SHIFT << FACE_SHIFT, key & ((1 << FACE_SHIFT) - 1));
    // Halves each of the three numbers.
    let last_bits = 1 << DISTANCE_SHIFT | 1 << ROW_SHIFT | 1;
    face | (place & !last_bits) >> 1
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use codec::math::random::Random;

    /// Returns points on a wall, so dense that many share a voxel.
    fn wall(count: usize) -> Vec<DVec3> {
        let mut random = Random::new(5);
        let mut unit = || f64::from(random.word()) / f64::from(u32::MAX) - 0.5;
        (0..count).map(|_| DVec3::new(2.0, 0.3 * unit(), 0.3 * unit())).collect()
    }

    fn merged(samples: &[DVec3], most: usize, at_once: usize) -> Vec<MergedPoint> {
        let mut merger = PointMerger::new(most);
        let with_contrast: Vec<(DVec3, f32)> = samples.iter().map(|&end| (end, 0.5)).collect();
        with_contrast.chunks(at_once).for_each(|samples| merger.add(samples));
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
            // Each point is one of the samples.
            assert!(points.iter().all(|point| samples.iter().any(|sample| sample.as_vec3() == point.position)));
        }
    }

    /// Merges by definition: assigns each sample to its voxel at the finest size with few enough voxels, and selects the sample
    /// with the smallest random number in each voxel.
    fn merged_plainly(samples: &[DVec3], most: usize) -> Vec<MergedPoint> {
        let of_level = |level: u32| {
            let mut voxels: BTreeMap<u64, Vec<(u64, Vec3)>> = BTreeMap::new();
            for (number, &end) in (0..).zip(samples) {
                let [x, y, z] = end.to_array().map(f64::to_bits);
                let random = mix(number ^ mix(x ^ y.rotate_left(21) ^ z.rotate_left(42)));
                voxels.entry(voxel_key(end, level)).or_default().push((random, end.as_vec3()));
            }
            voxels
        };
        let voxels = (COARSEST..=FINEST).rev().map(of_level).find(|voxels| voxels.len() <= most).unwrap();
        let point = |samples: &Vec<(u64, Vec3)>| {
            let (_, position) = samples.iter().min_by_key(|(random, _)| *random).unwrap();
            MergedPoint { position: *position, samples: samples.len() as u32, contrast: 0.5 * samples.len() as f64 }
        };
        voxels.values().map(point).collect()
    }

    #[test]
    fn points_are_those_of_the_definition() {
        let mut random = Random::new(9);
        let mut unit = || f64::from(random.word()) / f64::from(u32::MAX) - 0.5;
        let sign = |at: u32| if at.is_multiple_of(2) { 1.0 } else { -1.0 };
        let samples: Vec<DVec3> = (0..20_000)
            .map(|at| DVec3::new(2.0 * sign(at), 0.3 * unit(), 0.3 * unit()) * (0.2 * unit()).exp())
            .collect();
        for most in [100_000, 12_000, 3000] {
            assert_eq!(merged(&samples, most, 333), merged_plainly(&samples, most));
        }
    }

    #[test]
    fn voxels_grow_to_those_that_hold_them() {
        for end in wall(500).into_iter().chain([DVec3::new(-0.3, -7.0, 1e5), DVec3::new(0.1, 0.2, -1e-12)]) {
            for level in COARSEST..FINEST {
                assert_eq!(coarser_key(voxel_key(end, level + 1)), voxel_key(end, level), "{end}");
            }
        }
    }

    #[test]
    fn any_sample_of_a_voxel_may_stand_for_it() {
        // The samples fill a voxel from its near side, where the first sample lies.
        let samples: Vec<DVec3> = (0..4000).map(|at| DVec3::new(1.0003 + f64::from(at) * 1e-8, 1e-4, 1e-4)).collect();
        let points = merged(&samples, 1000, samples.len());
        let [point] = points[..] else { panic!("one voxel, not {}", points.len()) };
        assert!(point.position.x > 1.0003 + 4e-7, "{}", point.position.x);
    }
}
