//! Sweeps of the options of `render` over a dataset, of which one probe is left out.

use std::path::Path;
use std::time::Instant;

use clap::CommandFactory;
use clap::parser::ValueSource;
use glam::DVec3;

use super::grid::{Grid, Told};
use super::{Args, grid, input};
use crate::cli::{Cli, ExitStatus, GlobalArgs};
use crate::dataset::manifest::Manifest;
use crate::error::{Error, Result};
use crate::report::tradeoff::Axis;
use crate::report::tradeoff::knob::Stage;
use crate::report::tradeoff::rendering::{self, Sweep};

/// Options of `render` that tradeoff gives itself.
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

/// Whether rendering is to be measured: a knob is swept that only `render` has.
pub fn is_asked(args: &Args) -> bool {
    args.sweep.iter().any(|sweep| sweep.knob.stage == Stage::Render)
}

/// Options of `render` that all points have.
#[derive(Debug, Default, PartialEq)]
struct Fixed {
    words: Vec<String>,
    /// `--reference-probe` and `--frames`, which are given to other commands as well.
    probe: Option<String>,
    frames: Option<String>,
}

/// Measures what rendering costs.
pub fn measure(args: &Args, dataset: &str, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    grid::refuse_others(args, "rendering")?;
    let axes = axes(args)?;
    let fixed = options_of_all(&args.fixed, &axes)?;
    let probe = match &fixed.probe {
        Some(probe) => probe.clone(),
        None => most_central(Path::new(dataset))?,
    };
    let sweep = Sweep {
        dataset,
        probe: &probe,
        frames: fixed.frames.as_deref(),
        fixed: &fixed.words,
        axes: &axes,
        repeats: args.repeats,
    };
    let container = Path::new("field.lfold");
    input::parse(&sweep.encode(container))?;
    for settings in sweep.points() {
        input::parse(&sweep.command(container, &settings))?;
    }
    let grid = Grid {
        args,
        global,
        start,
        what: "rendering",
        runs: sweep.runs(),
        points: sweep.points().len(),
        files: rendering::files(&args.output),
    };
    let (folder, shown) = grid.measure(
        |runner, work, progress, keep| sweep.measure(runner, work, progress, keep),
        |shown| rendering::to_csv(&axes, shown),
    )?;
    let (about, commands) = (rendering::about(&sweep), rendering::commands(&sweep));
    let told = Told {
        title: format!("What rendering costs: {dataset}"),
        input: ("Dataset", dataset),
        about: &about,
        table: &rendering::table(&axes, &shown),
        figures: &rendering::figures(&sweep, &shown),
        commands: &commands,
        report: &rendering::json(&sweep, &shown),
    };
    grid.tell(&told, folder)?;
    Ok(ExitStatus::Passed)
}

fn axes(args: &Args) -> Result<Vec<Axis>> {
    let mut axes: Vec<Axis> = Vec::new();
    for sweep in &args.sweep {
        // Threads and device are knobs of coding, too.
        let knob = rendering::find(sweep.knob.name).ok_or_else(|| {
            let names: Vec<&str> = rendering::KNOBS.iter().map(|knob| knob.name).collect();
            let name = sweep.knob.name;
            Error::Usage(format!(
                "--sweep {name}: it is no option of rendering, which has {}; sweep it on its own",
                names.join(", ")
            ))
        })?;
        if axes.iter().any(|axis| axis.knob == knob.name) {
            return Err(Error::Usage(format!("--sweep {}: swept twice; name all values at once", knob.name)));
        }
        axes.push(Axis { knob: knob.name, values: sweep.values.clone() });
    }
    Ok(axes)
}

