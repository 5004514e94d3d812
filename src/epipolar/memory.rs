//! Memory need of a run, and the plan that keeps it within a budget: fewer scanlines at once, and views in a file.

use std::path::Path;

use half::f16;

use super::acquire::{AcquireSettings, Acquisition, SourceBands};
use super::coalesce::Run;
use super::grid;
use super::interpolate::Coverage;
use super::lines::Line;
use super::pipeline::RowsAtOnce;
use super::source::{SourcePixel, SourceRow, SourceView};
use super::view_store::Storage;
use super::views::OutputViews;
use codec::error::Result;
use codec::memory::{Budget, Need};
use codec::monitor::Monitor;
use scene::SceneAtTime;

/// Number of scanlines that are acquired to measure the need of all.
const MEASURED_ROWS: u32 = 8;
/// Total bytes of all output views above which they are stored in a file, unless a budget sets another limit.
const USUAL_VIEW_BYTES: u64 = 2 << 30;
/// Bytes of bands of sources, and of strips of views, that are enough for full speed.
const USUAL_BAND_BYTES: u64 = 256 << 20;
const USUAL_STRIP_BYTES: u64 = 128 << 20;
/// Number of scanlines of a strip per thread, unless scanlines are too wide for that.
const STRIP_ROWS_A_THREAD: u64 = 16;
/// Divisor of the budget that gives the size of strips.
const STRIPS_OF_BUDGET: u64 = 8;
/// Bytes per pixel of an output view that is in memory until its last strip is complete.
const VIEW_PIXEL_BYTES: u64 = (size_of::<[f16; 3]>() + size_of::<Coverage>()) as u64;
/// Bytes per pixel of a strip: as rows, and as planes or as bytes for a file.
const STRIP_PIXEL_BYTES: u64 = size_of::<([f16; 3], Coverage)>() as u64 + VIEW_PIXEL_BYTES;
/// Bytes per pixel of a view that is read from a file, of its single-precision picture with alpha, and of the buffers that write
/// the picture: half floats, their channels, and the compressed file.
const PICTURE_PIXEL_BYTES: u64 = 8 + 16 + 3 * 8;
/// Bytes of a line's highlight: its cell and some splits.
const HIGHLIGHT_BYTES: usize = 32 + 4 * 32;
/// Bytes of a line while its scanline is interpolated: the line, its run, the state of both in a view, and the highlight.
const LINE_BYTES: usize = size_of::<Line>() + size_of::<Run>() + 8 + HIGHLIGHT_BYTES;
/// Threads take unequal shares of bands and strips, and each heap keeps the memory of its largest share, which adds 1/5.
const HEAPS_PART: u64 = 5;
/// Size in bytes above which allocations do not reuse freed memory.
const REUSED_BYTES: u64 = 16 << 20;
/// Bytes of the hits of a ray while a scanline is acquired.
const HIT_BYTES: u64 = 3 * 72;

/// Memory need of the source views of a run.
#[derive(Debug, Clone, Copy)]
pub struct SourceNeed {
    /// Bytes per pixel of an output view.
    pub pixel_bytes: f64,
    /// Lines per pixel of an output view.
    pub pixel_lines: f64,
    /// True if sources are acquired in bands; otherwise all of them are in memory from the start.
    pub by_bands: bool,
    /// True if columns of a grid are made, each with all of its views.
    pub by_columns: bool,
}

impl SourceNeed {
    /// Returns the need of `count` images.
    pub fn images(count: u32) -> SourceNeed {
        let pixel_bytes = f64::from(count) * size_of::<SourcePixel>() as f64;
        SourceNeed { pixel_bytes, pixel_lines: f64::from(count), by_bands: false, by_columns: false }
    }

