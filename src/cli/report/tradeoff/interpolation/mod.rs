//! Sweeps of view interpolation: time and quality by number of views, layers, splits, coalescing, acquisition and
//! baseline (Epipolar 4).

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
use codec::error::Result;

pub static INTERPOLATION: SweepKind = SweepKind {
    stem: "interpolation",
    title: "What interpolating views costs",
    input_label: "Scene",
    knobs: KNOBS,
    measures: MEASURES,
    panels: PANELS,
    trades: TRADES,
    is_scored: false,
    is_resumable: false,
    survey_runs: 1,
    method: "Each point is a process. Seconds are those of acquisition, interpolation and filling, without reading the scene. PSNR \
             and SSIM are means over all views against ray casting every view, whose time the speedup is relative to.",
};

const fn knob(name: &'static str, label: &'static str, default: &'static str, usual: &'static [&'static str]) -> Knob {
    Knob::new(Stage::Interpolate, name, label, default, usual)
}

const KNOBS: &[Knob] = &[
    knob("views", "output views", "as given", &["2", "10", "25", "50", "75", "100"]),
    knob("acquire", "acquisition", "dual", &["center", "dual", "hierarchical"]),
    knob("baseline", "baseline (m)", "as given", &["0.25", "0.5", "1", "1.5", "3"]),
    knob("layers", "layers", "10", &["1", "2", "3", "5", "10"]),
    knob("culling", "surfaces left out", "full", &["full", "offset", "off"]),
    knob("coalesce", "coalescing (pixels)", "0", &["0", "0.25", "0.5", "1", "2"]),
    knob("splits", "splits of highlights", "8", &["0", "1", "2", "4", "8", "16", "64"]),
    knob("stop", "stopping rule", "holes", &["holes", "erosion"]).with(&[("acquire", "hierarchical")]),
    knob("source-placement", "place of sources", "midpoint", &["midpoint", "clusters"])
        .with(&[("acquire", "hierarchical")]),
    knob("max-sources", "most sources", "9", &["2", "3", "5", "9", "17"]).with(&[("acquire", "hierarchical")]),
    knob("ao-rays", "rays of ambient occlusion", "0", &["0", "4", "16", "64"]),
    knob("samples", "samples of a pixel", "4", &["1", "4", "16"]),
    knob("subdivide", "subdivisions", "0", &["0", "1", "2"]),
    knob("threads", "threads", "all", &["1", "2", "4"]),
];

const MEASURES: &[Measure] = &[
    Measure::new("psnr_db", DECIBELS).shown("PSNR dB", Format::Decimals(2)),
    Measure::new("least_psnr_db", DECIBELS).shown("least", Format::Decimals(2)),
    Measure::new("ssim", NUMBER).shown("SSIM", Format::Decimals(4)),
    Measure::new("psnr_hvs_m_db", DECIBELS).shown("PSNR-HVS-M dB", Format::Decimals(2)),
    Measure::new("unfilled_psnr_db", DECIBELS).shown("PSNR unfilled dB", Format::Decimals(2)),
    Measure::new("holes_percent", NUMBER).shown("holes %", Format::Decimals(3)),
    Measure::new("source_views", Source::Count(Some(1))).shown("sources", Format::Decimals(0)),
    Measure::new("lines", Source::Count(Some(0))).shown("lines", Format::Decimals(0)),
    Measure::new("fragments", Source::Count(Some(0))).shown("fragments", Format::Decimals(0)),
    Measure::new("brute_force_seconds", NUMBER).shown("ray cast s", Format::Decimals(2)),
    Measure::derived("speedup", |of| Some(of.number("brute_force_seconds")? / of.number("seconds")?))
        .shown("speedup", Format::Decimals(1)),
    Measure::new("acquire_seconds", NUMBER).shown("acquire s", Format::Decimals(3)),
    Measure::new("mask_seconds", NUMBER).shown("mask s", Format::Decimals(3)),
    Measure::new("filter_seconds", NUMBER).shown("filter s", Format::Decimals(3)),
    Measure::new("interpolate_seconds", NUMBER).shown("interpolate s", Format::Decimals(3)),
    Measure::new("light_seconds", NUMBER).shown("light s", Format::Decimals(3)),
    Measure::new("fill_seconds", NUMBER).shown("fill s", Format::Decimals(3)),
    Measure::derived("seconds", |of| median(of.runs("runs"))).median_of("runs").shown("seconds", Format::Decimals(3)),
    Measure::new("memory_model_bytes", Source::Count(Some(0))).shown("memory, model", Format::Bytes),
    Measure::new("peak_memory_bytes", Source::Count(None)).shown("memory, peak", Format::Bytes),
    Measure::new("runs", Source::Runs),
];

const STAGES: &[PanelLine] = &[
    PanelLine { label: "acquire", measure: "acquire_seconds" },
    PanelLine { label: "mask", measure: "mask_seconds" },
    PanelLine { label: "filter", measure: "filter_seconds" },
    PanelLine { label: "interpolate", measure: "interpolate_seconds" },
    PanelLine { label: "light", measure: "light_seconds" },
    PanelLine { label: "fill", measure: "fill_seconds" },
    PanelLine { label: "all", measure: "seconds" },
];

const QUALITY: &[PanelLine] = &[
    PanelLine { label: "mean", measure: "psnr_db" },
    PanelLine { label: "least", measure: "least_psnr_db" },
    PanelLine { label: "mean, holes not filled", measure: "unfilled_psnr_db" },
];

const MEMORY: &[PanelLine] = &[
    PanelLine { label: "model", measure: "memory_model_bytes" },
    PanelLine { label: "peak of the process", measure: "peak_memory_bytes" },
];

const PANELS: &[Panel] = &[
    Panel::new("PSNR (dB)", Scale::Decibels, QUALITY).mapped(Better::More),
    Panel::new("SSIM", Scale::WithoutZero, &[PanelLine::of("ssim")]).mapped(Better::More),
    Panel::new("Seconds", Scale::Linear, STAGES).mapped(Better::Less),
    Panel::new("Times as fast as ray casting", Scale::Linear, &[PanelLine::of("speedup")]).mapped(Better::More),
    Panel::new("Ray casting every view (s)", Scale::Linear, &[PanelLine::of("brute_force_seconds")]),
    Panel::new("Holes before filling (%)", Scale::Linear, &[PanelLine::of("holes_percent")]),
    Panel::new("Source views", Scale::Linear, &[PanelLine::of("source_views")]),
    Panel::new("Fragments", Scale::Linear, &[PanelLine::of("fragments")]),
    Panel::new("Memory", Scale::Bytes, MEMORY),
];

const TRADES: &[Trade] = &[Trade {
    name: "time-psnr",
    title: "PSNR by time",
    across: TradeAxis { label: "seconds", measure: "seconds", scale: Scale::Logarithmic },
    up: TradeAxis { label: "PSNR (dB)", measure: "psnr_db", scale: Scale::Decibels },
    better: Better::More,
    note: "",
}];

#[derive(Debug, Clone)]
pub struct InterpolationBench {
    pub scene: String,
    pub fixed: Vec<String>,
}

impl InterpolationBench {
    /// Returns the command of a point, without output options.
    fn interpolate(&self, point: &Point) -> Vec<OsString> {
        words_of(["interpolate", &self.scene], &self.fixed, point)
    }
}

impl CommandBench for InterpolationBench {
    fn kind(&self) -> &'static SweepKind {
        &INTERPOLATION
    }

    fn about(&self) -> String {
        "All views are compared with the same views ray cast, by the same light and samples.".to_owned()
    }

    fn input(&self) -> Json {
        json!({ "scene": self.scene })
    }

    fn line(&self, point: &Point, _work: &Path) -> Vec<OsString> {
        let mut words = self.interpolate(point);
        words.extend(["--null".into(), "--json".into()]);
        words
    }

    fn user_line(&self, point: &Point) -> String {
        let mut words = self.interpolate(point);
        words.extend(["-o".into(), "views/%04d.png".into()]);
        shell_line(&words)
    }

    fn add_values(&self, Lines { runner, work }: &Lines<'_>, report: &Report, measured: &mut Measured) -> Result<()> {
        for (name, path) in [
            ("acquire_seconds", "stages/acquire"),
            ("mask_seconds", "stages/mask"),
            ("filter_seconds", "stages/filter"),
            ("interpolate_seconds", "stages/interpolate"),
            ("light_seconds", "stages/light"),
            ("fill_seconds", "stages/fill"),
        ] {
            measured.set(name, Value::Number(report.number(path)?));
        }
        for name in ["source_views", "lines", "fragments"] {
            measured.set(name, Value::Count(report.count(&format!("counters/{name}"))?));
        }
        measured.set("memory_model_bytes", Value::Count(report.count("memory_model_bytes")?));
        measured.set("peak_memory_bytes", report.count("peak_memory_bytes").ok().map(Value::Count));
        measured.set("holes_percent", Value::Number(report.number("holes_percent")?));
        let mut compare = self.line(&measured.point.clone(), work);
        compare.push("--compare".into());
        let compared = Report::of(*runner, &compare)?;
        let truth = compared.number("speedup")? * compared.number("seconds")?;
        measured.set("brute_force_seconds", Value::Number(truth));
        for (name, path) in [
            ("psnr_db", "quality/psnr_db/mean"),
            ("least_psnr_db", "quality/psnr_db/min"),
            ("ssim", "quality/ssim/mean"),
            ("psnr_hvs_m_db", "quality/psnr_hvs_m_db/mean"),
            ("unfilled_psnr_db", "quality_without_fill/psnr_db/mean"),
        ] {
            measured.set(name, Value::Number(compared.number(path)?));
        }
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
    use crate::report::tradeoff::findings::Verdict;
    use crate::report::tradeoff::plan::{Sweep, grid};
    use crate::report::tradeoff::runner::{Commands, Runner};
    use crate::report::tradeoff::schedule::{Extent, Lab, measure};
    use crate::report::tradeoff::store::Store;
    use crate::report::tradeoff::study::Weights;
    use codec::monitor::Silent;

    /// Returns reports like those of `interpolate`: one second, and a hundredth of a second per view.
    struct Told(RefCell<Vec<String>>);

    impl Runner for Told {
        fn run(&self, words: &[OsString]) -> Result<Json> {
            let line = words.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
            let after = |name: &str| line.split(name).nth(1).and_then(|rest| rest.split(' ').next().map(str::to_owned));
            let views: f64 = after("--views=").and_then(|text| text.parse().ok()).unwrap_or(10.0);
            let coalesced = after("--coalesce=").is_some_and(|text| text != "0");
            let seconds = 1.0 + views * if coalesced { 0.004 } else { 0.01 };
            self.0.borrow_mut().push(line);
            let spread = json!({ "mean": 36.5, "min": 35.0, "max": null, "max_is": "inf" });
            Ok(json!({
                "seconds": seconds,
                "stages": {
                    "acquire": 0.5, "mask": 0.25, "filter": 0.0625, "interpolate": 0.0625, "light": 0, "fill": 0.125
                },
                "counters": { "source_views": 2, "lines": 100, "fragments": 900 }, "holes_percent": 0.5,
                "memory_model_bytes": 1000, "speedup": 0.5 * views / seconds,
                "quality": { "psnr_db": spread, "ssim": { "mean": 0.96 }, "psnr_hvs_m_db": spread },
                "quality_without_fill": { "psnr_db": spread },
            }))
        }

        fn now_seconds(&self) -> f64 {
            0.0
        }
    }

    #[test]
    fn points_are_timed_without_the_truth_and_compared_once() {
        let told = Told(RefCell::new(Vec::new()));
        let bench = InterpolationBench { scene: "a.glb".to_owned(), fixed: vec!["--baseline=0.5".to_owned()] };
        let sweeps = ["views=10,50,100", "coalesce=0,1"].map(|text| Sweep::parse(text).unwrap());
        let study = grid(&INTERPOLATION, &sweeps).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::new(&INTERPOLATION, folder.path(), vec!["views", "coalesce"]);
        let mut bench = Commands { bench, work: "work".into() };
        let lab = Lab { runner: &told, bench: &mut bench, store: &mut store };
        measure(std::slice::from_ref(&study), Extent { repeats: 2, budget_seconds: None }, lab, &Silent).unwrap();
        let lines = told.0.into_inner();
        // Two timed runs, and one with the comparison.
        assert_eq!(lines.len(), 6 * 3, "{lines:?}");
        assert_eq!(lines[0], "interpolate a.glb --baseline=0.5 --views=10 --coalesce=0 --null --json");
        assert_eq!(lines.iter().filter(|line| line.ends_with("--compare")).count(), 6);
        let rows: Vec<Measured> = store.rows.iter().map(|row| row.measured.clone()).collect();
        assert_eq!(rows[0].number("brute_force_seconds"), Some(5.0));
        let results = Results {
            sweep: &INTERPOLATION,
            input: String::new(),
            about: String::new(),
            command_line: String::new(),
            machine: String::new(),
            measured: rows,
            studies: vec![study],
            left_out: Vec::new(),
            weights: Weights::default(),
            commands: Vec::new(),
        };
        let found = |name: &str| findings::judge(&results).into_iter().find(|finding| finding.name == name).unwrap();
        assert_eq!(found("time_grows_little").verdict, Verdict::Found);
        assert_eq!(found("coalescing_helps").verdict, Verdict::Found);
        assert_eq!(found("baselines_cost_quality").verdict, Verdict::NotMeasured);
    }
}
