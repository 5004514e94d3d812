//! Sweeps of rendering: one probe of a dataset is left out and rendered from the others (CALF 7.2, figure 9).

use std::ffi::OsString;
use std::path::Path;

use serde_json::{Value as Json, json};

use super::kind::{
    Better, DECIBELS, Format, Measure, Measured, NUMBER, Panel, PanelLine, Point, Scale, Source, SweepKind, Trade,
    TradeAxis, Value,
};
use super::knob::{Knob, Stage};
use super::runner::{CommandBench, Lines, Report};
use crate::report::timing::median;
use codec::error::Result;

pub static RENDERING: SweepKind = SweepKind {
    stem: "rendering",
    title: "What rendering costs",
    input_label: "Dataset",
    knobs: KNOBS,
    measures: MEASURES,
    panels: PANELS,
    trades: TRADES,
    is_scored: false,
    is_resumable: false,
    survey_runs: 1,
    method: "Each point is a process. PSNR and SSIM are means over the pictures of the left-out probe.",
};

const fn knob(name: &'static str, label: &'static str, default: &'static str, usual: &'static [&'static str]) -> Knob {
    Knob::new(Stage::Render, name, label, default, usual)
}

const KNOBS: &[Knob] = &[
    knob("method", "method", "march", &["march", "calf", "splat", "reproject"]),
    knob("refinements", "refinements", "all", &["all", "none", "angles", "edges", "thin", "angles+edges"]),
    knob("holes", "fill of holes", "behind", &["behind", "nearest", "blank"]),
    knob("views", "active views", "all", &["1", "2", "4", "8"]),
    knob("steps", "steps", "1024", &["64", "128", "256", "512", "1024", "2048"]),
    knob("refine", "halvings of the last step", "8", &["0", "2", "4", "8", "12"]),
    knob("acceleration", "acceleration", "pyramid", &["pyramid", "none"]),
    knob("decode", "units that are decoded", "seen", &["seen", "all"]),
    knob("effects", "effects", "auto", &["auto", "none"]),
    knob("samples", "samples (square root)", "1", &["1", "2"]),
    knob("threads", "threads", "all", &["1", "2", "4"]),
    knob("device", "device", "cpu", &["cpu", "gpu"]),
];

const MEASURES: &[Measure] = &[
    Measure::new("psnr_db", DECIBELS).shown("PSNR dB", Format::Decimals(2)),
    Measure::new("ssim", Source::Signed).shown("SSIM", Format::Decimals(4)),
    Measure::new("hole_percent", NUMBER).shown("holes %", Format::Decimals(2)),
    Measure::new("steps_per_ray", NUMBER).shown("steps a ray", Format::Decimals(1)),
    Measure::new("bytes_read", Source::Count(Some(0))).shown("read", Format::Bytes),
    Measure::derived("ms_per_megapixel", |of| median(of.runs("runs")))
        .median_of("runs")
        .shown("ms/Mpixel", Format::Decimals(1)),
    Measure::derived("update_ms", |of| median(of.runs("update_runs")))
        .median_of("update_runs")
        .shown("update ms", Format::Decimals(2)),
    Measure::new("runs", Source::Runs),
    Measure::new("update_runs", Source::Runs),
];

const PANELS: &[Panel] = &[
    Panel::new("PSNR (dB)", Scale::Decibels, &[PanelLine::of("psnr_db")]).mapped(Better::More),
    Panel::new("Rendering (ms per Mpixel)", Scale::Linear, &[PanelLine::of("ms_per_megapixel")]).mapped(Better::Less),
    Panel::new("SSIM", Scale::WithoutZero, &[PanelLine::of("ssim")]),
    Panel::new("Holes (% of pixels)", Scale::Linear, &[PanelLine::of("hole_percent")]),
    Panel::new("Steps per ray", Scale::Linear, &[PanelLine::of("steps_per_ray")]),
    Panel::new("Read from the container", Scale::Bytes, &[PanelLine::of("bytes_read")]),
];

const TRADES: &[Trade] = &[Trade {
    name: "time-psnr",
    title: "PSNR by rendering time (CALF figure 9)",
    across: TradeAxis { label: "ms per Mpixel", measure: "ms_per_megapixel", scale: Scale::Logarithmic },
    up: TradeAxis { label: "PSNR (dB)", measure: "psnr_db", scale: Scale::Decibels },
    better: Better::More,
    note: "",
}];

#[derive(Debug, Clone)]
pub struct RenderingBench {
    pub dataset: String,
    pub probe: String,
    /// Frames to encode and render, such as `0-9`. All by default.
    pub frames: Option<String>,
    pub fixed: Vec<String>,
}

/// Container of the dataset. It is encoded once for all points.
const CONTAINER: &str = "field.lfold";

impl CommandBench for RenderingBench {
    fn kind(&self) -> &'static SweepKind {
        &RENDERING
    }

    fn about(&self) -> String {
        let probe = &self.probe;
        format!("Probe {probe} was left out, and rendered from the others; PSNR and SSIM are means over its pictures.")
    }

    fn input(&self) -> Json {
        json!({ "dataset": self.dataset, "probe": self.probe, "frames": self.frames })
    }

    fn preparation(&self, work: &Path) -> Option<(&'static str, Vec<OsString>)> {
        let mut words: Vec<OsString> = vec!["encode".into(), self.dataset.clone().into()];
        words.extend(self.frames.iter().map(|frames| format!("--frames={frames}").into()));
        words.extend(["--clip".into(), "-o".into(), work.join(CONTAINER).into(), "--json".into()]);
        Some(("Container", words))
    }

    fn line(&self, point: &Point, work: &Path) -> Vec<OsString> {
        let mut words: Vec<OsString> =
            vec!["render".into(), work.join(CONTAINER).into(), "--reference".into(), self.dataset.clone().into()];
        words.extend(["reference-probe", "exclude-probe"].map(|of| format!("--{of}={}", self.probe).into()));
        words.extend(self.frames.iter().map(|frames| format!("--frames={frames}").into()));
        words.extend(self.fixed.iter().map(OsString::from));
        words.extend(point.options());
        words.extend(["--null", "--stats", "--json"].map(OsString::from));
        words
    }

    fn add_run(&self, report: &Report, measured: &mut Measured) -> Result<()> {
        measured.push_run("runs", 1e3 / report.number("megapixels_per_second")?.max(1e-9));
        measured.push_run("update_runs", report.number("pacing/update_ms/mean_ms")?);
        Ok(())
    }

    fn add_values(&self, _commands: &Lines<'_>, report: &Report, measured: &mut Measured) -> Result<()> {
        measured.set("psnr_db", Value::Number(report.number("reference/mean_psnr_db")?));
        measured.set("ssim", report.value["reference"]["ssim"].as_f64().map(Value::Number));
        measured.set("hole_percent", Value::Number(report.number("reference/hole_percent")?));
        let steps = report.number("march_steps")? / report.number("primary_rays")?.max(1.0);
        measured.set("steps_per_ray", Value::Number(steps));
        measured.set("bytes_read", Value::Count(report.number("bytes_read")? as u64));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;
    use crate::report::tradeoff::plan::{Sweep, grid};
    use crate::report::tradeoff::runner::{Commands, Runner};
    use crate::report::tradeoff::schedule::{Extent, Lab, measure};
    use crate::report::tradeoff::store::Store;
    use codec::monitor::Silent;

    /// Returns reports like those of `encode` and `render`, and records the command lines.
    struct Told(RefCell<Vec<String>>);

    impl Runner for Told {
        fn run(&self, words: &[OsString]) -> Result<Json> {
            let line = words.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
            let few = line.contains("--steps=64");
            let (psnr_db, is) = if few { (json!(31.5), json!(null)) } else { (json!(null), json!("inf")) };
            self.0.borrow_mut().push(line);
            Ok(json!({
                "megapixels_per_second": if few { 2.0 } else { 0.5 },
                "march_steps": if few { 6_400 } else { 25_600 }, "primary_rays": 100, "bytes_read": 9_000,
                "pacing": { "update_ms": { "mean_ms": 1.5 } },
                "reference": { "mean_psnr_db": psnr_db, "mean_psnr_db_is": is, "ssim": null, "hole_percent": 0.25 },
            }))
        }

        fn now_seconds(&self) -> f64 {
            0.0
        }
    }

    #[test]
    fn one_container_serves_all_points_and_each_is_rendered_in_every_round() {
        let told = Told(RefCell::new(Vec::new()));
        let bench = RenderingBench {
            dataset: "set".to_owned(),
            probe: "00".to_owned(),
            frames: Some("0".to_owned()),
            fixed: vec!["--refine=4".to_owned()],
        };
        let sweeps = ["views=8", "steps=64,256"].map(|text| Sweep::parse(text).unwrap());
        let studies = [grid(&RENDERING, &sweeps).unwrap()];
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::new(&RENDERING, folder.path(), vec!["views", "steps"]);
        let examples = bench.examples(&studies[0].points());
        let mut bench = Commands { bench, work: "work".into() };
        let lab = Lab { runner: &told, bench: &mut bench, store: &mut store };
        let extent = Extent { repeats: 2, budget_seconds: None };
        measure(&studies, extent, lab, &Silent).unwrap();
        let lines = told.0.into_inner();
        assert_eq!(lines[0], "encode set --frames=0 --clip -o work/field.lfold --json");
        assert_eq!(
            lines[1],
            "render work/field.lfold --reference set --reference-probe=00 --exclude-probe=00 --frames=0 --refine=4 \
             --views=8 --steps=64 --null --stats --json"
        );
        assert_eq!(lines.len(), 1 + 2 * 2);
        assert!(lines[3].contains("--steps=256") && lines[4].contains("--steps=64"), "{lines:?}");
        let csv = std::fs::read_to_string(folder.path().join("rendering.csv")).unwrap();
        assert_eq!(
            csv,
            "settings_views,settings_steps,psnr_db,ssim,hole_percent,steps_per_ray,bytes_read,ms_per_megapixel,update_ms\n\
             8,64,31.5,,0.25,64.0,9000,500.0,1.5\n8,256,inf,,0.25,256.0,9000,2000.0,1.5\n"
        );
        assert!(examples[1].line.starts_with("lightfold render field.lfold --reference set"), "{examples:?}");
    }
}
