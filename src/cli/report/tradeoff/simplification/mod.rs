//! Sweeps of simplification: budgets of triangles, fill rate and texels against the quality of the simplified scene
//! (Seurat 7, figures 9 to 11, 13 and 14).

pub mod findings;

use std::ffi::OsString;
use std::path::Path;

use serde_json::{Value as Json, json};

use super::findings::Finding;
use super::kind::{
    Better, DECIBELS, Format, Measure, Measured, NUMBER, Panel, PanelLine, Point, Scale, Source, SweepKind, Trade,
    TradeAxis, Value,
};
use super::knob::{Knob, Stage};
use super::runner::{CommandBench, Lines, Report, shell_line, words_of};
use super::study::Results;
use crate::report::timing::median;
use codec::error::{Error, Result};
use simplify::{selection, texture_sizes};

pub static SIMPLIFICATION: SweepKind = SweepKind {
    stem: "simplification",
    title: "What simplifying costs",
    input_label: "Capture",
    knobs: KNOBS,
    measures: MEASURES,
    panels: PANELS,
    trades: TRADES,
    is_scored: false,
    is_resumable: false,
    survey_runs: 1,
    method: "Each point is a process. PSNR, SSIM, cracks and overdraw are over all pictures of the capture, holes black. A point \
             whose budgets no selection of tiles keeps is named with the budget and the least value that would do.",
};

