//! Candidate tilings of all tree cells (Seurat 4.2).
//!
//! Takes the merged points, and returns for each tree cell with points its tilings of one, two … K tiles.
//!
//! The points of a cell are clustered as in k-means: each point is assigned to the tile with the lowest energy, and tiles are
//! fitted to their points. The first tiling has one tile. Then the tile with the largest energy is split by adding a tile that is
//! perpendicular to the line of sight, through the point with the largest energy. Each number of tiles gives a tiling, which is
//! kept if its energy is at least 2% lower.

use glam::DVec3;
use rayon::prelude::*;

use super::energy::{EnergyKind, WeightedPoint};
use super::fit::{FitBounds, fit_plane};
use super::fit_displacement::fit_displacement;
use super::points::MergedPoint;
use super::shading::ShortCuts;
use super::tile_plane::TilePlane;
use super::tree::{MAX_LEVEL, PlaneRect, TreeCell, direction};
use codec::effort::Effort;
use codec::error::Result;
use codec::math::random::Random;
use codec::monitor::Monitor;

/// Maximum number of tiles of a tiling: K of Seurat 4.2.
pub const MAX_TILES: usize = 8;

/// Search effort of the fit of candidates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CandidateSettings {
    /// First and last level of the cells that get tilings.
    pub levels: [u32; 2],
    pub max_tiles: usize,
    /// Number of rounds of assignment and refinement for each number of tiles.
    pub rounds: usize,
    /// Number of points that a tile is refined with before the last round.
    pub subset: usize,
    /// Number of points that a tile is refined with in the last round.
    pub last_subset: usize,
    /// Maximum number of evaluations per parameter in Levenberg–Marquardt.
    pub evaluations: usize,
    /// Mean energy of a point below which no further tile is added.
    pub enough: f64,
    pub energy: EnergyKind,
}

/// Energy of each further tile of a cell, relative to the weight of the cell's points: tiles that overlap end at silhouettes, which
/// are less accurate than planes. In squared pixels.
const OVERLAP_PX2: f64 = 0.003;

impl CandidateSettings {
    pub fn of(effort: Effort, energy: EnergyKind) -> CandidateSettings {
        match energy {
            EnergyKind::Paper => CandidateSettings::of_paper(effort),
            // A linear solution takes many points in the time of one step of Levenberg–Marquardt.
            EnergyKind::Picture => {
                let of_paper = CandidateSettings::of_paper(effort);
                let enough = match effort {
                    Effort::Fast => 1e-3,
                    Effort::Normal => 1e-4,
                    Effort::Exhaustive => 0.0,
                };
                let [subset, last_subset] = [of_paper.subset, of_paper.last_subset].map(|points| 4 * points);
                CandidateSettings { subset, last_subset, enough, energy, ..of_paper }
            }
        }
    }

    fn of_paper(effort: Effort) -> CandidateSettings {
        let normal = CandidateSettings {
            levels: [0, MAX_LEVEL],
            max_tiles: MAX_TILES,
            rounds: 3,
            subset: 24,
            last_subset: 96,
            evaluations: 9,
            enough: 1e-8,
            energy: EnergyKind::Paper,
        };
        match effort {
            Effort::Fast => CandidateSettings {
                max_tiles: 4,
                rounds: 2,
                subset: 16,
                last_subset: 32,
                evaluations: 2,
                enough: 1e-7,
                ..normal
            },
            Effort::Normal => normal,
            Effort::Exhaustive => {
                CandidateSettings { rounds: 6, subset: 128, last_subset: 1024, evaluations: 30, enough: 0.0, ..normal }
            }
        }
    }
}

/// Tiles that cover the points of a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Tiling {
    pub planes: Vec<TilePlane>,
    /// Sum of the energy over all samples of the cell.
    pub energy: f64,
}

/// Tilings of all cells of a level, by cell index; empty for cells without points.
#[derive(Debug)]
pub struct CandidateLevel {
    pub level: u32,
    pub tilings: Vec<Vec<Tiling>>,
}

/// Bounds within which candidates are fitted.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Minimum and maximum distance in metres: 1% of the region's radius, and the radius of the geometry.
    pub min_m: f64,
    pub max_m: f64,
    /// Maximum dilation of a cell on each side, in the plane of its face.
    pub margin: f64,
    /// Displacement of a point in pixels times its distance in metres, where the inverse distance has a relative error of 1; in root
    /// mean square over eyes in the region.
    pub sway_px_m: f64,
}

