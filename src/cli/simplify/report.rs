//! Report of `simplify`.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;

use super::args::Args;
use crate::output::{self, human_bytes};
use codec::error::{Result, counted};
use footage::json::{self, Number};
use simplify::fidelity::{Evaluation, Fidelity};
use simplify::pipeline::{Counters, Simplified, Stages};

/// Comparisons with pictures, and written files.
pub struct Compared {
    /// Comparison with the input.
    pub evaluation: Option<Evaluation>,
    pub held_out: Option<Fidelity>,
    /// Paths and sizes in bytes.
    pub files: Vec<(PathBuf, u64)>,
    /// Charts and pictures.
    pub figures: Vec<PathBuf>,
}

#[derive(Debug, Serialize)]
pub struct Report {
    triangles: usize,
    tiles: u64,
    /// In multiples of the area of a sphere.
    projected_area: f64,
    /// According to the cost model.
    peak_overdraw: f64,
    atlas_width: u32,
    atlas_height: u32,
    atlas_texels: u64,
    atlas_occupancy: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    unsupported_percent: Option<f64>,
    #[serde(flatten)]
    evaluation: Option<EvaluationReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    held_out: Option<HeldOutReport>,
    selection: SelectionReport,
    budgets: Vec<BudgetReport>,
    samples: u64,
    points: u64,
    candidates: u64,
    stages: Stages,
    counters: Counters,
    files: Vec<FileReport>,
    /// Charts and pictures of `--plot`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    figures: Vec<PathBuf>,
    #[serde(serialize_with = "json::seconds")]
    seconds: Duration,
}

/// Comparison of rendered pictures of the scene with those of the capture.
#[derive(Debug, Serialize)]
struct EvaluationReport {
    /// Maximum over all rendered pictures of the mean number of triangles per pixel.
    peak_overdraw_measured: f64,
    overdraw_mean: f64,
    fragments_per_pixel_max: u32,
    psnr_db: Number,
    ssim: Option<f64>,
    psnr_hvs_m_db: Option<Number>,
    released_psnr_db: Number,
    crack_pixels: u64,
    translucent_pixels: u64,
    pixels: u64,
    random_poses: PoseReport,
}

#[derive(Debug, Serialize)]
struct HeldOutReport {
    psnr_db: Number,
    ssim: Option<f64>,
    psnr_hvs_m_db: Option<Number>,
    crack_pixels: u64,
    images: u64,
}

#[derive(Debug, Serialize)]
struct PoseReport {
    poses: u32,
    pixels: u64,
    crack_pixels: u64,
}

#[derive(Debug, Serialize)]
struct SelectionReport {
    dual: f64,
    primal: f64,
    gap: f64,
    iterations: usize,
    /// Budgets that limit the result: with a larger one the energy would be lower.
    limited_by: Vec<&'static str>,
}

#[derive(Debug, Serialize)]
struct BudgetReport {
    name: &'static str,
    limit: f64,
    used: f64,
}

#[derive(Debug, Serialize)]
struct FileReport {
    path: PathBuf,
    bytes: u64,
}

/// Returns a figure of compared pictures. NaN if none were compared.
fn figure(fidelity: &Fidelity, value: f64) -> Number {
    Number(if fidelity.pixels > 0 { value } else { f64::NAN })
}

impl EvaluationReport {
    fn new(Evaluation { fidelity, poses, .. }: &Evaluation) -> EvaluationReport {
        EvaluationReport {
            peak_overdraw_measured: fidelity.peak_overdraw,
            overdraw_mean: fidelity.overdraw_mean(),
            fragments_per_pixel_max: fidelity.fragments_per_pixel_max,
            psnr_db: figure(fidelity, fidelity.similarity.all.psnr_db()),
            ssim: fidelity.similarity.ssim(),
            psnr_hvs_m_db: fidelity.similarity.hvs.psnr_db().map(Number),
            released_psnr_db: figure(fidelity, fidelity.released_psnr_db()),
            crack_pixels: fidelity.crack_pixels,
            translucent_pixels: fidelity.translucent_pixels,
            pixels: fidelity.pixels,
            random_poses: PoseReport { poses: poses.poses, pixels: poses.pixels, crack_pixels: poses.crack_pixels },
        }
    }

