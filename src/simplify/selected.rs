//! Selection of the tiles of a capture (Seurat 4): samples are merged into points, tilings are fitted to the points, and the best
//! tilings that keep the budgets are selected. The result can be stored in a file as words, for texturing by another process.

use std::time::{Duration, Instant};

use glam::DVec3;

use super::budgeted::Budgeted;
use super::budgets::{CONSTRAINTS, SelectedTiling};
use super::candidates::{CandidateSettings, Extent, candidates};
use super::capture::Capture;
use super::cost::{CostModel, MAX_PARTS, ViewShares};
use super::cracks::eye_side;
use super::extended::{ExtendedTiles, Extender, Surroundings};
use super::gaps::SeenDirections;
use super::gbuffer;
use super::overdraw::OverdrawMeter;
use super::points::{MAX_POINTS, PointMerger};
use super::region::ViewingRegion;
use super::samples::SampleRules;
use super::selection::{Bounds, Selection};
use super::settings::{Settings, SurfaceAtlases, TilingKind};
use super::texturing::Texturing;
use super::tile_plane::TilePlane;
use super::tiles::QuadTile;
use super::tree::{MAX_LEVEL, PlaneRect, TreeCell};
use codec::effort::Effort;
use codec::error::{Error, Result};
use codec::image::Face;
use codec::monitor::Monitor;

/// Level of the uniform tiling (Seurat 7, figure 13).
const UNIFORM_LEVEL: u32 = 6;
/// Minimum side of a tree cell, in pixels of the capture.
const MIN_CELL_PIXELS: f64 = 4.0;
/// Fraction of the budgets that is left for tiles that are extended over gaps.
const GAP_SHARE: f64 = 0.1;
/// Maximum ratio of the energy with that reserve to the energy without it: beyond it, errors of surfaces are more visible than gaps.
const GAP_ENERGY: f64 = 2.0;

const _: () = assert!(UNIFORM_LEVEL <= MAX_LEVEL);

/// Counts of the input of selection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    pub samples: u64,
    /// Number of samples in the viewing region that were left out.
    pub dropped_samples: u64,
    pub points: u64,
    pub candidates: u64,
    /// Number of tree cells with samples.
    pub fitted_cells: u64,
    /// Number of tiles that were extended over gaps.
    pub extended_tiles: u64,
}

#[derive(Debug, Clone)]
pub struct SelectedTiles {
    pub region: ViewingRegion,
    /// Greatest coordinate of the surfaces relative to the centre of the region, in metres, without the sky; 0 without surfaces.
    pub surface_m: f64,
    /// Directions in which the capture has surfaces.
    pub seen: SeenDirections,
    /// Tiles in drawing order.
    pub tiles: Vec<QuadTile>,
    pub selection: Selection,
    /// Triangles, area in spheres, and the measured overdraw of the view with the most.
    pub used: [f64; 3],
    /// Fraction of the rays from eyes in the region that meet no surface that a camera has seen; `None` without a sky.
    pub unsupported: Option<f64>,
    pub counts: Counts,
    /// Durations of merging, candidates, selection, and extension over gaps.
    pub durations: [Duration; 4],
    pub notes: Vec<String>,
}

/// Supported radii of viewing regions, in metres.
const RADII_M: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

