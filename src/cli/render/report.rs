//! Reports of `render`.

use serde::Serialize;

use super::args::Args;
use super::truth::{TruthReport, TruthRun};
use crate::GlobalArgs;
use crate::output::{self, human_bytes};
use codec::error::{Result, counted};
use evaluate::similarity::some_psnr;
use gpu::render::RenderCost;
use render::march::counters::Counters;
use render::march::playback::frames::PlaybackSummary;
use render::march::playback::pacing::{FramePacing, Pacing};
use render::march::playback::trace::FrameTrace;
use render::rendered_image::HoleFill;
use render::views::player::ShowCounts;
use simplify::raster::Drawn;

#[derive(Debug, Clone, Default)]
pub struct Frames {
    views: Vec<usize>,
    milliseconds: Vec<f64>,
}

impl Frames {
    pub fn add(&mut self, trace: &FrameTrace) {
        self.views.push(trace.active.len());
        self.milliseconds.push(trace.update_ms + trace.render_ms);
    }

    fn within(&self, target_ms: f64) -> usize {
        self.milliseconds.iter().filter(|&&ms| ms <= target_ms).count()
    }

    /// Returns `6 probes`, or `2 to 6 probes` if the number varies.
    fn probes(&self) -> String {
        match (self.views.iter().min(), self.views.iter().max()) {
            (Some(least), Some(most)) if least < most => format!("{least} to {most} probes"),
            (_, most) => counted(most.map_or(0, |&most| most as u64), "probe"),
        }
    }
}

/// Rendering figures by kind of input.
pub enum Figures {
    LightField(Box<LightFieldFigures>),
    Quads(QuadFigures),
}

pub struct LightFieldFigures {
    pub summary: PlaybackSummary,
    pub frames: Frames,
    pub gpu_cost: Option<RenderCost>,
    /// Decoder of depth and colour: `device` or `cpu`.
    pub decoded_on: &'static str,
}

#[derive(Debug, Clone, Default)]
pub struct QuadFigures {
    triangles: usize,
    fragments: u64,
    samples: u64,
    max_fragments: u32,
    /// Largest mean overdraw of a picture.
    peak_overdraw: f64,
    update_ms: Vec<f64>,
    render_ms: Vec<f64>,
}

impl QuadFigures {
    pub fn of(triangles: usize) -> QuadFigures {
        QuadFigures { triangles, ..QuadFigures::default() }
    }

    /// Adds the pictures of a frame with `samples` samples each, and the times to upload the scene and to draw.
    pub fn add(&mut self, pictures: &[Drawn], samples: u64, [update_ms, render_ms]: [f64; 2]) {
        for drawn in pictures {
            self.fragments += drawn.fragments;
            self.samples += samples;
            self.max_fragments = self.max_fragments.max(drawn.max_fragments);
            self.peak_overdraw = self.peak_overdraw.max(drawn.fragments as f64 / samples.max(1) as f64);
        }
        self.update_ms.push(update_ms);
        self.render_ms.push(render_ms);
    }

    fn overdraw_mean(&self) -> f64 {
        self.fragments as f64 / self.samples.max(1) as f64
    }

    fn pacing(&self) -> FramePacing {
        let frame_ms: Vec<f64> = self.update_ms.iter().zip(&self.render_ms).map(|(a, b)| a + b).collect();
        let [frame, update, render] = [&frame_ms, &self.update_ms, &self.render_ms].map(|times| Pacing::of(times));
        FramePacing { frame, update, render }
    }
}

pub struct Report<'a> {
    pub args: &'a Args,
    pub figures: Figures,
    pub pixels: u64,
    pub pictures: u64,
    /// True if near or far distances clip surfaces.
    pub is_cut_off: bool,
    pub seconds: f64,
    pub bytes_out: u64,
    pub device: String,
    pub truth: Option<&'a TruthRun>,
}

#[derive(Serialize)]
struct Document<'a> {
    seconds: f64,
    frames: usize,
    pictures: u64,
    pixels: u64,
    bytes_out: u64,
    device: &'a str,
    #[serde(flatten)]
    drawn: DrawnFrom,
    megapixels_per_second: f64,
    pacing: FramePacing,
    #[serde(flatten)]
    target: Option<Target>,
    #[serde(flatten)]
    statistics: Option<Statistics>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gpu: Option<GpuCost>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reference: Option<TruthReport<'a>>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum DrawnFrom {
    Views {
        views: usize,
        min_views: Option<usize>,
        hole_rays: u64,
    },
    Triangles {
        triangles: usize,
        overdraw_mean: f64,
        fragments_per_pixel_max: u32,
        /// Largest mean overdraw of a picture.
        peak_overdraw_measured: f64,
    },
}

#[derive(Serialize)]
struct Target {
    target_ms: f64,
    frames_within_target: usize,
}

