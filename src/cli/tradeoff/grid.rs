//! Sweeps whose points are a command each: of placement, rendering, simplification and interpolation.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use serde_json::{Map, json};

use super::args::{Args, refuse_options_of_coding};
use super::fixed::{implied, parse, read};
use super::measure::Sweeping;
use crate::report::tradeoff::findings;
use crate::report::tradeoff::kind::SweepKind;
use crate::report::tradeoff::page::Extras;
use crate::report::tradeoff::plan;
use crate::report::tradeoff::point::Setting;
use crate::report::tradeoff::runner::CommandBench;
use crate::report::tradeoff::study::Axis;
use crate::{ExitStatus, GlobalArgs, refuse};
use codec::error::{Error, Result};
use footage::dataset::manifest::Manifest;

/// Option of `render` that names the probe to leave out.
const PROBE: &str = "reference-probe";

/// Measures a grid. Earlier results are not reused.
pub fn measure(args: &Args, kind: &'static SweepKind, input: &str, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    refuse_options_of_coding(args, kind.doing_what)?;
    let mut study = plan::grid(kind, &args.sweep)?;
    let mut fixed = Fixed::new(kind, input, &args.fixed, &study.axes)?;
    study.fixed = fixed.knobs;
    if let Some(probe) = fixed.variables.get_mut(PROBE).filter(|probe| probe.is_empty()) {
        probe.push(most_central(Path::new(input))?);
    }
    let mut bench = CommandBench { kind, work: ".".into(), variables: fixed.variables };
    let points = study.points();
    let lines = bench.preparation(&bench.work).into_iter();
    let lines = lines.chain(points.iter().map(|point| bench.point_line(point, &bench.work)));
    lines.into_iter().try_for_each(|line| parse(&line).map(drop))?;
    let mut sweeping = Sweeping::open(args, &study, 0, global)?;
    (sweeping.results.about, sweeping.results.commands) = (bench.about(), bench.examples(&points));
    let more = kind.reported.iter().map(|(key, name)| ((*key).to_owned(), json!(bench.variables[name].first())));
    let more: Map<_, _> = more.collect();
    sweeping.measure(&[study], start, |work| {
        bench.work = work.to_path_buf();
        bench
    })?;
    let extras = Extras { findings: findings::judge(&sweeping.results, None), figures: Vec::new() };
    sweeping.tell(&extras, more, "")?;
    Ok(ExitStatus::Passed)
}

/// Options after `--`, and those that swept knobs require.
#[derive(Debug, Default, PartialEq)]
struct Fixed {
    knobs: Vec<Setting>,
    variables: BTreeMap<&'static str, Vec<String>>,
}

impl Fixed {
    fn new(kind: &'static SweepKind, input: &str, words: &[String], axes: &[Axis]) -> Result<Fixed> {
        let mut line: Vec<String> = kind.line.split(' ').map(|word| word.replace("{input}", input)).collect();
        // Options that are required, but swept.
        let swept = kind.knobs.iter().filter(|knob| axes.iter().any(|axis| axis.knob == knob.name));
        let required =
            swept.filter_map(|knob| knob.required.map(|value| [format!("--{}", knob.name), value.to_owned()]));
        line.extend(required.flatten());
        let line: Vec<&str> = line.iter().map(String::as_str).collect();
        let options = read(kind.command, words, axes, (&line, &kind.own), None)?;
        let implied = implied(kind, axes, &options);
        let names = kind.reported.iter().map(|(_, name)| *name).chain(["fixed", "kept"]);
        let mut variables: BTreeMap<_, _> = names.map(|name| (name, Vec::new())).collect();
        variables.insert("input", vec![input.to_owned()]);
        let mut fixed = Fixed { knobs: Vec::new(), variables };
        if kind.fixes_knobs {
            fixed.knobs.clone_from(&implied);
        }
        for option in &options {
            let (name, value) = (option.name.as_str(), option.value());
            if name == PROBE && value.as_ref().is_some_and(|probe| probe.contains(',')) {
                return refuse(format!("--{PROBE} {}: one probe was expected", value.unwrap_or_default()));
            }
            if let Some(words) = fixed.variables.get_mut(name) {
                words.extend(value);
            } else if let (Some(knob), Some(value)) = (kind.knob(name).filter(|_| kind.fixes_knobs), value) {
                fixed.knobs.push((knob.name, value));
            } else {
                fixed.add(option.words(), kind.search.contains(&name));
            }
        }
        if !kind.fixes_knobs {
            let words = implied.iter().map(|(name, value)| format!("--{name}={value}"));
            fixed.add(words.collect(), false);
        }
        Ok(fixed)
    }

