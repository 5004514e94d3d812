//! Runs all stages, from a scene to the pictures of its output views.

use std::ops::Range;
use std::time::Instant;

use serde::Serialize;

use super::acquire::{AcquireSettings, SourceBands, acquire};
use super::backend::{Backend, Cpu};
use super::counters::Counters;
use super::drawing::DrawnScene;
use super::fill::{HoleFilling, Truth, fill, picture};
use super::interpolate::{InterpolateSettings, Interpolator};
use super::source::SourceView;
use super::stages::Stages;
use super::view_store::{Storage, ViewStore};
use super::views::OutputViews;
use codec::error::Result;
use codec::monitor::Monitor;
use render::rendered_image::RenderedImage;

#[derive(Debug, Clone)]
pub struct Settings {
    pub acquire: AcquireSettings,
    pub interpolate: InterpolateSettings,
    pub holes: HoleFilling,
    /// Number of scanlines in work. The results do not depend on it.
    pub at_once: RowsAtOnce,
    pub storage: Storage,
    /// True if each picture is also returned before hole filling.
    pub keeps_unfilled: bool,
}

/// Number of scanlines in work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowsAtOnce {
    /// Number of scanlines acquired at once, if sources are acquired in bands.
    pub acquired: u32,
    /// Number of acquired scanlines that are interpolated at once.
    pub interpolated: u32,
}

/// Views of a line or a grid to render, the settings, and the backend.
#[derive(Clone)]
pub struct Request<'a, V = OutputViews> {
    pub views: &'a V,
    /// Ranges of view numbers, in ascending order. Views of a grid are numbered row by row.
    pub wanted: Vec<Range<usize>>,
    pub settings: &'a Settings,
    pub backend: &'a dyn Backend,
}

/// Report of a source view.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SourceReport {
    /// Position in metres to the right of the middle of the output views.
    pub offset_m: f64,
    pub layers: u32,
}

impl SourceReport {
    pub fn of(source: &SourceView) -> SourceReport {
        SourceReport { offset_m: source.offset_m, layers: source.layers }
    }
}

#[derive(Debug, Clone, Default)]
pub struct Summary {
    /// Elapsed times. Stages that run on the same threads are counted as one.
    pub passed: Stages,
    pub counters: Counters,
    pub sources: Vec<SourceReport>,
}

impl Summary {
    /// Adds a run over other views or another frame. The sources of the first run are kept.
    pub fn add(&mut self, other: Summary) {
        self.passed = self.passed + other.passed;
        self.counters.add(&other.counters);
        if self.sources.is_empty() {
            self.sources = other.sources;
        }
    }

    /// Adds the sources of a band of scanlines.
    fn add_band(&mut self, sources: &[SourceView], counters: Counters) {
        let source_views = if self.sources.is_empty() { counters.source_views } else { 0 };
        self.counters.add(&Counters { source_views, ..counters });
        if self.sources.is_empty() {
            self.sources = sources.iter().map(SourceReport::of).collect();
        }
        for (report, source) in self.sources.iter_mut().zip(sources) {
            report.layers = report.layers.max(source.layers);
        }
    }

    /// Returns the durations of all stages, which add up to that of the run.
    pub fn stages(&self) -> Stages {
        self.passed.divided(&self.counters.threads)
    }
}

impl<'a> Request<'a> {
    /// Requests all views, on the CPU.
    pub fn all(views: &'a OutputViews, settings: &'a Settings) -> Request<'a> {
        Request { views, wanted: std::iter::once(0..views.offsets_m.len()).collect(), settings, backend: &Cpu }
    }

    /// Returns the number of steps that a run reports to its monitor: one per scanline for each source and for each range of
    /// views.
    pub fn steps(&self) -> u64 {
        if self.wanted.is_empty() {
            return 0;
        }
        let Settings { acquire, .. } = self.settings;
        let sources = acquire
            .acquisition
            .places(self.views)
            .map_or(acquire.hierarchy.max_sources, |places| places.offsets_m.len());
        (sources + self.wanted.len()) as u64 * u64::from(self.views.size[1])
    }
}

