//! Statistics of the depth images of a probe: near, far, and the distinct distances if there are few. Frames can be scanned in
//! any order and on any machine.

use std::collections::{BTreeMap, HashSet};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use codec::depth::DepthRange;
use codec::depth::predictive::Levels;
use codec::depth::predictive::levels::MAX_LEVELS;
use codec::depth::spread::Spread;
use codec::streams::convert::DepthExtent;

/// Minimum average number of surface pixels per level. With fewer, the small number of distances may be a coincidence.
const MIN_OCCURRENCES: u64 = 64;

/// Scans by probe number.
pub type Scans = BTreeMap<usize, Scan>;

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Scan {
    /// Range of distances; `None` if there is no surface.
    pub extent: Option<DepthExtent>,
    /// True if there are invalid depths that become near.
    pub has_invalid: bool,
    /// The distinct distances of surfaces in metres, ascending, if they are at most [`MAX_LEVELS`] and recur often enough; `None`
    /// otherwise, or if the codec has no levels.
    pub distances_m: Option<Vec<f32>>,
    /// Histogram of pixels by depth, used to find outliers that take much of the precision.
    pub spread: Spread,
}

impl Scan {
    /// Returns true if encodes with either scan have the same bytes.
    pub(super) fn is_as_good_as(&self, other: &Scan) -> bool {
        self.limits() == other.limits() && self.distances_m == other.distances_m
    }

    /// Returns everything that near and far are derived from.
    pub(super) fn limits(&self) -> (Option<DepthExtent>, bool) {
        (self.extent, self.has_invalid)
    }

    /// Returns the codes that occur; empty if there are none, or too many.
    pub(super) fn levels(&self, range: DepthRange) -> Levels {
        let near = self.has_invalid.then_some(0);
        let mut codes: Vec<u16> =
            self.distances_m.iter().flatten().map(|&distance_m| range.code(distance_m)).chain(near).collect();
        codes.sort_unstable();
        codes.dedup();
        match &self.distances_m {
            Some(_) => Levels::new(codes).unwrap_or_default(),
            None => Levels::default(),
        }
    }
}

/// Depth statistics of some frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundDepth {
    /// Range of distances; `None` if there is no surface.
    pub extent: Option<DepthExtent>,
    /// True if there are invalid depths that become near.
    pub has_invalid: bool,
    /// The distinct distances of surfaces in metres, ascending; `None` if there are more than [`MAX_LEVELS`], or if they were not
    /// needed.
    pub distances_m: Option<Vec<f32>>,
    /// Number of surface pixels if `distances_m` is known, else 0: with too many distances each thread stops at a different
    /// pixel, so that the count would not be deterministic.
    pub surfaces: u64,
    pub spread: Spread,
}

impl FoundDepth {
    /// Statistics of no frames, the identity of [`Self::union`].
    pub fn nothing() -> FoundDepth {
        FoundDepth {
            extent: None,
            has_invalid: false,
            distances_m: Some(Vec::new()),
            surfaces: 0,
            spread: Spread::default(),
        }
    }

    pub fn union(self, other: &FoundDepth) -> FoundDepth {
        let distances = match (self.distances_m, &other.distances_m) {
            (Some(mut distances), Some(more)) => {
                distances.extend(more);
                distances = sorted(distances);
                distances.dedup();
                (distances.len() <= MAX_LEVELS).then_some(distances)
            }
            _ => None,
        };
        let extent = [self.extent, other.extent].into_iter().flatten().reduce(DepthExtent::union);
        FoundDepth {
            extent,
            has_invalid: self.has_invalid || other.has_invalid,
            surfaces: if distances.is_some() { self.surfaces + other.surfaces } else { 0 },
            distances_m: distances,
            spread: self.spread.union(&other.spread),
        }
    }

    /// Returns the scan of a probe from the statistics of all its frames.
    pub fn scan(&self) -> Scan {
        let recur = |distances: &&Vec<f32>| distances.len() as u64 * MIN_OCCURRENCES <= self.surfaces;
        let distances_m = self.distances_m.as_ref().filter(recur).cloned();
        Scan { extent: self.extent, has_invalid: self.has_invalid, distances_m, spread: self.spread.clone() }
    }
}

/// Set of distinct surface distances, kept while it is small. Threads add to it in any order.
pub(super) struct Distances {
    /// Bit patterns of the distances; `None` if there are more than [`MAX_LEVELS`], or if they are not needed.
    found: Mutex<Option<HashSet<u32>>>,
    surfaces: AtomicU64,
}

impl Distances {
    pub fn new(are_wanted: bool) -> Distances {
        Distances { found: Mutex::new(are_wanted.then(HashSet::new)), surfaces: AtomicU64::new(0) }
    }