    /// Adds words to all commands, or to all except comparisons if they belong to a search.
    fn add(&mut self, words: Vec<String>, is_of_search: bool) {
        for name in ["fixed", "kept"].iter().filter(|name| **name == "fixed" || !is_of_search) {
            self.variables.entry(name).or_default().extend(words.iter().cloned());
        }
    }
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

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::Cli;
    use crate::report::tradeoff::kind::{INTERPOLATION, PLACEMENT, RENDERING, SIMPLIFICATION};

    fn of(kind: &'static SweepKind, line: &str, swept: &'static str) -> Result<Fixed> {
        let words: Vec<String> = line.split(' ').filter(|word| !word.is_empty()).map(str::to_owned).collect();
        Fixed::new(kind, "cornell", &words, &[Axis { knob: swept, values: vec!["1".to_owned()] }])
    }

    fn sorted(fixed: &Fixed, name: &str) -> Vec<String> {
        let mut words = fixed.variables[name].clone();
        words.sort_unstable();
        words
    }

    #[test]
    fn every_knob_is_an_option_of_its_command_and_takes_its_usual_values() {
        let mut root = Cli::command();
        root.build();
        let fixed = |kind: &SweepKind, knob: &str| match kind.command {
            "place" => vec!["--region=0,0,0,1,1,1"],
            "interpolate" => {
                let required = [("views", "--views=4"), ("baseline", "--baseline=1")];
                let required = required.into_iter().filter(|(name, _)| *name != knob).map(|(_, word)| word);
                ["--eye=0,1,0", "--look-at=1,1,0"].into_iter().chain(required).collect()
            }
            _ => Vec::new(),
        };
        for kind in [&PLACEMENT, &RENDERING, &SIMPLIFICATION, &INTERPOLATION] {
            let command = root.find_subcommand(kind.command).unwrap();
            let find = |name: &str| command.get_arguments().find(|argument| argument.get_long() == Some(name));
            for knob in &kind.knobs {
                if let [default] = find(knob.name).unwrap().get_default_values() {
                    assert_eq!(default.to_str(), Some(knob.default), "{}", knob.name);
                }
                let implied = knob.implies.iter().map(|(name, value)| format!("--{name}={value}"));
                let words: Vec<String> = fixed(kind, knob.name).into_iter().map(str::to_owned).chain(implied).collect();
                let study = plan::grid(kind, &[plan::Sweep::parse(knob.name).unwrap()]).unwrap();
                let mut variables = BTreeMap::from([("input", vec!["cornell".to_owned()]), ("fixed", words)]);
                variables.extend([(PROBE, vec!["00".to_owned()]), ("frames", vec!["0-1".to_owned()])]);
                let bench = CommandBench { kind, work: ".".into(), variables };
                for point in study.points() {
                    let line = bench.point_line(&point, Path::new("."));
                    parse(&line).unwrap_or_else(|error| panic!("{line:?}: {error}"));
                }
            }
            for name in kind.own.iter().chain(&kind.search) {
                assert!(find(name).is_some(), "{} --{name}", kind.command);
            }
            assert!(kind.own.iter().all(|name| !kind.search.contains(name)));
        }
    }

