//! What `simplify` reports.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;

use super::Args;
use crate::cli::output::human_bytes;
use crate::json::{self, Number};
use crate::simplify::pipeline::{Counters, Simplified, Stages};

#[derive(Debug, Serialize)]
pub struct Report {
    triangles: usize,
    tiles: u64,
    /// In whole spheres.
    projected_area: f64,
    /// Of the cost model.
    peak_overdraw: f64,
    /// Largest mean of a picture of the capture.
    peak_overdraw_measured: f64,
    overdraw_mean: f64,
    fragments_per_pixel_max: u32,
    atlas_width: u32,
    atlas_height: u32,
    atlas_texels: u64,
    atlas_occupancy: f64,
    psnr_db: Number,
    ssim: Option<f64>,
    psnr_hvs_m_db: Option<Number>,
    released_psnr_db: Number,
    crack_pixels: u64,
    translucent_pixels: u64,
    pixels: u64,
    selection: SelectionReport,
    budgets: Vec<BudgetReport>,
    samples: u64,
    points: u64,
    candidates: u64,
    stages: Stages,
    counters: Counters,
    files: Vec<FileReport>,
    #[serde(serialize_with = "json::seconds")]
    seconds: Duration,
}

#[derive(Debug, Serialize)]
struct SelectionReport {
    dual: f64,
    primal: f64,
    gap: f64,
    iterations: usize,
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

impl Report {
    pub fn new(simplified: &Simplified, args: &Args, bytes: u64, elapsed: Duration) -> Report {
        let Simplified { selection, fidelity, atlas, .. } = simplified;
        let [triangles, area, overdraw] = selection.used;
        let texels = u64::from(atlas[0]) * u64::from(atlas[1]);
        Report {
            triangles: simplified.scene.mesh.triangles.len(),
            tiles: simplified.tiles,
            projected_area: area,
            peak_overdraw: overdraw,
            peak_overdraw_measured: fidelity.peak_overdraw,
            overdraw_mean: fidelity.overdraw_mean(),
            fragments_per_pixel_max: fidelity.fragments_per_pixel_max,
            atlas_width: atlas[0],
            atlas_height: atlas[1],
            atlas_texels: texels,
            atlas_occupancy: simplified.used_texels as f64 / texels.max(1) as f64,
            psnr_db: Number(fidelity.similarity.all.psnr_db()),
            ssim: fidelity.similarity.ssim(),
            psnr_hvs_m_db: fidelity.similarity.hvs.psnr_db().map(Number),
            released_psnr_db: Number(fidelity.released_psnr_db()),
            crack_pixels: fidelity.crack_pixels,
            translucent_pixels: fidelity.translucent_pixels,
            pixels: fidelity.pixels,
            selection: SelectionReport {
                dual: selection.dual,
                primal: selection.primal,
                gap: selection.gap(),
                iterations: selection.iterations,
            },
            budgets: vec![
                BudgetReport { name: "triangles", limit: f64::from(args.triangles), used: triangles },
                BudgetReport { name: "area", limit: args.area, used: area },
                BudgetReport { name: "peak_overdraw", limit: args.peak_overdraw, used: overdraw },
                BudgetReport { name: "atlas", limit: f64::from(args.atlas), used: f64::from(atlas[0].max(atlas[1])) },
            ],
            samples: simplified.samples,
            points: simplified.points,
            candidates: simplified.candidates,
            stages: simplified.stages,
            counters: simplified.counters,
            files: vec![FileReport { path: args.output.clone(), bytes }],
            seconds: elapsed,
        }
    }

    pub fn text(&self) -> String {
        let bytes: u64 = self.files.iter().map(|file| file.bytes).sum();
        format!(
            "{} triangles, atlas {}x{} ({:.0}% used), {}\n\
             area {:.2} spheres, overdraw mean {:.2}, peak {:.2}\n\
             PSNR {:.2} dB, SSIM {:.4}, {} cracks of {} pixels\n\
             {:.1} s",
            self.triangles,
            self.atlas_width,
            self.atlas_height,
            100.0 * self.atlas_occupancy,
            human_bytes(bytes),
            self.projected_area,
            self.overdraw_mean,
            self.peak_overdraw_measured,
            self.psnr_db.0,
            self.ssim.unwrap_or(f64::NAN),
            self.crack_pixels,
            self.pixels,
            self.seconds.as_secs_f64(),
        )
    }
}