    pub fn add(&self, metres: impl Iterator<Item = f32>) {
        if self.found.lock().unwrap_or_else(PoisonError::into_inner).is_none() {
            return;
        }
        let (mut found, mut last, mut surfaces) = (HashSet::new(), f32::INFINITY, 0);
        for metres in metres.filter(|&metres| metres > 0.0 && metres < f32::INFINITY) {
            surfaces += 1;
            if metres != last && found.insert(metres.to_bits()) && found.len() > MAX_LEVELS {
                break;
            }
            last = metres;
        }
        self.surfaces.fetch_add(surfaces, Ordering::Relaxed);
        let mut all = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = all.as_mut() {
            known.extend(found);
            if known.len() > MAX_LEVELS {
                *all = None;
            }
        }
    }

    /// Returns the distances as statistics without near and far.
    pub fn into_found(self) -> FoundDepth {
        let found = self.found.into_inner().unwrap_or_else(PoisonError::into_inner);
        let distances_m = found.map(|found| sorted(found.into_iter().map(f32::from_bits).collect()));
        let surfaces = if distances_m.is_some() { self.surfaces.into_inner() } else { 0 };
        FoundDepth { distances_m, surfaces, ..FoundDepth::nothing() }
    }
}

fn sorted(mut distances: Vec<f32>) -> Vec<f32> {
    distances.sort_unstable_by(f32::total_cmp);
    distances
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan_of(distances: impl IntoIterator<Item = f32>, has_invalid: bool) -> Scan {
        let distances: Vec<f32> = distances.into_iter().collect();
        let extent = DepthExtent { near_m: distances[0], far_m: distances[distances.len() - 1] };
        Scan { extent: Some(extent), has_invalid, distances_m: Some(distances), spread: Spread::default() }
    }

    #[test]
    fn invalid_depth_is_a_level_of_its_own_where_nothing_lies_at_near() {
        let scan = |has_invalid| scan_of([1.0, 2.5, 4.0], has_invalid);
        let at = |near, scan: Scan| scan.levels(DepthRange::new(near, 4.0).unwrap()).codes().to_vec();
        assert_eq!(at(1.0, scan(true)), at(1.0, scan(false)));
        let (without, with) = (at(0.5, scan(false)), at(0.5, scan(true)));
        assert!(without[0] > 0);
        assert_eq!(with, [&[0][..], &without].concat());
    }

    #[test]
    fn one_level_more_than_the_most_means_none() {
        let range = DepthRange::new(0.5, 5000.0).unwrap();
        let distances = (0..MAX_LEVELS).map(|at| 1.0 + at as f32);
        assert_eq!(scan_of(distances.clone(), false).levels(range).codes().len(), MAX_LEVELS);
        assert!(scan_of(distances, true).levels(range).is_empty());
    }

    #[test]
    fn a_scan_comes_back_from_a_journal_as_it_was() {
        let distances = [1e-45, 0.1, 1.0 / 3.0, 0.7 + 0.37, 16_777_217.0, f32::MAX];
        let scan = scan_of(distances, true);
        let back: Scan = serde_json::from_slice(&serde_json::to_vec(&scan).unwrap()).unwrap();
        assert_eq!(back, scan);
    }

    #[test]
    fn few_distances_that_recur_are_found_in_any_order() {
        let repeated = |values: u64, times: u64| {
            let distances = Distances::new(true);
            for frame in 0..times {
                distances
                    .add((0..values).map(|at| 1.0 + ((at * 7 + frame) % values) as f32).chain([f32::INFINITY, 0.0]));
            }
            few(distances)
        };
        let ascending = |values: u64| Some((0..values).map(|at| 1.0 + at as f32).collect::<Vec<_>>());
        assert_eq!(repeated(5, 64), ascending(5));
        assert_eq!(repeated(4096, 64), ascending(4096));
        assert_eq!(repeated(5, 63), None);
        assert_eq!(repeated(4097, 64), None);
        // Few distances in every frame, many in total.
        let distances = Distances::new(true);
        (0..100).for_each(|frame| distances.add((0..10_000).map(|at| (1 + frame * 50 + at % 50) as f32)));
        assert_eq!(few(distances), None);
        // The number of pixels scanned before stopping is not kept.
        let distances = Distances::new(true);
        distances.add((0..10_000).map(|at| 1.0 + at as f32));
        assert_eq!(distances.into_found(), FoundDepth { distances_m: None, ..FoundDepth::nothing() });
    }

    fn few(distances: Distances) -> Option<Vec<f32>> {
        distances.into_found().scan().distances_m
    }

    #[test]
    fn what_frames_hold_is_the_union_of_what_each_holds() {
        let of = |values: &[f32]| {
            let distances = Distances::new(true);
            distances.add(values.iter().copied());
            distances.into_found()
        };
        let parts = [of(&[1.0, 2.0]), of(&[]), of(&[2.0, 0.5, f32::INFINITY])];
        let union = parts.iter().fold(FoundDepth::nothing(), FoundDepth::union);
        assert_eq!(union, of(&[1.0, 2.0, 2.0, 0.5]));
        let many: Vec<f32> = (0..MAX_LEVELS).map(|at| 1.0 + at as f32).collect();
        assert_eq!(of(&many).union(&of(&[3.0])).distances_m.map(|found| found.len()), Some(MAX_LEVELS));
        assert_eq!(of(&many).union(&of(&[3.5])).distances_m, None);
    }
}