/// Selects the tiles of a capture.
pub fn select(capture: &mut Capture, settings: &Settings, monitor: &dyn Monitor) -> Result<SelectedTiles> {
    if settings.surfaces == SurfaceAtlases::GBuffer {
        gbuffer::check(capture)?;
    }
    let mut notes = Vec::new();
    let region = viewing_region(capture, settings, &mut notes)?;
    let rules = SampleRules {
        region: &region,
        background: settings.background,
        inside: settings.inside,
        baked: settings.baked,
    };

    let begun = Instant::now();
    let mut merger = PointMerger::new(MAX_POINTS);
    let (mut samples, mut dropped_samples, mut farthest_m, mut surface_m) = (0, 0, 0f64, 0f64);
    rules.ends_of_all_images(capture, monitor, |ends, left_out| {
        dropped_samples += left_out;
        samples += ends.len() as u64;
        farthest_m = ends.iter().map(|(end, _)| end.length()).fold(farthest_m, f64::max);
        surface_m = ends.iter().filter_map(|&(end, _)| region.surface_m(end)).fold(surface_m, f64::max);
        merger.add(&ends);
    })?;
    if samples == 0 {
        return Err(Error::Usage(match dropped_samples {
            0 => "there are no samples: the capture shows no surface".to_owned(),
            count => format!("all {count} samples lie in the viewing region: set a smaller `region`"),
        }));
    }
    let points = merger.finish();
    let merged = begun.elapsed();

    let extent = Extent {
        min_m: region.min_m(),
        max_m: farthest_m,
        margin: 1.0 / capture.pixels_per_unit(),
        sway_px_m: region.offset_m() * capture.pixels_per_unit(),
    };
    let mut fitting = CandidateSettings::of(settings.effort, settings.energy);
    // Smaller cells would have no sample in some places, which would leave holes.
    let finest = (2.0 * capture.pixels_per_unit() / MIN_CELL_PIXELS).max(1.0).log2() as u32;
    fitting.levels[1] = finest.min(fitting.levels[1]);
    if settings.tiling == TilingKind::Uniform {
        fitting.levels = [UNIFORM_LEVEL.min(finest); 2];
    }
    let levels = candidates(&points, &extent, &fitting, settings.short_cuts, monitor)?;
    let cells = || levels.iter().flat_map(|level| &level.tilings);
    let counts = Counts {
        samples,
        dropped_samples,
        points: points.len() as u64,
        candidates: cells().flatten().map(|tiling| tiling.planes.len() as u64).sum(),
        fitted_cells: cells().filter(|tilings| !tilings.is_empty()).count() as u64,
        extended_tiles: 0,
    };
    let fitted = begun.elapsed();
    monitor.check()?;

    let model = cost_model(extent, &region, settings);
    let costs = model.costs(&levels);
    let shares = ViewShares::of_trees();
    let effort = match settings.effort {
        Effort::Fast => (200, 1e-2),
        Effort::Normal => (600, 1e-3),
        Effort::Exhaustive => (3000, 1e-5),
    };
    let meter = OverdrawMeter::new(region.border());
    let budgeted = Budgeted {
        levels: &levels,
        costs: &costs,
        shares: &shares,
        model: &model,
        meter: &meter,
        budgets: settings.budgets,
        effort,
    };
    let seen = SeenDirections::new(points.iter().map(|point| point.position.as_dvec3()));
    drop(points);
    let extender = Extender {
        texturing: Texturing::new(capture, settings, &region),
        surroundings: Surroundings {
            region: &region,
            seen: &seen,
            background: settings.background,
            eye_side: eye_side(capture),
        },
        model: &model,
        shares: &shares,
        meter: &meter,
        settings,
    };
    let selected = match budgeted.select(GAP_SHARE, monitor) {
        Err(Error::Usage(_)) => budgeted.select(0.0, monitor)?,
        Ok(reserved) if !reserved.selection.limits().is_empty() => {
            let whole = budgeted.select(0.0, monitor)?;
            let is_whole = GAP_ENERGY * whole.selection.primal < reserved.selection.primal;
            if is_whole { whole } else { reserved }
        }
        selected => selected?,
    };
    drop((levels, costs));
    let chosen = begun.elapsed();
    let ExtendedTiles { selection, tiles, used, count, unsupported } = extender.extend(selected, capture, monitor)?;
    let counts = Counts { extended_tiles: count, ..counts };
    let durations = [merged, fitted - merged, chosen - fitted, begun.elapsed() - chosen];
    let tiles = tiles.tiles;
    Ok(SelectedTiles { region, surface_m, seen, tiles, selection, used, unsupported, counts, durations, notes })
}

pub(super) fn cost_model(extent: Extent, region: &ViewingRegion, settings: &Settings) -> CostModel {
    CostModel { extent, eyes: region.border(), texture_coordinates: settings.texture_coordinates }
}

/// Returns the viewing region of a capture. Notes state how it was determined.
fn viewing_region(capture: &mut Capture, settings: &Settings, notes: &mut Vec<String>) -> Result<ViewingRegion> {
    let mut region = match &settings.region {
        Some(region) => ViewingRegion::given(region.clone()),
        None => ViewingRegion::around(capture.images.iter().map(|image| image.eye)),
    };
    if !region.has_extent() {
        region.grow(capture.nearest_m()?);
        let place =
            if settings.region.is_some() { "the `region` has no extent" } else { "all cameras have the same position" };
        notes.push(format!(
            "{place}: the viewing region is a cube of radius {:.4} m around it, a tenth of the distance of the nearest surface; see \
             `region`",
            region.radius()
        ));
    }
    if !region.radius().is_finite() || region.radius() <= 0.0 {
        return Err(Error::Usage("the viewing region has no extent and no surface is near: set `region`".into()));
    }
    // Vertices are in single precision.
    let place = region.middle.abs().max_element();
    if !RADII_M.contains(&region.radius()) || place * f64::from(f32::EPSILON) > region.radius() {
        return Err(Error::Usage(format!(
            "the viewing region has a radius of {:e} m at {place:e} m from the origin, which single precision cannot \
            represent: scale the scene, or move it to the origin",
            region.radius()
        )));
    }
    if !capture.images.iter().any(|image| region.admits(image.eye - region.middle)) {
        notes.push(
            "no camera is in the viewing region: surfaces that are visible from the region but not from a camera are \
            missing; see `region`"
                .into(),
        );
    }
    Ok(region)
}