#[derive(Serialize)]
struct Statistics {
    #[serde(flatten)]
    counters: Counters,
    #[serde(flatten)]
    counts: ShowCounts,
    cells_skipped: u64,
    decoded_on: &'static str,
}

/// Times per frame, and bytes in total.
#[derive(Serialize)]
struct GpuCost {
    sending_ms: f64,
    glass_ms: f64,
    marching_ms: f64,
    reading_ms: f64,
    bytes_sent: u64,
    bytes_copied: u64,
}

impl GpuCost {
    fn of(cost: &RenderCost, shots: usize) -> GpuCost {
        let ms = |time: std::time::Duration| time.as_secs_f64() * 1e3 / shots.max(1) as f64;
        GpuCost {
            sending_ms: ms(cost.sending),
            glass_ms: ms(cost.proxies),
            marching_ms: ms(cost.marching),
            reading_ms: ms(cost.reading),
            bytes_sent: cost.bytes_sent,
            bytes_copied: cost.bytes_copied,
        }
    }
}

impl Report<'_> {
    /// Prints the report on standard output, or text on standard error if a result goes to standard output. With
    /// --quiet and a file, prints only requested figures.
    pub fn print(&self, global: &GlobalArgs) -> Result<()> {
        if self.args.json {
            return output::print_json(&output::with_memory(self.document()));
        }
        let mut lines = if global.quiet && self.args.output.is_some() { Vec::new() } else { self.lines() };
        if self.args.cameras.stats {
            lines.extend(self.statistics());
        }
        lines.extend(self.truth.map(similarity));
        if self.args.results_to_stdout() > 0 {
            lines.iter().for_each(output::note);
            return Ok(());
        }
        lines.iter().try_for_each(|line| output::print_text(&format!("{line}\n")))
    }

    fn frames(&self) -> usize {
        match &self.figures {
            Figures::LightField(figures) => figures.summary.shots,
            Figures::Quads(figures) => figures.render_ms.len(),
        }
    }

    fn pacing(&self) -> FramePacing {
        match &self.figures {
            Figures::LightField(figures) => figures.summary.pacing,
            Figures::Quads(figures) => figures.pacing(),
        }
    }

    fn megapixels_per_second(&self) -> f64 {
        let render_s = self.pacing().render.mean_ms * self.frames() as f64 / 1e3;
        self.pixels as f64 / 1e6 / render_s.max(1e-9)
    }

    fn document(&self) -> Document<'_> {
        let drawn = match &self.figures {
            Figures::LightField(figures) => DrawnFrom::Views {
                views: figures.summary.max_views,
                min_views: figures.frames.views.iter().min().copied(),
                hole_rays: figures.summary.counters.hole_rays,
            },
            Figures::Quads(figures) => DrawnFrom::Triangles {
                triangles: figures.triangles,
                overdraw_mean: figures.overdraw_mean(),
                fragments_per_pixel_max: figures.max_fragments,
                peak_overdraw_measured: figures.peak_overdraw,
            },
        };
        let of_views = match &self.figures {
            Figures::LightField(figures) => Some(figures),
            Figures::Quads(_) => None,
        };
        let with_statistics = of_views.filter(|_| self.args.cameras.stats);
        Document {
            seconds: self.seconds,
            frames: self.frames(),
            pictures: self.pictures,
            pixels: self.pixels,
            bytes_out: self.bytes_out,
            device: &self.device,
            drawn,
            megapixels_per_second: self.megapixels_per_second(),
            pacing: self.pacing(),
            target: of_views.zip(self.args.views.target_ms).map(|(figures, target_ms)| {
                let frames_within_target = figures.frames.within(target_ms);
                Target { target_ms, frames_within_target }
            }),
            statistics: with_statistics.map(|figures| Statistics {
                counters: figures.summary.counters,
                counts: figures.summary.counts,
                cells_skipped: figures.summary.counts.cells_skipped(),
                decoded_on: figures.decoded_on,
            }),
            gpu: with_statistics.and_then(|figures| Some(GpuCost::of(&figures.gpu_cost?, self.frames()))),
            reference: self.truth.map(TruthRun::report),
        }
    }

    fn lines(&self) -> Vec<String> {
        let place = self.args.output.as_ref().map_or_else(String::new, |path| format!("{}: ", path.display()));
        let written = if self.bytes_out > 0 { format!(", {}", human_bytes(self.bytes_out)) } else { String::new() };
        let from = match &self.figures {
            Figures::LightField(figures) => figures.frames.probes(),
            Figures::Quads(figures) => counted(figures.triangles as u64, "triangle"),
        };
        let pacing = self.pacing();
        let line = format!(
            "{place}{}{written}, from {from}, {:.2} s; a frame{} took {:.1} ms ({:.1} to update, {:.1} to render, {:.2} Mpixel/s) on {}",
            counted(self.pictures, "picture"),
            self.seconds,
            self.pictures_a_frame(),
            pacing.frame.mean_ms,
            pacing.update.mean_ms,
            pacing.render.mean_ms,
            self.megapixels_per_second(),
            self.device,
        );
        let more = match &self.figures {
            Figures::LightField(figures) => self.lines_of_views(figures),
            Figures::Quads(figures) => vec![format!(
                "overdraw: mean {:.2}, of one picture up to {:.2}, of one pixel up to {}",
                figures.overdraw_mean(),
                figures.peak_overdraw,
                figures.max_fragments
            )],
        };
        std::iter::once(line).chain(more).collect()
    }

    fn lines_of_views(&self, figures: &LightFieldFigures) -> Vec<String> {
        let mut lines = Vec::new();
        let counters = &figures.summary.counters;
        if counters.hole_rays > 0 {
            let percent = 100.0 * counters.hole_rays as f64 / counters.primary_rays.max(1) as f64;
            let filled = match self.args.march.holes {
                HoleFill::Behind => "filled from behind, else with the nearest texel",
                HoleFill::Nearest => "alpha is 0, filled with the nearest texel",
                HoleFill::Blank => "alpha is 0",
            };
            let far = if self.is_cut_off { " or are clipped by near and far" } else { "" };
            lines.push(format!(
                "{} of {} rays ({percent:.2}%) hit holes{far}: {filled}",
                counters.hole_rays, counters.primary_rays
            ));
        }
        if let Some(target_ms) = self.args.views.target_ms {
            let within = figures.frames.within(target_ms);
            lines.push(format!(
                "{within} of {} took at most {target_ms} ms",
                counted(figures.summary.shots as u64, "frame")
            ));
        }
        lines
    }

    /// Returns ` of 6 pictures`, if all frames have the same number of pictures above 1.
    fn pictures_a_frame(&self) -> String {
        let frames = self.frames() as u64;
        match self.pictures.checked_div(frames) {
            Some(each) if each > 1 && each * frames == self.pictures => {
                format!(" of {each} pictures")
            }
            _ => String::new(),
        }
    }

    fn statistics(&self) -> Vec<String> {
        let mut lines = match &self.figures {
            Figures::LightField(figures) => counts(figures),
            Figures::Quads(_) => Vec::new(),
        };
        let pacing = self.pacing().frame;
        lines.push(format!(
            "frames: mean {:.1} ms, median {:.1}, 95% within {:.1}, longest {:.1}",
            pacing.mean_ms, pacing.p50_ms, pacing.p95_ms, pacing.max_ms
        ));
        lines
    }
}