const fn knob(name: &'static str, label: &'static str, default: &'static str, usual: &'static [&'static str]) -> Knob {
    Knob::new(Stage::Simplify, name, label, default, usual)
}

const KNOBS: &[Knob] = &[
    knob("triangles", "triangles", "72000", &["2000", "8000", "20000", "72000"]),
    knob("area", "area (spheres)", "3", &["1.25", "1.5", "2", "3", "4"]),
    knob("peak-overdraw", "peak overdraw", "5", &["3", "4", "5", "100"]),
    knob("atlas", "side of the atlas (texels)", "4096", &["512", "1024", "2048", "4096"]),
    knob("pixels-per-degree", "texels a degree", "by capture", &["3", "6", "12"]),
    knob("effort", "effort", "normal", &["fast", "normal", "exhaustive"]),
    knob("tiling", "tiling", "quadtree", &["quadtree", "uniform"]),
    knob("sizing", "texture sizes", "adaptive", &["adaptive", "uniform"]),
    knob("texture-filter", "texture filter", "gaussian", &["gaussian", "box", "b-spline"]),
    knob("threads", "threads", "all", &["1", "2", "4"]),
];

const MEASURES: &[Measure] = &[
    Measure::new("psnr_db", DECIBELS).shown("PSNR dB", Format::Decimals(2)),
    Measure::new("ssim", Source::Signed).shown("SSIM", Format::Decimals(4)),
    Measure::new("psnr_hvs_m_db", Source::Number { is_needed: false, may_be_infinite: true })
        .shown("PSNR-HVS-M dB", Format::Decimals(2)),
    Measure::new("held_out_psnr_db", Source::Number { is_needed: false, may_be_infinite: true })
        .shown("held-out PSNR dB", Format::Decimals(2)),
    Measure::new("held_out_ssim", Source::Signed).shown("held-out SSIM", Format::Decimals(4)),
    Measure::new("crack_pixels", Source::Count(Some(0))).shown("crack pixels", Format::Decimals(0)),
    Measure::new("translucent_pixels", Source::Count(Some(0))).shown("translucent pixels", Format::Decimals(0)),
    Measure::new("triangles", Source::Count(Some(0))).shown("triangles", Format::Decimals(0)),
    Measure::new("tiles", Source::Count(Some(0))).shown("tiles", Format::Decimals(0)),
    Measure::new("projected_area", NUMBER).shown("area, spheres", Format::Decimals(2)),
    Measure::new("overdraw_mean", NUMBER).shown("overdraw, mean", Format::Decimals(2)),
    Measure::new("peak_overdraw", NUMBER).shown("peak, model", Format::Decimals(2)),
    Measure::new("peak_overdraw_measured", NUMBER).shown("peak, measured", Format::Decimals(2)),
    Measure::new("atlas_texels", Source::Count(Some(0))).shown("texels", Format::Decimals(0)),
    Measure::new("atlas_occupancy", NUMBER).shown("atlas used %", Format::Percent),
    Measure::new("gap", NUMBER).shown("duality gap %", Format::Percent),
    Measure::new("bytes", Source::Count(Some(0))).shown("GLB", Format::Bytes),
    Measure::derived("seconds", |of| median(of.runs("runs"))).median_of("runs").shown("seconds", Format::Decimals(2)),
    Measure::new("runs", Source::Runs),
];

const OVERDRAW: &[PanelLine] = &[
    PanelLine { label: "mean", measure: "overdraw_mean" },
    PanelLine { label: "peak of a view", measure: "peak_overdraw_measured" },
    PanelLine { label: "peak of the cost model", measure: "peak_overdraw" },
];

const PANELS: &[Panel] = &[
    Panel::new("SSIM", Scale::WithoutZero, &[PanelLine::of("ssim")]).mapped(Better::More),
    Panel::new("PSNR (dB)", Scale::Decibels, &[PanelLine::of("psnr_db")]).mapped(Better::More),
    Panel::new("PSNR-HVS-M (dB)", Scale::Decibels, &[PanelLine::of("psnr_hvs_m_db")]),
    Panel::new("PSNR of held-out images (dB)", Scale::Decibels, &[PanelLine::of("held_out_psnr_db")]),
    Panel::new("Crack pixels", Scale::Linear, &[PanelLine::of("crack_pixels")]),
    Panel::new("Translucent pixels", Scale::Linear, &[PanelLine::of("translucent_pixels")]),
    Panel::new("Triangles", Scale::Linear, &[PanelLine::of("triangles")]),
    Panel::new("Overdraw", Scale::Linear, OVERDRAW),
    Panel::new("Texels of the atlas", Scale::Linear, &[PanelLine::of("atlas_texels")]),
    Panel::new("Duality gap (%)", Scale::Linear, &[PanelLine::of("gap")]),
    Panel::new("Bytes of the GLB", Scale::Bytes, &[PanelLine::of("bytes")]),
    Panel::new("Seconds", Scale::Linear, &[PanelLine::of("seconds")]).mapped(Better::Less),
];

const TRADES: &[Trade] = &[
    Trade {
        name: "overdraw-ssim",
        title: "SSIM by overdraw (Seurat figure 13)",
        across: TradeAxis {
            label: "triangles over a pixel, mean",
            measure: "overdraw_mean",
            scale: Scale::WithoutZero,
        },
        up: TradeAxis { label: "SSIM", measure: "ssim", scale: Scale::WithoutZero },
        better: Better::More,
        note: "",
    },
    Trade {
        name: "texels-psnr",
        title: "PSNR by texels of the atlas (Seurat figure 14)",
        across: TradeAxis { label: "texels", measure: "atlas_texels", scale: Scale::Logarithmic },
        up: TradeAxis { label: "PSNR (dB)", measure: "psnr_db", scale: Scale::Decibels },
        better: Better::More,
        note: "",
    },
    Trade {
        name: "triangles-psnr",
        title: "PSNR by triangles (Seurat figure 9)",
        across: TradeAxis { label: "triangles", measure: "triangles", scale: Scale::Logarithmic },
        up: TradeAxis { label: "PSNR (dB)", measure: "psnr_db", scale: Scale::Decibels },
        better: Better::More,
        note: "",
    },
];

const SCENE: &str = "scene.glb";

#[derive(Debug, Clone)]
pub struct SimplificationBench {
    pub capture: String,
    pub fixed: Vec<String>,
}

impl SimplificationBench {
    /// Returns the command of a point, without output options.
    fn simplify(&self, point: &Point) -> Vec<OsString> {
        words_of(["simplify", &self.capture], &self.fixed, point)
    }
}

impl CommandBench for SimplificationBench {
    fn kind(&self) -> &'static SweepKind {
        &SIMPLIFICATION
    }

    fn about(&self) -> String {
        "Pictures of the simplified scene are compared with all pictures of the capture.".to_owned()
    }

    fn input(&self) -> Json {
        json!({ "capture": self.capture })
    }

    fn line(&self, point: &Point, work: &Path) -> Vec<OsString> {
        let mut words = self.simplify(point);
        words.extend(["--json".into(), "-o".into(), work.join(SCENE).into()]);
        words
    }

    fn user_line(&self, point: &Point) -> String {
        let mut words = self.simplify(point);
        words.extend(["-o".into(), SCENE.into()]);
        shell_line(&words)
    }

    fn is_infeasible(&self, error: &Error) -> bool {
        let said = error.to_string();
        selection::says_infeasible(&said) || texture_sizes::says_infeasible(&said)
    }

    fn add_values(&self, _commands: &Lines<'_>, report: &Report, measured: &mut Measured) -> Result<()> {
        for name in ["psnr_db", "projected_area", "overdraw_mean", "peak_overdraw", "peak_overdraw_measured"] {
            measured.set(name, Value::Number(report.number(name)?));
        }
        measured.set("atlas_occupancy", Value::Number(report.number("atlas_occupancy")?));
        // Not defined for pictures smaller than the windows of the metrics.
        measured.set("ssim", report.value["ssim"].as_f64().map(Value::Number));
        measured.set("psnr_hvs_m_db", report.number("psnr_hvs_m_db").ok().map(Value::Number));
        // Present if all points are compared with images that were not used to build the scene.
        measured.set("held_out_psnr_db", report.number("held_out/psnr_db").ok().map(Value::Number));
        measured.set("held_out_ssim", report.value["held_out"]["ssim"].as_f64().map(Value::Number));
        for name in ["crack_pixels", "translucent_pixels", "triangles", "tiles", "atlas_texels"] {
            measured.set(name, Value::Count(report.count(name)?));
        }
        // The dual bound may exceed the energy by rounding.
        measured.set("gap", Value::Number(report.number("selection/gap")?.max(0.0)));
        measured.set("bytes", Value::Count(report.count("files/0/bytes")?));
        Ok(())
    }

    fn findings(results: &Results) -> Vec<Finding> {
        findings::judge(results)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;
    use crate::report::tradeoff::plan::{Sweep, grid};
    use crate::report::tradeoff::runner::{Commands, Runner};
    use crate::report::tradeoff::schedule::{Extent, Lab, Schedule, measure};
    use crate::report::tradeoff::store::Store;
    use codec::monitor::Silent;

    /// Returns reports like those of `simplify`, and records the command lines.
    struct Told {
        lines: RefCell<Vec<String>>,
        /// Error message of the point with the fewest triangles.
        failure: &'static str,
    }

    impl Runner for Told {
        fn run(&self, words: &[OsString]) -> Result<Json> {
            let line = words.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
            self.lines.borrow_mut().push(line.clone());
            if line.contains("--triangles=4 ") {
                return Err(Error::invalid(self.failure));
            }
            Ok(json!({
                "seconds": 1.5, "psnr_db": 31.25, "ssim": 0.5, "psnr_hvs_m_db": null, "psnr_hvs_m_db_is": "inf", "crack_pixels": 3,
                "translucent_pixels": 40, "triangles": 96, "tiles": 40, "projected_area": 1.5, "overdraw_mean": 1.25,
                "peak_overdraw": 2.5, "peak_overdraw_measured": 2.75, "atlas_texels": 4096, "atlas_occupancy": 0.5,
                "selection": { "gap": -1e-18 }, "files": [{ "bytes": 9000 }],
            }))
        }

        fn now_seconds(&self) -> f64 {
            0.0
        }
    }

    fn run(failure: &'static str) -> (Schedule, Vec<String>, String) {
        let told = Told { lines: RefCell::new(Vec::new()), failure };
        let bench = SimplificationBench { capture: "set".to_owned(), fixed: vec!["--frames=2".to_owned()] };
        let sweeps = ["effort=fast", "triangles=4,96"].map(|text| Sweep::parse(text).unwrap());
        let studies = [grid(&SIMPLIFICATION, &sweeps).unwrap()];
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::new(&SIMPLIFICATION, folder.path(), vec!["effort", "triangles"]);
        let mut bench = Commands { bench, work: "work".into() };
        let lab = Lab { runner: &told, bench: &mut bench, store: &mut store };
        let done = measure(&studies, Extent { repeats: 2, budget_seconds: None }, lab, &Silent).unwrap();
        let csv = std::fs::read_to_string(folder.path().join("simplification.csv")).unwrap();
        (done, told.lines.into_inner(), csv)
    }

    #[test]
    fn budgets_that_cannot_be_kept_are_told_and_the_others_are_measured() {
        let infeasible = "no selection of tiles meets the budget of triangles: the minimum is 12";
        let (done, lines, csv) = run(infeasible);
        assert_eq!(lines[1], "simplify set --frames=2 --triangles=96 --effort=fast --json -o work/scene.glb");
        assert_eq!(lines.len(), 1 + 2, "what is infeasible is not tried in later rounds: {lines:?}");
        assert!(done.failed.len() == 1 && done.failed[0].is_infeasible && done.failed[0].error.contains("is 12"));
        assert_eq!(
            csv,
            "settings_effort,settings_triangles,psnr_db,ssim,psnr_hvs_m_db,held_out_psnr_db,held_out_ssim,crack_pixels,translucent_pixels,triangles,tiles,\
             projected_area,overdraw_mean,peak_overdraw,peak_overdraw_measured,atlas_texels,atlas_occupancy,gap,bytes,seconds\n\
             fast,96,31.25,0.5,inf,,,3,40,96,40,1.5,1.25,2.5,2.75,4096,0.5,0.0,9000,1.5\n"
        );
        let (done, ..) = run("a file cannot be read");
        assert!(done.failed.len() == 1 && !done.failed[0].is_infeasible, "{done:?}");
    }
}
