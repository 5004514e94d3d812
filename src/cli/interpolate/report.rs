//! Report of `interpolate`.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;

use super::args::Args;
use crate::output::{self, human_bytes};
use crate::report::interpolation::{Quality, QualityReport};
use codec::error::{Result, counted};
use epipolar::counters::Counters;
use epipolar::pipeline::{SourceReport, Summary};
use epipolar::stages::Stages;
use epipolar::views::OutputViews;
use footage::json::{self, Number};

/// Measurements of a run besides its stages.
#[derive(Debug, Default)]
pub struct Measured {
    /// Number of views that this run wrote.
    pub views: usize,
    pub load: Duration,
    pub write: Duration,
    /// Total time of ray casting views.
    pub brute_force: Duration,
    pub memory_model_bytes: u64,
    /// Name of the graphics device that interpolated, or `cpu`.
    pub device: String,
    pub quality: Quality,
}

#[derive(Debug, Serialize)]
pub struct Report {
    views: usize,
    rows: u32,
    frames: u64,
    #[serde(serialize_with = "json::seconds")]
    seconds: Duration,
    #[serde(serialize_with = "json::seconds")]
    seconds_per_view: Duration,
    #[serde(serialize_with = "json::seconds")]
    load_seconds: Duration,
    #[serde(serialize_with = "json::seconds")]
    write_seconds: Duration,
    stages: Stages,
    sources: Vec<SourceReport>,
    baseline_m: f64,
    focus_m: Number,
    size: [u32; 2],
    device: String,
    brute_force: bool,
    /// True if the triangles of sources and of reference views are rasterised.
    rasterized: bool,
    holes_percent: f64,
    memory_model_bytes: u64,
    counters: Counters,
    #[serde(skip_serializing_if = "Option::is_none")]
    quality: Option<QualityReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    quality_without_fill: Option<QualityReport>,
    /// Time of ray casting or rasterising all views, divided by the time of interpolating them.
    #[serde(skip_serializing_if = "Option::is_none")]
    speedup: Option<f64>,
    /// Path of the written quilt. Its name contains columns, rows and aspect.
    #[serde(skip_serializing_if = "Option::is_none")]
    quilt: Option<PathBuf>,
}

impl Report {
    pub fn new(args: &Args, views: &OutputViews, summary: &Summary, measured: &Measured) -> Report {
        let count = measured.views;
        let stages = summary.stages();
        let seconds = if args.brute_force { measured.brute_force } else { stages.sum() };
        let pixels = count.max(1) as f64 * views.size.map(f64::from).iter().product::<f64>();
        let [quality, quality_without_fill] = match measured.quality.reports() {
            Some([filled, unfilled]) => [Some(filled), Some(unfilled)],
            None => [None, None],
        };
        Report {
            views: count,
            rows: args.rows,
            frames: args.frame_count(),
            seconds,
            seconds_per_view: seconds / count.max(1) as u32,
            load_seconds: measured.load,
            write_seconds: measured.write,
            stages,
            sources: summary.sources.clone(),
            baseline_m: views.baseline_m(),
            focus_m: Number(views.focus_m),
            size: views.size,
            device: measured.device.clone(),
            brute_force: args.brute_force,
            rasterized: args.rasterize,
            holes_percent: 100.0 * summary.counters.hole_pixels as f64 / pixels,
            memory_model_bytes: measured.memory_model_bytes,
            counters: summary.counters,
            quality,
            quality_without_fill,
            quilt: None,
            speedup: args.compare.then(|| measured.brute_force.as_secs_f64() / seconds.as_secs_f64()),
        }
    }

    pub fn with_quilt(self, quilt: Option<PathBuf>) -> Report {
        Report { quilt, ..self }
    }

    /// Returns durations and counts of the stages, one per line.
    pub fn stats(&self) -> Result<String> {
        output::stage_lines(&self.stages, &self.counters)
    }

    pub fn text(&self) -> String {
        let [width, height] = self.size;
        let sources = match self.sources.len() {
            0 => String::new(),
            count => format!(" from {}", counted(count as u64, "source view")),
        };
        let mut text = format!(
            "{} of {width}x{height}{sources}, {:.3} m: {:.2} s, {:.1} ms each{}; up to {}\n",
            counted(self.views as u64, "view"),
            self.baseline_m,
            self.seconds.as_secs_f64(),
            1e3 * self.seconds_per_view.as_secs_f64(),
            if self.device == "cpu" { String::new() } else { format!(", on {}", self.device) },
            human_bytes(self.memory_model_bytes),
        );
        if !self.brute_force {
            text += &format!(
                "holes {:.3}%, {} pixels ray cast of {}\n",
                self.holes_percent,
                self.counters.traced_pixels,
                self.views as u64 * u64::from(width) * u64::from(height)
            );
        }
        for (name, quality) in [("", &self.quality), ("without filling holes: ", &self.quality_without_fill)] {
            text += &quality.as_ref().map_or(String::new(), |quality| format!("{name}{}\n", quality.text()));
        }
        if let Some(speedup) = self.speedup {
            let alone = if self.rasterized { "drawing" } else { "ray casting" };
            text += &format!("{speedup:.1} times as fast as {alone} every view\n");
        }
        if let Some(path) = &self.quilt {
            text += &format!("{}\n", path.display());
        }
        text.trim_end().to_owned()
    }
}
