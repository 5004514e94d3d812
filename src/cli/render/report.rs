//! Reports of `render`.

use serde::Serialize;

use super::args::Args;
use super::truth::{TruthReport, TruthRun};
use crate::cli::GlobalArgs;
use crate::cli::output::{self, human_bytes};
use crate::error::Result;
use crate::evaluate::rendered_image::HoleFill;
use crate::evaluate::similarity::some_psnr;
use crate::gpu::render::RenderCost;
use crate::march::counters::Counters;
use crate::march::playback::frames::PlaybackSummary;
use crate::march::playback::pacing::FramePacing;
use crate::march::playback::trace::FrameTrace;
use crate::report::coding_map::counted;
use crate::views::player::ShowCounts;

#[derive(Debug, Default)]
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

    /// `6 probes`, or `2 to 6 probes` if the number varies.
    fn probes(&self) -> String {
        match (self.views.iter().min(), self.views.iter().max()) {
            (Some(least), Some(most)) if least < most => format!("{least} to {most} probes"),
            (_, most) => counted(most.map_or(0, |&most| most as u64), "probe"),
        }
    }
}

pub struct Report<'a> {
    pub args: &'a Args,
    pub summary: PlaybackSummary,
    pub pixels: u64,
    pub pictures: u64,
    pub frames: &'a Frames,
    /// Whether near or far distances clip surfaces.
    pub is_cut_off: bool,
    pub seconds: f64,
    pub bytes_out: u64,
    pub device: String,
    pub gpu_cost: Option<RenderCost>,
    /// Decoder of depth and colour: `device` or `cpu`.
    pub decoded_on: &'static str,
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
    views: usize,
    least_views: Option<usize>,
    hole_rays: u64,
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

/// Times for a frame, and bytes for all.
#[derive(Serialize)]
struct GpuCost {
    sending_ms: f64,
    glass_ms: f64,
    marching_ms: f64,
    reading_ms: f64,
    bytes_sent: u64,
    bytes_copied: u64,
}

impl Report<'_> {
    /// Prints the report on standard output, or text on standard error if a result goes there. With --quiet and a file, only
    /// requested figures.
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

    fn megapixels_per_second(&self) -> f64 {
        let render_s = self.summary.pacing.render.mean_ms * self.summary.shots as f64 / 1e3;
        self.pixels as f64 / 1e6 / render_s.max(1e-9)
    }

    fn document(&self) -> Document<'_> {
        let PlaybackSummary { shots, most_views, counters, counts, pacing } = self.summary;
        let ms = |time: std::time::Duration| time.as_secs_f64() * 1e3 / shots.max(1) as f64;
        let has_statistics = self.args.cameras.stats;
        Document {
            seconds: self.seconds,
            frames: shots,
            pictures: self.pictures,
            pixels: self.pixels,
            bytes_out: self.bytes_out,
            device: &self.device,
            views: most_views,
            least_views: self.frames.views.iter().min().copied(),
            hole_rays: counters.hole_rays,
            megapixels_per_second: self.megapixels_per_second(),
            pacing,
            target: self.args.views.target_ms.map(|target_ms| {
                let frames_within_target = self.frames.within(target_ms);
                Target { target_ms, frames_within_target }
            }),
            statistics: has_statistics.then(|| Statistics {
                counters,
                counts,
                cells_skipped: counts.cells_skipped(),
                decoded_on: self.decoded_on,
            }),
            gpu: self.gpu_cost.filter(|_| has_statistics).map(|cost| GpuCost {
                sending_ms: ms(cost.sending),
                glass_ms: ms(cost.proxies),
                marching_ms: ms(cost.marching),
                reading_ms: ms(cost.reading),
                bytes_sent: cost.bytes_sent,
                bytes_copied: cost.bytes_copied,
            }),
            reference: self.truth.map(TruthRun::report),
        }
    }

    fn lines(&self) -> Vec<String> {
        let summary = &self.summary;
        let place = self.args.output.as_ref().map_or_else(String::new, |path| format!("{}: ", path.display()));
        let written = if self.bytes_out > 0 { format!(", {}", human_bytes(self.bytes_out)) } else { String::new() };
        let mut lines = vec![format!(
            "{place}{}{written}, from {}, {:.2} s; a frame{} took {:.1} ms ({:.1} to update, {:.1} to render, {:.2} Mpixel/s) on {}",
            counted(self.pictures, "picture"),
            self.frames.probes(),
            self.seconds,
            self.pictures_a_frame(),
            summary.pacing.frame.mean_ms,
            summary.pacing.update.mean_ms,
            summary.pacing.render.mean_ms,
            self.megapixels_per_second(),
            self.device,
        )];
        let counters = &summary.counters;
        if counters.hole_rays > 0 {
            let percent = 100.0 * counters.hole_rays as f64 / counters.primary_rays.max(1) as f64;
            let filled = match self.args.march.holes {
                HoleFill::Blank => "",
                HoleFill::Nearest => ", filled with the nearest texel",
            };
            let far = if self.is_cut_off { " or are clipped by near and far" } else { "" };
            lines.push(format!(
                "{} of {} rays ({percent:.2}%) hit holes{far}: alpha is 0{filled}",
                counters.hole_rays, counters.primary_rays
            ));
        }
        if let Some(target_ms) = self.args.views.target_ms {
            let within = self.frames.within(target_ms);
            lines.push(format!(
                "{within} of {} took no longer than {target_ms} ms",
                counted(summary.shots as u64, "frame")
            ));
        }
        lines
    }

    /// ` of 6 pictures`, if all frames have the same number above 1.
    fn pictures_a_frame(&self) -> String {
        match self.pictures.checked_div(self.summary.shots as u64) {
            Some(each) if each > 1 && each * self.summary.shots as u64 == self.pictures => {
                format!(" of {each} pictures")
            }
            _ => String::new(),
        }
    }

    fn statistics(&self) -> Vec<String> {
        let summary = &self.summary;
        let (counters, counts, pacing) = (&summary.counters, &summary.counts, &summary.pacing.frame);
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
                if self.decoded_on == "device" { " on the device" } else { "" },
                counts.cells_skipped(),
                counts.cells_unchanged,
                counts.cells_unseen,
                human_bytes(counts.bytes_read),
                human_bytes(summary.counts.bytes_all),
                100.0 * counts.bytes_read as f64 / summary.counts.bytes_all.max(1) as f64,
            ),
            format!(
                "frames: mean {:.1} ms, median {:.1}, 95% within {:.1}, longest {:.1}",
                pacing.mean_ms, pacing.p50_ms, pacing.p95_ms, pacing.max_ms
            ),
        ]
    }
}

fn similarity(truth: &TruthRun) -> String {
    let all = &truth.all;
    let ssim = all.ssim().map(|ssim| format!(", SSIM {ssim:.4}")).unwrap_or_default();
    let mut parts = format!(
        "{}: PSNR {:.2} dB over all pixels, mean {:.2} dB of {} images{ssim}; {:.2}% holes, {:.2} dB without holes",
        truth.path.display(),
        all.all.psnr_db(),
        all.mean_psnr_db(),
        all.images,
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