    /// Measures the need of a scene on some scanlines that are spread over the picture. A hierarchical acquisition is assumed to
    /// use the maximum number of sources.
    pub fn measured(
        scene: &SceneAtTime,
        views: &OutputViews,
        settings: &AcquireSettings,
        monitor: &dyn Monitor,
    ) -> Result<SourceNeed> {
        let is_hierarchical = settings.acquisition == Acquisition::Hierarchical;
        let (acquisition, layers) = match is_hierarchical {
            true => (Acquisition::Dual, 1),
            false => (settings.acquisition, settings.layers),
        };
        let settings = AcquireSettings { acquisition, layers, ..settings.clone() };
        let Some(bands) = SourceBands::plan(scene.into(), views, &settings, monitor)? else {
            return Ok(SourceNeed::images(settings.hierarchy.max_sources as u32));
        };
        let (height, mut bytes, mut lines, mut count) = (views.size[1], 0, 0, 0);
        for at in 0..MEASURED_ROWS.min(height) {
            let row = (2 * u64::from(at) + 1) * u64::from(height) / (2 * u64::from(MEASURED_ROWS.min(height)));
            let (sources, _) = bands.rows(row as u32..row as u32 + 1)?;
            bytes += sources.iter().flat_map(|source| &source.rows).map(SourceRow::bytes).sum::<u64>();
            lines += sources.iter().map(SourceView::pixel_count).sum::<u64>();
            count = count.max(sources.len());
        }
        let of_all = match is_hierarchical {
            true => settings.hierarchy.max_sources as f64 / count.max(1) as f64,
            false => 1.0,
        };
        let each = of_all / (f64::from(views.size[0]) * f64::from(MEASURED_ROWS.min(height).max(1)));
        Ok(SourceNeed {
            pixel_bytes: bytes as f64 * each,
            pixel_lines: lines as f64 * each,
            by_bands: !is_hierarchical,
            by_columns: false,
        })
    }

    /// Returns the need of a grid that is made by columns: two rows, the columns between them that are made at once, and one
    /// turned column.
    #[must_use]
    pub fn by_columns(self) -> SourceNeed {
        let pixel_bytes = (3.0 + grid::COLUMNS_AT_ONCE as f64) * self.pixel_bytes;
        SourceNeed { pixel_bytes, by_bands: false, by_columns: true, ..self }
    }

    /// Returns the bytes for the given number of pixels of an output view.
    fn bytes(&self, pixels: u64) -> u64 {
        (self.pixel_bytes * pixels as f64) as u64
    }
}

/// Plan that keeps a run within a budget.
#[derive(Debug, Clone)]
pub struct Plan {
    pub at_once: RowsAtOnce,
    pub storage: Storage,
    /// Memory of the run in bytes, including what is loaded.
    pub bytes: u64,
}

/// Limits of a run.
#[derive(Debug, Clone, Copy)]
pub struct Limits<'a> {
    pub budget: Budget,
    /// Bytes that are already in use, or that are reserved for others: the scene, a quilt, pictures to compare.
    pub held: u64,
    /// Part of `held` that is free after loading, and that views in memory reuse.
    pub freed: u64,
    pub threads: usize,
    /// Folder for a file of views.
    pub folder: &'a Path,
}

