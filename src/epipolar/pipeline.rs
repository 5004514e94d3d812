//! All stages, from a scene to the pictures of its output views.

use std::ops::Range;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::acquire::{AcquireSettings, acquire};
use super::backend::{Backend, Cpu};
use super::counters::Counters;
use super::fill::{HoleFilling, Truth, fill, picture};
use super::interpolate::{InterpolateSettings, Interpolator};
use super::source::SourceView;
use super::views::OutputViews;
use crate::error::Result;
use crate::evaluate::RenderedImage;
use crate::json;
use crate::monitor::Monitor;
use crate::scene::SceneAtTime;

#[derive(Debug, Clone)]
pub struct Settings {
    pub acquire: AcquireSettings,
    pub interpolate: InterpolateSettings,
    pub holes: HoleFilling,
    /// Output views that are interpolated at once; results do not depend on it.
    pub views_at_once: usize,
    /// Whether pictures come before their holes are filled, too.
    pub keeps_unfilled: bool,
}

/// What is to be rendered, and where.
#[derive(Clone)]
pub struct Request<'a> {
    pub views: &'a OutputViews,
    /// Some of the views.
    pub range: Range<usize>,
    pub settings: &'a Settings,
    pub backend: &'a dyn Backend,
}

/// Durations of the stages.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Stages {
    #[serde(serialize_with = "json::seconds")]
    pub acquire: Duration,
    #[serde(serialize_with = "json::seconds")]
    pub interpolate: Duration,
    #[serde(serialize_with = "json::seconds")]
    pub fill: Duration,
}

/// A source view, in a report.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SourceReport {
    /// Metres to the right of the middle of the output views.
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
    pub stages: Stages,
    pub counters: Counters,
    pub sources: Vec<SourceReport>,
}

impl Summary {
    /// Adds a run over other views or another frame. Sources stay those of the first.
    pub fn add(&mut self, other: Summary) {
        let Stages { acquire, interpolate, fill } = other.stages;
        self.stages.acquire += acquire;
        self.stages.interpolate += interpolate;
        self.stages.fill += fill;
        self.counters.add(&other.counters);
        if self.sources.is_empty() {
            self.sources = other.sources;
        }
    }

    /// Seconds of all stages.
    pub fn duration(&self) -> Duration {
        let Stages { acquire, interpolate, fill } = self.stages;
        acquire + interpolate + fill
    }
}

impl<'a> Request<'a> {
    /// All views, on the CPU.
    pub fn all(views: &'a OutputViews, settings: &'a Settings) -> Request<'a> {
        Request { views, range: 0..views.offsets_m.len(), settings, backend: &Cpu }
    }

    /// Steps that a run reports to its monitor.
    pub fn steps(&self) -> u64 {
        let blocks = self.range.len().div_ceil(self.settings.views_at_once.max(1));
        blocks as u64 * u64::from(self.views.size[1])
    }
}

/// Renders some of the output views of a scene, and gives each picture with its number, in order.
pub fn interpolate(
    scene: &SceneAtTime,
    request: &Request<'_>,
    monitor: &dyn Monitor,
    take: impl FnMut(usize, Picture) -> Result<()>,
) -> Result<Summary> {
    let begun = Instant::now();
    let settings = &request.settings.acquire;
    let (sources, counters) = acquire(scene, request.views, settings, monitor)?;
    let acquired = begun.elapsed();
    let truth = Some(Truth { scene, samples: &settings.samples });
    let mut summary = between((&sources, truth), request, monitor, take)?;
    summary.counters.add(&counters);
    summary.stages.acquire = acquired;
    Ok(summary)
}

/// Renders some of the output views between source views, which are in their order.
pub fn between(
    (sources, truth): (&[SourceView], Option<Truth<'_>>),
    request: &Request<'_>,
    monitor: &dyn Monitor,
    mut take: impl FnMut(usize, Picture) -> Result<()>,
) -> Result<Summary> {
    let mut summary = Summary { sources: sources.iter().map(SourceReport::of).collect(), ..Summary::default() };
    let Request { views, range, settings, backend } = request;
    let interpolator = Interpolator::new(views, sources, settings.interpolate);
    let mut first = range.start;
    while first < range.end {
        let block = first..(first + settings.views_at_once.max(1)).min(range.end);
        let begun = Instant::now();
        let (mut interpolated, counted) = backend.views(&interpolator, block.clone(), monitor)?;
        // Lines are the same for all blocks.
        let lines = if first == range.start { counted.lines } else { 0 };
        let coalesced_pixels = if first == range.start { counted.coalesced_pixels } else { 0 };
        summary.counters.add(&Counters { lines, coalesced_pixels, ..counted });
        summary.stages.interpolate += begun.elapsed();
        for (view, of_view) in block.clone().zip(&mut interpolated) {
            let unfilled = settings.keeps_unfilled.then(|| picture(of_view)).transpose()?;
            let begun = Instant::now();
            let place = (*views, views.offsets_m[view]);
            summary.counters.traced_pixels += fill(of_view, truth, place, settings.holes, monitor)?;
            summary.stages.fill += begun.elapsed();
            take(view, Picture { filled: picture(of_view)?, unfilled })?;
        }
        first = block.end;
    }
    Ok(summary)
}

/// A picture of an output view.
#[derive(Debug, Clone)]
pub struct Picture {
    pub filled: RenderedImage,
    /// Before holes were filled: alpha is 0 there; `None` unless it is kept.
    pub unfilled: Option<RenderedImage>,
}
