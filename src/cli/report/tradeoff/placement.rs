//! Sweeps of camera placement in a scene (CALF 4). The coverage of all points is measured with the same
//! [`RULER_SAMPLES`] surface samples.

use std::ffi::OsString;
use std::path::Path;

use serde_json::{Value as Json, json};

use super::kind::{
    Better, Format, Measure, Measured, NUMBER, Panel, PanelLine, Point, Scale, Source, SweepKind, Trade, TradeAxis,
    Value,
};
use super::knob::{Knob, Stage};
use super::runner::{CommandBench, Lines, Report, shell_line};
use crate::report::timing::median;
use codec::error::Result;

pub static PLACEMENT: SweepKind = SweepKind {
    stem: "placement",
    title: "What placing cameras costs",
    input_label: "Scene",
    knobs: KNOBS,
    measures: MEASURES,
    panels: PANELS,
    trades: TRADES,
    is_scored: false,
    is_resumable: false,
    survey_runs: 1,
    method: "Each point is a process. Coverage is by the same surface samples for all points; own coverage is by the samples \
             of the point.",
};

const fn knob(name: &'static str, label: &'static str, default: &'static str, usual: &'static [&'static str]) -> Knob {
    Knob::new(Stage::Place, name, label, default, usual)
}

const KNOBS: &[Knob] = &[
    knob("effort", "effort", "normal", &["fast", "normal", "exhaustive"]),
    knob("candidates", "candidate positions", "by effort", &["128", "256", "512", "1024", "2048"]),
    knob("surface-samples", "samples of the surfaces", "by effort", &["1000", "2000", "4000", "8000", "16000"]),
    knob("lighting", "lighting", "diffuse", &["diffuse", "specular"]),
    knob("theta", "least angle between views (degrees)", "50", &["25", "50", "75"]).with(&[("lighting", "specular")]),
    knob("k", "decay beyond the viewer distance (1/m)", "by region", &["0.1", "0.3", "1", "3"]),
    knob("cameras", "cameras", "until the gain is small", &["1", "2", "4", "8", "16"]),
    knob("threads", "threads", "all", &["1", "2", "4"]),
];

const MEASURES: &[Measure] = &[
    Measure::new("cameras", Source::Count(Some(0))).shown("cameras", Format::Decimals(0)),
    Measure::new("objective_calls", Source::Count(Some(0))).shown("objective calls", Format::Decimals(0)),
    Measure::new("own_coverage", NUMBER).shown("own coverage %", Format::Percent),
    Measure::new("coverage", NUMBER).shown("coverage %", Format::Percent),
    Measure::derived("seconds", |of| median(of.runs("runs"))).median_of("runs").shown("seconds", Format::Decimals(3)),
    Measure::new("runs", Source::Runs),
];

const PANELS: &[Panel] = &[
    Panel::new("Coverage (%)", Scale::WithoutZero, &[PanelLine::of("coverage")]).mapped(Better::More),
    Panel::new("Search (s)", Scale::Linear, &[PanelLine::of("seconds")]).mapped(Better::Less),
    Panel::new("Cameras", Scale::Linear, &[PanelLine::of("cameras")]),
    Panel::new("Objective calls", Scale::Linear, &[PanelLine::of("objective_calls")]),
];

const TRADES: &[Trade] = &[Trade {
    name: "time-coverage",
    title: "Coverage by time of the search",
    across: TradeAxis { label: "seconds", measure: "seconds", scale: Scale::Logarithmic },
    up: TradeAxis { label: "coverage (%)", measure: "coverage", scale: Scale::WithoutZero },
    better: Better::More,
    note: "",
}];

/// Number of surface samples by which all camera sets are compared; as many as an exhaustive search uses.
pub const RULER_SAMPLES: u32 = 32_768;
/// Number of candidates in that comparison. Given cameras do not depend on it.
const RULER_CANDIDATES: u32 = 256;
const CAMERAS: &str = "cameras.json";

#[derive(Debug, Clone)]
pub struct PlacementBench {
    pub scene: String,
    pub fixed: Vec<String>,
    /// The fixed options that define the surface to cover, without options of the search.
    pub ruler: Vec<String>,
}

impl PlacementBench {
    fn place(&self, options: &[String]) -> Vec<OsString> {
        let words = ["place", &self.scene].map(OsString::from).into_iter();
        words.chain(options.iter().map(OsString::from)).collect()
    }

    /// Returns the command of a point, without output options.
    fn search(&self, point: &Point) -> Vec<OsString> {
        let mut words = self.place(&self.fixed);
        words.extend(point.options());
        words
    }

    fn coverage(&self, Lines { runner, work }: &Lines<'_>) -> Result<f64> {
        let mut words = self.place(&self.ruler);
        words.push(format!("--candidates={RULER_CANDIDATES}").into());
        words.push(format!("--surface-samples={RULER_SAMPLES}").into());
        words.extend(["--cameras=0".into(), "--start".into(), work.join(CAMERAS).into()]);
        Report::of(*runner, &into(words, &work.join("judged.json")))?.number("coverage")
    }
}

fn into(mut words: Vec<OsString>, cameras: &Path) -> Vec<OsString> {
    words.extend(["--json".into(), "-o".into(), cameras.into()]);
    words
}

impl CommandBench for PlacementBench {
    fn kind(&self) -> &'static SweepKind {
        &PLACEMENT
    }

    fn about(&self) -> String {
        format!(
            "Coverage is by the same {RULER_SAMPLES} points on surfaces for all rows; own coverage is by the row's."
        )
    }

    fn input(&self) -> Json {
        json!({ "scene": self.scene })
    }

    fn line(&self, point: &Point, work: &Path) -> Vec<OsString> {
        into(self.search(point), &work.join(CAMERAS))
    }

    fn user_line(&self, point: &Point) -> String {
        shell_line(&self.search(point))
    }

    fn add_values(&self, commands: &Lines<'_>, report: &Report, measured: &mut Measured) -> Result<()> {
        let cameras = report.value["cameras"].as_array().map_or(0, |cameras| cameras.len() as u64);
        measured.set("cameras", Value::Count(cameras));
        measured.set("objective_calls", Value::Count(report.number("objective_calls")? as u64));
        measured.set("own_coverage", Value::Number(report.number("coverage")?));
        measured.set("coverage", Value::Number(self.coverage(commands)?));
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
    use codec::error::Error;
    use codec::monitor::Silent;

    /// Returns reports like those of `place`, at most `answers` times, and records the command lines.
    struct Told {
        lines: RefCell<Vec<String>>,
        answers: usize,
    }

    impl Runner for Told {
        fn run(&self, words: &[OsString]) -> Result<Json> {
            let line = words.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
            if self.lines.borrow().len() == self.answers {
                return Err(Error::Interrupted);
            }
            let is_fast = line.contains("--effort=fast");
            let seconds = if is_fast { 0.5 } else { 4.0 } + self.lines.borrow().len() as f64 * 1e-3;
            let coverage = if line.contains("--start") { 0.75 } else { 0.875 };
            self.lines.borrow_mut().push(line);
            Ok(json!({ "seconds": seconds, "coverage": coverage, "objective_calls": 12, "cameras": [1, 2] }))
        }

        fn now_seconds(&self) -> f64 {
            0.0
        }
    }

    /// Returns the outcome, the command lines and the resulting CSV.
    fn run(sweep: &str, answers: usize, repeats: u32) -> (Result<()>, Vec<String>, String) {
        let fixed = ["--region=0,0,0,1,1,1", "--cameras=2"].map(str::to_owned);
        let told = Told { lines: RefCell::new(Vec::new()), answers };
        let bench = PlacementBench { scene: "a.glb".to_owned(), fixed: fixed.to_vec(), ruler: fixed[..1].to_vec() };
        let mut bench = Commands { bench, work: "work".into() };
        let folder = tempfile::tempdir().unwrap();
        let sweep = Sweep::parse(sweep).unwrap();
        let mut store = Store::new(&PLACEMENT, folder.path(), vec![sweep.knob.name]);
        let lab = Lab { runner: &told, bench: &mut bench, store: &mut store };
        let studies = [grid(&PLACEMENT, &[sweep]).unwrap()];
        let done = measure(&studies, Extent { repeats, budget_seconds: None }, lab, &Silent);
        let csv = std::fs::read_to_string(folder.path().join("placement.csv")).unwrap_or_default();
        (done.map(drop), told.lines.into_inner(), csv)
    }

    #[test]
    fn each_point_is_placed_in_rounds_and_judged_once_by_one_ruler() {
        let (done, lines, csv) = run("effort=fast,normal", 100, 3);
        done.unwrap();
        assert_eq!(lines.len(), 2 * (3 + 1));
        // The default is first, and every other round is in reverse order.
        assert_eq!(
            lines[0],
            "place a.glb --region=0,0,0,1,1,1 --cameras=2 --effort=normal --json -o work/cameras.json"
        );
        assert_eq!(
            lines[1],
            "place a.glb --region=0,0,0,1,1,1 --candidates=256 --surface-samples=32768 --cameras=0 --start \
             work/cameras.json --json -o work/judged.json"
        );
        assert!(lines[2].contains("--effort=fast") && lines[4].contains("--effort=fast"), "{lines:?}");
        assert_eq!(csv.lines().next(), Some("settings_effort,cameras,objective_calls,own_coverage,coverage,seconds"));
        assert!(csv.contains("\nfast,2,12,0.875,0.75,0.504\n"), "{csv}");
    }

    #[test]
    fn what_was_measured_is_kept_where_a_later_command_fails() {
        let (done, _, csv) = run("k=0.5,1", 3, 1);
        assert!(matches!(done, Err(Error::Interrupted)));
        assert!(csv.lines().count() == 2 && csv.contains("\n0.5,2,12,"), "{csv}");
    }
}
