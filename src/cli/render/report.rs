//! Reports of `render`.

use serde_json::{Value, json};

use super::args::Args;
use super::truth::TruthRun;
use crate::cli::GlobalArgs;
use crate::cli::output::{self, human_bytes};
use crate::error::Result;
use crate::gpu::render::RenderCost;
use crate::march::playback::frames::PlaybackSummary;
use crate::march::playback::trace::FrameTrace;

/// Active probes and times by frame.
#[derive(Debug, Default)]
pub struct Frames {
    views: Vec<usize>,
    milliseconds: Vec<f64>,
}

impl Frames {
    /// Adds a frame.
    pub fn add(&mut self, trace: &FrameTrace) {
        self.views.push(trace.active.len());
        self.milliseconds.push(trace.update_ms + trace.render_ms);
    }

    /// Number of frames within this time.
    fn within(&self, target_ms: f64) -> usize {
        self.milliseconds.iter().filter(|&&ms| ms <= target_ms).count()
    }

    /// `6 probes`, or `2 to 6 probes` if the number varies.
    fn probes(&self) -> String {
        match (self.views.iter().min(), self.views.iter().max()) {
            (Some(least), Some(most)) if least < most => format!("{least} to {most} probes"),
            (_, most) => plural(most.map_or(0, |&most| most as u64), "probe"),
        }
    }
}

/// `1 picture`, `2 pictures`.
fn plural(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Results of a run.
pub struct Report<'a> {
    /// The command line.
    pub args: &'a Args,
    /// Figures of all frames.
    pub summary: PlaybackSummary,
    /// Pixels of all images.
    pub pixels: u64,
    /// Number of images.
    pub pictures: u64,
    /// Active probes and times by frame.
    pub frames: &'a Frames,
    /// Whether near or far distances clip surfaces.
    pub is_cut_off: bool,
    /// Time for all frames, with writing.
    pub seconds: f64,
    /// Bytes of written images.
    pub bytes_out: u64,
    /// Name of the device.
    pub device: String,
    /// Cost of the graphics device, if used.
    pub gpu_cost: Option<RenderCost>,
    /// Decoder of depth and colour: `device` or `cpu`.
    pub decoded_on: &'static str,
    /// The reference.
    pub truth: Option<&'a TruthRun>,
}

impl Report<'_> {
    /// Prints the report on standard output, or text on standard error if a result goes there. With --quiet and a file, only
    /// requested figures.
    ///
    /// # Errors
    /// When standard output cannot be written.
    pub fn print(&self, global: &GlobalArgs) -> Result<()> {
        if self.args.json {
            let mut report = self.json();
            output::add_peak_memory(&mut report);
            return output::print_json(&report);
        }
        let mut lines = if global.quiet && self.args.output.is_some() { Vec::new() } else { self.lines() };
        if self.args.cameras.stats {
            lines.extend(self.statistics());
        }
        lines.extend(self.truth.map(similarity));
        if self.args.is_stdout_taken() {
            lines.iter().for_each(output::note);
            return Ok(());
        }
        lines.iter().try_for_each(|line| output::print_text(&format!("{line}\n")))
    }

    fn megapixels_per_second(&self) -> f64 {
        let render_s = self.summary.pacing.render.mean_ms * self.summary.shots as f64 / 1e3;
        self.pixels as f64 / 1e6 / render_s.max(1e-9)
    }

    fn json(&self) -> Value {
        let summary = &self.summary;
        let pacing = &summary.pacing;
        let mut report = json!({
            "seconds": self.seconds,
            "frames": summary.shots,
            "pictures": self.pictures,
            "pixels": self.pixels,
            "bytes_out": self.bytes_out,
            "device": self.device,
            "views": summary.most_views,
            "least_views": self.frames.views.iter().min(),
            "hole_rays": summary.counters.hole_rays,
            "megapixels_per_second": self.megapixels_per_second(),
            "pacing": {
                "mean_ms": pacing.frame.mean_ms,
                "p50_ms": pacing.frame.p50_ms,
                "p95_ms": pacing.frame.p95_ms,
                "max_ms": pacing.frame.max_ms,
                "update_ms": pacing.update,
                "render_ms": pacing.render,
            },
        });
        if let Some(target_ms) = self.args.views.target_ms {
            report["target_ms"] = json!(target_ms);
            report["frames_within_target"] = json!(self.frames.within(target_ms));
        }
        if self.args.cameras.stats {
            let (counters, counts) = (&summary.counters, &summary.counts);
            let more = json!({
                "primary_rays": counters.primary_rays,
                "march_steps": counters.march_steps,
                "refine_steps": counters.refine_steps,
                "secondary_rays": counters.secondary_rays,
                "normal_evals": counters.normal_evals,
                "material_samples": counters.material_samples,
                "background_rays": counters.background_rays,
                "cells_decoded": counts.cells_decoded,
                "cells_skipped": counts.cells_skipped(),
                "cells_unchanged": counts.cells_unchanged,
                "cells_unseen": counts.cells_unseen,
                "texels_updated": counts.texels_updated,
                "bytes_read": counts.bytes_read,
                "bytes_all": summary.counts.bytes_all,
                "decoded_on": self.decoded_on,
            });
            if let (Value::Object(report), Value::Object(more)) = (&mut report, more) {
                report.extend(more);
            }
        }
        if let Some(cost) = self.gpu_cost.filter(|_| self.args.cameras.stats) {
            let ms = |time: std::time::Duration| time.as_secs_f64() * 1e3 / summary.shots.max(1) as f64;
            report["gpu"] = json!({
                "sending_ms": ms(cost.sending),
                "glass_ms": ms(cost.proxies),
                "marching_ms": ms(cost.marching),
                "reading_ms": ms(cost.reading),
                "bytes_sent": cost.bytes_sent,
                "bytes_copied": cost.bytes_copied,
            });
        }
        if let Some(truth) = self.truth {
            report["reference"] = truth.json();
        }
        report
    }

    fn lines(&self) -> Vec<String> {
        let summary = &self.summary;
        let place = match &self.args.output {
            Some(path) => format!("{}: ", path.display()),
            None => String::new(),
        };
        let written = if self.bytes_out > 0 { format!(", {}", human_bytes(self.bytes_out)) } else { String::new() };
        let mut lines = vec![format!(
            "{place}{}{written}, from {}, {:.2} s; a frame{} took {:.1} ms ({:.1} to update, {:.1} to render, {:.2} Mpixel/s) on {}",
            plural(self.pictures, "picture"),
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
                super::options::HolesArg::Blank => "",
                super::options::HolesArg::Nearest => ", filled with the nearest texel",
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
                plural(summary.shots as u64, "frame")
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
    let all = truth.all();
    let ssim = all.ssim().map(|ssim| format!(", SSIM {ssim:.4}")).unwrap_or_default();
    let mut parts = format!(
        "{}: PSNR {:.2} dB over all pixels, mean {:.2} dB of {} images{ssim}; {:.2}% holes, {:.2} dB without holes",
        truth.path().display(),
        all.all.psnr_db(),
        all.mean_psnr_db(),
        all.images,
        all.hole_percent(),
        all.seen.psnr_db(),
    );
    for (what, value) in [("mirrors", all.mirrors_psnr_db()), ("glass", all.glass_psnr_db())] {
        if let Some(value) = value {
            parts.push_str(&format!("; {what} {value:.2} dB"));
        }
    }
    parts
}