fn counts(figures: &LightFieldFigures) -> Vec<String> {
    let PlaybackSummary { counters, counts, .. } = &figures.summary;
    let per_ray = |count: u64| count as f64 / (counters.primary_rays + counters.secondary_rays).max(1) as f64;
    vec![
        format!(
            "{} primary rays, {:.1} steps and {:.1} refinements per ray; {} secondary rays, {} normals, {} material \
             samples, {} background rays",
            counters.primary_rays,
            per_ray(counters.march_steps),
            per_ray(counters.refine_steps),
            counters.secondary_rays,
            counters.normal_evals,
            counters.material_samples,
            counters.background_rays,
        ),
        format!(
            "{} tiles and cells decoded{}, {} skipped ({} unchanged, {} not visible); {} of {} read ({:.1}%)",
            counts.cells_decoded,
            if figures.decoded_on == "device" { " on the device" } else { "" },
            counts.cells_skipped(),
            counts.cells_unchanged,
            counts.cells_unseen,
            human_bytes(counts.bytes_read),
            human_bytes(counts.bytes_all),
            100.0 * counts.bytes_read as f64 / counts.bytes_all.max(1) as f64,
        ),
    ]
}

fn similarity(truth: &TruthRun) -> String {
    let all = &truth.all;
    let ssim = all.ssim().map(|ssim| format!(", SSIM {ssim:.4}")).unwrap_or_default();
    let mut parts = format!(
        "{}: PSNR {:.2} dB over all pixels, mean {:.2} dB of {}{ssim}; {:.2}% holes, {:.2} dB without holes",
        truth.path.display(),
        all.all.psnr_db(),
        all.mean_psnr_db(),
        counted(all.images, "image"),
        all.hole_percent(),
        all.seen.psnr_db(),
    );
    for (what, value) in [("mirrors", some_psnr(&all.mirrors)), ("glass", some_psnr(&all.glass))] {
        if let Some(value) = value {
            parts.push_str(&format!("; {what} {value:.2} dB"));
        }
    }
    parts
}
