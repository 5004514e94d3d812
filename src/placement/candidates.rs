//! Positions that cameras may have: in the region, and in the open.
//!
//! Enters: a region and a site. Leaves: candidates spread evenly, and ever better positions around one of them.

use glam::DVec3;
use rayon::prelude::*;

use super::greedy::Choice;
use super::objective::{State, View};
use super::region::{Region, Volume};
use super::sequence;
use super::site::{Facets, Site};
use crate::error::{Error, Result};

/// Positions that are tried for each candidate that is wanted, at most.
const TRIES: usize = 64;
/// Least size of a volume along an axis, as a part of the region's diagonal, for the share of candidates that it gets.
const THINNEST: f64 = 1e-3;

/// How close cameras that are spread without a search may be, as a part of the spacing of as many on an even grid.
pub const APART: f64 = 0.5;

/// How candidates are spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CandidateKind {
    /// By a sequence of low discrepancy, and refined around the best.
    #[default]
    Refined,
    /// On a uniform grid, as in CALF 4.2.
    Grid,
}

/// Where candidates may be.
#[derive(Debug, Clone, Copy)]
pub struct Room<'a> {
    /// The scene.
    pub site: &'a Site,
    /// The region.
    pub region: &'a Region,
    /// Metres to the nearest surface, at least.
    pub clearance_m: f64,
}

impl Room<'_> {
    /// Whether a camera may be at a position.
    pub fn admits(&self, position: DVec3) -> bool {
        self.region.contains(position) && self.site.is_open(position, self.clearance_m)
    }

    /// About `wanted` candidates.
    ///
    /// # Errors
    /// When there is no room for a single one.
    pub fn candidates(&self, kind: CandidateKind, wanted: usize) -> Result<Vec<DVec3>> {
        let found = match kind {
            CandidateKind::Refined => self.spread(wanted),
            CandidateKind::Grid => {
                let points = grid(self.region, wanted);
                let admitted: Vec<bool> = points.par_iter().map(|point| self.admits(*point)).collect();
                points
                    .into_iter()
                    .zip(admitted)
                    .filter(|(_, is_admitted)| *is_admitted)
                    .map(|(point, _)| point)
                    .collect()
            }
        };
        if found.is_empty() {
            return Err(self.no_room());
        }
        Ok(found)
    }

    fn spread(&self, wanted: usize) -> Vec<DVec3> {
        let shares = shares(self.region);
        let mut found = Vec::new();
        let mut tried = 0;
        while found.len() < wanted && tried < TRIES * wanted {
            let batch: Vec<Option<DVec3>> = (tried..tried + wanted)
                .into_par_iter()
                .map(|at| position(self.region, &shares, at as u64).filter(|point| self.admits(*point)))
                .collect();
            tried += wanted;
            found.extend(batch.into_iter().flatten());
        }
        found.truncate(wanted);
        found
    }

    /// Cameras without a search, as for a box in which a viewer's head moves (Seurat 3): `wanted` of Hammersley's points in the
    /// box around the region, of those that are admitted and at least [`APART`] of an even spacing from each other. Fewer where
    /// there is no room for so many. In the order of the set, along x.
    ///
    /// # Errors
    /// When there is no room for a single one.
    pub fn hammersley(&self, wanted: usize) -> Result<Vec<DVec3>> {
        let bounds = self.region.bounds();
        let apart_m = APART * self.spacing_m(wanted);
        let mut count = wanted;
        loop {
            let at = |index: usize| {
                let share = sequence::hammersley(index as u64, count as u64);
                Some(bounds.min + share * (bounds.max - bounds.min)).filter(|point| self.admits(*point))
            };
            let admitted: Vec<Option<DVec3>> = (0..count).into_par_iter().map(at).collect();
            let mut found: Vec<DVec3> = Vec::new();
            for point in admitted.into_iter().flatten() {
                if found.iter().all(|other| other.distance(point) >= apart_m) {
                    found.push(point);
                }
            }
            if found.len() >= wanted || count >= TRIES * wanted {
                return match found.len() {
                    0 => Err(self.no_room()),
                    // As many of them, evenly from all of the set.
                    all => Ok((0..wanted.min(all)).map(|at| found[at * all / wanted.min(all)]).collect()),
                };
            }
            // The next larger set that may have enough.
            let more = count * wanted / found.len().max(1);
            count = more.clamp(count + 1, 2 * count + 1).min(TRIES * wanted);
        }
    }

    fn no_room(&self) -> Error {
        Error::Usage(format!(
            "the region has no room for a camera: everywhere it is inside something, or less than {:.3e} m from a surface; \
             move it, or turn the faces of the mesh outwards where they point inwards",
            self.clearance_m
        ))
    }

    /// Metres between neighbouring candidates, about.
    fn spacing_m(&self, candidates: usize) -> f64 {
        let volume: f64 = self.region.volumes().iter().map(|volume| size(volume, self.region).element_product()).sum();
        (volume / candidates.max(1) as f64).cbrt()
    }

    /// Goes from a candidate to where the gain is larger: in each of `steps` steps the best of six positions along the axes, if
    /// it is better, half as far in each step as in the one before. Adds to `calls` how many gains were asked for.
    pub fn refine(&self, search: &Refinement<'_>, from: (&View, Choice), calls: &mut u64) -> (View, f64) {
        let (mut best, mut gain) = (from.0.clone(), from.1.gain);
        let mut reach = 0.5 * self.spacing_m(search.candidates);
        for _ in 0..search.steps {
            let around = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
            let around = around.map(|axis| best.position + reach * axis);
            for position in around.into_iter().filter(|position| self.admits(*position)) {
                let view = self.site.look(search.facets, position);
                *calls += 1;
                let other = search.state.gain(&view);
                if other > gain {
                    (best, gain) = (view, other);
                }
            }
            reach *= 0.5;
        }
        (best, gain)
    }
}