/// Maximum dilation of a cell, as a fraction of its side.
const MARGIN_SHARE: f64 = 1.0 / 32.0;

impl Extent {
    /// Returns the dilated square of a cell's tiles, which overlap those of neighbouring cells.
    pub fn dilated(&self, cell: TreeCell) -> PlaneRect {
        cell.rect(self.margin.min(MARGIN_SHARE * cell.side()))
    }
}

/// Returns the tilings of all cells, by level. Cells without points have no tilings and cost nothing.
///
/// # Errors
/// [`codec::error::Error::Interrupted`] if the monitor is interrupted.
pub fn candidates(
    points: &[MergedPoint],
    extent: &Extent,
    settings: &CandidateSettings,
    short_cuts: ShortCuts,
    monitor: &dyn Monitor,
) -> Result<Vec<CandidateLevel>> {
    let mut sorted: Vec<(u32, WeightedPoint)> = points
        .iter()
        .map(|point| {
            let point = WeightedPoint::new(point, extent.sway_px_m, settings.energy);
            (leaf_order(TreeCell::containing(point.position, MAX_LEVEL)), point)
        })
        .collect();
    sorted.sort_by_key(|(cell, _)| *cell);
    let (cells, points): (Vec<u32>, Vec<WeightedPoint>) = sorted.into_iter().unzip();
    let [first, last] = settings.levels;
    (first..=last)
        .map(|level| {
            let shift = 2 * (MAX_LEVEL - level);
            let mut runs = Vec::new();
            let mut start = 0;
            for run in cells.chunk_by(|a, b| a >> shift == b >> shift) {
                runs.push((run[0] >> shift, start..start + run.len()));
                start += run.len();
            }
            if short_cuts == ShortCuts::Off {
                let mut of_all = vec![0..0; TreeCell::count(level)];
                runs.into_iter().for_each(|(order, run)| of_all[order as usize] = run);
                runs = (0..).zip(of_all).collect();
            }
            let fitted: Vec<(usize, Vec<Tiling>)> = runs
                .into_par_iter()
                .map(|(order, run)| {
                    monitor.check()?;
                    let cell = cell_of(level, order);
                    Ok((cell.index(), tilings(cell, &points[run], extent, settings)))
                })
                .collect::<Result<_>>()?;
            let mut tilings = vec![Vec::new(); TreeCell::count(level)];
            for (index, fitted) in fitted {
                tilings[index] = fitted;
            }
            Ok(CandidateLevel { level, tilings })
        })
        .collect()
}

/// Returns the index of a cell in a depth-first traversal of its level: the face, then two bits for each level.
fn leaf_order(cell: TreeCell) -> u32 {
    let bits = (0..cell.level).map(|at| (cell.row >> at & 1) << (2 * at + 1) | (cell.column >> at & 1) << (2 * at));
    (cell.face as u32) << (2 * cell.level) | bits.sum::<u32>()
}

fn cell_of(level: u32, order: u32) -> TreeCell {
    let bit = |from: u32| (0..level).map(|at| (order >> (2 * at + from) & 1) << at).sum();
    let root = TreeCell::ROOTS[((order >> (2 * level)) as usize).min(5)];
    TreeCell { level, column: bit(0), row: bit(1), ..root }
}

fn tilings(cell: TreeCell, points: &[WeightedPoint], extent: &Extent, settings: &CandidateSettings) -> Vec<Tiling> {
    if points.is_empty() {
        return Vec::new();
    }
    let corners = extent.dilated(cell).corners().map(|corner| direction(cell.face, corner).normalize());
    let bounds = FitBounds { corners, min_m: extent.min_m, max_m: extent.max_m };
    let total: f64 = points.iter().map(|point| point.weight).sum();
    let mut random = Random::new(u64::from(leaf_order(cell)) << 8 | u64::from(cell.level));
    let mean: DVec3 = points.iter().map(|point| point.weight * point.position).sum::<DVec3>() / total;
    let mut clusters = Clusters {
        planes: vec![TilePlane::fronto_parallel(if mean.length() > extent.min_m { mean } else { points[0].position })],
        owner: vec![0; points.len()],
        energy: vec![0.0; points.len()],
    };
    let overlap = if settings.energy == EnergyKind::Picture { OVERLAP_PX2 * total } else { 0.0 };
    let mut least = f64::INFINITY;
    let mut found: Vec<Tiling> = Vec::new();
    for count in 1..=settings.max_tiles.min(points.len()) {
        if count > 1 {
            clusters.split(points, settings.energy);
        }
        for round in 1..=settings.rounds {
            let subset = if round == settings.rounds { settings.last_subset } else { settings.subset };
            clusters.refine(points, &bounds, (subset, settings), &mut random);
            let changed = clusters.assign(points, settings.energy);
            if count == 1 || !changed {
                break;
            }
        }
        let energy = points.iter().zip(&clusters.energy).map(|(point, energy)| point.weight * energy).sum::<f64>();
        let is_better = energy < 0.98 * least;
        let planes = clusters.planes_with_points();
        if is_better && planes.iter().all(|&plane| bounds.admits(plane)) {
            // If planes have lost all of their points, the tiling has fewer tiles than expected. It replaces tilings with as many
            // or more tiles, since its energy is lower.
            found.retain(|tiling| tiling.planes.len() < planes.len());
            least = energy;
            let energy = energy + overlap * (planes.len() - 1) as f64;
            found.push(Tiling { planes, energy });
        }
        if energy <= settings.enough * total {
            break;
        }
    }
    if cell.level == 0 || found.is_empty() {
        found.push(face_tiling(cell, points, total, settings.energy));
    }
    found
}