/// Plans the memory for `count` views of a line or of a column. Fails if the budget is too small.
pub fn plan(views: &OutputViews, count: usize, sources: SourceNeed, limits: &Limits<'_>) -> Result<Plan> {
    let Limits { budget, held, freed, threads, folder } = *limits;
    let [width, height] = views.size.map(u64::from);
    let (count, threads) = (count as u64, threads as u64);
    let in_heaps = |bytes: u64| if threads > 1 { bytes + bytes / HEAPS_PART } else { bytes };
    let whole = if sources.by_bands { 0 } else { sources.bytes(width * height) };
    // A widened window has up to twice as many columns.
    let hits = 2 * width * u64::from(SourceBands::ROWS) * HIT_BYTES * threads;
    let lines = (sources.pixel_lines * (width * LINE_BYTES as u64) as f64) as u64 * threads;
    let strip_row = STRIP_PIXEL_BYTES * count * width;
    let strips = budget.bytes.map_or(u64::MAX, |bytes| bytes / STRIPS_OF_BUDGET).min(USUAL_STRIP_BYTES);
    let strip_rows = match sources.by_columns {
        true => height,
        false => (strips / strip_row.max(1)).clamp(1, STRIP_ROWS_A_THREAD * threads).min(height.max(1)),
    };
    let fixed = held + whole + hits.max(in_heaps(lines + strip_rows * strip_row));
    let each = if sources.by_bands { in_heaps(sources.bytes(width * u64::from(SourceBands::ROWS))) } else { 0 };
    // Columns are passed on as they are made, so views are not collected.
    let all_views = if sources.by_columns { 0 } else { count * width * height * VIEW_PIXEL_BYTES };
    let is_reused = width * height * size_of::<[f16; 3]>() as u64 <= REUSED_BYTES;
    let new_views = all_views.saturating_sub(if is_reused { freed } else { 0 });
    let fits = fixed + each + new_views <= budget.bytes.unwrap_or(u64::MAX);
    let in_memory = fits && all_views <= budget.bytes.unwrap_or(USUAL_VIEW_BYTES);
    let (waiting, storage) =
        if in_memory { (new_views, Storage::Memory) } else { (0, Storage::File(folder.to_owned())) };
    // Holes are filled after all bands are interpolated.
    let filling = held + whole + width * height * (VIEW_PIXEL_BYTES + PICTURE_PIXEL_BYTES);
    let fixed = waiting + fixed.max(filling.saturating_sub(each));
    let need = Need { what: "interpolating", fixed, each, instead: "smaller views" };
    let bands = height.div_ceil(u64::from(SourceBands::ROWS)).max(1) as usize;
    let usual = usize::try_from(USUAL_BAND_BYTES / each.max(1)).unwrap_or(usize::MAX).clamp(1, bands);
    // Divides the bands evenly, so that the last turn has as many as the others.
    let turns = bands.div_ceil(budget.at_once(&need, usual)?);
    let at_once = bands.div_ceil(turns);
    let at_once_rows = RowsAtOnce { acquired: SourceBands::ROWS * at_once as u32, interpolated: strip_rows as u32 };
    Ok(Plan { at_once: at_once_rows, storage, bytes: need.bytes(at_once) })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::views::Spread;
    use codec::math::{Camera, Lens};

    fn views(size: [u32; 2], count: u32) -> OutputViews {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, Lens::new(60.0)).unwrap();
        let camera = camera.with_aspect(f64::from(size[0]) / f64::from(size[1]));
        OutputViews::new(camera, size, count, Spread::Baseline(0.5), f64::INFINITY).unwrap()
    }

    #[test]
    fn bands_shrink_before_views_go_to_a_file_and_a_budget_is_kept_or_refused() {
        let folder = std::env::temp_dir();
        let views = views([1920, 1080], 500);
        let need = SourceNeed { pixel_bytes: 1800.0, pixel_lines: 8.0, by_bands: true, by_columns: false };
        let of = |count: usize, megabytes: Option<u64>| {
            let budget = megabytes.map_or(Budget::UNLIMITED, |megabytes| Budget::of(megabytes * 1_000_000));
            plan(&views, count, need, &Limits { budget, held: 100_000_000, freed: 0, threads: 2, folder: &folder })
        };
        let few = of(2, None).unwrap();
        assert!(few.storage == Storage::Memory && few.at_once.acquired > SourceBands::ROWS, "{few:?}");
        let tight = of(2, Some(245)).unwrap();
        assert!(tight.storage == Storage::Memory && tight.at_once.acquired == SourceBands::ROWS, "{tight:?}");
        // Views reuse the memory that loading freed.
        let limits =
            Limits { budget: Budget::UNLIMITED, held: 100_000_000, freed: 20_000_000, threads: 2, folder: &folder };
        assert_eq!(plan(&views, 2, need, &limits).unwrap().bytes, few.bytes - 20_000_000);
        // 7 GB of views.
        for megabytes in [None, Some(1000), Some(600)] {
            let many = of(500, megabytes).unwrap();
            assert_eq!(many.storage, Storage::File(folder.clone()));
            assert!(many.bytes <= 1_000_000 * megabytes.unwrap_or(1000), "{many:?}");
        }
        assert_eq!(of(500, Some(9000)).unwrap().storage, Storage::Memory);
        let refused = of(500, Some(150)).unwrap_err().to_string();
        assert!(refused.contains("MB"), "{refused}");
    }
}
