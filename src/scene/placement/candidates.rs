//! Candidate positions, spread evenly over the region outside of solids.

use glam::DVec3;
use rayon::prelude::*;

use super::region::{Region, Volume};
use super::sampled_scene::SampledScene;
use super::sequence;
use codec::error::{Error, Result};

/// Maximum number of positions tested per candidate.
const TRIES: usize = 64;
/// Minimum size of a volume along an axis, as a fraction of the region's diagonal. It gives flat volumes a share of the
/// candidates.
const THINNEST: f64 = 1e-3;

/// Minimum distance between cameras of [`FreeSpace::hammersley`], as a fraction of the spacing of an even grid.
pub const APART: f64 = 0.5;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CandidateKind {
    /// Low-discrepancy sequence; the search refines the best candidates.
    #[default]
    Refined,
    /// Uniform grid (CALF 4.2).
    Grid,
}

/// The part of the region that is outside of solids.
#[derive(Debug, Clone, Copy)]
pub struct FreeSpace<'a> {
    pub sampled: &'a SampledScene,
    pub region: &'a Region,
    /// Minimum distance to a surface, in metres.
    pub clearance_m: f64,
}

impl FreeSpace<'_> {
    pub fn admits(&self, position: DVec3) -> bool {
        self.region.contains(position) && self.sampled.is_free(position, self.clearance_m)
    }

    /// Returns about `wanted` candidates. Fails if there is no free space.
    pub fn candidates(&self, kind: CandidateKind, wanted: usize) -> Result<Vec<DVec3>> {
        let found: Vec<DVec3> = match kind {
            CandidateKind::Refined => self.refined(wanted),
            CandidateKind::Grid => {
                grid(self.region, wanted).into_par_iter().filter(|point| self.admits(*point)).collect()
            }
        };
        if found.is_empty() { Err(self.no_space()) } else { Ok(found) }
    }

    fn refined(&self, wanted: usize) -> Vec<DVec3> {
        let shares = shares(self.region);
        let mut found = Vec::new();
        let mut tried = 0;
        while found.len() < wanted && tried < TRIES * wanted {
            let free = |at: usize| position(self.region, &shares, at as u64).filter(|point| self.admits(*point));
            found.par_extend((tried..tried + wanted).into_par_iter().filter_map(free));
            tried += wanted;
        }
        found.truncate(wanted);
        found
    }

    /// Returns positions without a search, as Seurat 3 spreads cameras in the viewer's head box: points of a Hammersley set in
    /// the box around the region that are free and at least [`APART`] of an even spacing from each other. Returns `wanted` of
    /// them in the order of the set (along x), or fewer if the free space does not allow for more.
    pub fn hammersley(&self, wanted: usize) -> Result<Vec<DVec3>> {
        let bounds = self.region.bounds();
        let apart_m = APART * self.spacing_m(wanted);
        let mut count = wanted;
        loop {
            let at = |index: usize| {
                let share = sequence::hammersley(index as u64, count as u64);
                Some(bounds.min + share * (bounds.max - bounds.min)).filter(|point| self.admits(*point))
            };
            let admitted: Vec<DVec3> = (0..count).into_par_iter().filter_map(at).collect();
            let mut found: Vec<DVec3> = Vec::new();
            for point in admitted {
                if found.iter().all(|other| other.distance(point) >= apart_m) {
                    found.push(point);
                }
            }
            if found.len() >= wanted || count >= TRIES * wanted {
                return match found.len() {
                    0 => Err(self.no_space()),
                    // Selects points evenly from the whole set.
                    all => Ok((0..wanted.min(all)).map(|at| found[at * all / wanted.min(all)]).collect()),
                };
            }
            // Next larger set that may give enough points.
            let more = count * wanted / found.len().max(1);
            count = more.clamp(count + 1, 2 * count + 1).min(TRIES * wanted);
        }
    }

    fn no_space(&self) -> Error {
        Error::Usage(format!(
            "the region has no free space for a camera: all of it is inside solids, or less than {:.3e} m from a surface; move \
             it, or flip faces of the mesh that point inwards",
            self.clearance_m
        ))
    }

    /// Returns the mean spacing of candidates, in metres.
    pub fn spacing_m(&self, candidates: usize) -> f64 {
        let volume: f64 = self.region.volumes.iter().map(|volume| size(volume, self.region).element_product()).sum();
        (volume / candidates.max(1) as f64).cbrt()
    }
}

/// Returns the size of a volume in metres, which is above 0 for flat volumes.
fn size(volume: &Volume, region: &Region) -> DVec3 {
    let bounds = volume.bounds();
    (bounds.max - bounds.min).max(DVec3::splat(THINNEST * region.diagonal_m()))
}

/// Returns the cumulative shares of candidates of the volumes, by size; the last is 1.
fn shares(region: &Region) -> Vec<f64> {
    let diagonal = region.diagonal_m().max(f64::MIN_POSITIVE);
    let sizes: Vec<f64> =
        region.volumes.iter().map(|volume| (size(volume, region) / diagonal).element_product()).collect();
    let all: f64 = sizes.iter().sum();
    let cumulative = sizes.iter().scan(0.0, |sum, size| {
        *sum += size;
        Some(if all > 0.0 { *sum / all } else { 1.0 })
    });
    cumulative.collect()
}