/// Returns a tiling of one tile parallel to the face of the cube, which takes two triangles at any texture resolution. Six of
/// these tiles are the minimum that covers everything.
fn face_tiling(cell: TreeCell, points: &[WeightedPoint], total: f64, kind: EnergyKind) -> Tiling {
    let [forward, ..] = cell.face.axes();
    let depth = points.iter().map(|point| point.weight * point.position.dot(forward)).sum::<f64>() / total;
    let plane = TilePlane(forward / depth);
    Tiling { planes: vec![plane], energy: kind.sum(plane, points) }
}

struct Clusters {
    planes: Vec<TilePlane>,
    /// Index of the plane of each point.
    owner: Vec<usize>,
    energy: Vec<f64>,
}

impl Clusters {
    fn planes_with_points(&self) -> Vec<TilePlane> {
        let mut has_points = vec![false; self.planes.len()];
        self.owner.iter().for_each(|&owner| has_points[owner] = true);
        self.planes.iter().zip(has_points).filter(|(_, has_points)| *has_points).map(|(plane, _)| *plane).collect()
    }

    /// Assigns each point to the plane with the lowest energy. Returns true if any point changed its plane.
    fn assign(&mut self, points: &[WeightedPoint], kind: EnergyKind) -> bool {
        let mut changed = false;
        for (point, (owner, energy)) in points.iter().zip(self.owner.iter_mut().zip(&mut self.energy)) {
            let mut best = (0, f64::INFINITY);
            for (at, plane) in self.planes.iter().enumerate() {
                let energy = kind.of(*plane, point);
                if energy < best.1 {
                    best = (at, energy);
                }
            }
            changed |= *owner != best.0;
            (*owner, *energy) = best;
        }
        changed
    }

    fn refine(
        &mut self,
        points: &[WeightedPoint],
        bounds: &FitBounds,
        (subset, settings): (usize, &CandidateSettings),
        random: &mut Random,
    ) {
        let mut members: Vec<Vec<WeightedPoint>> = vec![Vec::new(); self.planes.len()];
        let mut seen = vec![0u32; self.planes.len()];
        for (point, &owner) in points.iter().zip(&self.owner) {
            // Reservoir sampling.
            seen[owner] += 1;
            if members[owner].len() < subset {
                members[owner].push(*point);
            } else if let Some(held) = members[owner].get_mut(random.below(seen[owner]) as usize) {
                *held = *point;
            }
        }
        for (plane, members) in self.planes.iter_mut().zip(&members) {
            *plane = match settings.energy {
                EnergyKind::Picture => fit_displacement(members, bounds, *plane),
                EnergyKind::Paper => fit_plane(members, bounds, *plane, settings.evaluations),
            };
        }
    }