    fn text(&self) -> String {
        if self.pixels == 0 {
            return "no pictures were compared: the input has no perspective view\n".to_owned();
        }
        format!(
            "overdraw of the input's views: mean {:.2}, peak {:.2}\n{}\n{} and {} more translucent of {} pixels; from random \
             places {} of {}\n",
            self.overdraw_mean,
            self.peak_overdraw_measured,
            similarity(self.psnr_db, self.ssim),
            counted(self.crack_pixels, "crack"),
            self.translucent_pixels - self.crack_pixels,
            self.pixels,
            counted(self.random_poses.crack_pixels, "crack"),
            self.random_poses.pixels,
        )
    }
}

fn similarity(psnr_db: Number, ssim: Option<f64>) -> String {
    format!("PSNR {:.2} dB{}", psnr_db.0, ssim.map_or(String::new(), |ssim| format!(", SSIM {ssim:.4}")))
}

impl SelectionReport {
    fn limits(&self) -> String {
        match &self.limited_by[..] {
            [] => "not limited by any budget".to_owned(),
            names => format!("limited by {}", names.join(" and ").replace('_', " ")),
        }
    }
}

impl Report {
    pub fn new(simplified: &Simplified, compared: &Compared, args: &Args, elapsed: Duration) -> Report {
        let Compared { evaluation, held_out, files, figures } = compared;
        let Simplified { selection, atlas, .. } = simplified;
        let [triangles, area, overdraw] = simplified.used;
        let texels = u64::from(atlas[0]) * u64::from(atlas[1]);
        Report {
            triangles: simplified.scene.mesh.triangles.len(),
            tiles: simplified.tiles,
            projected_area: area,
            peak_overdraw: overdraw,
            atlas_width: atlas[0],
            atlas_height: atlas[1],
            atlas_texels: texels,
            atlas_occupancy: simplified.used_texels as f64 / texels.max(1) as f64,
            unsupported_percent: simplified.unsupported.map(|share| 100.0 * share),
            evaluation: evaluation.as_ref().map(EvaluationReport::new),
            held_out: held_out.as_ref().map(|held_out| HeldOutReport {
                psnr_db: figure(held_out, held_out.similarity.all.psnr_db()),
                ssim: held_out.similarity.ssim(),
                psnr_hvs_m_db: held_out.similarity.hvs.psnr_db().map(Number),
                crack_pixels: held_out.crack_pixels,
                images: held_out.similarity.images,
            }),
            selection: SelectionReport {
                dual: selection.dual,
                primal: selection.primal,
                gap: selection.gap(),
                iterations: selection.iterations,
                limited_by: selection.limits(),
            },
            budgets: vec![
                BudgetReport { name: "triangles", limit: f64::from(args.triangles), used: triangles },
                BudgetReport { name: "area", limit: args.area, used: area },
                BudgetReport { name: "peak_overdraw", limit: args.peak_overdraw, used: overdraw },
                BudgetReport { name: "atlas", limit: f64::from(args.atlas), used: f64::from(atlas[0].max(atlas[1])) },
            ],
            samples: simplified.counts.samples,
            points: simplified.counts.points,
            candidates: simplified.counts.candidates,
            stages: simplified.stages,
            counters: simplified.counters,
            files: files.iter().map(|(path, bytes)| FileReport { path: path.clone(), bytes: *bytes }).collect(),
            figures: figures.clone(),
            seconds: elapsed,
        }
    }

    /// Returns durations and counts of the stages, one per line.
    pub fn stats(&self) -> Result<String> {
        output::stage_lines(&self.stages, &self.counters)
    }

    pub fn text(&self) -> String {
        let file = |file: &FileReport| format!("{}: {}\n", file.path.display(), human_bytes(file.bytes));
        let files: String = self.files.iter().map(file).collect();
        let held_out = self.held_out.as_ref().map_or(String::new(), |held_out| {
            format!(
                "held out: {}, {}\n",
                similarity(held_out.psnr_db, held_out.ssim),
                counted(held_out.images, "image")
            )
        });
        let textures = match self.counters.reduced_tiles {
            0 => "all textures in full resolution".to_owned(),
            reduced => format!("{} reduced to fit", counted(reduced, "texture")),
        };
        format!(
            "{files}{}, area {:.2} spheres, peak overdraw of 126 views {:.2}\natlas {}x{}, {:.0}% used, {textures}; energy \
            within {:.1}% of the lower bound, {}\n{}{}{:.1} s",
            counted(self.triangles as u64, "triangle"),
            self.projected_area,
            self.peak_overdraw,
            self.atlas_width,
            self.atlas_height,
            100.0 * self.atlas_occupancy,
            100.0 * self.selection.gap,
            self.selection.limits(),
            self.evaluation.as_ref().map_or(String::new(), EvaluationReport::text),
            held_out,
            self.seconds.as_secs_f64(),
        )
    }
}