/// The probe that is nearest to the middle of all, the first of several.
fn most_central(dataset: &Path) -> Result<String> {
    let manifest = Manifest::read(dataset)?;
    let position = |at: usize| DVec3::from_array(manifest.probes[at].position);
    let middle = (0..manifest.probes.len()).map(position).sum::<DVec3>() / manifest.probes.len().max(1) as f64;
    let away = |at: &usize| position(*at).distance_squared(middle);
    let nearest = (0..manifest.probes.len()).min_by(|a, b| away(a).total_cmp(&away(b)));
    match nearest {
        Some(at) if manifest.probes.len() > 1 => Ok(manifest.probes[at].name.clone()),
        _ => Err(Error::Usage(format!(
            "{}: one probe to leave out and others to render it from were expected",
            dataset.display()
        ))),
    }
}

/// The options that all points have, one word each.
fn options_of_all(words: &[String], axes: &[Axis]) -> Result<Fixed> {
    let mut root = Cli::command();
    root.build();
    // The reference stands for that of the points, so that options which need one are taken.
    let line = ["lightfold", "render", "field.lfold", "--reference", "set", "--null"].map(str::to_owned);
    let matches =
        root.clone().try_get_matches_from(line.iter().chain(words)).map_err(|error| input::refused(&error))?;
    let mut fixed = Fixed::default();
    let (Some((_, matches)), Some(render)) = (matches.subcommand(), root.find_subcommand("render")) else {
        return Ok(fixed);
    };
    let is_said = |name: &str| words.iter().any(|word| word.split('=').next() == Some(&format!("--{name}")));
    for argument in render.get_arguments() {
        let (id, Some(name)) = (argument.get_id().as_str(), argument.get_long()) else { continue };
        let given = matches!(matches.try_contains_id(id), Ok(true))
            && matches.value_source(id) == Some(ValueSource::CommandLine);
        if !given || (matches!(name, "reference" | "null") && !is_said(name)) {
            continue;
        }
        if OWN.contains(&name) {
            return Err(Error::Usage(format!("--{name} after --: tradeoff gives it to its points itself")));
        }
        if axes.iter().any(|axis| axis.knob == name) {
            return Err(Error::Usage(format!("--{name}: it is swept, so that it cannot be fixed as well")));
        }
        let values = matches.get_raw(id).filter(|_| argument.get_action().takes_values());
        let value = values.map(|values| values.map(|v| v.to_string_lossy().into_owned()).collect::<Vec<_>>().join(","));
        match (name, value) {
            ("reference-probe", Some(probe)) if probe.contains(',') => {
                return Err(Error::Usage(format!("--reference-probe {probe}: one probe is left out; name one")));
            }
            ("reference-probe", probe) => fixed.probe = probe,
            ("frames", frames) => fixed.frames = frames,
            (name, Some(value)) => fixed.words.push(format!("--{name}={value}")),
            (name, None) => fixed.words.push(format!("--{name}")),
        }
    }
    Ok(fixed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_knob_is_an_option_of_render_and_takes_its_usual_values() {
        let mut root = Cli::command();
        root.build();
        let render = root.find_subcommand("render").unwrap();
        for knob in rendering::KNOBS {
            let option = render.get_arguments().find(|argument| argument.get_long() == Some(knob.name)).unwrap();
            if let [default] = option.get_default_values() {
                assert_eq!(default.to_str(), Some(knob.default), "{}", knob.name);
            }
            let axes = [Axis { knob: knob.name, values: knob.usual.iter().map(ToString::to_string).collect() }];
            let sweep = Sweep { dataset: "set", probe: "00", frames: Some("0-1"), fixed: &[], axes: &axes, repeats: 1 };
            for settings in sweep.points() {
                let line = sweep.command(Path::new("a.lfold"), &settings);
                input::parse(&line).unwrap_or_else(|error| panic!("{line:?}: {error}"));
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
            options_of_all(&words, &[Axis { knob: swept, values: vec!["1".to_owned()] }])
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
        assert!(said("--reference-probe 01,02").contains("name one"));
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
        assert!(write(&probe("a", 0.0)).unwrap_err().to_string().contains("others to render"));
    }
}