/// Returns a point of the sequence in one of the volumes; `None` if the point is outside of that volume or inside an earlier one.
fn position(region: &Region, shares: &[f64], index: u64) -> Option<DVec3> {
    // A low-discrepancy sequence selects the volume, so that any run of indices gives each volume its share.
    let turn = (0.5 + (index % (1 << 40)) as f64 * 0.618_033_988_749_894_9).fract();
    let which = shares.partition_point(|share| *share <= turn).min(shares.len() - 1);
    let volume = &region.volumes[which];
    let bounds = volume.bounds();
    let point = bounds.min + sequence::in_cube(index) * (bounds.max - bounds.min);
    let point = point.min(bounds.max);
    let is_first = !region.volumes[..which].iter().any(|other| other.contains(point));
    (volume.contains(point) && is_first).then_some(point)
}

/// Returns the centres of about `wanted` cells of a uniform grid over the box around the region.
fn grid(region: &Region, wanted: usize) -> Vec<DVec3> {
    let bounds = region.bounds();
    let size = bounds.max - bounds.min;
    let least = size.max(DVec3::splat(THINNEST * region.diagonal_m().max(f64::MIN_POSITIVE)));
    let cell = least.max_element() * ((least / least.max_element()).element_product() / wanted.max(1) as f64).cbrt();
    let counts = (least / cell).round().max(DVec3::ONE).to_array().map(|count| (count as usize).min(wanted.max(1)));
    let cells = DVec3::from(counts.map(|count| count as f64));
    let mut points = Vec::new();
    for x in 0..counts[0] {
        for y in 0..counts[1] {
            let at = |z: usize| (DVec3::new(x as f64, y as f64, z as f64) + 0.5) / cells;
            points.extend((0..counts[2]).map(|z| bounds.min + at(z) * size));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Light, Material, Object, SceneAtTime, Shape, Sphere, Texture};

    fn sampled() -> SampledScene {
        let ball = Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 1.0 });
        let object = Object::new(ball, Material::diffuse(Texture::Solid(DVec3::ONE)));
        SampledScene::new(vec![SceneAtTime::new(vec![object], Light::default())], 64).unwrap()
    }

    fn free_space<'a>(sampled: &'a SampledScene, region: &'a Region) -> FreeSpace<'a> {
        FreeSpace { sampled, region, clearance_m: 0.01 }
    }

    #[test]
    fn candidates_fill_the_region_outside_the_ball() {
        let (sampled, region) = (sampled(), Region::parse(&["-2,-2,-2,2,2,2"]).unwrap());
        for kind in [CandidateKind::Refined, CandidateKind::Grid] {
            let found = free_space(&sampled, &region).candidates(kind, 500).unwrap();
            assert!((300..=500).contains(&found.len()), "{kind:?}: {}", found.len());
            assert!(found.iter().all(|at| at.length() > 1.0 && at.abs().max_element() <= 2.0));
            for axis in 0..3 {
                let low = found.iter().filter(|at| at[axis] < 0.0).count() as f64 / found.len() as f64;
                assert!((low - 0.5).abs() < 0.04, "{kind:?}: {low}");
            }
        }
    }

    #[test]
    fn hammersleys_cameras_are_apart_in_the_open_and_everywhere() {
        let (sampled, region) = (sampled(), Region::parse(&["-2,-2,-2,2,2,2"]).unwrap());
        for wanted in [1, 7, 16, 100] {
            let found = free_space(&sampled, &region).hammersley(wanted).unwrap();
            assert_eq!(found.len(), wanted);
            assert!(found.iter().all(|at| at.length() > 1.0 && at.abs().max_element() <= 2.0));
            let apart_m = APART * (64.0 / wanted as f64).cbrt();
            for (at, point) in found.iter().enumerate() {
                assert!(found[..at].iter().all(|other| other.distance(*point) >= apart_m), "{wanted}");
            }
            for axis in 0..3 {
                let low = found.iter().filter(|at| at[axis] < 0.0).count() as f64 / wanted as f64;
                assert!(wanted < 16 || (low - 0.5).abs() < 0.2, "{wanted} {axis}: {low}");
            }
        }
        let inside = Region::parse(&["-0.3,-0.3,-0.3,0.3,0.3,0.3"]).unwrap();
        assert!(free_space(&sampled, &inside).hammersley(4).unwrap_err().to_string().contains("no free space"));
    }

    #[test]
    fn volumes_share_by_size_and_flat_or_tiny_ones_work() {
        let sampled = sampled();
        let shared = Region::parse(&["2,0,0,4,1,1", "-4,0,0,-3,1,1", "2,0,0,3,1,1"]).unwrap();
        let found = free_space(&sampled, &shared).candidates(CandidateKind::Refined, 600).unwrap();
        let large = found.iter().filter(|at| at.x > 0.0).count();
        // The third volume lies in the first, and adds no candidates.
        assert!((380..=420).contains(&large), "{large}");
        for text in ["2,1.5,-2,4,1.5,2", "2,2,2,2,2,2", "sphere:3,0,0,1e-6"] {
            let region = Region::parse(&[text]).unwrap();
            for kind in [CandidateKind::Refined, CandidateKind::Grid] {
                let found = free_space(&sampled, &region).candidates(kind, 50).unwrap();
                assert!(found.iter().all(|at| region.contains(*at)), "{text}");
            }
        }
    }

    #[test]
    fn a_region_inside_something_is_refused() {
        let (sampled, region) = (sampled(), Region::parse(&["-0.3,-0.3,-0.3,0.3,0.3,0.3"]).unwrap());
        let said = free_space(&sampled, &region).candidates(CandidateKind::Refined, 50).unwrap_err().to_string();
        assert!(said.contains("no free space for a camera"), "{said}");
    }
}
