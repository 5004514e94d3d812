//! What placing cameras costs: sweeps of the options of `place` over one scene (CALF 4).
//!
//! Enters: a scene, the options that all points have, and a grid of others. Leaves: for each point the seconds it took
//! and what its cameras cover, measured for all points by one ruler: the same [`RULER_SAMPLES`] points on the surfaces,
//! under the options that all points have.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::bench::Runner;
use super::commands::shell_line;
use super::figures::Figure;
use super::knob::{Knob, Stage};
use super::point::{self, Timing};
use super::study::{Axis, product};
use crate::error::{Error, Result};
use crate::monitor::Monitor;
use crate::report::csv;
use crate::report::plot::Drawing;
use crate::report::plot::axis;
use crate::report::plot::chart::{Chart, Kind, Mark, Series};
use crate::report::plot::marker::Look;
use crate::report::{Column, Table};

/// Options of `place` that trade coverage for cameras or time, in the order of reports.
pub const KNOBS: &[Knob] = &[
    knob("effort", "effort", "normal", &["fast", "normal", "exhaustive"]),
    knob("candidates", "candidate positions", "by effort", &["128", "256", "512", "1024", "2048"]),
    knob("surface-samples", "samples of the surfaces", "by effort", &["1000", "2000", "4000", "8000", "16000"]),
    knob("lighting", "lighting", "diffuse", &["diffuse", "specular"]),
    Knob {
        implies: &[("lighting", "specular")],
        ..knob("theta", "least angle between views (degrees)", "50", &["25", "50", "75"])
    },
    knob("k", "decay beyond the viewer distance (1/m)", "by region", &["0.1", "0.3", "1", "3"]),
    knob("cameras", "cameras", "until the gain is small", &["1", "2", "4", "8", "16"]),
    knob("threads", "threads", "all", &["1", "2", "4"]),
];

const fn knob(name: &'static str, label: &'static str, default: &'static str, usual: &'static [&'static str]) -> Knob {
    Knob { name, label, kinds: &[], stage: Stage::Place, implies: &[], without: None, default, usual }
}

/// The knob of a name.
pub fn find(name: &str) -> Option<&'static Knob> {
    KNOBS.iter().find(|knob| knob.name == name)
}

/// Points on surfaces by which all sets of cameras are judged, as many as an exhaustive search has.
pub const RULER_SAMPLES: u32 = 32_768;
/// Candidates of the ruler. Cameras that are given do not depend on them, so that there are few.
const RULER_CANDIDATES: u32 = 256;

/// What is measured.
#[derive(Debug, Clone)]
pub struct Sweep<'a> {
    /// The scene, as the user named it.
    pub scene: &'a str,
    /// Options of `place` that all points have.
    pub fixed: &'a [String],
    /// Those of them that say what is to be covered, without how hard that is tried, or how many cameras there may be.
    pub ruler: &'a [String],
    /// Knobs and their values; all with all.
    pub axes: &'a [Axis],
    /// Timed runs of each point, at least 1.
    pub repeats: u32,
}

/// What was measured of one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// Names of knobs and their values.
    pub settings: Vec<(&'static str, String)>,
    /// Cameras that were placed.
    pub cameras: u64,
    /// Evaluations of the objective.
    pub objective_calls: u64,
    /// What they cover by the point's own samples, 0..=1.
    pub own_coverage: f64,
    /// What they cover by the ruler, 0..=1.
    pub coverage: f64,
    /// Seconds of each run.
    pub timing: Timing,
}

impl Placed {
    /// The median of the runs.
    pub fn seconds(&self) -> f64 {
        self.timing.median().unwrap_or(f64::NAN)
    }

    fn json(&self) -> Value {
        let settings: serde_json::Map<String, Value> =
            self.settings.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
        json!({
            "settings": settings,
            "cameras": self.cameras,
            "objective_calls": self.objective_calls,
            "own_coverage": self.own_coverage,
            "coverage": self.coverage,
            "seconds": self.seconds(),
            "runs": self.timing.runs,
        })
    }
}

