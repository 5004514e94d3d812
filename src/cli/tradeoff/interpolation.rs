//! Sweeps of view interpolation. The input is a scene.

use super::args::{Args, refuse_options_of_coding};
use super::fixed::{FixedSettings, OptionsOf};
use super::measure::measure_grid;
use crate::report::tradeoff::interpolation::{INTERPOLATION, InterpolationBench};
use crate::report::tradeoff::placement::PLACEMENT;
use crate::report::tradeoff::plan;
use crate::report::tradeoff::study::Axis;
use crate::{ExitStatus, GlobalArgs};
use codec::error::Result;

/// Options of `interpolate` that are set by tradeoff.
const OWN: &[&str] = &["output", "null", "json", "quiet", "compare", "csv", "brute-force"];

/// True if a swept knob belongs to interpolation and not to placement.
pub fn is_swept(args: &Args) -> bool {
    let names = args.sweep.iter().map(|sweep| sweep.knob.name);
    names.into_iter().any(|name| INTERPOLATION.knob(name).is_some() && PLACEMENT.knob(name).is_none())
}

pub fn measure(args: &Args, scene: &str, global: &GlobalArgs) -> Result<ExitStatus> {
    refuse_options_of_coding(args, "interpolating views of a scene")?;
    let mut study = plan::grid(&INTERPOLATION, &args.sweep)?;
    let fixed = fixed(scene, &args.fixed, &study.axes)?;
    study.fixed = fixed.knobs;
    measure_grid(args, study, InterpolationBench { scene: scene.to_owned(), fixed: fixed.words }, global)
}

fn fixed(scene: &str, words: &[String], axes: &[Axis]) -> Result<FixedSettings> {
    let mut line = vec![scene, "--null"];
    // Options that are required, but swept.
    for (knob, option, value) in [("views", "--views", "2"), ("baseline", "--baseline", "1")] {
        if axes.iter().any(|axis| axis.knob == knob) {
            line.extend([option, value]);
        }
    }
    let options = OptionsOf { command: "interpolate", line: &line, own: OWN, also: None };
    Ok(FixedSettings::new(&INTERPOLATION, axes, &options.read(words, axes)?))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::CommandFactory;

    use super::*;
    use crate::Cli;
    use crate::report::tradeoff::runner::CommandBench;
    use crate::tradeoff::fixed::parse;

    #[test]
    fn every_knob_is_an_option_of_interpolate_and_takes_its_usual_values() {
        let mut root = Cli::command();
        root.build();
        let interpolate = root.find_subcommand("interpolate").unwrap();
        let given = ["--eye=0,1,0", "--look-at=1,1,0"].map(str::to_owned);
        for knob in INTERPOLATION.knobs {
            let option = interpolate.get_arguments().find(|argument| argument.get_long() == Some(knob.name)).unwrap();
            if let [default] = option.get_default_values() {
                assert_eq!(default.to_str(), Some(knob.default), "{}", knob.name);
            }
            let mut fixed = given.to_vec();
            for (name, word) in [("views", "--views=4"), ("baseline", "--baseline=1")] {
                if knob.name != name {
                    fixed.push(word.to_owned());
                }
            }
            let bench = InterpolationBench { scene: "a.glb".to_owned(), fixed };
            let study = plan::grid(&INTERPOLATION, &[plan::Sweep::parse(knob.name).unwrap()]).unwrap();
            for point in study.points() {
                let line = bench.line(&point, Path::new("."));
                parse(&line).unwrap_or_else(|error| panic!("{line:?}: {error}"));
            }
        }
        for name in OWN {
            assert!(interpolate.get_arguments().any(|argument| argument.get_long() == Some(name)), "--{name}");
        }
    }

    #[test]
    fn options_of_all_points_are_taken_or_refused() {
        let of = |line: &str, swept: &'static str| {
            let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
            fixed("a.glb", &words, &[Axis { knob: swept, values: vec!["2".to_owned()] }])
        };
        let mut found = of("--eye=0,1,0 --look-at 1,1,0 --baseline 0.5 --size 48x27", "views").unwrap();
        found.words.sort_unstable();
        assert_eq!(found.words, ["--eye=0,1,0", "--look-at=1,1,0", "--size=48x27"]);
        assert_eq!(found.knobs, [("baseline", "0.5".to_owned())]);
        let hierarchical = of("--eye=0,1,0 --look-at 1,1,0 --views 4 --baseline 0.5", "stop").unwrap();
        assert!(hierarchical.knobs.contains(&("acquire", "hierarchical".to_owned())), "{hierarchical:?}");
        let all = "--eye=0,1,0 --look-at 1,1,0 --views 4 --baseline 0.5";
        let said = |line: &str| of(line, "layers").unwrap_err().to_string();
        assert!(said(&format!("{all} --layers 3")).contains("swept"));
        assert!(said(&format!("{all} --json")).contains("itself"));
    }
}