/// Renders the requested output views of a scene, and passes each picture with its number to `take`, in order.
pub fn interpolate<'a>(
    seen: impl Into<DrawnScene<'a>>,
    request: &Request<'_>,
    monitor: &dyn Monitor,
    take: impl FnMut(usize, Picture) -> Result<()>,
) -> Result<Summary> {
    let (views, settings) = (request.views, &request.settings.acquire);
    let seen = seen.into();
    let truth = Some(Truth { scene: seen.scene, samples: &settings.samples });
    let begun = Instant::now();
    let Some(bands) = SourceBands::plan(seen, views, settings, monitor)? else {
        let (sources, counters) = acquire(seen, views, settings, (request.backend, monitor))?;
        let acquired = begun.elapsed();
        let mut summary = between((&sources, truth), request, monitor, take)?;
        summary.counters.add(&counters);
        summary.passed.acquire = acquired;
        return Ok(summary);
    };
    let mut summary = Summary::default();
    summary.passed.acquire = begun.elapsed();
    let mut store = request.store()?;
    for rows in parts(0..views.size[1] as usize, request.settings.at_once.acquired) {
        let begun = Instant::now();
        let (sources, counters) = bands.rows(rows.start as u32..rows.end as u32)?;
        summary.add_band(&sources, counters);
        summary.passed.acquire += begun.elapsed();
        request.band((&sources, rows.start), 0..rows.len(), (&mut store, &mut summary), monitor)?;
    }
    request.finish((store, summary), truth, monitor, take)
}

/// Renders the requested output views from source views, which are sorted by position.
pub fn between(
    (sources, truth): (&[SourceView], Option<Truth<'_>>),
    request: &Request<'_>,
    monitor: &dyn Monitor,
    take: impl FnMut(usize, Picture) -> Result<()>,
) -> Result<Summary> {
    let mut summary = Summary { sources: sources.iter().map(SourceReport::of).collect(), ..Summary::default() };
    let mut store = request.store()?;
    let rows = 0..request.views.size[1] as usize;
    request.band((sources, 0), rows, (&mut store, &mut summary), monitor)?;
    request.finish((store, summary), truth, monitor, take)
}

impl Request<'_> {
    fn store(&self) -> Result<ViewStore> {
        let count = self.wanted.iter().map(ExactSizeIterator::len).sum();
        ViewStore::new(&self.settings.storage, self.views.size, count)
    }

    /// Interpolates scanlines of the sources in strips. `first_row` is the scanline of the views that corresponds to the first
    /// scanline of the sources.
    fn band(
        &self,
        (sources, first_row): (&[SourceView], usize),
        rows: Range<usize>,
        (store, summary): (&mut ViewStore, &mut Summary),
        monitor: &dyn Monitor,
    ) -> Result<()> {
        let begun = Instant::now();
        let mut interpolator = Interpolator::new(self.views, sources, self.settings.interpolate);
        for rows in parts(rows, self.settings.at_once.interpolated) {
            let first_row = first_row + rows.start;
            interpolator = interpolator.of_rows(rows);
            let mut first_view = 0;
            for range in &self.wanted {
                let (strips, counters) = self.backend.views(&interpolator, range.clone(), monitor)?;
                store.put([first_view, first_row], &strips)?;
                first_view += strips.len();
                summary.counters.add(&counters);
            }
        }
        summary.passed.interpolate += begun.elapsed();
        Ok(())
    }

    /// Fills the holes of all views, and passes the pictures to `take`.
    fn finish(
        &self,
        (mut store, mut summary): (ViewStore, Summary),
        truth: Option<Truth<'_>>,
        monitor: &dyn Monitor,
        mut take: impl FnMut(usize, Picture) -> Result<()>,
    ) -> Result<Summary> {
        let settings = self.settings;
        for (at, view) in self.wanted.iter().cloned().flatten().enumerate() {
            let begun = Instant::now();
            let mut of_view = store.take(at)?;
            summary.passed.interpolate += begun.elapsed();
            let unfilled = settings.keeps_unfilled.then(|| picture(&of_view)).transpose()?;
            let begun = Instant::now();
            let place = (self.views, self.views.offsets_m[view]);
            summary.counters.traced_pixels += fill(&mut of_view, truth, place, settings.holes, monitor)?;
            summary.passed.fill += begun.elapsed();
            take(view, Picture { filled: picture(&of_view)?, unfilled })?;
        }
        Ok(summary)
    }
}

/// Divides a range into parts of `length`; the last one may be shorter.
fn parts(range: Range<usize>, length: u32) -> impl Iterator<Item = Range<usize>> {
    let length = length.max(1) as usize;
    range.clone().step_by(length).map(move |first| first..(first + length).min(range.end))
}

/// Picture of an output view.
#[derive(Debug, Clone)]
pub struct Picture {
    pub filled: RenderedImage,
    /// Picture before hole filling, with an alpha of 0 in holes; `None` unless it is kept.
    pub unfilled: Option<RenderedImage>,
}