/// What positions around a candidate are judged by.
#[derive(Debug, Clone, Copy)]
pub struct Refinement<'a> {
    /// The cameras so far.
    pub state: &'a State<'a>,
    /// The facets.
    pub facets: &'a Facets,
    /// How many candidates there are: they tell how far apart they lie.
    pub candidates: usize,
    /// Steps, 0 for none.
    pub steps: usize,
}

/// Metres along each axis, for shares: a flat volume has some.
fn size(volume: &Volume, region: &Region) -> DVec3 {
    let bounds = volume.bounds();
    (bounds.max - bounds.min).max(DVec3::splat(THINNEST * region.diagonal_m()))
}

/// Which part of all candidates falls to the volumes up to and with each; the last is 1.
fn shares(region: &Region) -> Vec<f64> {
    let diagonal = region.diagonal_m().max(f64::MIN_POSITIVE);
    let sizes: Vec<f64> =
        region.volumes().iter().map(|volume| (size(volume, region) / diagonal).element_product()).collect();
    let all: f64 = sizes.iter().sum();
    let mut sum = 0.0;
    sizes
        .iter()
        .map(|size| {
            if all > 0.0 {
                sum += size;
                sum / all
            } else {
                1.0
            }
        })
        .collect()
}

/// The position of an index in the box of a volume, if it lies in the volume and in none before it.
fn position(region: &Region, shares: &[f64], index: u64) -> Option<DVec3> {
    // Which volume: by an even sequence of one dimension, so that any run of indices has its share of each.
    let turn = (0.5 + (index % (1 << 40)) as f64 * 0.618_033_988_749_894_9).fract();
    let which = shares.partition_point(|share| *share <= turn).min(shares.len() - 1);
    let volume = &region.volumes()[which];
    let bounds = volume.bounds();
    let point = bounds.min + sequence::in_cube(index) * (bounds.max - bounds.min);
    let point = point.min(bounds.max);
    let is_first = !region.volumes()[..which].iter().any(|other| other.contains(point));
    (volume.contains(point) && is_first).then_some(point)
}

/// The middles of the cells of a uniform grid over the region's box, about `wanted` of them in the box.
fn grid(region: &Region, wanted: usize) -> Vec<DVec3> {
    let bounds = region.bounds();
    let size = bounds.max - bounds.min;
    let least = size.max(DVec3::splat(THINNEST * region.diagonal_m().max(f64::MIN_POSITIVE)));
    let cell = least.max_element() * ((least / least.max_element()).element_product() / wanted.max(1) as f64).cbrt();
    let counts = (least / cell).round().max(DVec3::ONE).to_array().map(|count| (count as usize).min(wanted.max(1)));
    let mut points = Vec::new();
    for x in 0..counts[0] {
        for y in 0..counts[1] {
            for z in 0..counts[2] {
                let at = DVec3::new(x as f64, y as f64, z as f64) + 0.5;
                points.push(bounds.min + at / DVec3::from(counts.map(|count| count as f64)) * size);
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Light, Material, Object, SceneAtTime, Shape, Sphere, Texture};

    fn site() -> Site {
        let ball = Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 1.0 });
        let object = Object::new(ball, Material::diffuse(Texture::Solid(DVec3::ONE)));
        Site::new(vec![SceneAtTime::new(vec![object], Light::default())], 64).unwrap()
    }

    fn room<'a>(site: &'a Site, region: &'a Region) -> Room<'a> {
        Room { site, region, clearance_m: 0.01 }
    }

    #[test]
    fn candidates_fill_the_region_outside_the_ball() {
        let (site, region) = (site(), Region::parse(&["-2,-2,-2,2,2,2"]).unwrap());
        for kind in [CandidateKind::Refined, CandidateKind::Grid] {
            let found = room(&site, &region).candidates(kind, 500).unwrap();
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
        let (site, region) = (site(), Region::parse(&["-2,-2,-2,2,2,2"]).unwrap());
        for wanted in [1, 7, 16, 100] {
            let found = room(&site, &region).hammersley(wanted).unwrap();
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
        assert!(room(&site, &inside).hammersley(4).unwrap_err().to_string().contains("no room"));
    }

    #[test]
    fn volumes_share_by_size_and_flat_or_tiny_ones_work() {
        let site = site();
        let shared = Region::parse(&["2,0,0,4,1,1", "-4,0,0,-3,1,1", "2,0,0,3,1,1"]).unwrap();
        let found = room(&site, &shared).candidates(CandidateKind::Refined, 600).unwrap();
        let large = found.iter().filter(|at| at.x > 0.0).count();
        // The third lies in the first, and adds none.
        assert!((380..=420).contains(&large), "{large}");
        for text in ["2,1.5,-2,4,1.5,2", "2,2,2,2,2,2", "sphere:3,0,0,1e-6"] {
            let region = Region::parse(&[text]).unwrap();
            for kind in [CandidateKind::Refined, CandidateKind::Grid] {
                let found = room(&site, &region).candidates(kind, 50).unwrap();
                assert!(found.iter().all(|at| region.contains(*at)), "{text}");
            }
        }
    }

    #[test]
    fn a_region_inside_something_is_refused() {
        let (site, region) = (site(), Region::parse(&["-0.3,-0.3,-0.3,0.3,0.3,0.3"]).unwrap());
        let said = room(&site, &region).candidates(CandidateKind::Refined, 50).unwrap_err().to_string();
        assert!(said.contains("no room for a camera"), "{said}");
    }
}
