//! Sweeps of rendering a dataset from which one probe is left out.

use std::path::Path;

use glam::DVec3;

use super::args::{Args, refuse_options_of_coding};
use super::fixed::OptionsOf;
use super::measure::measure_grid;
use crate::report::tradeoff::plan;
use crate::report::tradeoff::rendering::{RENDERING, RenderingBench};
use crate::report::tradeoff::study::Axis;
use crate::{ExitStatus, GlobalArgs, refuse};
use codec::error::{Error, Result};
use footage::dataset::manifest::Manifest;

/// Options of `render` that are set by tradeoff.
const OWN: &[&str] = &[
    "output",
    "null",
    "json",
    "quiet",
    "stats",
    "reference",
    "exclude-probe",
    "camera",
    "eye",
    "look-at",
    "contact-sheet",
    "error-map",
    "trace",
];

#[derive(Debug, Default, PartialEq)]
struct Fixed {
    words: Vec<String>,
    /// Values of `--reference-probe` and `--frames`, which also apply to other commands.
    probe: Option<String>,
    frames: Option<String>,
}

pub fn measure(args: &Args, dataset: &str, global: &GlobalArgs) -> Result<ExitStatus> {
    refuse_options_of_coding(args, "rendering")?;
    let study = plan::grid(&RENDERING, &args.sweep)?;
    let fixed = fixed(&args.fixed, &study.axes)?;
    let probe = fixed.probe.map_or_else(|| most_central(Path::new(dataset)), Ok)?;
    let bench = RenderingBench { dataset: dataset.to_owned(), probe, frames: fixed.frames, fixed: fixed.words };
    measure_grid(args, study, bench, global)
}

/// Returns the probe nearest to the mean position of all; the first if several are equally near.
fn most_central(dataset: &Path) -> Result<String> {
    let manifest = Manifest::read(dataset)?;
    let position = |at: usize| DVec3::from_array(manifest.probes[at].first_pose(manifest.frame_range()).position);
    let middle = (0..manifest.probes.len()).map(position).sum::<DVec3>() / manifest.probes.len().max(1) as f64;
    let away = |at: &usize| position(*at).distance_squared(middle);
    let nearest = (0..manifest.probes.len()).min_by(|a, b| away(a).total_cmp(&away(b)));
    match nearest {
        Some(at) if manifest.probes.len() > 1 => Ok(manifest.probes[at].name.clone()),
        _ => Err(Error::Usage(format!(
            "{}: at least two probes were expected: one to exclude, and others from which to render it",
            dataset.display()
        ))),
    }
}

fn fixed(words: &[String], axes: &[Axis]) -> Result<Fixed> {
    // The reference is a placeholder, so that options which require one are accepted.
    let line = ["field.lfold", "--reference", "set", "--null"];
    let options = OptionsOf { command: "render", line: &line, own: OWN, also: None };
    let mut fixed = Fixed::default();
    for option in options.read(words, axes)? {
        match (option.name.as_str(), option.value()) {
            ("reference-probe", Some(probe)) if probe.contains(',') => {
                return refuse(format!("--reference-probe {probe}: one probe was expected"));
            }
            ("reference-probe", probe) => fixed.probe = probe,
            ("frames", frames) => fixed.frames = frames,
            _ => fixed.words.extend(option.words()),
        }
    }
    Ok(fixed)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::Cli;
    use crate::report::tradeoff::runner::CommandBench;
    use crate::tradeoff::fixed::parse;

    #[test]
    fn every_knob_is_an_option_of_render_and_takes_its_usual_values() {
        let mut root = Cli::command();
        root.build();
        let render = root.find_subcommand("render").unwrap();
        let bench = RenderingBench {
            dataset: "set".to_owned(),
            probe: "00".to_owned(),
            frames: Some("0-1".to_owned()),
            fixed: Vec::new(),
        };
        for knob in RENDERING.knobs {
            let option = render.get_arguments().find(|argument| argument.get_long() == Some(knob.name)).unwrap();
            if let [default] = option.get_default_values() {
                assert_eq!(default.to_str(), Some(knob.default), "{}", knob.name);
            }
            let study = plan::grid(&RENDERING, &[plan::Sweep::parse(knob.name).unwrap()]).unwrap();
            for point in study.points() {
                let line = bench.line(&point, Path::new("."));
                parse(&line).unwrap_or_else(|error| panic!("{line:?}: {error}"));
            }
        }
        for name in OWN {
            assert!(render.get_arguments().any(|argument| argument.get_long() == Some(name)), "--{name}");
        }
    }

    #[test]
    fn options_of_all_points_are_sorted_or_refused() {
        let of = |line: &str, swept: &'static str| {
            let words: Vec<String> = line.split(' ').filter(|word| !word.is_empty()).map(str::to_owned).collect();
            fixed(&words, &[Axis { knob: swept, values: vec!["1".to_owned()] }])
        };
        assert_eq!(of("", "steps").unwrap(), Fixed::default());
        let fixed = of("--frames 0-3 --reference-probe 02 --refine 4 --holes=nearest", "steps").unwrap();
        assert_eq!((fixed.frames.as_deref(), fixed.probe.as_deref()), (Some("0-3"), Some("02")));
        let mut words = fixed.words;
        words.sort_unstable();
        assert_eq!(words, ["--holes=nearest", "--refine=4"]);
        let said = |line: &str| of(line, "steps").unwrap_err().to_string();
        assert!(said("--steps 4").contains("swept"), "{}", said("--steps 4"));
        assert!(said("--stats").contains("itself"));
        assert!(said("--null").contains("itself") || said("--null").contains("cannot be used multiple times"));
        assert!(said("--reference-probe 01,02").contains("one probe"));
        assert!(said("--colour").contains("--colour"));
    }

    #[test]
    fn the_most_central_probe_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let write = |probes: &str| {
            let text = format!(
                r#"{{"lightfield": 1, "name": "a", "fps": 24, "frames": [0, 0], "projection": "cubemap", "size": [8, 8],
                    "files": {{"color": "{{probe}}/{{face}}.%04d.exr"}}, "probes": [{probes}]}}"#
            );
            std::fs::write(folder.path().join("lightfield.json"), text).unwrap();
            most_central(folder.path())
        };
        let probe = |name: &str, x: f64| format!(r#"{{"name": "{name}", "position": [{x}, 0, 0]}}"#);
        let three = [probe("a", -1.0), probe("b", 0.1), probe("c", 1.0)].join(",");
        assert_eq!(write(&three).unwrap(), "b");
        assert!(write(&probe("a", 0.0)).unwrap_err().to_string().contains("at least two probes"));
    }
}