impl SelectedTiles {
    /// Serialises all fields except the region and the notes.
    pub fn to_words(&self) -> Vec<u64> {
        let Selection { tilings, primal, dual, prices, iterations, convergence, used, capacity } = &self.selection;
        let Counts { samples, dropped_samples, points, candidates, fitted_cells, extended_tiles } = self.counts;
        let mut words = vec![samples, dropped_samples, points, candidates, fitted_cells, extended_tiles];
        words.extend(self.durations.map(|duration| duration.as_nanos() as u64));
        words.push(self.surface_m.to_bits());
        words.extend(self.used.map(f64::to_bits));
        // No fraction is below 0.
        words.push(self.unsupported.unwrap_or(-1.0).to_bits());
        words.extend([primal.to_bits(), dual.to_bits(), *iterations as u64]);
        words.extend([prices, used, capacity].into_iter().flatten().map(|value| value.to_bits()));
        words.push(convergence.len() as u64);
        words.extend(convergence.iter().flat_map(|bounds| [bounds.dual.to_bits(), bounds.primal.to_bits()]));
        words.push(tilings.len() as u64);
        for SelectedTiling { cell, tiling } in tilings {
            words.extend(words_of_cell(*cell));
            words.push(*tiling as u64);
        }
        words.push(self.tiles.len() as u64);
        for QuadTile { cell, plane, rect, divisions } in &self.tiles {
            words.extend(words_of_cell(*cell));
            words.extend(plane.0.to_array().map(f64::to_bits));
            words.extend([rect.min, rect.max].concat().into_iter().map(f64::to_bits));
            words.extend(divisions.map(u64::from));
        }
        words.extend(self.seen.to_words());
        words
    }

    /// Reads the result of [`Self::to_words`] for a capture with the same settings; `None` if the words are not valid.
    pub fn of_words(words: &[u64], capture: &mut Capture, settings: &Settings) -> Result<Option<SelectedTiles>> {
        let mut notes = Vec::new();
        let region = viewing_region(capture, settings, &mut notes)?;
        Ok(read(&mut Words(words.iter()), region, notes))
    }
}

fn words_of_cell(cell: TreeCell) -> [u64; 4] {
    [cell.face as u64, cell.level.into(), cell.column.into(), cell.row.into()]
}

/// Reader of words.
struct Words<'a>(std::slice::Iter<'a, u64>);

impl Words<'_> {
    fn word(&mut self) -> Option<u64> {
        self.0.next().copied()
    }

    fn float(&mut self) -> Option<f64> {
        self.word().map(f64::from_bits)
    }

    fn floats<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.float()?;
        }
        Some(values)
    }

    fn small(&mut self) -> Option<u32> {
        self.word()?.try_into().ok()
    }

    fn cell(&mut self) -> Option<TreeCell> {
        let face = *Face::CUBE.get(self.word()? as usize)?;
        let cell = TreeCell { face, level: self.small()?, column: self.small()?, row: self.small()? };
        let side = 1u32 << cell.level.min(MAX_LEVEL);
        (cell.level <= MAX_LEVEL && cell.column < side && cell.row < side).then_some(cell)
    }

    /// Reads a count, and that many items.
    fn list<T>(&mut self, mut item: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = self.word()?;
        (0..count).map(|_| item(self)).collect()
    }
}

fn read(words: &mut Words<'_>, region: ViewingRegion, notes: Vec<String>) -> Option<SelectedTiles> {
    let counts = Counts {
        samples: words.word()?,
        dropped_samples: words.word()?,
        points: words.word()?,
        candidates: words.word()?,
        fitted_cells: words.word()?,
        extended_tiles: words.word()?,
    };
    let durations = [words.word()?, words.word()?, words.word()?, words.word()?].map(Duration::from_nanos);
    let surface_m = words.float()?;
    let used_in_all = words.floats()?;
    let unsupported = words.float().map(|share| Some(share).filter(|share| *share >= 0.0))?;
    let (primal, dual, iterations) = (words.float()?, words.float()?, words.word()? as usize);
    let prices = words.floats::<CONSTRAINTS>()?;
    let used = words.floats::<CONSTRAINTS>()?;
    let capacity = words.floats::<CONSTRAINTS>()?;
    let convergence = words.list(|words| Some(Bounds { dual: words.float()?, primal: words.float()? }))?;
    let tilings = words.list(|words| Some(SelectedTiling { cell: words.cell()?, tiling: words.word()? as usize }))?;
    let tiles = words.list(|words| {
        let tile = QuadTile {
            cell: words.cell()?,
            plane: TilePlane(DVec3::from_array(words.floats()?)),
            rect: PlaneRect { min: words.floats()?, max: words.floats()? },
            divisions: [words.small()?, words.small()?],
        };
        let is_met = tile.corners().iter().all(|corner| corner.is_finite());
        (is_met && tile.divisions.iter().all(|parts| (1..=MAX_PARTS).contains(parts))).then_some(tile)
    })?;
    let seen = SeenDirections::of_words(words.0.as_slice())?;
    let selection = Selection { tilings, primal, dual, prices, iterations, convergence, used, capacity };
    Some(SelectedTiles {
        region,
        surface_m,
        seen,
        tiles,
        selection,
        used: used_in_all,
        unsupported,
        counts,
        durations,
        notes,
    })
}
