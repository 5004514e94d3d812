//! What rendering costs: sweeps of the options of `render`, PSNR against time (CALF 7.2, figure 9).
//!
//! Enters: a dataset, one probe of it that is left out, the options that all points have, and a grid of others. Leaves:
//! for each point how far the pictures of that probe, rendered from the others, are from the truth, and the time they took.

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

/// Options of `render` that trade quality, bytes or time, in the order of reports.
pub const KNOBS: &[Knob] = &[
    knob("method", "method", "march", &["march", "splat", "reproject"]),
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

const fn knob(name: &'static str, label: &'static str, default: &'static str, usual: &'static [&'static str]) -> Knob {
    Knob { name, label, kinds: &[], stage: Stage::Render, implies: &[], without: None, default, usual }
}

/// The knob of a name.
pub fn find(name: &str) -> Option<&'static Knob> {
    KNOBS.iter().find(|knob| knob.name == name)
}

/// What is measured.
#[derive(Debug, Clone)]
pub struct Sweep<'a> {
    /// The dataset, as the user named it.
    pub dataset: &'a str,
    /// The probe that is left out, and that pictures are compared with.
    pub probe: &'a str,
    /// Frames that are encoded and rendered, such as `0-9`; all where none are given.
    pub frames: Option<&'a str>,
    /// Options of `render` that all points have.
    pub fixed: &'a [String],
    /// Knobs and their values; all with all.
    pub axes: &'a [Axis],
    /// Timed runs of each point, at least 1.
    pub repeats: u32,
}

/// What was measured of one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// Names of knobs and their values.
    pub settings: Vec<(&'static str, String)>,
    /// Mean over all pictures of their PSNR in dB.
    pub psnr_db: f64,
    /// Mean over all pictures of their SSIM, where they are large enough to have one.
    pub ssim: Option<f64>,
    /// Holes in parts of a hundred of all pixels.
    pub hole_percent: f64,
    /// Steps of marching for each ray from the eye.
    pub steps_per_ray: f64,
    /// Bytes of the container that were read.
    pub bytes_read: u64,
    /// Milliseconds for a million pixels, of each run.
    pub ms_per_megapixel: Timing,
    /// Milliseconds of bringing a frame to where it is rendered, of each run.
    pub update_ms: Timing,
}

impl Shown {
    /// The median of the runs, in milliseconds for a million pixels.
    pub fn ms_per_megapixel(&self) -> f64 {
        self.ms_per_megapixel.median().unwrap_or(f64::NAN)
    }