    /// Adds a plane that is perpendicular to the line of sight, through the point with the largest energy in the cluster with the
    /// largest energy.
    fn split(&mut self, points: &[WeightedPoint], kind: EnergyKind) {
        let mut sums = vec![0.0; self.planes.len()];
        for (point, (&owner, energy)) in points.iter().zip(self.owner.iter().zip(&self.energy)) {
            sums[owner] += point.weight * energy;
        }
        let largest = (0..sums.len()).max_by(|&a, &b| sums[a].total_cmp(&sums[b])).unwrap_or(0);
        let weighted = |at: usize| points[at].weight * self.energy[at];
        let of_largest = (0..points.len()).filter(|&at| self.owner[at] == largest);
        if let Some(worst) = of_largest.max_by(|&a, &b| weighted(a).total_cmp(&weighted(b))) {
            self.planes.push(TilePlane::fronto_parallel(points[worst].position));
            self.assign(points, kind);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::monitor::Silent;

    const EXTENT: Extent = Extent { min_m: 0.01, max_m: 100.0, margin: 0.01, sway_px_m: 50.0 };
    const KINDS: [EnergyKind; 2] = [EnergyKind::Picture, EnergyKind::Paper];

    fn points(positions: impl Iterator<Item = DVec3>) -> Vec<MergedPoint> {
        positions.map(|position| MergedPoint { position: position.as_vec3(), samples: 1, contrast: 1.0 }).collect()
    }

    fn grid(steps: u32) -> impl Iterator<Item = DVec3> {
        let at = move |step: u32| 1.9 * (f64::from(step) + 0.5) / f64::from(steps) - 0.95;
        (0..steps).flat_map(move |x| (0..steps).map(move |y| DVec3::new(1.0, at(y), at(x))))
    }

    #[test]
    fn two_layers_get_two_tiles() {
        // Every other ray ends on a wall four times as far away.
        let layers = (0..).zip(grid(24)).map(|(at, direction)| direction * if at % 2 == 0 { 1.0 } else { 4.0 });
        let points = points(layers);
        for kind in KINDS {
            let settings = CandidateSettings { levels: [0, 1], ..CandidateSettings::of(Effort::Normal, kind) };
            let levels = candidates(&points, &EXTENT, &settings, ShortCuts::Taken, &Silent).unwrap();
            let tilings = &levels[0].tilings[TreeCell::ROOTS[0].index()];
            assert!(tilings[0].planes.len() == 1 && tilings[0].energy > 50.0, "{:?}", tilings[0]);
            let overlap = if kind == EnergyKind::Picture { 576.0 * OVERLAP_PX2 } else { 0.0 };
            assert!(tilings[1].planes.len() == 2 && tilings[1].energy < overlap + 1e-3, "{:?}", tilings[1]);
            // The third tiling is the one parallel to the face. Other faces have no points.
            assert!(tilings.len() == 3 && tilings[2].planes.len() == 1, "{tilings:?}");
            assert_eq!(levels[1].tilings.iter().filter(|tilings| !tilings.is_empty()).count(), 4);
        }
    }

    #[test]
    fn a_slanted_wall_gets_one_tile_along_it() {
        // Tiles perpendicular to the line of sight would need one tile per point.
        let wall = grid(24).map(|direction| direction / (1.0 + 0.4 * direction.y - 0.3 * direction.z));
        let points = points(wall);
        for kind in KINDS {
            let settings = CandidateSettings { levels: [0, 0], ..CandidateSettings::of(Effort::Fast, kind) };
            let levels = candidates(&points, &EXTENT, &settings, ShortCuts::Taken, &Silent).unwrap();
            let tiling = &levels[0].tilings[TreeCell::ROOTS[0].index()][0];
            assert_eq!(tiling.planes.len(), 1);
            let weighted: Vec<WeightedPoint> =
                points.iter().map(|point| WeightedPoint::new(point, EXTENT.sway_px_m, kind)).collect();
            let across = |distance_m: f64| kind.sum(TilePlane::fronto_parallel(DVec3::X * distance_m), &weighted);
            let best = (1..400).map(|step| across(0.01 * f64::from(step))).fold(f64::INFINITY, f64::min);
            assert!(tiling.energy < 1e-4 * best, "{kind:?}: {} {best}", tiling.energy);
        }
    }

    #[test]
    fn more_tiles_never_fit_worse() {
        let bumps = grid(40).map(|direction| direction * (2.0 + (5.0 * direction.y).sin() * (7.0 * direction.z).cos()));
        let fast = CandidateSettings::of(Effort::Fast, EnergyKind::Paper);
        let levels = candidates(&points(bumps), &EXTENT, &fast, ShortCuts::Taken, &Silent).unwrap();
        for level in &levels[1..] {
            for tilings in &level.tilings {
                assert!(tilings.is_sorted_by(|a, b| a.energy > b.energy && a.planes.len() < b.planes.len()));
            }
        }
        // The finest cells contain one or two points each, which a tile passes through.
        let last = levels.last().map_or(0.0, |level| level.tilings.iter().flatten().map(|tiling| tiling.energy).sum());
        assert!(last < 1.0, "{last}");
    }
}