impl Sweep<'_> {
    /// Settings of all points, the last knob fastest.
    pub fn points(&self) -> Vec<Vec<(&'static str, String)>> {
        product(&[], self.axes)
    }

    /// Commands that [`Self::measure`] runs.
    pub fn runs(&self) -> u64 {
        self.points().len() as u64 * (u64::from(self.repeats) + 1)
    }

    /// The command of a point, without where its cameras go.
    pub fn command(&self, settings: &[(&'static str, String)]) -> Vec<OsString> {
        let mut words: Vec<OsString> = ["place", self.scene].map(OsString::from).to_vec();
        words.extend(self.fixed.iter().map(OsString::from));
        words.extend(settings.iter().map(|(name, value)| format!("--{name}={value}").into()));
        words
    }

    /// Measures all points, each in a process of its own: rounds over all of them, so that a machine that becomes slower
    /// does so for all alike. The monitor advances by one for each command. `keep` is given all that is known after each
    /// point, so that a sweep that is stopped leaves it.
    ///
    /// # Errors
    /// When a command or `keep` fails, or the monitor is interrupted.
    pub fn measure(
        &self,
        runner: &dyn Runner,
        work: &Path,
        monitor: &dyn Monitor,
        keep: &mut dyn FnMut(&[Placed]) -> Result<()>,
    ) -> Result<Vec<Placed>> {
        let cameras = work.join("cameras.json");
        let mut placed: Vec<Placed> = Vec::new();
        for round in 0..self.repeats {
            for (at, settings) in self.points().into_iter().enumerate() {
                let report = runner.run(&into(self.command(&settings), &cameras))?;
                monitor.advance(1);
                let seconds = number(&report, "seconds")?;
                if round > 0 {
                    placed[at].timing.runs.push(seconds);
                    keep(&placed)?;
                    continue;
                }
                let coverage = self.judge(runner, &cameras, work)?;
                monitor.advance(1);
                placed.push(Placed {
                    settings,
                    cameras: report["cameras"].as_array().map_or(0, |cameras| cameras.len() as u64),
                    objective_calls: number(&report, "objective_calls")? as u64,
                    own_coverage: number(&report, "coverage")?,
                    coverage,
                    timing: Timing { runs: vec![seconds] },
                });
                keep(&placed)?;
            }
        }
        Ok(placed)
    }

    /// What cameras cover by the ruler.
    fn judge(&self, runner: &dyn Runner, cameras: &Path, work: &Path) -> Result<f64> {
        let mut words: Vec<OsString> = ["place", self.scene].map(OsString::from).to_vec();
        words.extend(self.ruler.iter().map(OsString::from));
        let count = |name: &str, count: u32| OsString::from(format!("--{name}={count}"));
        words.extend([count("candidates", RULER_CANDIDATES), count("surface-samples", RULER_SAMPLES)]);
        words.extend(["--cameras=0", "--start"].map(OsString::from));
        words.push(cameras.into());
        number(&runner.run(&into(words, &work.join("judged.json")))?, "coverage")
    }
}

fn into(mut words: Vec<OsString>, cameras: &Path) -> Vec<OsString> {
    words.extend(["--json".into(), "-o".into(), cameras.into()]);
    words
}

fn number(report: &Value, key: &str) -> Result<f64> {
    report[key].as_f64().ok_or_else(|| Error::invalid(format!("place reported no \"{key}\"")))
}

/// The report as JSON: every point, in the order in which they were measured.
pub fn json(scene: &str, placed: &[Placed]) -> Value {
    json!({ "scene": scene, "points": placed.iter().map(Placed::json).collect::<Vec<_>>() })
}

/// The same as CSV, a column for each knob of `axes`.
///
/// # Errors
/// When it cannot be written as CSV.
pub fn to_csv(axes: &[Axis], placed: &[Placed]) -> Result<String> {
    let objects: Vec<Value> = placed.iter().map(Placed::json).collect();
    let knobs = axes.iter().map(|axis| format!("settings.{}", axis.knob));
    let figures = ["cameras", "objective_calls", "own_coverage", "coverage", "seconds"].map(str::to_owned);
    let columns: Vec<String> = knobs.chain(figures).collect();
    csv::of_objects(&columns.iter().map(String::as_str).collect::<Vec<_>>(), &objects)
}

/// The same as a table for people.
pub fn table(axes: &[Axis], placed: &[Placed]) -> Table {
    let mut columns: Vec<Column<'_>> = axes.iter().map(|axis| Column::Left(axis.knob)).collect();
    columns.extend(["Cameras", "Objective calls", "Coverage, own %", "Coverage %", "Seconds"].map(Column::Right));
    let mut table = Table::new(&columns);
    for point in placed {
        let figures = [
            point.cameras.to_string(),
            point.objective_calls.to_string(),
            format!("{:.2}", 100.0 * point.own_coverage),
            format!("{:.2}", 100.0 * point.coverage),
            format!("{:.3}", point.seconds()),
        ];
        table.row(point.settings.iter().map(|(_, value)| value.clone()).chain(figures));
    }
    table
}

/// Coverage by seconds: a line for each setting of all knobs but the last, along which its points lie.
pub fn figure(sweep: &Sweep<'_>, placed: &[Placed]) -> Drawing {
    let x = axis::Axis::logarithmic("seconds", placed.iter().map(Placed::seconds));
    let y = axis::Axis::without_zero("coverage (%)", placed.iter().map(|point| 100.0 * point.coverage));
    let along = sweep.axes.last().map_or("", |axis| axis.knob);
    let chart = Chart::new(format!("Coverage of {} by time, along {along}", sweep.scene), x, y);
    with_points(chart, placed, |point| Some(point.seconds())).draw(760, 460)
}

/// The figures of a page.
pub fn figures(sweep: &Sweep<'_>, placed: &[Placed]) -> Vec<Figure> {
    let along = sweep.axes.last().map_or("", |axis| axis.knob);
    let caption = format!(
        "Coverage by the seconds of the search. Up and to the left is better. Marks are the values of {along}; a line joins \
         points whose other settings are the same."
    );
    let mut figures = vec![Figure { name: "placement".to_owned(), caption, drawing: figure(sweep, placed) }];
    figures.extend(figure_by_value(sweep, placed).map(|drawing| Figure {
        name: "placement-by-value".to_owned(),
        caption: format!("Coverage by {along}; a line for each setting of all others."),
        drawing,
    }));
    figures
}

/// What the figures of the table are.
pub fn about() -> String {
    format!(
        "Coverage is that of the cameras by the same {RULER_SAMPLES} points on surfaces for all rows; own is by the row's."
    )
}

/// Commands for who wants to repeat a point, and what each is for.
pub fn commands(sweep: &Sweep<'_>) -> Vec<(&'static str, String)> {
    let point = sweep.points().into_iter().next();
    point.map(|settings| ("First point", shell_line(&sweep.command(&settings)))).into_iter().collect()
}

/// Coverage by the value of the last knob, where that is a number: a line for each setting of all others.
pub fn figure_by_value(sweep: &Sweep<'_>, placed: &[Placed]) -> Option<Drawing> {
    let knob = find(sweep.axes.last()?.knob)?;
    let value = |point: &Placed| point.settings.last()?.1.parse().ok().filter(|value: &f64| value.is_finite());
    let values: Vec<f64> = placed.iter().map(value).collect::<Option<_>>()?;
    let x = if values.iter().all(|value| *value > 0.0) {
        axis::Axis::logarithmic(knob.label, values)
    } else {
        axis::Axis::without_zero(knob.label, values)
    };
    let y = axis::Axis::without_zero("coverage (%)", placed.iter().map(|point| 100.0 * point.coverage));
    let chart = Chart::new(format!("Coverage of {} by {}", sweep.scene, knob.name), x, y);
    Some(with_points(chart, placed, value).draw(760, 460))
}

/// A chart with a line for each setting of all knobs but the last.
fn with_points(mut chart: Chart, placed: &[Placed], x: impl Fn(&Placed) -> Option<f64>) -> Chart {
    for point in placed {
        let others = &point.settings[..point.settings.len().saturating_sub(1)];
        let name = point::words(others).unwrap_or_default();
        let Some(x) = x(point) else { continue };
        let mark = Mark {
            x,
            y: 100.0 * point.coverage,
            spread: None,
            name: point.settings.last().map(|(_, value)| value.clone()),
        };
        match chart.series.iter_mut().find(|series| series.name == name) {
            Some(series) => series.marks.push(mark),
            None => {
                let look = Look::of(chart.series.len());
                chart.series.push(Series { name, kind: Kind::Thread, look, marks: vec![mark] });
            }
        }
    }
    chart
}

/// Names of the files of a report, below its folder.
pub fn files(folder: &Path) -> [PathBuf; 2] {
    ["placement.csv", "placement.json"].map(|name| folder.join(name))
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;
    use crate::monitor::Silent;

    /// Answers as `place` would, and keeps the command lines.
    struct Told(RefCell<Vec<String>>);

    impl Runner for Told {
        fn run(&self, words: &[OsString]) -> Result<Value> {
            let line = words.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
            let is_fast = line.contains("--effort=fast");
            let seconds = if is_fast { 0.5 } else { 4.0 } + self.0.borrow().len() as f64 * 1e-3;
            let coverage = if line.contains("--start") { 0.75 } else { 0.875 };
            self.0.borrow_mut().push(line);
            Ok(json!({ "seconds": seconds, "coverage": coverage, "objective_calls": 12, "cameras": [1, 2] }))
        }

        fn now_seconds(&self) -> f64 {
            0.0
        }
    }

    #[test]
    fn each_point_is_placed_in_rounds_and_judged_once_by_one_ruler() {
        let told = Told(RefCell::new(Vec::new()));
        let axes = [Axis { knob: "effort", values: ["fast", "normal"].map(str::to_owned).to_vec() }];
        let fixed = ["--region=0,0,0,1,1,1", "--cameras=2"].map(str::to_owned);
        let sweep = Sweep { scene: "a.glb", fixed: &fixed, ruler: &fixed[..1], axes: &axes, repeats: 3 };
        let mut kept = Vec::new();
        let mut keep = |placed: &[Placed]| {
            kept.push(placed.iter().map(|point| point.timing.runs.len()).collect::<Vec<_>>());
            Ok(())
        };
        let placed = sweep.measure(&told, Path::new("work"), &Silent, &mut keep).unwrap();
        assert_eq!(kept, [vec![1], vec![1, 1], vec![2, 1], vec![2, 2], vec![3, 2], vec![3, 3]]);
        let lines = told.0.into_inner();
        assert_eq!(lines.len() as u64, sweep.runs());
        assert_eq!(
            lines[1],
            "place a.glb --region=0,0,0,1,1,1 --candidates=256 --surface-samples=32768 --cameras=0 --start \
             work/cameras.json --json -o work/judged.json"
        );
        assert!(lines[2].contains("--effort=normal") && lines[4].contains("--effort=fast"), "{lines:?}");
        assert_eq!(placed.len(), 2);
        assert_eq!((placed[0].coverage, placed[0].own_coverage, placed[0].cameras), (0.75, 0.875, 2));
        assert_eq!(placed[0].timing.runs, [0.5, 0.504, 0.506]);
        let csv = to_csv(&axes, &placed).unwrap();
        assert_eq!(csv.lines().next(), Some("settings_effort,cameras,objective_calls,own_coverage,coverage,seconds"));
        assert!(csv.contains("\nfast,2,12,0.875,0.75,0.504\n"), "{csv}");
        assert!(table(&axes, &placed).to_string().contains("75.00"));
        assert_eq!(json("a.glb", &placed)["points"][1]["settings"]["effort"], "normal");
        assert!(figure(&sweep, &placed).shapes.len() > 10);
        let names: Vec<_> = figures(&sweep, &placed).into_iter().map(|figure| figure.name).collect();
        assert_eq!(names, ["placement"]);
        assert_eq!(commands(&sweep)[0].1, "lightfold place a.glb --region=0,0,0,1,1,1 --cameras=2 --effort=fast");
    }

    #[test]
    fn what_was_measured_is_kept_where_a_later_command_fails() {
        /// Answers three times.
        struct Failing(Told);
        impl Runner for Failing {
            fn run(&self, words: &[OsString]) -> Result<Value> {
                let left = self.0.0.borrow().len() < 3;
                if left { self.0.run(words) } else { Err(Error::Interrupted) }
            }
            fn now_seconds(&self) -> f64 {
                0.0
            }
        }
        let axes = [Axis { knob: "k", values: ["0.5", "1"].map(str::to_owned).to_vec() }];
        let sweep = Sweep { scene: "a.glb", fixed: &[], ruler: &[], axes: &axes, repeats: 1 };
        let mut csv = String::new();
        let mut keep = |placed: &[Placed]| {
            csv = to_csv(&axes, placed)?;
            Ok(())
        };
        let failing = Failing(Told(RefCell::new(Vec::new())));
        let stopped = sweep.measure(&failing, Path::new("work"), &Silent, &mut keep);
        assert!(matches!(stopped, Err(Error::Interrupted)));
        assert!(csv.lines().count() == 2 && csv.contains("\n0.5,2,12,"), "{csv}");
    }

    #[test]
    fn a_knob_of_numbers_has_a_chart_by_its_values() {
        let told = Told(RefCell::new(Vec::new()));
        let by_value = |knob: &'static str, values: &[&str]| {
            let axes = [Axis { knob, values: values.iter().map(|value| (*value).to_owned()).collect() }];
            let sweep = Sweep { scene: "a.glb", fixed: &[], ruler: &[], axes: &axes, repeats: 1 };
            let placed = sweep.measure(&told, Path::new("work"), &Silent, &mut |_| Ok(())).unwrap();
            figure_by_value(&sweep, &placed)
        };
        assert!(by_value("k", &["0.1", "1", "3"]).unwrap().shapes.len() > 10);
        assert!(by_value("k", &["0", "1"]).is_some());
        assert!(by_value("effort", &["fast", "normal"]).is_none());
    }

    #[test]
    fn a_report_without_a_figure_is_refused() {
        assert!(number(&json!({ "coverage": null }), "coverage").unwrap_err().to_string().contains("coverage"));
    }
}