    fn json(&self) -> Value {
        let settings: serde_json::Map<String, Value> =
            self.settings.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
        json!({
            "settings": settings,
            "psnr_db": if self.psnr_db.is_finite() { json!(self.psnr_db) } else { json!("inf") },
            "ssim": self.ssim,
            "hole_percent": self.hole_percent,
            "steps_per_ray": self.steps_per_ray,
            "bytes_read": self.bytes_read,
            "ms_per_megapixel": self.ms_per_megapixel(),
            "update_ms": self.update_ms.median(),
            "runs": self.ms_per_megapixel.runs,
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
        self.points().len() as u64 * u64::from(self.repeats) + 1
    }

    /// The command that encodes the dataset, once for all points.
    pub fn encode(&self, container: &Path) -> Vec<OsString> {
        let mut words: Vec<OsString> = ["encode", self.dataset].map(OsString::from).to_vec();
        words.extend(self.frames.map(|frames| format!("--frames={frames}").into()));
        words.extend(["-o".into(), container.into(), "--json".into()]);
        words
    }

    /// The command of a point.
    pub fn command(&self, container: &Path, settings: &[(&'static str, String)]) -> Vec<OsString> {
        let mut words: Vec<OsString> =
            vec!["render".into(), container.into(), "--reference".into(), self.dataset.into()];
        let of_probe = |option: &str| OsString::from(format!("--{option}={}", self.probe));
        words.extend([of_probe("reference-probe"), of_probe("exclude-probe")]);
        words.extend(self.frames.map(|frames| format!("--frames={frames}").into()));
        words.extend(self.fixed.iter().map(OsString::from));
        words.extend(settings.iter().map(|(name, value)| format!("--{name}={value}").into()));
        words.extend(["--null", "--stats", "--json"].map(OsString::from));
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
        keep: &mut dyn FnMut(&[Shown]) -> Result<()>,
    ) -> Result<Vec<Shown>> {
        let container = work.join("field.lfold");
        runner.run(&self.encode(&container))?;
        monitor.advance(1);
        let mut shown: Vec<Shown> = Vec::new();
        for round in 0..self.repeats {
            for (at, settings) in self.points().into_iter().enumerate() {
                let report = runner.run(&self.command(&container, &settings))?;
                monitor.advance(1);
                if round == 0 {
                    shown.push(of_report(settings, &report)?);
                }
                shown[at].ms_per_megapixel.runs.push(1e3 / number(&report, "/megapixels_per_second")?.max(1e-9));
                shown[at].update_ms.runs.push(number(&report, "/pacing/update_ms/mean_ms")?);
                keep(&shown)?;
            }
        }
        Ok(shown)
    }
}

/// All of a point that is not time.
fn of_report(settings: Vec<(&'static str, String)>, report: &Value) -> Result<Shown> {
    let infinite = report.pointer("/reference/mean_psnr_db").and_then(Value::as_str) == Some("inf");
    Ok(Shown {
        settings,
        psnr_db: if infinite { f64::INFINITY } else { number(report, "/reference/mean_psnr_db")? },
        ssim: report.pointer("/reference/ssim").and_then(Value::as_f64),
        hole_percent: number(report, "/reference/hole_percent")?,
        steps_per_ray: number(report, "/march_steps")? / number(report, "/primary_rays")?.max(1.0),
        bytes_read: number(report, "/bytes_read")? as u64,
        ms_per_megapixel: Timing::default(),
        update_ms: Timing::default(),
    })
}

fn number(report: &Value, pointer: &str) -> Result<f64> {
    let found = report.pointer(pointer).and_then(Value::as_f64);
    found.ok_or_else(|| Error::invalid(format!("render reported no \"{}\"", &pointer[1..].replace('/', "."))))
}

/// The report as JSON: every point, in the order in which they were measured.
pub fn json(sweep: &Sweep<'_>, shown: &[Shown]) -> Value {
    let points: Vec<Value> = shown.iter().map(Shown::json).collect();
    json!({ "dataset": sweep.dataset, "probe": sweep.probe, "frames": sweep.frames, "points": points })
}

/// The same as CSV, a column for each knob of `axes`.
///
/// # Errors
/// When it cannot be written as CSV.
pub fn to_csv(axes: &[Axis], shown: &[Shown]) -> Result<String> {
    let objects: Vec<Value> = shown.iter().map(Shown::json).collect();
    let knobs = axes.iter().map(|axis| format!("settings.{}", axis.knob));
    let figures = ["psnr_db", "ssim", "hole_percent", "steps_per_ray", "bytes_read", "ms_per_megapixel", "update_ms"];
    let columns: Vec<String> = knobs.chain(figures.map(str::to_owned)).collect();
    csv::of_objects(&columns.iter().map(String::as_str).collect::<Vec<_>>(), &objects)
}

/// The same as a table for people.
pub fn table(axes: &[Axis], shown: &[Shown]) -> Table {
    let mut columns: Vec<Column<'_>> = axes.iter().map(|axis| Column::Left(axis.knob)).collect();
    let figures = ["PSNR dB", "SSIM", "Holes %", "Steps a ray", "Read kB", "ms/Mpixel", "Update ms"];
    columns.extend(figures.map(Column::Right));
    let mut table = Table::new(&columns);
    for point in shown {
        let figures = [
            format!("{:.2}", point.psnr_db),
            point.ssim.map_or_else(String::new, |ssim| format!("{ssim:.4}")),
            format!("{:.2}", point.hole_percent),
            format!("{:.1}", point.steps_per_ray),
            format!("{:.1}", point.bytes_read as f64 / 1e3),
            format!("{:.1}", point.ms_per_megapixel()),
            format!("{:.2}", point.update_ms.median().unwrap_or(f64::NAN)),
        ];
        table.row(point.settings.iter().map(|(_, value)| value.clone()).chain(figures));
    }
    table
}

/// PSNR by milliseconds for a million pixels: a line for each setting of all knobs but the last, along which its points lie.
/// Points that are exact have no place in it.
pub fn figure(sweep: &Sweep<'_>, shown: &[Shown]) -> Drawing {
    let finite: Vec<&Shown> = shown.iter().filter(|point| point.psnr_db.is_finite()).collect();
    let x = axis::Axis::logarithmic("ms per Mpixel", finite.iter().map(|point| point.ms_per_megapixel()));
    let y = axis::Axis::without_zero("PSNR (dB)", finite.iter().map(|point| point.psnr_db));
    let along = sweep.axes.last().map_or("", |axis| axis.knob);
    let title = format!("Probe {} of {} from the others, along {along}", sweep.probe, sweep.dataset);
    let mut chart = Chart::new(title, x, y);
    for point in finite {
        let others = &point.settings[..point.settings.len().saturating_sub(1)];
        let name = point::words(others).unwrap_or_default();
        let mark = Mark {
            x: point.ms_per_megapixel(),
            y: point.psnr_db,
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
    chart.draw(760, 460)
}

/// The figures of a page.
pub fn figures(sweep: &Sweep<'_>, shown: &[Shown]) -> Vec<Figure> {
    let along = sweep.axes.last().map_or("", |axis| axis.knob);
    let caption = format!(
        "PSNR by the time of rendering a million pixels. Up and to the left is better. Marks are the values of {along}; a line \
         joins points whose other settings are the same. Points that are exact have no place in it."
    );
    vec![Figure { name: "rendering".to_owned(), caption, drawing: figure(sweep, shown) }]
}

/// What the figures of the table are.
pub fn about(sweep: &Sweep<'_>) -> String {
    format!(
        "Probe {} was left out, and rendered from the others; PSNR and SSIM are means over its pictures.",
        sweep.probe
    )
}

/// Commands for who wants to repeat a point, and what each is for.
pub fn commands(sweep: &Sweep<'_>) -> Vec<(&'static str, String)> {
    let container = Path::new("field.lfold");
    let encode = ("Container", shell_line(&sweep.encode(container)));
    let point = sweep.points().into_iter().next().map(|settings| sweep.command(container, &settings));
    std::iter::once(encode).chain(point.map(|words| ("First point", shell_line(&words)))).collect()
}

/// Names of the files of a report, below its folder.
pub fn files(folder: &Path) -> [PathBuf; 2] {
    ["rendering.csv", "rendering.json"].map(|name| folder.join(name))
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;
    use crate::monitor::Silent;

    /// Answers as `encode` and `render` would, and keeps the command lines.
    struct Told(RefCell<Vec<String>>);

    impl Runner for Told {
        fn run(&self, words: &[OsString]) -> Result<Value> {
            let line = words.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
            let few = line.contains("--steps=64");
            let psnr_db = if few { json!(31.5) } else { json!("inf") };
            self.0.borrow_mut().push(line);
            Ok(json!({
                "megapixels_per_second": if few { 2.0 } else { 0.5 },
                "march_steps": if few { 6_400 } else { 25_600 }, "primary_rays": 100, "bytes_read": 9_000,
                "pacing": { "update_ms": { "mean_ms": 1.5 } },
                "reference": { "mean_psnr_db": psnr_db, "ssim": null, "hole_percent": 0.25 },
            }))
        }

        fn now_seconds(&self) -> f64 {
            0.0
        }
    }

    fn axes() -> [Axis; 2] {
        let axis = |knob, values: &[&str]| Axis { knob, values: values.iter().map(ToString::to_string).collect() };
        [axis("views", &["8"]), axis("steps", &["64", "256"])]
    }

    #[test]
    fn one_container_serves_all_points_and_each_is_rendered_in_every_round() {
        let told = Told(RefCell::new(Vec::new()));
        let (axes, fixed) = (axes(), ["--refine=4".to_owned()]);
        let sweep = Sweep { dataset: "set", probe: "00", frames: Some("0"), fixed: &fixed, axes: &axes, repeats: 2 };
        let mut kept = Vec::new();
        let mut keep = |shown: &[Shown]| {
            kept.push(shown.iter().map(|point| point.update_ms.runs.len()).collect::<Vec<_>>());
            Ok(())
        };
        let shown = sweep.measure(&told, Path::new("work"), &Silent, &mut keep).unwrap();
        assert_eq!(kept, [vec![1], vec![1, 1], vec![2, 1], vec![2, 2]]);
        let lines = told.0.into_inner();
        assert_eq!(lines.len() as u64, sweep.runs());
        assert_eq!(lines[0], "encode set --frames=0 -o work/field.lfold --json");
        assert_eq!(
            lines[2],
            "render work/field.lfold --reference set --reference-probe=00 --exclude-probe=00 --frames=0 --refine=4 \
             --views=8 --steps=256 --null --stats --json"
        );
        assert_eq!((shown[0].psnr_db, shown[0].ms_per_megapixel(), shown[0].steps_per_ray), (31.5, 500.0, 64.0));
        assert_eq!(shown[1].psnr_db, f64::INFINITY);
        let csv = to_csv(&axes, &shown).unwrap();
        assert!(csv.starts_with("settings_views,settings_steps,psnr_db,ssim,hole_percent,steps_per_ray,"), "{csv}");
        assert!(csv.contains("\n8,64,31.5,,0.25,64.0,9000,500.0,1.5\n"), "{csv}");
        assert!(table(&axes, &shown).to_string().contains("31.50"));
        assert_eq!(json(&sweep, &shown)["points"][1]["psnr_db"], "inf");
        assert!(figure(&sweep, &shown).shapes.len() > 5);
        let [figure] = &figures(&sweep, &shown)[..] else { panic!("one figure") };
        assert!(figure.name == "rendering" && figure.caption.contains("values of steps"), "{}", figure.caption);
        let [(_, encode), (_, point)] = &commands(&sweep)[..] else { panic!("two commands") };
        assert!(encode.starts_with("lightfold encode set ") && point.contains(" --views=8 --steps=64 "), "{point}");
    }

    #[test]
    fn a_report_that_lacks_a_figure_is_named() {
        /// Answers nothing.
        struct Silence;
        impl Runner for Silence {
            fn run(&self, _words: &[OsString]) -> Result<Value> {
                Ok(json!({ "reference": { "mean_psnr_db": 30.0 } }))
            }
            fn now_seconds(&self) -> f64 {
                0.0
            }
        }
        let axes = axes();
        let sweep = Sweep { dataset: "set", probe: "00", frames: None, fixed: &[], axes: &axes, repeats: 1 };
        let said = sweep.measure(&Silence, Path::new("work"), &Silent, &mut |_| Ok(())).unwrap_err().to_string();
        assert!(said.contains("\"reference.hole_percent\""), "{said}");
    }
}