    #[test]
    fn options_of_a_search_do_not_judge_it() {
        let of = |line: &str, swept: &'static str| of(&PLACEMENT, line, swept);
        let two = "--region -1,-1,-1,1,1,1 --region=2,2,2,3,3,3 --cameras 4";
        let found = of(two, "effort").unwrap().variables;
        assert_eq!(found["kept"], ["--region=-1,-1,-1,1,1,1", "--region=2,2,2,3,3,3"]);
        assert!(found["fixed"].len() == 3 && found["fixed"].contains(&"--cameras=4".to_owned()), "{found:?}");
        let many = "--region=0,0,0,1,1,1 --k 2 --lighting specular --theta 20 --fps 30 --frames 0-3 --min-distance 1 \
                    --candidates 9 --surface-samples 99 --grid --until 0.1 --threads 2";
        let of_scene = sorted(&of(many, "effort").unwrap(), "kept");
        let names: Vec<&str> = of_scene.iter().filter_map(|word| word.split('=').next()).collect();
        assert_eq!(names, ["--fps", "--frames", "--k", "--lighting", "--min-distance", "--region", "--theta"]);
        assert!(of("--region 0,0,0,1,1,1 --cameras 4", "cameras").unwrap_err().to_string().contains("swept"));
        let implied =
            |line: &str| of(line, "theta").unwrap().variables["kept"].contains(&"--lighting=specular".to_owned());
        assert!(implied(two) && !implied("--region 0,0,0,1,1,1 --lighting diffuse"));
        assert!(of("--region 0,0,0,1,1,1 --json", "k").unwrap_err().to_string().contains("itself"));
    }

    #[test]
    fn options_of_render_are_sorted_or_refused() {
        let none = of(&RENDERING, "", "steps").unwrap();
        assert!(none.knobs.is_empty());
        assert!(none.variables.iter().all(|(name, words)| words.is_empty() != (*name == "input")), "{none:?}");
        let fixed = of(&RENDERING, "--frames 0-3 --reference-probe 02 --refine 4 --holes=nearest", "steps").unwrap();
        assert_eq!(
            (&*fixed.variables["frames"], &*fixed.variables[PROBE]),
            (&["0-3".to_owned()][..], &["02".to_owned()][..])
        );
        assert_eq!(sorted(&fixed, "fixed"), ["--holes=nearest", "--refine=4"]);
        let said = |line: &str| of(&RENDERING, line, "steps").unwrap_err().to_string();
        assert!(said("--steps 4").contains("swept"), "{}", said("--steps 4"));
        assert!(said("--stats").contains("itself"));
        assert!(said("--null").contains("itself") || said("--null").contains("cannot be used multiple times"));
        assert!(said("--reference-probe 01,02").contains("one probe"));
        assert!(said("--colour").contains("--colour"));
    }

    #[test]
    fn knobs_of_simplify_and_interpolate_are_settings() {
        let fixed = of(&SIMPLIFICATION, "--frames 3 --region=0,0,0,1,1,1 --effort fast", "area").unwrap();
        assert_eq!(sorted(&fixed, "fixed"), ["--frames=3", "--region=0,0,0,1,1,1"]);
        assert_eq!(fixed.knobs, [("effort", "fast".to_owned())]);
        let said = |line: &str| of(&SIMPLIFICATION, line, "area").unwrap_err().to_string();
        assert!(said("--area 3").contains("swept") && said("--json").contains("itself"));

        let found = of(&INTERPOLATION, "--eye=0,1,0 --look-at 1,1,0 --baseline 0.5 --size 48x27", "views").unwrap();
        assert_eq!(sorted(&found, "fixed"), ["--eye=0,1,0", "--look-at=1,1,0", "--size=48x27"]);
        assert_eq!(found.knobs, [("baseline", "0.5".to_owned())]);
        let all = "--eye=0,1,0 --look-at 1,1,0 --views 4 --baseline 0.5";
        let hierarchical = of(&INTERPOLATION, all, "stop").unwrap();
        assert!(hierarchical.knobs.contains(&("acquire", "hierarchical".to_owned())), "{hierarchical:?}");
        let said = |line: &str| of(&INTERPOLATION, line, "layers").unwrap_err().to_string();
        assert!(said(&format!("{all} --layers 3")).contains("swept"));
        assert!(said(&format!("{all} --json")).contains("itself"));
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
